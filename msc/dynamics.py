"""Inverse dynamics: how an arm is to accelerate -> the joint torques that takes.

The links are slender, uniform rods turning in a horizontal plane, where nothing has to
be held up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Array = NDArray[np.float64]


def rod_inertia(length: ArrayLike, mass: ArrayLike) -> _Array:
    """Return the moment of inertia of slender rods about their middle.

    Parameters
    ----------
    length, mass : float or array_like
        Of the rods (m, kg).

    Returns
    -------
    float or ndarray
        Moments of inertia (kg m²).
    """
    return np.asarray(mass) * np.square(length) / 12


def coupled_inertias(link_lengths: ArrayLike, link_masses: ArrayLike) -> _Array:
    """Return the constants of an arm's equations of motion.

    Parameters
    ----------
    link_lengths, link_masses : array_like of shape (n_joints,)
        Of the links, from the base outwards (m, kg).

    Returns
    -------
    ndarray of shape (n_joints, n_joints)
        Constants m of the kinetic energy, ½ Σ mᵢⱼ cos(φᵢ - φⱼ) φ̇ᵢ φ̇ⱼ, where φᵢ is the
        angle of link i to a fixed direction (kg m²).

    Examples
    --------
    >>> coupled_inertias([1.0, 1.0], [3.0, 3.0])
    array([[4. , 1.5],
           [1.5, 1. ]])
    """
    lengths = np.asarray(link_lengths, dtype=float)
    masses = np.asarray(link_masses, dtype=float)
    beyond = masses.sum() - np.cumsum(masses)  # what each link carries at its end
    levers = lengths * (masses / 2 + beyond)
    inertias = np.triu(np.outer(lengths, levers), 1)
    own = rod_inertia(lengths, masses) + lengths**2 * (masses / 4 + beyond)
    return inertias + inertias.T + np.diag(own)


def joint_torques(motion: ArrayLike, inertias: _Array) -> _Array:
    """Find the torques that make an arm, or several, accelerate as wanted.

    Parameters
    ----------
    motion : array_like of shape (3, n_joints, ...)
        Joint angles, velocities and accelerations (rad, rad/s, rad/s²).
    inertias : ndarray of shape (n_joints, n_joints)
        What `coupled_inertias` gives.

    Returns
    -------
    ndarray of shape (n_joints, ...)
        Torques of the joints (N m).

    Notes
    -----
    Lagrange's equations. With links as complex numbers zⱼ = exp(i φⱼ), the torque about
    the near end of link i is the imaginary part of conj(zᵢ) Σⱼ mᵢⱼ z̈ⱼ, and a joint has
    to bear those of all links beyond it.

    Examples
    --------
    >>> inertias = coupled_inertias([1.0], [3.0])
    >>> joint_torques([[0.3], [5.0], [2.0]], inertias)
    array([2.])
    """
    angle, speed, acceleration = np.add.accumulate(np.asarray(motion), axis=1)
    links = np.exp(1j * angle)
    pulled = (1j * acceleration - speed * speed) * links
    weights = inertias.reshape(*inertias.shape, *(1,) * (angle.ndim - 1))
    about = (links.conj() * np.add.reduce(weights * pulled, axis=1)).imag
    return np.add.accumulate(about[::-1], axis=0)[::-1]
