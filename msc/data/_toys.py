"""Points on two curves that nearly touch: few enough to be looked at."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def make_two_arcs(
    n_points: int = 60, gap: float = 0.045
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Place points on two arcs that bend away from each other.

    Parameters
    ----------
    n_points : int, default=60
        Points on each curve.
    gap : float, default=0.045
        How near the curves come; by default nearer than neighbours on a curve are.

    Returns
    -------
    points : ndarray of shape (2 * n_points, 2)
        First those of the upper curve, from left to right.
    curves : ndarray of shape (2 * n_points,)
        Which curve each belongs to: 0 or 1.

    Raises
    ------
    ValueError
        If there are too few points, or no gap.

    Examples
    --------
    >>> points, curves = make_two_arcs(5)
    >>> points.shape, curves.tolist()
    ((10, 2), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1])
    """
    if n_points < 3 or gap <= 0:
        raise ValueError(
            f"n_points={n_points}, gap={gap}; wanted at least 3 and a gap above 0"
        )
    across = np.linspace(-1.6, 1.6, n_points)
    up = 0.45 * across**2 + gap / 2
    points = np.r_[np.c_[across, up], np.c_[across, -up]]
    return points, np.repeat(np.arange(2), n_points)
