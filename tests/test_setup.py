"""How `make env` makes .venv, on machines with other Pythons, with uv and without."""

import os
import re
import shutil
import subprocess
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
LOCK = (ROOT / "requirements.txt").read_text(encoding="utf-8")
PINS = re.findall(r"^(\S+)==\S+((?: \\\n    --hash=sha256:[0-9a-f]{64})*)$", LOCK, re.M)

TOOLS = ("bash", "grep", "make", "mkdir", "cp", "rm", "tail", "tee", "touch")

# Stand-ins write down what they are asked to do, by the name they are called by.
PYTHON = """#!{bash}
if [[ $1 == -c ]]; then {version}; fi
echo "${{0##*/}} $*" >>"$CALLS"
if [[ $* == "-m venv"* ]]; then
    mkdir -p .venv/bin
    cp "$0" .venv/bin/python
elif [[ $* == *"$FAILS"* ]]; then
    echo "Collecting numpy"
    echo "there is no numpy"
    exit 1
elif [[ $* == *"-r requirements.txt" ]]; then
    while read -r line; do
        [[ $line != *==* ]] || echo "Collecting $line"
    done <requirements.txt
    echo "Installing collected packages"
fi
"""
UV = """#!{bash}
echo "uv $*" >>"$CALLS"
if [[ $* == *"$FAILS"* || ($1 == venv && -e .venv && $UV_VENV_CLEAR != 1) ]]; then
    echo "error: no such thing" >&2
    exit 2
fi
[[ $1 != venv ]] || mkdir .venv 2>/dev/null || true
"""
BY_UV = [
    "uv venv --python 3.11 .venv",
    "uv pip install --python .venv/bin/python --require-hashes -r requirements.txt",
    "uv pip install --python .venv/bin/python --no-deps --no-build-isolation "
    "--editable .",
]
BY_PIP = [
    "python3.11 -m venv --clear .venv",
    "python -m pip install --require-hashes --no-deps --no-compile -r requirements.txt",
    "python -m pip install --quiet --no-deps --no-build-isolation --editable .",
]


class Machine:
    """A clone, and a PATH with a few tools, stand-ins and nothing else."""

    def __init__(self, folder):
        self.clone = folder / "a clone 'b' \"c\" $d"
        self.programs = folder / "programs"
        self.calls = folder / "calls"
        self.programs.mkdir()
        self.clone.mkdir()
        shutil.copy(ROOT / "Makefile", self.clone)
        shutil.copy(ROOT / "requirements.txt", self.clone)
        for name in TOOLS:
            (self.programs / name).symlink_to(shutil.which(name))

    def add(self, text, path, **told):
        path = self.programs / path
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.format(bash=shutil.which("bash"), **told), "utf-8")
        path.chmod(0o755)
        return path

    def add_python(self, path, version):
        version = f"echo {version}; exit" if version else "exit 127"
        return self.add(PYTHON, path, version=version)

    def make(self, *arguments, fails="nothing"):
        self.calls.write_text("", "utf-8")
        given = {"PATH": str(self.programs), "CALLS": str(self.calls), "FAILS": fails}
        done = subprocess.run(
            [shutil.which("make"), "env", *arguments],
            cwd=self.clone,
            env=given | {"LC_ALL": "C"},
            capture_output=True,
            text=True,
            check=False,
        )
        done.calls = self.calls.read_text("utf-8").splitlines()
        return done

    @property
    def is_done(self):
        return (self.clone / ".venv" / "installed").exists()

    @property
    def has_begun(self):
        return (self.clone / ".venv").exists()


@pytest.fixture
def machine(tmp_path):
    if any(shutil.which(name) is None for name in TOOLS):
        pytest.skip(f"needs {', '.join(TOOLS)}")
    return Machine(tmp_path)


@pytest.mark.parametrize("version", ["3.13", "3.9", None])
def test_another_python_and_no_uv_is_one_sentence(machine, version):
    if version:
        machine.add_python("python3", version)
    done = machine.make()
    assert done.returncode != 0
    [sentence] = done.stderr.splitlines()
    assert f"needs Python 3.11, the newest that PyBullet supports, but python3 is " \
        f"{version or 'missing'}: install uv, which brings it, or install Python 3.11" \
        in sentence  # fmt: skip
    assert (done.stdout, done.calls) == ("", [])
    assert not machine.has_begun


def test_uv_brings_python(machine):
    machine.add_python("python3", "3.13")
    machine.add(UV, "uv")
    done = machine.make()
    assert (done.returncode, done.stderr) == (0, "")
    assert done.calls == BY_UV
    assert machine.is_done
    assert machine.make().calls == []
    os.utime(machine.clone / ".venv" / "installed", (0, 0))  # the lock is newer now
    again = machine.make()
    assert (again.returncode, again.calls) == (0, BY_UV)


def test_without_uv_pip_is_asked_on_demand(machine):
    machine.add_python("python3.11", "3.11")
    machine.add(UV, "uv")
    assert machine.make("UV=").calls == BY_PIP


def test_uv_that_cannot_fetch_python_is_one_sentence(machine):
    machine.add_python("python3", "3.13")
    machine.add(UV, "uv")
    done = machine.make(fails="venv")
    assert done.returncode != 0
    reason, sentence, _ = done.stderr.splitlines()  # the last is make's own
    assert reason == "error: no such thing"
    assert sentence == (
        "uv brought no Python 3.11: install Python 3.11, or name it with "
        "make PYTHON=/path/to/python3.11."
    )
    assert done.calls == BY_UV[:1]
    assert not machine.has_begun


@pytest.mark.parametrize("failing", [1, 2])
def test_an_install_that_fails_is_not_taken_for_done(machine, failing):
    machine.add(UV, "uv")
    done = machine.make(fails=BY_UV[failing].removeprefix("uv "))
    assert done.returncode != 0
    assert "no such thing" in done.stderr
    assert done.calls == BY_UV[: failing + 1]
    assert not machine.is_done
    (machine.programs / "uv").unlink()
    machine.add_python("python3.11", "3.11")
    done = machine.make(fails=BY_PIP[failing].removeprefix("python "))
    assert done.returncode != 0
    assert "there is no numpy" in done.stderr + done.stdout
    assert done.calls == BY_PIP[: failing + 1]
    assert not machine.is_done
    assert machine.make().calls == BY_PIP
    assert machine.is_done


@pytest.mark.parametrize("broken", [True, False])
def test_pip_takes_python_from_the_path(machine, broken):
    machine.add_python("python3", "3.11" if broken else "3.13")
    machine.add_python("python3.11", None if broken else "3.11")  # as a pyenv shim is
    done = machine.make()
    assert (done.returncode, done.stderr) == (0, "")
    name = "python3" if broken else "python3.11"
    assert done.calls == [f"{name} -m venv --clear .venv", *BY_PIP[1:]]
    assert machine.is_done


@pytest.mark.parametrize("has_uv", [True, False])
def test_a_python_that_is_named_is_used(machine, has_uv):
    machine.add_python("python3.11", "3.11")
    mine = machine.add_python('it\'s "my" own/python', "3.11")
    old = machine.add_python('it\'s "my" own/old', "3.9")
    if has_uv:
        machine.add(UV, "uv")
    done = machine.make(f"PYTHON={old}")
    assert (done.returncode != 0, done.calls) == (True, [])
    assert (
        f"but {old} is 3.9: {'leave it to' if has_uv else 'install'} uv" in done.stderr
    )
    assert not machine.has_begun
    done = machine.make(f"PYTHON={mine}")
    assert (done.returncode, done.stderr) == (0, "")
    by_uv = [f"uv venv --python {mine} .venv", *BY_UV[1:]]
    assert done.calls == (
        by_uv if has_uv else ["python -m venv --clear .venv", *BY_PIP[1:]]
    )


def test_pip_s_progress_counts_the_packages_of_the_lock(machine):
    machine.add_python("python3.11", "3.11")
    lines = machine.make().stdout.splitlines()[1:]
    total = len(PINS)
    counts = [f"  found {n} of {total} packages" for n in range(30, total + 1, 30)]
    assert lines == [*counts, f"  installing {total} packages"]


# The lock


def test_every_package_of_the_lock_has_hashes():
    assert PINS
    assert len(PINS) == len(re.findall(r"^[^\s#]", LOCK, re.M))
    assert [name for name, hashes in PINS if not hashes] == []


LINUX = {"sys_platform": "linux", "platform_system": "Linux"}
MAC = {"sys_platform": "darwin", "platform_system": "Darwin"}


@pytest.mark.parametrize(
    "machine",
    [
        {**LINUX, "platform_machine": "x86_64", "python_full_version": "3.11.2"},
        {**LINUX, "platform_machine": "aarch64", "python_full_version": "3.11.14"},
        {**MAC, "platform_machine": "arm64", "python_full_version": "3.11.9"},
    ],
    ids=lambda machine: " ".join(machine.values()),
)
def test_the_lock_is_whole_on_other_machines(machine):
    # With hashes, pip and uv refuse what a package needs and the lock lacks.
    locked = {name for name, _ in PINS}
    missing = set()
    for name in locked - {"pip"}:
        for text in metadata.requires(name) or ():
            needed = Requirement(text)
            marker = needed.marker
            if marker is None or marker.evaluate({"extra": "", **machine}):
                missing |= {canonicalize_name(needed.name)} - locked
    assert missing == set()
