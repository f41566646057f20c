"""The world: an arm's dimensions, its home pose, the goal circle, the obstacles.

Lengths are in metres, masses in kilograms, angles in radians unless the name ends
in ``_deg``. Every constant is an assumption of ours, since the paper gives none:
the book's ledger says why each is what it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import LARGEST, check_number, to_floats
from msc.robot._control import ControllerGains
from msc.robot._dmp import DMP
from msc.robot._kinematics import forward_kinematics
from msc.robot._obstacles import Circle, clearance
from msc.robot._physics import Physics
from msc.robot._tasks import TASK_NUMBERS, CostWeights, TaskRange

if TYPE_CHECKING:
    import pandas as pd

_LINKS = (0.40, 0.35, 0.25)
_SMALLEST = 1e-6  # m; of a radius
_BOUNDS = {"link_lengths": (0.05, 10.0), "link_masses": (0.01, 1000.0)}


def home_pose(
    link_lengths: tuple[float, float, float], reach: float, heading: float
) -> tuple[float, float, float]:
    """Find the pose (q, b, b), b > 0, that puts the end effector at a given place.

    Parameters
    ----------
    link_lengths : tuple of float
        Lengths of the links (m).
    reach, heading : float
        Distance from the base (m) and direction (rad) of the end effector.

    Returns
    -------
    tuple of float
        Joint angles (rad).

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
    """A world: a planar three-link arm, goals around it, obstacles, and what counts.

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
    further : tuple of TaskRange
        What tasks have besides their angle, at most one of each kind; by default
        nothing. Goals at other distances than `goal_radius` lie in an annulus.
    cost : CostWeights
        What a search minimizes.
    dmp : DMP
        What a policy means.
    controller : ControllerGains
        Gains of the PID controller.
    physics : Physics
        Engine and steps.

    Raises
    ------
    ValueError
        If goals are out of the arm's reach, or pass through an obstacle; if there are
        not three links of length and mass within bounds; if an angle or an obstacle is
        not of finite real numbers; if an obstacle has no positive radius, stands where
        the arm is at home, or overlaps another; if a further task number is unknown or
        has no range.

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
    further: tuple[TaskRange, ...] = ()
    cost: CostWeights = field(default_factory=CostWeights)
    dmp: DMP = field(default_factory=DMP)
    controller: ControllerGains = field(default_factory=ControllerGains)
    physics: Physics = field(default_factory=Physics)

    def __post_init__(self) -> None:
        """Refuse an arm that cannot be, and goals that no movement could reach."""
        self._check_numbers()
        self._check_further()
        ranges = {one.name: (one.low, one.high) for one in self.further}
        farthest = sum(self.link_lengths)
        nearest = max(0.0, 2 * max(self.link_lengths) - farthest)
        goals = ranges.get("radius_m", (self.goal_radius,) * 2)
        name = "radius_m" if "radius_m" in ranges else "goal_radius"
        for radius in (self.goal_radius, *goals):
            if not max(nearest, _SMALLEST) < radius < farthest:
                raise ValueError(
                    f"{name}={radius} m is out of the arm's reach; wanted "
                    f"a radius between {nearest:g} m and {farthest:g} m, over a "
                    "micrometre"
                )
        object.__setattr__(self, "circles", tuple(Circle(*c) for c in self.circles))
        turns = ranges.get("turn_deg", (0.0, 0.0))
        homes = np.tile(self.home, (_n_places(*np.deg2rad(turns) * farthest), 1))
        homes[:, 0] += np.deg2rad(np.linspace(*turns, len(homes)))
        at_home = forward_kinematics(homes, self.link_lengths)
        for circles in self._circles_anywhere(*ranges.get("height_m", (0.0, 0.0))):
            self._check_circles(circles, goals, at_home)

    def _circles_anywhere(self, low: float, high: float) -> list[tuple[Circle, ...]]:
        """Return the obstacles, the first one everywhere along its track."""
        if low == high:
            return [self.circles]
        if not self.circles:
            raise ValueError("height_m: no obstacle to move; wanted one at least")
        (x, y, radius), *others = self.circles
        along = np.linspace(low, high, _n_places(low, high)).tolist()
        return [(Circle(x, y + height, radius), *others) for height in along]

    def _check_circles(
        self,
        circles: tuple[Circle, ...],
        goals: tuple[float, ...],
        at_home: NDArray[np.float64],
    ) -> None:
        """Refuse obstacles where the arm starts, where goals are, or in one another."""
        for number, circle in enumerate(circles):
            if not _SMALLEST < circle.radius < clearance(at_home, circle).min():
                raise ValueError(
                    f"circles: the obstacle {tuple(circle)} has no positive radius "
                    "or stands in the arm's home pose; wanted one clear of it, "
                    "with a radius over a micrometre"
                )
            away = math.hypot(circle.x, circle.y)
            gap = max(goals[0] - away, away - goals[-1])
            if gap < circle.radius:
                raise ValueError(
                    f"circles: the goals pass through the obstacle {tuple(circle)} and "
                    "cannot be reached; wanted obstacles clear of the goal circle"
                )
            for other in circles[:number]:
                between = math.hypot(circle.x - other.x, circle.y - other.y)
                if between < circle.radius + other.radius:
                    raise ValueError(
                        f"circles: the obstacles {tuple(other)} and {tuple(circle)} "
                        "overlap; wanted them apart"
                    )

    def _check_further(self) -> None:
        """Refuse task numbers that are unknown, or have no range."""
        object.__setattr__(self, "further", tuple(TaskRange(*o) for o in self.further))
        for number, (name, low, high) in enumerate(self.further):
            if name not in TASK_NUMBERS:
                raise ValueError(
                    f"further: {name!r} is unknown; wanted one of "
                    f"{', '.join(TASK_NUMBERS)}"
                )
            if name in [other.name for other in self.further[:number]]:
                raise ValueError(f"further: {name} is given twice; wanted it once")
            for end in (low, high):
                check_number(name, end, -LARGEST, LARGEST)
            if not low < high:
                raise ValueError(
                    f"{name}={[low, high]}; wanted two numbers, the lower one first"
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

    @property
    def task_names(self) -> tuple[str, ...]:
        """Names of the numbers of a task, the angle's first."""
        return ("task_deg", *(one.name for one in self.further))

    @property
    def task_units(self) -> NDArray[np.float64]:
        """By what to divide tasks in SI units to have a metric, of shape (n_numbers,).

        An angle of a radian counts as much as a goal's way of `goal_radius`, which is
        what it makes of it.
        """
        lengths = [name.endswith("_m") for name in self.task_names]
        return np.where(lengths, self.goal_radius, 1.0)

    @property
    def task_bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lowest and highest numbers of a task: the angle from 0 to 360 degrees."""
        low = (0.0, *(one.low for one in self.further))
        return low, (360.0, *(one.high for one in self.further))

    def tasks_in(self, table: pd.DataFrame) -> NDArray[np.float64]:
        """Take the tasks out of a table, as they are given to a world.

        Parameters
        ----------
        table : DataFrame
            With a column of each of `task_names`.

        Returns
        -------
        ndarray of shape (n_tasks,) or (n_tasks, n_numbers)
            Task angles (degrees); where tasks have further numbers, rows of them.

        Raises
        ------
        ValueError
            If a column is missing.
        """
        if missing := [name for name in self.task_names if name not in table]:
            raise ValueError(
                f"workspace={self.name!r}: the table lacks {', '.join(missing)}; "
                "wanted one of this world"
            )
        rows = table[list(self.task_names)].to_numpy()
        return np.asarray(rows if self.further else rows[:, 0])

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

    def at(self, task_deg: ArrayLike) -> Workspace:
        """Return the workspace of one task: its goals, home and obstacles fixed.

        Parameters
        ----------
        task_deg : float or array_like of shape (n_numbers,)
            A task, as for `target`.

        Returns
        -------
        Workspace
            One whose tasks have but their angle: itself, if it is such.

        Examples
        --------
        >>> world = Workspace(further=(TaskRange("radius_m", 0.3, 0.45),))
        >>> world.at([90.0, 0.4]).goal_radius
        0.4
        """
        if not self.further:
            return self
        home, circles = self.home_of(task_deg), self.circles_of(task_deg)
        radius = self._numbers(task_deg).get("radius_m", self.goal_radius)
        return replace(
            self,
            further=(),
            goal_radius=float(radius),
            home=tuple(home.tolist()),
            circles=tuple(Circle(*row) for row in circles.tolist()),
        )

    def target(self, task_deg: ArrayLike) -> NDArray[np.float64]:
        """Place the goal of a task.

        Parameters
        ----------
        task_deg : float or array_like
            Task angles, counted from the cut (degrees); taken modulo 360. Where tasks
            have further numbers, rows of them, of shape (..., n_numbers).

        Returns
        -------
        ndarray of shape (..., 2)
            Coordinates of the goals (m).

        Raises
        ------
        ValueError
            If an angle is not a finite real number, or beyond a thousand million; if
            rows have not as many numbers as tasks do.
        """
        numbers = self._numbers(task_deg)
        angle = np.deg2rad(np.mod(numbers["task_deg"], 360.0) + self.cut_deg)
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        if (radius := numbers.get("radius_m")) is not None:
            return np.asarray(radius[..., None] * unit)
        return self.goal_radius * unit

    def home_of(self, task_deg: ArrayLike) -> NDArray[np.float64]:
        """Return the joint angles in which the movement of a task begins.

        Parameters
        ----------
        task_deg : float or array_like
            Tasks, as for `target`.

        Returns
        -------
        ndarray of shape (..., 3)
            Joint angles (rad).
        """
        numbers = self._numbers(task_deg)
        homes = np.broadcast_to(self.home, (*numbers["task_deg"].shape, 3))
        if (turn := numbers.get("turn_deg")) is not None:
            homes = homes.copy()
            homes[..., 0] += np.deg2rad(turn)
        return homes

    def circles_of(self, task_deg: ArrayLike) -> NDArray[np.float64]:
        """Return where the obstacles of a task are.

        Parameters
        ----------
        task_deg : float or array_like
            Tasks, as for `target`.

        Returns
        -------
        ndarray of shape (..., n_circles, 3)
            Rows of x, y and radius (m).
        """
        numbers = self._numbers(task_deg)
        circles = np.reshape(np.array(self.circles), (-1, 3))
        circles = np.broadcast_to(circles, (*numbers["task_deg"].shape, *circles.shape))
        if (height := numbers.get("height_m")) is not None:
            circles = circles.copy()
            circles[..., 0, 1] += height
        return circles

    def _numbers(self, tasks: ArrayLike) -> Mapping[str, Any]:
        """Take tasks apart into their numbers, by name."""
        values = to_floats("task_deg", tasks)
        if not np.isfinite(values).all():
            raise ValueError(
                f"task_deg={values.tolist()} is not finite; wanted degrees"
            )
        largest = np.abs(values).max(initial=0.0)
        if largest > LARGEST:
            raise ValueError(
                f"task_deg has an angle of {largest:g} degrees; wanted at most "
                f"{LARGEST:g}, or its place in the turn is lost"
            )
        if not self.further:
            return {"task_deg": values}
        if values.ndim == 0 or values.shape[-1] != len(self.task_names):
            raise ValueError(
                f"task_deg has shape {values.shape}; wanted rows of "
                f"{len(self.task_names)} numbers: {', '.join(self.task_names)}"
            )
        return dict(zip(self.task_names, np.moveaxis(values, -1, 0), strict=True))


def _n_places(low: float, high: float) -> int:
    """Return at how many places along a way (m) to look: 5 mm apart, 1000 at most."""
    return min(1000, 1 + math.ceil((high - low) / 0.005))


LAYOUT_SEED = 1  # see data/results/layout.json


def random_circles(
    seed: int | Sequence[int], least: int = 3, most: int = 4
) -> tuple[Circle, ...]:
    """Draw a layout of a few obstacles, by default three or four.

    Centres lie 0.55 to 0.80 m from the base, radii are 0.04 to 0.07 m; every obstacle
    stays 3 cm clear of the arm in its home pose and of the other obstacles.

    Parameters
    ----------
    seed : int or sequence of int
        Seed of the draw.
    least, most : int, default=3, 4
        How many, at least and at most.

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
    n_circles = int(rng.integers(least, most + 1))
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
