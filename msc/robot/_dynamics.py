"""Inverse dynamics: how an arm is to accelerate -> the joint torques that takes.

The links are slender, uniform rods turning in a horizontal plane, where nothing has to
be held up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats

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


class InverseDynamics:
    """The torques that make arms accelerate as wanted, asked for time and again.

    Parameters
    ----------
    inertias : ndarray of shape (n_joints, n_joints)
        What `coupled_inertias` gives.
    n_arms : int
        How many arms.

    Notes
    -----
    Lagrange's equations. With links as complex numbers zⱼ = exp(i φⱼ), the torque about
    the near end of link i is the imaginary part of conj(zᵢ) Σⱼ mᵢⱼ z̈ⱼ, and a joint has
    to bear those of all links beyond it.

    On so few numbers most of NumPy's time goes into fitting shapes and types to one
    another, so constants are kept in full, and so is room for what comes in between.

    Examples
    --------
    >>> torques_of = InverseDynamics(coupled_inertias([1.0], [3.0]), n_arms=2)
    >>> torques_of(np.array([[[0.3, 0.3]], [[5.0, 5.0]], [[2.0, 4.0]]]))
    array([[2., 4.]])
    """

    def __init__(self, inertias: _Array, n_arms: int) -> None:
        shape = len(inertias), n_arms
        self._weights = inertias.T[..., None].repeat(n_arms, axis=-1).astype(complex)
        self._weighted = np.empty_like(self._weights)
        self._links, self._pulled = np.empty((2, *shape), dtype=complex)
        self._turning = np.empty((3, *shape))  # of the links
        self._parts, self._terms = tuple(self._turning), tuple(self._weighted)

    def __call__(self, motion: _Array) -> _Array:
        """Find the torques.

        Parameters
        ----------
        motion : ndarray of shape (3, n_joints, n_arms)
            Joint angles, velocities and accelerations (rad, rad/s, rad/s²).

        Returns
        -------
        ndarray of shape (n_joints, n_arms)
            Torques of the joints (N m).
        """
        angle, speed, acceleration = self._parts
        np.add.accumulate(motion, axis=1, out=self._turning)
        links, pulled = self._links, self._pulled
        links.real, links.imag = 0.0, angle
        np.exp(links, out=links)
        pulled.real, pulled.imag = -(speed * speed), acceleration
        pulled *= links  # z̈
        np.multiply(self._weights, pulled[:, None], out=self._weighted)
        about, *others = self._terms
        for other in others:
            about += other
        np.conjugate(links, out=links)
        np.multiply(links, about, out=about)
        return np.add.accumulate(about.imag[::-1], axis=0)[::-1].copy()


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
        Torques of the joints (N m), see `InverseDynamics`.

    Examples
    --------
    >>> inertias = coupled_inertias([1.0], [3.0])
    >>> joint_torques([[0.3], [5.0], [2.0]], inertias)
    array([2.])
    """
    moving = to_floats("motion", motion)
    arms = moving.reshape(*moving.shape[:2], -1)
    torques = InverseDynamics(inertias, arms.shape[-1])(arms)
    return torques.reshape(moving.shape[1:])
