"""What arms do in layouts: kept as it was found, and found again the same."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msc import Workspace
from msc.robot import forward_kinematics, read_world
from msc.study import METHODS
from msc.worlds import locate_moves, move_world, unpack_joints
from msc.worlds._moves import MOVED, TICK, pack_joints
from msc.worlds._study import load_world

ROOT = Path(__file__).parents[1]
FOLDER, KEPT = ROOT / "data" / "worlds", ROOT / "data" / "results" / "worlds"
LAYOUTS = [f"layout{number:02}" for number in range(1, 25)]
WORLD = "layout07"


def kept(name):
    return json.loads((KEPT / f"moves_{name}.json").read_text("utf-8"))


def test_one_layout_is_found_again_to_the_bit():
    call, _ = load_world(FOLDER, WORLD, "")
    before = kept(WORLD)
    found = json.loads(json.dumps(move_world(*call, seed=before["seed"])))
    assert found == {key: before[key] for key in found}


def test_all_layouts_are_kept_and_rest_on_their_tables(tmp_path):
    assert locate_moves(FOLDER, KEPT, LAYOUTS) == []
    assert locate_moves(FOLDER, tmp_path, ["arm1", "priced01"]) == []
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("name", LAYOUTS[::6])
def test_movements_end_as_far_from_their_goals_as_is_told(name):
    world, told = read_world(FOLDER / f"{name}.toml"), kept(name)
    goals = world.target(told["task_deg"])
    for of in told["methods"].values():
        joints = unpack_joints(of["joints"], world, len(goals))
        ends = forward_kinematics(joints[:, -1], world.link_lengths)[:, -1]
        left = 100 * np.linalg.norm(ends - goals, axis=1)
        np.testing.assert_allclose(left, of["error_cm"], atol=0.042)


@pytest.mark.parametrize("name", LAYOUTS[::6])
def test_what_is_trained_on_is_not_tested_on(name):
    told = kept(name)
    assert np.diff(told["trained_deg"]) == pytest.approx(15)
    assert not {*told["trained_deg"]} & {*told["task_deg"]}
    assert [*told["methods"]] == ["searched", *MOVED]
    assert {*MOVED} <= {*METHODS}


@given(st.integers(0, 2**32 - 1))
def test_poses_are_read_as_they_were_written(seed):
    world, rng = Workspace.free(), np.random.default_rng(seed)
    joints = rng.uniform(-13, 13, size=(4, 67, 3))
    joints[:, 0] = world.home
    found = unpack_joints(pack_joints(joints), world, 4)
    np.testing.assert_allclose(found, joints[:, ::6], atol=0.501 * TICK)
    np.testing.assert_array_equal(found[:, 0], joints[:, 0])
