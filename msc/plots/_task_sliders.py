"""Sliders over the task: what is predicted for it, and what the arm then does."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from msc.learn import ParameterizedSkill
from msc.plots._figures import METHODS
from msc.plots._skill import DENSE, predict_curves, widen
from msc.plots._slider import FLAT, TASK_AXIS, Mark, Panel, Slider, choose_ticks, poster
from msc.plots._style import COLOURS, LOOKS, WEIGHT_NAMES, chart_colour
from msc.plots._world import (
    TRAIL,
    draw_arm,
    draw_world,
    mark_arm,
    mark_goal,
    world_panel,
)
from msc.robot import Arm, Rollout, Workspace
from msc.study import Experiment

# Of the movements of an experiment.
WAYS: dict[str, dict[str, Any]] = {
    "searched": {"colour": COLOURS["searched"], "width": 6.0, "opacity": 0.55},
    "single regression": {"colour": COLOURS["single regression"], "width": 3.0},
    "charts": {"colour": COLOURS["charts"], "width": 3.0},
}
DASHES = {"single regression": (5.0, 3.0)}

Array = NDArray[np.float64]
_Rollouts = Mapping[str, list[Rollout]]


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
    policies |= {name: experiment.predict(name, tasks) for name in [*WAYS][1:]}
    with Arm(world) as arm:
        rollouts = _execute(arm, policies, degrees)
    moving = {
        name: mark_arm(
            some, world, 3, trail=TRAIL, **WAYS[name]
        )  # 20 pictures a second
        for name, some in rollouts.items()
    }
    error_cm = _miss(rollouts)
    charts = experiment.methods["charts"].predict_chart(tasks)
    captions = [
        f"Task {angle:g}°, chart {charts[k] + 1}. Ends from the target: "
        + _say(error_cm, k)
        for k, angle in enumerate(degrees)
    ]
    first = find_median(error_cm["single regression"])
    return _over_tasks(
        degrees,
        captions,
        [
            world_panel(
                "The arm from above, with the goal circle, the goal, obstacles and "
                "movements.",
                world,
                [mark_goal(world, degrees), *moving.values()],
            ),
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
    trained, values = np.rad2deg(tasks)[:, 0], np.asarray(policies)[:, weight]
    angles = np.asarray(degrees, dtype=float)
    asked = np.deg2rad(angles)[:, None]
    charts = skill.predict_chart(asked)
    # From back to front: the first is to be seen.
    found = {name: learners[name].predict(asked) for name in [*learners][::-1]}
    rollouts = _execute(arm, found, angles)
    error_cm = _miss(rollouts)
    captions = [
        f"Task {angle:g}°: chart {charts[k] + 1}. Ends from the goal: "
        + _say({name: error_cm[name] for name in learners}, k)
        for k, angle in enumerate(angles)
    ]
    first = int(np.abs(angles - first_deg).argmin())
    return _over_tasks(
        angles,
        captions,
        [
            world_panel(
                "The arm from above, goals coloured by chart, the goal, and the "
                "movements.",
                world,
                [
                    *_mark_by_chart(world.target(trained), skill),
                    mark_goal(world, angles, "ring", radius=0.05, width=3.0),
                    *(
                        mark_arm(
                            some, world, 6, colour=COLOURS[name], width=3.0, trail=TRAIL
                        )
                        for name, some in rollouts.items()
                    ),
                ],
            ),
            _predicted_panel(
                angles,
                skill,
                np.c_[trained, values],
                {name: one[:, weight] for name, one in found.items()},
                weight,
            ),
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


def _execute(arm: Arm, policies: Mapping[str, Array], degrees: Array) -> _Rollouts:
    """Execute several policies for each task."""
    return {
        name: arm.execute_many(some, degrees.tolist())
        for name, some in policies.items()
    }


def _miss(rollouts: _Rollouts) -> dict[str, Array]:
    """Return how far from the goal movements end (cm)."""
    return {
        name: np.array([100 * rollout.error for rollout in some])
        for name, some in rollouts.items()
    }


def _say(error_cm: Mapping[str, Array], step: int) -> str:
    """Say how far from the goal the movements for one task end."""
    return ", ".join(f"{name} {some[step]:.2f} cm" for name, some in error_cm.items())


def _over_tasks(
    degrees: Array, captions: Sequence[str], panels: Sequence[Panel], **more: Any
) -> Slider:
    """Make a slider over the task."""
    labels = [f"{angle:g} degrees" for angle in degrees]
    return Slider("task angle", labels, captions, panels, **more)


def _task_panel(
    alt: str,
    y: tuple[float, float],
    degrees: Array,
    still: Iterable[Mark],
    moving: Iterable[Mark],
    **axes: Any,
) -> Panel:
    """Show something over the task angle, the chosen task by an upright line."""
    upright = Mark(
        "upright", _steps(degrees, 0 * degrees), "step", width=1.0, opacity=0.5
    )
    return Panel(alt, (0, 360), y, [*still, upright, *moving], **TASK_AXIS, **axes)


def _steps(degrees: Array, values: Array) -> Array:
    """Return a point a step."""
    return np.stack([degrees, values], axis=1)[:, None]


def _follow(degrees: Array, values: Mapping[str, Array], width: float) -> list[Mark]:
    """Mark each method's value for the chosen task."""
    return [
        Mark("dots", _steps(degrees, one), "step", colour=COLOURS[name], width=width)
        for name, one in values.items()
    ]


def _trace(
    degrees: Array,
    values: Mapping[str, Array],
    width: float,
    dashes: Mapping[str, tuple[float, ...]],
) -> list[Mark]:
    """Draw each method's values over the tasks, and mark the chosen task's."""
    return [
        mark
        for name, one in values.items()
        for mark in (
            Mark(
                "line",
                np.c_[degrees, one],
                colour=COLOURS[name],
                dash=dashes.get(name, ()),
            ),
            *_follow(degrees, {name: one}, width),
        )
    ]


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
        _follow(degrees, found, 4.5),
        aspect=FLAT,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=choose_ticks(float(searched.min()), float(searched.max())),
    )


def _error_panel(degrees: Array, error_cm: Mapping[str, Array]) -> Panel:
    """Show how far from the target movements end, over the tasks."""
    logs = {name: np.log10(error_cm[name]) for name in METHODS}
    low = min(float(log.min()) for log in logs.values()) - 0.1
    high = max(float(log.max()) for log in logs.values()) + 0.1
    decades = range(math.ceil(low), math.floor(high) + 1)
    return _task_panel(
        "The execution error over the task angle, with the chosen task marked.",
        (low, high),
        degrees,
        [],
        _trace(degrees, logs, 4.5, DASHES),
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
    inside = {name: np.clip(one, low, high) for name, one in found.items()}
    return _task_panel(
        "One policy weight over the task angle: a curve with its band for every chart.",
        (low, high),
        degrees,
        [*curves, *_mark_by_chart(points, skill)],
        _follow(degrees, inside, 5.5),
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
        _trace(degrees, error_cm, 5.0, {}),
        y_label="left to the goal (cm)",
        y_ticks=(0, half, 2 * half) if 2 * half <= top else (0, half),
    )


@poster
def _draw_predicted(
    axis: Axes, world: Workspace, rollouts: _Rollouts, degrees: Array, step: int
) -> None:
    """Draw the movements of one step and the poses at their ends."""
    draw_world(axis, world, degrees[step])
    for name, some in rollouts.items():
        draw_arm(axis, world, some[step].joints[-1], lw=3, color=COLOURS[name])
        look: Any = {"color": COLOURS[name], "label": name, "ls": LOOKS[name]["ls"]}
        axis.plot(*some[step].path.T, **look)
    axis.legend(loc="lower right")
