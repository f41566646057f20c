"""CMA-ES: from where a search begins to the policy that costs least around it.

The only module that imports pycma.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cma
import numpy as np
from numpy.typing import NDArray

NEAR = 0.05  # of a known policy's norm: a run that is so near is on the way to it
MAX_EVALUATIONS = 4000  # of one start; converged ones take 400 to 2000
PATIENCE = 1200  # evaluations; a start then still twice as dear as a known one ends
STALLED, GAIN = 40, 1e-5  # generations that gain less than this share: it ends

Costs = Callable[[NDArray[np.float64]], list[float]]


@dataclass(frozen=True, eq=False)
class CmaRun:
    """One run of CMA-ES: its name, what it found, what that took.

    A run that came near the policy of an earlier one is stopped there: `merged_into` is
    the number of that one, else -1.
    """

    name: str
    policy: NDArray[np.float64]
    cost: float
    evaluations: int
    merged_into: int = -1


def minimize(
    costs: Costs,
    mean: NDArray[np.float64],
    step: float,
    rng: np.random.Generator,
    shape: NDArray[np.float64],
    *,
    name: str = "start",
    known: Sequence[CmaRun] = (),
) -> CmaRun:
    """Run CMA-ES until it converges, stalls or comes near the policy of a known start.

    It is stalled if 40 generations lowered the best cost by less than a
    hundred-thousandth.

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
    shape : ndarray of shape (n_params, n_params)
        Square root of the first covariance, see `msc.search.initial_covariance`.
    name : str, default="start"
        What to call the run.
    known : sequence of CmaRun, optional
        Earlier runs. A run that is narrower than a twentieth of a known policy's norm,
        and nearer to it than that, and not cheaper, is stopped. So is one that after
        1200 evaluations still costs twice as much as the cheapest.

    Returns
    -------
    CmaRun
        What was found.
    """
    strategy = cma.CMAEvolutionStrategy(
        np.zeros(len(mean)),
        step,
        {
            "seed": np.nan,  # all draws come from rng
            "randn": lambda *size: rng.standard_normal(size),
            "popsize": 9,
            "maxfevals": MAX_EVALUATIONS,
            "tolfun": 1e-7,
            "verbose": -9,
            "verb_log": 0,
        },
    )
    policies = np.array([start.policy for start in known])
    reach = NEAR * np.linalg.norm(policies, axis=-1)
    paid = np.array([start.cost for start in known])
    policy, best, merged_into = mean, np.inf, -1
    earlier = [np.inf] * STALLED  # best costs after the last generations
    while merged_into < 0 and not strategy.stop():
        asked = np.array(strategy.ask())
        tried = mean + asked @ shape.T
        values = costs(tried)
        strategy.tell(asked, values)
        if min(values) < best:
            policy, best = tried[np.argmin(values)], min(values)
        earlier.append(best)
        if earlier[-STALLED - 1] - best < GAIN * best:
            break
        if known:
            middle = mean + shape @ strategy.mean
            spread = strategy.sigma * np.linalg.norm(shape @ strategy.B * strategy.D, 2)
            apart = np.linalg.norm(policies - middle, axis=1)
            near = (np.maximum(spread, apart) < reach) & (best >= paid)
            if near.any():
                nearest = int(near.argmax())
                first = known[nearest].merged_into
                merged_into = first if first >= 0 else nearest
            if strategy.countevals >= PATIENCE and best > 2 * paid.min():
                break
    return CmaRun(name, policy, float(best), strategy.countevals, merged_into)
