"""CMA-ES with a surrogate: from where a search begins to the cheapest policy around it.

The only module that imports pycma. Equations are those of Hansen's tutorial,
arXiv 1604.00772; the surrogate is that of lq-CMA-ES: N. Hansen, "A Global Surrogate
Assisted CMA-ES", GECCO 2019.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any

import cma
import numpy as np
from cma.fitness_models import LQModel
from numpy.typing import NDArray

from msc.search._options import SearchOptions

Array = NDArray[np.float64]


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
        Policies executed.
    merged_into : int
        Number of the earlier run at whose policy it was stopped, else -1.
    failed : bool
        Whether it ended with its first generation, all policies of which cost the
        same: it had nowhere to go.
    """

    name: str
    policy: Array
    cost: float
    evaluations: int
    merged_into: int = -1
    failed: bool = False


def minimize(
    costs: Callable[[Array], Sequence[float]],
    x0: Array,
    sigma0: float,
    rng: np.random.Generator,
    sqrt_cov: Array,
    *,
    name: str = "start",
    known: Sequence[CmaRun] = (),
    options: SearchOptions,
) -> CmaRun:
    """Run CMA-ES until it converges, stalls, falls behind or comes near a known policy.

    Parameters
    ----------
    costs : callable
        Gives the costs of policies, an array of shape (n_policies, n_params).
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
        When a run ends, what is near, and how far the surrogate is believed.

    Returns
    -------
    CmaRun
        What was found.

    Raises
    ------
    ValueError
        If `costs` does not give a finite number for each policy.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.search import SearchOptions, minimize
    >>> def costs(policies):
    ...     return 1 + ((policies - 3) ** 2).sum(axis=1)
    >>> rng = np.random.default_rng(0)
    >>> run = minimize(
    ...     costs, np.zeros(6), 1.0, rng, np.eye(6), options=SearchOptions()
    ... )
    >>> run.policy.round(2)
    array([3., 3., 3., 3., 3., 3.])
    """
    asking = minimize_steps(
        x0, sigma0, rng, sqrt_cov, costs, name=name, known=known, options=options
    )
    answer = None
    while True:
        try:
            answer = asking.send(answer)  # policies: their own answer
        except StopIteration as end:
            found: CmaRun = end.value
            return found


def minimize_steps(
    x0: Array,
    sigma0: float,
    rng: np.random.Generator,
    sqrt_cov: Array,
    costs_of: Callable[[Any], Sequence[float]],
    *,
    name: str,
    known: Sequence[CmaRun],
    options: SearchOptions,
    seen: list[tuple[Array, Array]] | None = None,
) -> Generator[Array, Any, CmaRun]:
    """Run as `minimize` does; yield policies and be sent what tells their costs.

    `seen` gets the policies of each generation and their costs, NaN if not asked for.
    """
    strategy = cma.CMAEvolutionStrategy(
        np.zeros(len(x0)),
        1.0,
        {
            "seed": np.nan,  # all draws come from rng
            "randn": lambda *size: rng.standard_normal(size),
            "popsize": options.population,  # lambda (eq. 48)
            "tolfun": options.tolerance,
            "CMA_injections_threshold_keep_len": 1,  # as lq-CMA-ES has it
            "verbose": -9,
            "verb_log": 0,
        },
    )
    # z ~ N(m, sigma^2 C) (eqs. 38-40), with m = 0, sigma = 1 and C = I to begin with,
    # and x = x0 + A z: the first covariance of policies is A A'.
    transform = sigma0 * sqrt_cov
    surrogate = _Surrogate(options, costs_of)
    policies = np.array([run.policy for run in known])
    reach = options.near * np.array(
        [0.0 if run.failed else np.linalg.norm(run.policy) for run in known]
    )
    paid = np.array([run.cost for run in known])
    policy, best, evaluations, merged_into = x0, np.inf, 0, -1
    earlier = [np.inf] * options.stalled  # best costs after the last generations
    while (
        merged_into < 0
        and evaluations <= options.max_evaluations
        and not strategy.stop()
    ):
        asked = np.array(strategy.ask())
        tried = x0 + asked @ transform.T
        values, costs = yield from surrogate.evaluate(asked, tried)
        if seen is not None:
            seen.append((tried, costs))
        strategy.tell(asked, values)  # m, sigma and C of the next (eqs. 41-47)
        strategy.inject(surrogate.optimum)
        evaluations += np.isfinite(costs).sum()
        if np.nanmin(costs) < best:
            policy, best = tried[np.nanargmin(costs)], np.nanmin(costs)
        earlier.append(best)
        if earlier[-options.stalled - 1] - best < options.gain * best:
            break
        if known:
            mean = x0 + transform @ strategy.mean
            # The cloud's widest standard deviation: the largest singular value of
            # sigma A B D, since C = B D^2 B' (eq. 39).
            axes = transform @ strategy.B * strategy.D
            spread = strategy.sigma * np.linalg.norm(axes, 2)
            apart = np.linalg.norm(policies - mean, axis=1)
            near = (np.maximum(spread, apart) < reach) & (best >= paid)
            if near.any():
                reached = int(near.argmax())
                first = known[reached].merged_into
                merged_into = first if first >= 0 else reached
            pace = earlier[-options.stalled - 1] - best
            if best - options.patience * pace > paid.min():  # never gets there
                break
    flat = strategy.countiter == 1 and "tolfun" in strategy.stop()
    return CmaRun(name, policy, float(best), int(evaluations), merged_into, flat)


class _Surrogate:
    """Costs of a generation, of which only some are asked for (Hansen 2019, alg. 1).

    A linear, then quadratic model is fitted to the costs known of a run. It ranks a
    generation; the policies it thinks best are executed, one, then half as many again,
    until its ranks agree with the costs. The rest get the model's values.
    """

    def __init__(
        self, options: SearchOptions, costs_of: Callable[[Any], Sequence[float]]
    ) -> None:
        self._agreement, self._tell = options.agreement, costs_of
        self._model = LQModel(max_absolute_size=options.population)

    @property
    def optimum(self) -> list[Array]:
        """Where the model is least, for the next generation; nothing if unused."""
        return [self._model.xopt] if self._agreement <= 1 else []

    def evaluate(
        self, points: Array, policies: Array
    ) -> Generator[Array, Any, tuple[Array, Array]]:
        """Ask for some costs; return values of all points, and the costs, NaN if none.

        The points are the model's coordinates of the policies.
        """
        costs = np.full(len(points), np.nan)
        if self._agreement > 1:  # no model could agree so well: plain CMA-ES
            costs[:] = self._costs_of((yield policies), len(points))
            return costs, costs
        model, n_true = self._model, max(1, 4 - self._model.size)
        while True:
            order = np.argsort(self._values(points), kind="stable")
            asked = order[np.isnan(costs[order])]
            asked = asked[: n_true - np.isfinite(costs).sum()]
            costs[asked] = self._costs_of((yield policies[asked]), len(asked))
            for k in asked:
                if not model.isin(points[k]):
                    model.add_data_row(points[k], costs[k])
            model.sort(n_true)
            # Over at least 15 policies, those of earlier generations among them.
            latest = slice(int(max(15, min(1.2 * n_true, 0.75 * len(points)))))
            agreement = _kendall(model.Y[latest], model.Z[latest] @ model.coefficients)
            if agreement >= self._agreement or n_true == len(points):
                break
            n_true = min(n_true + -(-n_true // 2), len(points))
        model.adapt_max_relative_size(agreement)
        if n_true == len(points):
            return costs, costs
        values = self._values(points)
        return values - values.min() + np.nanmin(costs), costs

    def _costs_of(self, answer: Any, n_policies: int) -> Array:
        """Return the costs of what was executed; refuse what ranks no policies."""
        costs = np.asarray(self._tell(answer), dtype=float)
        if costs.shape != (n_policies,) or not np.isfinite(costs).all():
            raise ValueError(
                f"costs gave {costs} for {n_policies} policies; wanted a finite number "
                "for each"
            )
        return costs

    def _values(self, points: Array) -> Array:
        """Return the model's values; before there is a model, the order given."""
        if self._model.size < 2:
            return np.arange(len(points), dtype=float)
        expanded = np.array([self._model.expand_x(point) for point in points])
        return np.asarray(expanded @ self._model.coefficients)


def _kendall(one: Array, other: Array) -> float:
    """Return how well two rankings agree, Kendall's tau: 1 if they are the same."""
    upper = np.triu_indices(len(one), 1)
    signs = [np.sign(values[:, None] - values)[upper] for values in (one, other)]
    return float(np.mean(signs[0] * signs[1])) if len(one) > 2 else 0.0
