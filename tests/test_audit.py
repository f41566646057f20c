from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import msc.study._audit
from msc import SearchResult, Workspace, load_dataset
from msc._parallel import call_in_order
from msc.data import Dataset, find_data, save_table
from msc.plots import jump_table, quality_table
from msc.search import SearchOptions, SweepPlan, grid, search_tasks
from msc.study import audit_table
from msc.study._audit import _bisect, _bisect_jumps, _find_workspace

free = Workspace.free()
brief = SearchOptions(max_evaluations=18)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A table of four tasks, searched as little as can be."""
    path = tmp_path_factory.mktemp("data") / "free.csv"
    least = replace(brief, max_sweeps=0)
    plan = SweepPlan(free, grid(4), seed=0, n_starts=1, options=least)
    found = search_tasks(plan)
    save_table(found, path, command="msc search", seed=0)
    return path


@pytest.fixture
def searches(monkeypatch):
    """Stand in for the search: policies from a function of the task, costs given."""

    def install(policy, cost=1.0):
        def search(workspace, task_deg, **options):
            found = np.asarray(policy(task_deg), dtype=float)
            return SearchResult(task_deg, found, cost, 0.0, 0.0, 0.0, ())

        install_search(monkeypatch, search)
        return search

    return install


def install_search(monkeypatch, search):
    """Have audits search so, tasks alone and together."""

    def several(workspace, tasks_deg, **options):
        return [search(workspace, task, **options) for task in tasks_deg]

    monkeypatch.setattr(msc.study._audit, "search_policy", search)
    monkeypatch.setattr(msc.study._audit, "search_policies", several)


# Executed again


def test_stored_distances_come_back_to_the_last_bit(table, searches):
    searches(lambda _: np.zeros(6))
    executed = audit_table(table, n_sample=1)["executed"]
    assert executed == {"identical": 4, "largest_difference_m": 0.0}


def test_a_policy_that_was_tampered_with_is_noticed(table, tmp_path, searches):
    searches(lambda _: np.zeros(6))
    text = table.read_text("utf-8").splitlines()
    values = text[1].split(",")
    values[1] = str(float(values[1]) + 0.01)
    other = tmp_path / "free.csv"
    other.write_text("\n".join([text[0], ",".join(values), *text[2:]]) + "\n", "utf-8")
    executed = audit_table(other, "free", n_sample=1)["executed"]
    assert executed["identical"] == 3
    assert executed["largest_difference_m"] > 1e-6


def test_a_table_may_be_named(table, searches, monkeypatch):
    searches(lambda _: np.zeros(6))
    monkeypatch.setattr("msc.data._tables.find_data", lambda: table.parent)
    assert audit_table(Path("free"), n_sample=1) == audit_table(table, n_sample=1)


# Searched again


def test_a_poor_table_is_found_out(table):
    longer = SearchOptions(max_evaluations=45, max_sweeps=0)
    searched = audit_table(table, n_sample=2, options=longer)["searched"]
    assert searched["n_cheaper"] == 2
    assert max(searched["change_of_cost"]) < -0.005


@pytest.mark.parametrize(("cost", "n_cheaper"), [(0.0, 4), (1e9, 0)])
def test_costs_are_compared_with_the_stored_ones(table, searches, cost, n_cheaper):
    searches(lambda _: np.zeros(6), cost)
    assert audit_table(table, n_sample=4)["searched"]["n_cheaper"] == n_cheaper


def test_the_sample_is_drawn_with_the_seed(table, searches):
    searches(lambda _: np.zeros(6))
    samples = {
        tuple(audit_table(table, n_sample=2, seed=seed)["searched"]["task_deg"])
        for seed in range(1, 5)
    }
    assert len(samples) > 1


# Jumps


def test_a_jump_stays_a_jump(searches):
    search = searches(lambda task: np.where(task < 40.3, 0.0, 9.0) * np.ones(6))
    found = _bisect(search, free, (40.0, 41.0), (np.zeros(6), 9 * np.ones(6)))
    assert found["is_jump"]
    low, high = found["located_deg"]
    assert low < 40.3 <= high
    assert high - low == 1 / 8
    assert found["step_sizes"] == pytest.approx([9 * 6**0.5] * 4)


def test_a_steep_slope_is_no_jump(searches):
    search = searches(lambda task: (task - 40) * 9 * np.ones(6))
    found = _bisect(search, free, (40.0, 41.0), (np.zeros(6), 9 * np.ones(6)))
    assert not found["is_jump"]
    assert found["located_deg"] == [40.0, 41.0]


def test_the_closed_circle_is_looked_at(searches):
    search = searches(lambda task: (task % 360) * np.ones(6))
    table = pd.DataFrame({"task_deg": np.arange(0.0, 360.0, 10.0)})
    policies = table.to_numpy() * np.ones(6)
    circle = Dataset(np.deg2rad(table.to_numpy()), policies, table)
    call = partial(call_in_order, jobs=1)
    (found,) = _bisect_jumps(free, circle, search, call)
    assert found["between_deg"] == [350.0, 360.0]
    assert found["is_jump"]


# Read again


def test_an_audit_is_summarised(table, searches):
    searches(lambda _: np.zeros(6), 0.0)
    audit = audit_table(table, n_sample=3)
    summary = quality_table(audit)["free.csv"]
    assert summary["policies"] == 4
    assert summary["searched again"] == 3
    assert summary["cheaper by more than 0.5 %"] == 3
    assert summary["largest gain (%)"] == 100
    assert len(jump_table(audit)) == summary["large steps, the cut's included"]


# Bad input


@pytest.mark.parametrize("n_sample", [0, 5])
def test_a_sample_larger_than_the_table_is_refused(table, n_sample):
    with pytest.raises(ValueError, match=f"sample={n_sample}; wanted from 1 to 4"):
        audit_table(table, n_sample=n_sample)


def test_options_are_heeded_and_told(table, searches, monkeypatch):
    search, asked = searches(lambda _: np.zeros(6)), []

    def note(*arguments, **more):
        asked.append(more["options"])
        return search(*arguments)

    install_search(monkeypatch, note)
    command = audit_table(table, n_sample=2, options=brief)["provenance"]["command"]
    assert command.endswith(" --seed 1 --set max_evaluations=18")
    assert len(asked) >= 2
    assert set(asked) == {brief}
    plain = audit_table(table, n_sample=2)["provenance"]["command"]
    assert plain == "msc audit data/free.csv --sample 2 --seed 1"


def test_the_seed_of_the_table_is_refused(table):
    with pytest.raises(ValueError, match="seed=0 made this table"):
        audit_table(table, seed=0, n_sample=1)


# The workspace


@pytest.fixture
def saved(table, searches):
    """Save the table in a folder with a name and a command; return what audits say."""
    searches(lambda _: np.zeros(6))

    def save(path, command, given=None, **extra):
        save_table(load_dataset(table)[2], path, command=command, seed=0, **extra)
        return audit_table(path, given, n_sample=1)

    return save


@pytest.mark.parametrize(
    ("command", "extra", "world"),
    [
        ("msc search --workspace obstacles --tasks 4", {}, "obstacles"),
        ("msc search --tasks 4 --workspace=obstacles", {}, "obstacles"),
        ("msc search --workspace free --out data/obstacles.csv", {}, "free"),
        ("msc search --tasks 4 --out data/obstacles.csv", {}, "free"),
        ("python mine.py", {"workspace": "obstacles"}, "obstacles"),
    ],
)
def test_the_workspace_is_the_package_s_whatever_the_name(
    command, extra, world, saved, tmp_path
):
    for name in ("obstacles_test.csv", "elsewhere.csv"):
        found = saved(tmp_path / name, command, **extra)
        assert found["workspace"] == world
        assert "--workspace" not in found["provenance"]["command"]
    assert saved(tmp_path / "mine.csv", command, world, **extra)["workspace"] == world


def test_another_workspace_than_the_package_s_is_refused(saved, tmp_path):
    asked = r"workspace='free', but the data package beside a\.csv says 'obstacles'"
    with pytest.raises(ValueError, match=asked):
        saved(tmp_path / "a.csv", "msc search --workspace obstacles", "free")


@pytest.mark.parametrize("command", ["python mine.py --workspace free", "", "msc"])
def test_a_workspace_that_nothing_tells_is_asked_for(command, saved, tmp_path):
    path = tmp_path / "free.csv"
    with pytest.raises(ValueError, match=r"free\.csv: no data package .*--workspace"):
        saved(path, command)
    path.with_name("datapackage.json").unlink()
    with pytest.raises(ValueError, match=r"free\.csv: no data package .*--workspace"):
        audit_table(path, n_sample=1)
    found = audit_table(path, "obstacles", n_sample=1)
    assert found["workspace"] == "obstacles"
    assert found["provenance"]["command"].endswith(" --workspace obstacles")


def test_a_workspace_that_is_unknown_is_refused(saved, tmp_path):
    with pytest.raises(ValueError, match="workspace='elsewhere' is unknown"):
        saved(tmp_path / "free.csv", "msc search --workspace elsewhere")


def test_the_tables_of_the_repository_tell_their_workspaces():
    for name in ("free", "free_test", "obstacles", "obstacles_test"):
        path = find_data() / f"{name}.csv"
        assert _find_workspace(path, None) == name.removesuffix("_test")
