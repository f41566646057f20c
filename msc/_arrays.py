"""Numbers as they come in: real ones, or one sentence that says what they are."""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST = 1e9
"""Of weights, degrees and metres: beyond it a float no longer tells a micrometre."""


REAL: Any = (int, float, np.integer, np.floating)


def check_real(argument: str, values: Any) -> None:
    """Refuse what NumPy would turn into floats without a word, but not whole.

    Parameters
    ----------
    argument : str
        What the caller knows them as.
    values : array-like
        What was given.

    Raises
    ------
    ValueError
        If there are complex numbers, dates or masked entries among them.

    Examples
    --------
    >>> check_real("policy", [1.0, 2.0 + 0.5j])
    Traceback (most recent call last):
    ...
    ValueError: Complex data not supported: policy must hold real numbers.
    """
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):  # no array at all: left to whoever converts it
        return
    kinds = {array.dtype.kind}
    if array.dtype.kind == "O":
        kinds = {np.asarray(value).dtype.kind for value in array.flat}
    if "c" in kinds:
        raise ValueError(
            f"Complex data not supported: {argument} must hold real numbers."
        )
    if kinds & set("mM"):
        raise ValueError(f"{argument} must hold numbers. Got dates or times.")
    if np.ma.is_masked(values):
        raise ValueError(f"{argument} must hold numbers. Got masked entries.")


def to_floats(argument: str, values: Any) -> NDArray[np.float64]:
    """Return numbers as floats, or raise a ValueError that names what they are.

    Parameters
    ----------
    argument : str
        What the caller knows them as.
    values : array-like
        What was given.

    Returns
    -------
    ndarray
        The same, of whatever shape; NaN and infinity are let through.

    Raises
    ------
    ValueError
        If they are not real numbers.

    Examples
    --------
    >>> to_floats("task_deg", [0, 90])
    array([ 0., 90.])
    """
    check_real(argument, values)
    try:
        with np.errstate(over="ignore"):  # of longer floats: infinity, as a float says
            return np.asarray(values, dtype=np.float64)
    except OverflowError as error:
        raise ValueError(f"{argument} must hold floats: {error}") from None
    except (TypeError, ValueError) as error:
        raise ValueError(f"{argument} must hold numbers: {error}") from None


def check_number(argument: str, value: Any, lowest: float, highest: float) -> None:
    """Refuse a constant beyond its bounds, or that is no real number.

    Parameters
    ----------
    argument : str
        What the caller knows it as.
    value : object
        What was given.
    lowest, highest : float
        Its bounds, which belong to what is allowed.

    Raises
    ------
    ValueError
        If it is beyond them.

    Examples
    --------
    >>> check_number("spring", -1.0, 0.01, 1e4)
    Traceback (most recent call last):
    ...
    ValueError: spring=-1.0; wanted a positive number from 0.01 to 10000
    """
    is_real = isinstance(value, REAL) and not isinstance(value, bool)
    if not (is_real and lowest <= value <= highest):
        sign = "positive" if lowest > 0 else "finite" if highest < np.inf else "real"
        raise ValueError(
            f"{argument}={value}; wanted a {sign} number from {lowest:g} to {highest:g}"
        )


def check_whole(argument: str, value: Any, lowest: int, highest: int) -> None:
    """Refuse a count beyond its bounds, or that is none.

    Parameters
    ----------
    argument : str
        What the caller knows it as.
    value : object
        What was given.
    lowest, highest : int
        Its bounds, which belong to what is allowed.

    Raises
    ------
    ValueError
        If it is beyond them.

    Examples
    --------
    >>> check_whole("n_parallel", 2.5, 1, 1000)
    Traceback (most recent call last):
    ...
    ValueError: n_parallel=2.5; wanted at least 1, whole, and at most 1000
    """
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not (is_whole and lowest <= value <= highest):
        raise ValueError(
            f"{argument}={value!r}; wanted at least {lowest}, whole, and at most "
            f"{highest}"
        )


def check_kind(argument: str, value: Any, kind: type) -> None:
    """Refuse what is no object of a class.

    Parameters
    ----------
    argument : str
        What the caller knows it as.
    value : object
        What was given.
    kind : type
        The class.

    Raises
    ------
    TypeError
        If it is another's.

    Examples
    --------
    >>> check_kind("gated", "no", bool)
    Traceback (most recent call last):
    ...
    TypeError: gated='no'; wanted a bool
    """
    if not isinstance(value, kind):
        raise TypeError(f"{argument}={value!r}; wanted a {kind.__name__}")
