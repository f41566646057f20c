"""A number with its interval: measured, compared and combined.

`Average` is the mean of a method's errors over training sets and test tasks, and
`compare` divides two of them; `quotient`, `difference`, `average` and `bonferroni` say
what becomes of intervals that are combined.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.special import expit, logit, stdtrit

# Settled by `benchmarks/coverage.py`:
N_WAVES = 2  # lowest frequencies round the circle that tell how tasks vary
WIDER = 2.0  # than Student's t makes them are intervals

_MOST = 100.0  # the logarithm of a factor that says no more than any larger one

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
    note : str
        What else is to be said of it, as on how many training sets it is below one.
    of : Average, optional
        Of a mean: what it was averaged of. A quotient of two such is that of errors on
        the same test tasks.
    """

    value: float
    low: float | None = None
    high: float | None = None
    label: str = ""
    baseline: str = ""
    note: str = ""
    of: Average | None = field(default=None, compare=False)

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
    for name in (method, baseline):
        if name not in errors:
            known = [*errors]
            raise ValueError(f"no errors of {name!r}; there are those of {known}")
    shape, its = np.shape(errors[method]), np.shape(errors[baseline])
    if shape != its:
        raise ValueError(
            f"errors of {method!r} have shape {shape}, of {baseline!r} {its}; wanted "
            "the same training sets and test tasks"
        )
    top, bottom = (
        Average(errors[name], weights, spread=spread) for name in (method, baseline)
    )
    return replace(top.over(bottom), label=label, baseline=baseline)


class Average:
    """Errors averaged over training sets and test tasks, and how sure that is.

    Parameters
    ----------
    errors : array_like of shape (n_training_sets, n_test_tasks) or (n_test_tasks,)
        Errors, of which truth values are counted; test tasks in their order round the
        circle.
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
    n_tasks : int
        Test tasks that count.
    waves : ndarray of shape (N_WAVES,), complex
        The slowest waves, round the circle, in what test tasks make of the value.

    Raises
    ------
    ValueError
        If there are no errors, or not a weight a task, or one is negative or all zero.

    Notes
    -----
    Both test tasks and training sets are taken for a sample. An error moves the average
    by its influence u(s, t), of mean zero: its distance from the mean. The means u(t)
    over the sets and u(s) over the tasks are what the luck of tasks and of sets makes
    of it. The variance of the average is the sum of two:

    - That of the sets is the variance of u(s) over their number.
    - Test tasks beside one another err alike, so that 120 of them are worth about ten.
      The variance of the mean of such a series is its spectrum at frequency zero over
      their number. It is taken from the lowest `N_WAVES` frequencies round the circle
      [1]_: for each k, the square of the mean of u(t) exp(i k φ(t)), with two degrees
      of freedom. The angle φ goes round as weights add up, hence tasks without weight
      may be left out as well.

    Degrees of freedom of the sum are Satterthwaite's, and the quantile is Student's. Of
    a ratio all this is done for the difference of both influences, each over its mean,
    and holds for the logarithm; of a positive mean for its logarithm, of a share for
    that of its odds, of a mean of errors of either sign for itself.

    Spectra fall from frequency zero on, and a mean of errors with long tails is mostly
    too low, with an interval that is too short. In simulated studies with what was
    measured of errors here such intervals cover the truth far less often than they
    should, so they are stretched by the factor `WIDER`: `benchmarks/coverage.py` has
    the numbers.

    An interval covers which training sets were drawn and which tasks tested, as if this
    circle of tasks was one of many. It knows nothing of how worlds differ otherwise,
    nor of another search. A single training set tells nothing of others, nor a single
    task of others. Where all errors are the same it has no length.

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
        values = np.atleast_2d(np.asarray(errors))
        if values.ndim > 2 or not values.size:
            raise ValueError(
                f"errors have shape {np.shape(errors)}; wanted (n_test_tasks,) or "
                "(n_training_sets, n_test_tasks), at least one of each"
            )
        self._is_share = values.dtype == bool
        values = values.astype(float)
        self._is_signed = not spread and bool((values < 0).any())
        shares = _check_weights(weights, values.shape[1])
        self.n_tasks = int(np.count_nonzero(shares))
        self.per_set = values @ shares
        apart = values - self.per_set[:, None]
        if spread:
            squares = apart**2 * self.n_tasks / max(1, self.n_tasks - 1)
            self.per_set = np.sqrt(squares @ shares)
            # What a square adds to a variance, its root feels by half, over itself.
            own = np.where(self.per_set > 0, self.per_set, np.inf)[:, None]
            apart = (squares - self.per_set[:, None] ** 2) / (2 * own)
        self.value = float(self.per_set.mean())
        self.waves = _find_waves(apart.mean(axis=0), shares)

    @classmethod
    def read(cls, stored: Mapping[str, Any]) -> Self:
        """Read what `stored` wrote.

        Parameters
        ----------
        stored : mapping
            Plain data.

        Returns
        -------
        Average
            The same, to six digits; it can be divided.
        """
        found = cls(np.atleast_2d(stored["per_repetition"]).T)
        found.value, found.n_tasks = stored["mean"], stored["n_tasks"]
        found.waves = np.array(stored["waves"], float).view(complex)
        return found

    def stored(self) -> dict[str, Any]:
        """Write it as plain data, see `six_digits`.

        Returns
        -------
        dict
            "mean", "low" and "high"; and what it takes to divide it by another:
            "n_tasks", "per_repetition" and "waves".
        """
        parts = self.waves.view(float)
        return {
            **self.estimate.stored("mean"),
            "n_tasks": self.n_tasks,
            "per_repetition": [six_digits(value) for value in self.per_set],
            "waves": [six_digits(value) for value in parts],
        }

    @property
    def estimate(self) -> Estimate:
        """The average with its 95 % interval."""
        value = self.value
        if self._is_share and 0 < value < 1:
            half = self._half_width(value * (1 - value))
            low, high = (float(expit(logit(value) + step)) for step in (-half, half))
        elif self._is_signed or not value > 0:
            half = self._half_width()
            low, high = value - half, value + half
        else:
            low, high = _around(value, self._half_width(value))
        return Estimate(value, low, high)

    def over(self, other: Average, *, same_sets: bool = True) -> Estimate:
        """Divide by another average over the same test tasks, with the same weights.

        Parameters
        ----------
        other : Average
            What to divide by.
        same_sets : bool, default=True
            Whether both are over the same training sets, in the same order; if there
            are not as many of either, they are not.

        Returns
        -------
        Estimate
            The ratio with its 95 % interval. Where either is not positive, there is
            none, and its bounds are not finite.

        Raises
        ------
        ValueError
            If the other is over another number of test tasks.
        """
        if self.n_tasks != other.n_tasks:
            raise ValueError(
                f"averages over {self.n_tasks} and {other.n_tasks} test tasks; wanted "
                "the same test tasks"
            )
        if not min(self.value, other.value) > 0:
            value = self.value / other.value if other.value else np.nan
            return Estimate(value, -np.inf, np.inf)
        ours, theirs = (one.per_set / one.value for one in (self, other))
        are_paired = same_sets and len(ours) == len(theirs)
        sets = [ours - theirs] if are_paired else [ours, theirs]
        waves = self.waves / self.value - other.waves / other.value
        ratio = self.value / other.value
        return Estimate(
            ratio, *_around(ratio, _half_width_of(waves, self.n_tasks, sets))
        )

    def _half_width(self, unit: float = 1.0) -> float:
        """Return half the length of the interval, in a unit."""
        return _half_width_of(self.waves / unit, self.n_tasks, [self.per_set / unit])


def _around(value: float, half: float) -> tuple[float, float]:
    """Return bounds of a positive number, from those of its logarithm."""
    factor = float(np.exp(min(half, _MOST)))
    return value / factor, value * factor


def _check_weights(weights: ArrayLike | None, n_tasks: int) -> Array:
    """Return the share of each task in the whole."""
    counted = np.ones(n_tasks) if weights is None else np.asarray(weights, float)
    if counted.shape != (n_tasks,):
        raise ValueError(
            f"weights have shape {counted.shape}; wanted ({n_tasks},), one a task"
        )
    if not (counted.min() >= 0 and counted.any()):
        least, most = counted.min(), counted.max()
        raise ValueError(
            f"weights from {least:g} to {most:g}; wanted none negative, one positive"
        )
    shares: Array = counted / counted.sum()
    return shares


def _find_waves(values: Array, shares: Array, n_waves: int = N_WAVES) -> Array:
    """Find the slowest waves in values round the circle, whose mean does not count."""
    n_counted = int(np.count_nonzero(shares))
    numbers = np.arange(1, min(n_waves, n_counted // 2) + 1)
    angles = 2 * np.pi * (np.cumsum(shares) - shares / 2)
    centred = (values - values @ shares) * shares
    found: Array = np.exp(1j * np.outer(numbers, angles)) @ centred
    return found


def _half_width_of(
    waves: Array, n_tasks: int, sets: Sequence[Array], wider: float = WIDER
) -> float:
    """Return half the length of an interval, of waves and of independent sets."""
    variances, freedoms = [0.0], [1]
    if len(waves):
        variances.append(float(np.mean(np.abs(waves) ** 2)))
        freedoms.append(min(2 * len(waves), n_tasks - 1))
    for values in sets:
        if len(values) > 1:
            variances.append(float(values.var(ddof=1) / len(values)))
            freedoms.append(len(values) - 1)
    total = float(np.sum(variances))
    # Satterthwaite's: variances of variances add up.
    weight = float(np.sum(np.square(variances) / freedoms))
    freedom = total**2 / weight if weight else 1.0
    return float(wider * stdtrit(freedom, 0.975) * np.sqrt(total))


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
        Bonferroni's inequality and as if they (their logarithms, if all is positive)
        were of Student's t with as many degrees of freedom as the waves of an
        `Average` have.

    Examples
    --------
    >>> print(bonferroni(Estimate(1.0, 0.5, 2.0), 20))
    1 [0.185, 5.4]
    """
    if estimate.low is None:
        return estimate
    is_positive = min(estimate.value, *estimate.bounds) > 0
    scaled = _mapped(np.log, estimate) if is_positive else estimate
    # Each misses with 5 % / n_looks: the interval grows as the quantile does.
    factor = stdtrit(2 * N_WAVES, 1 - 0.025 / n_looks) / stdtrit(2 * N_WAVES, 0.975)
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
