"""Numbers beyond sense, and those that are not real: refused wherever they enter."""

import warnings

import numpy as np
import pandas as pd
import pytest

from msc import Arm, Workspace, find_jumps, search_policy
from msc._checks import check_number, to_floats
from msc.data import step_sizes
from msc.robot import (
    Circle,
    clearance,
    forward_kinematics,
    inverse_kinematics,
    joint_torques,
)
from msc.robot._control import ControllerGains
from msc.study import draw_samples

free = Workspace.free()
SIX = np.zeros((6, 6))


@pytest.fixture(scope="module")
def arm():
    with Arm(free, n_parallel=2) as arm:
        yield arm


@pytest.mark.parametrize(
    "kind",
    [
        lambda values: np.asarray(values) + 1j,
        lambda values: (np.asarray(values) + 0j).tolist(),
        lambda values: np.asarray(values).astype(np.complex64),
        lambda values: np.asarray([*np.ravel(values)[:-1], 1j], object),
        lambda values: np.array(
            [np.complex64(value) for value in np.ravel(values)], object
        ).reshape(np.shape(values)),
        lambda values: pd.DataFrame(np.atleast_2d(values) + 0j),
    ],
)
def test_complex_numbers_are_refused_wherever_arrays_enter(arm, kind):
    straight = np.arange(6.0)
    calls = {
        "task_deg": free.target,
        "task_deg ": lambda bad: arm.execute_many(SIX, bad),
        "policy": lambda bad: arm.execute_many(bad, 0.0),
        "policy ": lambda bad: arm.execute(bad, 0.0),
        "policy  ": lambda bad: search_policy(free, 0, seed=0, start_policies=[bad]),
        "tasks": lambda bad: find_jumps(bad, SIX),
        "tasks ": lambda bad: draw_samples("even", bad, 3),
        "policies": lambda bad: find_jumps(straight, bad),
        "policies ": step_sizes,
        "joints": lambda bad: forward_kinematics(bad, free.link_lengths),
        "path": lambda bad: inverse_kinematics(bad, free.home, free.link_lengths),
        "motion": lambda bad: joint_torques(bad, np.eye(3)),
    }
    for name, call in calls.items():
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            said = f"Complex data not supported: {name.strip()} must hold real"
            with pytest.raises(ValueError, match=said):
                call(kind(straight))


@pytest.mark.parametrize("value", [1e308, -1e10, 1e300])
def test_policies_and_tasks_beyond_sense_are_refused(arm, value):
    policy = np.array([0.0, 0, 0, value, 0, 0])
    with pytest.raises(
        ValueError, match=r"policy has a weight of magnitude .* at most"
    ):
        arm.execute(policy, 0.0)
    with pytest.raises(
        ValueError, match=r"policy has a weight of magnitude .* at most"
    ):
        arm.execute_many([np.zeros(6), policy], 0.0)
    with pytest.raises(
        ValueError, match=r"policy has a weight of magnitude .* at most"
    ):
        search_policy(free, 0.0, seed=0, n_starts=0, start_policies=[policy])
    with pytest.raises(
        ValueError, match=r"task_deg has an angle of .*; wanted at most"
    ):
        arm.execute(np.zeros(6), value)
    with pytest.raises(
        ValueError, match=r"task_deg has an angle of .*; wanted at most"
    ):
        free.target([0.0, value])


def test_the_largest_policies_that_are_taken_end_somewhere(arm):
    signs = np.random.default_rng(0).choice([-1, 0, 1], (8, 6))
    for rollout in arm.execute_many(1e9 * signs, 1e9):
        found = rollout.error, rollout.energy, rollout.contact_impulse
        assert np.isfinite([*found, *rollout.joints.ravel()]).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("link_lengths", (0.4, np.nan, 0.25)),
        ("link_lengths", (0.4, 1e300, 0.25)),
        ("link_lengths", (1e-9, 1e-9, 1e-9)),
        ("link_masses", (1.0, np.inf, 0.5)),
        ("link_masses", (1.0, 1e-300, 0.5)),
        ("link_masses", (1.0, "heavy", 0.5)),
        ("link_masses", (1.0, 1j, 0.5)),
        ("link_masses", 1.0),
        ("home", (0.0, np.nan, 0.0)),
        ("home", (0.0, 1e300, 0.0)),
        ("home", (0.0, 1j, 0.0)),
        ("home", (0.0, 0.5)),
        ("cut_deg", np.nan),
        ("cut_deg", 1e300),
        ("cut_deg", 1j),
        ("goal_radius", np.inf),
        ("goal_radius", 0.45 + 0j),
        ("circles", ((np.nan, 0.7, 0.05),)),
        ("circles", ((0.7, 0.3, 1j),)),
        ("circles", ((1e300, 0.3, 0.05),)),
    ],
)
def test_worlds_beyond_sense_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Workspace(**{name: value})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[
            ("bandwidth", value)
            for value in (np.nan, np.inf, -1.0, 1e10, 1j, "15", None)
        ],
        *[("windup", value) for value in (np.nan, -1.0, 1j, None)],
        ("torque_limit", (40.0, np.nan, 5.0)),
        ("torque_limit", (40.0, -1.0, 5.0)),
        ("torque_limit", (40.0, 1j, 5.0)),
        ("torque_limit", (40.0, 20.0)),
        ("torque_limit", 40.0),
    ],
)
def test_controllers_beyond_sense_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        ControllerGains(**{name: value})


@pytest.mark.parametrize("bandwidth", [0.0, 1000.0])
@pytest.mark.parametrize("mass", [0.01, 1000.0])
@pytest.mark.parametrize("length", [0.06, 9.0])
@pytest.mark.parametrize("limit", [1e-3, np.inf])
def test_worlds_at_their_bounds_end_somewhere(bandwidth, mass, length, limit):
    world = Workspace(
        link_lengths=(length,) * 3, link_masses=(mass,) * 3, goal_radius=2 * length
    )
    controller = ControllerGains(bandwidth, np.inf, (limit,) * 3)
    with Arm(world, controller=controller, n_parallel=1) as arm:
        rollout = arm.execute(np.full(6, 30.0), 10.0)
    assert np.isfinite([rollout.error, rollout.energy, *rollout.joints.ravel()]).all()


def test_numbers_pass_as_they_are():
    values = np.random.default_rng(0).normal(size=(3, 2))
    assert to_floats("x", values) is values
    for same in (values.tolist(), pd.DataFrame(values), values.astype(object)):
        np.testing.assert_array_equal(to_floats("x", same), values)
    assert np.isinf(to_floats("x", np.longdouble("1e400")))
    assert (
        clearance(forward_kinematics(free.home, free.link_lengths), Circle(9, 9, 1)) > 0
    )
    check_number("x", np.float32(1), 0, 1)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.array(["2020-01-01"], "M8[D]"), "Got dates"),
        (pd.Series(pd.to_timedelta([1, 2], "s")), "Got dates"),
        (np.ma.masked_array([1.0, 2.0], [True, False]), "Got masked"),
        ([[1.0], [1.0, 2.0]], "inhomogeneous"),
        ({"a": 1}, "not 'dict'"),
        ("north", "could not convert"),
        (None, r"NoneType|nan"),
    ],
)
def test_what_is_no_number_is_named(values, said):
    if values is None:
        assert np.isnan(to_floats("x", values))  # for whoever asks for finite ones
        return
    with pytest.raises(ValueError, match=rf"^x must hold numbers.*{said}"):
        to_floats("x", values)
