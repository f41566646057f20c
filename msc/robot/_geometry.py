"""Plane geometry of an arm: where its links are, how far they are from a circle.

Lengths are in metres, angles in radians.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats

LINK_RADIUS = 0.02  # m; half the thickness of a link


class Circle(NamedTuple):
    """A round obstacle, as seen from above (m)."""

    x: float
    y: float
    radius: float


def home_pose(
    link_lengths: tuple[float, float, float], reach: float, heading: float
) -> tuple[float, float, float]:
    """Find the pose (q, b, b), b > 0, that puts the end effector at a given place.

    Parameters
    ----------
    link_lengths : tuple of float
        Lengths of the three links (m).
    reach : float
        Distance of the end effector from the base (m).
    heading : float
        World angle of the end effector as seen from the base (rad).

    Returns
    -------
    tuple of float
        Joint angles (rad).

    Notes
    -----
    The squared reach is a quadratic in cos b.

    Examples
    --------
    >>> [round(angle, 3) for angle in home_pose((0.40, 0.35, 0.25), 0.85, 0.0)]
    [-0.592, 0.707, 0.707]
    """
    first, second, third = link_lengths
    quadratic = 4 * first * third
    linear = 2 * second * (first + third)
    constant = (first - third) ** 2 + second**2 - reach**2
    root = math.sqrt(linear**2 - 4 * quadratic * constant)
    bend = math.acos((root - linear) / (2 * quadratic))
    tip = first + second * np.exp(1j * bend) + third * np.exp(2j * bend)
    return (heading - float(np.angle(tip)), bend, bend)


def forward_kinematics(
    joints: ArrayLike, link_lengths: ArrayLike
) -> NDArray[np.float64]:
    """Place the arm's joints and its end effector (forward kinematics).

    Parameters
    ----------
    joints : array_like of shape (..., 3)
        Joint angles, each relative to the link before (rad).
    link_lengths : array_like of shape (3,)
        Lengths of the links (m).

    Returns
    -------
    ndarray of shape (..., 4, 2)
        The base, the two joints further out and the end effector (m).

    Examples
    --------
    >>> forward_kinematics([0.0, 0.0, 0.0], [0.40, 0.35, 0.25])[-1]
    array([1., 0.])
    """
    heading = np.cumsum(to_floats("joints", joints), axis=-1)
    links = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    links = links * np.asarray(link_lengths, dtype=float)[:, None]
    base = np.zeros((*heading.shape[:-1], 1, 2))
    return np.concatenate([base, np.cumsum(links, axis=-2)], axis=-2)


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
