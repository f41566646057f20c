"""Weights of tasks, checked."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc._checks import to_floats


def validate_weights(sample_weight: Any, n_tasks: int) -> NDArray[np.float64]:
    """Return weights of tasks as floats, or say what is wrong with them.

    Parameters
    ----------
    sample_weight : array_like of shape (n_tasks,)
        How much each task counts.
    n_tasks : int
        How many tasks there are.

    Returns
    -------
    ndarray of shape (n_tasks,)
        The same numbers.

    Raises
    ------
    ValueError
        If the shape is another, one is negative or not finite, or all are zero.
    """
    weights = to_floats("sample_weight", sample_weight)
    if weights.shape != (n_tasks,):
        raise ValueError(
            f"sample_weight must have shape ({n_tasks},), one entry per task. "
            f"Got shape {weights.shape}."
        )
    bad = weights[~(np.isfinite(weights) & (weights >= 0))]
    if bad.size:
        raise ValueError(f"sample_weight must not be negative. Got {bad[0]}.")
    if not weights.any():
        raise ValueError("sample_weight is zero for all tasks: none is left to learn.")
    return weights
