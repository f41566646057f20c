"""What a reader has set does not reach the processes that make the book.

And what a run depended on is known.
"""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import asdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from press import _chapters
from press._chapters import Record, read_log, read_record
from press._processes import chosen, environment

# What the machine may need, and so is handed on.
KEPT = ("PATH", "LD_LIBRARY_PATH", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")
READERS = (
    "HOME",
    "LANG",
    "LC_ALL",
    "MATPLOTLIBRC",
    "MPLBACKEND",
    "MPLCONFIGDIR",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "IPYTHONDIR",
    "JUPYTER_CONFIG_DIR",
    "JUPYTER_PATH",
    "PYTHONOPTIMIZE",
    "PYTHONPATH",
    "PYTHONSTARTUP",
    "PYTHONWARNINGS",
    "SOURCE_DATE_EPOCH",
    "TZ",
    "XDG_CACHE_HOME",
    "XDG_CONFIG_HOME",
)
# Neither NUL nor "=" nor a half of a pair of code points can be in the environment.
WORDS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]))
NAMES = st.sampled_from(READERS) | st.from_regex(r"[A-Z][A-Z_]{0,12}", fullmatch=True)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """Return a folder that has a home already."""
    folder = tmp_path_factory.mktemp("a cache")
    environment(folder)
    return folder


def machine():
    """Return what the machine has set."""
    return {name: os.environ[name] for name in KEPT if name in os.environ}


@settings(max_examples=9)
@given(st.dictionaries(NAMES, WORDS))
def test_every_variable_is_the_machine_s_or_chosen(cache, theirs):
    plain = environment(cache)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in theirs.items():
            if name not in KEPT:
                patch.setenv(name, value)
        assert environment(cache) == plain
    with pytest.MonkeyPatch.context() as patch:
        for name in set(os.environ) - set(KEPT):
            patch.delenv(name)
        assert environment(cache) == plain


def test_what_the_machine_needs_is_handed_on(cache, monkeypatch):
    for name in KEPT:
        monkeypatch.setenv(name, f"as {name}")
    given = environment(cache)
    assert {name: given[name] for name in KEPT} == machine()
    switches = {name for name in KEPT if name.startswith("OPENBLAS")}
    assert switches <= set(chosen())  # they change how numbers are computed


STATE = """
import json, locale, os, sys, time, warnings
import matplotlib, numpy
from matplotlib import font_manager
from threadpoolctl import threadpool_info
print(json.dumps({
    "backend": matplotlib.get_backend(),
    "warnings": len(warnings.filters),
    "encoding": [locale.getencoding(), sys.stdout.encoding, sys.flags.utf8_mode],
    "optimize": sys.flags.optimize,
    "zone": time.tzname,
    "threads": [one["num_threads"] for one in threadpool_info()],
    "hash": hash("msc"),
    "settings": matplotlib.get_configdir(),
    "figure": matplotlib.rcParams["figure.figsize"],
}))
"""


def test_a_process_is_the_same_whatever_is_set_and_says_nothing(cache, monkeypatch):
    def state():
        ran = subprocess.run(
            [sys.executable, "-c", STATE],
            env=environment(cache),
            cwd=cache,
            capture_output=True,
            check=True,
        )
        assert not ran.stderr
        return json.loads(ran.stdout)

    plain = state()
    assert plain["backend"] == "module://matplotlib_inline.backend_inline"
    assert plain["encoding"] == ["UTF-8", "utf-8", 1]
    assert set(plain["threads"]) == {1}
    settings_file = cache / "mine"
    settings_file.write_text("figure.figsize: 1, 1\nbackend: pdf\n", "utf-8")
    theirs = {
        "MPLBACKEND": "nonsense",
        "MATPLOTLIBRC": str(settings_file),
        "MPLCONFIGDIR": str(settings_file),
        "HOME": "/proc/1/root/nowhere",
        "LC_ALL": "POSIX",
        "PYTHONUTF8": "0",
        "PYTHONCOERCECLOCALE": "0",
        "PYTHONWARNINGS": "error",
        "PYTHONOPTIMIZE": "2",
        "TZ": "Asia/Kolkata",
        "OMP_NUM_THREADS": "7",
        "OPENBLAS_NUM_THREADS": "7",
    }
    for name, value in theirs.items():
        monkeypatch.setenv(name, value)
    assert state() == plain


def test_without_a_folder_for_temporary_files_the_home_is_one(cache, monkeypatch):
    def none():
        raise FileNotFoundError("No usable temporary directory found")

    monkeypatch.setattr(tempfile, "gettempdir", none)
    given = environment(cache)
    assert given["TMPDIR"] == given["HOME"]


def test_fonts_are_listed_once(tmp_path):
    """The list is there before anything else could make it, and is not made again."""
    [fonts] = (tmp_path / "home").glob("*/fontlist*") if environment(tmp_path) else []
    before = fonts.stat().st_mtime_ns
    environment(tmp_path)
    assert fonts.stat().st_mtime_ns == before


# What a run depended on


def test_how_the_package_is_installed_is_no_input(tmp_path):
    log, digest = tmp_path / "log", "0" * 64
    read = ["data/free.csv", "msc.egg-info/entry_points.txt"]
    lines = [{"file": str(tmp_path / name), "sha256": digest} for name in read]
    log.write_text("\n".join(map(json.dumps, lines)), "utf-8")
    assert read_log(log, tmp_path)[0] == {"data/free.csv": digest}


def test_a_run_in_another_environment_holds_no_longer(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Haswell")
    kept = Record("code", {}, {}, chosen(), seconds=1.0)
    assert read_record(json.loads(json.dumps(asdict(kept)))) == kept
    assert kept.changes("code", tmp_path) == []
    monkeypatch.delenv("OPENBLAS_CORETYPE")
    monkeypatch.setattr(
        _chapters, "chosen", lambda: chosen() | {"MPLBACKEND": "agg", "NEW": "1"}
    )
    assert kept.changes("code", tmp_path) == [
        f"MPLBACKEND {chosen()['MPLBACKEND']} became agg",
        "NEW unset became 1",
        "OPENBLAS_CORETYPE Haswell became unset",
    ]


def test_a_run_whose_environment_is_not_known_is_no_record():
    old = asdict(Record("code", {}, {}, {}, seconds=1.0))
    del old["environment"]
    assert read_record(old) is None
