"""What tasks may have besides their angle, and what is paid for a movement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from msc._checks import check_number

TASK_NUMBERS = {
    "radius_m": "distance of the goal from the base",
    "height_m": "how far the first obstacle has moved along y",
    "turn_deg": "how far the home pose is turned about the base",
}
"""What a task may have besides its angle."""


class TaskRange(NamedTuple):
    """A number that tasks have besides their angle, and its range.

    Attributes
    ----------
    name : {"radius_m", "height_m", "turn_deg"}
        Distance of the goal from the base (m); how far the first obstacle has moved
        along y (m); how far the home pose is turned about the base (degrees).
    low, high : float
        Its range.
    """

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class CostWeights:
    """What is paid for what a movement does.

    Parameters
    ----------
    error : float, default=100.0
        For the squared final distance (1/m²).
    energy : float, default=0.005
        For the squared joint velocity, summed and integrated (s/rad²). One centimetre
        weighs as much as 2 rad²/s.
    contact : float, default=0.0
        For the impulse of contacts (1/(N s)).
    length : float, default=0.0
        For the length of the joints' path (1/rad).

    Raises
    ------
    ValueError
        If one is no number, negative, or above 1e6.
    """

    error: float = 100.0
    energy: float = 0.005
    contact: float = 0.0
    length: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no price."""
        for name in ("error", "energy", "contact", "length"):
            check_number(name, getattr(self, name), 0.0, 1e6)
