import json
import shutil
import subprocess
import sys
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from disk import disk_of

import msc.search._journal
from msc import SearchResult, Workspace
from msc.search import SearchOptions, SweepPlan, grid
from msc.search._cmaes import CmaRun
from msc.search._journal import Journal

plan = SweepPlan(Workspace.free(), grid(4), seed=0, n_starts=1)

# Holds a journal, and so does a child that outlives it if it inherits the lock.
HOLDER = """
import subprocess, sys, time
from pathlib import Path
from msc.search._journal import Journal

with Journal(Path(sys.argv[1]), "plan"):
    child = subprocess.Popen(["sleep", "20"])
    print(child.pid, flush=True)
    time.sleep(20)
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "new" / "journal"


def result(seed=0):
    rng = np.random.default_rng(seed)
    runs = tuple(
        CmaRun(f"start {k}", rng.normal(size=6), float(rng.normal()), 9 * k, k - 1)
        for k in range(2)
    )
    numbers = rng.normal(size=4).tolist()
    return SearchResult(7.5, runs[0].policy, *numbers, runs, same=0.02)


def bits(result):
    *numbers, runs, same = astuple(result)
    return [np.asarray(value).tobytes() for value in numbers], repr(runs), same


def write(path, n_results=2, plan=plan):
    with Journal(path, plan) as journal:
        for k in range(n_results):
            journal.append("level 0", k, result(k))


def read(path, plan=plan):
    with Journal(path, plan) as journal:
        return dict(journal.results)


# There and back


def test_results_come_back_bit_for_bit(path):
    write(path, 3)
    found = read(path)
    assert list(found) == [("level 0", k) for k in range(3)]
    for k in range(3):
        assert bits(found["level 0", k]) == bits(result(k))


def test_what_was_appended_is_on_disk_at_once(path):
    with Journal(path, plan) as journal:
        for k in range(3):
            journal.append("level 0", k, result(k))
            assert path.read_bytes().count(b"\n") == k + 2


def test_what_is_there_stays_as_it_is(path):
    write(path)
    before = path.read_bytes()
    read(path)
    assert path.read_bytes() == before
    with Journal(path, plan) as journal:
        journal.append("level 1", 0, result())
    assert path.read_bytes().startswith(before)
    assert len(read(path)) == 3


def test_without_a_file_nothing_is_kept_on_disk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with Journal(None, plan) as journal:
        journal.append("level 0", 0, result())
        assert bits(journal.results["level 0", 0]) == bits(result())
    assert not list(tmp_path.iterdir())


def test_each_line_is_json(path):
    with Journal(path, plan) as journal:
        journal.append("level 0, sweep 1", 3, result())
    header, entry = map(json.loads, path.read_text("utf-8").splitlines())
    assert list(header) == ["plan"]
    assert (entry["phase"], entry["k"]) == ("level 0, sweep 1", 3)
    assert entry["result"]["policy"] == result().policy.tolist()


# Torn lines


@pytest.mark.parametrize("end", [-1, -60, 20])
def test_a_torn_line_is_dropped(end, path):
    write(path)
    last = path.read_bytes().splitlines(keepends=True)[-1]
    whole = path.read_bytes().removesuffix(last)
    path.write_bytes(whole + last[:end])
    assert list(read(path)) == [("level 0", 0)]
    assert path.read_bytes() == whole
    with Journal(path, plan) as journal:
        journal.append("level 0", 1, result(1))
    assert path.read_bytes() == whole + last


def test_what_follows_a_torn_line_is_dropped_with_it(path):
    write(path, 3)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], b"\0" * 512 + lines[2][512:], lines[3]]))
    assert list(read(path)) == [("level 0", 0)]
    assert path.read_bytes() == b"".join(lines[:2])


def entries(lines):
    """Make lines that are JSON, and none of this journal's, out of one that is."""
    entry = json.loads(lines[1])
    start, *others = entry["result"]["runs"]
    changed = [
        {"k": 7},
        {"k": "1"},
        {"k": [1]},
        {"phase": "level 9"},
        {"phase": None},
        {"result": None},
        {"result": {}},
        {"result": {**entry["result"], "cost": 0.0}},
        {"result": {**entry["result"], "policy": "none"}},
        {"result": {**entry["result"], "more": 1}},
        {"result": {**entry["result"], "runs": [{**start, "merged_into": 5}, *others]}},
        {"digest": 64 * "0"},
        {"digest": None},
    ]
    yield from [5, -0.5, [], [1, 2], None, True, "text", {}, {"phase": "level 0"}]
    yield from [entry | change for change in changed]
    for key in entry:
        yield {name: value for name, value in entry.items() if name != key}


def test_a_line_that_is_json_and_no_entry_is_dropped_as_a_torn_one(path):
    write(path, 3)
    lines = path.read_bytes().splitlines(keepends=True)
    made_up = [json.dumps(entry).encode() for entry in entries(lines)]
    made_up += [b"", lines[0].strip(), lines[1].strip()[:-1] + b" }", b"[" * 100_000]
    for line in made_up:
        path.write_bytes(b"".join([*lines[:2], line, b"\n", lines[3]]))
        assert list(read(path)) == [("level 0", 0)], line[:200]
        assert path.read_bytes() == b"".join(lines[:2])


def test_a_line_of_another_plan_is_dropped(path):
    write(path, 2, replace(plan, seed=1))
    other = path.read_bytes().splitlines(keepends=True)
    write(path, 2)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], other[2]]))
    assert list(read(path)) == [("level 0", 0)]


@pytest.mark.parametrize("end", [0, 20, -1])
def test_a_torn_first_line_is_begun_anew(end, path):
    write(path, 0)
    header = path.read_bytes()
    path.write_bytes(header[:end])
    assert not read(path)
    assert path.read_bytes() == header


# Other searches


@pytest.mark.parametrize(
    "other",
    [
        replace(plan, seed=1),
        replace(plan, n_starts=2),
        replace(plan, tasks_deg=grid(5)),
        replace(plan, workspace=Workspace(cut_deg=70.0)),
        replace(plan, guide=((0.0, (0.0,) * 6),)),
        replace(plan, options=SearchOptions(max_sweeps=23)),
    ],
)
def test_another_plan_is_begun_anew(other, path):
    write(path)
    assert not read(path, other)
    assert not read(path)


@pytest.mark.parametrize("name", msc.search._journal.CODE)
def test_other_code_is_begun_anew(name, path, tmp_path, monkeypatch):
    package = tmp_path / "msc"
    write(path)
    shutil.copytree(Path(msc.search._journal.__file__).parents[1], package)
    there = str(package / "search" / "_journal.py")
    monkeypatch.setattr(msc.search._journal, "__file__", there)
    assert read(path)
    with (package / f"{name}.py").open("a", encoding="utf-8") as file:
        file.write("# changed\n")
    assert not read(path)


# One at a time


@pytest.mark.parametrize("other", [plan, replace(plan, seed=1)])
def test_a_second_holder_is_refused_and_changes_nothing(other, path):
    write(path)
    with Journal(path, plan) as journal:
        before = path.read_bytes()
        with pytest.raises(ValueError, match=r"journal is in use by another search; "):
            Journal(path, other)
        assert path.read_bytes() == before
        journal.append("level 1", 0, result())
    assert len(read(path)) == 3


def test_a_killed_holder_holds_nothing_even_if_a_child_lives_on(path):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(path)],
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    with holder:
        child = Path("/proc", holder.stdout.readline().decode().strip())
        with pytest.raises(ValueError, match="in use by another search"):
            Journal(path, "plan")
        holder.kill()
        holder.wait()
        assert child.is_dir()
        assert not read(path, "plan")
        subprocess.run(["kill", child.name], check=True)


# Failing disks


def test_on_a_full_disk_what_is_kept_stays_and_the_file_is_named(path):
    write(path)
    whole = path.read_bytes()
    with (
        disk_of(len(whole) + 100),
        pytest.raises(OSError, match=r"File too large: '.*/new/journal'"),
        Journal(path, plan) as journal,
    ):
        journal.append("level 0", 2, result(2))
    assert path.read_bytes()[: len(whole)] == whole
    assert len(path.read_bytes()) == len(whole) + 100
    assert list(read(path)) == [("level 0", 0), ("level 0", 1)]
    assert path.read_bytes() == whole


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=r"'.*/file'"):
        Journal(tmp_path / "file" / "journal", plan)


def test_a_journal_that_is_a_folder_is_named(path):
    path.mkdir(parents=True)
    with pytest.raises(IsADirectoryError, match=r"'.*/new/journal'"):
        Journal(path, plan)
