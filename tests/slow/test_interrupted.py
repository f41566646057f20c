"""Ctrl-C in a terminal, while worker processes search."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from test_cli import FOUR, contents, files

from msc.cli import main

# A module whose search finds two tasks and then waits for Ctrl-C.
WAITING = """
import time
import msc.search._sweep

really = msc.search._sweep._search

def search(plan, work):
    if min(work) >= 2:
        time.sleep(300)
    return really(plan, work)

msc.search._sweep._search = search
"""
WAIT = "import sys, waiting; from msc.cli import main; sys.exit(main())"


def run_program(program, *arguments):
    """Run a program of Python in the background, and as the head of a group."""
    return subprocess.Popen(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(["", *sys.path])},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )


def test_a_search_ended_by_ctrl_c_goes_on_to_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = [*FOUR, "--jobs", "1", "--out"]
    Path("waiting.py").write_text(WAITING, "utf-8")
    process = run_program(WAIT, *arguments, "half/free.csv", "--jobs", "2")
    journal = tmp_path / "half" / ".free.csv.partial"
    while process.poll() is None:
        if journal.is_file() and journal.read_bytes().count(b"\n") == 3:
            os.killpg(process.pid, signal.SIGINT)  # as a terminal does
            break
        time.sleep(0.05)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130
    assert out == ""
    assert "msc: the same command goes on from here\nmsc: interrupted\n" in err
    assert files("half") == ["half/.free.csv.partial"]

    assert main([*arguments, "half/free.csv"]) == 0
    assert main([*arguments, "whole/free.csv"]) == 0
    assert contents("half") == contents("whole")
