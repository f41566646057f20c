"""Ratios with their intervals, drawn: a forest in place of a table of brackets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from msc.estimates import Estimate
from msc.plots._style import SMALL, styled
from msc.plots._tables import write_ratio

FARTHEST = 100.0  # an axis goes from one over this to this, at most
_LINE: Any = {"color": "0.55", "lw": 1, "zorder": 1}


@styled
def plot_ratios(ratios: pd.DataFrame, *, told: str = "charts") -> Figure:
    """Draw ratios and their intervals, a row each, one below the other.

    Parameters
    ----------
    ratios : DataFrame
        Estimates, as `find_ratios` returns them. A panel a column, their heads above
        and, if these have several levels, left; a line a row, NaN where there is none.
    told : str, default="charts"
        Whose error is divided by others'.

    Returns
    -------
    Figure
        All panels have one logarithmic axis with a line at one. The mark is that of
        `ratio_table`: a dot for lower, a cross for higher, a ring for undecided. What
        leaves the axis ends in an arrow, dark if it is decided. Ratios of a single
        column are also written.
    """
    heads = [head if isinstance(head, tuple) else (head,) for head in ratios.columns]
    rows: dict[Any, list[int]] = {}
    for number, head in enumerate(heads):
        rows.setdefault(head[:-1], []).append(number)
    shape = len(rows), max(map(len, rows.values()))
    size = 7.4, len(rows) * (0.35 + 0.19 * len(ratios)) + 0.45
    share: Any = {"sharex": True, "sharey": True, "squeeze": False}
    figure: Figure
    figure, axes = plt.subplots(*shape, figsize=size, **share)
    reach = _find_reach(ratios)
    for line, (group, numbers) in zip(axes, rows.items(), strict=True):
        line[0].set_ylabel("\n".join(part for part in group if part))
        for axis in line[len(numbers) :]:
            axis.set_axis_off()
        for axis, number in zip(line, numbers, strict=False):
            axis.set_title(heads[number][-1], loc="left")
            column = ratios.iloc[:, number].to_list()
            _draw_column(axis, column, reach, written=shape[1] == 1)
    axes[0, 0].set(xscale="log", xlim=(1 / reach, reach))
    axes[0, 0].set_yticks(-np.arange(len(ratios)), ratios.index, fontsize=SMALL)
    axes[0, 0].set_ylim(0.6 - len(ratios), 0.6)
    axes[0, 0].xaxis.set_major_locator(
        LogLocator(subs=(1,) if reach > 9 else (1, 2, 5))
    )
    axes[0, 0].xaxis.set_major_formatter("{x:g}")
    axes[0, 0].xaxis.set_minor_locator(NullLocator())
    what = f"error of {told}, as a multiple of the other's"
    figure.supxlabel(f"← {told} err less · {what} · more →", fontsize=9)
    return figure


def plot_comparisons(*found: Estimate) -> Figure:
    """Draw comparisons on one training set, one below the other.

    Parameters
    ----------
    *found : Estimate
        The charts with other methods, as `compare` returns them.

    Returns
    -------
    Figure
        As of `plot_ratios`.
    """
    several = len({one.baseline for one in found}) > 1
    rows = [
        f"{one.label}, over {one.baseline}" if several else one.label for one in found
    ]
    head = "" if several else f"over {found[0].baseline}"
    column = pd.Series([*found], index=rows, dtype=object)
    return plot_ratios(pd.DataFrame({head: column}))


def draw_ratio(axis: Axes, place: float, one: Estimate, reach: float = np.inf) -> None:
    """Draw a ratio with its interval into a panel, its mark as its sign.

    Parameters
    ----------
    axis : Axes
        The panel.
    place : float
        Its height there.
    one : Estimate
        The ratio.
    reach : float, optional
        How far the axis goes from one either way; farther ends are arrows.
    """
    is_open = one.verdict == "undecided"
    fill = "white" if is_open else "0.2"
    marker = "X" if one.verdict == "higher" else "o"
    low, high = np.clip(one.bounds, 1 / reach, reach)
    axis.plot((low, high), (place, place), **_LINE)
    arrow: Any = {
        "ls": "",
        "ms": 4,
        "color": "0.55" if is_open else "0.2",
        "clip_on": False,
    }
    for end, bound, mark in ((low, one.bounds[0], "<"), (high, one.bounds[1], ">")):
        if end != bound:
            axis.plot(end, place, mark, **arrow)
    if 1 / reach <= one.value <= reach:
        axis.plot(one.value, place, marker, ms=4.5, mfc=fill, mec="0.2", mew=0.8)


def _draw_column(
    axis: Axes, column: Sequence[Any], reach: float, *, written: bool
) -> None:
    """Draw a column of ratios, and beside them, if wanted, write them in figures."""
    axis.axvline(1, color="0.3", lw=1, ls="--", zorder=0)
    axis.grid(visible=False, axis="y")
    look: Any = {"va": "center", "fontsize": SMALL}
    for place, one in enumerate(column):
        if not isinstance(one, Estimate):
            axis.text(1, -place, "–", ha="center", color="0.4", **look)
            continue
        draw_ratio(axis, -place, one, reach)
        if written:
            beside = {"transform": axis.get_yaxis_transform(), **look}
            axis.text(1.02, -place, write_ratio(one), **beside)


def _find_reach(ratios: pd.DataFrame) -> float:
    """Find how far an axis goes from one, either way: to all ends, but not too far."""
    found = [one for one in ratios.to_numpy().flat if isinstance(one, Estimate)]
    ends = [end for one in found for end in (one.value, *one.bounds)]
    logs = np.abs(np.log([end for end in ends if 0 < end < np.inf]))
    return float(np.clip(1.1 * np.exp(logs.max(initial=0.0)), 2, FARTHEST))
