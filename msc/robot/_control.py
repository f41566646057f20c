"""The controller: planned and actual joint motion -> torques, for many arms at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from msc._checks import check_number, to_floats
from msc.robot._dynamics import InverseDynamics

TIME_STEP = 1 / 60  # s; between two commands, and between two rows of a rollout


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
        if limits.shape != (3,) or not (limits > 0).all():
            raise ValueError(
                f"torque_limit={self.torque_limit}; wanted 3 positive numbers"
            )


class ComputedTorqueController:
    """Arms on their way along plans: the controller with its memory.

    Parameters
    ----------
    controller : ControllerGains
        Gains and limits.
    plan : ndarray of shape (n_steps + 1, 3, n_arms)
        Joint angles to follow, one row a time step (rad).
    inertias : ndarray of shape (3, 3)
        Of the arm, see `msc.robot.coupled_inertias`.
    """

    def __init__(
        self,
        controller: ControllerGains,
        plan: NDArray[np.float64],
        inertias: NDArray[np.float64],
    ) -> None:
        rate = controller.bandwidth
        proportional, derivative, integral = 3 * rate**2, 3 * rate, rate**3
        speed = np.gradient(plan, TIME_STEP, axis=0)
        acceleration = np.gradient(speed, TIME_STEP, axis=0)
        drive = acceleration + derivative * speed + proportional * plan
        self._plan, self._drive = list(plan), list(drive)
        # Constants in full: NumPy is quick where it need not fit shapes to one another.
        shape = plan.shape[1:]
        gains = proportional, derivative, integral, TIME_STEP, controller.windup
        *self._gains, self._time_step, self._windup = (np.full(shape, g) for g in gains)
        limit = np.array(controller.torque_limit)[:, None]
        self._limit = limit.repeat(shape[1], axis=1)
        self._integral = np.zeros(shape)
        self._motion = np.empty((3, *shape))
        self._parts = tuple(self._motion)
        self._torques_of = InverseDynamics(inertias, shape[1])

    def torques(self, step: int, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Decide the torques of a time step.

        Parameters
        ----------
        step : int
            Its number; steps are gone through in order.
        state : ndarray of shape (2, 3, n_arms)
            Joint angles and velocities (rad, rad/s).

        Returns
        -------
        ndarray of shape (3, n_arms)
            Torques (N m).
        """
        proportional, derivative, integral = self._gains
        angle, speed, acceleration = self._parts
        self._motion[:2] = state
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


def _bound(values: NDArray[np.float64], limit: NDArray[np.float64]) -> None:
    """Keep values within plus and minus a limit, in place."""
    np.minimum(values, limit, out=values)
    np.maximum(values, -limit, out=values)
