"""A slider over tasks that were never searched: chart, prediction, movement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from msc.learn import ParameterizedSkill
from msc.plots._curves import DENSE
from msc.plots._marks import (
    TASK_AXIS,
    WEIGHT_NAMES,
    films,
    mark_world,
    uprights,
    world_panel,
)
from msc.plots._slider import Mark, Panel, Slider
from msc.plots._style import COLOURS, GOAL, METHOD_STYLES, chart_colour, styled
from msc.plots._world import draw_arm, draw_world
from msc.robot import Arm, Rollout, Workspace

FRAME = 6  # time steps from one picture of a film to the next


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
    trained = np.asarray(tasks), np.asarray(policies)
    angles = np.asarray(degrees, dtype=float)
    asked = np.deg2rad(angles)[:, None]
    skill = next(iter(learners.values()))
    charts = skill.predict_chart(asked)
    found = {name: learner.predict(asked) for name, learner in learners.items()}
    rollouts = {
        name: arm.execute_many(some, angles.tolist()) for name, some in found.items()
    }
    missed = {
        name: np.array([100 * rollout.error for rollout in some])
        for name, some in rollouts.items()
    }
    first = int(np.abs(angles - first_deg).argmin())
    captions = [
        f"Task {angle:g}°: chart {charts[k] + 1}. Ends from the goal: "
        + ", ".join(f"{name} {left[k]:.2f} cm" for name, left in missed.items())
        for k, angle in enumerate(angles)
    ]
    return Slider(
        name="task angle",
        labels=[f"{angle:g} degrees" for angle in angles],
        captions=captions,
        panels=[
            _arm_panel(arm, angles, skill, trained[0], rollouts),
            _weight_panel(angles, skill, trained, found, weight),
            _missed_panel(angles, missed),
        ],
        poster=_poster(arm.workspace, rollouts, angles, first),
        poster_alt=f"The arm at the end of predicted movements: {captions[first]}",
        first=first,
        n_times=-(-len(rollouts[next(iter(learners))][0].joints) // FRAME),
        legend={name: COLOURS[name] for name in learners},
    )


def _arm_panel(
    arm: Arm,
    angles: NDArray[np.float64],
    skill: ParameterizedSkill,
    tasks: NDArray[np.float64],
    rollouts: Mapping[str, list[Rollout]],
) -> Panel:
    """Show the world from above: training goals by chart, the goal, the arms."""
    world = arm.workspace
    marks = mark_world(world)
    goals = world.target(np.rad2deg(tasks[:, 0]))
    for chart in range(skill.n_charts_):
        look: Any = {"colour": chart_colour(chart), "width": 4.0}
        marks.append(Mark("dots", goals[skill.charts_ == chart], **look))
    here = [[world.target(angle)] for angle in angles]
    marks.append(Mark("ring", here, "step", colour=GOAL, radius=0.05, width=3.0))
    for name, some in reversed(list(rollouts.items())):
        film = films(some, world, FRAME)
        trail = {"width": 1.2, "opacity": 1.0, "dash": [4, 3]}
        mark: Any = {"colour": COLOURS[name], "width": 3.0, "trail": trail}
        marks.append(Mark("line", film, "time", **mark))
    alt = "The arm from above, goals coloured by chart, the goal, and the movements."
    return world_panel(alt, marks)


def _weight_panel(
    angles: NDArray[np.float64],
    skill: ParameterizedSkill,
    trained: tuple[NDArray[np.float64], NDArray[np.float64]],
    found: Mapping[str, NDArray[np.float64]],
    weight: int,
) -> Panel:
    """Show the skill's curves and bands by chart, and all predictions for the task."""
    tasks, policies = trained
    gate = skill.predict_chart(DENSE)
    mean, std = (both[:, weight] for both in skill.predict(DENSE, return_std=True))
    places, values = np.rad2deg(DENSE[:, 0]), policies[:, weight]
    span = np.ptp(values)
    low, high = float(values.min() - 0.25 * span), float(values.max() + 0.25 * span)
    marks = []
    for piece in np.split(np.arange(len(gate)), np.flatnonzero(np.diff(gate)) + 1):
        colour, some = chart_colour(gate[piece[0]]), piece[::3]
        for sign, look in ((-2, 0.35), (2, 0.35), (0, 1.0)):
            line = np.clip(mean[some] + sign * std[some], low, high)
            points: Any = np.c_[places[some], line]
            width = 2.5 if sign == 0 else 1.0
            marks.append(Mark("line", points, colour=colour, opacity=look, width=width))
    for chart in range(skill.n_charts_):
        here = skill.charts_ == chart
        dots: Any = np.c_[np.rad2deg(tasks[here, 0]), values[here]]
        marks.append(Mark("dots", dots, colour=chart_colour(chart), width=4.0))
    marks.append(uprights(angles, low))
    for name, one in reversed(list(found.items())):
        at = np.clip(one[:, weight], low, high)
        points = [[[x, y]] for x, y in zip(angles, at, strict=True)]
        marks.append(Mark("dots", points, "step", colour=COLOURS[name], width=5.5))
    return Panel(
        "One policy weight over the task angle: a curve with its band for every chart.",
        (0, 360),
        (low, high),
        marks,
        **TASK_AXIS,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=(round(float(values.min())), 0, round(float(values.max()))),
    )


def _missed_panel(
    angles: NDArray[np.float64], missed: Mapping[str, NDArray[np.float64]]
) -> Panel:
    """Show how far from the goal the movements end, over the tasks."""
    top = 1.05 * max(float(left.max()) for left in missed.values())
    marks = [uprights(angles)]
    for name, left in reversed(list(missed.items())):
        points = np.c_[angles, left]
        marks.append(Mark("line", points, colour=COLOURS[name]))
        here = [[point] for point in points]
        marks.append(Mark("dots", here, "step", colour=COLOURS[name], width=5.0))
    half = float(f"{top / 2:.1g}")
    return Panel(
        "How far from the goal the movements end, over the task angle.",
        (0, 360),
        (0, top),
        marks,
        **TASK_AXIS,
        y_label="left to the goal (cm)",
        y_ticks=(0, half, 2 * half) if 2 * half <= top else (0, half),
    )


@styled
def _poster(
    world: Workspace,
    rollouts: Mapping[str, list[Rollout]],
    angles: NDArray[np.float64],
    first: int,
) -> Figure:
    """Draw one step as a picture: the movements and the poses at their ends."""
    figure, plane = plt.subplots(figsize=(4.2, 4.2))
    draw_world(plane, world)
    for name, some in reversed(list(rollouts.items())):
        look: Any = {
            "color": COLOURS[name],
            "label": name,
            "ls": METHOD_STYLES[name]["ls"],
        }
        draw_arm(plane, world, some[first].joints[-1], lw=3, color=COLOURS[name])
        plane.plot(*some[first].path.T, **look)
    plane.plot(*world.target(angles[first]), "o", color=GOAL, ms=8, zorder=5)
    plane.legend(loc="lower right")
    return figure
