import json
import os
import shlex
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from disk import disk_of
from PIL import Image

import msc.cli
import msc.plots._film
import msc.search._sweep
import msc.study._calibration
from msc import load_dataset
from msc.cli import main
from msc.data import COLUMNS, save_table
from msc.search._journal import Journal
from press import check_output

really = msc.search._sweep._search

# All of a generation at once, and two generations a start.
SHORT = ["--set", "agreement=2", "--set", "max_evaluations=9", "--set", "max_sweeps=1"]
SEARCH = ["search", "--tasks", "2", "--jobs", "1", *SHORT]
FOUR = ["search", "--tasks", "4", *SHORT]
ZERO = ["--policy", *"000000"]

DISK = 6000  # bytes that a file may have, as on a disk almost full


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What a search that nothing cuts short writes, by name."""
    folder = tmp_path_factory.mktemp("whole")
    assert main([*FOUR, "--jobs", "1", "--out", str(folder / "free.csv")]) == 0
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def contents(folder):
    return {file.name: file.read_bytes() for file in Path(folder).iterdir()}


def save_old_table(path):
    table = pd.DataFrame(np.zeros((1, len(COLUMNS))), columns=list(COLUMNS))
    save_table(table, path, command="", seed=0)
    return path.read_bytes()


def files(folder="."):
    return sorted(str(one) for one in Path(folder).rglob("*") if one.is_file())


# msc search


def test_a_search_writes_a_table_that_says_how_it_was_made(capfd):
    assert main([*SEARCH, "--seed", "5", "--out", "new/free.csv"]) == 0
    assert files() == ["new/datapackage.json", "new/free.csv"]
    table = load_dataset(Path("new/free.csv"))[2]
    assert table["task_deg"].tolist() == [0, 180]
    assert (table["seed"] == 5).all()
    (resource,) = json.loads(Path("new/datapackage.json").read_text("utf-8"))[
        "resources"
    ]
    assert resource["command"] == (
        "msc search --workspace free --tasks 2 --offset 0 --seed 5 "
        "--set agreement=2.0 --set max_evaluations=9 --set max_sweeps=1 "
        "--out data/free.csv"
    )
    out, err = capfd.readouterr()
    assert out.startswith("new/free.csv: 2 tasks, at most ")
    assert out.count("\n") == 1
    assert "task/s" in err


def test_the_command_in_the_package_makes_the_same_table():
    assert main([*SEARCH, "--out", "data/free.csv"]) == 0
    more = ["--offset", "7.5", "--guide", "data/free.csv", "--out", "data/test.csv"]
    assert main([*SEARCH, *more]) == 0
    before = {name: Path(name).read_bytes() for name in files()}
    for resource in json.loads(before["data/datapackage.json"])["resources"]:
        assert main([*shlex.split(resource["command"])[1:], "--jobs", "1"]) == 0
    assert {name: Path(name).read_bytes() for name in files()} == before


def test_a_guide_may_be_a_name_and_the_command_works_again():
    more = ["--offset", "7.5", "--guide", "free", "--out", "new/test.csv"]
    assert main([*SEARCH, *more]) == 0
    package = json.loads(Path("new/datapackage.json").read_text("utf-8"))
    command = package["resources"][0]["command"]
    assert main([*shlex.split(command)[1:], "--jobs", "1"]) == 0
    assert contents("data") == contents("new")


def test_an_interrupted_search_goes_on_to_the_same_bytes(whole, monkeypatch, capfd):
    """With workers and a true Ctrl-C, see tests/slow."""
    arguments = [*FOUR, "--jobs", "1", "--out", "half/free.csv"]

    def interrupted(plan, work):
        if min(work) >= 2:
            raise KeyboardInterrupt
        return really(plan, work)

    with monkeypatch.context() as patch:
        patch.setattr(msc.search._sweep, "_search", interrupted)
        assert main(arguments) == 130
    out, err = capfd.readouterr()
    assert out == ""
    assert err.endswith("msc: the same command goes on from here\nmsc: interrupted\n")
    assert files("half") == ["half/.free.csv.partial"]

    assert main(arguments) == 0
    assert contents("half") == whole


def test_a_search_on_a_full_disk_leaves_the_old_table_and_goes_on(whole, capfd):
    arguments = [*FOUR, "--jobs", "1", "--out"]
    Path("half").mkdir()
    old = save_old_table(Path("half/free.csv"))
    with disk_of(DISK):
        assert main([*arguments, "half/free.csv"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.endswith("\nmsc: error: File too large: half/.free.csv.partial\n")
    assert "Traceback" not in err
    assert Path("half/free.csv").read_bytes() == old
    assert Path("half/.free.csv.partial").stat().st_size == DISK

    assert main([*arguments, "half/free.csv"]) == 0
    assert Path("half/free.csv").read_bytes() == whole["free.csv"]


def test_a_search_that_another_does_is_refused(monkeypatch, capsys):
    old = save_old_table(Path("free.csv"))
    monkeypatch.setattr(msc.search._sweep, "search_steps", None)
    with Journal(Path(".free.csv.partial"), "another plan"):
        assert main([*SEARCH, "--out", "free.csv"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("msc: error: .free.csv.partial is in use by another search; ")
    assert err.count("\n") == 1
    assert Path("free.csv").read_bytes() == old
    assert Path(".free.csv.partial").is_file()


def test_a_journal_that_cannot_be_written_is_named(here, capsys):
    Path(".free.csv.partial").mkdir()
    assert main([*SEARCH, "--out", "free.csv"]) == 2
    err = capsys.readouterr().err
    assert err == "msc: error: Is a directory: .free.csv.partial\n"
    assert not files()


def test_what_was_found_survives_a_full_disk(monkeypatch, capsys):
    def fail(*_, **__):
        raise OSError(28, "No space left on device", "free.csv")

    with monkeypatch.context() as patch:
        patch.setattr(msc.cli, "save_table", fail)
        assert main([*SEARCH, "--out", "free.csv"]) == 2
    assert "No space left on device: free.csv" in capsys.readouterr().err
    assert files() == [".free.csv.partial"]
    monkeypatch.setattr(msc.search._sweep, "search_steps", None)
    assert main([*SEARCH, "--out", "free.csv"]) == 0


BROKEN = [b"{", b"[]", b'{"resources": [{}]}', b"{}", b"\xff"]


@pytest.mark.parametrize("content", BROKEN)
def test_a_broken_data_package_is_named_before_the_search(content, monkeypatch, capsys):
    monkeypatch.setattr(msc.search._sweep, "search_steps", None)
    Path("new").mkdir()
    Path("new/datapackage.json").write_bytes(content)
    assert main([*SEARCH, "--out", "new/free.csv"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("msc: error: new/datapackage.json: wanted a data package, ")
    assert err.count("\n") == 1
    assert files() == ["new/datapackage.json"]
    assert Path("new/datapackage.json").read_bytes() == content


# A worker killed, as by the system


def killed_over_the_third(plan, work):
    """Stand in for a worker's search: it is killed over the third task."""
    if min(work) >= 2:
        time.sleep(1)
        os.kill(os.getpid(), signal.SIGKILL)
    return really(plan, work)


def killed(*_, **__):
    """Stand in for work whose worker is killed."""
    raise BrokenProcessPool


KILLED = "msc: error: a worker was killed, as the system does when memory runs out; "
ANEW, ON = "the same command begins anew\n", "the same command goes on from here\n"


def test_two_workers_find_what_one_finds(whole):
    assert main([*FOUR, "--jobs", "2", "--out", "two/free.csv"]) == 0
    assert contents("two") == whole


def test_a_search_whose_worker_is_killed_goes_on_to_the_same_bytes(
    whole, monkeypatch, capfd
):
    arguments = [*FOUR, "--out"]
    with monkeypatch.context() as patch:
        patch.setattr(msc.search._sweep, "_search", killed_over_the_third)
        assert main([*arguments, "half/free.csv", "--jobs", "2"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.endswith("\n" + KILLED + ON)
    assert "Traceback" not in err
    assert files("half") == ["half/.free.csv.partial"]
    assert Path("half/.free.csv.partial").read_bytes().count(b"\n") <= 3

    assert main([*arguments, "half/free.csv", "--jobs", "1"]) == 0
    assert contents("half") == whole


def test_a_command_whose_worker_is_killed_says_so(monkeypatch, capfd):
    monkeypatch.setattr("msc.study._calibration._walk", killed)
    assert main(["survey", "cut", "--out", "new/cut.json", "--jobs", "1"]) == 2
    out, err = capfd.readouterr()
    assert err.splitlines(keepends=True)[-1] == KILLED + ANEW
    assert "Traceback" not in err
    assert (out, files()) == ("", [])


# msc render


def test_a_given_policy_is_drawn(capfd):
    arguments = ["--workspace", "obstacles", "--task", "200", "--out", "new/arm.png"]
    assert main(["render", *arguments, *ZERO]) == 0
    with Image.open("new/arm.png") as strip:
        assert strip.width == 6 * strip.height
    out, err = capfd.readouterr()
    assert out.startswith("new/arm.png: the given policy ends ")
    assert out.endswith(" cm from the target\n")
    assert not err


def test_by_default_the_nearest_task_s_policy_is_drawn(monkeypatch, capsys):
    table = pd.DataFrame(np.zeros((4, len(COLUMNS))), columns=list(COLUMNS))
    table["task_deg"], table["winner"] = [0.0, 90.0, 180.0, 270.0], "start 0"
    save_table(table, Path("data/free.csv"), command="", seed=0)
    monkeypatch.setattr(msc.plots._film, "render", lambda *_: None)
    for task, nearest in ((359, 0), (100, 90), (226, 270), (-80, 270), (720, 0)):
        assert main(["render", "--task", str(task), "--out", "arm.gif"]) == 0
        assert f"the policy searched for {nearest}° ends" in capsys.readouterr().out


# msc survey


@pytest.mark.parametrize(
    ("constant", "function"), [("cut", "locate_cut"), ("layout", "choose_layout")]
)
def test_a_survey_writes_what_it_measured(constant, function, monkeypatch, capsys):
    asked = {}

    def measure(**options):
        asked.update(options)
        return {"tie_deg": 70.2}

    monkeypatch.setattr(msc.study._calibration, function, measure)
    arguments = ["--seed", "3", "--jobs", "1", "--out", "results/found.json"]
    assert main(["survey", constant, *arguments]) == 0
    assert json.loads(Path("results/found.json").read_text("utf-8")) == {
        "tie_deg": 70.2
    }
    assert (asked["seed"], asked["jobs"]) == (3, 1)
    assert capsys.readouterr().out == "results/found.json\n"


# Bad input


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ("search --workspace fre --out free.csv", "workspace='fre'"),
        ("search --tasks 1 --out free.csv", "tasks=1"),
        ("search --tasks 4 --offset 90 --out free.csv", "offset=90"),
        ("search --jobs 0 --out free.csv", "jobs=0"),
        ("search --seed -1 --out free.csv", "seed=-1"),
        ("search --guide no.csv --out free.csv", "'no.csv' is not there"),
        ("search --out file/free.csv", "out=file/free.csv"),
        ("search --out file/deeper/free.csv", "out=file/deeper/free.csv"),
        ("search --out folder.csv", "out=folder.csv"),
        ("search --out free.txt", "out=free.txt"),
        ("search --tasks 1 --out FREE.CSV", "tasks=1"),
        ("survey cut --out file/cut.json", "out=file/cut.json"),
        ("survey layout --out cut.txt", "out=cut.txt"),
        ("survey cut --jobs 0 --out cut.json", "jobs=0"),
        ("survey cut --seed -1 --out cut.json", "seed=-1"),
        ("audit free --jobs 0", "jobs=0; wanted at least 1"),
        ("audit free --jobs -1", "jobs=-1; wanted at least 1"),
        ("audit free --seed -1", "seed=-1; wanted 0 or more"),
        ("audit free --sample 0", "sample=0; wanted from 1 to "),
        ("twice --jobs 0", "jobs=0; wanted at least 1"),
        ("release", "holds no book: it has no _toc.yml"),
        ("pdf", "holds no book: it has no _toc.yml"),
        ("claims", "holds no claims: it has no book/claims.yml"),
        ("render --task 0 --out arm.avi --policy 0 0 0 0 0 0", "arm.avi"),
        ("render --task nan --out a.gif --policy 0 0 0 0 0 0", "task_deg=nan"),
        ("render --task 0 --out a.gif --policy 0 0", "policy has shape ("),
        ("render --task 0 --out a.gif --policy 0 0 0 0 0 nan", "policy has NaN"),
        ("render --task 0 --out a.gif --policy 0 0 0 0 0 1e308", "policy has a weight"),
        ("render --task 1e300 --out A.GIF --policy 0 0 0 0 0 0", "task_deg has an ang"),
        ("render --task 0 --out file/a.gif --policy 0 0 0 0 0 0", "out=file/a.gif"),
        ("render --task 0 --out a.gif --workspace free2", "workspace='free2'"),
        ("book --profile quik", "profile"),
        ("book --profile quik", "'quik'"),
    ],
)
def test_bad_input_is_named_in_a_sentence(
    arguments, complaint, here, monkeypatch, capfd
):
    works = (msc.search._sweep, "search_tasks"), (msc.plots._film, "render")
    works += (
        (msc.study._calibration, "locate_cut"),
        (msc.study._calibration, "choose_layout"),
    )
    for module, work in works:
        monkeypatch.setattr(module, work, None)  # it must not come to that
    Path("folder.csv").mkdir()
    Path("file").touch()
    before = sorted(here.rglob("*"))
    assert main(arguments.split()) == 2
    out, err = capfd.readouterr()
    assert not out
    assert err.startswith("msc: error: ")
    assert err.count("\n") == 1
    assert complaint in err
    assert sorted(here.rglob("*")) == before


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ("", "COMMAND"),
        ("serch", "invalid choice: 'serch'"),
        ("search", "--out"),
        ("search --tasks few --out free.csv", "--tasks: invalid int value: 'few'"),
        ("survey home --out cut.json", "invalid choice: 'home'"),
        ("render --out arm.gif", "--task"),
    ],
)
def test_a_malformed_command_line_is_refused(arguments, complaint, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(arguments.split())
    assert complaint in capsys.readouterr().err
    assert not files()


def test_a_policy_may_have_any_sign(monkeypatch):
    monkeypatch.setattr(msc.plots._film, "render", lambda *_: None)
    policy = ["-1", "2", "-3.5", "1e1", "-0", "-.5"]
    arguments = ["render", "--task", "-90", "--out", "arm.gif", "--policy", *policy]
    assert main(arguments) == 0


def test_the_module_runs_as_a_program():
    package = Path(msc.cli.__file__).parents[1]
    run = subprocess.run(
        [sys.executable, "-m", "msc", "search", "--jobs", "0", "--out", "free.csv"],
        env={**os.environ, "PYTHONPATH": str(package)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr == "msc: error: jobs=0; wanted at least 1\n"


@pytest.mark.parametrize("name", ["a.CSV", "a.Csv", "a.csv"])
@pytest.mark.parametrize("suffix", [".csv", ".CSV"])
def test_an_ending_may_be_in_capitals(tmp_path, name, suffix):
    check_output(tmp_path / name, suffix)
    with pytest.raises(ValueError, match=r"wanted a name ending in \.json"):
        check_output(tmp_path / name, ".json")
