"""Pieces: where policies leap from one behaviour to another, and two to look at."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats


def find_jumps(
    tasks: ArrayLike, policies: ArrayLike, closed: bool = False
) -> NDArray[np.intp]:
    """Find the steps between neighbouring tasks that are too large to be smooth.

    Parameters
    ----------
    tasks : array_like of shape (n_tasks,) or (n_tasks, 1)
        Ascending task parameters, about evenly spaced: a step is not divided by the
        distance of its tasks, so that a gap between them looks like a jump.
    policies : array_like of shape (n_tasks, n_params)
        Their policies.
    closed : bool, default=False
        Whether the last task's neighbour is the first, as on a circle not cut open.

    Returns
    -------
    ndarray of int
        Indices i for which the step from task i to the next is a jump: larger than
        five times the median step, and than 0.3 times the policies' root-mean-square
        distance from their mean.

    Raises
    ------
    ValueError
        If the lengths differ, the tasks do not ascend or there are fewer than two.

    Notes
    -----
    A threshold only points: `msc audit` settles whether a step is a jump by searching
    the tasks in between.

    Examples
    --------
    >>> find_jumps(np.arange(6), [[0.0], [0.1], [0.2], [3.0], [3.1], [3.2]])
    array([2])
    """
    order, values = to_floats("tasks", tasks), to_floats("policies", policies)
    if order.ndim == 2 and order.shape[1] == 1:
        order = order[:, 0]
    if order.ndim != 1:
        raise ValueError(f"tasks has shape {order.shape}; wanted one number a task")
    if values.ndim != 2 or len(values) != len(order) or len(order) < 2:
        raise ValueError(
            f"policies has shape {values.shape} for {len(order)} tasks; wanted one row "
            "a task and at least two tasks"
        )
    if not np.isfinite(values).all():
        raise ValueError("policies has NaN or infinite entries; wanted numbers")
    if not (np.isfinite(order).all() and (np.diff(order) > 0).all()):
        raise ValueError(
            "tasks do not ascend; wanted them finite and sorted, without duplicates"
        )
    steps, threshold = step_sizes(values, closed=closed)
    return np.flatnonzero(steps > threshold)


def step_sizes(
    policies: ArrayLike, *, closed: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Measure the steps between neighbouring policies.

    Parameters
    ----------
    policies : array_like of shape (n_tasks, n_params)
        Policies in the order of their tasks.
    closed : bool, default=False
        Whether the last one's neighbour is the first.

    Returns
    -------
    steps : ndarray of shape (n_tasks - 1,), or (n_tasks,) if closed
        Distances from each policy to the next.
    threshold : float
        What a step must exceed to count as a jump, see `find_jumps`.

    Examples
    --------
    >>> step_sizes([[0.0], [0.1], [0.2], [3.0]])[0].round(1)
    array([0.1, 0.1, 2.8])
    """
    values = to_floats("policies", policies)
    after = np.roll(values, -1, axis=0)
    steps = np.linalg.norm(after - values, axis=1)[: None if closed else -1]
    spread = np.sqrt(np.mean(np.sum((values - values.mean(axis=0)) ** 2, axis=1)))
    return steps, float(max(5 * np.median(steps), 0.3 * spread))


def make_two_arcs(
    n_points: int = 60, gap: float = 0.045
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Place points on two arcs that nearly touch and bend away from each other.

    Parameters
    ----------
    n_points : int, default=60
        Points on each curve.
    gap : float, default=0.045
        How near the curves come; by default nearer than neighbours on a curve are.

    Returns
    -------
    points : ndarray of shape (2 * n_points, 2)
        First those of the upper curve, from left to right.
    curves : ndarray of shape (2 * n_points,)
        Which curve each belongs to: 0 or 1.

    Raises
    ------
    ValueError
        If there are too few points, or no gap.

    Examples
    --------
    >>> points, curves = make_two_arcs(5)
    >>> points.shape, curves.tolist()
    ((10, 2), [0, 0, 0, 0, 0, 1, 1, 1, 1, 1])
    """
    if n_points < 3 or gap <= 0:
        raise ValueError(
            f"n_points={n_points}, gap={gap}; wanted at least 3 and a gap above 0"
        )
    across = np.linspace(-1.6, 1.6, n_points)
    up = 0.45 * across**2 + gap / 2
    points = np.r_[np.c_[across, up], np.c_[across, -up]]
    return points, np.repeat(np.arange(2), n_points)
