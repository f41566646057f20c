"""The arm in PyBullet: a policy -> path -> joints -> PID torques -> what happened.

The only module that imports PyBullet. One physics world carries `n_parallel` copies of
the arm on the same spot: they start from the same pose, meet the same obstacles, pass
through one another, and are controlled and stepped together. This is what makes a
rollout cost little more than its physics. Each copy is a body, and so a solver island,
of its own: a test holds it to do, bit for bit, what it would do alone.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from msc.dmp import DMP, check_policies
from msc.kinematics import follow_path
from msc.workspace import LINK_RADIUS, Workspace, chain

TIME_STEP = 1 / 240  # s; of the physics and of the controller
N_MOVING, N_SETTLING = 240, 24  # steps: one second of movement, a tenth to settle
N_STEPS = N_MOVING + N_SETTLING
PLAN_EVERY = 4  # steps; inverse kinematics at 60 Hz, cubic splines between


@dataclass(frozen=True)
class Controller:
    """Gains of the PID controller, one number per joint.

    Proportional gains are the joints' largest inertias times (20 rad/s)², derivative
    gains make them critically damped, and the integral term, which has no weight to
    hold up in a horizontal plane, only removes what is left. It is clamped to a tenth
    of the torque limits so that an arm stopped by an obstacle does not wind up.
    """

    proportional: tuple[float, float, float] = (280.0, 60.0, 4.2)  # N m / rad
    integral: tuple[float, float, float] = (280.0, 60.0, 4.2)  # N m / (rad s)
    derivative: tuple[float, float, float] = (28.0, 6.0, 0.42)  # N m s / rad
    torque_limit: tuple[float, float, float] = (40.0, 20.0, 5.0)  # N m


@dataclass(frozen=True)
class Rollout:
    """What one executed policy did.

    Attributes
    ----------
    joints : ndarray of shape (n_steps + 1, 3)
        Joint angles, the start and then one row per physics step (rad).
    path : ndarray of shape (n_steps + 1, 2)
        Positions of the end effector (m).
    error : float
        Distance of the end effector from the target at the end of settling (m).
    energy : float
        Squared joint velocity, summed over the joints and integrated over the movement
        and the settling (rad²/s).
    contact_impulse : float
        Normal force of all contacts with obstacles, integrated over time (N s).
    touched : bool
        Whether the arm met an obstacle.
    """

    joints: NDArray[np.float64]
    path: NDArray[np.float64]
    error: float
    energy: float
    contact_impulse: float

    @property
    def touched(self) -> bool:
        """Whether the arm met an obstacle."""
        return self.contact_impulse > 0


class Arm:
    """A simulated arm that executes policies.

    Parameters
    ----------
    workspace : Workspace
        Where it stands.
    dmp : DMP, optional
        What a policy means; by default ``DMP()``.
    controller : Controller, optional
        Gains of the PID controller; by default ``Controller()``.
    n_parallel : int, default=9
        Copies simulated side by side: CMA-ES asks for nine policies at a time.

    Examples
    --------
    >>> with Arm(Workspace.free()) as arm:
    ...     rollout = arm.execute(np.zeros(6), task_deg=120)
    >>> rollout.joints.shape, rollout.touched
    ((265, 3), False)
    """

    def __init__(
        self,
        workspace: Workspace,
        *,
        dmp: DMP | None = None,
        controller: Controller | None = None,
        n_parallel: int = 9,
    ) -> None:
        self.workspace = workspace
        self.dmp = dmp or DMP()
        self.controller = controller or Controller()
        self.n_parallel = n_parallel
        self._bullet = load_pybullet()
        self.client_id: int = self._bullet.connect(self._bullet.DIRECT)
        self._bodies = self._load_arms()
        self._obstacles = [self._load_obstacle(*c) for c in workspace.circles]
        knots = np.arange(0, N_MOVING + 1, PLAN_EVERY)
        spline = CubicSpline(knots, np.eye(len(knots)))
        moving = np.arange(N_STEPS + 1).clip(max=N_MOVING)
        self._knot_times = knots * TIME_STEP
        self._interpolation = spline(moving)  # (n_steps + 1, n_knots)

    def __enter__(self) -> Arm:
        """Return the arm itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the arm."""
        self.close()

    def close(self) -> None:
        """Free the physics world."""
        if self.client_id >= 0:
            self._bullet.disconnect(self.client_id)
            self.client_id = -1

    def execute(self, policy: ArrayLike, task_deg: float) -> Rollout:
        """Execute one policy.

        Parameters
        ----------
        policy : array_like of shape (n_params,)
            Weights of Eq. 7.
        task_deg : float
            Task angle (degrees).

        Returns
        -------
        Rollout
            What happened.
        """
        return self.execute_many(np.asarray(policy, dtype=float)[None], task_deg)[0]

    def execute_many(
        self, policies: ArrayLike, task_deg: float | Sequence[float]
    ) -> list[Rollout]:
        """Execute several policies, each from the home pose.

        Parameters
        ----------
        policies : array_like of shape (n_policies, n_params)
            Weights of Eq. 7.
        task_deg : float or array_like of shape (n_policies,)
            Task angle of all, or of each (degrees).

        Returns
        -------
        list of Rollout
            What happened, in order.

        Raises
        ------
        ValueError
            If a policy has another length or is not finite, or the lengths differ.
        """
        checked = np.atleast_2d(check_policies(policies, self.dmp.n_params))
        angles = np.asarray(task_deg, dtype=float)
        if angles.ndim and angles.shape != (len(checked),):
            raise ValueError(
                f"task_deg has shape {angles.shape}; wanted one angle or "
                f"{len(checked)}, as many as policies"
            )
        targets = np.broadcast_to(self.workspace.target(angles), (len(checked), 2))
        rollouts = []
        for first in range(0, len(checked), self.n_parallel):
            batch = slice(first, first + self.n_parallel)
            plan = self.plan(checked[batch], targets[batch])
            joints, energy, impulse = self.track(plan)
            path = chain(joints, self.workspace.link_lengths)[:, :, -1]
            error = np.hypot(*(path[:, -1] - targets[batch]).T)
            rollouts += [
                Rollout(j, p, float(d), float(e), float(i))
                for j, p, d, e, i in zip(
                    joints, path, error, energy, impulse, strict=True
                )
            ]
        return rollouts

    def plan(
        self, policies: NDArray[np.float64], targets: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Turn policies into the joint angles that the controller is to follow.

        Parameters
        ----------
        policies : ndarray of shape (n_policies, n_params)
            Weights of Eq. 7.
        targets : ndarray of shape (n_policies, 2)
            Goals (m).

        Returns
        -------
        ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles (rad); after the movement the last ones are held.
        """
        world = self.workspace
        start = chain(world.home, world.link_lengths)[-1]
        path = self.dmp.path(policies, start, targets, self._knot_times)
        joints = follow_path(path, world.home, world.link_lengths)
        return np.asarray(self._interpolation @ joints)

    def track(
        self, plan: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Follow planned joint angles by PID torques in the physics world.

        Parameters
        ----------
        plan : ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles to follow (rad), for at most `n_parallel` arms.

        Returns
        -------
        joints : ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles that came about (rad).
        energy : ndarray of shape (n_policies,)
            Their `Rollout.energy` (rad²/s).
        impulse : ndarray of shape (n_policies,)
            Their `Rollout.contact_impulse` (N s).
        """
        bullet, client = self._bullet, self.client_id
        n_arms, n_rows = plan.shape[:2]
        wanted = np.tile(self.workspace.home, (n_rows, self.n_parallel))
        wanted[:, : 3 * n_arms] = plan.transpose(1, 0, 2).reshape(n_rows, -1)
        kp, ki, kd, limit = (
            np.tile(gain, self.n_parallel) for gain in astuple(self.controller)
        )
        ki, windup = ki * TIME_STEP, limit / 10
        drive = kp * wanted[1:] + kd * np.diff(wanted, axis=0) / TIME_STEP
        integral = np.zeros_like(limit)
        states = np.empty((n_rows, len(limit), 2))
        impulse = np.zeros(self.n_parallel)
        self._reset()
        states[0] = self._read()
        for step in range(n_rows - 1):
            position, velocity = states[step].T
            integral += ki * (wanted[step + 1] - position)
            np.maximum(np.minimum(integral, windup, out=integral), -windup, integral)
            torque = drive[step] - kp * position - kd * velocity + integral
            np.maximum(np.minimum(torque, limit, out=torque), -limit, torque)
            forces = torque.reshape(-1, 3).tolist()
            for body, force in zip(self._bodies, forces, strict=True):
                bullet.setJointMotorControlArray(
                    body,
                    _JOINTS,
                    bullet.TORQUE_CONTROL,
                    forces=force,
                    physicsClientId=client,
                )
            bullet.stepSimulation(physicsClientId=client)
            states[step + 1] = self._read()
            if self._obstacles:
                for contact in bullet.getContactPoints(physicsClientId=client):
                    body, force = contact[1], contact[9]
                    impulse[self._bodies.index(body)] += force * TIME_STEP
        states = states[:, : 3 * n_arms].reshape(n_rows, n_arms, 3, 2)
        joints = np.ascontiguousarray(states[..., 0].transpose(1, 0, 2))
        energy = TIME_STEP * np.sum(states[1:, ..., 1] ** 2, axis=(0, 2))
        return joints, energy, impulse[:n_arms]

    def _read(self) -> list[tuple[float, float]]:
        """Return position and velocity of every joint of every arm."""
        read, client = self._bullet.getJointStates, self.client_id
        return [
            state[:2]
            for body in self._bodies
            for state in read(body, _JOINTS, physicsClientId=client)
        ]

    def _reset(self) -> None:
        """Put every arm at rest in the home pose and forget every contact."""
        bullet, client = self._bullet, self.client_id
        for body in self._bodies:
            for joint, angle in zip(_JOINTS, self.workspace.home, strict=True):
                bullet.resetJointState(body, joint, angle, 0.0, physicsClientId=client)
        for obstacle in self._obstacles:  # renews its proxy: no cached contact is left
            bullet.setCollisionFilterGroupMask(
                obstacle, -1, *_OBSTACLE_FILTER, physicsClientId=client
            )

    def _load_arms(self) -> list[int]:
        """Build the physics world with its arms."""
        bullet, client = self._bullet, self.client_id
        bullet.setTimeStep(TIME_STEP, physicsClientId=client)
        bullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1,
            minimumSolverIslandSize=1,  # contacts of one arm are solved apart
            solverResidualThreshold=0.0,
            physicsClientId=client,
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "arm.urdf")
            file.write_text(_urdf(self.workspace))
            bodies: list[int] = [
                bullet.loadURDF(str(file), useFixedBase=True, physicsClientId=client)
                for _ in range(self.n_parallel)
            ]
        for body in bodies:
            for link in (-1, *_JOINTS):
                bullet.changeDynamics(
                    body,
                    link,
                    linearDamping=0.0,
                    angularDamping=0.0,
                    jointDamping=0.0,
                    physicsClientId=client,
                )
                bullet.setCollisionFilterGroupMask(
                    body, link, *_ARM_FILTER, physicsClientId=client
                )
            bullet.setJointMotorControlArray(
                body,
                _JOINTS,
                bullet.VELOCITY_CONTROL,
                forces=[0.0, 0.0, 0.0],
                physicsClientId=client,
            )
        return bodies

    def _load_obstacle(self, x: float, y: float, radius: float) -> int:
        """Add an immovable, frictionless cylinder."""
        bullet, client = self._bullet, self.client_id
        shape = bullet.createCollisionShape(
            bullet.GEOM_CYLINDER, radius=radius, height=0.2, physicsClientId=client
        )
        body: int = bullet.createMultiBody(
            0.0, shape, basePosition=[x, y, 0.0], physicsClientId=client
        )
        bullet.changeDynamics(body, -1, lateralFriction=0.0, physicsClientId=client)
        return body


_JOINTS = [0, 1, 2]
_ARM_FILTER, _OBSTACLE_FILTER = (2, 1), (1, 2)  # group, mask: arms meet obstacles only


def _urdf(workspace: Workspace) -> str:
    """Describe the arm; one element a line, as PyBullet's parser wants it."""
    lines = [
        '<robot name="arm">',
        '<link name="link_0">',
        '<inertial><mass value="1"/>',
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>',
        "</link>",
    ]
    offset = 0.0
    links = zip(workspace.link_lengths, workspace.link_masses, strict=True)
    for number, (length, mass) in enumerate(links, start=1):
        rod = mass * length**2 / 12
        lines += [
            f'<link name="link_{number}">',
            f'<inertial><origin xyz="{length / 2} 0 0"/>',
            f'<mass value="{mass}"/>',
            f'<inertia ixx="{rod / 100}" iyy="{rod}" izz="{rod}"',
            ' ixy="0" ixz="0" iyz="0"/></inertial>',
            "<collision>",
            f'<origin xyz="{length / 2} 0 0" rpy="0 {math.pi / 2} 0"/>',
            f'<geometry><capsule radius="{LINK_RADIUS}" length="{length}"/></geometry>',
            "</collision>",
            "</link>",
            f'<joint name="joint_{number}" type="continuous">',
            f'<parent link="link_{number - 1}"/>',
            f'<child link="link_{number}"/>',
            f'<origin xyz="{offset} 0 0"/>',
            '<axis xyz="0 0 1"/>',
            "</joint>",
        ]
        offset = length
    return "\n".join([*lines, "</robot>"])


def load_pybullet() -> Any:
    """Import PyBullet without the line it prints past Python's own streams."""
    with _quiet():
        import pybullet  # noqa: PLC0415
    return pybullet


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Send the process's output nowhere, that of C libraries included."""
    saved = [os.dup(stream) for stream in (1, 2)]
    null = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(null, stream)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        for stream, copy in zip((1, 2), saved, strict=True):
            os.dup2(copy, stream)
            os.close(copy)
        os.close(null)
