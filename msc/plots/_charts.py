"""The number of charts: tables and figure of the readings of the elbow, and the gates.

`msc evaluate` writes the files, one a workspace; see `msc.study.measure_elbows`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from msc.learn import SELECTION_CRITERIA
from msc.plots._style import SMALL, TRIO, styled
from msc.study import most_picked

PAPER_N_CHARTS = 4  # charts, in either workspace

_Measured = Mapping[str, Any]


def elbow_table(*elbows: _Measured, count: int = PAPER_N_CHARTS) -> pd.DataFrame:
    """List which number of charts every reading picks, and how firmly.

    Parameters
    ----------
    *elbows : dict
        What `msc evaluate` wrote, one a workspace.
    count : int, default=4
        The number whose share is told.

    Returns
    -------
    DataFrame
        One row a reading; for each workspace the number picked on all tasks, the share
        of the parts on which it picks `count`, and the number it picks most often with
        the share of that, the last number considered excepted.
    """
    columns: dict[tuple[str, str], list[str]] = {}
    names = tuple(SELECTION_CRITERIA)
    for measured in elbows:
        readings, n_parts = measured["readings"], measured["n_resamples"]
        world = measured["workspace"]
        most = [most_picked(measured, name) for name in names]
        times = [readings[name]["resampled"].get(f"{count}", 0) for name in names]
        columns[world, "picks"] = [f"{readings[name]['picked']}" for name in names]
        columns[world, f"picks {count}"] = [f"{n / n_parts:.0%}" for n in times]
        columns[world, "most often"] = [f"{n} ({share:.0%})" for n, share in most]
    return pd.DataFrame(columns, index=list(SELECTION_CRITERIA.values()))


@styled
def plot_elbows(*elbows: _Measured) -> Figure:
    """Draw the curves that an elbow may be read from, and what is picked.

    Parameters
    ----------
    *elbows : dict
        What `msc evaluate` wrote, one a workspace.

    Returns
    -------
    Figure
        One row a reading, one column a workspace: the curve over the number of charts,
        scaled to its range; the number picked as a diamond; as bars, the share of the
        parts of the data on which each number is picked; dotted, the paper's number.
    """
    figure, axes = plt.subplots(
        len(SELECTION_CRITERIA),
        len(elbows),
        figsize=(7.4, 1.45 * len(SELECTION_CRITERIA) + 0.4),
        sharex="col",
        sharey=True,
        squeeze=False,
    )
    for column, measured in zip(axes.T, elbows, strict=True):
        for axis, (name, label) in zip(column, SELECTION_CRITERIA.items(), strict=True):
            _draw_reading(axis, measured["readings"][name])
            axis.set_title(label, loc="left", fontsize=SMALL)
        column[0].set_title(measured["workspace"], loc="right", fontweight="bold")
        column[-1].set_xlabel("charts")
    named = axes[0, 0].get_legend_handles_labels()
    figure.legend(*named, loc="outside lower center", ncols=4)
    figure.supylabel("share of the parts; curve, scaled", fontsize=9)
    return figure


def gate_table(*elbows: _Measured) -> pd.DataFrame:
    """Show how often each gate tells a held-out task's chart.

    Parameters
    ----------
    *elbows : dict
        What `msc evaluate` wrote, one a workspace.

    Returns
    -------
    DataFrame
        One row a workspace and number of training tasks: the number of training sets,
        and for each gate its mean accuracy and on how many sets it is the best, ties
        going to the first.
    """
    rows = {}
    for measured in elbows:
        for found in measured["gates"]:
            accuracy, best = found["accuracy"], found["best"]
            rows[measured["workspace"], found["n_samples"]] = {
                "training sets": found["repetitions"],
                **{name: f"{accuracy[name]:.2f} ({best[name]})" for name in accuracy},
            }
    table = pd.DataFrame.from_dict(rows, orient="index")
    table.index = pd.MultiIndex.from_tuples(rows, names=["world", "training tasks"])
    return table


def _draw_reading(axis: Axes, reading: Mapping[str, Any]) -> None:
    """Draw one curve, its pick, and the picks on parts of the data."""
    curve, picked = np.array(reading["curve"]), reading["picked"]
    counts = np.arange(1, len(curve) + 1)
    height = (curve - curve.min()) / (np.ptp(curve) or 1.0)
    times = np.array([reading["resampled"].get(f"{count}", 0) for count in counts])
    axis.bar(
        counts,
        times / max(times.sum(), 1),
        color="0.78",
        label="share of the parts that pick it",
    )
    axis.axvline(PAPER_N_CHARTS, color="0.3", ls=":", lw=1, label="the paper's number")
    axis.plot(
        counts, height, "o-", ms=3, color=TRIO[0], label="curve, scaled to its range"
    )
    axis.plot(
        picked,
        height[picked - 1],
        "D",
        ms=7,
        color=TRIO[1],
        mec="black",
        label="picked on all tasks",
    )
    axis.yaxis.set_major_formatter(PercentFormatter(1))
    axis.set_axisbelow(True)
    axis.set(ylim=(-0.08, 1.08), yticks=(0, 0.5, 1), xticks=counts)
