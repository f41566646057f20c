"""Stored movements that are stopped elsewhere, after Soni and Singh."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone

from msc import DMP, Arm, Workspace, load_dataset
from msc.robot import TIME_STEP, forward_kinematics
from msc.study.rivals import StoppedMovement

world = Workspace.free()
start = forward_kinematics(world.home, world.link_lengths)[-1]
times = TIME_STEP * np.arange(61)
tasks, policies, _ = load_dataset("free")
chosen = slice(None, None, 15)
tasks, policies = tasks[chosen], policies[chosen]
new = np.linspace(0.05, 6.2, 40)[:, None]


def goals(X):
    return world.target(np.rad2deg(X[:, 0]))


@pytest.fixture(scope="module")
def option():
    return StoppedMovement().fit(tasks, policies)


def test_no_stored_movement_comes_nearer_at_any_time(option):
    stored = DMP().path(policies, start, goals(tasks), times)
    nearest = np.linalg.norm(option.path(new)[:, -1] - goals(new), axis=1)
    for goal, gap in zip(goals(new), nearest, strict=True):
        apart = [np.hypot(*(place - goal)) for path in stored for place in path]
        assert min(apart) == pytest.approx(gap, abs=1e-12)


def test_it_is_the_stored_movement_to_the_stop_and_stands_still_then(option):
    movement, step = option.choose(new)
    assert len({*step}) > 3
    for path, i, stop in zip(option.path(new), movement, step, strict=True):
        own = DMP().path(policies[i], start, goals(tasks)[i], times)
        np.testing.assert_array_equal(path[: stop + 1], own[: stop + 1])
        np.testing.assert_array_equal(path[stop:], np.tile(own[stop], (61 - stop, 1)))


def test_a_straight_movement_stops_at_the_foot_of_the_perpendicular():
    through = np.array([[np.deg2rad(300.0)]])
    option = StoppedMovement().fit(through, np.zeros((1, 6)))  # the spring alone
    along = goals(through)[0] - start
    aside = goals(new) - start
    foot = np.clip(aside @ along / (along @ along), 0, None)[:, None] * along + start
    end = option.movements_[0, -1]
    inside = np.linalg.norm(foot - start, axis=1) < np.linalg.norm(end - start)
    assert 3 < inside.sum() < 40
    step = np.linalg.norm(np.diff(option.movements_[0], axis=0), axis=1).max()
    stops = option.path(new)[:, -1]
    assert np.linalg.norm(stops - foot, axis=1)[inside].max() <= step / 2 + 1e-9
    np.testing.assert_allclose(stops[~inside], np.tile(end, (sum(~inside), 1)))


def test_an_arm_that_follows_it_stops_where_it_says(option):
    chosen = new[::8]
    with Arm(world) as arm:
        rollouts = arm.follow(option.plan(chosen), np.rad2deg(chosen[:, 0]))
    ends = np.array([rollout.path[-1] for rollout in rollouts])
    np.testing.assert_allclose(ends, option.path(chosen)[:, -1], atol=0.01)
    missed = np.linalg.norm(option.path(chosen)[:, -1] - goals(chosen), axis=1)
    assert [one.error for one in rollouts] == pytest.approx(missed, abs=0.01)


def test_a_learned_goal_is_reached_by_its_own_movement_or_nearer(option):
    own = DMP().path(policies, start, goals(tasks), times)[:, -1]
    missed = np.linalg.norm(own - goals(tasks), axis=1)
    found = np.linalg.norm(option.path(tasks)[:, -1] - goals(tasks), axis=1)
    assert (found <= missed + 1e-12).all()


def test_the_plan_has_the_form_of_an_arm_s_and_ends_at_the_stop(option):
    plan = option.plan(new)
    with Arm(world) as arm:
        own = arm.plan(policies, goals(tasks))
    assert plan.shape[1:] == own.shape[1:]
    np.testing.assert_array_equal(plan[:, -7:], plan[:, [-7]].repeat(7, axis=1))
    tip = forward_kinematics(plan[:, -1], world.link_lengths)[:, -1]
    np.testing.assert_allclose(tip, option.path(new)[:, -1], atol=2e-3)
    movement, step = option.choose(tasks)
    whole = (step == 60) & (movement == np.arange(len(tasks)))
    assert whole.any()
    np.testing.assert_allclose(option.plan(tasks)[whole], own[whole], atol=1e-12)


def test_a_whole_movement_is_a_policy_of_another_goal_too():
    """As the docstring says: the spring's pull is a force like the basis'."""
    one, other = goals(new)[[3, 30]]
    ratio = np.repeat((one - start) / (other - start), 3)
    moved = ratio * (DMP().spring + policies[2]) - DMP().spring
    own = DMP().path(policies[2], start, one, times)
    np.testing.assert_allclose(DMP().path(moved, start, other, times), own, atol=1e-9)


def test_another_world_has_other_goals():
    turned = Workspace(cut_deg=159.5)  # by 90 degrees
    option = StoppedMovement(turned).fit(tasks, policies)
    at = turned.target(np.rad2deg(tasks[:, 0]))
    expected = DMP().path(policies, start, at, times)
    np.testing.assert_array_equal(option.movements_, expected)


def test_manners(option):
    assert clone(option).get_params() == {"workspace": None, "dmp": None}
    again = pickle.loads(pickle.dumps(option))
    np.testing.assert_array_equal(again.path(new), option.path(new))


def test_bad_input(option):
    with pytest.raises(TypeError, match="workspace='free'; wanted a Workspace"):
        StoppedMovement("free").fit(tasks, policies)
    with pytest.raises(TypeError, match="dmp=3; wanted a DMP"):
        StoppedMovement(dmp=3).fit(tasks, policies)
    with pytest.raises(ValueError, match=r"X has shape \(24, 2\).*wanted \(n_tasks, 1"):
        StoppedMovement().fit(np.c_[tasks, tasks], policies)
    with pytest.raises(ValueError, match=r"y \(24, 5\); wanted .*\(n_tasks, 6\)"):
        StoppedMovement().fit(tasks, policies[:, :5])
    with pytest.raises(ValueError, match="X has 2 features, but StoppedMovement is"):
        option.choose([[0.0, 1.0]])
