"""The arm: a policy -> path -> joints -> PID torques -> what happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.arrays import to_floats
from msc.bullet import World
from msc.control import TIME_STEP, Controller
from msc.dmp import DMP, check_policies
from msc.geometry import chain
from msc.kinematics import follow_path
from msc.workspace import Workspace

N_MOVING, N_SETTLING = 60, 6  # steps: one second of movement, a tenth to settle
N_STEPS = N_MOVING + N_SETTLING


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
    ((67, 3), False)
    """

    def __init__(
        self,
        workspace: Workspace,
        *,
        dmp: DMP | None = None,
        controller: Controller | None = None,
        n_parallel: int = 9,
    ) -> None:
        if n_parallel < 1:
            raise ValueError(f"n_parallel={n_parallel}; wanted at least 1")
        self.workspace = workspace
        self.dmp = dmp or DMP()
        self.n_parallel = n_parallel
        self._world = World(workspace, controller or Controller(), n_parallel)

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

    def close(self) -> None:
        """Free the physics world."""
        self._world.close()

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
        """
        checked = np.atleast_2d(check_policies(policies, self.dmp.n_params))
        angles = to_floats("task_deg", task_deg)
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
            joints, impulse = self._world.track(plan)
            energy = np.sum(np.diff(joints, axis=1) ** 2, axis=(1, 2)) / TIME_STEP
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
        times = TIME_STEP * np.arange(N_MOVING + 1)
        path = self.dmp.path(policies, start, targets, times)
        moving = follow_path(path, world.home, world.link_lengths)
        held = moving[:, -1:].repeat(N_SETTLING, axis=1)
        return np.concatenate([moving, held], axis=1)


@lru_cache(maxsize=4)
def kept_arm(workspace: Workspace, dmp: DMP | None = None) -> Arm:
    """Return the arm that this process keeps for a world: building one takes time.

    Parameters
    ----------
    workspace : Workspace
        Where it stands.
    dmp : DMP, optional
        What a policy means; by default ``DMP()``.

    Returns
    -------
    Arm
        Not to be closed. What it does does not depend on what it did before.
    """
    return Arm(workspace, dmp=dmp)
