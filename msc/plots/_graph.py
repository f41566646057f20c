"""Points that reconstruct each other, and what comes of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import scipy.sparse as sp
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from msc.learn import SMCE
from msc.plots._style import TRIO, chart_colour, chart_marker, styled

USED = 1e-6  # coefficients: smaller ones are not drawn
CLOSE = 0.35  # how far around a place a closer look shows
N_VALUES = 12  # eigenvalues shown


@styled
def plot_clusterings(
    points: NDArray[np.float64], found: Mapping[str, ArrayLike]
) -> Figure:
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
    figure, axes = plt.subplots(
        1, len(found), figsize=(7.4, 2.3), sharey=True, squeeze=False
    )
    for axis, (name, labels) in zip(axes.flat, found.items(), strict=True):
        _draw_points(axis, points, np.asarray(labels))
        axis.set_title(name)
    return figure


@styled
def plot_reconstruction(points: NDArray[np.float64], smce: SMCE, index: int) -> Figure:
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
    plane.set(xlim=(x - CLOSE, x + CLOSE), ylim=(y - CLOSE, y + CLOSE))
    plane.set(aspect="equal")
    plane.set_axis_off()
    plane.legend(loc="upper center", ncols=3, handletextpad=0.2)
    ranks = np.arange(1, len(near) + 1)
    bars.bar(ranks, penalties, color="0.8", label="penalty $q_j$ (Eq. 4)")
    bars.plot(ranks, coef[near], "o", color=blue, label="share $|c_j|$ (Eq. 3)")
    bars.set(xlabel="neighbours, nearest first", ylim=(0, None))
    bars.set_xticks(ranks[::3])
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
def plot_graph(
    points: NDArray[np.float64], smce: SMCE, title: str, aspect: str = "equal"
) -> Figure:
    """Draw points in the plane by chart, and the graph that joins them.

    Parameters
    ----------
    points : ndarray of shape (n_points, 2)
        Where the points are drawn.
    smce : SMCE
        Fitted to the points, in whatever space.
    title : str
        What is written above.
    aspect : {"equal", "auto"}, default="equal"
        Of the axes.

    Returns
    -------
    Figure
        One panel.
    """
    figure, axis = plt.subplots(figsize=(4.6, 3.4))
    _draw_edges(axis, points, edges(smce), "0.4")
    _draw_points(axis, points, smce.labels_, aspect)
    axis.set_title(title)
    return figure


def edges(smce: SMCE) -> NDArray[np.intp]:
    """List the pairs of points that reconstruct each other.

    Parameters
    ----------
    smce : SMCE
        Fitted.

    Returns
    -------
    ndarray of shape (n_edges, 2)
        Each pair once, the smaller index first.
    """
    upper = sp.triu(smce.affinity_matrix_, k=1).tocoo()
    return np.column_stack([upper.row, upper.col]).astype(np.intp)


def _draw_points(
    axis: Axes,
    points: NDArray[np.float64],
    labels: NDArray[np.intp],
    aspect: str = "equal",
) -> None:
    """Draw points by label."""
    for label in np.unique(labels):
        look: Any = {"color": chart_colour(label), "mec": "white", "mew": 0.3}
        here = points[labels == label]
        axis.plot(*here.T, chart_marker(label), ms=4, **look)
    axis.set(aspect=aspect)
    axis.set_axis_off()


def _draw_edges(
    axis: Axes, points: NDArray[np.float64], pairs: NDArray[np.intp], colour: str
) -> None:
    """Draw lines between pairs of points."""
    axis.add_collection(
        LineCollection(list(points[pairs]), colors=colour, linewidths=1.2, zorder=1)
    )
