"""What sliders show: movements over the task angle."""

from __future__ import annotations

import math
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from msc.plots._manifold import COMPARED
from msc.plots._marks import (
    FLAT,
    TASK_AXIS,
    WEIGHT_NAMES,
    films,
    mark_world,
    uprights,
    world_panel,
)
from msc.plots._slider import Mark, Panel, Slider, choose_ticks
from msc.plots._style import COLOURS, GOAL, styled
from msc.plots._world import draw_world
from msc.robot import Arm
from msc.study import Experiment

FRAME = 3  # time steps from one picture of a film to the next: 20 pictures a second
WAYS: dict[str, dict[str, Any]] = {
    "searched": {"colour": COLOURS["searched"], "width": 6.0, "opacity": 0.55},
    "single regression": {"colour": COLOURS["single regression"], "width": 3.0},
    "charts": {"colour": COLOURS["charts"], "width": 3.0},
}

DASHES = {"single regression": (5.0, 3.0), "charts": ()}


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
    shown = slice(None, None, every)
    degrees = experiment.test_table["task_deg"].to_numpy()[shown]
    policies = {
        name: experiment.test_policies[shown]
        if name == "searched"
        else experiment.predict(name, experiment.test_tasks[shown])
        for name in WAYS
    }
    with Arm(experiment.workspace) as arm:
        rollouts = {
            name: arm.execute_many(some, degrees.tolist())
            for name, some in policies.items()
        }
    error_cm = {
        name: np.array([100 * rollout.error for rollout in some])
        for name, some in rollouts.items()
    }
    world = experiment.workspace
    moving = {name: films(some, world, FRAME) for name, some in rollouts.items()}
    charts = experiment.methods["charts"].predict_chart(experiment.test_tasks[shown])
    captions = [
        f"Task {degrees[k]:g}°, chart {charts[k] + 1}. Ends from the target: "
        + ", ".join(f"{name} {error_cm[name][k]:.2f} cm" for name in WAYS)
        for k in range(len(degrees))
    ]
    first = find_median(error_cm["single regression"])
    return Slider(
        name="task angle",
        labels=[f"{angle:g} degrees" for angle in degrees],
        captions=captions,
        panels=[
            _arm_panel(experiment, degrees, moving),
            _weight_panel(experiment, degrees, policies),
            _error_panel(degrees, error_cm),
        ],
        poster=_poster(experiment, degrees[first], moving, first),
        poster_alt=f"The arm at the end of three movements: {captions[first]}",
        first=first,
        n_times=moving["charts"].shape[1],
        legend={name: str(look["colour"]) for name, look in WAYS.items()},
    )


def find_median(errors: ArrayLike) -> int:
    """Find whose error is the median one.

    Parameters
    ----------
    errors : array_like of shape (n_tasks,)
        Any numbers; of an even count the lower of the two in the middle.

    Returns
    -------
    int
        Its index.

    Examples
    --------
    >>> find_median([9.0, 1.0, 2.0, 3.0])
    2
    """
    return int(np.argsort(errors, kind="stable")[(np.size(errors) - 1) // 2])


def _arm_panel(
    experiment: Experiment, degrees: NDArray[Any], moving: dict[str, NDArray[Any]]
) -> Panel:
    """Show the world from above, with all arms."""
    world = experiment.workspace
    marks = mark_world(world)
    goals = [[world.target(angle)] for angle in degrees]
    marks.append(Mark("disc", goals, "step", colour=GOAL, radius=0.025))
    for name, film in moving.items():
        look = WAYS[name]
        trail = {"width": 1.2, "opacity": 1.0, "dash": [4, 3]}
        marks.append(Mark("line", film, "time", trail=trail, **look))
    alt = "The arm from above, with the goal circle, the goal, obstacles and movements."
    return world_panel(alt, marks)


def _weight_panel(
    experiment: Experiment, degrees: NDArray[Any], policies: dict[str, NDArray[Any]]
) -> Panel:
    """Show the weight that varies most over the tasks."""
    weight = int(np.argmax(experiment.policies.std(axis=0)))
    grid = np.rad2deg(experiment.tasks[:, 0])
    searched = experiment.policies[:, weight]
    still = Mark("dots", np.c_[grid, searched], colour=COLOURS["searched"], width=1.2)
    marks = [still]
    marks.append(uprights(degrees))
    for name, some in policies.items():
        points = [[[x, y]] for x, y in zip(degrees, some[:, weight], strict=True)]
        marks.append(
            Mark("dots", points, "step", colour=WAYS[name]["colour"], width=4.5)
        )
    low, high = searched.min(), searched.max()
    margin = 0.1 * (high - low)
    return Panel(
        "One policy weight over the task angle, with the chosen task marked.",
        (0, 360),
        (float(low - margin), float(high + margin)),
        marks,
        aspect=FLAT,
        **TASK_AXIS,
        y_label="policy weight " + WEIGHT_NAMES[weight],
        y_ticks=choose_ticks(float(low), float(high)),
    )


def _error_panel(degrees: NDArray[Any], error_cm: dict[str, NDArray[Any]]) -> Panel:
    """Show how far from the target movements end, over the tasks."""
    logs = {name: np.log10(error_cm[name]) for name in COMPARED}
    low = min(float(log.min()) for log in logs.values()) - 0.1
    high = max(float(log.max()) for log in logs.values()) + 0.1
    marks = [uprights(degrees, low)]
    for name, log in logs.items():
        points = np.c_[degrees, log]
        look = WAYS[name] | {"width": 1.5, "dash": DASHES[name]}
        marks += [Mark("line", points, **look)]
        here = [[point] for point in points]
        marks.append(Mark("dots", here, "step", colour=WAYS[name]["colour"], width=4.5))
    decades = range(math.ceil(low), math.floor(high) + 1)
    return Panel(
        "The execution error over the task angle, with the chosen task marked.",
        (0, 360),
        (low, high),
        marks,
        aspect=FLAT,
        **TASK_AXIS,
        y_label="execution error (cm)",
        y_ticks=tuple(map(float, decades)),
        y_names=tuple(f"{10.0**decade:g}" for decade in decades),
    )


@styled
def _poster(
    experiment: Experiment, angle: float, moving: dict[str, NDArray[Any]], step: int
) -> Figure:
    """Draw one step as a picture."""
    figure, axis = plt.subplots(figsize=(4.2, 4.2))
    draw_world(axis, experiment.workspace)
    axis.plot(*experiment.workspace.target(angle), "o", color=GOAL, ms=8)
    for name, film in moving.items():
        axis.plot(*film[step, :, -1].T, ls="--", lw=1, color=WAYS[name]["colour"])
        axis.plot(
            *film[step, -1].T,
            lw=WAYS[name]["width"],
            color=WAYS[name]["colour"],
            alpha=WAYS[name].get("opacity", 1.0),
            label=name,
        )
    axis.legend()
    return figure
