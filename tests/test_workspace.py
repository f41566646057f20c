import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc import Workspace
from msc.robot import LINK_RADIUS, Circle, CostWeights, Physics, forward_kinematics
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


# Tasks of several numbers

POST = Circle(0.7, 0.3, 0.05)
RANGES = (("turn_deg", -10, 10), ("radius_m", 0.3, 0.45), ("height_m", -0.08, 0.05))
varied = Workspace(circles=(POST, Circle(-0.3, 0.7, 0.04)), further=RANGES)
rows = st.tuples(
    st.floats(-400, 400),
    st.floats(-10, 10),
    st.floats(0.3, 0.45),
    st.floats(-0.08, 0.05),
)


@given(rows)
def test_a_row_places_goal_home_and_first_obstacle(row):
    angle, turn, radius, height = row
    place = complex(*varied.target(row))
    wanted = radius * np.exp(1j * np.deg2rad(angle + varied.cut_deg))
    assert place == pytest.approx(wanted, abs=1e-9)
    first, *others = np.array(varied.home_of(row)) - varied.home
    assert first == pytest.approx(np.deg2rad(turn), abs=1e-12)
    assert not np.any(others)
    moved, still = varied.circles_of(row)
    assert tuple(moved) == (POST.x, POST.y + height, POST.radius)
    assert tuple(still) == varied.circles[1]


def test_rows_of_any_shape_are_placed_at_once():
    tasks = np.random.default_rng(0).uniform(0.3, 0.45, (4, 5, 4)) - [0, 0, 0, 0.4]
    for place, shape in ((varied.target, (2,)), (varied.home_of, (3,))):
        assert place(tasks).shape == (4, 5, *shape)
        np.testing.assert_array_equal(place(tasks)[3, 2], place(tasks[3, 2]))
    assert varied.circles_of(tasks).shape == (4, 5, 2, 3)
    assert free.circles_of([1.0, 2.0]).shape == (2, 0, 3)
    assert free.home_of(7.0).tolist() == [*free.home]


def test_the_numbers_of_a_task_have_names_and_units():
    assert free.task_names == ("task_deg",)
    assert varied.task_names == ("task_deg", "turn_deg", "radius_m", "height_m")
    assert free.task_units.tolist() == [1.0]
    assert varied.task_units.tolist() == [1.0, 1.0, 0.45, 0.45]


@pytest.mark.parametrize("tasks", [30.0, [30.0, 0.0, 0.4], [[1.0, 2.0]] * 4])
def test_rows_of_another_length_are_refused(tasks):
    with pytest.raises(
        ValueError, match=r"task_deg has shape .*; wanted rows of 4 num"
    ):
        varied.target(tasks)


@pytest.mark.parametrize(
    ("further", "message"),
    [
        ([("speed", 0, 1)], "further: 'speed' is unknown; wanted one of radius_m, hei"),
        ([("turn_deg", 0, 1)] * 2, "further: turn_deg is given twice; wanted it once"),
        ([("turn_deg", 1, 1)], r"turn_deg=\[1, 1\]; wanted .* the lower one first"),
        ([("turn_deg", 2, 1)], r"turn_deg=\[2, 1\]; wanted .* the lower one first"),
        ([("turn_deg", "0", "1")], "turn_deg=0; wanted a finite number"),
        ([("turn_deg", 0, math.inf)], "turn_deg=inf; wanted a finite number"),
        ([("turn_deg", 0, math.nan)], "turn_deg=nan; wanted a finite number"),
        ([("radius_m", 0.4, 1.2)], "radius_m=1.2 m is out of the arm's reach"),
        ([("height_m", 0, 0.1)], "height_m: no obstacle to move; wanted one at least"),
    ],
)
def test_a_range_that_is_none_is_refused(further, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        Workspace(further=further)


@pytest.mark.parametrize(
    ("further", "message"),
    [
        (("height_m", -1.2, 0.0), "stands in the arm's home pose"),
        (("turn_deg", -360.0, 0.0), "stands in the arm's home pose"),
        (("radius_m", 0.45, 0.8), "the goals pass through"),
    ],
)
def test_an_obstacle_that_is_met_anywhere_on_its_way_is_refused(further, message):
    post = Circle(-0.65, 0.35, 0.02)
    Workspace(circles=(post,))
    with pytest.raises(ValueError, match=f"circles: .*{message}"):
        Workspace(circles=(post,), further=(further,))


# Prices and physics


@pytest.mark.parametrize("name", ["error", "energy", "contact", "length"])
@pytest.mark.parametrize("value", [-1e-9, 1e6 + 1, math.nan, "1", None, True])
def test_a_price_that_is_none_is_refused(name, value):
    with pytest.raises(ValueError, match=f"^{name}=.*; wanted a finite number from 0"):
        CostWeights(**{name: value})


def test_physics_counts_its_steps():
    physics = Physics()
    assert (physics.time_step, physics.n_moving, physics.n_steps) == (1 / 60, 60, 66)
    slow = Physics(control_rate=100.0, duration=2.5, settling=0.0)
    assert (slow.time_step, slow.n_moving, slow.n_steps) == (0.01, 250, 250)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("control_rate", 10.0, 1000.0),
        ("substeps", 1, 100),
        ("duration", 0.1, 20.0),
        ("settling", 0.0, 5.0),
        ("gravity", 0.0, 30.0),
    ],
)
def test_physics_has_bounds(name, low, high):
    for inside in (low, high):
        assert getattr(Physics(**{name: inside}), name) == inside
    for outside in (low - 1, high + 1, math.nan, "1", True):
        with pytest.raises(ValueError, match=f"^{name}=.*; wanted"):
            Physics(**{name: outside})


@pytest.mark.parametrize("engine", ["ode", "MuJoCo", None, 3])
def test_an_unknown_engine_is_refused(engine):
    with pytest.raises(ValueError, match=r"engine=.*; wanted 'pybullet' or 'mujoco'"):
        Physics(engine=engine)
