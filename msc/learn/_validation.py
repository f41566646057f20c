"""What all learners ask of their data, and how they say what is wrong with it."""

from __future__ import annotations

from numbers import Integral
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import issparse
from sklearn.utils import check_random_state
from sklearn.utils.validation import validate_data

from msc._arrays import check_real, to_floats

Array = NDArray[np.float64]
RandomState: TypeAlias = int | np.random.RandomState | np.random.Generator | None

RANDOM_STATE = ["random_state", np.random.Generator]
"""What scikit-learn is to accept as a `random_state`: a Generator besides its own."""

MAGNITUDES = (1e-100, 1e100)
"""Of values whose sums of squares are sure to be neither infinite nor lost."""


_NO_NUMBERS = ("could not convert", "float() argument", "setting an array", "The DType")


def validate_points(estimator: Any, X: Any, **options: Any) -> Array:
    """Return the points, or raise a ValueError that names what is wrong with them.

    Parameters
    ----------
    estimator : estimator
        Whose data they are.
    X : array-like of shape (n_samples, n_features)
        Points, or tasks.
    **options : dict
        Passed on to scikit-learn's `validate_data`.

    Returns
    -------
    ndarray of shape (n_samples, n_features)
        The same, as floats.

    Raises
    ------
    ValueError
        If they are not finite real numbers, or of another shape.
    TypeError
        If they are a sparse matrix, or objects other than numbers.
    """
    check_real("X", X)
    try:
        with np.errstate(over="ignore"):  # of longer floats: told as infinity
            points = validate_data(estimator, X, dtype=np.float64, **options)
    except (TypeError, ValueError, OverflowError) as error:
        raise _named("X", error) from None
    return np.asarray(points)


def validate_pairs(estimator: Any, X: Any, y: Any) -> tuple[Array, Array]:
    """Return tasks and policies, or raise an error that names what is wrong with them.

    Parameters
    ----------
    estimator : estimator
        Whose data they are.
    X : array-like of shape (n_tasks, n_task_params)
        Tasks.
    y : array-like of shape (n_tasks, n_params) or (n_tasks,)
        Policies.

    Returns
    -------
    X : ndarray of shape (n_tasks, n_task_params)
        The same, as floats.
    y : ndarray of shape (n_tasks, n_params) or (n_tasks,)
        The same, as floats.

    Raises
    ------
    ValueError
        If they are not finite real numbers, of other shapes, or of different lengths.
    TypeError
        If they are sparse matrices, or tasks objects other than numbers.
    """
    if issparse(y):
        raise TypeError(
            "Sparse data was passed for y, but dense data is required. "
            "Use '.toarray()' to convert to a dense numpy array."
        )
    if y is not None:
        y = to_floats("y", y)
        if y.ndim == 0:
            raise ValueError(f"y must hold one policy a task. Got {y.item()}.")
    check_real("X", X)
    try:
        with np.errstate(over="ignore"):
            X, y = validate_data(
                estimator, X, y, dtype=np.float64, multi_output=True, y_numeric=True
            )
    except (TypeError, ValueError, OverflowError) as error:
        raise _named("X", error) from None
    return X, y


def validate_cost(cost: Any, n_tasks: int) -> Array:
    """Return the costs, or raise a ValueError that names what is wrong with them.

    Parameters
    ----------
    cost : array-like of shape (n_tasks,)
        What each training policy cost.
    n_tasks : int
        Number of tasks.

    Returns
    -------
    ndarray of shape (n_tasks,)
        The same, as floats.

    Raises
    ------
    ValueError
        If they are not positive finite numbers, one a task.
    """
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


def check_magnitude(argument: str, values: Array) -> None:
    """Refuse values of which squares overflow or vanish.

    Parameters
    ----------
    argument : str
        What the caller knows them as.
    values : ndarray
        Finite numbers.

    Raises
    ------
    ValueError
        If the largest magnitude is beyond 1e100, or below 1e-100 and not zero.

    Examples
    --------
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

    Parameters
    ----------
    random_state : int, RandomState instance, Generator or None
        An int is the seed itself; a generator is asked for the next one; None draws
        fresh entropy.

    Returns
    -------
    int
        A seed, >= 0.

    Examples
    --------
    >>> seed_of(7)
    7
    >>> seed_of(np.random.default_rng(0)) == seed_of(np.random.default_rng(0))
    True
    """
    if isinstance(random_state, Integral):
        return int(random_state)
    if random_state is None or isinstance(random_state, np.random.Generator):
        return int(np.random.default_rng(random_state).integers(2**31 - 1))
    return int(check_random_state(random_state).randint(2**31 - 1))


def _named(argument: str, error: Exception) -> Exception:
    """Name the argument in NumPy's complaint about what is no number."""
    if isinstance(error, OverflowError):
        return ValueError(f"{argument} must hold floats: {error}")
    if str(error).startswith(_NO_NUMBERS):
        return type(error)(f"{argument} must hold numbers: {error}")
    return error
