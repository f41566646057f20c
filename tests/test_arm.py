import gc
import math
import re
import warnings
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from msc import Arm, Rollout, Workspace
from msc.robot import (
    ENGINES,
    LINK_RADIUS,
    TIME_STEP,
    Circle,
    Physics,
    TaskRange,
    forward_kinematics,
    joint_torques,
    random_circles,
)
from msc.robot._bullet import load_pybullet
from msc.robot._control import ControllerGains, coupled_inertias

try:
    bullet = load_pybullet()
except ValueError:  # on Python 3.12 and later
    bullet = None
physics = Physics()
free = Workspace.free()
circles = (Circle(-0.5, 0.2, 0.05), Circle(0.2, -0.5, 0.05))
walled = replace(free, name="walled", circles=circles)

rng = np.random.default_rng(0)
policies = 4 * rng.normal(size=(20, 6))
tasks = rng.uniform(0, 360, size=20)


@pytest.fixture(scope="module")
def bullet_arm():
    if bullet is None:
        pytest.skip("PyBullet is not installed")
    with Arm(free) as arm:
        yield arm


@pytest.fixture(scope="module", params=ENGINES)
def engine(request):
    try:
        Arm(within(free, request.param), n_parallel=1).close()
    except ValueError as error:  # says how to come by it
        pytest.skip(str(error))
    return request.param


def within(workspace, engine, **changed):
    """The same world in another engine."""
    return replace(workspace, physics=Physics(engine=engine, **changed))


@pytest.fixture(scope="module")
def arm(engine):
    with Arm(within(free, engine)) as arm:
        yield arm


@pytest.fixture(scope="module")
def walled_arm(engine):
    with Arm(within(walled, engine)) as arm:
        yield arm


@pytest.fixture(scope="module")
def rollouts(walled_arm):
    return walled_arm.execute_many(policies, tasks)


def bits(rollout):
    return [np.asarray(value).tobytes() for value in astuple(rollout)]


def gap(rollout):
    """Measure the least gap of arm and obstacles, at 200 points a link, each step."""
    joints = forward_kinematics(rollout.joints, free.link_lengths)[:, None]
    along = np.linspace(0, 1, 200)[:, None, None]
    points = joints[:, :, :-1] + along * np.diff(joints, axis=2)
    return min(
        np.linalg.norm(points - circle[:2], axis=-1).min() - LINK_RADIUS - circle.radius
        for circle in circles
    )


# The body


@settings(max_examples=20, deadline=None)
@given(st.tuples(*[st.floats(-math.pi, math.pi)] * 3))
def test_forward_kinematics_are_those_of_pybullet(bullet_arm, pose):
    arm = bullet_arm
    body, client = arm._world._bodies[0], {"physicsClientId": arm.client_id}
    for joint, angle in enumerate(pose):
        bullet.resetJointState(body, joint, angle, **client)
    states = bullet.getLinkStates(body, [0, 1, 2], computeForwardKinematics=1, **client)
    frames = [state[4:6] for state in states]
    tip, _ = bullet.multiplyTransforms(
        *frames[2], [free.link_lengths[2], 0, 0], [0, 0, 0, 1]
    )
    found = np.array([place for place, _ in frames] + [tip])
    wanted = forward_kinematics(
        pose, free.link_lengths
    )  # PyBullet's rotations have seven digits
    np.testing.assert_allclose(found[:, :2], wanted, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[:, 2], found[0, 2], rtol=0, atol=1e-6)


INSTANT = 1e-5  # s; in a whole time step the acceleration itself changes


@settings(max_examples=20, deadline=None)
@given(*[st.tuples(*[st.floats(-3, 3)] * 3)] * 3)
@example((0.0, -0.5, 1.0), (0.0, 3.0, 0.0), (0.0, 3.0, 1.0))
def test_torques_move_the_links_as_slender_rods(bullet_arm, pose, speed, torque):
    arm = bullet_arm
    body, client = arm._world._bodies[0], {"physicsClientId": arm.client_id}
    for joint in range(3):
        bullet.resetJointState(body, joint, pose[joint], speed[joint], **client)
    mass = np.array(bullet.calculateMassMatrix(body, pose, **client))
    bullet.setJointMotorControlArray(
        body, [0, 1, 2], bullet.TORQUE_CONTROL, forces=torque, **client
    )
    bullet.setTimeStep(INSTANT, **client)
    bullet.stepSimulation(**client)
    bullet.setTimeStep(TIME_STEP, **client)
    states = bullet.getJointStates(body, [0, 1, 2], **client)
    gained = (np.array([state[1] for state in states]) - speed) / INSTANT
    inertias = coupled_inertias(free.link_lengths, free.link_masses)
    still = joint_torques([pose, speed, np.zeros(3)], inertias)
    wanted = np.linalg.solve(mass, torque - still)
    assert np.linalg.norm(gained - wanted) < 0.01 * (1 + np.linalg.norm(wanted))


def test_nothing_slows_the_arm_down(bullet_arm):
    arm = bullet_arm
    body, client = arm._world._bodies[0], {"physicsClientId": arm.client_id}
    for joint, (angle, speed) in enumerate(zip(free.home, (2, -3, 4), strict=True)):
        bullet.resetJointState(body, joint, angle, speed, **client)

    def energy():
        states = bullet.getJointStates(body, [0, 1, 2], **client)
        angles, speeds, *_ = zip(*states, strict=True)
        inertia = bullet.calculateMassMatrix(body, angles, **client)
        return np.array(speeds) @ inertia @ speeds / 2

    before = energy()
    for _ in range(120):
        bullet.setJointMotorControlArray(
            body, [0, 1, 2], bullet.TORQUE_CONTROL, forces=[0, 0, 0], **client
        )
        bullet.stepSimulation(**client)
    assert energy() == pytest.approx(before, rel=0.02)


# Both engines

LIMP = ControllerGains(torque_limit=(1e-9,) * 3)


def test_free_movements_are_the_same_in_both_engines():
    for engine in ("mujoco", "pybullet"):
        pytest.importorskip(engine, reason=f"{engine} is not installed")
    done = []
    for engine in ENGINES:
        with Arm(within(free, engine)) as arm:
            done.append(arm.execute_many(policies, tasks))
    for one, other in zip(*done, strict=True):
        np.testing.assert_allclose(one.joints, other.joints, rtol=0, atol=1e-9)
        np.testing.assert_allclose(one.path, other.path, rtol=0, atol=1e-9)


def released(engine, workspace, **physics):
    """Let go of an arm in its home pose."""
    world = within(workspace, engine, settling=0.0, **physics)
    with Arm(world, controller=LIMP, n_parallel=1) as arm:
        held = np.tile(world.home, (1, world.physics.n_steps + 1, 1))
        return arm.follow(held, 0.0)[0].joints, world.physics.time_step


def test_an_arm_that_is_let_go_swings_as_a_rod_does(engine):
    """A heavy rod about its end: its square frequency is 3 g / 2 l."""
    lean = 0.01
    hanging = Workspace(
        link_lengths=(1.0, 0.05, 0.05),
        link_masses=(1000.0, 0.01, 0.01),
        home=(lean - math.pi / 2, 0.0, 0.0),
        goal_radius=1.0,
    )
    joints, step = released(engine, hanging, gravity=9.81, duration=5.0, substeps=16)
    times = step * np.arange(len(joints))
    swings = lean * np.cos(math.sqrt(1.5 * 9.81) * times)
    np.testing.assert_allclose(joints[:, 0] + math.pi / 2, swings, atol=0.005 * lean)


def test_an_arm_that_falls_keeps_its_energy(engine):
    """Neither engine damps a joint."""
    lengths, masses = np.array(free.link_lengths), np.array(free.link_masses)
    joints, step = released(
        engine, free, gravity=9.81, duration=2.0, control_rate=1000.0, substeps=8
    )
    along, weights = np.polynomial.legendre.leggauss(2)  # exact for rods
    ends = forward_kinematics(joints, lengths)
    energy = np.zeros(len(joints) - 2)
    for place, weight in zip((1 + along) / 2, weights / 2, strict=True):
        points = ends[:, :-1] + place * np.diff(ends, axis=1)
        speeds = (points[2:] - points[:-2]) / (2 * step)
        motion = np.sum(speeds**2, axis=-1) / 2 + 9.81 * points[1:-1, :, 1]
        energy += weight * motion @ masses
    scale = np.ptp(9.81 * (ends[:, :-1, 1] + ends[:, 1:, 1]) / 2 @ masses)
    assert scale > 1
    assert np.ptp(energy) < 0.02 * scale


def test_an_arm_at_rest_under_gravity_stays(engine):
    world = within(free, engine, gravity=9.81)
    with Arm(world, n_parallel=1) as arm:
        [rollout] = arm.follow(np.tile(free.home, (1, 67, 1)), 0.0)
    np.testing.assert_allclose(rollout.joints, [free.home] * 67, rtol=0, atol=1e-3)


NUMBERS = {"radius_m": (0.2, 0.45), "height_m": (-0.05, 0.05), "turn_deg": (-5.0, 5.0)}
FIXED = {
    "radius_m": {"goal_radius": 0.3},
    "height_m": {"circles": (Circle(-0.5, 0.2 + 0.03, 0.05), circles[1])},
    "turn_deg": {"home": (free.home[0] + np.deg2rad(4.0), *free.home[1:])},
}


@pytest.mark.parametrize(
    ("name", "value"), [("radius_m", 0.3), ("height_m", 0.03), ("turn_deg", 4.0)]
)
def test_a_number_of_a_task_does_what_it_does_in_a_world_of_its_own(
    engine, name, value
):
    own = within(replace(walled, **FIXED[name]), engine)
    shared = within(walled, engine)
    shared = replace(shared, further=(TaskRange(name, *NUMBERS[name]),))
    rows = np.column_stack([tasks, np.full(len(tasks), value)])
    elsewhere = np.random.default_rng(0).uniform(*NUMBERS[name], len(tasks))
    with Arm(own) as one, Arm(shared) as other:
        found = other.execute_many(policies, rows)
        other.execute_many(policies, np.column_stack([tasks, elsewhere]))
        wanted = [bits(rollout) for rollout in one.execute_many(policies, tasks)]
        assert [bits(rollout) for rollout in found] == wanted
        again = other.execute_many(policies[::-1], rows[::-1])
        assert [bits(rollout) for rollout in again] == wanted[::-1]
    assert any(rollout.touched for rollout in found)


# The controller


def test_the_arm_follows_its_plan(arm):
    plans = arm.plan(policies, free.target(tasks))
    for plan, rollout in zip(plans, arm.execute_many(policies, tasks), strict=True):
        path = forward_kinematics(plan, free.link_lengths)[:, -1]
        behind = np.hypot(*(rollout.path - path).T)
        assert behind.mean() < 0.02
        assert behind.max() < 0.06


def test_given_time_the_arm_comes_to_rest_where_it_should(arm):
    plan = arm.plan(policies[:9], free.target(tasks[:9]))
    plan = np.concatenate([plan, np.repeat(plan[:, -1:], 960, axis=1)], axis=1)
    homes = arm.workspace.home_of(tasks[:9])
    joints, _ = arm._world.track(plan, homes, np.empty((9, 0, 3)))
    np.testing.assert_allclose(joints[:, -1], plan[:, -1], atol=2e-3)


def test_a_weak_arm_is_left_behind(arm):
    controller = ControllerGains(torque_limit=(0.4, 0.2, 0.05))
    with Arm(arm.workspace, controller=controller) as weak:
        found = weak.execute(np.zeros(6), 270)
    assert found.error > 3 * arm.execute(np.zeros(6), 270).error


def test_the_plan_holds_its_last_pose_while_the_arm_settles(arm):
    plan = arm.plan(policies[:1], free.target(tasks[:1]))[0]
    assert plan.shape == (physics.n_steps + 1, 3)
    assert (plan[physics.n_moving :] == plan[physics.n_moving]).all()
    np.testing.assert_allclose(plan[0], free.home)


# What a rollout says


def test_a_rollout_measures_what_happened(arm):
    rollout = arm.execute(policies[0], 120)
    assert rollout.joints.shape == (physics.n_steps + 1, 3)
    np.testing.assert_allclose(rollout.joints[0], free.home)
    tips = forward_kinematics(rollout.joints, free.link_lengths)[:, -1]
    np.testing.assert_array_equal(rollout.path, tips)
    missed = math.dist(tips[-1], free.target(120))
    assert rollout.error == pytest.approx(missed, rel=1e-12)
    speeds = np.diff(rollout.joints, axis=0) / TIME_STEP
    assert rollout.energy == pytest.approx(TIME_STEP * np.sum(speeds**2), rel=1e-12)
    assert rollout.contact_impulse == 0
    assert not rollout.touched


def test_a_task_is_an_angle_modulo_360(arm):
    wrapped = arm.execute(policies[0], 120 - 360)
    assert bits(wrapped) == bits(arm.execute(policies[0], 120))


# Obstacles


# m, at the policies of these tests; measured: 0.2 mm and 5.8 mm, for MuJoCo's contacts
# are springs.
DEEPEST = {"pybullet": 0.002, "mujoco": 0.008}


def test_an_obstacle_is_touched_when_the_gap_closes_and_never_entered(engine, rollouts):
    gaps = np.array([gap(rollout) for rollout in rollouts])
    touched = np.array([rollout.touched for rollout in rollouts])
    assert 5 <= touched.sum() <= 15
    assert (touched == (gaps < 1e-3)).all()
    assert gaps.min() > -DEEPEST[engine]


def test_an_obstacle_stops_the_arm(engine, arm, walled_arm):
    through, stopped = (one.execute(np.zeros(6), 90) for one in (arm, walled_arm))
    assert gap(through) < -0.05
    assert gap(stopped) > -DEEPEST[engine]
    assert stopped.contact_impulse > 1
    assert stopped.error > through.error + 0.1


def test_contacts_are_as_smooth_as_the_movement(walled_arm, rollouts):
    nearby = walled_arm.execute_many(policies * (1 + 1e-12), tasks)
    for one, other in zip(rollouts, nearby, strict=True):  # cylinders: 4e-4 apart
        np.testing.assert_allclose(one.joints, other.joints, rtol=0, atol=1e-10)


def test_an_obstacle_out_of_the_way_changes_nothing(arm, rollouts):
    missed = [k for k, rollout in enumerate(rollouts) if not rollout.touched]
    alone = arm.execute_many(policies[missed], tasks[missed])
    assert [bits(rollouts[k]) for k in missed] == [bits(one) for one in alone]


# The same policy always does the same, to the last bit


def test_one_by_one_as_together(walled_arm, rollouts):
    for policy, task, rollout in zip(policies, tasks, rollouts, strict=True):
        assert bits(walled_arm.execute(policy, task)) == bits(rollout)


@pytest.mark.parametrize("n_parallel", [1, 4])
def test_whatever_the_number_of_copies(engine, n_parallel, rollouts):
    with Arm(within(walled, engine), n_parallel=n_parallel) as other:
        found = other.execute_many(policies, tasks)
    assert [bits(one) for one in found] == [bits(one) for one in rollouts]


@pytest.mark.parametrize("seed", range(3))
def test_in_any_slot_after_any_other(walled_arm, rollouts, seed):
    order = np.random.default_rng(seed).permutation(len(tasks))
    found = walled_arm.execute_many(policies[order], tasks[order])
    assert [bits(one) for one in found] == [bits(rollouts[k]) for k in order]


def test_contacts_of_several_links_add_up_in_any_order(engine):
    wild = 16 * np.random.default_rng(1).normal(size=(36, 6))
    layout = within(Workspace(circles=random_circles(0)), engine)
    impulses = []
    for n_parallel in (9, 4):
        with Arm(layout, n_parallel=n_parallel) as arm:
            found = arm.execute_many(wild, 0)
        impulses.append([rollout.contact_impulse for rollout in found])
    assert impulses[0] == impulses[1]


def test_two_arms_do_not_meet(engine, walled_arm, rollouts):
    with Arm(within(walled, engine)) as other, Arm(within(free, engine)) as third:
        if engine == "pybullet":
            assert len({walled_arm.client_id, other.client_id, third.client_id}) == 3
        for k in np.flatnonzero([rollout.touched for rollout in rollouts])[:4]:
            third.execute(policies[k], tasks[k])
            other.execute(-policies[k], tasks[k])
            assert bits(walled_arm.execute(policies[k], tasks[k])) == bits(rollouts[k])


def test_closing_one_arm_leaves_the_other(engine, walled_arm, rollouts):
    Arm(within(walled, engine)).close()
    assert bits(walled_arm.execute(policies[0], tasks[0])) == bits(rollouts[0])


def test_an_arm_may_be_closed_twice(engine):
    arm = Arm(within(free, engine), n_parallel=1)
    arm.close()
    arm.close()
    assert arm.client_id == -1


def test_results_belong_to_the_caller(walled_arm, rollouts):
    before = bits(rollouts[0])
    walled_arm.execute_many(policies[::-1], tasks[::-1])
    assert bits(rollouts[0]) == before


# Bad input


def test_a_rollout_cannot_be_changed(rollouts):
    assert isinstance(rollouts[0], Rollout)
    with pytest.raises(AttributeError):
        rollouts[0].error = 0.0


@pytest.mark.parametrize("shape", [(5,), (3, 2), (), (1, 6)])
def test_a_policy_of_another_shape_is_refused(arm, shape):
    asked = re.escape(f"policy has shape {shape}; wanted (6,)")
    with pytest.raises(ValueError, match=asked):
        arm.execute(np.zeros(shape), 0)


def test_an_arm_without_copies_is_refused():
    with pytest.raises(ValueError, match="n_parallel=0; wanted at least 1"):
        Arm(Workspace.free(), n_parallel=0)


def test_a_closed_arm_executes_nothing(engine):
    with Arm(within(free, engine), n_parallel=1) as closed:
        pass
    with pytest.raises(RuntimeError, match="the arm is closed"):
        closed.execute(np.zeros(6), 0)


def test_rollouts_are_told_apart_by_identity(rollouts):
    assert rollouts[0] == rollouts[0]
    assert len({*rollouts}) == len(rollouts)


def test_a_policy_with_nan_is_refused(arm):
    with pytest.raises(ValueError, match="policy has NaN"):
        arm.execute([0, 0, 0, 0, 0, math.nan], 0)


def test_other_numbers_of_tasks_and_policies_are_refused(arm):
    with pytest.raises(ValueError, match=r"task_deg has shape \(3,\); wanted .* 2"):
        arm.execute_many(np.zeros((2, 6)), [0, 1, 2])


def test_an_arm_follows_plans_as_it_does_those_of_policies(walled_arm, rollouts):
    plans = walled_arm.plan(policies, walled_arm.workspace.target(tasks))
    found = walled_arm.follow(plans, tasks)
    assert [bits(one) for one in found] == [bits(one) for one in rollouts]


def test_a_movement_that_is_stopped_stays_where_it_stopped(arm):
    """The same up to the stop; what it misses is counted to the goal that is given."""
    [plan] = arm.plan(policies[:1], arm.workspace.target([30.0]))
    stopped = np.concatenate([plan[:30], np.tile(plan[30], (len(plan) - 30, 1))])
    whole, halted = arm.follow([plan, stopped], 200.0)
    np.testing.assert_array_equal(halted.joints[:30], whole.joints[:30])
    np.testing.assert_allclose(halted.joints[-1], plan[30], atol=0.02)
    place = forward_kinematics(halted.joints[-1], arm.workspace.link_lengths)[-1]
    missed = np.hypot(*(place - arm.workspace.target(200.0)))
    assert halted.error == pytest.approx(missed, abs=1e-12)


@pytest.mark.parametrize(
    "plans", [np.zeros((2, 66, 3)), np.zeros((67, 3)), np.full((1, 67, 3), np.nan)]
)
def test_plans_of_another_shape_are_refused(arm, plans):
    with pytest.raises(
        ValueError, match=r"plans have shape .*; wanted \(n_plans, 67, 3"
    ):
        arm.follow(plans, 0.0)


def test_a_task_that_is_no_angle_is_refused(arm):
    with pytest.raises(ValueError, match=r"task_deg=.* not finite"):
        arm.execute(np.zeros(6), math.nan)


def test_the_order_of_policies_in_memory_does_not_matter(walled_arm):
    by_column = np.asfortranarray(policies)
    found = walled_arm.execute_many(by_column, tasks)
    expected = walled_arm.execute_many(np.ascontiguousarray(policies), tasks)
    assert [bits(rollout) for rollout in found] == [bits(one) for one in expected]


@pytest.mark.parametrize(
    "n_parallel", [2.5, "9", None, np.nan, 1j, True, 10**7, 257, [9]]
)
def test_a_number_of_copies_that_is_none_is_refused(n_parallel):
    with pytest.raises(ValueError, match=r"n_parallel=.*; wanted at least 1, whole"):
        Arm(free, n_parallel=n_parallel)


@pytest.mark.parametrize(
    ("name", "value", "kind"),
    [
        ("workspace", None, "Workspace"),
        ("workspace", Workspace, "Workspace"),
        ("dmp", 0, "DMP"),
        ("controller", "", "ControllerGains"),
    ],
)
def test_a_part_of_another_kind_is_refused_before_there_is_a_world(name, value, kind):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(TypeError, match=rf"^{name}=.*; wanted a {kind}$"):
            Arm(**({"workspace": free} | {name: value}))
        gc.collect()
