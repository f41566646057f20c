"""The movements of a table's policies, how far neighbours are apart, and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.data import find_jumps, load_dataset
from msc.plots._style import SMALL, TRIO, styled
from msc.plots._world import bounds_of, draw_links, draw_world, place_arm
from msc.robot import Arm, Circle, Workspace, clearance
from msc.search import cost
from msc.study import take_evenly

CONTACT = 0.001  # m; an arm that came this close to an obstacle touched it
SIDES = TRIO[:2]  # of a break: before, after


class Movements:
    """What the arm does for each task of a table.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its table.

    Attributes
    ----------
    workspace : Workspace
        Where the movements take place.
    degrees : ndarray of shape (n_tasks,)
        Task angles, ascending (degrees).
    rollouts : list of Rollout
        What the policy of each task does.
    jumps : ndarray of int
        Indices of tasks after which the policies jump, the circle cut open.

    Examples
    --------
    >>> free = Movements("free")
    >>> len(free.rollouts) == len(free.degrees) == len(free.gaps)
    True
    """

    def __init__(self, name: str) -> None:
        self.workspace = Workspace.named(name)
        dataset = load_dataset(name)
        self._tasks, policies, _ = dataset
        self.degrees = dataset.task_deg
        self.jumps = find_jumps(self._tasks, policies)
        with Arm(self.workspace) as arm:
            self.rollouts = arm.execute_many(policies, self.degrees.tolist())

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """Base, joints and end effector (m), of shape (n_tasks, n_steps + 1, 4, 2)."""
        return place_arm(self.rollouts, self.workspace)

    @property
    def gaps(self) -> NDArray[np.float64]:
        """How far each movement is from the next task's (m), of shape (n_tasks,).

        The farthest that any joint, or the end effector, is from where it is in the
        other movement at the same time. The last task's next is the first.
        """
        apart = np.roll(self.places, -1, axis=0) - self.places
        return np.asarray(np.linalg.norm(apart, axis=-1).max(axis=(1, 2)))

    @property
    def breaks(self) -> list[tuple[int, int]]:
        """Indices of the tasks on both sides of each jump and, last, of the cut."""
        last = len(self.degrees) - 1
        return [(int(k), int(k) + 1) for k in self.jumps] + [(last, 0)]

    @property
    def unbroken(self) -> NDArray[np.float64]:
        """The `gaps` elsewhere (m): without those of the jumps and of the cut."""
        return np.delete(self.gaps, [*self.jumps, len(self.degrees) - 1])

    @property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower and upper bounds of all that moves or stands here, x and y (m)."""
        low, high = bounds_of(self.workspace.circles, self.places)
        return low - 0.03, high + 0.03

    def evenly(self, n_tasks: int) -> list[int]:
        """Pick tasks evenly spaced over the circle.

        Parameters
        ----------
        n_tasks : int
            How many.

        Returns
        -------
        list of int
            Their indices.

        Raises
        ------
        ValueError
            If there are fewer.
        """
        return [int(index) for index in take_evenly(self._tasks, n_tasks)]

    def touched(self, index: int) -> list[Circle]:
        """Find the obstacles that the arm touched.

        Parameters
        ----------
        index : int
            Which task.

        Returns
        -------
        list of Circle
            The obstacles.
        """
        return [
            circle
            for circle in self.workspace.circles
            if self.rollouts[index].touched
            and clearance(self.places[index], circle).min() < circle.radius + CONTACT
        ]

    def compare(self) -> pd.DataFrame:
        """Compare the movements on both sides of each jump and, last, of the cut.

        Returns
        -------
        DataFrame
            One row a break: the largest distance between the two movements (cm), see
            `gaps`; the cost before and after; whether the arm touched an obstacle; and
            the larger of the distances that were left to the goals (cm).
        """
        rows = {}
        for pair in self.breaks:
            before, after = (self.rollouts[index] for index in pair)
            rows[" | ".join(f"{self.degrees[index]:g}°" for index in pair)] = {
                "apart (cm)": 100 * self.gaps[pair[0]],
                "cost before": cost(before),
                "cost after": cost(after),
                "touched before": before.touched,
                "touched after": after.touched,
                "missed by (cm)": 100 * max(before.error, after.error),
            }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("tasks")


@styled
def plot_tasks(
    movements: Movements, indices: Sequence[int], *, n_poses: int = 6
) -> Figure:
    """Draw movements in a grid, four in a row.

    Parameters
    ----------
    movements : Movements
        The movements.
    indices : sequence of int
        Which tasks.
    n_poses : int, default=6
        Poses in a panel, evenly spaced in time.

    Returns
    -------
    Figure
        One panel a task: poses from pale to dark, the way of the end effector blue,
        the goal a red ring, obstacles black, those touched with an orange rim.
    """
    n_rows = -(-len(indices) // 4)
    figure, axes = plt.subplots(n_rows, 4, figsize=(7.4, 2.05 * n_rows), squeeze=False)
    for axis in axes.flat[len(indices) :]:
        axis.set_axis_off()
    for axis, index in zip(axes.flat, indices, strict=False):
        _draw_movement(axis, movements, index, n_poses=n_poses)
        axis.set_title(f"{movements.degrees[index]:g}°", pad=2)
    return figure


@styled
def plot_breaks(
    movements: Movements, breaks: Sequence[tuple[int, int]], *, n_poses: int = 6
) -> Figure:
    """Draw the movements on both sides of breaks next to each other.

    Parameters
    ----------
    movements : Movements
        The movements.
    breaks : sequence of tuple of int
        Indices of the two tasks of each, see `Movements.breaks`.
    n_poses : int, default=6
        Poses in a panel, evenly spaced in time.

    Returns
    -------
    Figure
        Two panels a break, drawn as by `plot_tasks`: the way of the end effector blue
        before and orange after it, and dotted in the other's panel. One break in a
        row, or two if there are more than five.
    """
    n_pairs = 1 if len(breaks) <= 5 else 2
    n_rows, width = -(-len(breaks) // n_pairs), 3.1 if n_pairs == 1 else 1.85
    figure, axes = plt.subplots(
        n_rows,
        2 * n_pairs,
        figsize=(2 * n_pairs * width, (width + 0.1) * n_rows),
        squeeze=False,
    )
    for axis in axes.flat[2 * len(breaks) :]:
        axis.set_axis_off()
    for panels, pair in zip(axes.reshape(-1, 2), breaks, strict=False):
        sides = list(zip(panels, pair, SIDES, strict=True))
        for axis, index, colour in sides:
            for _, other, its_colour in sides:
                if other != index:
                    way = movements.rollouts[other].path
                    axis.plot(*way.T, ":", color=its_colour, lw=1.3)
            _draw_movement(axis, movements, index, colour=colour, n_poses=n_poses)
            axis.set_title(_caption(movements, index), pad=3, fontsize=SMALL)
    return figure


def _draw_movement(
    axis: Axes,
    movements: Movements,
    index: int,
    *,
    colour: str = SIDES[0],
    n_poses: int,
) -> None:
    """Draw poses of one movement, evenly spaced in time, and the end effector's way."""
    world, path = movements.workspace, movements.rollouts[index].path
    steps = np.linspace(0, len(path) - 1, n_poses).round().astype(int)
    greys = np.linspace(0.86, 0.30, n_poses)
    for order, (step, grey) in enumerate(zip(steps, greys, strict=True)):
        look: Any = {"color": str(grey), "zorder": 2 + order / n_poses}
        joints: Any = {"mfc": "white", "mec": None, "ms": 2.8, "mew": 0.8, **look}
        draw_links(axis, movements.places[index, step], {"lw": 2.8, **look}, **joints)
    axis.plot(*path.T, color=colour, lw=1.8, zorder=4)
    axis.plot(*path[steps].T, "o", color=colour, ms=3.2, zorder=4)
    task_deg, touched = movements.degrees[index], movements.touched(index)
    draw_world(axis, world, task_deg, view="movement", touched=touched)
    low, high = movements.bounds
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _caption(movements: Movements, index: int) -> str:
    """Say what task this is, what it costs, and whether an obstacle was touched."""
    rollout = movements.rollouts[index]
    contact = "contact" if rollout.touched else "no contact"
    return f"{movements.degrees[index]:g}°\ncost {cost(rollout):.3f}, {contact}"
