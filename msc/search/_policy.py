"""The search: what a rollout costs, and from one task to its policy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.robot import (
    DMP,
    Rollout,
    Workspace,
    cached_arm,
    check_policies,
    forward_kinematics,
)
from msc.search._cmaes import CmaRun, minimize

ERROR_WEIGHT = 100.0  # 1/m²
ENERGY_WEIGHT = 0.005  # s/rad²
FIRST_STEP, SMALL_STEP = 0.5, 0.006  # of CMA-ES, in spring constants
SAME = 0.01  # of a policy's norm: a start that ends so near has found it too


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The policy found for a task, and how.

    Attributes
    ----------
    task_deg : float
        Task angle (degrees).
    policy : ndarray of shape (n_params,)
        Weights of Eq. 7.
    cost : float
        Its cost, see `cost`.
    error, energy, contact_impulse : float
        What its rollout measured, see `Rollout`.
    runs : tuple of CmaRun
        All runs of CMA-ES, in order; the cheapest gave the policy.
    """

    task_deg: float
    policy: NDArray[np.float64]
    cost: float
    error: float
    energy: float
    contact_impulse: float
    runs: tuple[CmaRun, ...]

    @property
    def evaluations(self) -> int:
        """Rollouts spent, over all starts."""
        return sum(run.evaluations for run in self.runs)

    @property
    def winner(self) -> str:
        """Name of the run that gave the policy."""
        return self.runs[self._best].name

    @property
    def n_agreeing(self) -> int:
        """Starts that ended at the policy, or were stopped on their way to it."""
        return len(self.runs) - len(self._others)

    @property
    def margin(self) -> float:
        """Cost of the best run that ended elsewhere, over the policy's; NaN if none.

        A small margin tells of two behaviours that are nearly tied.
        """
        costs = [run.cost for run in self._others]
        return min(costs) - self.cost if costs else float("nan")

    @property
    def _best(self) -> int:
        """Number of the run that gave the policy."""
        costs = [run.cost for run in self.runs]
        return costs.index(min(costs))

    @property
    def _others(self) -> list[CmaRun]:
        """Starts that did not end at the policy."""
        ends = [
            number if run.merged_into < 0 else run.merged_into
            for number, run in enumerate(self.runs)
        ]
        reach = SAME * np.linalg.norm(self.policy)
        there = [np.linalg.norm(run.policy - self.policy) <= reach for run in self.runs]
        return [run for run, end in zip(self.runs, ends, strict=True) if not there[end]]


def cost(rollout: Rollout) -> float:
    """Weigh what a rollout missed against how much it moved.

    Parameters
    ----------
    rollout : Rollout
        What happened.

    Returns
    -------
    float
        100/m² · error² + 0.005 s/rad² · energy: one centimetre weighs as much as
        2 rad²/s. The paper asks for a term that penalises longer movements; energy
        bounds the squared length of the joint path and, unlike length, settles the
        timing along it too, so that the optimum is a point.
    """
    return ERROR_WEIGHT * rollout.error**2 + ENERGY_WEIGHT * rollout.energy


def search_policy(
    workspace: Workspace,
    task_deg: float,
    *,
    seed: int,
    n_starts: int = 4,
    start_policies: Sequence[ArrayLike] = (),
    incumbent: SearchResult | None = None,
    dmp: DMP | None = None,
) -> SearchResult:
    """Search the policy that solves one task, by CMA-ES.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    seed : int
        Seed of all random draws, together with the task and the start's number: a
        task's search does not depend on what else is searched.
    n_starts : int, default=4
        Independent starts: from the zero policy, then from random ones.
    start_policies : sequence of array_like of shape (n_params,), optional
        Starts before those, from given policies and with a small first step.
    incumbent : SearchResult, optional
        An earlier search of the same task, to go on from: its starts count too.
    dmp : DMP, optional
        What a policy means; by default ``DMP()``.

    Returns
    -------
    SearchResult
        The cheapest policy of all starts.

    Raises
    ------
    ValueError
        If there is no start at all, an argument is not a number as wanted, or the
        incumbent is of another task.

    Examples
    --------
    >>> found = search_policy(Workspace.free(), 200, seed=1, n_starts=1)
    >>> found.error < 0.005
    True
    """
    dmp = dmp or DMP()
    runs = list(incumbent.runs) if incumbent else []
    if n_starts < 0 or n_starts + len(start_policies) + len(runs) == 0:
        raise ValueError(
            f"n_starts={n_starts} with {len(start_policies)} start_policies; "
            "wanted at least one start"
        )
    if seed < 0:
        raise ValueError(f"seed={seed}; wanted 0 or more")
    given = [
        check_policies(policy, dmp.n_params, single=True) for policy in start_policies
    ]
    if not np.isfinite(task_deg):
        raise ValueError(f"task_deg={task_deg}; wanted a finite angle")
    if incumbent and incumbent.task_deg != task_deg:
        raise ValueError(
            f"incumbent is of task {incumbent.task_deg}°; wanted one of {task_deg}°"
        )
    arm = cached_arm(workspace, dmp)

    def costs(policies: NDArray[np.float64]) -> list[float]:
        return [cost(rollout) for rollout in arm.execute_many(policies, task_deg)]

    shape = initial_covariance(workspace, task_deg, dmp)
    n_before = sum(run.name.startswith("start") for run in runs)
    for number in range(len(given) + n_starts):
        rng = start_generator(seed, task_deg, len(runs))
        if number < len(given):
            name, mean = f"given {number}", given[number]
            step = SMALL_STEP * dmp.spring
        else:
            fresh = n_before + number - len(given)
            name, mean = f"start {fresh}", random_start(fresh, dmp, rng)
            step = FIRST_STEP * dmp.spring
        runs.append(minimize(costs, mean, step, rng, shape, name=name, known=runs))
    best = min(runs, key=lambda run: run.cost)
    rollout = arm.execute(best.policy, task_deg)
    return SearchResult(
        task_deg=float(task_deg),
        policy=best.policy,
        cost=cost(rollout),
        error=rollout.error,
        energy=rollout.energy,
        contact_impulse=rollout.contact_impulse,
        runs=tuple(runs),
    )


def start_generator(seed: int, task_deg: float, number: int) -> np.random.Generator:
    """Give a start its source of random numbers, whatever else is searched.

    Parameters
    ----------
    seed : int
        Seed of the search.
    task_deg : float
        Task angle (degrees).
    number : int
        How many starts of the task came before.

    Returns
    -------
    Generator
        The source.
    """
    return np.random.default_rng([seed, round(1000 * task_deg) % 360_000, number])


def random_start(
    number: int, dmp: DMP, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw where a start begins: the first at the zero policy, the others anywhere.

    Parameters
    ----------
    number : int
        The start's number.
    dmp : DMP
        What a policy means.
    rng : Generator
        Where the draw comes from.

    Returns
    -------
    ndarray of shape (n_params,)
        A policy.
    """
    if number == 0:
        return np.zeros(dmp.n_params)
    return FIRST_STEP * dmp.spring * rng.standard_normal(dmp.n_params)


def initial_covariance(
    workspace: Workspace, task_deg: float, dmp: DMP
) -> NDArray[np.float64]:
    """Guess how far CMA-ES should look in each direction.

    Of an end effector that moves freely, a link's length for every radian of a joint,
    the cost is quadratic in the policy. The inverse of that quadratic form, as the
    first covariance instead of the unit matrix, saves CMA-ES about half of its rollouts
    and leaves open where it goes.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    dmp : DMP
        What a policy means.

    Returns
    -------
    ndarray of shape (n_params, n_params)
        A square root of the covariance, scaled to determinant 1.
    """
    times = np.linspace(0, 1, 61)
    start = forward_kinematics(workspace.home, workspace.link_lengths)[-1]
    policies = np.vstack([np.zeros(dmp.n_params), np.eye(dmp.n_params)])
    paths = dmp.path(policies, start, workspace.target(task_deg), times)
    moved = paths[1:] - paths[0]
    speeds = np.gradient(moved, times, axis=1) / workspace.link_lengths[0]
    ends, speeds = moved[:, -1], speeds.reshape(dmp.n_params, -1)
    bend = ERROR_WEIGHT * ends @ ends.T + ENERGY_WEIGHT * times[1] * speeds @ speeds.T
    bend += 1e-9 * np.trace(bend) * np.eye(dmp.n_params)  # where a weight does nothing
    shape = np.linalg.cholesky(np.linalg.inv(bend))
    return np.asarray(shape / np.exp(np.mean(np.log(np.diag(shape)))))
