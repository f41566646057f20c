"""What all learners ask of their data, and how they say what is wrong with it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import issparse
from sklearn.utils.validation import validate_data

Array = NDArray[np.float64]


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
        If they are not finite numbers, or of another shape.
    """
    try:
        return np.asarray(validate_data(estimator, X, dtype=np.float64, **options))
    except ValueError as error:
        raise _named("X", error) from None


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
        If they are not finite numbers, of other shapes, or of different lengths.
    TypeError
        If the policies are a sparse matrix.
    """
    if issparse(y):
        raise TypeError(
            "Sparse data was passed for y, but dense data is required. "
            "Use '.toarray()' to convert to a dense numpy array."
        )
    try:
        X, y = validate_data(
            estimator, X, y, dtype=np.float64, multi_output=True, y_numeric=True
        )
        return X, np.asarray(y, dtype=np.float64)
    except ValueError as error:
        validate_points(estimator, X)
        raise _named("y", error) from None


def _named(argument: str, error: ValueError) -> ValueError:
    """Name the argument in NumPy's complaint about what is no number."""
    if str(error).startswith("could not convert"):
        return ValueError(f"{argument} must hold numbers: {error}")
    return error
