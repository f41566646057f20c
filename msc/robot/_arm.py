"""The arm: a policy -> path -> joints -> PID torques -> what happened."""

from __future__ import annotations

import threading
import warnings
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import LARGEST, check_kind, check_whole, to_floats
from msc.robot._bullet import BulletWorld
from msc.robot._control import TIME_STEP, ControllerGains
from msc.robot._dmp import DMP, check_policies
from msc.robot._kinematics import forward_kinematics, inverse_kinematics
from msc.robot._workspace import Workspace

N_MOVING, N_SETTLING = 60, 6  # steps: one second of movement, a tenth to settle
N_STEPS = N_MOVING + N_SETTLING
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
        What a policy means; by default ``DMP()``.
    controller : ControllerGains, optional
        Gains of the PID controller; by default ``ControllerGains()``.
    n_parallel : int, default=9
        Copies simulated side by side, from 1 to 256: CMA-ES asks for nine policies at
        a time.

    Raises
    ------
    TypeError
        If `workspace`, `dmp` or `controller` is none.
    ValueError
        If the number of copies is none.
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
        dmp = DMP() if dmp is None else dmp
        check_kind("dmp", dmp, DMP)
        controller = ControllerGains() if controller is None else controller
        check_kind("controller", controller, ControllerGains)
        self.workspace = workspace
        self.dmp = dmp
        self.n_parallel = n_parallel
        self._world = BulletWorld(workspace, controller, n_parallel)
        self._unclosed = weakref.finalize(self, _warn_of_unclosed, workspace.name)
        self._unclosed.atexit = False

    @property
    def client_id(self) -> int:
        """PyBullet's number of the physics world."""
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
            Task angle (degrees).

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
        RuntimeError
            If the arm is closed, also by another thread, or the call comes from within
            a rollout.
        """
        checked = np.atleast_2d(check_policies(policies, self.dmp.n_params))
        targets = self._targets(task_deg, len(checked))
        rollouts = []
        for first in range(0, len(checked), self.n_parallel):
            batch = slice(first, first + self.n_parallel)
            plan = self.plan(checked[batch], targets[batch])
            rollouts += self._follow(plan, targets[batch])
        return rollouts

    def follow(
        self, plans: ArrayLike, task_deg: float | Sequence[float]
    ) -> list[Rollout]:
        """Follow joint angles, whoever planned them, each from the home pose.

        Parameters
        ----------
        plans : array_like of shape (n_plans, n_steps + 1, 3)
            Joint angles (rad), as `plan` gives them.
        task_deg : float or array_like of shape (n_plans,)
            Task angle of all, or of each (degrees).

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
        wanted = (N_STEPS + 1, 3)
        if joints.shape[1:] != wanted or not (np.abs(joints) <= LARGEST).all():
            raise ValueError(
                f"plans have shape {joints.shape}; wanted (n_plans, {wanted[0]}, "
                f"{wanted[1]}), all of finite angles"
            )
        targets = self._targets(task_deg, len(joints))
        rollouts = []
        for first in range(0, len(joints), self.n_parallel):
            batch = slice(first, first + self.n_parallel)
            rollouts += self._follow(joints[batch], targets[batch])
        return rollouts

    def _targets(
        self, task_deg: float | Sequence[float], n_rollouts: int
    ) -> NDArray[np.float64]:
        """Return the goal of each rollout."""
        angles = to_floats("task_deg", task_deg)
        if angles.ndim and angles.shape != (n_rollouts,):
            raise ValueError(
                f"task_deg has shape {angles.shape}; wanted one angle or "
                f"{n_rollouts}, as many as policies"
            )
        return np.broadcast_to(self.workspace.target(angles), (n_rollouts, 2))

    def _follow(
        self, plan: NDArray[np.float64], targets: NDArray[np.float64]
    ) -> list[Rollout]:
        """Follow as many plans as there are copies, or fewer."""
        joints, impulse = self._world.track(plan)
        energy = np.sum(np.diff(joints, axis=1) ** 2, axis=(1, 2)) / TIME_STEP
        path = forward_kinematics(joints, self.workspace.link_lengths)[:, :, -1]
        error = np.hypot(*(path[:, -1] - targets).T)
        numbers = error.tolist(), energy.tolist(), impulse.tolist()
        return [Rollout(*row) for row in zip(joints, path, *numbers, strict=True)]

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
        start = forward_kinematics(world.home, world.link_lengths)[-1]
        times = TIME_STEP * np.arange(N_MOVING + 1)
        path = self.dmp.path(policies, start, targets, times)
        moving = inverse_kinematics(path, world.home, world.link_lengths)
        held = moving[:, -1:].repeat(N_SETTLING, axis=1)
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
        What a policy means; by default ``DMP()``.
    n_parallel : int, default=9
        Copies simulated side by side.

    Returns
    -------
    Arm
        Not to be closed: the thread keeps six, and frees them as it ends. What it does
        does not depend on what it did before.
    """
    return _cache.arm(workspace, dmp or DMP(), n_parallel)
