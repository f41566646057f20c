"""Round obstacles, and how far the arm is from them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

LINK_RADIUS = 0.02  # m; half the thickness of a link


class Circle(NamedTuple):
    """A round obstacle, as seen from above.

    Attributes
    ----------
    x, y : float
        Its centre, from the arm's base (m).
    radius : float
        Its radius (m).
    """

    x: float
    y: float
    radius: float


def clearance(points: ArrayLike, circle: Circle) -> NDArray[np.float64]:
    """Measure the gap between an arm's links and the centre of a circle.

    Parameters
    ----------
    points : array_like of shape (..., 4, 2)
        What `forward_kinematics` gives (m).
    circle : Circle
        The circle; its radius does not count.

    Returns
    -------
    ndarray of shape (...)
        Smallest distance of the links' surfaces from the centre (m).

    Examples
    --------
    >>> from msc.robot import forward_kinematics
    >>> arm = forward_kinematics([0.0, 0.0, 0.0], [0.40, 0.35, 0.25])
    >>> clearance(arm, Circle(0.5, 0.3, 0.1)).round(3)
    np.float64(0.28)
    """
    points = np.asarray(points, dtype=float)
    starts, steps = points[..., :-1, :], np.diff(points, axis=-2)
    to_centre = np.array([circle.x, circle.y]) - starts
    along = np.sum(to_centre * steps, axis=-1) / np.sum(steps**2, axis=-1)
    apart = to_centre - np.clip(along, 0, 1)[..., None] * steps
    return np.asarray(np.hypot(apart[..., 0], apart[..., 1]).min(axis=-1) - LINK_RADIUS)
