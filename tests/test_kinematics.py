import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from msc import Workspace
from msc.robot import forward_kinematics, inverse_kinematics
from msc.robot._kinematics import DAMPING, MAX_JOINT_STEP

HOME, LENGTHS = Workspace.home, Workspace.link_lengths

times = np.linspace(0, 1, 241)
eased = times**3 * (10 - 15 * times + 6 * times**2)
properties = settings(max_examples=50, deadline=None)


def tip(joints):
    return forward_kinematics(joints, LENGTHS)[..., -1, :]


def follow(path):
    return inverse_kinematics(path, HOME, LENGTHS)


def triples(size):
    return st.tuples(*[st.floats(-size, size)] * 3).map(np.array)


@properties
@given(triples(1.5))
def test_paths_within_reach_are_followed_to_a_millimetre(turn):
    path = tip(HOME + eased[:, None] * turn)
    assume(np.hypot(*path.T).max() < 0.98)
    missed = np.hypot(*(tip(follow(path)) - path).T)
    assert missed.max() < 1e-3
    assert missed[-1] < 1e-6


@properties
@given(st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)), triples(3.0))
def test_a_step_is_damped_least_squares(error, pose):
    origin = tip(pose)
    after = inverse_kinematics([origin, origin + error], pose, LENGTHS)[1]
    heading = np.cumsum(pose)
    links = np.array(LENGTHS) * np.exp(1j * heading)
    columns = 1j * np.cumsum(links[::-1])[::-1]
    J = np.stack([columns.real, columns.imag])
    step = J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(2), np.array(error))
    np.testing.assert_allclose(
        after - pose, step.clip(-MAX_JOINT_STEP, MAX_JOINT_STEP), atol=1e-10
    )


def test_the_first_pose_is_home():
    assert follow([tip(HOME)]).tolist() == [list(HOME)]


def test_a_point_that_stays_moves_no_joint():
    joints = follow(np.tile(tip(HOME), (20, 1)))
    np.testing.assert_allclose(joints, np.tile(HOME, (20, 1)), atol=1e-15)


def test_out_of_reach_the_arm_stretches_towards_the_path():
    away = 1 + 2 * eased[:, None]
    joints = follow(away * tip(HOME))
    assert abs(np.diff(joints, axis=0)).max() <= MAX_JOINT_STEP
    wanted = tip(HOME) / np.hypot(*tip(HOME))
    np.testing.assert_allclose(tip(joints[-1]), wanted, atol=0.01)


@pytest.mark.parametrize("n_paths", [1, 2, 3, 4, 8, 9])
def test_a_path_is_followed_alike_in_any_population(n_paths):
    turns = np.random.default_rng(0).uniform(-1, 1, size=(n_paths, 1, 3))
    paths = tip(HOME + eased[:, None] * turns)
    for path, joints in zip(paths, follow(paths), strict=True):
        np.testing.assert_array_equal(joints, follow(path[None])[0])
        np.testing.assert_allclose(joints, follow(path), atol=1e-12)
