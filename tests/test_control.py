from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc import Arm, Workspace
from msc.robot import TIME_STEP, joint_torques
from msc.robot._bullet import BulletWorld, load_pybullet
from msc.robot._control import (
    ComputedTorqueController,
    ControllerGains,
    coupled_inertias,
    rod_inertia,
)
from msc.robot._mujoco import MujocoWorld

free = Workspace.free()
inertias = coupled_inertias(free.link_lengths, free.link_masses)
unbounded = ControllerGains(windup=np.inf, torque_limit=(np.inf, np.inf, np.inf))
home = np.array(free.home)
motions = st.tuples(*[st.tuples(*[st.floats(-5, 5)] * 3)] * 3)


@pytest.fixture(params=[BulletWorld, MujocoWorld])
def world(request):
    try:
        world = request.param(free, unbounded, 1)
    except ValueError as error:  # not installed
        pytest.skip(str(error))
    yield world
    world.close()


# Inverse dynamics


@pytest.fixture(scope="module")
def arm():
    pytest.importorskip("pybullet", reason="PyBullet is not installed")
    with Arm(free, n_parallel=1) as arm:
        yield arm


@given(motions)
def test_torques_are_those_of_pybullet(arm, motion):
    found = load_pybullet().calculateInverseDynamics(
        arm._world._bodies[0], *motion, physicsClientId=arm.client_id
    )
    np.testing.assert_allclose(joint_torques(motion, inertias), found, atol=1e-5)


@given(motions)
def test_torques_do_the_work_that_becomes_kinetic_energy(motion):
    def energy(time):
        angle, speed, acceleration = np.array(motion)
        turned = np.cumsum(angle + speed * time + acceleration * time**2 / 2)
        turning = np.cumsum(speed + acceleration * time)
        apart = np.cos(turned[:, None] - turned)
        return turning @ (inertias * apart) @ turning / 2

    power = joint_torques(motion, inertias) @ motion[1]
    gained = (energy(1e-5) - energy(-1e-5)) / 2e-5
    assert power == pytest.approx(gained, rel=1e-4, abs=1e-4)


def test_several_arms_at_once_as_one_by_one():
    motion = np.random.default_rng(0).normal(size=(3, 3, 7))
    together = joint_torques(motion, inertias)
    apart = [joint_torques(motion[..., k], inertias) for k in range(7)]
    assert (together == np.transpose(apart)).all()


def test_a_single_rod_about_its_end():
    assert coupled_inertias([2.0], [3.0])[0, 0] == pytest.approx(3 * 2**2 / 3)
    assert rod_inertia(2.0, 3.0) == pytest.approx(1.0)


# Why torques come from inverse dynamics


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), free.home])
def test_a_pid_of_torques_on_each_joint_would_tremble(pose):
    # a mode that loses more than twice its speed in a time step swings ever wider
    def mass_matrix(angles):
        angles, rest = np.array(angles)[:, None], np.zeros((3, 1))
        columns = [
            joint_torques((angles, rest, a), inertias) for a in np.eye(3)[..., None]
        ]
        return np.hstack(columns)

    largest = np.diag(np.diag(mass_matrix((0.0, 0.0, 0.0))))
    modes = np.linalg.solve(mass_matrix(pose), 2 * 20 * largest)
    assert np.linalg.eigvals(modes).real.max() / 240 > 2


# How errors die out


@pytest.mark.parametrize("bandwidth", [4.0, 8.0, 15.0])
def test_an_error_dies_out_as_a_triple_pole_says(bandwidth, world):
    # (d/dt + w)³ y = 0 for y = ∫e, from y = 0, ẏ = e₀, ÿ = 0
    world.controller = replace(unbounded, bandwidth=bandwidth)
    first = np.array([0.03, -0.02, 0.04])
    plan = np.tile(home + first, (1, 241, 1))
    joints, _ = world.track(plan, home[np.newaxis], np.empty((1, 0, 3)))
    time = bandwidth * TIME_STEP * np.arange(241)[:, None]
    wanted = (1 + time - time**2) * np.exp(-time)
    late = 0.7 * bandwidth * TIME_STEP  # commands are held for a time step
    found = (plan - joints)[0] / first
    np.testing.assert_allclose(found, np.tile(wanted, 3), atol=late)


def test_without_an_error_the_torques_are_those_of_the_plan():
    time = TIME_STEP * np.arange(61)[:, None]
    plan = (home + np.array([1.0, -2.0, 1.5]) * time**2)[..., None]
    pursuit = ComputedTorqueController(
        ControllerGains(torque_limit=unbounded.torque_limit), plan, inertias
    )
    for step in range(2, 59):
        speed = np.array([2.0, -4.0, 3.0])[:, None] * time[step]
        motion = plan[step], speed, np.array([[2.0], [-4.0], [3.0]])
        torque = pursuit.torques(step, np.array(motion[:2]))
        np.testing.assert_allclose(torque, joint_torques(motion, inertias), rtol=1e-6)


# Limits


numbers = st.floats(-1e3, 1e3)
states = st.tuples(*[st.tuples(*[numbers] * 3)] * 2)


@settings(deadline=None)
@given(states, st.floats(0, 100), st.tuples(*[st.floats(0.1, 50)] * 3))
def test_no_torque_exceeds_its_limit(state, bandwidth, limit):
    controller = ControllerGains(bandwidth, torque_limit=limit)
    pursuit = ComputedTorqueController(
        controller, np.tile(home[:, None], (9, 1, 1)), inertias
    )
    for step in range(8):
        torque = pursuit.torques(step, np.array(state)[..., None])
        assert (abs(torque[:, 0]) <= limit).all()


@pytest.mark.parametrize("sign", [1, -1])
def test_an_arm_that_is_held_up_pushes_no_harder_than_the_windup_allows(sign):
    controller = ControllerGains(torque_limit=unbounded.torque_limit)
    plan = np.tile((home + sign)[:, None], (121, 1, 1))
    pursuit = ComputedTorqueController(controller, plan, inertias)
    held = np.array([home, np.zeros(3)])[..., None]
    pushes = np.array([pursuit.torques(step, held)[:, 0] for step in range(120)])
    rate = controller.bandwidth
    pull = sign * (3 * rate**2 + controller.windup * rate**3)
    wanted = joint_torques([home, np.zeros(3), np.full(3, pull)], inertias)
    np.testing.assert_allclose(pushes[1:], np.tile(wanted, (119, 1)))


def test_a_wound_up_integral_is_left_at_once():
    plan = np.tile((home + 1)[:, None], (121, 1, 1))
    held, beyond, there = np.zeros((3, 2, 3, 1))
    held[0, :, 0], beyond[0, :, 0], there[0, :, 0] = home, home + 3, home + 1
    pursuit = ComputedTorqueController(ControllerGains(), plan, inertias)
    for step in range(120):
        pursuit.torques(step, held)
    pursuit.torques(120, beyond)
    fresh = ComputedTorqueController(ControllerGains(), plan, inertias)
    fresh.torques(0, beyond)
    assert (pursuit.torques(120, there) == fresh.torques(1, there)).all()
    assert fresh.torques(1, there).any()


def test_each_arm_has_an_integral_of_its_own():
    plan = np.tile(home[:, None], (9, 1, 2))
    pursuit = ComputedTorqueController(unbounded, plan, inertias)
    state = np.array([home, np.zeros(3)])[..., None] + [[[0.1, 0]] * 3, [[0, 0]] * 3]
    for step in range(8):
        torque = pursuit.torques(step, state)
    assert abs(torque[:, 0]).min() > 0
    np.testing.assert_allclose(torque[:, 1], 0, atol=1e-9)


@pytest.mark.parametrize("name", ["bandwidth", "windup"])
def test_a_truth_is_no_gain(name):
    with pytest.raises(ValueError, match=f"{name}=True; wanted a .* number from 0"):
        ControllerGains(**{name: True})
