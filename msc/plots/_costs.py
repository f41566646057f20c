"""What a rollout and a task cost, drawn from the benchmark's file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msc.plots._cost_tables import ROLLOUT_LIMIT
from msc.plots._style import SMALL, WORLD_STYLES, styled

_WAYS = {
    "mujoco": "MuJoCo, open loop",
    "raw_steps": "raw steps",
    "own_steps": "own steps",
    "search": "rollout in the search",
    "floats": "Python loop, floats",
    "naive": "Python loop, NumPy",
}
_Figures = Mapping[str, Any]


@styled
def plot_costs(
    figures: _Figures, tables: Mapping[str, pd.DataFrame] | None = None
) -> Figure:
    """Draw what a rollout costs, and how a task's search shrinks among others.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.
    tables : mapping from str to DataFrame, optional
        Searched policies of whole worlds, as `load_dataset` gives them.

    Returns
    -------
    Figure
        Left every way to do a rollout in units of its raw steps; right the rollouts
        that a task takes over the number of tasks searched together.
    """
    figure, (ways, growth) = plt.subplots(
        1, 2, figsize=(7.4, 3.5), width_ratios=(1.15, 1)
    )
    _draw_ways(ways, figures)
    _draw_growth(growth, figures, tables or {})
    return figure


def _draw_ways(axis: Axes, figures: _Figures) -> None:
    """Draw the times of a rollout, medians and the middle four fifths of rounds."""
    worlds = figures["rollouts"]
    ways = [
        way
        for way in reversed(_WAYS)
        if all(measured["milliseconds"][way] for measured in worlds.values())
    ]
    for number, (world, measured) in enumerate(worlds.items()):
        times = [measured["milliseconds"][way] for way in ways]
        low, middle, high = (
            np.array([time[key] for time in times]) for key in ("low", "median", "high")
        )
        raw = measured["milliseconds"]["raw_steps"]["median"]
        axis.errorbar(
            middle / raw,
            np.arange(len(ways)) + 0.24 * (0.5 - number),
            xerr=np.array([middle - low, high - middle]) / raw,
            ls="",
            ms=5,
            mec="white",
            mew=0.5,
            elinewidth=1.2,
            label=world,
            **WORLD_STYLES[world],
        )
    axis.axvline(ROLLOUT_LIMIT, color="0.3", lw=1, ls="--")
    axis.text(ROLLOUT_LIMIT, -0.4, f" {ROLLOUT_LIMIT:g} ×", fontsize=SMALL, va="bottom")
    axis.set_xscale("log")
    ticks = [tick for tick in (0.5, 1, 2, 5, 10, 20, 50) if _within(tick, axis)]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(ways)), [_WAYS[way] for way in ways])
    axis.set(ylim=(-0.5, len(ways) - 0.5), xlabel="time (multiples of raw steps)")
    axis.set_title("one rollout", loc="left")
    axis.legend(loc="upper right")


def _draw_growth(
    axis: Axes, figures: _Figures, tables: Mapping[str, pd.DataFrame]
) -> None:
    """Draw rollouts per task: alone, in the benchmark's circles, in the tables."""
    growth = figures["growth"]
    runs = sorted(
        {(run["n_tasks"], run["evaluations_per_task"]) for run in growth["runs"]}
    )
    look = WORLD_STYLES[growth["workspace"]]
    axis.plot(
        *np.transpose(runs),
        ms=5,
        label=f"{growth['workspace']}, benchmark's circle",
        **look,
    )
    for world, searched in figures["searches"].items():
        axis.plot(
            1,
            searched["evaluations_per_task"],
            ls="",
            mfc="none",
            label=f"{world}, one task alone",
            **WORLD_STYLES[world],
        )
    for world, table in tables.items():
        axis.plot(
            len(table),
            table["evaluations"].mean(),
            ls="",
            ms=8,
            mec="black",
            label=f"{world}, the data set",
            **WORLD_STYLES[world],
        )
    counts = sorted({1, *(n for n, _ in runs), *map(len, tables.values())})
    axis.set_xscale("log")
    axis.set_xticks(counts, [f"{count}" for count in counts])
    axis.set_xticks([], minor=True)
    axis.set(xlabel="tasks searched together", ylabel="rollouts per task")
    axis.set_title("one task", loc="left")
    axis.set_ylim(bottom=0)
    axis.figure.legend(
        *axis.get_legend_handles_labels(), ncols=3, loc="outside lower right"
    )


def _within(tick: float, axis: Axes) -> bool:
    """Whether a tick lies in the range of the x axis."""
    low, high = axis.get_xlim()
    return low <= tick <= high
