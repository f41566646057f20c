import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msc import Arm, Workspace
from msc.robot import joint_torques
from msc.robot._bullet import load_pybullet
from msc.robot._control import coupled_inertias, rod_inertia

free = Workspace.free()
inertias = coupled_inertias(free.link_lengths, free.link_masses)
motions = st.tuples(*[st.tuples(*[st.floats(-5, 5)] * 3)] * 3)


@pytest.fixture(scope="module")
def arm():
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
