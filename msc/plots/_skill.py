"""The picture of a skill: from a task to the gate, a policy and a movement."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc
from matplotlib.patches import ConnectionPatch
from numpy.typing import ArrayLike, NDArray

from msc.learn import ParameterizedSkill
from msc.plots._curves import DENSE, draw_charts
from msc.plots._style import (
    COLOURS,
    GOAL,
    SMALL,
    chart_colour,
    chart_marker,
    styled,
)
from msc.plots._world import WEIGHT_LABELS, draw_arm
from msc.robot import Rollout, Workspace


@styled
def plot_composition(
    skill: ParameterizedSkill,
    tasks: ArrayLike,
    policies: ArrayLike,
    *,
    world: Workspace,
    task_deg: float,
    rollout: Rollout,
    weight: int,
) -> Figure:
    """Draw how the skill turns one task into a movement.

    Parameters
    ----------
    skill : ParameterizedSkill
        The skill, fitted.
    tasks : array_like of shape (n_tasks, 1)
        What it was trained on (rad).
    policies : array_like of shape (n_tasks, n_params)
        Their policies.
    world : Workspace
        Where.
    task_deg : float
        The new task (degrees).
    rollout : Rollout
        What the arm did with the policy predicted for it.
    weight : int
        The policy dimension whose regression is drawn.

    Returns
    -------
    Figure
        Numbered panels joined by arrows: the task; the gate; the regression of the
        task's chart, the others pale; the six weights predicted; the movement.
    """
    tasks, policies = np.asarray(tasks), np.asarray(policies)
    new = np.deg2rad([[task_deg]])
    chart = int(skill.predict_chart(new)[0])
    mean, std = skill.predict(new, return_std=True)
    colour = chart_colour(chart)
    figure = plt.figure(figsize=(7.4, 6.4))
    grid = figure.add_gridspec(
        3, 2, width_ratios=(1, 1.35), height_ratios=(0.28, 1.35, 1.5)
    )
    task = figure.add_subplot(grid[:2, 0])
    gate = figure.add_subplot(grid[0, 1])
    curve = figure.add_subplot(grid[1, 1], sharex=gate)
    bars = figure.add_subplot(grid[2, 1])
    plane = figure.add_subplot(grid[2, 0])
    goal = world.target(task_deg)
    _draw_goals(task, skill, tasks, world)
    task.plot(*goal, "*", color=GOAL, ms=13, mec="white", zorder=6)
    task.set_title("1  a task, never searched", loc="left")
    _draw_gate(gate, skill)
    gate.axvline(task_deg, color=GOAL, lw=1.5)
    gate.set_title(f"2  the gate: chart {chart + 1}", loc="left")
    draw_charts(curve, skill, tasks, policies, weight=weight, only=chart)
    curve.axvline(task_deg, color=GOAL, lw=1.5)
    curve.plot(task_deg, mean[0, weight], "*", color=GOAL, ms=13, mec="white")
    curve.set_title("3  that chart's regressions, one a weight", loc="left")
    curve.set(xlabel="task angle (degrees)", xticks=range(0, 361, 60))
    curve.set_ylabel(f"weight {WEIGHT_LABELS[weight]}")
    look: Any = {"color": colour, "ecolor": "0.2", "capsize": 4}
    bars.bar(range(len(mean[0])), mean[0], yerr=2 * std[0], **look)
    bars.set_axisbelow(True)
    bars.axhline(0, color="0.3", lw=0.8)
    bars.plot(weight, mean[0, weight], "*", color=GOAL, ms=13, mec="white", zorder=5)
    bars.set_xticks(range(len(mean[0])), WEIGHT_LABELS)
    bars.set_title("4  the policy: six weights", loc="left")
    _draw_movement(plane, world, rollout, goal)
    plane.set_title(f"5  it ends {100 * rollout.error:.1f} cm off", loc="left")
    _join(figure, task, goal, gate, (0, 0.5))
    _join(figure, curve, (360, mean[0, weight]), bars, (5.6, 0.0), turn=-0.15)
    _join(figure, bars, (-0.6, 0.0), plane, goal)
    layout: Any = figure.get_layout_engine()
    layout.set(rect=(0, 0, 0.95, 1))  # the arrow beside the panels needs room
    return figure


def _draw_goals(
    axis: Axes, skill: ParameterizedSkill, tasks: NDArray[np.float64], world: Workspace
) -> None:
    """Draw the goals of the training tasks in the colours of their charts."""
    _draw_ground(axis, world)
    draw_arm(axis, world, world.home, alpha=0.5)
    for chart in range(skill.n_charts_):
        goals = world.target(np.rad2deg(tasks[skill.charts_ == chart, 0]))
        look: Any = {"color": chart_colour(chart), "ms": 6, "mec": "white"}
        marker, label = chart_marker(chart), f"chart {chart + 1}"
        axis.plot(*goals.T, marker, ls="", label=label, zorder=4, **look)
    axis.legend(loc="lower right", ncols=2, columnspacing=0.8, handletextpad=0.1)


def _draw_gate(axis: Axes, skill: ParameterizedSkill) -> None:
    """Draw which chart the gate names, over the tasks."""
    gate = skill.predict_chart(DENSE)
    ends = np.flatnonzero(np.diff(gate, prepend=-1, append=-1))
    for start, stop in pairwise(ends):
        chart, step = gate[start], 360 / len(gate)
        axis.axvspan(start * step, stop * step, color=chart_colour(chart), lw=0)
        if stop - start > 20:
            middle, text = (start + stop) / 2 * step, f"{chart + 1}"
            look: Any = {"ha": "center", "va": "center", "fontweight": "bold"}
            box = {"boxstyle": "circle,pad=0.1", "fc": "white", "ec": "none"}
            axis.text(middle, 0.5, text, fontsize=SMALL, bbox=box, **look)
    axis.set(xlim=(0, 360), ylim=(0, 1), yticks=())
    axis.tick_params(labelbottom=False)
    axis.grid(visible=False)


def _draw_movement(
    axis: Axes, world: Workspace, rollout: Rollout, goal: NDArray[np.float64]
) -> None:
    """Draw the movement as a stroboscope would show it."""
    _draw_ground(axis, world)
    for step in np.linspace(0, len(rollout.joints) - 1, 5).round().astype(int):
        pale = 0.2 + 0.6 * step / (len(rollout.joints) - 1)
        draw_arm(axis, world, rollout.joints[step], lw=3, color=str(1 - pale))
    axis.plot(*rollout.path.T, color=COLOURS["charts"], lw=2, zorder=4)
    axis.plot(*goal, "*", color=GOAL, ms=11, mec="white", zorder=6)


def _draw_ground(axis: Axes, world: Workspace) -> None:
    """Draw the goal circle and the obstacles, without numbers."""
    axis.add_patch(Disc((0, 0), world.goal_radius, fill=False, color=GOAL, lw=1))
    for circle in world.circles:
        axis.add_patch(Disc((circle.x, circle.y), circle.radius, color="black"))
    axis.set(xlim=(-0.95, 0.8), ylim=(-0.95, 0.8), aspect="equal", xticks=(), yticks=())
    axis.spines[["left", "bottom"]].set_visible(False)


def _join(
    figure: Figure, one: Axes, here: Any, two: Axes, there: Any, *, turn: float = -0.15
) -> None:
    """Draw an arrow from a place in one panel to a place in another."""
    look: Any = {"arrowstyle": "-|>", "mutation_scale": 12, "color": "0.35"}
    bend: Any = {"connectionstyle": f"arc3,rad={turn}", "shrinkA": 9, "shrinkB": 9}
    arrow = ConnectionPatch(
        here, there, one.transData, two.transData, zorder=10, **look, **bend
    )
    arrow.set_in_layout(False)
    figure.add_artist(arrow)
