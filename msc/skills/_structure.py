"""What policies look like over their tasks: jumps, pieces, charts."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import find_jump_edges, find_pieces, task_edges
from msc.skills._scale import TaskScale
from msc.skills._skill import TableSkill
from msc.skills._subsample import spread_out
from msc.skills._table import Table

Array = NDArray[np.float64]

MOST_TASKS = 2000
"""Different tasks among which jumps are sought; of more, so many."""

_SHOWN = 20  # jumps that a card holds
_STEEP = 5.0  # median slopes: less is no jump, but a gap between tasks
_NARROW = 6.0  # width of the first column: less than the turn that `task_edges` knows


def find_structure(table: Table, policies: Array, scale: TaskScale, seed: int) -> Any:
    """Find where neighbouring tasks have policies far apart.

    Parameters
    ----------
    table : Table
        Tasks; of equal ones policies are averaged.
    policies : ndarray of shape (n_rows, n_params)
        Policies of unit spread.
    scale : TaskScale
        Fitted to the tasks.
    seed : int
        Draws tasks if there are too many.

    Returns
    -------
    dict
        Fit for JSON: how many tasks were looked at, ``"n_jumps"``, the widest of them
        as pairs of tasks, and the sizes of the pieces between them; ``"least_jump"``,
        how far apart policies of neighbours as far apart as the median have to be to
        count, over the policies' spread.

    Notes
    -----
    A jump is what `msc.find_jumps` calls one, if it is also five times steeper than the
    median step: a table's tasks may lie anywhere, and a gap between them is no jump.
    Tasks of one number have those on either side for neighbours, on a circle all round;
    of several, twice as many as columns.
    """
    _, first, place = np.unique(table.copies, return_index=True, return_inverse=True)
    sums = np.zeros((len(first), policies.shape[1]))
    np.add.at(sums, place, policies)
    means = sums / np.bincount(place)[:, None]
    tasks = table.tasks.to_numpy()[first]
    some = spread_out(scale.transform(tasks), MOST_TASKS, seed)
    tasks, means = tasks[some], means[some]
    edges = _edges(tasks, scale)
    lengths = np.linalg.norm(
        np.diff(scale.transform(tasks)[edges], axis=1)[:, 0], axis=1
    )
    steps = np.linalg.norm(np.diff(means[edges], axis=1)[:, 0], axis=1)
    slope = _STEEP * np.median(steps / lengths)
    is_steep = steps > slope * lengths
    jumps = find_jump_edges(means, edges)
    spread = np.sqrt(means.var(axis=0).sum()) or 1.0
    least = max(0.3 * spread, 5 * np.median(steps), slope * np.median(lengths))
    jumps = jumps[is_steep[jumps]]
    pieces = np.bincount(find_pieces(len(tasks), edges, jumps))
    widest = edges[jumps[np.argsort(-steps[jumps], kind="stable")[:_SHOWN]]]
    return {
        "n_tasks": len(tasks),
        "n_jumps": len(jumps),
        "n_edges": len(edges),
        "least_jump": float(f"{least / spread:.6g}"),
        "widest_jumps": [tasks[pair].tolist() for pair in widest],
        "pieces": pieces.tolist(),
    }


def _edges(tasks: Array, scale: TaskScale) -> NDArray[np.intp]:
    """Join neighbouring tasks."""
    n_tasks, n_columns = tasks.shape
    if n_columns == 1:
        order = np.argsort(scale.flatten(tasks)[:, 0], kind="stable")
        ring = np.stack([order, np.roll(order, -1)], axis=1)
        is_closed = scale.periods[0] is not None and n_tasks > 2
        return np.sort(ring if is_closed else ring[:-1], axis=1)
    points = scale.transform(tasks)
    points -= points.min(axis=0)
    points *= _NARROW / max(points[:, 0].max(), 1e-12)
    return task_edges(points, 2 * n_columns, closed=False)


def describe_charts(skill: TableSkill) -> dict[str, Any]:
    """Tell the charts that the paper's skill found: how many, how large, and why."""
    charts = skill.model_
    return {
        "n_charts": charts.n_charts_,
        "sizes": np.bincount(charts.charts_).tolist(),
        "elbow_curve": [float(f"{one:.6g}") for one in charts.clusterer_.elbow_curve_],
        "n_components": int(charts.clusterer_.n_components_),
        "n_tasks": len(skill.rows_),
    }
