"""What comes in: real numbers, or one sentence that says what else they are.

First what is asked of any number, then what all learners ask of their data. Some load
scikit-learn or SciPy when they are called: a table does without. `argument` is what the
caller knows the values as; bounds belong to what is allowed, None is none.
"""

from __future__ import annotations

import warnings
from numbers import Integral
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

RandomState: TypeAlias = int | np.random.RandomState | np.random.Generator | None

LARGEST = 1e9
"""Of weights, degrees and metres: beyond it a float no longer tells a micrometre."""

MAGNITUDES = (1e-100, 1e100)
"""Of values whose sums of squares are sure to be neither infinite nor lost."""

LENGTH_SCALES = (0.2, 0.7, 2.5)
"""Length scales of kernels at which their search begins (rad)."""

LENGTH_SCALE_BOUNDS = (1e-2, 1e2)
"""Between which it ends (rad)."""

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


def warn_of_scale(tasks: _Array) -> None:
    """Warn of tasks at a scale on which no length scale would be found.

    Notes
    -----
    Tasks are counted once, however often they are given; tasks nearer than a tenth of
    the distance to the 16th nearest count as copies, and so does a group of any size
    within a fifth of the distance to the next. A column's neighbours are those among
    all columns scaled to the same span, twice as many as columns, as on a grid.
    On functions that change over a quarter of either column, of one that spans 6.3 and
    one whose neighbours lie 7.5 apart, 0.3 to 0.7 of the standard deviation was missed
    (16 to 64 tasks, on grids and at random), against 0.14 or less at best.

    Examples
    --------
    >>> warn_of_scale(np.linspace(0, 6.28, 24)[:, None])
    """
    spans = np.ptp(tasks, axis=0)
    varies = spans > 1e-9 * np.abs(tasks).max(axis=0)  # more than rounding
    distinct = _distinct(tasks[:, varies] / spans[varies])
    if len(distinct) < 3:
        return
    (columns,), spans = np.nonzero(varies), spans[varies]
    gap, steps = _nearest(distinct * spans), _steps(distinct) * spans
    is_other = (spans > 3 * spans.min()) & (steps > spans.min())
    has_neighbours = len(distinct) > 2 * len(spans)  # on all sides
    is_wide = (steps > 3 * LENGTH_SCALES[-1]) & is_other & has_neighbours
    if gap > 4 * LENGTH_SCALES[-1]:
        is_wide |= (steps > 4 * LENGTH_SCALES[-1]) | (spans == spans.max())
    widest = spans[~is_wide].max(initial=0.0)
    is_narrow = ~is_wide & ((spans < LENGTH_SCALE_BOUNDS[0]) | (spans < widest / 100))
    found = [
        f"span {spans[k]:.3g} and lie {steps[k]:.3g} apart in column {columns[k]} "
        f"(divide it by {spans[k] / 6:.2g}, say)"
        for k in np.flatnonzero(is_wide | is_narrow)
    ]
    if found:
        least, most = LENGTH_SCALE_BOUNDS
        warnings.warn(
            f"tasks {'; '.join(found)}, but kernels are tuned to length scales from "
            f"{least:g} to {most:g}, one for all columns: bring tasks to a scale on "
            "which policies change over about one unit in each column",
            UserWarning,
            stacklevel=3,
        )


def _distinct(points: _Array) -> _Array:
    """Return points, those left out that are copies of others, or nearly so."""
    if points.shape[1] == 0:
        return points[:1]
    points = np.unique(points, axis=0)
    distinct = thinned = _thin(points, 0.0, 0.1)
    radius = 1e-9
    while radius < 0.5:  # of many copies some stay
        radius *= 2
        thinner = _thin(thinned, radius)
        if len(thinner) < len(thinned):
            thinned = thinner
            off = np.quantile(_query(thinned, points)[0], 0.9)
            if len(thinned) > 2 and off < 0.2 * _nearest(thinned):
                distinct = _thin(thinned, 0.0, 0.1)
    return distinct


def _thin(points: _Array, radius: float, share: float = 0.0) -> _Array:
    """Drop points nearer to earlier ones than a radius, or a share of the 16th's."""
    n_points = len(points)
    distances, nearest = _query(points, points, range(1, min(17, n_points) + 1))
    is_copy = distances < np.maximum(radius, share * distances[:, -1:])
    is_later = nearest < np.arange(n_points)[:, None]
    return np.asarray(points[~(is_copy & is_later).any(axis=1)])


def _nearest(points: _Array) -> float:
    """Return the median distance of a point to the nearest other one."""
    return float(np.median(_query(points, points, 2)[0][:, 1]))


def _query(among: _Array, points: _Array, k: int | range = 1) -> Any:
    """Return distances and indices of the k nearest among some of each point."""
    from scipy.spatial import KDTree  # noqa: PLC0415

    return KDTree(among).query(points, k=k)


def _steps(points: _Array) -> _Array:
    """Return how far neighbours lie apart in each column, on a grid: its spacing."""
    n_points, n_columns = points.shape
    n_nearest = min(2 * n_columns + 1, n_points)
    nearest = _query(points, points, n_nearest)[1][:, 1:]
    apart = np.abs(points[nearest] - points[:, None]).mean(axis=1)
    return np.asarray(np.minimum(n_columns * np.median(apart, axis=0), 1.0))
