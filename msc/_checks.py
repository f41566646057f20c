"""What comes in: real numbers, or one sentence that says what else they are.

First what is asked of any number, then what all learners ask of their data. These load
scikit-learn when they are called: an arm does without. `argument` is what the caller
knows the values as; bounds belong to what is allowed, None is none.
"""

from __future__ import annotations

from numbers import Integral
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

RandomState: TypeAlias = int | np.random.RandomState | np.random.Generator | None

LARGEST = 1e9
"""Of weights, degrees and metres: beyond it a float no longer tells a micrometre."""

MAGNITUDES = (1e-100, 1e100)
"""Of values whose sums of squares are sure to be neither infinite nor lost."""

RANDOM_STATE = ["random_state", np.random.Generator]
"""What scikit-learn is to accept as a `random_state`: a Generator besides its own."""

REAL: Any = (int, float, np.integer, np.floating)

_Array = NDArray[np.float64]
_NO_NUMBERS = ("could not convert", "float() argument", "setting an array", "The DType")


def check_real(argument: str, values: Any) -> None:
    """Refuse complex numbers, dates and masks: NumPy would make floats of them.

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

    Their shape is left alone; NaN and infinity are let through.

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


def check_whole(
    argument: str, value: Any, lowest: int, highest: int | None = None
) -> None:
    """Refuse a count beyond its bounds, or that is none.

    >>> check_whole("n_parallel", 2.5, 1, 1000)
    Traceback (most recent call last):
    ...
    ValueError: n_parallel=2.5; wanted at least 1, whole, and at most 1000
    """
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not (is_whole and lowest <= value and (highest is None or value <= highest)):
        most = "" if highest is None else f", and at most {highest}"
        raise ValueError(f"{argument}={value!r}; wanted at least {lowest}, whole{most}")


def check_kind(argument: str, value: Any, kind: type) -> None:
    """Refuse what is no object of a class.

    >>> check_kind("gated", "no", bool)
    Traceback (most recent call last):
    ...
    TypeError: gated='no'; wanted a bool
    """
    if not isinstance(value, kind):
        raise TypeError(f"{argument}={value!r}; wanted a {kind.__name__}")


def validate_points(estimator: Any, X: Any, **options: Any) -> _Array:
    """Return the points, or raise a ValueError that names what is wrong with them."""
    return np.asarray(_validate(estimator, X, **options))


def validate_pairs(estimator: Any, X: Any, y: Any) -> tuple[_Array, _Array]:
    """Return tasks and policies, of one number or several, or refuse them by name."""
    from scipy.sparse import issparse  # noqa: PLC0415

    if issparse(y):
        raise TypeError(
            "Sparse data was passed for y, but dense data is required. "
            "Use '.toarray()' to convert to a dense numpy array."
        )
    if y is not None:
        y = to_floats("y", y)
        if y.ndim == 0:
            raise ValueError(f"y must hold one policy a task. Got {y.item()}.")
    X, y = _validate(estimator, X, y, multi_output=True, y_numeric=True)
    return X, y


def _validate(estimator: Any, *data: Any, **options: Any) -> Any:
    """Let scikit-learn validate an estimator's data, X first, as floats."""
    from sklearn.utils.validation import validate_data  # noqa: PLC0415

    check_real("X", data[0])
    try:
        with np.errstate(over="ignore"):  # of longer floats: told as infinity
            return validate_data(estimator, *data, dtype=np.float64, **options)
    except OverflowError as error:
        raise ValueError(f"X must hold floats: {error}") from None
    except (TypeError, ValueError) as error:
        if str(error).startswith(_NO_NUMBERS):
            raise type(error)(f"X must hold numbers: {error}") from None
        raise


def validate_sample(tasks: Any, policies: Any) -> tuple[_Array, _Array]:
    """Return tasks and policies that no estimator is fitted to, or refuse them."""
    from sklearn.utils import check_X_y  # noqa: PLC0415

    X, y = check_X_y(
        tasks, policies, dtype=np.float64, multi_output=True, ensure_min_samples=3
    )
    return X, y.astype(np.float64).reshape(len(X), -1)


def validate_cost(cost: Any, n_tasks: int) -> _Array:
    """Return the costs, or raise a ValueError that names what is wrong with them."""
    costs = to_floats("cost", cost)
    if costs.shape != (n_tasks,):
        raise ValueError(
            f"cost must have shape ({n_tasks},), one entry per task. "
            f"Got shape {costs.shape}."
        )
    bad = costs[~(np.isfinite(costs) & (costs > 0))]
    if bad.size:
        raise ValueError(f"cost must be positive and finite. Got {bad[0]}.")
    return costs


def check_magnitude(argument: str, values: _Array) -> None:
    """Refuse values of which squares overflow or vanish.

    >>> check_magnitude("y", np.array([0.0, -2.0]))
    """
    largest = values.flat[np.abs(values).argmax()]
    lowest, highest = MAGNITUDES
    if largest and not lowest <= abs(largest) <= highest:
        raise ValueError(
            f"{argument} must have its largest magnitude from {lowest:g} to "
            f"{highest:g}, or squares leave the floats: rescale it. Got {largest:g}."
        )


def seed_of(random_state: RandomState) -> int:
    """Turn any random_state into an int without touching NumPy's global state.

    An int is the seed itself; a generator is asked for the next one; None draws fresh
    entropy.

    >>> seed_of(7)
    7
    >>> seed_of(np.random.default_rng(0)) == seed_of(np.random.default_rng(0))
    True
    """
    if isinstance(random_state, Integral):
        return int(random_state)
    if random_state is None or isinstance(random_state, np.random.Generator):
        return int(np.random.default_rng(random_state).integers(2**31 - 1))
    assert isinstance(random_state, np.random.RandomState)
    return int(random_state.randint(2**31 - 1))
