"""The search: what a rollout costs, and CMA-ES from one task to its policy.

The only module that imports pycma.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import cma
import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.arm import Arm, Rollout
from msc.dmp import DMP, check_policies
from msc.workspace import Workspace

ERROR_WEIGHT = 100.0  # 1/m²
ENERGY_WEIGHT = 0.005  # s/rad²
FIRST_STEP, SMALL_STEP = 0.5, 0.05  # of CMA-ES, in spring constants
MAX_EVALUATIONS = 4000  # of one start; converged ones take 1000 to 1500


@dataclass(frozen=True)
class Start:
    """One run of CMA-ES: its name, what it found, what that took.

    A run that came upon the policy of an earlier one is stopped there: `joined` names
    that one.
    """

    name: str
    policy: NDArray[np.float64]
    cost: float
    evaluations: int
    joined: str = ""


@dataclass(frozen=True)
class SearchResult:
    """The policy found for a task, and how.

    Attributes
    ----------
    policy : ndarray of shape (n_params,)
        Weights of Eq. 7.
    cost : float
        Its cost, see `cost`.
    error, energy, contact_impulse : float
        What its rollout measured, see `Rollout`.
    starts : tuple of Start
        All runs of CMA-ES, in order; the cheapest gave the policy.
    """

    policy: NDArray[np.float64]
    cost: float
    error: float
    energy: float
    contact_impulse: float
    starts: tuple[Start, ...]

    @property
    def evaluations(self) -> int:
        """Rollouts spent, over all starts."""
        return sum(start.evaluations for start in self.starts)

    @property
    def winner(self) -> str:
        """Name of the start that gave the policy."""
        return min(self.starts, key=lambda start: start.cost).name

    @property
    def n_agreeing(self) -> int:
        """Starts that ended at the policy: joined it, or within 1 % of its norm."""
        close = 0.01 * np.linalg.norm(self.policy)
        return sum(
            start.joined == self.winner
            or bool(np.linalg.norm(start.policy - self.policy) <= close)
            for start in self.starts
        )


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
        Further starts, from given policies and with a small first step.
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
        If there is no start at all, or an argument is not a number as wanted.

    Examples
    --------
    >>> found = search_policy(Workspace.free(), 200, seed=1, n_starts=1)
    >>> found.error < 0.005
    True
    """
    dmp = dmp or DMP()
    starts = list(incumbent.starts) if incumbent else []
    if n_starts < 0 or n_starts + len(start_policies) + len(starts) == 0:
        raise ValueError(
            f"n_starts={n_starts} with {len(start_policies)} start_policies; "
            "wanted at least one start"
        )
    if seed < 0:
        raise ValueError(f"seed={seed}; wanted 0 or more")
    given = [check_policies(policy, dmp.n_params) for policy in start_policies]
    if not np.isfinite(task_deg):
        raise ValueError(f"task_deg={task_deg}; wanted a finite angle")
    arm = _arm(workspace, dmp)

    def costs(policies: NDArray[np.float64]) -> list[float]:
        return [cost(rollout) for rollout in arm.execute_many(policies, task_deg)]

    task_key = round(1000 * task_deg) % 360_000
    for number in range(n_starts + len(given)):
        rng = np.random.default_rng([seed, task_key, len(starts)])
        if number < n_starts:
            name, mean = f"start {number}", random_start(number, dmp, rng)
            step = FIRST_STEP * dmp.spring
        else:
            name, mean = f"given {number - n_starts}", given[number - n_starts]
            step = SMALL_STEP * dmp.spring
        starts.append(minimise(costs, mean, step, rng, name=name, known=starts))
    best = min(starts, key=lambda start: start.cost)
    rollout = arm.execute(best.policy, task_deg)
    return SearchResult(
        policy=best.policy,
        cost=best.cost,
        error=rollout.error,
        energy=rollout.energy,
        contact_impulse=rollout.contact_impulse,
        starts=tuple(starts),
    )


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


def minimise(
    costs: Callable[[NDArray[np.float64]], list[float]],
    mean: NDArray[np.float64],
    step: float,
    rng: np.random.Generator,
    *,
    name: str = "start",
    known: Sequence[Start] = (),
) -> Start:
    """Run CMA-ES until it converges or comes upon the policy of a known start.

    Parameters
    ----------
    costs : callable
        Gives the costs of policies, an array of shape (9, n_params).
    mean : ndarray of shape (n_params,)
        Where to begin.
    step : float
        Standard deviation of the first policies around it.
    rng : Generator
        All randomness; NumPy's global generator is left alone.
    name : str, default="start"
        What to call the run.
    known : sequence of Start, optional
        Earlier runs. One that is narrower than a tenth of a known policy's norm, and
        nearer to it than that, is stopped.

    Returns
    -------
    Start
        What was found.
    """
    strategy = cma.CMAEvolutionStrategy(
        mean,
        step,
        {
            "seed": np.nan,  # all draws come from rng
            "randn": lambda *shape: rng.standard_normal(shape),
            "popsize": 9,
            "maxfevals": MAX_EVALUATIONS,
            "tolfun": 1e-6,
            "tolx": 0.016,
            "verbose": -9,
            "verb_log": 0,
        },
    )
    joined = ""
    while not joined and not strategy.stop():
        policies = strategy.ask()
        strategy.tell(policies, costs(np.array(policies)))
        spread = strategy.sigma * np.max(strategy.D)
        for start in known:
            reach = 0.1 * np.linalg.norm(start.policy)
            apart = np.linalg.norm(strategy.mean - start.policy)
            if max(spread, apart) < reach:
                joined = start.joined or start.name
                break
    found = strategy.result
    policy = np.array(found.xbest)
    return Start(name, policy, float(found.fbest), found.evaluations, joined)


@lru_cache(maxsize=4)
def _arm(workspace: Workspace, dmp: DMP) -> Arm:
    """Keep one simulated arm per process, world and DMP."""
    return Arm(workspace, dmp=dmp)
