"""Figures of what was stored: studies of many training sets, elbows, audits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import NullLocator, PercentFormatter
from numpy.typing import NDArray
from sklearn.decomposition import PCA

from msc.data import WEIGHTS, find_jumps, step_sizes
from msc.learn import SELECTION_CRITERIA
from msc.plots._style import COLOURS, COUNT_STYLES, METHOD_STYLES, SMALL, TRIO, styled
from msc.plots._tables import PAPER_N_CHARTS, SIGNS, WORLD_TITLES, Stored, comparisons
from msc.study import MEASURES

PAPER_METHODS = ("charts", "CrKr", "single regression")  # of Figure 8

_LOOK: Any = {"color": TRIO[0], "ms": 2.5, "lw": 0}
_FAINT: Any = {"color": TRIO[1], "ms": 2.5, "lw": 0}


@styled
def plot_sample_sizes(
    *studies: Stored,
    measures: Sequence[str] = ("mse, gate learned",),
    methods: Sequence[str] = PAPER_METHODS,
    design: str = "even",
    verdicts: bool = True,
    common: bool = True,
) -> Figure:
    """Draw errors over the number of training tasks, as the paper's Figure 8.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`, one column of panels each.
    measures : sequence of str, default=("mse, gate learned",)
        One row of panels each.
    methods : sequence of str, default=PAPER_METHODS
        The lines.
    design : {"even", "uniform", "nonuniform"}, default="even"
        How training tasks were drawn.
    verdicts : bool, default=True
        Whether to write, below each panel, whether the charts' error is lower (●),
        higher (✕) or undecided (○) against each other method at each size.
    common : bool, default=True
        Whether all panels of a row have the same scale, as in the paper.

    Returns
    -------
    Figure
        The drawing; bands reach from the best training set to the worst.
    """
    height = 3.0 * len(measures) + 0.6
    figure, axes = _panels(studies, measures, height, common=common)
    for column, study in zip(axes.T, studies, strict=True):
        cells = [cell for cell in study["cells"] if cell["design"] == design]
        for axis, measure in zip(column, measures, strict=True):
            for method in methods:
                look = {"over": "n_samples", "label": method, **METHOD_STYLES[method]}
                _draw_line(axis, cells, measure, method, **look)
            axis.set(xscale="log", yscale="log")
            if verdicts:
                _draw_verdicts(axis, study, design, measure, methods[1:])
        sizes = [cell["n_samples"] for cell in cells]
        column[-1].set_xlabel("training tasks")
        column[-1].xaxis.set_minor_locator(NullLocator())
        column[-1].set_xticks(sizes, [str(size) for size in sizes], fontsize=SMALL)
    axes[0, -1].legend()
    return figure


@styled
def plot_sweep(*studies: Stored, measures: Sequence[str]) -> Figure:
    """Draw the charts' errors over the number of charts.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`, one column of panels each.
    measures : sequence of str
        One row of panels each.

    Returns
    -------
    Figure
        The drawing; one line a number of training tasks, bands as in
        `plot_sample_sizes`.
    """
    figure, axes = _panels(studies, measures, 2.6 * len(measures))
    for column, study in zip(axes.T, studies, strict=True):
        sizes, counts = (
            sorted({cell[name] for cell in study["sweep"]})
            for name in ("n_samples", "n_charts")
        )
        for axis, measure in zip(column, measures, strict=True):
            for n_samples, look in zip(sizes, COUNT_STYLES, strict=False):
                cells = [c for c in study["sweep"] if c["n_samples"] == n_samples]
                more = {"over": "n_charts", "label": str(n_samples), **look}
                _draw_line(axis, cells, measure, "charts", **more)
            axis.set_yscale("log")
        column[-1].set(xlabel="charts", xticks=counts)
    axes[0, -1].legend(title="training tasks")
    return figure


def _grid(
    n_rows: int, n_columns: int, size: tuple[float, float], **share: Any
) -> tuple[Figure, NDArray[Any]]:
    """Make panels with one x axis, unless told otherwise; a row has one y axis."""
    share = {"sharex": True, "sharey": "row", **share}
    return plt.subplots(n_rows, n_columns, figsize=size, squeeze=False, **share)


def _panels(
    studies: Sequence[Stored],
    measures: Sequence[str],
    height: float,
    *,
    common: bool = True,
) -> tuple[Figure, NDArray[Any]]:
    """Lay out one row of panels a measure, on one scale, and one column a study."""
    size, share = (3.7 * len(studies), height), {"sharey": "row" if common else False}
    figure, axes = _grid(len(measures), len(studies), size, **share)
    for axis, study in zip(axes[0], studies, strict=True):
        axis.set_title(WORLD_TITLES[study["workspace"]])
    for axis, measure in zip(axes[:, 0], measures, strict=True):
        axis.set_ylabel(MEASURES[measure].axis)
    return figure, axes


def _draw_line(
    axis: Axes,
    cells: Sequence[Stored],
    measure: str,
    method: str,
    *,
    over: str,
    **look: Any,
) -> None:
    """Draw a method's means, if any, as a line, the range over the sets as a band."""
    here = [cell for cell in cells if method in cell["measures"].get(measure, {})]
    if here:
        places = [cell[over] for cell in here]
        found = pd.DataFrame([cell["measures"][measure][method] for cell in here])
        axis.plot(places, found["mean"], ms=4, **look)
        band: Any = {"color": look["color"], "alpha": 0.15, "lw": 0}
        sets = found["per_repetition"]
        axis.fill_between(places, sets.map(min), sets.map(max), **band)


def _draw_verdicts(
    axis: Axes, study: Stored, design: str, measure: str, baselines: Sequence[str]
) -> None:
    """Write, below a panel, the verdict on the charts at each size."""
    below = axis.get_xaxis_transform()
    for row, baseline in enumerate(baselines):
        height = -0.07 * (row + 1)
        look: Any = {"color": COLOURS[baseline], "fontsize": SMALL, "va": "center"}
        ratios = comparisons(study, measure, baseline, design=design)
        for n_samples, ratio in ratios.items():
            sign = SIGNS[ratio.verdict]
            axis.text(n_samples, height, sign, transform=below, ha="center", **look)
        place_in_grid: Any = axis.get_subplotspec()
        if place_in_grid.is_first_col():
            beside, text = axis.transAxes, f"vs {baseline} "
            dark = look | {"color": "0.2"}  # a name has to be read
            axis.text(-0.02, height, text, transform=beside, ha="right", **dark)
    axis.tick_params(axis="x", pad=4 + 15 * len(baselines))


@styled
def plot_elbows(*elbows: Stored) -> Figure:
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
    n_rows = len(SELECTION_CRITERIA)
    size = 7.4, 1.45 * n_rows + 0.4
    figure, axes = _grid(n_rows, len(elbows), size, sharex="col", sharey=True)
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


def _draw_reading(axis: Axes, reading: Mapping[str, Any]) -> None:
    """Draw one curve, its pick, and the picks on parts of the data."""
    curve, picked = np.array(reading["curve"]), reading["picked"]
    counts = np.arange(1, len(curve) + 1)
    height = (curve - curve.min()) / (np.ptp(curve) or 1.0)
    times = np.array([reading["resampled"].get(f"{count}", 0) for count in counts])
    shares, named = times / max(times.sum(), 1), "share of the parts that pick it"
    axis.bar(counts, shares, color="0.78", label=named)
    axis.axvline(PAPER_N_CHARTS, color="0.3", ls=":", lw=1, label="the paper's number")
    look: Any = {"ms": 3, "color": TRIO[0], "label": "curve, scaled to its range"}
    axis.plot(counts, height, "o-", **look)
    look = {"ms": 7, "color": TRIO[1], "mec": "black", "label": "picked on all tasks"}
    axis.plot(picked, height[picked - 1], "D", **look)
    axis.yaxis.set_major_formatter(PercentFormatter(1))
    axis.set_axisbelow(True)
    axis.set(ylim=(-0.08, 1.08), yticks=(0, 0.5, 1), xticks=counts)


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
    figure, axes = _grid(len(rows), len(tables), (3.6 * len(tables), 7.4))
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
    beside: Any = {"textcoords": "offset points", "ha": "right", "va": "center"}
    axis.annotate("across the cut", (after.iloc[-1], steps[-1]), (-6, 0), **beside)
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
        degrees = table["task_deg"]
        points = axis.scatter(*flat.T, c=degrees, cmap="viridis", s=9, zorder=3)
        look: Any = {"textcoords": "offset points", "fontweight": "bold", "zorder": 4}
        look |= {"path_effects": [withStroke(linewidth=2.5, foreground="white")]}
        ends = (0, -5, "right", "top"), (-1, 5, "left", "bottom")
        for place, off, ha, va in ends:
            text = f"{degrees.iloc[place]:g}°"
            axis.annotate(text, flat[place], (off, off), ha=ha, va=va, **look)
        axis.set(title=name, xlabel="1st component")
    axes[0, 0].set_ylabel("2nd component")
    figure.colorbar(points, ax=axes, label="task angle (degrees)", shrink=0.9)
    return figure
