"""One policy weight over the tasks, as skills and other learners predict it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.learn import ParameterizedSkill
from msc.plots._style import COLOURS, METHOD_STYLES, chart_colour, chart_marker, styled
from msc.plots._world import WEIGHT_LABELS

DENSE = np.linspace(0, 2 * np.pi, 721, endpoint=False)[:, None]  # tasks (rad)


@styled
def plot_rivals(
    learners: Mapping[str, Any],
    tasks: NDArray[np.float64],
    policies: NDArray[np.float64],
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
    searched = policies[:, weight]
    figure, axes = plt.subplots(
        1, len(learners), figsize=(7.4, 2.9), sharex=True, sharey=True
    )
    for axis, (name, learner) in zip(axes, learners.items(), strict=True):
        dots: Any = {"ms": 2.5, "color": COLOURS["searched"]}
        axis.plot(np.rad2deg(tasks[:, 0]), searched, ".", **dots)
        if getattr(learner, "n_charts_", 1) > 1:
            trained = tasks[chosen], policies[chosen]
            draw_charts(axis, learner, *trained, weight=weight)
        else:
            _draw_single(axis, learner, weight, COLOURS[name])
            at = np.rad2deg(tasks[chosen, 0]), searched[chosen]
            look: Any = {"color": COLOURS[name], "mec": "white", "mew": 0.4}
            axis.plot(*at, METHOD_STYLES[name]["marker"], ms=4, **look)
        axis.set(title=name, xticks=range(0, 361, 120))
        axis.set_xlabel("task angle (degrees)")
    margin = 0.15 * np.ptp(searched)
    axes[0].set_ylim(searched.min() - margin, searched.max() + margin)
    axes[0].set_ylabel(f"policy weight {WEIGHT_LABELS[weight]}")
    return figure


def draw_charts(
    axis: Axes,
    skill: ParameterizedSkill,
    tasks: NDArray[np.float64],
    policies: NDArray[np.float64],
    *,
    weight: int,
    only: int | None = None,
) -> None:
    """Draw a weight over the tasks, with bands of two standard deviations, by chart.

    Parameters
    ----------
    axis : Axes
        The panel.
    skill : ParameterizedSkill
        The skill, fitted.
    tasks : ndarray of shape (n_tasks, 1)
        What it was trained on (rad).
    policies : ndarray of shape (n_tasks, n_params)
        Their policies.
    weight : int
        The policy dimension.
    only : int, optional
        A chart that stands out while the others are pale; by default none does.
    """
    gate = skill.predict_chart(DENSE)
    mean, std = (both[:, weight] for both in skill.predict(DENSE, return_std=True))
    angles = np.rad2deg(DENSE[:, 0])
    for piece in np.split(np.arange(len(gate)), np.flatnonzero(np.diff(gate)) + 1):
        chart = gate[piece[0]]
        pale = 1.0 if only in (None, chart) else 0.3
        look: Any = {"color": chart_colour(chart)}
        axis.plot(angles[piece], mean[piece], alpha=pale, **look)
        edges = mean[piece] - 2 * std[piece], mean[piece] + 2 * std[piece]
        axis.fill_between(angles[piece], *edges, alpha=0.2 * pale, lw=0, **look)
    for chart in np.unique(skill.charts_):
        here = skill.charts_ == chart
        axis.plot(
            np.rad2deg(tasks[here, 0]),
            policies[here, weight],
            chart_marker(chart),
            color=chart_colour(chart),
            alpha=1.0 if only in (None, chart) else 0.4,
            ms=5,
            mec="white",
            mew=0.4,
        )
    span = np.ptp(policies[:, weight])
    low, high = policies[:, weight].min(), policies[:, weight].max()
    axis.set_ylim(low - 0.25 * span, high + 0.25 * span)


def _draw_single(axis: Axes, learner: Any, weight: int, colour: str) -> None:
    """Draw one regression over all tasks; its band, if it has one in these units."""
    angles = np.rad2deg(DENSE[:, 0])
    mean = learner.predict(DENSE)[:, weight]
    axis.plot(angles, mean, color=colour)
    if isinstance(learner, ParameterizedSkill):
        std = learner.predict(DENSE, return_std=True)[1][:, weight]
        edges = mean - 2 * std, mean + 2 * std
        axis.fill_between(angles, *edges, color=colour, alpha=0.15, lw=0)
