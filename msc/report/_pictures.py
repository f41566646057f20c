"""Which pictures a report has: those of the book, of a table of anybody's."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image
from sklearn.decomposition import PCA
from sklearn.neighbors import NearestNeighbors

from msc.plots import (
    Walk,
    plot_column,
    plot_elbow,
    plot_errors,
    plot_graph,
    plot_held,
    plot_learning,
    plot_plane,
)
from msc.report._words import Card, percent, share, unit_of
from msc.skills import Fit, Table, list_breaks

Array = NDArray[np.float64]

MOST_TASKS = 5
"""Task columns that are drawn, by pairs."""

MOST_POLICIES = {1: 6, 2: 6, 3: 3, 4: 1, 5: 1}
"""By the number of task columns drawn, policy columns that are."""

_STEPS = 61  # of the slider
_FINE = 481  # places of a curve
_NEAR = 3  # rows that are ringed
_TOLD = 4  # policy columns of which a caption tells
_DPI = 200
_COLOURS = 128  # of a picture


@dataclass(frozen=True)
class Picture:
    """A figure, and what it shows in words."""

    figure: Figure
    alt: str

    def to_png(self) -> str:
        """Draw it, in base 64."""
        file = io.BytesIO()
        self.figure.savefig(file, format="png", dpi=_DPI)
        with Image.open(file) as image:
            few = image.convert("RGB").quantize(_COLOURS)  # a third of the bytes
        file = io.BytesIO()
        few.save(file, format="png", optimize=True)
        return base64.b64encode(file.getvalue()).decode()


class Scene:
    """A table, its fit, and the rows drawn: those that charts were found of."""

    def __init__(self, table: Table, fit: Fit) -> None:
        self.fit, self.card = fit, fit.card
        self.X, self.y = table.tasks.to_numpy(), table.policies.to_numpy()
        self.columns = table.tasks.columns
        self.tasks = [_named(one) for one in self.card["tasks"]]
        self.policies = [_named(one) for one in self.card["policies"]]
        self.shown = fit.paper.rows_
        self.charts = np.asarray(fit.paper.model_.charts_)

    def first(self, X: Array) -> Array:
        """Return the first task column, on its own turn of a circle."""
        scale = self.fit.skill.scale_
        period, low = scale.periods[0], scale.lows_[0]
        column = X[..., 0]
        return column if period is None else low + np.mod(column - low, period)

    def line(self, n_steps: int) -> Array:
        """Return tasks along the first column, all others at their medians."""
        scale = self.fit.skill.scale_
        tasks = np.tile(np.median(self.X, axis=0), (n_steps, 1))
        tasks[:, 0] = np.linspace(scale.lows_[0], scale.highs_[0], n_steps)
        return tasks

    def predict(self, tasks: Array) -> tuple[Array, Array]:
        """Predict policies and standard deviations of rows of numbers."""
        named = pd.DataFrame(tasks, columns=self.columns)
        means, stds = self.fit.skill.predict(named, return_std=True)
        return means, stds


def draw_policies(scene: Scene) -> Iterator[Picture]:
    """Draw policy columns over the one task column, or over pairs of them as maps."""
    n_tasks = min(len(scene.tasks), MOST_TASKS)
    shown = range(min(len(scene.policies), MOST_POLICIES[n_tasks]))
    X, y = scene.X[scene.shown], scene.y[scene.shown]
    if n_tasks == 1:
        places = scene.line(_FINE)
        means, stds = scene.predict(places)
        jumps = scene.first(_middles(scene.card)).tolist()
        for k in shown:
            figure = plot_column(
                np.c_[scene.first(X), y[:, k]],
                scene.charts,
                names=(scene.tasks[0], scene.policies[k]),
                curve=(places[:, 0], means[:, k], stds[:, k]),
                jumps=jumps,
            )
            yield Picture(
                figure,
                f"{scene.policies[k]} over {scene.tasks[0]}: rows by chart, the "
                f"prediction as a line, and {len(jumps)} breaks.",
            )
        return
    drawn: list[tuple[str, dict[str, Any]]] = [("charts", {"charts": scene.charts})]
    drawn += [(scene.policies[k], {"values": y[:, k]}) for k in shown]
    for title, what in drawn:
        for pair in combinations(range(n_tasks), 2):
            names = scene.tasks[pair[0]], scene.tasks[pair[1]]
            figure = plot_plane(X[:, pair], names=names, title=title, **what)
            yield Picture(figure, f"A map of {title} over {names[0]} and {names[1]}.")


def _middles(card: Card) -> Array:
    """Return the middles of breaks, as tasks of one column."""
    period = card["tasks"][0]["period"] or np.inf
    pairs = list_breaks(card, len(card["jumps"]["widest_jumps"]))
    middles = [low + (high - low) % period / 2 for low, high in pairs]
    return np.array(middles).reshape(-1, 1)


def draw_charts(scene: Scene) -> Iterator[Picture]:
    """Draw the graph of policies, by chart, and the elbow."""
    policies = scene.y[scene.shown]
    smce, found = scene.fit.paper.model_.clusterer_, scene.card["charts"]
    unit = (policies - policies.mean(axis=0)) / scene.fit.paper.spreads_
    if unit.shape[1] > 1:
        where = "in the plane"
        plane = PCA(2, svd_solver="full").fit_transform(unit)
        plane *= np.sign(plane[np.abs(plane).argmax(axis=0), [0, 1]])
    else:
        where = "over tasks"
        plane = np.c_[scene.first(scene.X[scene.shown]), unit[:, 0]]
    sizes = ", ".join(map(str, found["sizes"]))
    yield Picture(
        plot_graph(plane, smce, f"policies {where}", "auto"),
        f"Policies {where}, joined where they reconstruct each other: "
        f"{found['n_charts']} charts of {sizes}.",
    )
    yield Picture(
        plot_elbow(found["elbow_curve"], found["n_charts"]),
        "Squares within charts over the number of charts, which falls to the elbow at "
        f"{found['n_charts']}.",
    )


def draw_comparison(card: Card) -> Iterator[Picture]:
    """Draw errors of methods, what bands hold, and what more tasks are worth."""
    told = "; ".join(
        f"{one['method']} {share(one['error'])}" for one in card["methods"]
    )
    yield Picture(
        plot_errors(card["methods"], card["chosen"]),
        f"Errors of methods, squared, with intervals; as shares of the spread: {told}.",
    )
    if bands := card["held_out"]["bands"]:
        told = "; ".join(
            f"{percent(one['held'])} where {percent(one['level'])} should be"
            for one in bands
        )
        yield Picture(plot_held(bands), f"Policies that bands held: {told}.")
    if card["curve"]:
        sizes = sorted({one["n_tasks"] for one in card["curve"]})
        yield Picture(
            plot_learning(card["curve"]),
            f"Errors over the tasks learned from, {sizes[0]} to {sizes[-1]}.",
        )


def walk_along(scene: Scene) -> Walk:
    """Move along the first task column, the others at their medians."""
    tasks = scene.line(_STEPS)
    means, stds = scene.predict(tasks)
    scale = scene.fit.skill.scale_
    finder = NearestNeighbors(n_neighbors=_NEAR).fit(scale.transform(scene.X))
    near = finder.kneighbors(scale.transform(tasks), return_distance=False)
    all_rows = np.c_[scene.first(scene.X), scene.y]
    return Walk(
        task=scene.tasks[0],
        policies=scene.policies,
        places=tasks[:, 0],
        means=means,
        stds=stds,
        rows=all_rows[scene.shown],
        charts=scene.charts,
        near=all_rows[near],
        captions=[
            _caption(scene, task[0], mean, std, int(rows[0]))
            for task, mean, std, rows in zip(tasks, means, stds, near, strict=True)
        ],
    )


def _caption(scene: Scene, place: float, mean: Array, std: Array, row: int) -> str:
    """Say what is predicted at a place, and what the nearest row has."""
    told = [
        f"{name} {value:.4g}" + (f" ± {2 * doubt:.2g}" if np.isfinite(doubt) else "")
        for name, value, doubt in zip(scene.policies, mean, std, strict=True)
    ][:_TOLD]
    names = [*scene.tasks, *scene.policies[:_TOLD]]
    known = np.concatenate([scene.X[row], scene.y[row, :_TOLD]])
    near = ", ".join(
        f"{name} {value:.4g}" for name, value in zip(names, known, strict=True)
    )
    return (
        f"{scene.tasks[0]} {place:.4g}: {', '.join(told)}. Nearest is row {row + 1}: "
        f"{near}."
    )


def _named(column: Mapping[str, Any]) -> str:
    """Name a column with its unit."""
    unit = unit_of(column).strip()
    return f"{column['name']} ({unit})" if unit else str(column["name"])
