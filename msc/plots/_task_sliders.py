"""Sliders over the task: what is predicted for it, and what the arm then does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from msc.learn import ParameterizedSkill
from msc.plots._manifold import COMPARED
from msc.plots._skill import DENSE, predict_curves, widen
from msc.plots._slider import FLAT, TASK_AXIS, Mark, Panel, Slider, choose_ticks, poster
from msc.plots._style import COLOURS, METHOD_STYLES, WEIGHT_NAMES, chart_colour
from msc.plots._world import (
    draw_arm,
    draw_world,
    mark_arm,
    mark_goal,
    world_panel,
)
from msc.robot import Arm, Rollout, Workspace
from msc.study import Experiment

FRAME = 6  # time steps from one picture of a film of predictions to the next
# An experiment's movements.
WAYS: dict[str, dict[str, Any]] = {
    "searched": {"colour": COLOURS["searched"], "width": 6.0, "opacity": 0.55},
    "single regression": {"colour": COLOURS["single regression"], "width": 3.0},
    "charts": {"colour": COLOURS["charts"], "width": 3.0},
}

Array = NDArray[np.float64]


def slide_execution(experiment: Experiment, *, every: int = 2) -> Slider:
    """Let the reader drag the task and see searched and predicted movements.

    Parameters
    ----------
    experiment : Experiment
        What was trained on what.
    every : int, default=2
        Every how many-th test task is on the slider.

    Returns
    -------
    Slider
        Three panels: the arm, one policy weight over the tasks, the execution errors.
        At first it shows the task whose error by the single regression is their median.
    """
    world, shown = experiment.workspace, slice(None, None, every)
    tasks = experiment.test_tasks[shown]
    degrees = experiment.test_table["task_deg"].to_numpy()[shown]
    policies = {"searched": experiment.test_policies[shown]}
    policies |= {name: experiment.predict(name, tasks) for name in COMPARED}
    with Arm(world) as arm:
        rollouts, error_cm = _execute(arm, policies, degrees)
    moving = {
        name: mark_arm(rollouts[name], world, FRAME // 2, **look)
        for name, look in WAYS.items()
    }
    charts = experiment.methods["charts"].predict_chart(tasks)
    opening = "Task {:g}°, chart {}. Ends from the target: "
    captions = _say(opening, degrees, charts, {name: error_cm[name] for name in WAYS})
    first = find_median(error_cm["single regression"])
    alt = "The arm from above, with the goal circle, the goal, obstacles and movements."
    return Slider(
        name="task angle",
        labels=[f"{angle:g} degrees" for angle in degrees],
        captions=captions,
        panels=[
            world_panel(alt, world, [mark_goal(world, degrees), *moving.values()]),
            _searched_panel(experiment, degrees, policies),
            _error_panel(degrees, error_cm),
        ],
        poster=_draw_ends(world, degrees[first], moving, first),
        poster_alt=f"The arm at the end of three movements: {captions[first]}",
        first=first,
        legend={name: COLOURS[name] for name in WAYS},
    )


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
    rollouts, error_cm = _execute(arm, found, angles)
    opening = "Task {:g}°: chart {}. Ends from the goal: "
    told = {name: error_cm[name] for name in learners}
    captions = _say(opening, angles, skill.predict_chart(asked), told)
    first = int(np.abs(angles - first_deg).argmin())
    marks = _mark_by_chart(world.target(trained), skill)
    marks.append(mark_goal(world, angles, "ring", radius=0.05, width=3.0))
    for name, some in rollouts.items():
        marks.append(mark_arm(some, world, FRAME, colour=COLOURS[name], width=3.0))
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
        poster=_draw_predicted(world, rollouts, angles, first),
        poster_alt=f"The arm at the end of predicted movements: {captions[first]}",
        first=first,
        legend={name: COLOURS[name] for name in learners},
    )


def find_median(errors: ArrayLike) -> int:
    """Find whose error is the median one: of two in the middle the lower.

    >>> find_median([9.0, 1.0, 2.0, 3.0])
    2
    """
    return int(np.argsort(errors, kind="stable")[(np.size(errors) - 1) // 2])


# What both show.


def _execute(
    arm: Arm, policies: Mapping[str, Array], degrees: Array
) -> tuple[dict[str, list[Rollout]], dict[str, Array]]:
    """Execute policies for each task: what the arm did, and its final errors (cm)."""
    angles = degrees.tolist()
    done = {name: arm.execute_many(some, angles) for name, some in policies.items()}
    error_cm = {
        name: np.array([100 * rollout.error for rollout in some])
        for name, some in done.items()
    }
    return done, error_cm


def _say(
    opening: str, degrees: Array, charts: Array, error_cm: Mapping[str, Array]
) -> list[str]:
    """Say for every task its chart, and how far from the goal the movements end."""
    steps = zip(*error_cm.values(), strict=True)
    ends = [map("{} {:.2f} cm".format, error_cm, some) for some in steps]
    tasks = zip(degrees, charts + 1, ends, strict=True)
    return [opening.format(angle, k) + ", ".join(end) for angle, k, end in tasks]


def _task_panel(
    alt: str,
    y: tuple[float, float],
    degrees: Array,
    still: Sequence[Mark],
    values: Mapping[str, Array],
    *,
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


# What an experiment shows.


def _searched_panel(
    experiment: Experiment, degrees: Array, policies: Mapping[str, Array]
) -> Panel:
    """Show the weight that varies most over the tasks."""
    weight = int(np.argmax(experiment.policies.std(axis=0)))
    searched = experiment.policies[:, weight]
    points = np.c_[np.rad2deg(experiment.tasks[:, 0]), searched]
    found = {name: some[:, weight] for name, some in policies.items()}
    return _task_panel(
        "One policy weight over the task angle, with the chosen task marked.",
        widen(searched, 0.1),
        degrees,
        [Mark("dots", points, colour=COLOURS["searched"], width=1.2)],
        found,
        width=4.5,
        aspect=FLAT,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=choose_ticks(float(searched.min()), float(searched.max())),
    )


def _error_panel(degrees: Array, error_cm: Mapping[str, Array]) -> Panel:
    """Show how far from the target movements end, over the tasks."""
    logs = {name: np.log10(error_cm[name]) for name in COMPARED}
    low = min(float(log.min()) for log in logs.values()) - 0.1
    high = max(float(log.max()) for log in logs.values()) + 0.1
    decades = range(math.ceil(low), math.floor(high) + 1)
    return _task_panel(
        "The execution error over the task angle, with the chosen task marked.",
        (low, high),
        degrees,
        [],
        logs,
        width=4.5,
        dashes={"single regression": (5.0, 3.0)},
        aspect=FLAT,
        y_label="execution error (cm)",
        y_ticks=tuple(map(float, decades)),
        y_names=tuple(f"{10.0**decade:g}" for decade in decades),
    )


@poster
def _draw_ends(
    axis: Axes, world: Workspace, task_deg: float, moving: Mapping[str, Mark], step: int
) -> None:
    """Draw the movements of one step as lines, with the arms at their ends."""
    draw_world(axis, world, task_deg, zorder=2)
    for name, mark in moving.items():
        film = mark.points[step]
        look: Any = {"lw": mark.width, "alpha": mark.opacity, "label": name}
        axis.plot(*film[:, -1].T, ls="--", lw=1, color=mark.colour)
        axis.plot(*film[-1].T, color=mark.colour, **look)
    axis.legend()


# What learners predict.


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
    return _task_panel(
        "One policy weight over the task angle: a curve with its band for every chart.",
        (low, high),
        degrees,
        [*curves, *_mark_by_chart(points, skill)],
        inside,
        width=5.5,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=(round(float(values.min())), 0, round(float(values.max()))),
    )


def _missed_panel(degrees: Array, error_cm: Mapping[str, Array]) -> Panel:
    """Show how far from the goal the movements end, over the tasks."""
    top = 1.05 * max(float(left.max()) for left in error_cm.values())
    half = float(f"{top / 2:.1g}")
    return _task_panel(
        "How far from the goal the movements end, over the task angle.",
        (0, top),
        degrees,
        [],
        error_cm,
        width=5.0,
        dashes={},
        y_label="left to the goal (cm)",
        y_ticks=(0, half, 2 * half) if 2 * half <= top else (0, half),
    )


@poster
def _draw_predicted(
    axis: Axes,
    world: Workspace,
    rollouts: Mapping[str, list[Rollout]],
    degrees: Array,
    step: int,
) -> None:
    """Draw the movements of one step and the poses at their ends."""
    draw_world(axis, world, degrees[step])
    for name, some in rollouts.items():
        draw_arm(axis, world, some[step].joints[-1], lw=3, color=COLOURS[name])
        dashes = METHOD_STYLES[name]["ls"]
        look: Any = {"color": COLOURS[name], "label": name, "ls": dashes}
        axis.plot(*some[step].path.T, **look)
    axis.legend(loc="lower right")
