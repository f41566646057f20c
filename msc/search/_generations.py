"""What CMA-ES tries, generation by generation: a search that is looked at.

The search itself keeps only what it found. Here its very runs are made again while all
that they execute is recorded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from msc.robot import DMP, Arm, Workspace, cached_arm
from msc.search._cmaes import CmaRun, minimize
from msc.search._policy import (
    FIRST_STEP,
    cost,
    initial_covariance,
    random_start,
    start_generator,
)


@dataclass(frozen=True)
class SearchTrace:
    """One run of CMA-ES and all that it tried.

    Attributes
    ----------
    run : CmaRun
        What was found, the same as in `SearchResult.runs`.
    policies : ndarray of shape (n_generations, n_policies, n_params)
        Weights of Eq. 7, in the order in which they were tried.
    costs : ndarray of shape (n_generations, n_policies)
        What each costs.
    joints : ndarray of shape (n_generations, n_policies, n_steps + 1, 3)
        What the arm did (rad).
    """

    run: CmaRun
    policies: NDArray[np.float64]
    costs: NDArray[np.float64]
    joints: NDArray[np.float64]

    @property
    def evaluations(self) -> NDArray[np.intp]:
        """Rollouts spent after each generation, of shape (n_generations,)."""
        n_generations, n_policies = self.costs.shape
        return np.arange(n_policies, n_policies * n_generations + 1, n_policies)

    @property
    def best_costs(self) -> NDArray[np.float64]:
        """Least cost up to each generation, of shape (n_generations,)."""
        return np.minimum.accumulate(self.costs.min(axis=1))


def record_search(
    workspace: Workspace,
    task_deg: float,
    *,
    seed: int,
    n_starts: int = 4,
) -> list[SearchTrace]:
    """Search as `search_policy` does, and keep all that is tried.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    seed : int
        Seed of all random draws, together with the task and the start's number.
    n_starts : int, default=4
        Independent starts: from the zero policy, then from random ones.

    Returns
    -------
    list of SearchTrace
        One a start, in order.

    Raises
    ------
    ValueError
        If there is no start.

    Examples
    --------
    >>> [trace] = record_search(Workspace.free(), 200, seed=1, n_starts=1)
    >>> bool(trace.best_costs[-1] == trace.run.cost < trace.best_costs[0])
    True
    """
    if n_starts < 1:
        raise ValueError(f"n_starts={n_starts}; wanted at least one")
    dmp = DMP()
    shape = initial_covariance(workspace, task_deg, dmp)
    arm = cached_arm(workspace, dmp)
    traces: list[SearchTrace] = []
    for number in range(n_starts):
        tape = _Tape(arm, task_deg)
        rng = start_generator(seed, task_deg, number)
        run = minimize(
            tape,
            random_start(number, dmp, rng),
            FIRST_STEP * dmp.spring,
            rng,
            shape,
            name=f"start {number}",
            known=[trace.run for trace in traces],
        )
        traces.append(SearchTrace(run, *tape.arrays()))
    return traces


class _Tape:
    """Gives the costs of policies, and remembers what was asked and what happened."""

    def __init__(self, arm: Arm, task_deg: float) -> None:
        self._arm, self._task_deg = arm, task_deg
        self._seen: list[tuple[NDArray[np.float64], ...]] = []

    def __call__(self, policies: NDArray[np.float64]) -> list[float]:
        rollouts = self._arm.execute_many(policies, self._task_deg)
        costs = [cost(rollout) for rollout in rollouts]
        joints = np.array([rollout.joints for rollout in rollouts])
        self._seen.append((policies.copy(), np.array(costs), joints))
        return costs

    def arrays(self) -> tuple[NDArray[np.float64], ...]:
        """Stack policies, costs and joints, generation by generation."""
        return tuple(np.array(kind) for kind in zip(*self._seen, strict=True))
