"""Whether one method's errors are lower than another's, with an interval."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

TAILS = (0.025, 0.975)  # of the resampled values: a 95 % interval

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """The mean of one method's errors over that of another's, on the same tasks.

    The interval is a paired bootstrap over training sets and test tasks, at 95 %: see
    `compare` for what it covers.
    """

    measure: str
    method: str
    baseline: str
    ratio: float
    low: float
    high: float

    @property
    def verdict(self) -> str:
        """Whether the interval lies below one, above one or includes it.

        Undecided too where it is not positive: of two means one may then be zero.
        """
        if not min(self.ratio, self.low) > 0:
            return "undecided"
        if self.high < 1:
            return "lower"
        return "higher" if self.low > 1 else "undecided"

    def __str__(self) -> str:
        """Say it in a sentence."""
        return (
            f"{self.measure}: {self.ratio:.2f} × {self.baseline} "
            f"[{self.low:.2f}, {self.high:.2f}]: {self.verdict}"
        )

    __repr__ = __str__


def compare(
    measure: str,
    errors: pd.DataFrame | Mapping[str, ArrayLike],
    method: str,
    baseline: str,
    *,
    weights: ArrayLike | None = None,
    spread: bool = False,
    n_resamples: int = 1_000,
    seed: int = 0,
) -> Comparison:
    """Compare the mean errors of two methods.

    Parameters
    ----------
    measure : str
        What the errors are, for the sentence.
    errors : DataFrame or mapping of str to array_like
        Of each method, one error a test task, shape (n_test_tasks,), or one a training
        set and test task, shape (n_training_sets, n_test_tasks).
    method, baseline : str
        The methods whose means are divided, the first by the second.
    weights : array_like of shape (n_test_tasks,), optional
        How much each test task counts, as P(τ) in Eq. 1; by default all the same.
    spread : bool, default=False
        Whether to compare, instead of means, standard deviations over the test tasks,
        averaged over the training sets.
    n_resamples : int, default=1000
        Bootstrap resamples.
    seed : int, default=0
        Seed of the resampling.

    Returns
    -------
    Comparison
        The ratio and its interval.

    Raises
    ------
    ValueError
        If a method has no errors, or shapes do not fit together.

    Notes
    -----
    Training sets and test tasks are resampled independently of each other, the same
    ones for both methods: the pigeonhole bootstrap of [1]_, which is if anything a
    little wide. With one training set it is the usual bootstrap over test tasks.

    The interval covers which training sets were drawn and which tasks tested, within
    one world and one search of its policies. It does not cover another world (other
    obstacles, another arm) nor another search. A handful of training sets says little
    about others, and the interval is then too narrow (with five and a strong influence
    of the set, four in five cover the truth); with one it does not cover them at all.

    References
    ----------
    .. [1] A. B. Owen, "The pigeonhole bootstrap", Annals of Applied Statistics 1, 2007.

    Examples
    --------
    >>> errors = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [2.0, 4.0, 6.0]})
    >>> compare("error", errors, "a", "b").ratio
    0.5
    """
    pair = [_check_errors(errors, name) for name in (method, baseline)]
    if pair[0].shape != pair[1].shape:
        raise ValueError(
            f"errors of {method!r} have shape {pair[0].shape}, those of {baseline!r} "
            f"{pair[1].shape}; wanted the same training sets and test tasks"
        )
    n_tasks = pair[0].shape[1]
    if weights is not None and np.shape(weights) != (n_tasks,):
        raise ValueError(
            f"weights have shape {np.shape(weights)}; wanted ({n_tasks},), one a task"
        )
    if not isinstance(n_resamples, int | np.integer) or n_resamples < 1:
        raise ValueError(
            f"n_resamples={n_resamples!r}; wanted a whole number, at least 1"
        )
    draws = Resamples(pair[0].shape, n_resamples=n_resamples, seed=seed)
    top, bottom = (
        draws.average(draws.per_set(values, weights, spread=spread)) for values in pair
    )
    ratios = top / bottom
    low, high = interval(ratios[1:])
    return Comparison(measure, method, baseline, float(ratios[0]), low, high)


def _check_errors(errors: pd.DataFrame | Mapping[str, ArrayLike], name: str) -> Array:
    """Return a method's errors, with a row a training set."""
    if name not in errors:
        raise ValueError(f"no errors of {name!r}; there are those of {list(errors)}")
    values = np.atleast_2d(np.asarray(errors[name], dtype=float))
    if values.ndim > 2 or not values.size:
        raise ValueError(
            f"errors of {name!r} have shape {np.shape(errors[name])}; wanted "
            "(n_test_tasks,) or (n_training_sets, n_test_tasks), at least one of each"
        )
    return values


class Resamples:
    """Training sets and test tasks, drawn again with replacement.

    Parameters
    ----------
    shape : (int, int)
        Training sets and test tasks.
    n_resamples : int, default=1000
        How many times to draw as many of both.
    seed : int, default=0
        Seed of the draws.

    Examples
    --------
    >>> draws = Resamples((1, 3), n_resamples=2)
    >>> draws.average(draws.per_set([[1.0, 2.0, 6.0]])).shape
    (3,)
    """

    def __init__(
        self, shape: tuple[int, int], *, n_resamples: int = 1_000, seed: int = 0
    ) -> None:
        rng = np.random.default_rng(seed)
        # How often each is drawn. First the sample itself, each once.
        self._sets, self._tasks = (
            np.r_[np.ones((1, n)), rng.multinomial(n, np.full(n, 1 / n), n_resamples)]
            for n in shape
        )

    def per_set(
        self,
        errors: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        spread: bool = False,
    ) -> Array:
        """Average errors over the test tasks, one number a training set.

        Parameters
        ----------
        errors : array_like of shape (n_training_sets, n_test_tasks)
            Errors.
        weights : array_like of shape (n_test_tasks,), optional
            How much each test task counts; by default all the same.
        spread : bool, default=False
            Whether to measure their standard deviation instead, with the number of
            test tasks less one in the denominator.

        Returns
        -------
        ndarray of shape (1 + n_resamples, n_training_sets)
            For the test tasks as they are, and then for those of each resample.
        """
        counted = self._tasks * (1.0 if weights is None else np.asarray(weights))
        shares = counted / counted.sum(axis=1, keepdims=True)
        values = np.asarray(errors, dtype=float)
        if not spread:
            return np.asarray(shares @ values.T)
        centred = (values - values.mean(axis=1, keepdims=True)).T
        variances = shares @ centred**2 - (shares @ centred) ** 2
        n_tasks = len(centred)
        variances *= n_tasks / max(1, n_tasks - 1)
        return np.asarray(np.sqrt(np.maximum(variances, 0.0)))

    def average(self, per_set: Array) -> Array:
        """Average over training sets, in each resample over those drawn.

        Parameters
        ----------
        per_set : ndarray of shape (1 + n_resamples, n_training_sets)
            See the method of that name.

        Returns
        -------
        ndarray of shape (1 + n_resamples,)
            The average, and then that of each resample.
        """
        return np.asarray((self._sets * per_set).mean(axis=1))


def interval(resampled: Array) -> tuple[float, float]:
    """Bound the middle 95 % of resampled values.

    Parameters
    ----------
    resampled : ndarray of shape (n_resamples,)
        A statistic of each resample.

    Returns
    -------
    low, high : float
        Their 2.5th and 97.5th percentiles.

    Examples
    --------
    >>> interval(np.arange(1001.0))
    (25.0, 975.0)
    """
    low, high = np.quantile(resampled, TAILS)
    return float(low), float(high)
