"""A number with its interval: measured, resampled, compared and combined.

`compare` divides the mean errors of two methods and bounds the ratio by a bootstrap
over training sets and test tasks, which `Resamples` draws; `quotient`, `difference`,
`average` and `bonferroni` say what becomes of intervals that are combined.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from msc._checks import check_whole

TAILS = (0.025, 0.975)  # of the resampled values: a 95 % interval

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """A measured number and its 95 % interval.

    Attributes
    ----------
    value : float
        The number.
    low, high : float, optional
        Its interval; without one, the number is taken as exact, as a count is.
    label : str
        Which of several numbers it is, as "n = 24", or what was measured.
    baseline : str
        Of a ratio: the method whose errors it is a multiple of.
    """

    value: float
    low: float | None = None
    high: float | None = None
    label: str = ""
    baseline: str = ""

    @classmethod
    def read(cls, stored: Mapping[str, Any], name: str) -> Self:
        """Read what `stored` wrote.

        Parameters
        ----------
        stored : mapping
            Plain data.
        name : str
            What the number is called there; its bounds are "low" and "high".

        Returns
        -------
        Estimate
            The number.
        """
        return cls(stored[name], stored["low"], stored["high"])

    def stored(self, name: str) -> dict[str, float | None]:
        """Write it as plain data, see `six_digits`.

        Parameters
        ----------
        name : str
            What to call the number.

        Returns
        -------
        dict
            The number, "low" and "high".

        Examples
        --------
        >>> Estimate(1 / 3, 0.25, 0.5).stored("mean")
        {'mean': 0.333333, 'low': 0.25, 'high': 0.5}
        """
        numbers = {name: self.value, "low": self.low, "high": self.high}
        return {
            key: None if number is None else six_digits(number)
            for key, number in numbers.items()
        }

    @property
    def bounds(self) -> tuple[float, float]:
        """The interval, or the number twice."""
        low = self.value if self.low is None else self.low
        return low, self.value if self.high is None else self.high

    @property
    def verdict(self) -> str:
        """Of a ratio: whether its interval lies below one, above or includes it.

        Undecided too where it is not positive: of two means one may then be zero.
        """
        low, high = self.bounds
        if not min(self.value, low) > 0:
            return "undecided"
        if high < 1:
            return "lower"
        return "higher" if low > 1 else "undecided"

    def __str__(self) -> str:
        """Say it to three digits; of a ratio also what it compares, and the verdict."""
        text = _digits(self.value)
        if not (self.low is None and self.high is None):
            low, high = map(_digits, self.bounds)
            text += f" [{low}, {high}]"
        if not self.baseline:
            return text
        return f"{self.label}: {text} × {self.baseline}: {self.verdict}"

    __repr__ = __str__


def compare(
    label: str,
    errors: pd.DataFrame | Mapping[str, ArrayLike],
    method: str,
    baseline: str,
    *,
    weights: ArrayLike | None = None,
    spread: bool = False,
    n_resamples: int = 1_000,
    seed: int = 0,
) -> Estimate:
    """Compare the mean errors of two methods.

    Parameters
    ----------
    label : str
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
    Estimate
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
    >>> compare("error", errors, "a", "b")
    error: 0.5 [0.5, 0.5] × b: lower
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
    check_whole("n_resamples", n_resamples, 1)
    draws = Resamples(pair[0].shape, n_resamples=n_resamples, seed=seed)
    top, bottom = (
        draws.average(draws.per_set(values, weights, spread=spread)) for values in pair
    )
    return replace(bounded(top / bottom), label=label, baseline=baseline)


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
        # How often each is drawn; first the sample itself, each once. Rows and columns
        # are drawn apart, and an error counts by the product: Owen's pigeonholes.
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
        # As np.std of the tasks drawn, but with the sample's own n / (n - 1).
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


def bounded(values: Array) -> Estimate:
    """Bound a statistic by the middle 95 % of its resampled values.

    Parameters
    ----------
    values : ndarray of shape (1 + n_resamples,)
        The statistic, and then that of each resample, as from `Resamples.average`.

    Returns
    -------
    Estimate
        The statistic between their 2.5th and 97.5th percentiles.

    Examples
    --------
    >>> bounded(np.r_[480.0, np.arange(1001.0)])
    480 [25, 975]
    """
    low, high = np.quantile(values[1:], TAILS)  # the percentile interval, as it is
    return Estimate(float(values[0]), float(low), float(high))


def quotient(top: Estimate, bottom: Estimate) -> Estimate:
    """Divide one number by another.

    Parameters
    ----------
    top, bottom : Estimate
        Positive numbers, measured apart.

    Returns
    -------
    Estimate
        Their quotient, labelled as the first. Its interval joins theirs on a
        logarithmic scale as if the two were independent, the method of variance
        estimates recovery [1]_. Errors on the same test tasks rise and fall together;
        then the interval is wider than it need be.

    Raises
    ------
    ValueError
        If an interval reaches zero, unless only the first number has one.

    References
    ----------
    .. [1] A. Donner and G. Y. Zou, Closed-form confidence intervals for functions of
       the normal mean and standard deviation. Statistical Methods in Medical Research
       21(4), 2012.

    Examples
    --------
    >>> print(quotient(Estimate(2.0, 1.0, 4.0), Estimate(1.0, 1.0, 1.0)))
    2 [1, 4]
    """
    if bottom.low is None and bottom.value > 0:
        factor = 1 / bottom.value
        return _mapped(lambda number: factor * number, top)
    for estimate in (top, bottom):
        if min(estimate.value, *estimate.bounds) <= 0:
            raise ValueError(f"{estimate}: wanted positive numbers for a quotient")
    logs = (_mapped(np.log, estimate) for estimate in (top, bottom))
    return _mapped(np.exp, difference(*logs))


def difference(plus: Estimate, minus: Estimate) -> Estimate:
    """Subtract one number from another.

    Parameters
    ----------
    plus, minus : Estimate
        Numbers, measured apart.

    Returns
    -------
    Estimate
        Their difference, with an interval as in `quotient`, but on a linear scale.

    Examples
    --------
    >>> print(difference(Estimate(9.0, 6.0, 12.0), Estimate(4.0, 0.0, 8.0)))
    5 [0, 10]
    """
    value = plus.value - minus.value
    if plus.low is None and minus.low is None:
        return Estimate(value, label=plus.label)
    (below, above), (under, over) = plus.bounds, minus.bounds
    # Donner and Zou: distances to the bounds stand for standard errors, so they add as
    # variances do; below, the low bound of the first and the high one of the second.
    down = np.hypot(plus.value - below, over - minus.value)
    up = np.hypot(above - plus.value, minus.value - under)
    return Estimate(value, float(value - down), float(value + up), plus.label)


def average(estimates: Sequence[Estimate], *, geometric: bool) -> Estimate:
    """Average numbers that were measured together.

    Parameters
    ----------
    estimates : sequence of Estimate
        The numbers.
    geometric : bool
        Whether their logarithms are averaged.

    Returns
    -------
    Estimate
        The average, NaN of none. Its interval is the average of theirs, as if all erred
        alike: the widest that it can be. The average of exact numbers is exact.

    Raises
    ------
    ValueError
        If logarithms are to be averaged and a number or a bound is not positive.

    Examples
    --------
    >>> parts = [Estimate(1.0, 0.5, 2.0), Estimate(4.0, 2.0, 8.0)]
    >>> print(average(parts, geometric=True))
    2 [1, 4]
    """
    if not estimates:
        return Estimate(float("nan"))
    rows = np.array([(estimate.value, *estimate.bounds) for estimate in estimates])
    if geometric and (rows <= 0).any():
        raise ValueError(
            f"{rows.min():g}: wanted positive numbers for a geometric mean"
        )
    means = np.exp(np.log(rows).mean(axis=0)) if geometric else rows.mean(axis=0)
    value, low, high = map(float, means)
    is_exact = all(estimate.low is estimate.high is None for estimate in estimates)
    return Estimate(value) if is_exact else Estimate(value, low, high)


def bonferroni(estimate: Estimate, n_looks: int) -> Estimate:
    """Widen an interval for having looked at several.

    Parameters
    ----------
    estimate : Estimate
        One of them.
    n_looks : int
        How many there are.

    Returns
    -------
    Estimate
        The same number. All of `n_looks` such intervals together miss with 5 %, by
        Bonferroni's inequality and as if they were normal (their logarithms, if all
        is positive).

    Examples
    --------
    >>> print(bonferroni(Estimate(1.0, 0.5, 2.0), 20))
    1 [0.343, 2.91]
    """
    if estimate.low is None:
        return estimate
    is_positive = min(estimate.value, *estimate.bounds) > 0
    scaled = _mapped(np.log, estimate) if is_positive else estimate
    # Each misses with 5 % / n_looks: the interval grows as the normal's quantile does.
    factor = ndtri(1 - 0.025 / n_looks) / ndtri(1 - 0.025)
    low, high = (
        float(scaled.value + factor * (bound - scaled.value)) for bound in scaled.bounds
    )
    wider = replace(scaled, low=low, high=high)
    return _mapped(np.exp, wider) if is_positive else wider


def rounded(value: float, digits: int) -> str:
    """Round a number, but never to 1, where equality lies.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Significant digits, unless it takes more to tell the number from 1.

    Returns
    -------
    str
        The number.

    Examples
    --------
    >>> rounded(0.125, 2), rounded(0.998, 2), rounded(1.0, 2)
    ('0.12', '0.998', '1')
    """
    text = f"{value:.{digits}g}"
    while float(text) == 1 != value and digits < 5:
        digits += 1
        text = f"{value:.{digits}g}"
    return text


def six_digits(value: float) -> float:
    """Round a number as results are stored: the same on any processor.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    float
        It with six significant digits, more than any interval deserves.
    """
    return float(f"{value:.6g}")


def _mapped(function: Callable[[float], float], estimate: Estimate) -> Estimate:
    """Change the scale of a number and of its interval."""
    low, high = (
        None if bound is None else float(function(bound))
        for bound in (estimate.low, estimate.high)
    )
    return replace(estimate, value=float(function(estimate.value)), low=low, high=high)


def _digits(value: float) -> str:
    """Write a number with three significant digits."""
    return f"{float(rounded(value, 3)):,g}".replace("-", "−")
