"""CMA-ES: from where a search begins to the policy that costs least around it.

The only module that imports pycma. Equations are those of Hansen's tutorial,
arXiv 1604.00772.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cma
import numpy as np
from numpy.typing import NDArray

from msc.search._options import SearchOptions

Costs = Callable[[NDArray[np.float64]], list[float]]


@dataclass(frozen=True, eq=False)
class CmaRun:
    """One run of CMA-ES.

    Attributes
    ----------
    name : str
        What it is called: where it began.
    policy : ndarray of shape (n_params,)
        The best that it found.
    cost : float
        What that costs.
    evaluations : int
        Policies tried.
    merged_into : int
        Number of the earlier run at whose policy it was stopped, else -1.
    """

    name: str
    policy: NDArray[np.float64]
    cost: float
    evaluations: int
    merged_into: int = -1


def minimize(
    costs: Costs,
    x0: NDArray[np.float64],
    sigma0: float,
    rng: np.random.Generator,
    sqrt_cov: NDArray[np.float64],
    *,
    name: str = "start",
    known: Sequence[CmaRun] = (),
    options: SearchOptions,
) -> CmaRun:
    """Run CMA-ES until it converges, stalls or comes near the policy of a known run.

    Parameters
    ----------
    costs : callable
        Gives the costs of policies, an array of shape (population, n_params).
    x0 : ndarray of shape (n_params,)
        Where to begin.
    sigma0 : float
        Standard deviation of the first policies around it.
    rng : Generator
        All randomness; NumPy's global generator is left alone.
    sqrt_cov : ndarray of shape (n_params, n_params)
        Square root of the first covariance, see `msc.search.initial_covariance`.
    name : str, default="start"
        What to call the run.
    known : sequence of CmaRun, optional
        Earlier runs, at which this one may be stopped or given up.
    options : SearchOptions
        When a run ends, and what is near.

    Returns
    -------
    CmaRun
        What was found.
    """
    strategy = cma.CMAEvolutionStrategy(
        np.zeros(len(x0)),
        sigma0,
        {
            "seed": np.nan,  # all draws come from rng
            "randn": lambda *size: rng.standard_normal(size),
            "popsize": options.population,  # lambda (eq. 48)
            "maxfevals": options.max_evaluations,
            "tolfun": options.tolerance,
            "verbose": -9,
            "verb_log": 0,
        },
    )
    policies = np.array([run.policy for run in known])
    reach = options.near * np.linalg.norm(policies, axis=-1)
    paid = np.array([run.cost for run in known])
    policy, best, merged_into = x0, np.inf, -1
    earlier = [np.inf] * options.stalled  # best costs after the last generations
    while merged_into < 0 and not strategy.stop():
        # z ~ N(m, sigma^2 C) (eqs. 38-40), with m = 0 and C = I to begin with, and
        # x = x0 + A z: the first covariance of policies is sigma0^2 A A'.
        asked = np.array(strategy.ask())
        tried = x0 + asked @ sqrt_cov.T
        values = costs(tried)
        strategy.tell(asked, values)  # m, sigma and C of the next (eqs. 41-47)
        if min(values) < best:
            policy, best = tried[np.argmin(values)], min(values)
        earlier.append(best)
        if earlier[-options.stalled - 1] - best < options.gain * best:
            break
        if known:
            mean = x0 + sqrt_cov @ strategy.mean
            # The cloud's widest standard deviation: the largest singular value of
            # sigma A B D, since C = B D^2 B' (eq. 39).
            axes = sqrt_cov @ strategy.B * strategy.D
            spread = strategy.sigma * np.linalg.norm(axes, 2)
            apart = np.linalg.norm(policies - mean, axis=1)
            near = (np.maximum(spread, apart) < reach) & (best >= paid)
            if near.any():
                reached = int(near.argmax())
                first = known[reached].merged_into
                merged_into = first if first >= 0 else reached
            if strategy.countevals >= options.patience and best > 2 * paid.min():
                break
    return CmaRun(name, policy, float(best), strategy.countevals, merged_into)
