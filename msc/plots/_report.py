"""A fit of anybody's table in small panels, which narrow pages show one below another.

Names of columns are a stranger's: they are shown as they are, no formulas, if need be
shortened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, PercentFormatter
from numpy.typing import ArrayLike, NDArray

from msc.estimates import Estimate
from msc.plots._skill import draw_by_chart
from msc.plots._slider import FLAT, Mark, Panel, Slider, choose_ticks, poster
from msc.plots._style import (
    CHART_COLOURS,
    METHOD_STYLES,
    TRIO,
    Array,
    chart_colour,
    styled,
    widen,
)

SIZE = 3.7, 2.8  # inches: a panel, legible on a telephone
LETTERS = 30  # of a name in a picture
NEAR = TRIO[0]  # what the nearest rows are ringed in
SHOWN = 4  # policy columns of a slider

_INK = "0.15"
_RING = 0.012  # radius of a ring, of the panel's width
# Methods that have no look elsewhere.
LOOKS: dict[str, dict[str, Any]] = {
    "single, one kernel": {"color": CHART_COLOURS[3], "marker": "<", "ls": "--"},
    "charts, one kernel": {"color": CHART_COLOURS[1], "marker": ">", "ls": "-"},
    "charts, k-means": {"color": CHART_COLOURS[2], "marker": "p", "ls": "-"},
}
_OTHER: dict[str, Any] = {"color": "0.45", "marker": "h", "ls": "-"}

# Rows of a forest.
_RIVAL: dict[str, Any] = {
    "color": "0.35",
    "marker": "o",
    "mfc": "0.7",
    "ms": 5,
    "mew": 1,
}
_LEAST = _RIVAL | {"marker": "s", "mfc": "white", "label": "least error"}
_CHOSEN = _RIVAL | {"color": TRIO[0], "marker": "D", "mfc": TRIO[0], "ms": 7, "mew": 2}
_CHOSEN |= {"label": "recommended"}


@dataclass(frozen=True)
class Walk:
    """What a skill predicts along a line of tasks, and what is known beside it.

    Attributes
    ----------
    task : str
        Name of the task column that changes, with its unit.
    policies : sequence of str
        Names of the policy columns, with their units.
    places : ndarray of shape (n_steps,)
        The task column along the line.
    means, stds : ndarray of shape (n_steps, n_params)
        Predicted policies and their standard deviations, NaN where there are none.
    rows : ndarray of shape (n_rows, 1 + n_params)
        Solved tasks: that task column and the policies.
    charts : ndarray of int of shape (n_rows,)
        Chart of each.
    near : ndarray of shape (n_steps, n_near, 1 + n_params)
        The nearest solved tasks of each step, in the same columns.
    captions : sequence of str
        What is said of each step.
    """

    task: str
    policies: Sequence[str]
    places: Array
    means: Array
    stds: Array
    rows: Array
    charts: NDArray[np.intp]
    near: Array
    captions: Sequence[str]


def shorten(name: str, most: int = LETTERS) -> str:
    r"""Show a stranger's name as it is: no formula, on one line, if need be shortened.

    >>> shorten("cost\n in $ of $")
    'cost in \\$ of \\$'
    """
    seen = "".join(one if one.isprintable() else " " for one in name)
    line = " ".join(seen.split())
    return (line if len(line) <= most else line[: most - 1] + "…").replace("$", r"\$")


@styled
def plot_column(
    rows: Array,
    charts: ArrayLike,
    *,
    names: tuple[str, str],
    curve: tuple[Array, Array, Array],
    jumps: Sequence[float] = (),
) -> Figure:
    """Draw a policy column over the task column.

    Parameters
    ----------
    rows : ndarray of shape (n_rows, 2)
        Task and policy of solved tasks.
    charts : array_like of int of shape (n_rows,)
        Chart of each.
    names : tuple of str
        Of the task column and of the policy column.
    curve : tuple of ndarray, each of shape (n_steps,)
        Tasks, what is predicted for them, and its standard deviation; NaN: none.
    jumps : sequence of float, optional
        Tasks between which policies jump.

    Returns
    -------
    Figure
        Rows in the colours and with the marks of their charts; a line where the
        prediction is, grey two deviations to either side; dotted, the jumps.
    """
    figure, axis = plt.subplots(figsize=SIZE)
    places, mean, std = curve
    if np.isfinite(std).all():
        band: Any = {"color": "0.8", "lw": 0, "zorder": 1}
        axis.fill_between(places, mean - 2 * std, mean + 2 * std, **band)
    for jump in jumps:
        axis.axvline(jump, color="0.5", lw=0.8, ls=":", zorder=0)
    draw_by_chart(axis, rows, charts, ms=_size(rows), mew=0.2)
    axis.plot(places, mean, color=_INK, lw=1)
    axis.set(xlabel=shorten(names[0]), ylim=_span(rows[:, 1], 0.15))
    axis.set_title(shorten(names[1], 40), loc="left")
    _name_charts(figure, charts)
    return figure


@styled
def plot_plane(
    points: Array,
    *,
    names: tuple[str, str],
    title: str = "",
    charts: ArrayLike | None = None,
    values: Array | None = None,
    jumps: ArrayLike = (),
) -> Figure:
    """Draw something over two task columns, as a map.

    Parameters
    ----------
    points : ndarray of shape (n_rows, 2)
        Two columns of solved tasks.
    names : tuple of str
        Their names.
    title : str, optional
        What is drawn.
    charts : array_like of int of shape (n_rows,), optional
        Charts, drawn as colours and marks.
    values : ndarray of shape (n_rows,), optional
        Numbers, drawn the lighter the larger, if there are no charts.
    jumps : array_like of shape (n_jumps, 2, 2), optional
        Neighbours between which policies jump, joined by a line.

    Returns
    -------
    Figure
        The map.
    """
    figure, axis = plt.subplots(figsize=SIZE)
    if charts is not None:
        draw_by_chart(axis, points, charts, ms=_size(points), mew=0.2)
        _name_charts(figure, charts)
    else:
        look: Any = {"c": values, "cmap": "cividis", "s": _size(points) ** 2}
        dots = axis.scatter(*points.T, edgecolors="0.5", linewidths=0.2, **look)
        figure.colorbar(dots, ax=axis, ticks=MaxNLocator(5))
    for ends in np.asarray(jumps):
        axis.plot(*ends.T, color=TRIO[0], lw=1)
    axis.set(xlabel=shorten(names[0]), ylabel=shorten(names[1]))
    axis.set_title(shorten(title, 40), loc="left")
    return figure


@styled
def plot_elbow(curve: Sequence[float], n_charts: int) -> Figure:
    """Draw the curve of which the number of charts was read.

    Parameters
    ----------
    curve : sequence of float
        The sum of squares within charts, for one chart and more.
    n_charts : int
        How many were found.

    Returns
    -------
    Figure
        The curve as shares of its first value, and the number as a diamond.
    """
    figure, axis = plt.subplots(figsize=SIZE)
    shares = np.array(curve) / (curve[0] or 1.0)
    counts = np.arange(1, len(shares) + 1)
    axis.plot(counts, shares, "o-", color="0.45", ms=4)
    if n_charts <= len(shares):
        found = shares[n_charts - 1]
        axis.plot(n_charts, found, "D", color=TRIO[0], ms=8, label=f"found: {n_charts}")
        axis.legend()
    axis.set(xlabel="charts", ylabel="squares within charts", ylim=(0, None))
    axis.xaxis.set_major_locator(MaxNLocator(8, integer=True))
    return figure


@styled
def plot_errors(methods: Sequence[Mapping[str, Any]], chosen: str) -> Figure:
    """Draw errors of methods with their intervals, a row each.

    Parameters
    ----------
    methods : sequence of mapping
        Of a card, the simplest first: ``"method"``, ``"error"``, ``"low"``, ``"high"``.
    chosen : str
        Which is recommended.

    Returns
    -------
    Figure
        A forest: hollow the least error, filled what is recommended, at the dashed
        line; a logarithmic axis, where all are positive.
    """
    figure, axis = plt.subplots(figsize=(SIZE[0], 1.1 + 0.2 * len(methods)))
    least = min(methods, key=lambda one: one["error"])["method"]
    looks = {least: _LEAST, chosen: _CHOSEN}
    for row, one in enumerate(methods):
        error, look = Estimate.read(one, "error"), looks.get(one["method"], _RIVAL)
        axis.plot(error.bounds, (row, row), color=look["color"], lw=look["mew"])
        axis.plot(error.value, row, ls="", **look)
        if one["method"] == chosen:
            axis.axvline(error.value, color=look["color"], lw=0.8, ls="--", zorder=0)
    _log(axis, "x", [one[bound] for one in methods for bound in ("low", "high")])
    axis.set_yticks(range(len(methods)), [one["method"] for one in methods])
    axis.invert_yaxis()
    axis.set_xlabel("error (1: as far off as the mean)")
    figure.legend(loc="outside upper right", ncols=2)
    return figure


@styled
def plot_held(bands: Sequence[Mapping[str, float]]) -> Figure:
    """Draw how many policies bands held, over how many they should.

    Parameters
    ----------
    bands : sequence of mapping
        Of a card: ``"level"``, ``"held"``, ``"low"``, ``"high"``.

    Returns
    -------
    Figure
        Shares with intervals; on the dashed line bands hold what they say, below it
        they are too narrow.
    """
    figure, axis = plt.subplots(figsize=SIZE)
    axis.plot((0, 1), (0, 1), color="0.5", ls="--", lw=1)
    axis.text(0.24, 0.18, "too narrow", color="0.3", ha="left", va="top")
    axis.text(0.24, 0.3, "too wide", color="0.3", ha="right", va="bottom")
    for one in bands:
        axis.plot([one["level"]] * 2, [one["low"], one["high"]], color=TRIO[0], lw=1)
    levels = [one["level"] for one in bands]
    axis.plot(levels, [one["held"] for one in bands], "o-", color=TRIO[0], ms=5)
    axis.set(xlim=(0, 1.02), ylim=(0, 1.02))
    axis.set(xlabel="share that a band should hold", ylabel="share held")
    axis.xaxis.set_major_formatter(PercentFormatter(1))
    axis.yaxis.set_major_formatter(PercentFormatter(1))
    return figure


@styled
def plot_learning(curve: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw errors over how many tasks were learned from.

    Parameters
    ----------
    curve : sequence of mapping
        Of a card: ``"method"``, ``"n_tasks"``, ``"error"``.

    Returns
    -------
    Figure
        A line a method.
    """
    names = list(dict.fromkeys(one["method"] for one in curve))
    figure, axis = plt.subplots(figsize=(SIZE[0], SIZE[1] + 0.17 * len(names)))
    for name in names:
        points = [
            (one["n_tasks"], one["error"]) for one in curve if one["method"] == name
        ]
        look = _OTHER | METHOD_STYLES.get(name, LOOKS.get(name, {}))
        axis.plot(*zip(*points, strict=True), ms=4, label=name, **look)
    sizes = sorted({one["n_tasks"] for one in curve})
    axis.set(xlabel="tasks learned from", ylabel="error", xscale="log")
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xticks(sizes, [str(size) for size in sizes])
    _log(axis, "y", [one["error"] for one in curve])
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def slide_policies(walk: Walk) -> Slider:
    """Let the reader move along a task column, and see what is predicted.

    Parameters
    ----------
    walk : Walk
        What is predicted along it, and what is known.

    Returns
    -------
    Slider
        A panel a policy column, at most four: rows by chart, the prediction with its
        band, and at the chosen task the nearest rows, ringed.
    """
    first = len(walk.places) // 2
    n_charts = int(walk.charts.max()) + 1
    n_named = n_charts if n_charts <= len(CHART_COLOURS) else 0
    return Slider(
        name=walk.task,
        labels=[f"{walk.task} {place:.5g}" for place in walk.places],
        captions=walk.captions,
        panels=[_panel(walk, k) for k in range(min(SHOWN, len(walk.policies)))],
        poster=_draw_walk(walk, first),
        poster_alt=f"{walk.policies[0]} over {walk.task}. {walk.captions[first]}",
        first=first,
        walks=True,
        legend={f"chart {k + 1}": chart_colour(k) for k in range(n_named)}
        | {"nearest rows": NEAR},
    )


def _panel(walk: Walk, k: int) -> Panel:
    """Show a policy column over the task column."""
    x = widen(np.r_[walk.places, walk.rows[:, 0]], 0.03)
    low, high = _span(np.r_[walk.means[:, k], walk.rows[:, 1 + k]], 0.1)
    width: float = x[1] - x[0]

    def lift(values: ArrayLike) -> Array:
        """Bring policies to the width of the tasks: one scale serves both."""
        share: Array = np.clip((np.asarray(values) - low) / (high - low), 0, 1)
        return share * width

    def pairs(rows: Array) -> Array:
        return np.column_stack([rows[:, 0], lift(rows[:, 1 + k])])

    rows, mean, std = pairs(walk.rows), walk.means[:, k], walk.stds[:, k]
    marks = [
        Mark("dots", rows[walk.charts == chart], colour=chart_colour(chart), width=2.2)
        for chart in np.unique(walk.charts)
    ]
    marks.append(Mark("line", np.c_[walk.places, lift(mean)], width=1.2, opacity=0.8))
    if np.isfinite(std).all():
        edges = [lift(mean + sign * 2 * std) for sign in (-1, 1)]
        dashed: Any = {"width": 1.0, "opacity": 0.6, "dash": (4.0, 3.0)}
        marks += [Mark("line", np.c_[walk.places, edge], **dashed) for edge in edges]
        upright = np.stack([np.c_[walk.places, edge] for edge in edges], axis=1)
        marks.append(Mark("segments", upright, "step", width=2.5))
    near = [pairs(rows) for rows in walk.near]
    ring: Any = {"colour": NEAR, "width": 2.5, "radius": _RING * width}
    marks.append(Mark("ring", near, "step", **ring))
    marks.append(Mark("dots", np.c_[walk.places, lift(mean)][:, None], "step", width=5))
    ticks = choose_ticks(low, high)
    return Panel(
        f"{walk.policies[k]} over {walk.task}: solved tasks, what is predicted, and at "
        "the chosen task the nearest solved ones.",
        x,
        (0, width),
        marks,
        aspect=FLAT,
        x_label=_cut(walk.task),
        y_label=_cut(walk.policies[k]),
        x_ticks=choose_ticks(*x),
        y_ticks=tuple(lift(ticks).tolist()),
        y_names=tuple(f"{tick:g}" for tick in ticks),
    )


def _cut(name: str) -> str:
    """Shorten a name where there are no formulas."""
    return shorten(name).replace(r"\$", "$")


@poster
def _draw_walk(axis: Axes, walk: Walk, step: int) -> None:
    """Draw the first policy column over the task column, at one step."""
    mean, std = walk.means[:, 0], walk.stds[:, 0]
    if np.isfinite(std).all():
        band: Any = {"color": "0.8", "lw": 0, "zorder": 1}
        axis.fill_between(walk.places, mean - 2 * std, mean + 2 * std, **band)
    draw_by_chart(axis, walk.rows[:, :2], walk.charts, ms=_size(walk.rows), mew=0.2)
    axis.plot(walk.places, mean, color=_INK, lw=1, label="predicted")
    rings: Any = {"mfc": "none", "mec": NEAR, "ms": 9, "mew": 1.8}
    axis.plot(*walk.near[step, :, :2].T, "o", label="nearest rows", **rings)
    axis.plot(walk.places[step], mean[step], "o", color=_INK, ms=7)
    axis.set(xlabel=shorten(walk.task), ylim=_span(walk.rows[:, 1], 0.15))
    axis.set_title(shorten(walk.policies[0], 40), loc="left")
    axis.figure.legend(loc="outside lower center", ncols=3)


def _log(axis: Axes, which: str, values: Sequence[float]) -> None:
    """Make an axis logarithmic, with round numbers, if all values are positive."""
    if min(values) <= 0:
        return
    axis.set(**{f"{which}scale": "log"})
    ratio, one = max(values) / min(values), getattr(axis, f"{which}axis")
    subs = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8) if ratio < 4 else (1, 2, 5)
    one.set_major_locator(LogLocator(subs=subs if ratio < 50 else (1,)))
    one.set_major_formatter("{x:g}")
    one.set_minor_locator(NullLocator())


def _span(values: Array, share: float) -> tuple[float, float]:
    """Return bounds of values, apart even of those that are all alike."""
    low, high = widen(values, share)
    margin = 0.0 if high > low else 0.1 * (abs(low) or 1.0)
    return low - margin, high + margin


def _size(rows: Array) -> float:
    """Choose a mark's size by how many there are."""
    return 5.0 if len(rows) <= 60 else 4.0 if len(rows) <= 200 else 3.0


def _name_charts(figure: Figure, charts: ArrayLike) -> None:
    """Write a legend of charts, if there are several."""
    n_charts = len(np.unique(charts))
    if 1 < n_charts <= len(CHART_COLOURS):
        figure.legend(loc="outside lower center", ncols=3)
