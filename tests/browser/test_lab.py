"""JupyterLab as `make lab` starts it: a chapter is run, changed, run again and saved.

In a clone with `make hooks`, git then sees what was changed by hand and nothing else.
"""

import json
import os
import shutil
import signal
import socket
import subprocess
import time
from contextlib import contextmanager, suppress
from urllib.request import urlopen

import pytest
from built import ROOT
from conftest import PATIENCE, WIDE

CHAPTER = "book/fig3_free_24.ipynb"
SECONDS = 300  # at most, until JupyterLab listens or a chapter has run
TOKEN = "token"

# What the clone has of the repository: the packages are those of the environment.
KEPT = "Makefile", "requirements.txt", ".gitignore", ".pre-commit-config.yaml", "book"


def call(folder, *command):
    """Run a command in a folder; return what it prints."""
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def status(clone):
    """Ask git what has changed, without writing down what it found."""
    return call(clone, "git", "--no-optional-locks", "status", "--porcelain")


@pytest.fixture
def clone(tmp_path):
    """Lay out a clone of the book, with hooks and the environment of the tests."""
    folder = tmp_path / "a clone"
    folder.mkdir()
    for name in KEPT:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)
    call(folder, "git", "init", "--quiet")
    with (folder / ".git/info/exclude").open("a", encoding="utf-8") as exclude:
        exclude.write(".venv\n")
    (folder / ".venv").symlink_to(ROOT / ".venv")
    call(folder, "git", "add", "--all")
    me = "-c", "user.name=me", "-c", "user.email=me@example.org"
    call(folder, "git", *me, "commit", "--quiet", "--message", "All")
    call(folder, "make", "hooks")
    return folder


@contextmanager
def jupyterlab(clone, own):
    """Start JupyterLab as `make lab` does, with no settings of one's own."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    options = f"--no-browser --allow-root --port={port} --ServerApp.port_retries=0"
    folders = {
        f"JUPYTER{kind}_DIR": str(own / kind)
        for kind in ("_CONFIG", "_RUNTIME", "LAB_SETTINGS", "LAB_WORKSPACES")
    }
    with (own / "log").open("w", encoding="utf-8") as log:
        lab = subprocess.Popen(
            ["make", "lab", f"LAB={options} --IdentityProvider.token={TOKEN}"],
            cwd=clone,
            env={**os.environ, **folders, "IPYTHONDIR": str(own)},
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
    address = f"http://127.0.0.1:{port}"
    try:
        wait_until(lambda: answers(f"{address}/api?token={TOKEN}") or lab.poll())
        assert lab.poll() is None, (own / "log").read_text("utf-8")
        yield address
    finally:
        os.killpg(lab.pid, signal.SIGTERM)  # make, JupyterLab and its kernels
        lab.wait()


def answers(url):
    try:
        return urlopen(url).status == 200
    except OSError:
        return False


def wait_until(holds):
    """Ask again and again, but not for ever."""
    end = time.monotonic() + SECONDS
    while not (held := holds()):
        assert time.monotonic() < end
        time.sleep(0.1)
    return held


def run_and_save(page, file):
    """Run all cells, save until all have run, and return what they showed."""
    before = file.read_bytes()
    page.get_by_text("Python 3 (ipykernel) | Idle").wait_for()  # it is connected
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()

    def done():
        page.keyboard.press("Control+s")
        page.wait_for_timeout(1000)
        if (text := file.read_bytes()) == before:
            return []
        with suppress(ValueError):  # half of it is written
            cells = json.loads(text)["cells"]
            cells = [cell for cell in cells if cell["cell_type"] == "code"]
            return cells if all(cell["execution_count"] for cell in cells) else []

    outputs = [output for cell in wait_until(done) for output in cell["outputs"]]
    assert not [one for one in outputs if one["output_type"] == "error"]
    return json.dumps([one["data"] for one in outputs if "data" in one])


def change(page, name, old, new):
    """Type another value of a parameter where it is assigned."""
    line = page.locator(".cm-line", has_text=f"{name} = {old}").first
    line.get_by_text(old, exact=True).dblclick()
    page.keyboard.type(new)
    line = page.locator(".cm-line", has_text=f"{name} = {new}").first
    assert line.is_visible()


def test_a_chapter_is_edited_and_git_sees_what_was_changed(browser, clone, tmp_path):
    file = clone / CHAPTER
    with jupyterlab(clone, tmp_path) as address:
        context = browser.new_context(viewport=WIDE)
        context.set_default_timeout(PATIENCE)
        page = context.new_page()
        page.goto(f"{address}/lab/tree/{CHAPTER}?token={TOKEN}")
        page.locator(".jp-CodeCell .cm-line").first.wait_for()
        first = run_and_save(page, file)
        assert "image/png" in first
        wait_until(lambda: not status(clone))
        change(page, "n_samples", "24", "12")
        assert run_and_save(page, file) != first
        context.close()
    assert call(clone, "git", "diff", "--cached") == ""
    told = call(clone, "git", "diff", "--unified=0").splitlines()
    changed = [line for line in told if line[0] in "+-" and "book/" not in line]
    assert [line.split("#")[0] for line in changed] == [
        '-    "n_samples = 24  ',
        '+    "n_samples = 12  ',
    ]
    assert status(clone) == f" M {CHAPTER}\n"
