"""How a search converges: what its generations do, and what that costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc
from numpy.typing import NDArray

from msc.plots._style import GOAL, TRIO, styled
from msc.robot import Workspace, forward_kinematics
from msc.search import SearchTrace

STARTS = (TRIO[1], TRIO[0], TRIO[2], "0.3", "0.5", "0.7")


@styled
def plot_generations(
    workspace: Workspace,
    task_deg: float,
    recordings: Sequence[SearchTrace],
    shown: Sequence[int] = (1, 10, 20),
) -> Figure:
    """Draw what generations do, and what their policies cost.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    recordings : sequence of SearchTrace
        The starts of one search.
    shown : sequence of int, default=(1, 10, 20)
        Generations of the first start, counted from 1.

    Returns
    -------
    Figure
        Top the ways of the end effector in generations of the first start, the cheapest
        dark, and what every start found; bottom their costs over the rollouts spent: as
        dots all policies, as lines the cheapest so far, dashed the generations above.
    """
    run = recordings[0]
    numbers = [min(number, len(run.costs)) for number in shown]
    figure = plt.figure(figsize=(7.4, 4.5))
    grid = figure.add_gridspec(2, len(numbers) + 1, height_ratios=(1, 1.05))
    costs = figure.add_subplot(grid[1, :])
    for column, number in enumerate(numbers):
        axis = figure.add_subplot(grid[0, column])
        draw_generation(axis, workspace, task_deg, run, number - 1)
        axis.set_title(f"generation {number}", fontsize=9)
        costs.axvline(
            run.evaluations[number - 1], color="0.5", lw=0.8, ls="--", zorder=0
        )
    found = figure.add_subplot(grid[0, len(numbers)])
    _draw_found(found, workspace, task_deg, recordings)
    found.set_title("what every start found", fontsize=9)
    for recording, colour in zip(recordings, STARTS, strict=False):
        _draw_costs(costs, recording, colour)
    costs.set(
        yscale="log",
        xlabel="rollouts of the start",
        ylabel="cost",
        xlim=(0, None),
    )
    costs.legend(loc="upper right")
    return figure


def draw_generation(
    axis: Axes, workspace: Workspace, task_deg: float, run: SearchTrace, generation: int
) -> None:
    """Draw the ways of a generation's policies, the cheapest one dark.

    Parameters
    ----------
    axis : Axes
        The panel.
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    run : SearchTrace
        The start.
    generation : int
        The generation's number, from 0 on.
    """
    _draw_world(
        axis,
        workspace,
        task_deg,
        forward_kinematics(run.joints, workspace.link_lengths),
    )
    places = forward_kinematics(run.joints[generation], workspace.link_lengths)
    best = run.costs[generation].argmin()
    axis.plot(*places[best, -1].T, color="0.65", lw=4, solid_capstyle="round")
    for place in places:
        axis.plot(*place[:, -1].T, color=STARTS[0], lw=1.0)
    axis.plot(*places[best, :, -1].T, color="black", lw=1.6)


def _draw_found(
    axis: Axes, workspace: Workspace, task_deg: float, recordings: Sequence[SearchTrace]
) -> None:
    """Draw the cheapest movement of every start, and where the arm ends."""
    lengths = workspace.link_lengths
    _draw_world(
        axis, workspace, task_deg, forward_kinematics(recordings[0].joints, lengths)
    )
    widths = np.linspace(4.5, 1.2, len(recordings))  # those below remain visible
    for recording, colour, width in zip(recordings, STARTS, widths, strict=False):
        places = forward_kinematics(
            recording.joints[-1, recording.costs[-1].argmin()], lengths
        )
        axis.plot(*places[-1].T, color=colour, lw=4, alpha=0.4)
        axis.plot(*places[:, -1].T, color=colour, lw=width)


def _draw_world(
    axis: Axes, workspace: Workspace, task_deg: float, places: NDArray[np.float64]
) -> None:
    """Draw goal circle, goal, obstacles and the arm at home, with room for places."""
    circle: Any = {"fill": False, "color": GOAL, "lw": 0.8}
    axis.add_patch(Disc((0, 0), workspace.goal_radius, **circle))
    for x, y, radius in workspace.circles:
        axis.add_patch(Disc((x, y), radius, color="black"))
    axis.plot(
        *forward_kinematics(workspace.home, workspace.link_lengths).T,
        color="0.85",
        lw=4,
    )
    goal = workspace.target(task_deg)
    axis.plot(*goal, "o", mfc="none", mec=GOAL, ms=8, mew=1.6, zorder=5)
    across, up = square_around(workspace, places)
    axis.set(xlim=across, ylim=up, aspect="equal")
    axis.set_axis_off()


def square_around(
    workspace: Workspace, places: NDArray[np.float64]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Find a square that holds the goals, the obstacles and the arm in many places.

    Parameters
    ----------
    workspace : Workspace
        The world.
    places : ndarray of shape (..., 2)
        Where joints and end effectors are (m).

    Returns
    -------
    tuple of tuple of float
        The ranges of x and of y (m).
    """
    centres = np.array([[0.0, 0.0], *((x, y) for x, y, _ in workspace.circles)])
    radii = np.array([workspace.goal_radius, *(r for _, _, r in workspace.circles)])
    arms = places.reshape(-1, 2)
    low = np.minimum((centres - radii[:, None]).min(axis=0), arms.min(axis=0))
    high = np.maximum((centres + radii[:, None]).max(axis=0), arms.max(axis=0))
    middle, half = (low + high) / 2, 0.52 * (high - low).max()
    (left, bottom), (right, top) = (middle - half).tolist(), (middle + half).tolist()
    return (left, right), (bottom, top)


def _draw_costs(axis: Axes, recording: SearchTrace, colour: str) -> None:
    """Draw the costs of a start: of every policy, and the least so far."""
    spent = recording.evaluations
    every = np.repeat(spent, recording.costs.shape[1])
    axis.plot(every, recording.costs.ravel(), ".", ms=1.5, alpha=0.25, color=colour)
    axis.plot(spent, recording.best_costs, color=colour, lw=2, label=recording.run.name)
    axis.plot(spent[-1], recording.best_costs[-1], "o", ms=5, color=colour, mec="white")
