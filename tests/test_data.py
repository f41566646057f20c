"""The committed tables: what they say they are, and what their policies do."""

import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from msc import Arm, Workspace, find_jumps, load_dataset
from msc.search import cost

ROOT = Path(__file__).parents[1]
NAMES = ("free", "obstacles", "free_test", "obstacles_test")

every_table = pytest.mark.parametrize("name", NAMES)
every_world = pytest.mark.parametrize("world", ["free", "obstacles"])


@pytest.fixture(autouse=True)
def here(monkeypatch):
    monkeypatch.chdir(ROOT)


def described(name):
    package = json.loads(Path("data/datapackage.json").read_text("utf-8"))
    return {one["path"]: one for one in package["resources"]}[f"{name}.csv"]


def option(name, option):
    """Read an option of the command that made a table."""
    found = re.search(rf"--{option} (\S+)", described(name)["command"])
    return found and found[1]


@every_table
def test_the_checksum_is_that_of_the_file(name):
    content = Path(f"data/{name}.csv").read_bytes()
    assert described(name)["hash"] == f"sha256:{hashlib.sha256(content).hexdigest()}"
    assert described(name)["bytes"] == len(content)


@every_table
def test_the_schema_describes_every_column(name):
    fields = described(name)["schema"]["fields"]
    table = pd.read_csv(f"data/{name}.csv")
    assert [field["name"] for field in fields] == list(table.columns)
    kinds = {"number": "f", "integer": "i", "string": "OTU"}
    for field in fields:
        assert field["description"]
        assert table[field["name"]].dtype.kind in kinds[field["type"]]


@every_table
def test_the_command_and_the_seed_are_told(name):
    command = described(name)["command"]
    world = name.removesuffix("_test")
    assert command.startswith(f"msc search --workspace {world} ")
    assert option(name, "out") == f"data/{name}.csv"
    assert option(name, "seed") == str(described(name)["seed"])
    assert (load_dataset(name)[2]["seed"] == described(name)["seed"]).all()
    assert {"python", "numpy", "pybullet", "cma"} <= set(described(name)["versions"])


def test_nothing_tells_where_it_was_made():
    text = Path("data/datapackage.json").read_text("utf-8")
    assert not re.search(r"(^|[\s\"'=])(/|~|[A-Z]:\\)", text)


@every_table
def test_the_tasks_are_those_asked_for(name):
    tasks, policies, _ = found = load_dataset(name)
    n_tasks, offset = int(option(name, "tasks")), float(option(name, "offset"))
    assert len(found.table) == n_tasks
    assert policies.shape == (n_tasks, 6)
    wanted = offset + 360 * np.arange(n_tasks) / n_tasks
    np.testing.assert_allclose(found.task_deg, wanted, rtol=1e-12)
    np.testing.assert_array_equal(tasks[:, 0], np.deg2rad(found.task_deg))
    np.testing.assert_array_equal(found.task_deg, found.table["task_deg"])


@every_world
def test_test_tasks_are_off_the_grid(world):
    grid, off = (load_dataset(name)[0] for name in (world, f"{world}_test"))
    step = 2 * np.pi / len(grid)
    assert abs(grid - off.T).min() > 0.2 * step


@every_table
def test_every_target_is_reached(name):
    assert load_dataset(name)[2]["distance_m"].max() < 0.01


@every_table
def test_the_cost_is_the_sum_of_its_terms(name):
    table = load_dataset(name)[2]
    terms = 100 * table["distance_m"] ** 2, 0.005 * table["energy_rad2_per_s"]
    np.testing.assert_allclose(table["cost_distance"], terms[0], rtol=1e-12)
    np.testing.assert_allclose(table["cost_energy"], terms[1], rtol=1e-12)
    np.testing.assert_allclose(table["cost"], sum(terms), rtol=1e-12)


@every_table
def test_a_policy_executed_again_does_what_the_table_says(name):
    _, policies, table = load_dataset(name)
    some = table[::4]
    with Arm(Workspace.named(name.removesuffix("_test"))) as arm:
        rollouts = arm.execute_many(policies[::4], some["task_deg"].tolist())
    for rollout, (_, row) in zip(rollouts, some.iterrows(), strict=True):
        assert rollout.error == pytest.approx(row["distance_m"], abs=1e-9)
        assert rollout.energy == pytest.approx(row["energy_rad2_per_s"], rel=1e-9)
        assert cost(rollout) == pytest.approx(row["cost"], rel=1e-9)
        impulse = row["contact_impulse_n_s"]
        assert rollout.contact_impulse == pytest.approx(impulse, rel=1e-9)


def test_only_obstacles_are_touched():
    for name in ("free", "free_test"):
        assert not load_dataset(name)[2]["contact_impulse_n_s"].any()


def test_the_free_manifold_is_whole_and_obstacles_break_it():
    free, obstacles = (load_dataset(world)[:2] for world in ("free", "obstacles"))
    assert find_jumps(*free).size == 0
    assert find_jumps(*obstacles).size >= 3


def test_without_a_policy_the_arm_misses_and_with_the_searched_ones_it_does_not():
    _, policies, table = load_dataset("free")
    policies, tasks = policies[::6], table["task_deg"][::6].tolist()
    with Arm(Workspace.free()) as arm:
        missed = [
            np.mean([rollout.error for rollout in arm.execute_many(tried, tasks)])
            for tried in (np.zeros_like(policies), policies)
        ]
    assert missed[0] > 0.02
    assert missed[1] < 0.003
