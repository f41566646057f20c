import json
import shutil
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import msc.dataset
import msc.journal
import msc.search
from msc.dataset import Plan, grid, search_tasks, take_evenly
from msc.journal import Journal
from msc.search import SearchResult, Start
from msc.tables import COLUMNS
from msc.workspace import Workspace

plan = Plan(Workspace.free(), grid(4), seed=0, n_starts=1)


def in_short(patch):
    """Cut the searches short, and the consistency pass after each task's turn."""
    patch.setattr(msc.search, "MAX_EVALUATIONS", 9)
    patch.setattr(msc.dataset, "MAX_SWEEPS", 1)


@pytest.fixture
def short(monkeypatch):
    in_short(monkeypatch)


@pytest.fixture(scope="module")
def whole():
    with pytest.MonkeyPatch.context() as patch:
        in_short(patch)
        return to_csv(search_tasks(plan))


def to_csv(table):
    return table.to_csv(index=False)


def search_in_short(*arguments, really=msc.dataset._search):
    """Search a task, in whatever process."""
    with pytest.MonkeyPatch.context() as patch:
        in_short(patch)
        return really(*arguments)


# Tasks


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


@given(st.integers(2, 72))
def test_samples_are_the_nearest_grid_tasks(n_samples):
    tasks = np.deg2rad(grid(72))
    chosen = take_evenly(tasks, n_samples)
    assert (np.diff(chosen) > 0).all()
    wanted = 360 * np.arange(n_samples) / n_samples
    assert abs(np.rad2deg(tasks[chosen]) - wanted).max() <= 2.5 + 1e-9


@pytest.mark.parametrize("n_samples", [1, -2, 12.0, "12", None])
def test_a_number_of_samples_that_is_none_is_refused(n_samples):
    with pytest.raises(ValueError, match=r"n_samples=.*; wanted a whole number"):
        take_evenly(np.deg2rad(grid(72)), n_samples)


def test_more_samples_than_tasks_are_refused():
    with pytest.raises(ValueError, match=r"n_samples=73 .* wanted at most 72"):
        take_evenly(np.deg2rad(grid(72)), 73)


# The search of many tasks


def test_a_table_has_one_row_a_task(whole, short):
    table = search_tasks(plan)
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


def test_two_workers_find_what_one_finds(whole, short, monkeypatch):
    monkeypatch.setattr(msc.dataset, "_search", search_in_short)
    assert to_csv(search_tasks(plan, jobs=2)) == whole


def test_a_task_s_own_search_does_not_depend_on_the_others(short):
    alone = msc.search.search_policy(plan.workspace, 90, seed=0, n_starts=1)
    table = search_tasks(plan)
    assert table["cost"][1] <= alone.cost


# The consistency pass, with a made-up search in place of the arm


def made_up_search(depths):
    """Make a search that stays in the basin it starts in, or goes to the task's own.

    The basin is the policy's first weight, `depths` the costs: one row a task, one
    column a basin. The number of calls is kept with each task.
    """
    calls = []

    def search(world, task, *, seed, n_starts, start_policies, incumbent):
        k = round(task) // 90
        calls.append(k)
        basins = [int(policy[0]) for policy in start_policies]
        found = [(f"given {i}", basin) for i, basin in enumerate(basins)]
        starts = list(incumbent.starts) if incumbent else []
        for name, basin in [("start 0", k % depths.shape[1])] * n_starts + found:
            policy = np.r_[float(basin), 1.0, np.zeros(4)]
            starts.append(Start(name, policy, float(depths[k, basin]), 9))
        best = min(starts, key=lambda start: start.cost)
        return SearchResult(best.policy, best.cost, 0.0, 0.0, 0.0, tuple(starts))

    search.calls = calls
    return search


@settings(max_examples=30, deadline=None)
@given(st.permutations(range(4)), st.integers(0, 100))
def test_the_best_behaviour_spreads_to_all_and_costs_only_fall(order, seed):
    depths = np.random.default_rng(seed).uniform(1, 2, size=(4, 4))
    depths[:, order[0]] -= 1
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.dataset, "search_policy", made_up_search(depths))
        table = search_tasks(plan)
    assert (table["weight_x1"] == order[0]).all()
    np.testing.assert_array_equal(table["cost"], depths[:, order[0]])


def test_the_pass_rests_when_nothing_spreads(monkeypatch):
    search = made_up_search(np.ones((4, 1)))
    monkeypatch.setattr(msc.dataset, "search_policy", search)
    search_tasks(plan)
    assert sorted(search.calls) == sorted([0, 1, 2, 3] * 2)


def test_a_winner_from_next_door_is_named_so(monkeypatch):
    depths = np.array([[1, 9, 9, 9], [1, 2, 9, 9], [9, 9, 1, 9], [1, 9, 9, 2]])
    monkeypatch.setattr(msc.dataset, "search_policy", made_up_search(depths))
    winners = search_tasks(plan)["winner"].tolist()
    assert winners == ["start 0", "task before", "start 0", "task after"]


def test_guides_on_either_side_are_neighbours_too(monkeypatch):
    depths = np.array([[9, 1], [1, 9], [1, 9], [9, 9.0]])
    guide = ((300.0, (1.0, 1, 0, 0, 0, 0)), (60.0, (1.0, 1, 0, 0, 0, 0)))
    search = made_up_search(depths)
    monkeypatch.setattr(msc.dataset, "search_policy", search)
    table = search_tasks(replace(plan, tasks_deg=(0.0, 180.0), guide=guide))
    assert table["winner"][0] == "guide before"
    before, after = msc.dataset._nearest_guides(
        replace(plan, guide=((10.0, (1.0,)), (200.0, (2.0,)), (350.0, (3.0,)))), 5.0
    )
    assert (before.tolist(), after.tolist()) == ([3.0], [1.0])


# Interrupted and gone on with


@pytest.mark.parametrize("n_done", [1, 4, 6])
def test_an_interrupted_search_ends_alike(n_done, whole, short, tmp_path, monkeypatch):
    journal = tmp_path / "journal"
    really, calls = msc.dataset.search_policy, []

    def search(*arguments, **options):
        calls.append(arguments)
        if len(calls) == n_done + 1:
            raise KeyboardInterrupt
        return really(*arguments, **options)

    monkeypatch.setattr(msc.dataset, "search_policy", search)
    with pytest.raises(KeyboardInterrupt):
        search_tasks(plan, journal=journal)
    assert len(journal.read_text().splitlines()) == 1 + n_done
    assert to_csv(search_tasks(plan, journal=journal)) == whole
    n_searches = len(calls) - 1
    assert len(journal.read_text().splitlines()) == 1 + n_searches


def test_a_finished_journal_is_all_it_takes(whole, short, tmp_path, monkeypatch):
    search_tasks(plan, journal=tmp_path / "journal")
    monkeypatch.setattr(msc.dataset, "search_policy", None)
    assert to_csv(search_tasks(plan, journal=tmp_path / "journal")) == whole


def test_a_torn_journal_ends_alike(whole, short, tmp_path):
    journal = tmp_path / "journal"
    search_tasks(plan, journal=journal)
    content = journal.read_bytes()
    for torn in (len(content) // 2, len(content) - 1):
        journal.write_bytes(content[:torn])
        assert to_csv(search_tasks(plan, journal=journal)) == whole
        assert sorted(journal.read_bytes().splitlines()) == sorted(content.splitlines())


# The journal


def result(seed=0):
    rng = np.random.default_rng(seed)
    starts = tuple(
        Start(f"start {k}", rng.normal(size=6), float(rng.normal()), 9 * k, "start 0")
        for k in range(2)
    )
    return SearchResult(starts[0].policy, *rng.normal(size=4).tolist(), starts)


def bits(result):
    *numbers, starts = astuple(result)
    return [np.asarray(value).tobytes() for value in numbers], repr(starts)


def test_results_come_back_bit_for_bit(tmp_path):
    path = tmp_path / "new" / "journal"
    first = Journal(path, plan)
    for k in range(3):
        first.append("search", k, result(k))
    again = Journal(path, plan)
    assert list(again.results) == [("search", k) for k in range(3)]
    for k in range(3):
        assert bits(again.results["search", k]) == bits(result(k))


@pytest.mark.parametrize("end", [-1, -60, 20])
def test_a_torn_line_is_dropped(end, tmp_path):
    path = tmp_path / "journal"
    first = Journal(path, plan)
    for k in range(2):
        first.append("search", k, result(k))
    last = path.read_bytes().splitlines(keepends=True)[-1]
    path.write_bytes(path.read_bytes().removesuffix(last) + last[:end])
    again = Journal(path, plan)
    assert list(again.results) == [("search", 0)]
    again.append("search", 1, result(1))
    assert len(Journal(path, plan).results) == 2


@pytest.mark.parametrize("end", [0, 20, -1])
def test_a_torn_first_line_is_begun_anew(end, tmp_path):
    path = tmp_path / "journal"
    Journal(path, plan)
    path.write_bytes(path.read_bytes()[:end])
    Journal(path, plan).append("search", 0, result())
    assert len(Journal(path, plan).results) == 1


@pytest.mark.parametrize(
    "other",
    [
        replace(plan, seed=1),
        replace(plan, n_starts=2),
        replace(plan, tasks_deg=grid(5)),
        replace(plan, workspace=Workspace(cut_deg=70.0)),
        replace(plan, guide=((0.0, (0.0,) * 6),)),
    ],
)
def test_another_plan_is_begun_anew(other, tmp_path):
    path = tmp_path / "journal"
    Journal(path, plan).append("search", 0, result())
    assert not Journal(path, other).results
    assert not Journal(path, plan).results


def test_other_code_is_begun_anew(tmp_path, monkeypatch):
    path, package = tmp_path / "journal", tmp_path / "msc"
    Journal(path, plan).append("search", 0, result())
    shutil.copytree(Path(msc.journal.__file__).parent, package)
    monkeypatch.setattr(msc.journal, "__file__", str(package / "journal.py"))
    assert Journal(path, plan).results
    with (package / "bullet.py").open("a") as file:
        file.write("# changed\n")
    assert not Journal(path, plan).results


def test_without_a_file_nothing_is_kept_on_disk(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    journal = Journal(None, plan)
    journal.append("search", 0, result())
    assert bits(journal.results["search", 0]) == bits(result())
    assert not list(tmp_path.iterdir())


def test_each_line_is_json(tmp_path):
    path = tmp_path / "journal"
    Journal(path, plan).append("sweep 1", 3, result())
    header, entry = map(json.loads, path.read_text().splitlines())
    assert list(header) == ["plan"]
    assert (entry["phase"], entry["k"]) == ("sweep 1", 3)
    assert entry["result"]["policy"] == result().policy.tolist()
