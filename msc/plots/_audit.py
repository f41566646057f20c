"""Figures on the quality of the searched policies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from sklearn.decomposition import PCA

from msc.data import WEIGHTS, find_jumps, step_sizes
from msc.plots._style import TRIO, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LOOK: Any = {"color": TRIO[0], "ms": 2.5, "lw": 0}
_FAINT: Any = {"color": TRIO[1], "ms": 2.5, "lw": 0}


@styled
def plot_quality(*tables: pd.DataFrame, names: tuple[str, ...]) -> Figure:
    """Draw what the searches found over the circle: cost, agreement, steps, contacts.

    Parameters
    ----------
    *tables : DataFrame
        Tables of searched policies, one column of panels each.
    names : tuple of str
        Their titles.

    Returns
    -------
    Figure
        The drawing.
    """
    rows = (_draw_cost, _draw_agreement, _draw_steps, _draw_contacts)
    figure, axes = plt.subplots(
        len(rows),
        len(tables),
        figsize=(3.6 * len(tables), 7.4),
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    for column, table, name in zip(axes.T, tables, names, strict=True):
        jumps = find_jumps(table["task_deg"], table[list(WEIGHTS)])
        for axis, draw in zip(column, rows, strict=True):
            for jump in jumps:
                where = table["task_deg"].iloc[jump : jump + 2].mean()
                axis.axvline(where, color="0.6", ls=":", lw=1)
            draw(axis, table)
            if axis not in axes[:, 0]:
                axis.set_ylabel("")
        column[0].set_title(name)
        column[-1].set(xlabel="task angle (degrees)", xticks=range(0, 361, 90))
    axes[0, 0].legend(markerscale=2)
    return figure


def _draw_cost(axis: Axes, table: pd.DataFrame) -> None:
    other = table["cost"] + table["margin"]
    axis.plot(table["task_deg"], other, "^", **_FAINT, label="best other")
    axis.plot(table["task_deg"], table["cost"], "o", **_LOOK, label="stored")
    axis.set(ylabel="cost", ylim=(0, 1.6 * table["cost"].max()))


def _draw_agreement(axis: Axes, table: pd.DataFrame) -> None:
    share = 100 * table["starts_agreeing"] / table["starts"]
    axis.plot(table["task_deg"], share, "o", **_LOOK)
    axis.set(ylabel="starts that agree (%)", ylim=(0, 104))


def _draw_steps(axis: Axes, table: pd.DataFrame) -> None:
    steps, threshold = step_sizes(table[list(WEIGHTS)], closed=True)
    after = table["task_deg"] + np.diff(table["task_deg"], append=360) / 2
    axis.semilogy(after[:-1], steps[:-1], "o", **_LOOK)
    axis.semilogy(after.iloc[-1:], steps[-1:], "D", mfc="none", color="black", ms=5)
    axis.annotate(
        "across the cut",
        (after.iloc[-1], steps[-1]),
        (-6, 0),
        textcoords="offset points",
        ha="right",
        va="center",
    )
    axis.axhline(threshold, color="0.3", ls="--", lw=1)
    axis.set(ylabel="step to the next policy")


def _draw_contacts(axis: Axes, table: pd.DataFrame) -> None:
    axis.plot(table["task_deg"], table["contact_impulse_n_s"], "o", **_LOOK)
    axis.set(ylabel="contact impulse (N s)")


@styled
def plot_curves(*tables: pd.DataFrame, names: tuple[str, ...]) -> Figure:
    """Draw the manifolds in the policies' first two principal components.

    Parameters
    ----------
    *tables : DataFrame
        Tables of searched policies, one panel each.
    names : tuple of str
        Their titles.

    Returns
    -------
    Figure
        The drawing: colour is the task angle, dashed lines are jumps, the dash-dotted
        one closes the circle across the cut.
    """
    figure, axes = plt.subplots(
        1, len(tables), figsize=(3.6 * len(tables), 3.4), squeeze=False
    )
    for axis, table, name in zip(axes[0], tables, names, strict=True):
        flat = PCA(2).fit_transform(table[list(WEIGHTS)].to_numpy())
        for jump in find_jumps(table["task_deg"], table[list(WEIGHTS)]):
            axis.plot(*flat[jump : jump + 2].T, "--", color="0.5", lw=1)
        axis.plot(*flat[[-1, 0]].T, "-.", color="black", lw=1)
        points = axis.scatter(
            *flat.T, c=table["task_deg"], cmap="viridis", s=9, zorder=3
        )
        for place, across in ((0, -1), (-1, 1)):  # below left, above right
            angle = table["task_deg"].iloc[place]
            axis.annotate(
                f"{angle:g}°",
                flat[place],
                (5 * across, 5 * across),
                textcoords="offset points",
                ha="left" if across > 0 else "right",
                va="bottom" if across > 0 else "top",
                fontweight="bold",
                path_effects=[withStroke(linewidth=2.5, foreground="white")],
                zorder=4,
            )
        axis.set(title=name, xlabel="1st component")
    axes[0, 0].set_ylabel("2nd component")
    figure.colorbar(points, ax=axes, label="task angle (degrees)", shrink=0.9)
    return figure
