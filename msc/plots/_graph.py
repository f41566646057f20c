"""Points that reconstruct each other, and what comes of it: figures, and sliders.

The sliders change what finds the charts: the regularisation, and their number.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import scipy.sparse as sp
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from sklearn.decomposition import PCA

from msc.learn import SMCE, elbow
from msc.plots._skill import draw_by_chart
from msc.plots._slider import FLAT, TASK_AXIS, Mark, Panel, Slider, choose_ticks
from msc.plots._style import (
    CHART_COLOURS,
    TRIO,
    WEIGHT_NAMES,
    Array,
    chart_colour,
    styled,
    widen,
)

USED = 1e-6  # coefficients: smaller ones are not drawn
CLOSE = 0.35  # how far around a place a closer look shows
N_VALUES = 12  # eigenvalues shown
ACROSS = TRIO[1]  # edges that join different curves
MAX_CHARTS = len(CHART_COLOURS)  # of a slider's steps, if it does not begin beyond
MARGIN = 0.06  # of a slider's range, around all points
DOTS: Any = {"ms": 4, "mew": 0.3}


@styled
def plot_clusterings(points: Array, found: Mapping[str, ArrayLike]) -> Figure:
    """Draw what several ways to cluster make of the same points.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2)
        Points in the plane.
    found : mapping from str to array_like of shape (n_points,)
        Labels by the name of the way.

    Returns
    -------
    Figure
        One panel a way, points coloured and shaped by label.
    """
    figure, axes = plt.subplots(1, len(found), figsize=(7.4, 2.3), sharey=True)
    for axis, (name, labels) in zip(np.ravel(axes), found.items(), strict=True):
        draw_by_chart(axis, points, np.asarray(labels), **DOTS)
        axis.set(aspect="equal", title=name)
        axis.set_axis_off()
    return figure


@styled
def plot_reconstruction(points: Array, smce: SMCE, index: int) -> Figure:
    """Draw from which neighbours a point is reconstructed, and how much each counts.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2)
        Points in the plane.
    smce : SMCE
        Fitted to them.
    index : int
        Which point.

    Returns
    -------
    Figure
        Left the point, its neighbours as rings, those that it is made of joined to it;
        right the neighbours' penalties (Eq. 4) and coefficients (Eq. 3), nearest first.
    """
    coef = np.abs(smce.coef_[[index]].toarray()[0])
    distances = np.linalg.norm(points - points[index], axis=1)
    near = np.argsort(distances, kind="stable")[1 : smce.n_neighbors + 1]
    penalties = distances[near] / distances[near].sum()  # Eq. 4
    used, blue = near[coef[near] > USED], TRIO[0]
    figure, (plane, bars) = plt.subplots(
        1, 2, figsize=(7.4, 3.0), width_ratios=(1, 1.2)
    )
    plane.plot(*points.T, ".", color="0.7", ms=4)
    plane.plot(*points[near].T, "o", mfc="none", mec="0.45", ms=8, label="nearest")
    _draw_edges(plane, points, np.c_[np.full(len(used), index), used], blue)
    plane.plot(*points[used].T, "o", color=blue, ms=8, label="used")
    plane.plot(*points[index], "k*", ms=12, label="the point")
    x, y = points[index]
    plane.set(xlim=(x - CLOSE, x + CLOSE), ylim=(y - CLOSE, y + CLOSE), aspect="equal")
    plane.set_axis_off()
    plane.legend(loc="upper center", ncols=3, handletextpad=0.2)
    ranks = np.arange(1, len(near) + 1)
    bars.bar(ranks, penalties, color="0.8", label="penalty $q_j$ (Eq. 4)")
    bars.plot(ranks, coef[near], "o", color=blue, label="share $|c_j|$ (Eq. 3)")
    bars.set(xlabel="neighbours, nearest first", ylim=(0, None), xticks=ranks[::3])
    bars.legend()
    return figure


@styled
def plot_affinity(smce: SMCE) -> Figure:
    """Draw the affinity matrix, and the eigenvalues that tell its pieces.

    Parameters
    ----------
    smce : SMCE
        Fitted to policies in the order of their tasks.

    Returns
    -------
    Figure
        Left a dot for every pair that has an affinity, coloured by chart where both are
        in the same one; right the least eigenvalues of the Laplacian.
    """
    pairs = smce.affinity_matrix_.tocoo()
    labels, values = smce.labels_, smce.eigenvalues_[:N_VALUES]
    figure, (matrix, spectrum) = plt.subplots(
        1, 2, figsize=(7.4, 3.4), width_ratios=(1, 1.1)
    )
    same = labels[pairs.row] == labels[pairs.col]
    matrix.plot(pairs.col[~same], pairs.row[~same], ".", ms=2, color="black")
    for chart in range(smce.n_clusters_):
        here = same & (labels[pairs.row] == chart)
        colour = chart_colour(chart)
        matrix.plot(pairs.col[here], pairs.row[here], ".", ms=2, color=colour)
    matrix.set(aspect="equal", xlabel="policy", ylabel="policy")
    matrix.invert_yaxis()
    matrix.set_title("affinity matrix $M$")
    spectrum.plot(np.arange(1, len(values) + 1), values, "o", color="0.35")
    spectrum.set(xlabel="number", ylabel="eigenvalue")
    spectrum.set_title("least eigenvalues of the Laplacian")
    return figure


@styled
def plot_graph(points: Array, smce: SMCE, title: str, aspect: str = "equal") -> Figure:
    """Draw points in the plane, fitted in whatever space, by chart, and their graph.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2)
        Where to draw them.
    smce : SMCE
        Fitted to them, in whatever space.
    title : str
        What is written above.
    aspect : str, default="equal"
        How height goes with width, as Matplotlib has it.

    Returns
    -------
    Figure
        Points in the colours and with the marks of their charts, and lines between
        those that reconstruct each other.
    """
    figure, axis = plt.subplots(figsize=(4.6, 3.4))
    _draw_edges(axis, points, edges(smce), "0.4")
    draw_by_chart(axis, points, smce.labels_, **DOTS)
    axis.set(aspect=aspect, title=title)
    axis.set_axis_off()
    return figure


def edges(smce: SMCE) -> NDArray[np.intp]:
    """List the pairs of points that reconstruct each other, the smaller index first."""
    upper = sp.triu(smce.affinity_matrix_, k=1).tocoo()
    return np.column_stack([upper.row, upper.col]).astype(np.intp)


def slide_regularization(
    points: Array, curves: NDArray[np.intp], values: Sequence[float], *, first: int = 0
) -> Slider:
    """Let the reader change λ, and see the graph and the charts of points in the plane.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2)
        Points in the plane.
    curves : ndarray of shape (n_points,)
        Which curve each belongs to: 0 or 1. SMCE is not told.
    values : sequence of float
        What `regularization` is set to.
    first : int, default=0
        The step shown at first.

    Returns
    -------
    Slider
        Two panels: all points, and those around the origin.
    """
    with warnings.catch_warnings():  # with some values it falls apart: one sees it
        warnings.filterwarnings("ignore", "The graph has", UserWarning)
        fits = [
            SMCE(2, regularization=value, max_clusters=1, random_state=0).fit(points)
            for value in values
        ]
    graphs = [edges(fit) for fit in fits]
    across = [curves[graph[:, 0]] != curves[graph[:, 1]] for graph in graphs]
    pairs = list(zip(graphs, across, strict=True))
    within = [points[graph[~apart]].reshape(-1, 2) for graph, apart in pairs]
    between = [points[graph[apart]].reshape(-1, 2) for graph, apart in pairs]
    marks = [
        Mark("segments", within, "step", width=1.0, opacity=0.5),
        Mark("segments", between, "step", width=1.5, colour=ACROSS),
        *_chart_dots(points, [fit.labels_ for fit in fits], 2, width=2.5),
    ]
    captions = [
        f"λ = {value:g}: {len(apart)} edges, {apart.sum()} of them between the curves, "
        f"{_pieces(fit)}. {_verdict(fit.labels_, curves)}"
        for value, apart, fit in zip(values, across, fits, strict=True)
    ]
    x, y = (widen(values, MARGIN) for values in points.T)
    shape = float(np.ptp(y) / np.ptp(x))
    near = (-CLOSE, CLOSE), (-CLOSE * shape, CLOSE * shape)
    alt = "Points on two curves, coloured by chart, with the edges of their graph"
    return Slider(
        name="regularisation λ",
        labels=[f"λ = {value:g}" for value in values],
        captions=captions,
        panels=[
            Panel(f"{alt}.", x, y, marks, aspect=shape),
            Panel(f"{alt}, where the curves come nearest.", *near, marks, aspect=shape),
        ],
        poster=plot_graph(points, fits[first], f"λ = {values[first]:g}"),
        poster_alt=f"{alt}. {captions[first]}",
        first=first,
        walks=True,
        legend=_legend(2) | {"edge between the curves": ACROSS},
    )


def slide_charts(
    tasks: Array, policies: Array, weight: int, *, first: int = 4
) -> Slider:
    """Let the reader change the number of charts.

    Parameters
    ----------
    tasks : ndarray of shape (n_tasks, 1)
        Tasks (rad).
    policies : ndarray of shape (n_tasks, n_params)
        Their policies.
    weight : int
        Which weight is shown over the tasks.
    first : int, default=4
        The number of charts shown at first; the slider goes as far at least. Beyond
        the last colour of charts the colours come again.

    Returns
    -------
    Slider
        Three panels: the policies in the plane in which they vary most, with the graph
        that SMCE makes of them; one weight over the tasks; and the squares within
        charts, of which the elbow is read.
    """
    n_counts = max(MAX_CHARTS, first)
    counts = range(1, n_counts + 1)
    fits = [SMCE(count, random_state=0).fit(policies) for count in counts]
    labels, curve = [fit.labels_ for fit in fits], fits[0].elbow_curve_
    plane = PCA(2).fit_transform(policies)
    plane *= np.sign(plane[np.abs(plane).argmax(axis=0), [0, 1]])
    graph = plane[edges(fits[0])].reshape(-1, 2)
    marks = [Mark("segments", graph, width=1.0, opacity=0.4)]
    marks += _chart_dots(plane, labels, n_counts)
    degrees, values = np.rad2deg(tasks[:, 0]), policies[:, weight]
    span, picked = widen(values, MARGIN), elbow(curve)
    across, along = (widen(places, MARGIN) for places in plane.T)
    captions = [
        f"{count} chart{'s' if count > 1 else ''}, of "
        f"{', '.join(str(size) for size in np.bincount(found))} policies."
        f"{' Here the elbow is.' if count == picked else ''}"
        for count, found in zip(counts, labels, strict=True)
    ]
    alt = "Policies in the plane in which they vary most, coloured by chart"
    return Slider(
        name="number of charts S",
        labels=[f"{count} charts" for count in counts],
        captions=captions,
        panels=[
            Panel(f"{alt}, with the edges of their graph.", across, along, marks),
            Panel(
                "One policy weight over the task angle, coloured by chart.",
                (0, 360),
                span,
                _chart_dots(np.c_[degrees, values], labels, n_counts, width=2.0),
                aspect=FLAT,
                **TASK_AXIS,
                y_label=f"policy weight {WEIGHT_NAMES[weight]}",
                y_ticks=choose_ticks(*span),
            ),
            _elbow_panel(curve, n_counts),
        ],
        poster=plot_graph(plane, fits[first - 1], f"{first} charts", "auto"),
        poster_alt=f"{alt}. {captions[first - 1]}",
        first=first - 1,
        walks=True,
        legend=_legend(n_counts),
    )


def _draw_edges(
    axis: Axes, points: Array, pairs: NDArray[np.intp], colour: str
) -> None:
    """Draw lines between pairs of points."""
    look: Any = {"colors": colour, "linewidths": 1.2, "zorder": 1}
    axis.add_collection(LineCollection(list(points[pairs]), **look))


def _elbow_panel(curve: Array, n_counts: int) -> Panel:
    """Show the squares within charts over the number of charts, as shares of one's."""
    points = np.c_[np.arange(1, len(curve) + 1), curve / curve[0]]
    return Panel(
        "The sum of squares within charts over the number of charts.",
        (0.5, len(curve) + 0.5),
        (0.0, 1.05),
        [
            Mark("line", points, opacity=0.6),
            Mark("line", points[[0, -1]], width=1.0, opacity=0.4, dash=(4, 3)),
            Mark("dots", points[:n_counts, None], "step", width=5.0),
        ],
        aspect=FLAT,
        x_label="charts",
        y_label="squares within charts",
        x_ticks=tuple(range(1, len(curve) + 1)),
        y_ticks=(0, 0.5, 1),
    )


def _chart_dots(
    points: Array, labels: Sequence[NDArray[np.intp]], n_charts: int, width: float = 3.0
) -> list[Mark]:
    """Place a mark of dots a chart, one shape a step."""
    return [
        Mark(
            "dots",
            [points[found == chart] for found in labels],
            "step",
            colour=chart_colour(chart),
            width=width,
        )
        for chart in range(n_charts)
    ]


def _legend(n_charts: int) -> dict[str, str]:
    """Name the colours of charts."""
    return {f"chart {k + 1}": chart_colour(k) for k in range(n_charts)}


def _pieces(fit: SMCE) -> str:
    """Say into how many pieces a graph falls."""
    n_pieces = fit.n_components_
    return "in one piece" if n_pieces == 1 else f"in {n_pieces} pieces"


def _verdict(labels: NDArray[np.intp], curves: NDArray[np.intp]) -> str:
    """Say whether charts are the curves."""
    wrong = np.mean(labels != curves)
    wrong = min(wrong, 1 - wrong)
    if wrong == 0:
        return "The charts are the curves."
    return f"Charts and curves differ at {wrong:.0%} of the points."
