"""The arm: a policy -> path -> joints -> PID torques -> what happened."""

from __future__ import annotations

import threading
import warnings
import weakref
from dataclasses import dataclass
from functools import lru_cache
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import LARGEST, check_kind, check_whole, to_floats
from msc.robot._bullet import BulletWorld
from msc.robot._control import ControllerGains
from msc.robot._dmp import DMP, check_policies
from msc.robot._kinematics import forward_kinematics, inverse_kinematics
from msc.robot._mujoco import MujocoWorld
from msc.robot._turns import World
from msc.robot._workspace import Workspace

_MOST_PARALLEL = 256


@dataclass(frozen=True, eq=False)
class Rollout:
    """What one executed policy did.

    Attributes
    ----------
    joints : ndarray of shape (n_steps + 1, 3)
        Joint angles, the start and then one row per time step (rad).
    path : ndarray of shape (n_steps + 1, 2)
        Positions of the end effector (m).
    error : float
        Distance of the end effector from the target at the end of settling (m).
    energy : float
        Squared joint velocity, the mean of each time step, summed over the joints and
        integrated over the movement and the settling (rad²/s).
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
    def length(self) -> float:
        """Length of the joints' path, the sum over the joints (rad)."""
        return float(np.abs(np.diff(self.joints, axis=0)).sum())

    @property
    def touched(self) -> bool:
        """Whether the arm met an obstacle."""
        return self.contact_impulse > 0


class Arm:
    """A simulated arm that executes policies.

    It takes some 30 MB until it is closed. Threads may share one, which takes them in
    turn: what a policy does depends neither on that nor on what was done before. A
    process that is forked has a copy; an arm cannot be pickled.

    Parameters
    ----------
    workspace : Workspace
        Where it stands.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    controller : ControllerGains, optional
        Gains of the PID controller; by default the workspace's.
    n_parallel : int, default=9
        Copies simulated side by side, from 1 to 256: CMA-ES asks for nine policies at
        a time.

    Raises
    ------
    TypeError
        If `workspace`, `dmp` or `controller` is none.
    ValueError
        If the number of copies is none, or the world's engine is not installed.
    RuntimeError
        If the process has 1024 worlds, which is all that PyBullet takes.

    Warns
    -----
    ResourceWarning
        If it is forgotten without being closed.

    Examples
    --------
    >>> with Arm(Workspace.free()) as arm:
    ...     rollout = arm.execute(np.zeros(6), task_deg=120)
    >>> rollout.joints.shape, rollout.touched
    ((67, 3), False)
    """

    def __init__(
        self,
        workspace: Workspace,
        *,
        dmp: DMP | None = None,
        controller: ControllerGains | None = None,
        n_parallel: int = 9,
    ) -> None:
        check_whole("n_parallel", n_parallel, 1, _MOST_PARALLEL)
        check_kind("workspace", workspace, Workspace)
        dmp = workspace.dmp if dmp is None else dmp
        check_kind("dmp", dmp, DMP)
        controller = workspace.controller if controller is None else controller
        check_kind("controller", controller, ControllerGains)
        self.workspace = workspace
        self.dmp = dmp
        self.n_parallel = n_parallel
        engines: dict[str, type[World]]
        engines = {"pybullet": BulletWorld, "mujoco": MujocoWorld}
        open_world = engines[workspace.physics.engine]
        self._world = open_world(workspace, controller, n_parallel)
        self._unclosed = weakref.finalize(self, _warn_of_unclosed, workspace.name)
        self._unclosed.atexit = False

    @property
    def client_id(self) -> int:
        """PyBullet's number of the physics world, 0 in MuJoCo; -1 once it is closed."""
        return self._world.client_id

    def __enter__(self) -> Arm:
        """Return the arm itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the arm."""
        self.close()

    def __reduce__(self) -> NoReturn:
        """Refuse to be copied or pickled."""
        raise TypeError(
            "an Arm cannot be copied or pickled: its world lives in this process; "
            "wanted another one, made where it is used: Arm(workspace)"
        )

    def close(self) -> None:
        """Free the physics world, after what another thread has it do.

        Raises
        ------
        RuntimeError
            If the call comes from within a rollout, as from a signal's handler.
        """
        self._world.close()
        self._unclosed.detach()

    def execute(self, policy: ArrayLike, task_deg: float) -> Rollout:
        """Execute one policy.

        Parameters
        ----------
        policy : array_like of shape (n_params,)
            Weights of Eq. 7.
        task_deg : float
            Task angle (degrees); where tasks have further numbers, a row of them.

        Returns
        -------
        Rollout
            What happened.

        Raises
        ------
        ValueError
            If the policy has another length or is not finite.
        RuntimeError
            If the arm is closed, or the call comes from within a rollout.
        """
        one = check_policies(policy, self.dmp.n_params, single=True)
        return self.execute_many(one, task_deg)[0]

    def execute_many(self, policies: ArrayLike, task_deg: ArrayLike) -> list[Rollout]:
        """Execute several policies, each from the home pose.

        Parameters
        ----------
        policies : array_like of shape (n_policies, n_params)
            Weights of Eq. 7.
        task_deg : float or array_like of shape (n_policies,)
            Task angle of all, or of each (degrees); where tasks have further numbers,
            a row of them, or as many rows as policies.

        Returns
        -------
        list of Rollout
            What happened, in order.

        Raises
        ------
        ValueError
            If a policy has another length or is not finite, or the lengths differ.
        RuntimeError
            If the arm is closed, also by another thread, or the call comes from within
            a rollout.
        """
        checked = np.atleast_2d(check_policies(policies, self.dmp.n_params))
        tasks = self._tasks(task_deg, len(checked))
        rollouts = []
        for first in range(0, len(checked), self.n_parallel):
            batch = slice(first, first + self.n_parallel)
            targets = self.workspace.target(tasks[batch])
            homes = self.workspace.home_of(tasks[batch])
            plan = self.plan(checked[batch], targets, homes)
            rollouts += self._follow(plan, tasks[batch])
        return rollouts

    def follow(self, plans: ArrayLike, task_deg: ArrayLike) -> list[Rollout]:
        """Follow joint angles, whoever planned them, each from the home pose.

        Parameters
        ----------
        plans : array_like of shape (n_plans, n_steps + 1, 3)
            Joint angles (rad), as `plan` gives them.
        task_deg : float or array_like of shape (n_plans,)
            Task angle of all, or of each (degrees), as for `execute_many`.

        Returns
        -------
        list of Rollout
            What happened, in order.

        Raises
        ------
        ValueError
            If plans have another shape or are not finite, or the lengths differ.
        RuntimeError
            If the arm is closed, also by another thread, or the call comes from within
            a rollout.
        """
        joints = to_floats("plans", plans)
        wanted = (self.workspace.physics.n_steps + 1, 3)
        if joints.shape[1:] != wanted or not (np.abs(joints) <= LARGEST).all():
            raise ValueError(
                f"plans have shape {joints.shape}; wanted (n_plans, {wanted[0]}, "
                f"{wanted[1]}), all of finite angles"
            )
        tasks = self._tasks(task_deg, len(joints))
        rollouts = []
        for first in range(0, len(joints), self.n_parallel):
            batch = slice(first, first + self.n_parallel)
            rollouts += self._follow(joints[batch], tasks[batch])
        return rollouts

    def _tasks(self, task_deg: ArrayLike, n_rollouts: int) -> NDArray[np.float64]:
        """Return the task of each rollout."""
        tasks, further = to_floats("task_deg", task_deg), self.workspace.further
        one: tuple[int, ...] = (len(further) + 1,) if further else ()
        if tasks.shape not in (one, (n_rollouts, *one)):
            what = f"row of {one[0]} numbers" if further else "angle"
            raise ValueError(
                f"task_deg has shape {tasks.shape}; wanted one {what} or "
                f"{n_rollouts}, as many as policies"
            )
        return np.broadcast_to(tasks, (n_rollouts, *one))

    def _follow(
        self, plan: NDArray[np.float64], tasks: NDArray[np.float64]
    ) -> list[Rollout]:
        """Follow as many plans as there are copies, or fewer."""
        world = self.workspace
        targets, homes = world.target(tasks), world.home_of(tasks)
        joints, impulse = self._world.track(plan, homes, world.circles_of(tasks))
        squares = np.sum(np.diff(joints, axis=1) ** 2, axis=(1, 2))
        energy = squares / world.physics.time_step
        path = forward_kinematics(joints, self.workspace.link_lengths)[:, :, -1]
        error = np.hypot(*(path[:, -1] - targets).T)
        numbers = error.tolist(), energy.tolist(), impulse.tolist()
        return [Rollout(*row) for row in zip(joints, path, *numbers, strict=True)]

    def plan(
        self,
        policies: NDArray[np.float64],
        targets: NDArray[np.float64],
        homes: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Turn policies into the joint angles that the controller is to follow.

        Parameters
        ----------
        policies : ndarray of shape (n_policies, n_params)
            Weights of Eq. 7.
        targets : ndarray of shape (n_policies, 2)
            Goals (m).
        homes : ndarray of shape (n_policies, 3), optional
            Joint angles at the start (rad); by default the workspace's home pose.

        Returns
        -------
        ndarray of shape (n_policies, n_steps + 1, 3)
            Joint angles (rad); after the movement the last ones are held.
        """
        world, physics = self.workspace, self.workspace.physics
        home = np.asarray(world.home if homes is None else homes)
        start = forward_kinematics(home, world.link_lengths)[..., -1, :]
        times = physics.time_step * np.arange(physics.n_moving + 1)
        path = self.dmp.path(policies, start, targets, times)
        moving = inverse_kinematics(path, home, world.link_lengths)
        n_settling = physics.n_steps - physics.n_moving
        held = moving[:, -1:].repeat(n_settling, axis=1)
        return np.concatenate([moving, held], axis=1)


def _warn_of_unclosed(name: str) -> None:
    """Warn of an arm that was forgotten; its world is freed."""
    warnings.warn(
        f"an arm (workspace {name!r}) was not closed; wanted close(), or "
        "`with Arm(workspace) as arm:`",
        ResourceWarning,
        stacklevel=2,
    )


def _forgettable_arm(workspace: Workspace, dmp: DMP, n_parallel: int) -> Arm:
    """Build an arm that may be forgotten."""
    arm = Arm(workspace, dmp=dmp, n_parallel=n_parallel)
    arm._unclosed.detach()
    return arm


class _ArmCache(threading.local):
    """The arms that a thread keeps, freed as it ends."""

    def __init__(self) -> None:
        self.arm = lru_cache(maxsize=6)(_forgettable_arm)


_cache = _ArmCache()


def cached_arm(
    workspace: Workspace, dmp: DMP | None = None, *, n_parallel: int = 9
) -> Arm:
    """Return the arm that this thread keeps for a world: building one takes time.

    Parameters
    ----------
    workspace : Workspace
        Where it stands.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    n_parallel : int, default=9
        Copies simulated side by side.

    Returns
    -------
    Arm
        Not to be closed: the thread keeps six, and frees them as it ends. What it does
        does not depend on what it did before.
    """
    return _cache.arm(workspace, dmp or workspace.dmp, n_parallel)
