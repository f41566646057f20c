"""What contributors run: hooks, JupyterLab, workflows, containers."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
import yaml
from ipykernel.ipkernel import IPythonKernel
from jupyter_client.kernelspec import KernelSpecManager

ROOT = Path(__file__).parents[1]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([a-z][a-z-]*):.*## ", MAKEFILE, re.M))
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
MADE = (".venv", "_build", "~/.cache")  # not in the repository


def steps(path):
    """Return the steps of all jobs of a workflow."""
    jobs = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]
    return [step for job in jobs.values() for step in job["steps"]]


def commands(path):
    """Return the command lines that a file has a machine run."""
    if path.suffix == ".yml":
        return [
            line for step in steps(path) for line in step.get("run", "").split("\n")
        ]
    told = json.loads(path.read_text(encoding="utf-8"))
    return [text for key, text in told.items() if key.endswith("Command")]


CONTAINER = ROOT / ".devcontainer" / "devcontainer.json"


@pytest.mark.parametrize("path", [*WORKFLOWS, CONTAINER], ids=lambda path: path.name)
def test_what_is_run_exists(path):
    lines = [line for line in commands(path) if line]
    assert lines
    for line in lines:
        program, *arguments = line.split()
        if program == "make":
            wanted = {word for word in arguments if "=" not in word}
            assert wanted
            assert wanted <= TARGETS
            given = {word.partition("=")[0] for word in arguments if "=" in word}
            assert all(re.search(rf"^{name} \?=", MAKEFILE, re.M) for name in given)
        elif "/" in program:
            assert os.access(ROOT / program, os.X_OK)


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_files_that_a_workflow_names_exist(path):
    text = path.read_text(encoding="utf-8")
    named = re.findall(r"'([^']+)'", " ".join(re.findall(r"hashFiles\((.+?)\)", text)))
    for step in steps(path):
        given = step.get("with", {})
        named += [given["cache-dependency-path"]] if "cache" in given else []
        named += given.get("path", "").split()
    assert named
    for name in named:
        assert name.startswith(MADE) or next(ROOT.glob(name), None), name


def test_the_book_s_workflow_is_ci_and_only_main_is_published():
    [path] = [path for path in WORKFLOWS if path.stem == "book"]
    told = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert ".ci/run" in commands(path)
    assert told["permissions"] == {"contents": "read"}
    assert told["jobs"]["publish"]["if"] == "github.ref == 'refs/heads/main'"
    assert told["jobs"]["publish"]["needs"] == "book"


def test_the_full_profile_is_scheduled():
    [path] = [path for path in WORKFLOWS if path.stem == "full"]
    told = yaml.safe_load(path.read_text(encoding="utf-8"))
    [entry] = told[True]["schedule"]  # YAML 1.1 reads `on` as true
    assert re.fullmatch(r"(\S+ ){4}\S+", entry["cron"])
    lines = " ".join(commands(path))
    assert "make results" in lines
    assert "make book PROFILE=full" in lines


def test_every_machine_has_the_same_python():
    [version] = re.findall(r"^NEEDED := (3\.\d+)", MAKEFILE, re.M)
    files = [*WORKFLOWS, CONTAINER, ROOT / ".binder" / "runtime.txt"]
    asked = r"(?:container: python:|python-version: \"|\"python:|^python-)(3\.\d+)"
    for path in files:
        found = re.findall(asked, path.read_text(encoding="utf-8"))
        assert found == [version], path.name


def test_binder_installs_the_lock_and_nothing_else():
    requirements = ROOT / ".binder" / "requirements.txt"
    lines = [
        line for line in requirements.read_text("utf-8").splitlines() if line[0] != "#"
    ]
    [(flag, name)] = [line.split() for line in lines]
    assert flag == "-r"
    assert (requirements.parent / name).resolve() == ROOT / "requirements.txt"
    script = requirements.with_name("postBuild")
    assert os.access(script, os.X_OK)
    installs = re.findall(r"pip install (.+)", script.read_text("utf-8"))
    assert installs == ["--no-deps --no-build-isolation --editable ."]


# Hooks and JupyterLab, as `make` starts them


def run(*command, folder, **environment):
    given = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_NOSYSTEM": "1"}
    given |= {"GIT_AUTHOR_NAME": "A", "GIT_AUTHOR_EMAIL": "a@b"}
    given |= {"GIT_COMMITTER_NAME": "A", "GIT_COMMITTER_EMAIL": "a@b"}
    given["PYTHONPATH"] = str(folder.parent / "python")
    mine = {key: text for key, text in os.environ.items() if not key.startswith("GIT_")}
    return subprocess.run(
        command,
        cwd=folder,
        env=mine | given | environment,
        capture_output=True,
        text=True,
        check=False,
    )


# A shell or make would take parts of it for something else.
ODD = "a clone $HOME $(touch no) `touch no` 'b' \"c\" [d]* \N{SNOWMAN} #; touch no"


def lay_out(folder):
    """Lay out the set-up alone."""
    root = folder / ODD
    (root / "book").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", ".pre-commit-config.yaml", ".gitignore"):
        shutil.copy(ROOT / name, root)
    lock = root / "requirements.txt"
    lock.touch()
    os.utime(lock, (0, 0))
    return root


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """Lay out a repository of the set-up alone, with this very environment."""
    tmp_path = tmp_path_factory.mktemp("contributing")
    if not (shutil.which("make") and shutil.which("git")):
        pytest.skip("needs make and git")
    if sys.prefix == sys.base_prefix:
        pytest.skip("needs a virtual environment")
    root = lay_out(tmp_path)
    (tmp_path / "python").mkdir()  # jsonschema does without, and nbstripout starts soon
    missing = "raise ImportError"
    (tmp_path / "python" / "rfc3987_syntax.py").write_text(missing, "utf-8")
    (root / ".venv").symlink_to(sys.prefix)
    if not (root / ".venv" / "installed").exists():
        pytest.skip("needs the environment that make makes")
    assert run("git", "init", "--initial-branch=main", folder=root).returncode == 0
    return root


@pytest.fixture(scope="module")
def hooks(clone):
    return run("make", "hooks", folder=clone)


def notebook(code, *outputs):
    cell = {"cell_type": "code", "source": code, "metadata": {}, "id": "a"}
    cell |= {"outputs": list(outputs), "execution_count": 1 if outputs else None}
    return {"cells": [cell], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def test_hooks_keep_outputs_and_bad_style_out_of_commits(clone, hooks, tmp_path):
    assert hooks.returncode == 0, hooks.stderr
    assert not (clone / "no").exists()
    home = {"PRE_COMMIT_HOME": str(tmp_path / "pre-commit")}
    printed = {"output_type": "stream", "name": "stdout", "text": "forty-two\n"}
    path = clone / "book" / "one.ipynb"
    path.write_text(json.dumps(notebook("6 * 7", printed), indent=1) + "\n", "utf-8")
    os.utime(path, (0, 0))  # older than the index: git strips it only once
    run("git", "add", "book", folder=clone)
    staged = run("git", "show", ":book/one.ipynb", folder=clone).stdout
    assert "6 * 7" in staged
    assert "forty-two" not in staged
    (clone / "bad.py").write_text("seven = six + one\n", "utf-8")
    run("git", "add", "bad.py", folder=clone)
    done = run("git", "commit", "-m", "Bad style", folder=clone, **home)
    assert done.returncode != 0
    assert "F821" in done.stdout + done.stderr
    (clone / "bad.py").unlink()
    run("git", "rm", "--cached", "bad.py", folder=clone)
    done = run("git", "commit", "-m", "A notebook", folder=clone, **home)
    assert done.returncode == 0, done.stdout + done.stderr


def run_in_lab(path):
    """Save a notebook as JupyterLab does once its cells have run."""
    found = nbformat.read(path, nbformat.NO_CONVERT)
    spec = KernelSpecManager(kernel_dirs=[f"{sys.prefix}/share/jupyter/kernels"])
    kernel = spec.get_kernel_spec("python3")
    found.metadata |= {
        "kernelspec": {
            "name": "python3",
            "display_name": kernel.display_name,
            "language": kernel.language,
        },
        "language_info": IPythonKernel.language_info,
        "widgets": {"application/vnd.jupyter.widget-state+json": {"state": {}}},
        "toc-showcode": True,
    }
    for number, cell in enumerate(found.cells):
        cell.metadata |= {"editable": True, "slideshow": {"slide_type": ""}}
        if cell.cell_type == "code":
            cell.execution_count = number
            cell.outputs = [nbformat.v4.new_output("stream", text="forty-two\n")]
            cell.metadata |= {
                "collapsed": True,
                "scrolled": True,
                "jupyter": {"outputs_hidden": True, "source_hidden": True},
                "execution": {"iopub.status.busy": "2026-11-27T07:00:00.000000Z"},
            }
    nbformat.write(found, path)


def test_after_the_hooks_a_chapter_run_in_lab_is_unchanged(clone, hooks):
    assert hooks.returncode == 0
    path = clone / "book" / "fig1_workspaces.ipynb"
    shutil.copy(ROOT / "book" / path.name, path)
    text = path.read_text("utf-8")
    run("git", "add", "book", folder=clone)
    run("git", "commit", "--no-verify", "-m", "A chapter", folder=clone)
    stored = run("git", "show", f"HEAD:book/{path.name}", folder=clone)
    assert stored.stdout == text
    run_in_lab(path)
    assert path.read_text("utf-8") != text
    for options in ([], ["--no-textconv"]):
        told = run("git", "diff", *options, folder=clone)
        assert (told.returncode, told.stdout, told.stderr) == (0, "", "")
    path.write_text(
        path.read_text("utf-8").replace("import", "import os, ", 1), "utf-8"
    )
    assert "import os" in run("git", "diff", folder=clone).stdout


# Stands in for Python: writes down what it is asked for.
STAND_IN = """#!/bin/bash
printf '%s\\n' "$JUPYTER_PATH" "$JUPYTER_PREFER_ENV_PATH" "$@" >"$TOLD"
"""


def test_lab_is_asked_for_the_repository_and_for_its_own_kernel(tmp_path):
    """What it then does, see tests/browser."""
    root = lay_out(tmp_path)
    python = root / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text(STAND_IN, "utf-8")
    python.chmod(0o755)
    (root / ".venv" / "installed").touch()
    given = {"TOLD": str(tmp_path / "told"), "JUPYTER_PATH": str(tmp_path)}
    done = run("make", "lab", "LAB=--no-browser --port=8", folder=root, **given)
    assert done.returncode == 0, done.stderr
    path, preferred, *asked = (tmp_path / "told").read_text("utf-8").splitlines()
    assert (path, preferred) == ("", "1")
    assert asked[:3] == ["-m", "jupyterlab", f"--ServerApp.root_dir={root}"]
    assert asked[-2:] == ["--no-browser", "--port=8"]
    assert not (root / "no").exists()
