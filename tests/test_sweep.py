import multiprocessing
import os
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import msc.search._sweep
from msc import SearchResult, Workspace, search_policy
from msc.cli import main
from msc.data import COLUMNS
from msc.search import SearchOptions, SweepPlan, grid, search_tasks
from msc.search._cmaes import CmaRun
from msc.search._journal import Journal

plan = SweepPlan(Workspace.free(), grid(4), seed=0, n_starts=1)

# Cut short, and the consistency pass after each task's turn. Of four tasks, two are
# searched first.
short = SearchOptions(max_evaluations=9, agreement=2, max_sweeps=1, coarse_deg=180)
twofold = replace(plan, n_starts=2, options=short)
BRIEF = ["--set", "max_evaluations=9", "--set", "agreement=2", "--set", "max_sweeps=2"]


@pytest.fixture(scope="module")
def whole():
    return to_csv(search_tasks(twofold))


def to_csv(table):
    return table.to_csv(index=False)


# Tasks


@settings(deadline=None)
@given(st.integers(2, 400), st.floats(0, 0.99))
def test_a_grid_is_even_and_within_the_circle(n_tasks, share):
    tasks = np.array(grid(n_tasks, share * 360 / n_tasks))
    assert (tasks >= 0).all()
    assert (tasks < 360).all()
    np.testing.assert_allclose(np.diff(tasks), 360 / n_tasks)


@pytest.mark.parametrize("n_tasks", [1, 0, -3])
def test_fewer_than_two_tasks_are_refused(n_tasks):
    with pytest.raises(ValueError, match=f"tasks={n_tasks}; wanted at least 2"):
        grid(n_tasks)


@pytest.mark.parametrize("offset", [-1.0, 90.0, np.nan])
def test_an_offset_beyond_the_first_step_is_refused(offset):
    with pytest.raises(ValueError, match=r"offset=.* from 0 to below 90"):
        grid(4, offset)


# The search of many tasks


def test_a_table_has_one_row_a_task(whole):
    table = search_tasks(twofold)
    assert list(table.columns) == list(COLUMNS)
    assert table["task_deg"].tolist() == list(plan.tasks_deg)
    np.testing.assert_array_equal(
        table["cost"], table["cost_distance"] + table["cost_energy"]
    )
    np.testing.assert_array_equal(
        table["cost_distance"], 100 * table["distance_m"] ** 2
    )
    np.testing.assert_array_equal(
        table["cost_energy"], 0.005 * table["energy_rad2_per_s"]
    )
    assert to_csv(table) == whole


def test_a_task_s_own_search_does_not_depend_on_the_others():
    options = replace(short, max_sweeps=0)
    alone = search_policy(plan.workspace, 180, seed=0, n_starts=2, options=options)
    for n_tasks in (2, 4):
        tasks_deg = grid(n_tasks)
        table = search_tasks(replace(twofold, tasks_deg=tasks_deg, options=options))
        row = table[table["task_deg"] == 180]
        assert row.iloc[0, 1:7].tolist() == alone.policy.tolist()
        assert row["margin"].item() == alone.margin


def test_a_search_under_way_belongs_to_its_options(tmp_path):
    journal, more = tmp_path / "journal", replace(short, first_step=1.0)
    two = replace(twofold, tasks_deg=grid(2))
    first = search_tasks(two, journal=journal)
    other = replace(two, options=more)
    found = to_csv(search_tasks(other, journal=journal))
    assert found == to_csv(search_tasks(other))
    assert found != to_csv(first)


# Levels and passes, with a made-up search in place of the arm


def behaviour(basin):
    return np.r_[float(basin), 1.0, np.zeros(4)]


def made_up_search(depths):
    """Make a search that stays in the basin it starts in, or goes to the task's own.

    The basin is the policy's first weight, `depths` the costs: one row a task, one
    column a basin. An independent start finds the basin with the task's number, each
    further one the next. Of every call are kept: task, basins given, independent
    starts, and whether there was an incumbent.
    """
    calls = []

    def search(
        world, task, *, seed, options, n_starts, start_policies=(), incumbent=None
    ):
        k = round(task * len(depths) / 360)
        basins = [int(policy[0]) for policy in start_policies]
        calls.append((k, basins, n_starts, incumbent is not None))
        starts = list(incumbent.runs) if incumbent else []
        n_before = sum(start.name.startswith("start") for start in starts)
        new = [(f"given {i}", basin) for i, basin in enumerate(basins)]
        for number in range(n_before, n_before + n_starts):
            new.append((f"start {number}", (k + number) % depths.shape[1]))
        for name, basin in new:
            starts.append(CmaRun(name, behaviour(basin), float(depths[k, basin]), 9))
        best = min(starts, key=lambda start: start.cost)
        return SearchResult(task, best.policy, best.cost, 0.0, 0.0, 0.0, tuple(starts))
        yield  # nothing is executed

    search.calls = calls
    return search


@settings(max_examples=30, deadline=None)
@given(st.permutations(range(4)), st.integers(0, 100), st.sampled_from([5.0, 180.0]))
def test_the_best_behaviour_spreads_to_all_and_costs_only_fall(order, seed, coarse):
    depths = np.random.default_rng(seed).uniform(1, 2, size=(4, 4))
    depths[:, order[0]] -= 1
    options = SearchOptions(coarse_deg=coarse)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.search._sweep, "search_steps", made_up_search(depths))
        table = search_tasks(replace(plan, n_starts=4, options=options))
    assert (table["weight_x1"] == order[0]).all()
    np.testing.assert_array_equal(table["cost"], depths[:, order[0]])


def test_the_pass_rests_when_nothing_spreads(monkeypatch):
    search = made_up_search(np.ones((4, 1)))
    monkeypatch.setattr(msc.search._sweep, "search_steps", search)
    search_tasks(plan)
    assert sorted(call[0] for call in search.calls) == sorted([0, 1, 2, 3] * 2)


def test_a_winner_from_next_door_is_named_so(monkeypatch):
    depths = np.array([[1, 9, 9, 9], [1, 2, 9, 9], [9, 9, 1, 9], [1, 9, 9, 2]])
    monkeypatch.setattr(msc.search._sweep, "search_steps", made_up_search(depths))
    winners = search_tasks(plan)["winner"].tolist()
    assert winners == ["start 0", "task before", "start 0", "task after"]


@pytest.mark.parametrize(
    ("n_tasks", "strides"),
    [(36, [1]), (72, [2, 1]), (108, [3, 1]), (145, [4, 2, 1]), (360, [10, 5, 1])],
)
def test_tasks_ten_degrees_apart_are_searched_first(n_tasks, strides, monkeypatch):
    search = made_up_search(np.ones((n_tasks, 1)))
    monkeypatch.setattr(msc.search._sweep, "search_steps", search)
    search_tasks(replace(plan, tasks_deg=grid(n_tasks), n_starts=3))
    levels = [set(range(0, n_tasks, stride)) for stride in strides]
    expected = [(k, [], 2, False) for k in sorted(levels[0])]
    for coarse, fine in pairwise(levels):
        expected += [(k, [0, 0], 1, False) for k in sorted(fine - coarse)]
    new = [call for call in search.calls if not call[3]]
    assert new == expected
    again = search.calls[len(levels[0]) :][: len(levels[0])]
    assert {call[0] for call in again} == levels[0]  # before the next level


def test_tasks_between_start_from_what_was_made_consistent(monkeypatch):
    depths = np.array([[1, 9, 9, 9], [9, 9, 9, 9], [1, 9, 2, 9], [9, 9, 9, 9]])
    search = made_up_search(depths)  # task 2 finds basin 2, and 0 only from task 0
    monkeypatch.setattr(msc.search._sweep, "search_steps", search)
    search_tasks(replace(plan, options=SearchOptions(coarse_deg=180.0)))
    between = [call for call in search.calls if call[0] in (1, 3) and not call[3]]
    assert between == [(1, [0, 0], 1, False), (3, [0, 0], 1, False)]


def test_more_starts_are_spent_until_one_confirms(monkeypatch):
    search = made_up_search(np.tile([1.0, 2, 3], (4, 1)))
    monkeypatch.setattr(msc.search._sweep, "search_steps", search)
    options = SearchOptions(coarse_deg=180.0, max_sweeps=0)
    table = search_tasks(replace(plan, n_starts=3, options=options))
    assert search.calls[:4] == [
        (0, [], 2, False),  # its starts find basins 0 and 1
        (0, [], 1, True),  # and start 2, the last, basin 2
        (2, [], 2, False),
        (2, [], 1, True),
    ]
    assert search.calls[4:] == [
        (1, [0, 0], 1, False),  # its start 0 finds basin 1
        (1, [], 1, True),  # and start 1, the last, basin 2
        (3, [0, 0], 1, False),  # its start 0 finds basin 0 as well
    ]
    assert table["starts"].tolist() == [3, 4, 3, 3]
    assert table["starts_agreeing"].tolist() == [1, 2, 1, 3]
    np.testing.assert_array_equal(table["margin"], [1, 1, 1, np.nan])


# Neighbours


def test_a_guide_s_tasks_are_neighbours_known_from_the_beginning(monkeypatch):
    depths = np.array([[9, 1], [1, 9], [1, 9], [9, 9.0]])
    guide = tuple((angle, tuple(behaviour(1))) for angle in (300.0, 60.0))
    search = made_up_search(depths)
    monkeypatch.setattr(msc.search._sweep, "search_steps", search)
    options = SearchOptions(coarse_deg=180.0)
    table = search_tasks(replace(plan, n_starts=3, guide=guide, options=options))
    assert [call[:2] for call in search.calls if not call[3]] == [
        (k, [1, 1]) for k in range(4)
    ]
    assert table["winner"][0] == "task before"


@settings(deadline=None)
@given(
    st.lists(st.integers(0, 359), min_size=1, max_size=9, unique=True),
    st.floats(0, 360, exclude_max=True),
)
def test_nothing_known_lies_between_a_task_and_its_neighbours(angles, task):
    known = [(float(angle), np.array([angle])) for angle in angles]
    (before,), (after,) = msc.search._sweep._on_either_side(known, task)
    for angle in angles:
        assert (task - before) % 360 <= (task - angle) % 360
        assert (after - task) % 360 <= (angle - task) % 360


def test_where_nothing_is_known_there_are_no_neighbours():
    assert msc.search._sweep._nearby(plan, [], [0.0, 90.0]) == [(), ()]


# Interrupted and gone on with


@pytest.mark.parametrize("n_done", [1, 6])
def test_an_interrupted_search_ends_alike(n_done, whole, tmp_path, monkeypatch):
    journal = tmp_path / "journal"
    really, calls = msc.search._sweep._search, []

    def search(*arguments):
        calls.append(arguments)
        if len(calls) == n_done + 1:
            raise KeyboardInterrupt
        return really(*arguments)

    monkeypatch.setattr(msc.search._sweep, "_search", search)
    with pytest.raises(KeyboardInterrupt):
        search_tasks(twofold, journal=journal)
    assert len(journal.read_text("utf-8").splitlines()) == 1 + n_done
    assert to_csv(search_tasks(twofold, journal=journal)) == whole
    n_searches = len(calls) - 1
    assert len(journal.read_text("utf-8").splitlines()) == 1 + n_searches


def test_a_finished_journal_is_all_it_takes(whole, tmp_path, monkeypatch):
    search_tasks(twofold, journal=tmp_path / "journal")
    monkeypatch.setattr(msc.search._sweep, "search_steps", None)
    assert to_csv(search_tasks(twofold, journal=tmp_path / "journal")) == whole


def test_a_torn_journal_ends_alike(whole, tmp_path):
    journal = tmp_path / "journal"
    search_tasks(twofold, journal=journal)
    content = journal.read_bytes()
    for torn in (len(content) // 2, len(content) - 1):
        journal.write_bytes(content[:torn])
        assert to_csv(search_tasks(twofold, journal=journal)) == whole
        assert sorted(journal.read_bytes().splitlines()) == sorted(content.splitlines())


def search_quietly(arguments):
    """Search, and say nothing: it stands for another process."""
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    main(arguments)


def test_a_search_killed_at_any_moment_goes_on_to_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = ["search", "--workspace", "obstacles", "--tasks", "4", "--seed", "3"]
    arguments += BRIEF
    lines = []
    append = Journal.append
    with monkeypatch.context() as patch:
        patch.setattr(Journal, "append", lambda *a: lines.append(a) or append(*a))
        assert main([*arguments, "--jobs", "1", "--out", "whole/table.csv"]) == 0

    journal = tmp_path / "half" / ".table.csv.partial"
    arguments += ["--out", "half/table.csv"]
    rng = np.random.default_rng(0)
    moments = np.sort(rng.choice(np.arange(1, len(lines) - 2), 2, replace=False))
    for moment in moments:
        process = multiprocessing.get_context("fork").Process(
            target=search_quietly, args=([*arguments, "--jobs", "1"],)
        )
        process.start()
        while process.is_alive():
            if journal.is_file() and journal.read_bytes().count(b"\n") > moment:
                time.sleep(rng.uniform(0, 0.05))
                process.kill()
            time.sleep(0.005)
        assert process.exitcode == -9, "it was done before it could be killed"
        assert not (tmp_path / "half" / "table.csv").exists()

    assert main([*arguments, "--jobs", "1"]) == 0
    files = {one.name for one in (tmp_path / "half").iterdir()}
    assert files == {"table.csv", "datapackage.json"}
    for name in files:
        whole = (tmp_path / "whole" / name).read_bytes()
        assert (tmp_path / "half" / name).read_bytes() == whole
