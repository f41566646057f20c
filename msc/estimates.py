"""Measured numbers with their intervals, and what becomes of both when combined."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri


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
        Which of several numbers it is, as "n = 24".
    """

    value: float
    low: float | None = None
    high: float | None = None
    label: str = ""

    @property
    def bounds(self) -> tuple[float, float]:
        """The interval, or the number twice."""
        low = self.value if self.low is None else self.low
        return low, self.value if self.high is None else self.high

    def __str__(self) -> str:
        """Say it to three digits."""
        if self.low is None and self.high is None:
            return _digits(self.value)
        low, high = map(_digits, self.bounds)
        return f"{_digits(self.value)} [{low}, {high}]"


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
        return _scaled(top, 1 / bottom.value)
    for effect in (top, bottom):
        if min(effect.value, *effect.bounds) <= 0:
            raise ValueError(f"{effect}: wanted positive numbers for a quotient")
    logs = (_mapped(np.log, effect) for effect in (top, bottom))
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
    down = np.hypot(plus.value - below, over - minus.value)
    up = np.hypot(above - plus.value, minus.value - under)
    return Estimate(value, float(value - down), float(value + up), plus.label)


def average(effects: Sequence[Estimate], *, geometric: bool) -> Estimate:
    """Average numbers that were measured together.

    Parameters
    ----------
    effects : sequence of Estimate
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
    if not effects:
        return Estimate(float("nan"))
    rows = np.array([(effect.value, *effect.bounds) for effect in effects])
    if geometric and (rows <= 0).any():
        raise ValueError(
            f"{rows.min():g}: wanted positive numbers for a geometric mean"
        )
    means = np.exp(np.log(rows).mean(axis=0)) if geometric else rows.mean(axis=0)
    value, low, high = map(float, means)
    is_exact = all(effect.low is effect.high is None for effect in effects)
    return Estimate(value) if is_exact else Estimate(value, low, high)


def bonferroni(effect: Estimate, n_looks: int) -> Estimate:
    """Widen an interval for having looked at several.

    Parameters
    ----------
    effect : Estimate
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
    if effect.low is None:
        return effect
    factor = ndtri(1 - 0.025 / n_looks) / ndtri(1 - 0.025)
    if min(effect.value, *effect.bounds) > 0:
        return _mapped(np.exp, _stretched(_mapped(np.log, effect), factor))
    return _stretched(effect, factor)


def _scaled(effect: Estimate, factor: float) -> Estimate:
    return _mapped(lambda number: factor * number, effect)


def _stretched(effect: Estimate, factor: float) -> Estimate:
    low, high = (
        effect.value + factor * (bound - effect.value) for bound in effect.bounds
    )
    return replace(effect, low=float(low), high=float(high))


def _mapped(function: Callable[[float], float], effect: Estimate) -> Estimate:
    """Change the scale of a number and of its interval."""
    low, high = (
        None if bound is None else float(function(bound))
        for bound in (effect.low, effect.high)
    )
    return replace(effect, value=float(function(effect.value)), low=low, high=high)


def _digits(value: float) -> str:
    """Write a number with three significant digits."""
    return f"{float(rounded(value, 3)):,g}".replace("-", "−")


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
