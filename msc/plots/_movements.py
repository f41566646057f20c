"""Stroboscopic pictures: several poses of one movement in one panel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc

from msc.plots._executed import Movements
from msc.plots._style import SMALL, TRIO, styled
from msc.search import cost

SIDES = TRIO[:2]  # of a break: before, after
TOUCHED = TRIO[1]


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
        draw_movement(axis, movements, index, n_poses=n_poses)
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
            draw_movement(axis, movements, index, colour=colour, n_poses=n_poses)
            axis.set_title(_caption(movements, index), pad=3, fontsize=SMALL)
    return figure


def draw_movement(
    axis: Axes,
    movements: Movements,
    index: int,
    *,
    colour: str = SIDES[0],
    n_poses: int = 6,
) -> None:
    """Draw one movement into a panel.

    Parameters
    ----------
    axis : Axes
        The panel.
    movements : Movements
        The movements.
    index : int
        Which task.
    colour : str, optional
        Of the way of the end effector; by default blue.
    n_poses : int, default=6
        Poses, evenly spaced in time.
    """
    world, path = movements.workspace, movements.rollouts[index].path
    axis.add_patch(Disc((0, 0), world.goal_radius, fill=False, color="red", lw=0.8))
    touched = movements.touched(index)
    for circle in world.circles:
        rim: Any = {"ec": TOUCHED, "lw": 2} if circle in touched else {"ec": "black"}
        axis.add_patch(Disc((circle.x, circle.y), circle.radius, fc="black", **rim))
    steps = np.linspace(0, len(path) - 1, n_poses).round().astype(int)
    greys = np.linspace(0.86, 0.30, n_poses)
    for order, (step, grey) in enumerate(zip(steps, greys, strict=True)):
        look: Any = {"color": str(grey), "zorder": 2 + order / n_poses}
        arm = movements.places[index, step]
        axis.plot(*arm.T, lw=2.8, solid_capstyle="round", **look)
        axis.plot(*arm[:-1].T, "o", mfc="white", ms=2.8, mew=0.8, **look)
    axis.plot(*path.T, color=colour, lw=1.8, zorder=4)
    axis.plot(*path[steps].T, "o", color=colour, ms=3.2, zorder=4)
    goal = world.target(movements.degrees[index])
    axis.plot(*goal, "o", mfc="none", mec="red", ms=8, mew=1.6, zorder=5)
    low, high = movements.bounds
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axis.set_axis_off()


def _caption(movements: Movements, index: int) -> str:
    """Say what task this is, what it costs, and whether an obstacle was touched."""
    rollout = movements.rollouts[index]
    contact = "contact" if rollout.touched else "no contact"
    return f"{movements.degrees[index]:g}°\ncost {cost(rollout):.3f}, {contact}"
