"""The figures of the paper: policies over the tasks, and what executing them misses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.evaluation import Experiment
from msc.looks import CHART_COLOURS, COLOURS, chart_colour, chart_marker, styled
from msc.plots_world import WEIGHT_LABELS


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
        Left the single regression, right the charts.
    """
    if dimensions is None:
        dimensions = [int(np.argmax(experiment.policies.std(axis=0)))]
    height = 3.3 if len(dimensions) == 1 else 1.9 * len(dimensions)
    figure, axes = plt.subplots(
        len(dimensions),
        2,
        figsize=(7.4, height),
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    for (single, charts), dimension in zip(axes, dimensions, strict=True):
        _draw_manifold(single, charts, experiment, dimension)
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
    labels, chosen = experiment.methods["charts"].charts_, experiment.chosen
    trained = np.rad2deg(experiment.tasks[chosen, 0])
    values = experiment.policies[chosen, dimension]
    searched = experiment.policies[:, dimension]
    for axis in (single, charts):
        axis.plot(
            np.rad2deg(experiment.tasks[:, 0]),
            searched,
            ".",
            ms=2.5,
            color=COLOURS["searched"],
            label="searched",
        )
        _mark_jumps(axis, experiment)
        axis.set_xticks(range(0, 361, 60))
    dense = np.linspace(0, 2 * np.pi, 1441, endpoint=False)[:, None]
    draw: Any = {"dense": dense, "dimension": dimension, "experiment": experiment}
    one = np.zeros(len(dense), dtype=int)
    colour = COLOURS["single regression"]
    _draw_regression(single, "single regression", one, (colour,), **draw)
    single.plot(trained, values, "o", ms=3.5, color=colour, mec="white", mew=0.4)
    gate = experiment.methods["charts"].predict_chart(dense)
    _draw_regression(charts, "charts", gate, CHART_COLOURS, **draw)
    for chart in np.unique(labels):
        here = labels == chart
        charts.plot(
            trained[here],
            values[here],
            chart_marker(chart),
            ms=4,
            color=chart_colour(chart),
            mec="white",
            mew=0.4,
            label=f"chart {chart + 1}",
        )
    margin = 0.15 * np.ptp(searched)
    single.set_ylim(searched.min() - margin, searched.max() + margin)
    single.set_ylabel(f"policy weight {WEIGHT_LABELS[dimension]}")


def _draw_regression(
    axis: Axes,
    method: str,
    chart: NDArray[np.int_],
    colours: tuple[str, ...],
    *,
    dense: NDArray[np.float64],
    dimension: int,
    experiment: Experiment,
) -> None:
    """Draw a prediction and its band of two standard deviations, broken at charts."""
    mean, std = experiment.methods[method].predict(dense, return_std=True)
    mean, std = mean[:, dimension], std[:, dimension]
    angles = np.rad2deg(dense[:, 0])
    for piece in np.split(np.arange(len(dense)), np.flatnonzero(np.diff(chart)) + 1):
        colour = colours[chart[piece[0]] % len(colours)]
        axis.plot(angles[piece], mean[piece], color=colour)
        low, high = mean[piece] - 2 * std[piece], mean[piece] + 2 * std[piece]
        axis.fill_between(angles[piece], low, high, color=colour, alpha=0.15, lw=0)


@styled
def plot_execution(experiment: Experiment) -> Figure:
    """Draw the execution error over the tasks, as the paper's Figures 4 and 7.

    Parameters
    ----------
    experiment : Experiment
        What was trained on what.

    Returns
    -------
    Figure
        Top the single regression, bottom the charts; mean and standard deviation
        marked, tasks that met an obstacle crossed.
    """
    executed = experiment.executed
    figure, axes = plt.subplots(2, 1, figsize=(7.4, 4.6), sharex=True, sharey=True)
    for axis, method in zip(axes, ("single regression", "charts"), strict=True):
        rows = executed[executed["method"] == method]
        mean, std = rows["error_cm"].mean(), rows["error_cm"].std()
        axis.axhspan(max(0, mean - std), mean + std, color="0.9", lw=0, zorder=0)
        axis.axhline(mean, color="0.3", lw=1, ls="--")
        axis.vlines(
            rows["task_deg"], 0, rows["error_cm"], color=COLOURS[method], lw=2.5
        )
        met = rows[rows["touched"]]
        axis.plot(met["task_deg"], met["error_cm"], "kx", ms=5)
        _mark_jumps(axis, experiment)
        axis.set_title(f"{method}: {mean:.2f} ± {std:.2f} cm", loc="left")
        axis.set(ylabel="error (cm)", xticks=range(0, 361, 60), xlim=(-3, 363))
    axes[1].set_xlabel("task angle (degrees)")
    axes[0].set_ylim(bottom=0)
    return figure


def _mark_jumps(axis: Axes, experiment: Experiment) -> None:
    """Draw dotted lines where the policies jump."""
    for jump in experiment.jumps:
        place = np.rad2deg(experiment.tasks[jump : jump + 2, 0].mean())
        axis.axvline(place, color="0.5", lw=0.8, ls=":", zorder=0)
