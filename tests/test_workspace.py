import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc import Workspace
from msc.robot import LINK_RADIUS, Circle, forward_kinematics
from msc.robot import random_circles as draw
from msc.robot._workspace import home_pose

free = Workspace.free()
HAND = forward_kinematics(free.home, free.link_lengths)[-1]
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(angles, angles, angles)


# Forward kinematics


@given(poses)
def test_the_chain_is_a_sum_of_turned_links(pose):
    turned = np.array(free.link_lengths) * np.exp(1j * np.cumsum(pose))
    x, y = forward_kinematics(pose, free.link_lengths)[1:].T
    np.testing.assert_allclose(x + 1j * y, np.cumsum(turned), atol=1e-15)


def test_the_chain_takes_poses_of_any_shape():
    many = np.random.default_rng(0).normal(size=(4, 5, 3))
    points = forward_kinematics(many, free.link_lengths)
    assert points.shape == (4, 5, 4, 2)
    np.testing.assert_array_equal(
        points[2, 3], forward_kinematics(many[2, 3], free.link_lengths)
    )


@given(st.floats(0.2, 0.99), angles)
def test_the_bent_home_reaches_where_asked(reach, heading):
    pose = home_pose(free.link_lengths, reach, heading)
    assert pose[1] == pose[2] > 0
    wanted = reach * np.array([math.cos(heading), math.sin(heading)])
    np.testing.assert_allclose(
        forward_kinematics(pose, free.link_lengths)[-1], wanted, atol=1e-12
    )


# Goals


@given(st.floats(0, 360), st.integers(-3, 3))
def test_goals_lie_on_the_circle_counted_from_the_cut(task, turns):
    x, y = free.target(task + 360 * turns)
    wanted = free.goal_radius * np.exp(1j * np.deg2rad(task + free.cut_deg))
    assert x + 1j * y == pytest.approx(wanted, abs=1e-9)


def test_many_goals_are_placed_at_once():
    tasks = np.arange(6.0).reshape(2, 3)
    assert free.target(tasks).shape == (2, 3, 2)
    np.testing.assert_array_equal(free.target(tasks)[1, 2], free.target(5))


def test_goal_minus_start_never_vanishes_in_either_dimension():
    start = forward_kinematics(free.home, free.link_lengths)[-1]
    assert (abs(start) > free.goal_radius + 0.1).all()


# Obstacles


def gap(pose, circle):
    """Measure the gap of arm and obstacle at a thousand points along each link."""
    joints = forward_kinematics(pose, free.link_lengths)
    along = np.linspace(0, 1, 1001)[:, None, None]
    points = joints[:-1] + along * np.diff(joints, axis=0)
    return np.hypot(*(points - circle[:2]).reshape(-1, 2).T).min() - LINK_RADIUS


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_a_layout_keeps_clear_of_the_home_pose_and_of_itself(seed):
    circles = draw(seed)
    assert len(circles) in (3, 4)
    for number, circle in enumerate(circles):
        assert 0.55 <= math.hypot(circle.x, circle.y) <= 0.80
        assert 0.04 <= circle.radius <= 0.07
        assert gap(free.home, circle) - circle.radius > 0.03
        for other in circles[:number]:
            between = math.hypot(circle.x - other.x, circle.y - other.y)
            assert between - circle.radius - other.radius > 0.03


def test_a_layout_is_a_function_of_its_seed():
    assert draw(5) == draw(5) != draw(6)


# The ready workspaces


def test_the_workspaces_differ_in_their_obstacles_alone():
    obstacles = Workspace.obstacles()
    assert not free.circles
    assert obstacles.circles
    assert dataclasses.replace(obstacles, name="free", circles=()) == free
    assert Workspace.named("free") == free
    assert Workspace.named("obstacles") == obstacles


def test_an_unknown_name_is_refused():
    with pytest.raises(ValueError, match=r"workspace='fre'.*'free' or 'obstacles'"):
        Workspace.named("fre")


def test_a_workspace_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        free.goal_radius = 0.5


@pytest.mark.parametrize("radius", [0.0, 1.0, 1.2, -0.45, math.nan])
def test_goals_out_of_reach_are_refused(radius):
    with pytest.raises(ValueError, match=r"goal_radius=.* between 0 m and 1 m"):
        Workspace(goal_radius=radius)


def test_goals_inside_the_reach_of_folded_links_are_refused():
    with pytest.raises(ValueError, match=r"goal_radius=0\.45 m .* 0\.5 m"):
        Workspace(link_lengths=(1.0, 0.3, 0.2))


def test_an_obstacle_on_the_goal_circle_is_refused():
    with pytest.raises(ValueError, match="circles: the goals pass through"):
        Workspace(circles=(Circle(0.5, 0.0, 0.06),))


@pytest.mark.parametrize(
    "circle", [Circle(-0.3, 0.0, 0.0), Circle(-0.3, 0.0, -0.1), Circle(*HAND, 0.05)]
)
def test_an_obstacle_without_a_size_or_in_the_arm_s_place_is_refused(circle):
    with pytest.raises(ValueError, match=r"circles: .* no positive radius or stands"):
        Workspace(circles=(circle,))


@pytest.mark.parametrize("name", ["link_lengths", "link_masses"])
@pytest.mark.parametrize("numbers", [(0.4, 0.4), (0.4, 0.3, 0.2, 0.1), (0.4, 0.3, 0.0)])
def test_links_that_cannot_be_are_refused(name, numbers):
    with pytest.raises(ValueError, match=rf"{name}=.*; wanted 3 positive numbers"):
        Workspace(**{name: numbers})


def test_obstacles_may_be_given_as_a_list():
    walled = Workspace(circles=[(0.7, 0.3, 0.05)])
    assert walled.circles == (Circle(0.7, 0.3, 0.05),)
    assert hash(walled) == hash(Workspace(circles=walled.circles))


@pytest.mark.parametrize("task", [math.nan, math.inf, [0.0, math.nan]])
def test_a_task_that_is_no_angle_is_refused(task):
    with pytest.raises(ValueError, match=r"task_deg=.* is not finite"):
        free.target(task)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("goal_radius", "0.4", "goal_radius='0.4'; wanted real numbers"),
        ("goal_radius", None, "goal_radius=None; wanted real numbers"),
        ("goal_radius", True, "goal_radius=True; wanted real numbers"),
        ("goal_radius", [0.45], r"goal_radius=\[0.45\]; wanted one number"),
        ("goal_radius", 1e-320, "goal_radius=1e-320 m .* over a micrometre"),
        ("goal_radius", 1j, "Complex data not supported: goal_radius"),
        ("cut_deg", "69.5", "cut_deg='69.5'; wanted real numbers"),
        ("home", ("0", "1", "1"), "home=.*; wanted real numbers"),
        ("link_lengths", ("0.4", "0.3", "0.2"), "link_lengths=.*; wanted real numbers"),
        ("circles", 5, "circles=5; wanted x, y and radius of each"),
        ("circles", None, "circles=None; wanted real numbers"),
        ("circles", (0.7, 0.3, 0.05), "circles=.*; wanted x, y and radius of each"),
        ("circles", ((0.7, 0),), "circles=.*; wanted x, y and radius of each"),
        ("circles", ((0.7, 0.3, "0.05"),), "circles=.*; wanted real numbers"),
        ("circles", ((0.7, 0.3, 1e-320),), "circles: .* a radius over a micrometre"),
    ],
)
def test_what_is_no_number_of_a_workspace_is_refused_by_name(name, value, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Workspace(**{name: value})
