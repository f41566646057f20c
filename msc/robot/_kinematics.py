"""Kinematics: joint angles -> where the links are, and a path -> joint angles.

The inverse is differential damped least squares, followed from the home pose: each step
takes the smallest joint motion that brings the end effector to the path's next point.
So the redundant third joint needs no rule of its own, and the pose at the end depends
on the way there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats

DAMPING = 0.02  # m; where the arm is nearly singular, joints stay slow, the path is cut
MAX_JOINT_STEP = 0.4  # rad; at 60 Hz 24 rad/s, only met by paths out of reach


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


def inverse_kinematics(
    path: ArrayLike, home: ArrayLike, link_lengths: ArrayLike
) -> NDArray[np.float64]:
    """Follow end-effector paths with the arm's joints.

    Parameters
    ----------
    path : array_like of shape (..., n_times, 2)
        Where the end effector should be (m). The first point is the home pose's.
    home : array_like of shape (3,) or (..., 3)
        Joint angles at the first point (rad), of all paths or of each.
    link_lengths : array_like of shape (3,)
        Lengths of the links (m).

    Returns
    -------
    ndarray of shape (..., n_times, 3)
        Joint angles (rad).

    Notes
    -----
    Points of the plane are complex numbers here. With the Jacobian's columns j₁, j₂,
    j₃ and the error e, the step is dqₖ = Re(conj(jₖ) y), where y solves
    (J Jᵀ + damping²) y = e, that is p y + r conj(y) = e with
    p = Σ|jₖ|²/2 + damping² and r = Σ jₖ²/2. See [1]_.

    References
    ----------
    .. [1] Y. Nakamura, H. Hanafusa, "Inverse kinematic solutions with singularity
       robustness for robot manipulator control", J. Dyn. Syst. Meas. Control, 1986.

    Examples
    --------
    >>> path, home = [[1.2, 1.0], [1.19, 1.01]], [0, 0.5, 0.8]
    >>> joints = inverse_kinematics(path, home, [1, 1, 0.5])
    >>> joints.shape
    (2, 3)
    """
    points = to_floats("path", path)
    targets = points[..., 0] + 1j * points[..., 1]
    targets = np.moveaxis(targets, -1, 0).reshape(points.shape[-2], -1)
    shape = 3, targets.shape[1]
    joints = np.empty((len(targets), *shape))
    joints[0] = np.reshape(home, (-1, 3)).T
    # Constants in full, room for what comes in between: see `InverseDynamics`.
    lengths = np.reshape(link_lengths, (3, 1)).repeat(shape[1], axis=1).astype(complex)
    limit, unit = np.full(shape, MAX_JOINT_STEP), np.full(shape, 1j)
    half = np.full((2, shape[1]), 0.5 + 0j)
    arms, turned = np.empty((2, *shape), dtype=complex)
    squares, moduli = products = np.empty((2, *shape), dtype=complex)
    upper, middle, lower = arms
    for before, after, target in zip(joints, joints[1:], targets[1:], strict=False):
        arms.real = 0.0
        np.add.accumulate(before, out=arms.imag)
        np.multiply(lengths, np.exp(arms, out=arms), out=arms)  # the links
        middle += lower
        upper += middle  # now arms[k] points from joint k to the end effector
        error = target - upper
        arms *= unit  # jₖ = ∂(end effector)/∂qₖ, the Jacobian's columns
        np.conjugate(arms, out=turned)
        np.multiply(arms, arms, out=squares)
        np.multiply(arms, turned, out=moduli)
        r, p = half * np.add.reduce(products, axis=1)  # J Jᵀ y = p y + r conj(y)
        p = p.real + DAMPING**2
        y = (p * error - r * error.conj()) / (p * p - (r * r.conj()).real)
        step = np.minimum((turned * y).real, limit)  # dq = Jᵀ y
        np.add(before, np.maximum(step, -limit), out=after)
    joints = joints.reshape(len(targets), 3, *points.shape[:-2])
    return np.moveaxis(joints, (0, 1), (-2, -1))
