"""The plain way to execute a policy: one arm, one step after the other, at 240 Hz.

At each step the loop takes the next point of the path, goes towards it by one step of
damped least squares, asks the controller for torques, and steps the physics. It comes
with two kinds of arithmetic: NumPy's arrays of three numbers, as one would first write
it, and Python's own floats, which is the quickest that a loop over single arms gets.
Controller, dynamics and damping are those of `msc`.
"""

from cmath import rect
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from msc import DMP, Workspace
from msc.robot import TIME_STEP, Physics, forward_kinematics, joint_torques
from msc.robot._bullet import BulletWorld, load_pybullet
from msc.robot._control import ControllerGains, coupled_inertias
from msc.robot._kinematics import DAMPING
from msc.search import ENERGY_WEIGHT, ERROR_WEIGHT

PHYSICS = Physics()
STEP = TIME_STEP / PHYSICS.substeps  # s
N_PHYSICS_STEPS = PHYSICS.substeps * PHYSICS.n_steps
ARM, JOINTS = 0, [0, 1, 2]  # a world's first body is its arm

bullet = load_pybullet()


class PlainArm:
    """One arm in a world of its own, stepped at 240 Hz without sub-steps."""

    def __init__(self, workspace: Workspace) -> None:
        self.workspace, self.dmp = workspace, DMP()
        self.times = np.arange(1, PHYSICS.substeps * PHYSICS.n_moving + 1) * STEP
        self._world = BulletWorld(workspace, ControllerGains(), n_arms=1)
        self.client = self._world.client_id
        bullet.setTimeStep(STEP, physicsClientId=self.client)
        bullet.setPhysicsEngineParameter(numSubSteps=0, physicsClientId=self.client)
        self._home = np.array([workspace.home])
        self._circles = workspace.circles_of(np.zeros(1))
        self._world._reset(self._home, self._circles)  # at rest, the obstacles solid

    def step_only(self) -> None:
        """Step the physics as often as a rollout does; read nothing, set nothing."""
        for _ in range(N_PHYSICS_STEPS):
            bullet.stepSimulation(physicsClientId=self.client)

    def execute(
        self,
        policy: np.ndarray,
        task_deg: float,
        follower: "type[ArrayFollower | FloatFollower]",
    ) -> tuple[float, np.ndarray]:
        """Execute a policy; return its cost and where the end effector ends."""
        workspace, client = self.workspace, self.client
        target = workspace.target(task_deg)
        start = forward_kinematics(workspace.home, workspace.link_lengths)[-1]
        path = self.dmp.path(policy, start, target, self.times).tolist()
        pursuit = follower(workspace, ControllerGains())
        self._world._reset(self._home, self._circles)
        angles, speed, impulse = [workspace.home], (0.0, 0.0, 0.0), 0.0
        for step in range(N_PHYSICS_STEPS):
            point = path[min(step, len(path) - 1)]
            bullet.setJointMotorControlArray(
                ARM,
                JOINTS,
                bullet.TORQUE_CONTROL,
                forces=pursuit.torques(point, angles[-1], speed),
                physicsClientId=client,
            )
            bullet.stepSimulation(physicsClientId=client)
            states = bullet.getJointStates(ARM, JOINTS, physicsClientId=client)
            angle, speed, _, _ = zip(*states, strict=True)
            angles.append(angle)
            if workspace.circles:
                for contact in bullet.getContactPoints(physicsClientId=client):
                    impulse += STEP * contact[9]
        end = forward_kinematics(angles[-1], workspace.link_lengths)[-1]
        energy = np.sum(np.diff(angles, axis=0) ** 2) / STEP
        error = np.linalg.norm(end - target)
        return ERROR_WEIGHT * error**2 + ENERGY_WEIGHT * energy, end


class ArrayFollower:
    """Inverse kinematics and PID control by NumPy."""

    def __init__(self, workspace: Workspace, controller: ControllerGains) -> None:
        self.lengths = np.array(workspace.link_lengths)
        self.inertias = coupled_inertias(self.lengths, workspace.link_masses)
        self.windup, self.rate = controller.windup, controller.bandwidth
        self.limit = np.array(controller.torque_limit)
        self.wanted = np.array(workspace.home)
        self.speed, self.integral = np.zeros(3), np.zeros(3)

    def torques(
        self, point: Sequence[float], angle: Sequence[float], speed: Sequence[float]
    ) -> np.ndarray:
        """Decide the torques of a step from the path's next point and the motion."""
        joint_step = self.joint_step(np.array(point))
        acceleration = (joint_step / STEP - self.speed) / STEP
        self.wanted, self.speed = self.wanted + joint_step, joint_step / STEP
        error = self.wanted - angle
        self.integral = self.integral + STEP * error
        self.integral = np.clip(self.integral, -self.windup, self.windup)
        acceleration = (
            acceleration
            + 3 * self.rate**2 * error
            + 3 * self.rate * (self.speed - speed)
            + self.rate**3 * self.integral
        )
        torque = joint_torques([angle, speed, acceleration], self.inertias)
        return np.clip(torque, -self.limit, self.limit)

    def joint_step(self, point: np.ndarray) -> np.ndarray:
        """Find the joint motion that takes the end effector to a point."""
        heading = np.cumsum(self.wanted)
        links = self.lengths * np.array([np.cos(heading), np.sin(heading)])
        arms = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]  # from each joint to the end
        jacobian = np.array([-arms[1], arms[0]])
        square = jacobian @ jacobian.T + DAMPING**2 * np.eye(2)
        return jacobian.T @ np.linalg.solve(square, point - arms[:, 0])


class FloatFollower:
    """The same by floats and complex numbers, which for three joints are quicker."""

    def __init__(self, workspace: Workspace, controller: ControllerGains) -> None:
        self.lengths = workspace.link_lengths
        self.inertias = coupled_inertias(self.lengths, workspace.link_masses).tolist()
        self.windup, self.rate = controller.windup, controller.bandwidth
        self.limit = controller.torque_limit
        self.wanted = list(workspace.home)
        self.speed, self.integral = [0.0] * 3, [0.0] * 3

    def torques(
        self, point: Sequence[float], angle: Sequence[float], speed: Sequence[float]
    ) -> list[float]:
        """Decide the torques of a step from the path's next point and the motion."""
        rate, windup = self.rate, self.windup
        accelerations = []
        for joint, joint_step in enumerate(self.joint_step(complex(*point))):
            planned_speed = joint_step / STEP
            acceleration = (planned_speed - self.speed[joint]) / STEP
            self.speed[joint] = planned_speed
            self.wanted[joint] += joint_step
            error = self.wanted[joint] - angle[joint]
            integral = self.integral[joint] + STEP * error
            self.integral[joint] = integral = max(-windup, min(windup, integral))
            accelerations.append(
                acceleration
                + 3 * rate**2 * error
                + 3 * rate * (planned_speed - speed[joint])
                + rate**3 * integral
            )
        torques = self.inverse_dynamics(angle, speed, accelerations)
        return [
            max(-limit, min(limit, torque))
            for torque, limit in zip(torques, self.limit, strict=True)
        ]

    def joint_step(self, point: complex) -> list[float]:
        """Find the joint motion, as `inverse_kinematics` does for many arms."""
        a, b, c = map(rect, self.lengths, accumulate(self.wanted))
        columns = 1j * (a + b + c), 1j * (b + c), 1j * c
        error = point - (a + b + c)
        p = 0.5 * sum(abs(j) ** 2 for j in columns) + DAMPING**2
        r = 0.5 * sum(j * j for j in columns)
        y = (p * error - r * error.conjugate()) / (p * p - abs(r) ** 2)
        return [(j.conjugate() * y).real for j in columns]

    def inverse_dynamics(
        self,
        angle: Sequence[float],
        speed: Sequence[float],
        acceleration: Sequence[float],
    ) -> list[float]:
        """Find the torques, as `msc.robot.joint_torques` does for many arms."""
        motion = zip(*map(accumulate, (angle, speed, acceleration)), strict=True)
        links, pulled = [], []
        for heading, turning, turning_faster in motion:
            link = rect(1.0, heading)
            links.append(link.conjugate())
            pulled.append(complex(-turning * turning, turning_faster) * link)
        x, y, z = pulled
        about = [
            (link * (i * x + j * y + k * z)).imag
            for link, (i, j, k) in zip(links, self.inertias, strict=True)
        ]
        return [about[0] + about[1] + about[2], about[1] + about[2], about[2]]
