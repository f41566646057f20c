"""The world: an arm's dimensions, its home pose, the goal circle, the obstacles.

Lengths are in metres, masses in kilograms, angles in radians unless the name ends
in ``_deg``. Every constant is an assumption of ours, since the paper gives none:
the book's ledger says why each is what it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import LARGEST, to_floats
from msc.robot._kinematics import forward_kinematics

LINK_RADIUS = 0.02  # m; half the thickness of a link

_LINKS = (0.40, 0.35, 0.25)
_SMALLEST = 1e-6  # m; of a radius
_BOUNDS = {"link_lengths": (0.05, 10.0), "link_masses": (0.01, 1000.0)}


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


def home_pose(
    link_lengths: tuple[float, float, float], reach: float, heading: float
) -> tuple[float, float, float]:
    """Find the pose (q, b, b), b > 0, that puts the end effector at a given place.

    Examples
    --------
    >>> [round(angle, 3) for angle in home_pose((0.40, 0.35, 0.25), 0.85, 0.0)]
    [-0.592, 0.707, 0.707]
    """
    first, second, third = link_lengths
    quadratic = 4 * first * third  # reach² is a quadratic in cos b
    linear = 2 * second * (first + third)
    constant = (first - third) ** 2 + second**2 - reach**2
    root = math.sqrt(linear**2 - 4 * quadratic * constant)
    bend = math.acos((root - linear) / (2 * quadratic))
    tip = first + second * np.exp(1j * bend) + third * np.exp(2j * bend)
    return (heading - float(np.angle(tip)), bend, bend)


@dataclass(frozen=True)
class Workspace:
    """A planar three-link arm, a circle of goals around it, and obstacles.

    Parameters
    ----------
    name : str
        What tables and captions call it.
    link_lengths, link_masses : tuple of float
        Lengths (m), from 0.05 to 10, and masses (kg), from 0.01 to 1000, of the links,
        from the base outwards.
    home : tuple of float
        Joint angles at the start of every movement (rad). The default puts the end
        effector 0.85 m from the base towards 225°: outside the range of the goal
        circle's coordinates in *both* dimensions, so that goal minus start (Eq. 5)
        never vanishes.
    goal_radius : float
        Radius of the circle of goals around the base (m).
    cut_deg : float
        World angle at which the task angle is 0° (degrees): where reaching round
        either side costs the same without obstacles, measured by `msc survey cut`.
    circles : tuple of Circle
        The obstacles.

    Raises
    ------
    ValueError
        If the goal circle is out of the arm's reach, or passes through an obstacle; if
        there are not three links of length and mass within bounds; if an angle or an
        obstacle is not of finite real numbers; if an obstacle has no positive radius,
        or stands where the arm is at home.

    Examples
    --------
    >>> free = Workspace.free()
    >>> bool(np.allclose(free.target(0), free.target(360)))
    True
    """

    name: str = "free"
    link_lengths: tuple[float, float, float] = _LINKS
    link_masses: tuple[float, float, float] = (1.0, 0.8, 0.5)
    home: tuple[float, float, float] = home_pose(_LINKS, 0.85, math.radians(225))
    goal_radius: float = 0.45
    cut_deg: float = 69.5
    circles: tuple[Circle, ...] = ()

    def __post_init__(self) -> None:
        """Refuse an arm that cannot be, and goals that no movement could reach."""
        self._check_numbers()
        farthest = sum(self.link_lengths)
        nearest = max(0.0, 2 * max(self.link_lengths) - farthest)
        if not max(nearest, _SMALLEST) < self.goal_radius < farthest:
            raise ValueError(
                f"goal_radius={self.goal_radius} m is out of the arm's reach; wanted "
                f"a radius between {nearest:g} m and {farthest:g} m, over a micrometre"
            )
        at_home = forward_kinematics(self.home, self.link_lengths)
        object.__setattr__(self, "circles", tuple(Circle(*c) for c in self.circles))
        for circle in self.circles:
            if not _SMALLEST < circle.radius < clearance(at_home, circle):
                raise ValueError(
                    f"circles: the obstacle {tuple(circle)} has no positive radius or "
                    "stands in the arm's home pose; wanted one clear of it, with a "
                    "radius over a micrometre"
                )
            gap = abs(math.hypot(circle.x, circle.y) - self.goal_radius)
            if gap < circle.radius:
                raise ValueError(
                    f"circles: the goals pass through the obstacle {tuple(circle)} and "
                    "cannot be reached; wanted obstacles clear of the goal circle"
                )

    def _check_numbers(self) -> None:
        """Refuse what is no number, or beyond sense, or too many or few of them."""
        for name, (lowest, highest) in _BOUNDS.items():
            given = to_floats(name, getattr(self, name))
            is_bounded = (lowest <= given) & (given <= highest)
            if given.shape != (len(_LINKS),) or not is_bounded.all():
                raise ValueError(
                    f"{name}={getattr(self, name)}; wanted {len(_LINKS)} positive "
                    f"numbers from {lowest:g} to {highest:g}"
                )
        for name in (*_BOUNDS, "home", "goal_radius", "cut_deg", "circles"):
            given = getattr(self, name)
            sizes = np.abs(to_floats(name, given))
            if np.asarray(given).dtype.kind not in "iuf":  # text, say
                raise ValueError(f"{name}={given!r}; wanted real numbers")
            if name != "goal_radius" and not (sizes <= LARGEST).all():
                raise ValueError(
                    f"{name}={given}; wanted numbers of at most {LARGEST:g}"
                )
        if np.shape(self.home) != (len(_LINKS),) or np.ndim(self.cut_deg):
            raise ValueError(
                f"home={self.home}, cut_deg={self.cut_deg}; wanted 3 angles and one"
            )
        if np.ndim(self.goal_radius):
            raise ValueError(f"goal_radius={self.goal_radius!r}; wanted one number")
        if np.shape(self.circles) not in ((0,), (np.size(self.circles) // 3, 3)):
            raise ValueError(
                f"circles={self.circles!r}; wanted x, y and radius of each obstacle"
            )

    @classmethod
    def free(cls) -> Workspace:
        """Return the workspace without obstacles (Experiment 1 of the paper).

        Returns
        -------
        Workspace
            The workspace.
        """
        return cls()

    @classmethod
    def obstacles(cls) -> Workspace:
        """Return the workspace with obstacles (Experiment 2 of the paper).

        Returns
        -------
        Workspace
            The workspace.

        Notes
        -----
        The layout is `random_circles` of the first seed that fulfils the premise of
        Experiment 2, found by `msc survey layout` before any regression was fitted.
        """
        return cls(name="obstacles", circles=random_circles(LAYOUT_SEED))

    @classmethod
    def named(cls, name: str) -> Workspace:
        """Return the ready workspace of that name.

        Parameters
        ----------
        name : {"free", "obstacles"}
            Which.

        Returns
        -------
        Workspace
            The workspace.

        Raises
        ------
        ValueError
            If there is none.
        """
        if name not in ("free", "obstacles"):
            raise ValueError(
                f"workspace={name!r} is unknown; wanted 'free' or 'obstacles'"
            )
        return cls.free() if name == "free" else cls.obstacles()

    def target(self, task_deg: ArrayLike) -> NDArray[np.float64]:
        """Place the goal of a task.

        Parameters
        ----------
        task_deg : float or array_like
            Task angles, counted from the cut (degrees); taken modulo 360.

        Returns
        -------
        ndarray of shape (..., 2)
            Coordinates of the goals (m).

        Raises
        ------
        ValueError
            If an angle is not a finite real number, or beyond a thousand million.
        """
        angle = to_floats("task_deg", task_deg)
        if not np.isfinite(angle).all():
            raise ValueError(f"task_deg={angle.tolist()} is not finite; wanted degrees")
        largest = np.abs(angle).max(initial=0.0)
        if largest > LARGEST:
            raise ValueError(
                f"task_deg has an angle of {largest:g} degrees; wanted at most "
                f"{LARGEST:g}, or its place in the turn is lost"
            )
        angle = np.deg2rad(np.mod(angle, 360.0) + self.cut_deg)
        return self.goal_radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


LAYOUT_SEED = 1  # see data/results/layout.json


def random_circles(seed: int) -> tuple[Circle, ...]:
    """Draw a layout of three or four obstacles.

    Centres lie 0.55 to 0.80 m from the base, radii are 0.04 to 0.07 m; every obstacle
    stays 3 cm clear of the arm in its home pose and of the other obstacles.

    Parameters
    ----------
    seed : int
        Seed of the draw.

    Returns
    -------
    tuple of Circle
        The layout.

    Examples
    --------
    >>> random_circles(0) == random_circles(0)
    True
    """
    rng = np.random.default_rng(seed)
    home = forward_kinematics(Workspace.home, Workspace.link_lengths)
    n_circles = int(rng.integers(3, 5))
    circles: list[Circle] = []
    while len(circles) < n_circles:
        distance, angle = rng.uniform(0.55, 0.80), rng.uniform(0, 2 * math.pi)
        candidate = Circle(
            x=distance * math.cos(angle),
            y=distance * math.sin(angle),
            radius=rng.uniform(0.04, 0.07),
        )
        others = (
            math.hypot(candidate.x - other.x, candidate.y - other.y) - other.radius
            for other in circles
        )
        gap = min([float(clearance(home, candidate)), *others]) - candidate.radius
        if gap > 0.03:
            circles.append(candidate)
    return tuple(circles)
