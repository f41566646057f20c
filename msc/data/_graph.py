"""Neighbouring tasks, whatever a task has: which ones, and where policies leap."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats

TURN = 2 * np.pi


def find_neighbors(
    tasks: ArrayLike, queries: ArrayLike, n_neighbors: int, *, closed: bool = True
) -> NDArray[np.intp]:
    """Find the tasks nearest to others.

    Parameters
    ----------
    tasks : array_like of shape (n_tasks, n_numbers)
        Tasks, the angle first (rad), all numbers in units of equal weight.
    queries : array_like of shape (n_queries, n_numbers)
        Whose neighbours to find.
    n_neighbors : int
        How many, at most all of them.
    closed : bool, default=True
        Whether angles go round.

    Returns
    -------
    ndarray of shape (n_queries, n_neighbors)
        Indices of tasks, the nearest first; a query that is a task is its own.

    Examples
    --------
    >>> find_neighbors([[0.0], [1.0], [6.0]], [[0.2]], 2)
    array([[0, 2]])
    """
    from scipy.spatial import KDTree  # noqa: PLC0415

    points, others = _in_turn(tasks), _in_turn(queries)
    box = [TURN if closed else 0.0] + [0.0] * (points.shape[1] - 1)
    tree = KDTree(points, boxsize=box)
    _, found = tree.query(others, k=range(1, min(n_neighbors, len(points)) + 1))
    return np.asarray(found, dtype=np.intp)


def task_edges(
    tasks: ArrayLike, n_neighbors: int | None = None, *, closed: bool = True
) -> NDArray[np.intp]:
    """Join each task with those nearest to it.

    Parameters
    ----------
    tasks : array_like of shape (n_tasks, n_numbers)
        Tasks, as for `find_neighbors`.
    n_neighbors : int, optional
        How many; by default two a number, which makes a ring of evenly spaced angles.
    closed : bool, default=True
        Whether angles go round.

    Returns
    -------
    ndarray of shape (n_edges, 2)
        Pairs of indices, the smaller first, each pair once.

    Examples
    --------
    >>> task_edges([[0.0], [1.5], [3.0], [4.7]]).tolist()
    [[0, 1], [0, 3], [1, 2], [2, 3]]
    """
    points = _in_turn(tasks)
    n_neighbors = n_neighbors or 2 * points.shape[1]
    found = find_neighbors(points, points, n_neighbors + 1, closed=closed)
    ends = np.repeat(np.arange(len(points)), found.shape[1])
    pairs = np.sort(np.stack([ends, found.ravel()], axis=1), axis=1)
    return np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)


def find_jump_edges(policies: ArrayLike, edges: ArrayLike) -> NDArray[np.intp]:
    """Find the edges between neighbouring tasks that are too large to be smooth.

    Parameters
    ----------
    policies : array_like of shape (n_tasks, n_params)
        Their policies.
    edges : array_like of shape (n_edges, 2)
        Pairs of neighbours, as `task_edges` gives them.

    Returns
    -------
    ndarray of int
        Which edges are jumps, by the threshold of `find_jumps`: longer than five times
        the median edge, and than 0.3 times the policies' root-mean-square distance
        from their mean.

    Examples
    --------
    >>> policies = [[0.0], [0.1], [0.2], [3.0], [3.1]]
    >>> find_jump_edges(policies, [[0, 1], [1, 2], [2, 3], [3, 4]])
    array([2])
    """
    values, pairs = to_floats("policies", policies), np.asarray(edges)
    steps = np.linalg.norm(values[pairs[:, 0]] - values[pairs[:, 1]], axis=1)
    spread = np.sqrt(np.mean(np.sum((values - values.mean(axis=0)) ** 2, axis=1)))
    return np.flatnonzero(steps > max(5 * np.median(steps), 0.3 * spread))


def find_pieces(n_tasks: int, edges: ArrayLike, jumps: ArrayLike) -> NDArray[np.intp]:
    """Tell which piece of the policies each task belongs to.

    Parameters
    ----------
    n_tasks : int
        How many tasks there are.
    edges : array_like of shape (n_edges, 2)
        Pairs of neighbours.
    jumps : array_like of int
        Which edges are jumps.

    Returns
    -------
    ndarray of shape (n_tasks,)
        Number of the piece, the largest one's 0: tasks are in the same one if edges
        that are no jumps lead from one to the other.

    Examples
    --------
    >>> find_pieces(5, [[0, 1], [1, 2], [2, 3], [3, 4]], [1])
    array([1, 1, 0, 0, 0])
    """
    from scipy.sparse import coo_array  # noqa: PLC0415
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    kept = np.delete(np.asarray(edges), np.asarray(jumps, dtype=int), axis=0)
    joined = coo_array((np.ones(len(kept)), kept.T), shape=(n_tasks, n_tasks))
    _, labels = connected_components(joined, directed=False)
    by_size = np.argsort(-np.bincount(labels), kind="stable")
    return np.asarray(np.argsort(by_size, kind="stable")[labels])


def _in_turn(tasks: ArrayLike) -> NDArray[np.float64]:
    """Return tasks with angles from 0 to below a turn."""
    points = np.array(to_floats("tasks", tasks), dtype=float)
    points[:, 0] %= TURN
    points[points[:, 0] >= TURN, 0] = 0.0  # rounded up to it
    return points
