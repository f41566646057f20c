from dataclasses import replace

import numpy as np
import pytest

from msc import DMP, Arm, SearchResult, Workspace
from msc.robot import TIME_STEP, Circle, clearance, forward_kinematics, random_circles
from msc.search import SearchOptions
from msc.study import _calibration as calibration
from msc.study import choose_layout, locate_cut


@pytest.mark.parametrize(("tie", "cut"), [(70.2, 70.5), (70.4, 70.5), (70.6, 71.0)])
def test_the_cut_is_where_both_sides_cost_the_same(tie, cut, monkeypatch):
    def search(world, angle, *, seed, options, n_starts=4, start_policies=()):
        assert world.cut_deg == 0
        side = start_policies[0] if start_policies else np.sign(angle - 45)
        cost = 10 - side * (angle - tie) / 100
        return SearchResult(angle, side, cost, 0.0, 0.0, 0.0, ())

    monkeypatch.setattr(calibration, "search_policy", search)
    found, told = locate_cut(), locate_cut(options=SearchOptions(near=0.1))
    assert told == {**found, "options": ["near=0.1"]}
    assert found["tie_deg"] == pytest.approx(tie)
    assert found["cut_deg"] == cut
    angles = np.array(found["world_angle_deg"])
    np.testing.assert_allclose(found["cost_from_below"], 10 + (angles - tie) / 100)
    np.testing.assert_allclose(found["cost_from_above"], 10 - (angles - tie) / 100)


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_layout_is_the_first_whose_tasks_are_reached_and_jump(jobs, monkeypatch):
    fits = [False, False, True, True]

    def look_at(layout, n_tasks, seed, options):
        assert (n_tasks, seed, options) == (72, 4, SearchOptions())
        return {"layout": layout, "fit": fits[layout]}

    monkeypatch.setattr(calibration, "_look_at", look_at)
    monkeypatch.setattr(calibration, "call_in_order", starcall)
    found = choose_layout(seed=4, jobs=jobs)
    assert found["chosen"] == 2
    assert [one["layout"] for one in found["layouts"]] == [0, 1, 2]


def starcall(function, calls, **_):
    """Do what workers would, in this process."""
    return [function(*arguments) for arguments in calls]


def test_a_look_at_a_layout_says_what_it_found():
    once = SearchOptions(max_evaluations=9)
    found = calibration._look_at(3, n_tasks=6, seed=0, options=once)
    assert found == calibration._look_at(3, n_tasks=6, seed=0, options=once)
    assert found["circles"] == [list(circle) for circle in random_circles(3)]
    assert set(found["jumps_after_deg"]) <= set(range(0, 360, 60))
    assert found["fit"] == (
        found["largest_distance_m"] < calibration.MAX_DISTANCE
        and found["largest_depth_m"] < calibration.MAX_DEPTH
        and len(found["jumps_after_deg"]) >= calibration.MIN_JUMPS
    )


def test_the_planned_cost_is_that_of_an_arm_that_does_what_is_planned():
    world, policies = Workspace.free(), np.random.default_rng(0).normal(size=(9, 6))
    with Arm(world) as arm:
        plans = arm.plan(policies, np.tile(world.target(200), (9, 1)))
    ends = forward_kinematics(plans[:, -1], world.link_lengths)[:, -1]
    missed = np.hypot(*(ends - world.target(200)).T)
    energy = np.sum(np.diff(plans, axis=1) ** 2, axis=(1, 2)) / TIME_STEP
    walled = replace(world, circles=(Circle(0.0, 0.8, 0.05),))
    np.testing.assert_allclose(
        calibration._planned_cost(walled, DMP(), 200)(policies),
        100 * missed**2 + 0.005 * energy,
        rtol=0.01,
    )


def test_entering_an_obstacle_costs_the_depth_and_the_time():
    free, policies = Workspace.free(), np.zeros((1, 6))
    walled = replace(free, circles=(Circle(-0.5, 0.2, 0.05),))
    joints, _, depth = calibration._plan_joints(
        walled, DMP(), policies, np.array([90.0])
    )
    gaps = (
        clearance(forward_kinematics(joints, free.link_lengths), walled.circles[0])
        - 0.05
    )
    np.testing.assert_allclose(depth, np.maximum(0, -gaps))
    assert depth.max() > 0.05
    outside = replace(free, circles=(Circle(0.0, 0.8, 0.05),))
    extra = np.subtract(
        calibration._planned_cost(walled, DMP(), 90)(policies),
        calibration._planned_cost(outside, DMP(), 90)(policies),
    )
    assert extra == pytest.approx(calibration.DEPTH_WEIGHT * depth.sum() / 60)
