"""What predicting saves: rollouts until a search is near enough, and in all."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msc.plots._style import COLOURS, SMALL, styled
from msc.plots._tables import WORLD_TITLES, Stored, lay_out
from msc.study import ONCE, SCRATCH

_MOST = 100  # tasks to solve, that are drawn


@styled
def plot_savings(*found: Stored) -> Figure:
    """Draw what searches from predictions take, and what all tasks together take.

    Parameters
    ----------
    *found : dict
        Results of `msc.study.run_savings`, one column of panels each.

    Returns
    -------
    Figure
        Above, a row a method: the mean number of rollouts until the cost is within
        1.05 times (filled) and 1.01 times (hollow) that of the task's searched policy;
        a search that never is goes on from scratch and pays for both. Below, rollouts
        until within 1.05 times, so paid, over the number of tasks to solve: each from
        scratch; or 24 others so, and each from what is predicted from these.
    """
    figure, axes = plt.subplots(
        2, len(found), figsize=(7.4, 5.6), squeeze=False, sharey="row"
    )
    for (above, below), one in zip(axes.T, found, strict=True):
        summary = pd.DataFrame(one["summary"])
        names = list(summary["method"].unique())
        for factor, rows in summary.groupby("factor", sort=False):
            is_near = factor == min(summary["factor"])
            look: Any = {"mfc": "white"} if is_near else {}
            places = -np.arange(len(rows))
            label = f"within {factor:g} × the searched cost"
            look |= {"ls": "", "marker": "o", "ms": 5, "label": label}
            above.plot(rows["mean_rollouts"], places, color=COLOURS["charts"], **look)
        above.set_yticks(-np.arange(len(names)), names, fontsize=SMALL)
        above.set(xscale="log", xlabel="rollouts until near enough", xlim=(0.7, 500))
        above.set_title(WORLD_TITLES[one["workspace"]], loc="left")
        _draw_budgets(below, one, summary)
    axes[1, 0].set_ylabel("rollouts in all")
    axes[0, 0].legend(loc="center right")
    axes[1, 0].legend(loc="upper left")
    axes[1, 0].set_ylim(bottom=0)
    return figure


def _draw_budgets(axis: Any, one: Stored, summary: pd.DataFrame) -> None:
    """Draw what so many tasks take, by searches alone and from predictions."""
    near = summary[summary["factor"] == max(summary["factor"])].set_index("method")
    spent = near["mean_rollouts"].drop(ONCE)
    scratch, n_trained = spent.pop(SCRATCH), one["n_samples"]
    n_tasks = np.arange(_MOST + 1)
    axis.plot(n_tasks, n_tasks * scratch, color="0.3", ls="--", label=SCRATCH)
    for name, paid in spent.items():
        look: Any = {"color": "0.7", "lw": 1}
        if name == "charts":
            look["label"] = f"{n_trained} others, then from predictions"
            look |= {"color": COLOURS["charts"], "zorder": 3}
        axis.plot(n_tasks, n_trained * scratch + n_tasks * paid, **look)
    even = {row["method"]: row["tasks"] for row in one["break_even"]}["charts"]
    told = "never cheaper" if even is None else f"cheaper from {even:.0f} on"
    axis.text(
        0.98,
        0.03,
        f"charts: {told}",
        transform=axis.transAxes,
        ha="right",
        fontsize=SMALL,
    )
    axis.set(xlabel="tasks to solve", xlim=(0, None))


def savings_table(*found: Stored) -> pd.DataFrame:
    """Show what searches from predictions come to.

    Parameters
    ----------
    *found : dict
        Results of `msc.study.run_savings`.

    Returns
    -------
    DataFrame
        One row a method; of each world the first rollout's median cost over the
        searched one, rollouts until within 1.05 times the searched cost (median, mean),
        the share of tasks that end in a worse basin, and the rollouts till a search
        ends by itself.
    """
    heads = {
        "jump_start": "first cost (median), × searched",
        "median_rollouts": "rollouts to 1.05 ×, median",
        "mean_rollouts": "mean",
        "worse_basin": "worse basin (%)",
        "mean_spent": "rollouts till it ends",
    }
    columns = {}
    for one in found:
        summary = pd.DataFrame(one["summary"]).set_index("method")
        wide = summary[summary["factor"] == max(summary["factor"])]
        for key, head in heads.items():
            scale = 100 if key == "worse_basin" else 1
            values = scale * wide[key].astype(float)
            columns[WORLD_TITLES[one["workspace"]], head] = [
                "never" if np.isnan(value) else float(value) for value in values
            ]
        index = wide.index
    table = lay_out(columns)
    table.index = index
    return table
