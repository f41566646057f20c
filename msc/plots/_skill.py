"""What skills and other learners make of tasks: regressions, the gate, movements.

A skill's charts have their own colours; a learner without charts has its method's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch
from numpy.typing import ArrayLike, NDArray

from msc.learn import ParameterizedSkill
from msc.plots._slider import TASK_AXIS, Mark, Panel, Slider, poster
from msc.plots._style import (
    COLOURS,
    GOAL,
    METHOD_STYLES,
    SMALL,
    WEIGHT_LABELS,
    WEIGHT_NAMES,
    Array,
    chart_colour,
    chart_marker,
    styled,
    widen,
)
from msc.plots._world import (
    FRAME,
    draw_arm,
    draw_world,
    mark_arm,
    mark_goal,
    world_panel,
)
from msc.robot import Arm, Rollout, Workspace

DENSE = np.linspace(0, 2 * np.pi, 721, endpoint=False)[:, None]  # tasks (rad)
STAR: dict[str, Any] = {"color": GOAL, "ms": 13, "mec": "white"}  # of a new task


def predict_curves(
    learner: Any, weight: int, tasks: Array = DENSE
) -> Iterator[tuple[int, Array, Array, Array]]:
    """Predict a weight over many tasks (rad), cut where the gate's chart changes.

    A piece is its chart, the tasks (degrees), means, and standard deviations with the
    policies' noise, zeros if that is not known.
    """
    if isinstance(learner, ParameterizedSkill):
        gate = learner.predict_chart(tasks)
        mean, std = learner.predict(tasks, return_std=True)
    else:  # others have no band in these units
        gate, mean = np.zeros(len(tasks), int), learner.predict(tasks)
        std = np.zeros_like(mean)
    found = np.rad2deg(tasks[:, 0]), mean[:, weight], std[:, weight]
    for piece in np.split(np.arange(len(gate)), np.flatnonzero(np.diff(gate)) + 1):
        degrees, means, stds = (some[piece] for some in found)
        yield int(gate[piece[0]]), degrees, means, stds


def draw_regression(
    axis: Axes,
    learner: Any,
    weight: int,
    *,
    colour: str | None = None,
    band: float = 0.15,
    only: int | None = None,
    tasks: Array = DENSE,
) -> None:
    """Draw a weight over the tasks, and two standard deviations to either side.

    Without a `colour` it is the charts'; all charts but `only` that one are pale.
    """
    for chart, degrees, mean, std in predict_curves(learner, weight, tasks):
        pale = 1.0 if only in (None, chart) else 0.3
        look: Any = {"color": colour or chart_colour(chart)}
        axis.plot(degrees, mean, alpha=pale, **look)
        if std.any():
            edges = mean - 2 * std, mean + 2 * std
            axis.fill_between(degrees, *edges, alpha=band * pale, lw=0, **look)


def draw_by_chart(
    axis: Axes,
    points: Array,
    charts: ArrayLike,
    *,
    only: int | None = None,
    **look: Any,
) -> None:
    """Draw points in the colours and with the markers of their charts."""
    for chart in np.unique(charts):
        here, pale = points[charts == chart], 1.0 if only in (None, chart) else 0.4
        looks: Any = {"label": f"chart {chart + 1}", "mec": "white", **look}
        looks |= {"color": chart_colour(chart), "alpha": pale}
        axis.plot(*here.T, chart_marker(chart), **looks)


def draw_charts(
    axis: Axes,
    skill: ParameterizedSkill,
    degrees: Array,
    values: Array,
    *,
    weight: int,
    only: int | None = None,
) -> None:
    """Draw a skill's regressions of a weight, and the values it was trained on."""
    draw_regression(axis, skill, weight, band=0.2, only=only)
    draw_by_chart(axis, np.c_[degrees, values], skill.charts_, only=only, ms=5, mew=0.4)
    axis.set_ylim(*widen(values, 0.25))


@styled
def plot_rivals(
    learners: Mapping[str, Any],
    tasks: Array,
    policies: Array,
    *,
    chosen: NDArray[np.intp],
    weight: int,
) -> Figure:
    """Draw one weight over the tasks as several learners predict it.

    Parameters
    ----------
    learners : mapping from str to estimator
        Fitted, by the names of methods; a skill of several charts in their colours.
    tasks : ndarray of shape (n_grid, 1)
        Tasks (rad).
    policies : ndarray of shape (n_grid, n_params)
        Their searched policies.
    chosen : ndarray of int
        Indices of those trained on.
    weight : int
        The policy dimension.

    Returns
    -------
    Figure
        One panel a learner; grey points are all searched policies.
    """
    degrees, searched = np.rad2deg(tasks[:, 0]), policies[:, weight]
    figure, axes = plt.subplots(
        1, len(learners), figsize=(7.4, 2.9), sharex=True, sharey=True
    )
    for axis, (name, learner) in zip(axes, learners.items(), strict=True):
        axis.plot(degrees, searched, ".", ms=2.5, color=COLOURS["searched"])
        trained = degrees[chosen], searched[chosen]
        if getattr(learner, "n_charts_", 1) > 1:
            draw_charts(axis, learner, *trained, weight=weight)
        else:
            draw_regression(axis, learner, weight, colour=COLOURS[name])
            look: Any = {"color": COLOURS[name], "mec": "white", "mew": 0.4}
            axis.plot(*trained, METHOD_STYLES[name]["marker"], ms=4, **look)
        axis.set(title=name, xticks=range(0, 361, 120))
        axis.set_xlabel("task angle (degrees)")
    axes[0].set_ylim(*widen(searched, 0.15))
    axes[0].set_ylabel(f"policy weight {WEIGHT_LABELS[weight]}")
    return figure


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
    degrees, values = np.rad2deg(tasks)[:, 0], np.asarray(policies)[:, weight]
    new = np.deg2rad([[task_deg]])
    chart = int(skill.predict_chart(new)[0])
    [mean], [std] = skill.predict(new, return_std=True)
    figure = plt.figure(figsize=(7.4, 6.4))
    grid = figure.add_gridspec(
        3, 2, width_ratios=(1, 1.35), height_ratios=(0.28, 1.35, 1.5)
    )
    task = figure.add_subplot(grid[:2, 0])
    gate = figure.add_subplot(grid[0, 1])
    curve = figure.add_subplot(grid[1, 1], sharex=gate)
    bars = figure.add_subplot(grid[2, 1])
    plane = figure.add_subplot(grid[2, 0])

    draw_world(task, world, task_deg, view="skill")
    draw_arm(task, world, world.home, alpha=0.5)
    draw_by_chart(task, world.target(degrees), skill.charts_, ms=6, zorder=4)
    task.legend(loc="lower right", ncols=2, columnspacing=0.8, handletextpad=0.1)
    task.set_title("1  a task, never searched", loc="left")

    _draw_gate(gate, skill)
    gate.axvline(task_deg, color=GOAL, lw=1.5)
    gate.set_title(f"2  the gate: chart {chart + 1}", loc="left")

    draw_charts(curve, skill, degrees, values, weight=weight, only=chart)
    curve.axvline(task_deg, color=GOAL, lw=1.5)
    curve.plot(task_deg, mean[weight], "*", **STAR)
    curve.set_title("3  that chart's regressions, one a weight", loc="left")
    curve.set(xlabel="task angle (degrees)", xticks=range(0, 361, 60))
    curve.set_ylabel(f"weight {WEIGHT_LABELS[weight]}")

    look: Any = {"color": chart_colour(chart), "ecolor": "0.2", "capsize": 4}
    bars.bar(range(len(mean)), mean, yerr=2 * std, **look)
    bars.set_axisbelow(True)
    bars.axhline(0, color="0.3", lw=0.8)
    bars.plot(weight, mean[weight], "*", zorder=5, **STAR)
    bars.set_xticks(range(len(mean)), WEIGHT_LABELS)
    bars.set_title("4  the policy: six weights", loc="left")

    draw_world(plane, world, task_deg, view="skill", ms=11)
    _draw_movement(plane, world, rollout)
    plane.set_title(f"5  it ends {100 * rollout.error:.1f} cm off", loc="left")

    goal = world.target(task_deg)
    _join(figure, task, goal, gate, (0, 0.5))
    _join(figure, curve, (360, mean[weight]), bars, (5.6, 0.0))
    _join(figure, bars, (-0.6, 0.0), plane, goal)
    layout: Any = figure.get_layout_engine()
    layout.set(rect=(0, 0, 0.95, 1))  # the arrow beside the panels needs room
    return figure


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


def _draw_movement(axis: Axes, world: Workspace, rollout: Rollout) -> None:
    """Draw the movement as a stroboscope would show it."""
    last = len(rollout.joints) - 1
    for step in np.linspace(0, last, 5).round().astype(int):
        grey = str(1 - (0.2 + 0.6 * step / last))
        draw_arm(axis, world, rollout.joints[step], lw=3, color=grey)
    axis.plot(*rollout.path.T, color=COLOURS["charts"], lw=2, zorder=4)


def _join(figure: Figure, one: Axes, here: Any, two: Axes, there: Any) -> None:
    """Draw an arrow from a place in one panel to a place in another."""
    look: Any = {"arrowstyle": "-|>", "mutation_scale": 12, "color": "0.35"}
    bend: Any = {"connectionstyle": "arc3,rad=-0.15", "shrinkA": 9, "shrinkB": 9}
    arrow = ConnectionPatch(
        here, there, one.transData, two.transData, zorder=10, **look, **bend
    )
    arrow.set_in_layout(False)
    figure.add_artist(arrow)


def slide_predictions(
    learners: Mapping[str, Any],
    tasks: ArrayLike,
    policies: ArrayLike,
    *,
    arm: Arm,
    degrees: ArrayLike,
    weight: int,
    first_deg: float = 180.0,
) -> Slider:
    """Let the reader drag a task and see what learners predict and the arm does.

    Parameters
    ----------
    learners : mapping from str to estimator
        Fitted, by the names of methods; the first is a skill with charts.
    tasks : array_like of shape (n_tasks, 1)
        What they were trained on (rad).
    policies : array_like of shape (n_tasks, n_params)
        Their policies.
    arm : Arm
        What executes the predictions.
    degrees : array_like of shape (n_steps,)
        The tasks on the slider (degrees).
    weight : int
        The policy dimension that is drawn.
    first_deg : float, default=180.0
        The slider's first task is the one nearest to this (degrees).

    Returns
    -------
    Slider
        Three panels: the arm, with goals in the colours of their charts; the weight
        over the tasks; the distances that are left.
    """
    world, skill = arm.workspace, next(iter(learners.values()))
    angles = np.asarray(degrees, dtype=float)
    asked = np.deg2rad(angles)[:, None]
    trained = np.rad2deg(tasks)[:, 0]
    # From back to front: the first is to be seen.
    found = {name: learners[name].predict(asked) for name in [*learners][::-1]}
    rollouts, error_cm = execute_all(arm, found, angles)
    opening = "Task {:g}°: chart {}. Ends from the goal: "
    told = {name: error_cm[name] for name in learners}
    captions = tell_ends(opening, angles, skill.predict_chart(asked), told)
    first = int(np.abs(angles - first_deg).argmin())
    ends = {name: some[first] for name, some in rollouts.items()}
    marks = _mark_by_chart(world.target(trained), skill)
    marks.append(mark_goal(world, angles, "ring", radius=0.05, width=3.0))
    for name, some in rollouts.items():
        marks.append(mark_arm(some, world, 2 * FRAME, colour=COLOURS[name], width=3.0))
    alt = "The arm from above, goals coloured by chart, the goal, and the movements."
    points = np.c_[trained, np.asarray(policies)[:, weight]]
    return Slider(
        name="task angle",
        labels=[f"{angle:g} degrees" for angle in angles],
        captions=captions,
        panels=[
            world_panel(alt, world, marks),
            _predicted_panel(angles, skill, points, found, weight),
            _missed_panel(angles, error_cm),
        ],
        poster=_draw_predicted(world, angles[first], ends),
        poster_alt=f"The arm at the end of predicted movements: {captions[first]}",
        first=first,
        legend={name: COLOURS[name] for name in learners},
    )


def _mark_by_chart(points: Array, skill: ParameterizedSkill) -> list[Mark]:
    """Mark a skill's training tasks in the colours of their charts."""
    return [
        Mark("dots", points[skill.charts_ == k], colour=chart_colour(k), width=4.0)
        for k in range(skill.n_charts_)
    ]


def _predicted_panel(
    degrees: Array,
    skill: ParameterizedSkill,
    points: Array,
    found: Mapping[str, Array],
    weight: int,
) -> Panel:
    """Show the skill's curves and bands by chart, and all predictions for the task."""
    values = points[:, 1]
    low, high = widen(values, 0.25)
    curves = []
    for chart, angles, mean, std in predict_curves(skill, weight, DENSE):
        for sign, opacity, width in ((-2, 0.35, 1.0), (2, 0.35, 1.0), (0, 1.0, 2.5)):
            edge = np.c_[angles, np.clip(mean + sign * std, low, high)][::3]
            look: Any = {"colour": chart_colour(chart), "opacity": opacity}
            curves.append(Mark("line", edge, width=width, **look))
    inside = {n: np.clip(one[:, weight], low, high) for n, one in found.items()}
    return task_panel(
        "One policy weight over the task angle: a curve with its band for every chart.",
        (low, high),
        degrees,
        inside,
        still=[*curves, *_mark_by_chart(points, skill)],
        width=5.5,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=(round(float(values.min())), 0, round(float(values.max()))),
    )


def _missed_panel(degrees: Array, error_cm: Mapping[str, Array]) -> Panel:
    """Show how far from the goal the movements end, over the tasks."""
    top = 1.05 * max(float(left.max()) for left in error_cm.values())
    half = float(f"{top / 2:.1g}")
    return task_panel(
        "How far from the goal the movements end, over the task angle.",
        (0, top),
        degrees,
        error_cm,
        width=5.0,
        dashes={},
        y_label="left to the goal (cm)",
        y_ticks=(0, half, 2 * half) if 2 * half <= top else (0, half),
    )


@poster
def _draw_predicted(
    axis: Axes, world: Workspace, task_deg: float, rollouts: Mapping[str, Rollout]
) -> None:
    """Draw movements and the poses at their ends."""
    draw_world(axis, world, task_deg)
    for name, rollout in rollouts.items():
        colour, dashes = COLOURS[name], METHOD_STYLES[name]["ls"]
        draw_arm(axis, world, rollout.joints[-1], lw=3, color=colour)
        axis.plot(*rollout.path.T, color=colour, ls=dashes, label=name)
    axis.legend(loc="lower right")


def execute_all(
    arm: Arm, policies: Mapping[str, Array], degrees: Array
) -> tuple[dict[str, list[Rollout]], dict[str, Array]]:
    """Execute policies for each task: what the arm did, and its final errors (cm)."""
    angles = degrees.tolist()
    done = {name: arm.execute_many(some, angles) for name, some in policies.items()}
    return done, {n: np.array([100 * one.error for one in done[n]]) for n in done}


def tell_ends(
    opening: str, degrees: Array, charts: Array, error_cm: Mapping[str, Array]
) -> list[str]:
    """Say for every task its chart, and how far from the goal the movements end."""
    steps = zip(*error_cm.values(), strict=True)
    ends = [map("{} {:.2f} cm".format, error_cm, some) for some in steps]
    tasks = zip(degrees, charts + 1, ends, strict=True)
    return [opening.format(angle, k) + ", ".join(end) for angle, k, end in tasks]


def task_panel(
    alt: str,
    y: tuple[float, float],
    degrees: Array,
    values: Mapping[str, Array],
    *,
    still: Sequence[Mark] = (),
    width: float,
    dashes: Mapping[str, tuple[float, ...]] | None = None,
    **axes: Any,
) -> Panel:
    """Show methods' values over the tasks, those of the chosen task as dots.

    An upright line is where that is; with `dashes` all of a method's values are a line.
    """
    places = np.stack([degrees, 0 * degrees], axis=1)[:, None]
    marks = [*still, Mark("upright", places, "step", width=1.0, opacity=0.5)]
    for name, some in values.items():
        points, colour = np.stack([degrees, some], axis=1), COLOURS[name]
        if dashes is not None:
            marks.append(Mark("line", points, colour=colour, dash=dashes.get(name, ())))
        marks.append(Mark("dots", points[:, None], "step", colour=colour, width=width))
    return Panel(alt, (0, 360), y, marks, **TASK_AXIS, **axes)
