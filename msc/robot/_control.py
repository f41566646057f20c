"""The controller: planned and actual joint motion -> torques, for many arms at once.

It asks every joint for an acceleration; inverse dynamics say which torques that takes.
The links are slender, uniform rods turning in a horizontal plane, where nothing has to
be held up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import check_number, to_floats

if TYPE_CHECKING:
    from msc.robot._workspace import Workspace

TIME_STEP = 1 / 60  # s; between two commands, and between two rows of a rollout

_Array = NDArray[np.float64]


def rod_inertia(length: ArrayLike, mass: ArrayLike) -> _Array:
    """Return the moment of inertia of slender rods about their middle."""
    return np.asarray(mass) * np.square(length) / 12


def coupled_inertias(link_lengths: ArrayLike, link_masses: ArrayLike) -> _Array:
    """Return the constants of an arm's equations of motion.

    Parameters
    ----------
    link_lengths, link_masses : array_like of shape (n_joints,)
        Of thin rods (m, kg).

    Returns
    -------
    ndarray of shape (n_joints, n_joints)
        How the acceleration of one link turns about the near end of another (kg m²).

    Examples
    --------
    >>> from msc.robot import coupled_inertias
    >>> coupled_inertias([1.0, 1.0], [3.0, 3.0])
    array([[4. , 1.5],
           [1.5, 1. ]])
    """
    lengths = np.asarray(link_lengths, dtype=float)
    masses = np.asarray(link_masses, dtype=float)
    beyond = masses.sum() - np.cumsum(masses)  # what each link carries at its end
    levers = link_levers(lengths, masses)
    inertias = np.triu(np.outer(lengths, levers), 1)
    own = rod_inertia(lengths, masses) + lengths**2 * (masses / 4 + beyond)
    return inertias + inertias.T + np.diag(own)


def link_levers(link_lengths: ArrayLike, link_masses: ArrayLike) -> _Array:
    """Return each link's length times its and what it carries' mass, as levers go.

    Times gravity, these are the torques about the links' near ends that hold an arm
    whose links are level.

    Examples
    --------
    >>> link_levers([1.0, 1.0], [3.0, 3.0])
    array([4.5, 1.5])
    """
    lengths = np.asarray(link_lengths, dtype=float)
    masses = np.asarray(link_masses, dtype=float)
    return np.asarray(lengths * (masses / 2 + masses.sum() - np.cumsum(masses)))


class InverseDynamics:
    """The torques that make arms accelerate as wanted, asked for time and again.

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

    def __init__(
        self, inertias: _Array, n_arms: int, weights: _Array | None = None
    ) -> None:
        shape = len(inertias), n_arms
        # Torques that hold the links against gravity when they are level.
        self._hold = None if weights is None else np.asarray(weights)[:, None]
        self._weights = inertias.T[..., None].repeat(n_arms, axis=-1).astype(complex)
        self._weighted = np.empty_like(self._weights)
        self._links, self._pulled = np.empty((2, *shape), dtype=complex)
        self._turning = np.empty((3, *shape))  # of the links
        self._parts, self._terms = tuple(self._turning), tuple(self._weighted)

    def __call__(self, motion: _Array) -> _Array:
        """Find (n_joints, n_arms) torques of motion, as `joint_torques` has it."""
        angle, speed, acceleration = self._parts
        np.add.accumulate(motion, axis=1, out=self._turning)
        links, pulled = self._links, self._pulled
        links.real, links.imag = 0.0, angle
        np.exp(links, out=links)  # zⱼ = exp(i φⱼ)
        pulled.real, pulled.imag = -(speed * speed), acceleration
        pulled *= links  # z̈ⱼ = (i φ̈ⱼ - φ̇ⱼ²) zⱼ
        np.multiply(self._weights, pulled[:, None], out=self._weighted)
        about, *others = self._terms  # Σⱼ mᵢⱼ z̈ⱼ, of all links i
        for other in others:
            about += other
        np.conjugate(links, out=links)
        np.multiply(links, about, out=about)
        if self._hold is not None:
            about.imag += self._hold * links.real
        # From the last joint inwards, as the recursive Newton-Euler method adds up.
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


@dataclass(frozen=True)
class ControllerGains:
    """A PID controller of joint angles, its output turned into torques.

    Proportional, integral and derivative term give an acceleration for every joint, on
    top of the planned one; inverse dynamics give the torques ("computed torque"). So
    every joint's error e dies out alike, whatever the pose: (d/dt + bandwidth)³ ∫e = 0.

    Parameters
    ----------
    bandwidth : float, default=15.0
        Decay of errors (1/s), from 0 to 1000.
    windup : float, default=0.005
        Bound of the integrated error (rad s), so that an arm that an obstacle holds up
        does not push ever harder; 0 or more, also infinite.
    torque_limit : tuple of float
        Largest torques (N m) of the three joints; positive, or infinite.

    Raises
    ------
    ValueError
        If a number is beyond its bounds.
    """

    bandwidth: float = 15.0
    windup: float = 0.005
    torque_limit: tuple[float, float, float] = (40.0, 20.0, 5.0)

    def __post_init__(self) -> None:
        """Refuse gains and limits that are none."""
        check_number("bandwidth", self.bandwidth, 0.0, 1000.0)
        check_number("windup", self.windup, 0.0, np.inf)
        limits = to_floats("torque_limit", self.torque_limit)
        is_real = np.asarray(self.torque_limit).dtype.kind in "iuf"  # no text, say
        if not is_real or limits.shape != (3,) or not (limits > 0).all():
            raise ValueError(
                f"torque_limit={self.torque_limit}; wanted 3 positive numbers"
            )


class ComputedTorqueController:
    """Arms on their way along a plan (n_steps + 1, 3, n_arms), with their integrals."""

    def __init__(
        self,
        controller: ControllerGains,
        plan: _Array,
        inertias: _Array,
        time_step: float = TIME_STEP,
        weights: _Array | None = None,
    ) -> None:
        rate = controller.bandwidth  # (d/dt + rate)³ = d³/dt³ + 3 rate d²/dt² + …
        proportional, derivative, integral = 3 * rate**2, 3 * rate, rate**3
        speed = np.gradient(plan, time_step, axis=0)
        acceleration = np.gradient(speed, time_step, axis=0)
        drive = acceleration + derivative * speed + proportional * plan
        self._plan, self._drive = list(plan), list(drive)
        # Constants in full: NumPy is quick where it need not fit shapes to one another.
        shape = plan.shape[1:]
        gains = proportional, derivative, integral, time_step, controller.windup
        *self._gains, self._time_step, self._windup = (np.full(shape, g) for g in gains)
        limit = np.array(controller.torque_limit)[:, None]
        self._limit = limit.repeat(shape[1], axis=1)
        self._integral = np.zeros(shape)
        self._motion = np.empty((3, *shape))
        self._parts = tuple(self._motion)
        self._torques_of = InverseDynamics(inertias, shape[1], weights)

    def torques(self, step: int, state: _Array) -> _Array:
        """Decide the torques of a time step."""
        proportional, derivative, integral = self._gains
        angle, speed, acceleration = self._parts
        self._motion[:2] = state
        # Acceleration that is asked for: planned + 3r ė + 3r² e + r³ ∫e, with e = plan
        # - angle; what depends on the plan alone is `drive`, computed beforehand.
        self._integral += self._time_step * (self._plan[step] - angle)
        _bound(self._integral, self._windup)
        acceleration[:] = (
            self._drive[step]
            - proportional * angle
            - derivative * speed
            + integral * self._integral
        )
        torque = self._torques_of(self._motion)
        _bound(torque, self._limit)
        return torque


def _bound(values: _Array, limit: _Array) -> None:
    """Keep values within plus and minus a limit, in place."""
    np.minimum(values, limit, out=values)
    np.maximum(values, -limit, out=values)


def steer(
    workspace: Workspace, controller: ControllerGains, plan: _Array
) -> ComputedTorqueController:
    """Return what drives the arms of a workspace along a plan."""
    links = workspace.link_lengths, workspace.link_masses
    physics = workspace.physics
    weights = physics.gravity * link_levers(*links) if physics.gravity else None
    inertias = coupled_inertias(*links)
    return ComputedTorqueController(
        controller, plan, inertias, physics.time_step, weights
    )
