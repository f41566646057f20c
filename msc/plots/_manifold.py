"""The figures of the paper: policies over the tasks, and what executing them misses.

A slider has both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from msc.plots._skill import (
    draw_by_chart,
    draw_regression,
    execute_all,
    task_panel,
    tell_ends,
)
from msc.plots._slider import FLAT, Mark, Panel, Slider, choose_ticks, poster
from msc.plots._style import COLOURS, WEIGHT_LABELS, WEIGHT_NAMES, Array, styled, widen
from msc.plots._world import draw_world, mark_arm, mark_goal, world_panel
from msc.robot import Arm, Workspace
from msc.study import Experiment

FINE = np.linspace(0, 2 * np.pi, 1441, endpoint=False)[:, None]  # tasks (rad)
COMPARED = ("single regression", "charts")  # from left to right, or top to bottom

# An experiment's movements.
WAYS: dict[str, dict[str, Any]] = {
    "searched": {"colour": COLOURS["searched"], "width": 6.0, "opacity": 0.55},
    "single regression": {"colour": COLOURS["single regression"], "width": 3.0},
    "charts": {"colour": COLOURS["charts"], "width": 3.0},
}


@styled
def plot_manifold(
    experiment: Experiment, dimensions: Sequence[int] | None = None
) -> Figure:
    """Draw policy dimensions over the tasks, as the paper's Figures 2, 3, 5 and 6.

    Parameters
    ----------
    experiment : Experiment
        What was trained on what.
    dimensions : sequence of int, optional
        Policy dimensions, one row each; by default the one that varies most over all
        grid tasks.

    Returns
    -------
    Figure
        Left the single regression, right the charts; below a dimension that is alone,
        what is predicted minus what was searched.
    """
    if dimensions is None:
        dimensions = [int(np.argmax(experiment.policies.std(axis=0)))]
    alone = len(dimensions) == 1
    heights = (3.0, 1.0) if alone else (1.9,) * len(dimensions)
    size = 7.4, sum(heights) + 0.3 * alone
    layout: Any = {"sharex": True, "sharey": "row", "height_ratios": heights}
    figure: Figure
    figure, axes = plt.subplots(len(heights), 2, figsize=size, squeeze=False, **layout)
    for (single, charts), dimension in zip(axes, dimensions, strict=False):
        _draw_manifold(single, charts, experiment, dimension)
    if alone:
        _draw_residuals(axes[1], experiment, dimensions[0])
        axes[1, 0].set_ylabel("predicted\n− searched")
    n_samples = experiment.n_samples
    n_charts = experiment.methods["charts"].n_charts_
    axes[0, 0].set_title(f"single regression, {n_samples} samples")
    axes[0, 1].set_title(f"{n_charts} charts, {n_samples} samples")
    axes[0, 1].legend(ncols=2)
    for axis in axes[-1]:
        axis.set_xlabel("task angle (degrees)")
    return figure


def _draw_manifold(
    single: Axes, charts: Axes, experiment: Experiment, dimension: int
) -> None:
    """Draw one policy dimension: searched, and predicted by either method."""
    chosen, methods = experiment.chosen, experiment.methods
    angles = np.rad2deg(experiment.tasks[:, 0])
    searched = experiment.policies[:, dimension]
    trained = np.c_[angles, searched][chosen]
    look: Any = {"color": COLOURS["searched"], "label": "searched"}
    for axis in (single, charts):
        axis.plot(angles, searched, ".", ms=2.5, **look)
        _mark_jumps(axis, experiment)
        axis.set_xticks(range(0, 361, 60))
    colour = COLOURS["single regression"]
    one, several = (methods[name] for name in COMPARED)
    draw_regression(single, one, dimension, colour=colour, tasks=FINE)
    single.plot(*trained.T, "o", ms=3.5, color=colour, mec="white", mew=0.4)
    draw_regression(charts, several, dimension, tasks=FINE)
    draw_by_chart(charts, trained, several.charts_, ms=4, mew=0.4)
    single.set_ylim(*widen(searched, 0.15))
    single.set_ylabel(f"policy weight {WEIGHT_LABELS[dimension]}")


def _draw_residuals(
    axes: Iterable[Axes], experiment: Experiment, dimension: int
) -> None:
    """Draw, for every searched task, the weight predicted minus that searched."""
    angles = np.rad2deg(experiment.tasks[:, 0])
    for axis, method in zip(axes, COMPARED, strict=True):
        predicted = experiment.predict(method, experiment.tasks)
        residual = (predicted - experiment.policies)[:, dimension]
        axis.axhline(0, color="0.3", lw=0.8)
        axis.plot(angles, residual, ".", ms=2.5, color=COLOURS[method])
        _mark_jumps(axis, experiment)


@styled
def plot_execution(experiment: Experiment, *, scale: str = "log") -> Figure:
    """Draw the execution error over the tasks, as the paper's Figures 4 and 7.

    Parameters
    ----------
    experiment : Experiment
        What was trained on what.
    scale : {"log", "linear"}, default="log"
        Of the errors; the paper's is linear.

    Returns
    -------
    Figure
        Top the single regression, bottom the charts, on one scale; a rug
        beside each has the errors alone. Mean, standard deviation and median are
        marked, and tasks that met an obstacle.
    """
    figure, axes = plt.subplots(
        2, 2, figsize=(7.4, 5.0), sharex="col", sharey=True, width_ratios=(1, 0.05)
    )
    executed = experiment.executed
    for (axis, rug), method in zip(axes, COMPARED, strict=True):
        rows = executed[executed["method"] == method]
        _draw_errors(axis, rows, method)
        _mark_jumps(axis, experiment)
        rug.hlines(rows["error_cm"], 0, 1, color=COLOURS[method], lw=0.6, alpha=0.6)
        rug.set_axis_off()
    shown = executed.loc[executed["method"].isin(COMPARED), "error_cm"]
    low, high = shown.min() / 1.3, shown.max() * 1.3
    axes[0, 0].set(yscale=scale, ylim=(low if scale == "log" else 0.0, high))
    axes[0, 0].yaxis.set_major_formatter("{x:g}")
    axes[1, 0].set(xticks=range(0, 361, 60), xlim=(-3, 363))
    axes[1, 0].set_xlabel("task angle (degrees)")
    _name_marks(figure, axes[:, 0])
    return figure


def _draw_errors(axis: Axes, rows: pd.DataFrame, method: str) -> None:
    """Draw the errors of one method over the tasks, and what sums them up."""
    mean, std, median = rows["error_cm"].agg(["mean", "std", "median"])
    spread = f"mean {mean:.2f} ± {std:.2f} cm, median {median:.2f} cm"
    axis.set_title(f"{method}: {spread}", loc="left")
    axis.set_ylabel("error (cm)")
    low = max(mean - std, 1e-9)  # a logarithm's axis has no zero
    axis.axhspan(low, mean + std, color="0.9", lw=0, zorder=0, label="mean ± std")
    axis.axhline(mean, color="0.3", lw=1, ls="--", label="mean")
    axis.axhline(median, color="0.3", lw=1, label="median")
    ways: Any = (
        (False, "o", 3.5, "touched nothing"),
        (True, "x", 4.5, "met an obstacle"),
    )
    for touched, marker, size, label in ways:
        here = rows[rows["touched"] == touched]
        if len(here):
            place = here["task_deg"], here["error_cm"]
            axis.plot(*place, marker, color=COLOURS[method], ms=size, label=label)


def _name_marks(figure: Figure, axes: Iterable[Axes]) -> None:
    """Write one legend for several panels, below them, in the colour of none."""
    named: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            named.setdefault(label, handle)
    legend = figure.legend(
        named.values(), named.keys(), loc="outside lower center", ncols=len(named)
    )
    for line in legend.get_lines():
        line.set_color("0.3")


def _mark_jumps(axis: Axes, experiment: Experiment) -> None:
    """Draw dotted lines where the policies jump."""
    for jump in experiment.jumps:
        place = np.rad2deg(experiment.tasks[jump : jump + 2, 0].mean())
        axis.axvline(place, color="0.5", lw=0.8, ls=":", zorder=0)


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
        rollouts, error_cm = execute_all(arm, policies, degrees)
    moving = {
        name: mark_arm(rollouts[name], world, **look) for name, look in WAYS.items()
    }
    charts = experiment.methods["charts"].predict_chart(tasks)
    opening = "Task {:g}°, chart {}. Ends from the target: "
    captions = tell_ends(opening, degrees, charts, error_cm)
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


def find_median(errors: ArrayLike) -> int:
    """Find whose error is the median one: of two in the middle the lower.

    >>> find_median([9.0, 1.0, 2.0, 3.0])
    2
    """
    return int(np.argsort(errors, kind="stable")[(np.size(errors) - 1) // 2])


def _searched_panel(
    experiment: Experiment, degrees: Array, policies: Mapping[str, Array]
) -> Panel:
    """Show the weight that varies most over the tasks."""
    weight = int(np.argmax(experiment.policies.std(axis=0)))
    searched = experiment.policies[:, weight]
    points = np.c_[np.rad2deg(experiment.tasks[:, 0]), searched]
    found = {name: some[:, weight] for name, some in policies.items()}
    return task_panel(
        "One policy weight over the task angle, with the chosen task marked.",
        widen(searched, 0.1),
        degrees,
        found,
        still=[Mark("dots", points, colour=COLOURS["searched"], width=1.2)],
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
    return task_panel(
        "The execution error over the task angle, with the chosen task marked.",
        (low, high),
        degrees,
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
