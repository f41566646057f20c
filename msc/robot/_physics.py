"""How time passes in a world."""

from __future__ import annotations

from dataclasses import dataclass

from msc._checks import check_number, check_whole

ENGINES = ("pybullet", "mujoco")


@dataclass(frozen=True)
class Physics:
    """How time passes: the engine, its steps, the controller's, gravity.

    Parameters
    ----------
    engine : {"pybullet", "mujoco"}, default="pybullet"
        Who integrates the equations of motion.
    control_rate : float, default=60.0
        Commands a second (Hz), from 10 to 1000.
    substeps : int, default=4
        Of the physics, in a time step of the controller: 240 Hz; from 1 to 100.
    duration : float, default=1.0
        Of the movement (s), from 0.1 to 20.
    settling : float, default=0.1
        Then the last joint angles are held so long (s), from 0 to 5.
    gravity : float, default=0.0
        Along -y (m/s²), from 0 to 30; the controller knows of it. Zero: the arm moves
        in a horizontal plane.

    Raises
    ------
    ValueError
        If the engine is unknown, or a number is beyond its bounds.

    Examples
    --------
    >>> Physics().n_steps
    66
    """

    engine: str = "pybullet"
    control_rate: float = 60.0
    substeps: int = 4
    duration: float = 1.0
    settling: float = 0.1
    gravity: float = 0.0

    def __post_init__(self) -> None:
        """Refuse an engine that is none, and steps that make no movement."""
        if self.engine not in ENGINES:
            raise ValueError(
                f"engine={self.engine!r}; wanted {' or '.join(map(repr, ENGINES))}"
            )
        check_number("control_rate", self.control_rate, 10.0, 1000.0)
        check_whole("substeps", self.substeps, 1, 100)
        check_number("duration", self.duration, 0.1, 20.0)
        check_number("settling", self.settling, 0.0, 5.0)
        check_number("gravity", self.gravity, 0.0, 30.0)

    @property
    def time_step(self) -> float:
        """Time between two commands, and between two rows of a rollout (s)."""
        return 1 / self.control_rate

    @property
    def n_moving(self) -> int:
        """Time steps of the movement."""
        return round(self.duration * self.control_rate)

    @property
    def n_steps(self) -> int:
        """Time steps of the movement and the settling."""
        return self.n_moving + round(self.settling * self.control_rate)
