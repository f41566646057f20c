"""A number with its interval: measured, compared and combined.

`Average` is the mean of a method's errors over training sets and test tasks, and
`compare` divides two of them; `quotient`, `difference`, `average` and `bonferroni` say
what becomes of intervals that are combined.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri, stdtrit

N_WAVES = 2  # lowest frequencies round the circle that tell how tasks vary
WIDER = 1.4  # intervals, for errors with long tails (`benchmarks/coverage.py`)

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
) -> Estimate:
    """Compare the mean errors of two methods.

    Parameters
    ----------
    label : str
        What the errors are, for the sentence.
    errors : DataFrame or mapping of str to array_like
        Of each method, one error a test task, shape (n_test_tasks,), or one a training
        set and test task, shape (n_training_sets, n_test_tasks); test tasks in their
        order round the circle.
    method, baseline : str
        The methods whose means are divided, the first by the second.
    weights : array_like of shape (n_test_tasks,), optional
        How much each test task counts, as P(τ) in Eq. 1; by default all the same.
    spread : bool, default=False
        Whether to compare, instead of means, standard deviations over the test tasks,
        averaged over the training sets.

    Returns
    -------
    Estimate
        The ratio and its interval, see `Average`.

    Raises
    ------
    ValueError
        If a method has no errors, or shapes do not fit together.

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
    top, bottom = (Average(values, weights, spread=spread) for values in pair)
    return replace(top.over(bottom), label=label, baseline=baseline)


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


class Average:
    """Errors averaged over training sets and test tasks, and how sure that is.

    Parameters
    ----------
    errors : array_like of shape (n_training_sets, n_test_tasks)
        Errors; test tasks in their order round the circle.
    weights : array_like of shape (n_test_tasks,), optional
        How much each test task counts, zero if it does not; by default all the same.
    spread : bool, default=False
        Whether to average, instead of the errors, a training set's standard deviation
        over the test tasks, with their number less one in the denominator.

    Attributes
    ----------
    per_set : ndarray of shape (n_training_sets,)
        The mean, or standard deviation, of each training set.
    value : float
        Their mean.

    Raises
    ------
    ValueError
        If there is not a weight a task, or all are zero.

    Notes
    -----
    Both test tasks and training sets are taken for a sample. An error counts for the
    average by its influence u(s, t), of mean zero, whose means over the sets, u(t), and
    over the tasks, u(s), are what the luck of tasks and of sets makes of it. Test tasks
    beside one another err alike (correlation 0.9), so that 120 are worth some eight.
    The variance of the mean of such a series is its spectrum at frequency zero over
    their number; the spectrum is averaged over the two lowest frequencies round the
    circle [1]_, sine and cosine each, which leaves four degrees of freedom. That of the
    sets is their variance over their number. Degrees of freedom of the sum are
    Satterthwaite's, and the quantile is Student's. Of a ratio all this is done for the
    difference of both influences, each relative to its mean, and holds for the
    logarithm.

    Means of errors with long tails are surer to be too low than too high, and such an
    interval covers the truth in 87 % of studies simulated with what was measured of
    errors here (`benchmarks/coverage.py`). So it is made wider, by the factor `WIDER`.

    The interval covers which training sets were drawn and which tasks tested, as if
    this circle of tasks was one of many. It knows nothing of how worlds differ
    otherwise, nor of another search. A single training set tells nothing of others.

    References
    ----------
    .. [1] E. Lazarus, D. J. Lewis, J. H. Stock and M. W. Watson, "HAR inference:
       recommendations for practice", Journal of Business & Economic Statistics 36,
       2018.

    Examples
    --------
    >>> one = Average([[1.0, 2.0, 6.0], [2.0, 3.0, 10.0]])
    >>> one.value, one.per_set.tolist()
    (4.0, [3.0, 5.0])
    >>> one.over(one)
    1 [1, 1]
    """

    def __init__(
        self,
        errors: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        spread: bool = False,
    ) -> None:
        values = np.asarray(errors)
        self._most = 1.0 if values.dtype == bool else np.inf  # shares
        values = values.astype(float)
        self._is_signed = bool((values < 0).any())
        n_tasks = values.shape[1]
        counted = np.ones(n_tasks) if weights is None else np.asarray(weights, float)
        if counted.shape != (n_tasks,):
            raise ValueError(
                f"weights have shape {counted.shape}; wanted ({n_tasks},), one a task"
            )
        if not counted.sum() > 0:
            raise ValueError("weights are all zero; wanted a task that counts")
        shares = counted / counted.sum()
        means = values @ shares
        if spread:
            scaled = (values - means[:, None]) ** 2
            n_counted = np.count_nonzero(counted)
            scaled *= n_counted / max(1, n_counted - 1)
            self.per_set = np.sqrt(scaled @ shares)
            own = 2 * np.where(self.per_set > 0, self.per_set, np.inf)[:, None]
            apart = (scaled - self.per_set[:, None] ** 2) / own  # of a root: a half
        else:
            self.per_set = means
            apart = values - means[:, None]
        self.value = float(self.per_set.mean())
        of_set = self.per_set[:, None] - self.value
        self._influence = n_tasks * shares * apart + of_set

    @property
    def estimate(self) -> Estimate:
        """The average with its 95 % interval; of shares no farther than one."""
        if not self.value > 0 or self._is_signed:
            half = self._half_width(self._influence)
            return Estimate(self.value, self.value - half, self.value + half)
        found = self._around(self.value, self._influence / self.value)
        return replace(found, high=min(found.bounds[1], self._most))

    def over(self, other: Average) -> Estimate:
        """Divide by another average, of the same training sets and test tasks.

        Parameters
        ----------
        other : Average
            What to divide by.

        Returns
        -------
        Estimate
            The ratio with its 95 % interval. Where either is not positive, there is
            none, and its bounds are not finite.
        """
        if not min(self.value, other.value) > 0:
            with np.errstate(divide="ignore", invalid="ignore"):
                value = float(np.divide(self.value, other.value))
            return Estimate(value, -np.inf, np.inf)
        apart = self._influence / self.value - other._influence / other.value
        return self._around(self.value / other.value, apart)

    def _around(self, value: float, influence: Array) -> Estimate:
        """Give a positive number its interval, from influences on its logarithm."""
        factor = np.exp(self._half_width(influence))
        return Estimate(value, float(value / factor), float(value * factor))

    @staticmethod
    def _half_width(influence: Array) -> float:
        """Return half the length of the interval."""
        n_sets, n_tasks = influence.shape
        n_waves = min(N_WAVES, (n_tasks - 1) // 2)
        if n_waves == 0:
            return np.inf
        waves = np.fft.rfft(influence.mean(axis=0))[1 : n_waves + 1]
        parts = [(np.mean(np.abs(waves) ** 2) / n_tasks**2, 2 * n_waves)]
        if n_sets > 1:
            of_sets = influence.mean(axis=1).var(ddof=1) / n_sets
            parts.append((of_sets, n_sets - 1))
        variances, freedom = np.transpose(parts)
        total = variances.sum()
        if total == 0:
            return 0.0
        freedom = total**2 / (variances**2 / freedom).sum()  # Satterthwaite's
        return float(WIDER * stdtrit(freedom, 0.975) * np.sqrt(total))


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
