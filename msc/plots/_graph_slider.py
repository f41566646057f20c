"""Sliders over what finds the charts: the regularisation, and their number."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from sklearn.decomposition import PCA

from msc.learn import SMCE, elbow
from msc.plots._graph import CLOSE, edges, plot_graph
from msc.plots._slider import FLAT, TASK_AXIS, Mark, Panel, Slider, choose_ticks
from msc.plots._style import CHART_COLOURS, TRIO, WEIGHT_NAMES, chart_colour

ACROSS = TRIO[1]  # edges that join different curves
MAX_CHARTS = len(CHART_COLOURS)  # of a slider's steps, if it does not begin beyond
MARGIN = 0.06  # of a panel's range, around all points


def slide_regularization(
    points: NDArray[np.float64],
    curves: NDArray[np.intp],
    values: Sequence[float],
    *,
    first: int = 0,
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
    within = [
        points[graph[~one]].reshape(-1, 2)
        for graph, one in zip(graphs, across, strict=True)
    ]
    between = [
        points[graph[one]].reshape(-1, 2)
        for graph, one in zip(graphs, across, strict=True)
    ]
    marks = [
        Mark("segments", within, "step", width=1.0, opacity=0.5),
        Mark("segments", between, "step", width=1.5, colour=ACROSS),
        *_chart_dots(points, [fit.labels_ for fit in fits], 2, width=2.5),
    ]
    captions = [
        f"λ = {value:g}: {len(graph)} edges, {one.sum()} of them between the curves, "
        f"{_pieces(fit)}. {_verdict(fit.labels_, curves)}"
        for value, graph, one, fit in zip(values, graphs, across, fits, strict=True)
    ]
    x, y = _range(points[:, 0]), _range(points[:, 1])
    shape = float(np.ptp(y) / np.ptp(x))
    alt = "Points on two curves, coloured by chart, with the edges of their graph"
    return Slider(
        name="regularisation λ",
        labels=[f"λ = {value:g}" for value in values],
        captions=captions,
        panels=[
            Panel(f"{alt}.", x, y, marks, aspect=shape),
            Panel(
                f"{alt}, where the curves come nearest.",
                (-CLOSE, CLOSE),
                (-CLOSE * shape, CLOSE * shape),
                marks,
                aspect=shape,
            ),
        ],
        poster=plot_graph(points, fits[first], f"λ = {values[first]:g}"),
        poster_alt=f"{alt}. {captions[first]}",
        first=first,
        seconds=6.0,
        walks=True,
        legend=_legend(2) | {"edge between the curves": ACROSS},
    )


def slide_charts(
    tasks: NDArray[np.float64],
    policies: NDArray[np.float64],
    weight: int,
    *,
    first: int = 4,
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
    degrees, values = np.rad2deg(tasks[:, 0]), policies[:, weight]
    picked = elbow(curve)
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
            Panel(
                f"{alt}, with the edges of their graph.",
                _range(plane[:, 0]),
                _range(plane[:, 1]),
                [
                    Mark("segments", graph, width=1.0, opacity=0.4),
                    *_chart_dots(plane, labels, n_counts),
                ],
            ),
            Panel(
                "One policy weight over the task angle, coloured by chart.",
                (0, 360),
                _range(values),
                _chart_dots(np.c_[degrees, values], labels, n_counts, width=2.0),
                aspect=FLAT,
                **TASK_AXIS,
                y_label=f"policy weight {WEIGHT_NAMES[weight]}",
                y_ticks=choose_ticks(*_range(values)),
            ),
            _elbow_panel(curve, n_counts),
        ],
        poster=plot_graph(plane, fits[first - 1], f"{first} charts", "auto"),
        poster_alt=f"{alt}. {captions[first - 1]}",
        first=first - 1,
        seconds=6.0,
        walks=True,
        legend=_legend(n_counts),
    )


def _elbow_panel(curve: NDArray[np.float64], n_counts: int) -> Panel:
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
    points: NDArray[np.float64],
    labels: Sequence[NDArray[np.intp]],
    n_charts: int,
    width: float = 3.0,
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


def _range(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return bounds with a margin."""
    margin = MARGIN * np.ptp(values)
    return float(values.min() - margin), float(values.max() + margin)


def _legend(n_charts: int) -> dict[str, str]:
    """Name the colours of charts."""
    return {f"chart {k + 1}": chart_colour(k) for k in range(n_charts)}


def _pieces(fit: SMCE) -> str:
    """Say into how many pieces a graph falls."""
    n_pieces = connected_components(fit.affinity_matrix_, directed=False)[0]
    return "in one piece" if n_pieces == 1 else f"in {n_pieces} pieces"


def _verdict(labels: NDArray[np.intp], curves: NDArray[np.intp]) -> str:
    """Say whether charts are the curves."""
    wrong = np.mean(labels != curves)
    wrong = min(wrong, 1 - wrong)
    return (
        "The charts are the curves."
        if wrong == 0
        else (f"Charts and curves differ at {wrong:.0%} of the points.")
    )
