"""Which of the searched tasks are trained on: three designs, drawn many times."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import check_whole, to_floats

DESIGNS = ("even", "uniform", "nonuniform")
TEST_SUBSETS = ("gate learned", "chart known", "away from jumps", "beside jumps")

Indices = NDArray[np.intp]


def draw_samples(
    design: str, tasks: ArrayLike, n_samples: int, *, n_draws: int = 1, seed: int = 0
) -> list[Indices]:
    """Draw training sets from a grid of tasks.

    Parameters
    ----------
    design : {"even", "uniform", "nonuniform"}
        "even": evenly spaced, to within a step of the grid, each set from another
        first task. "uniform": any set is as likely as any other. "nonuniform": task
        after task, each with the probability that `task_density` gives it among those
        not yet drawn.
    tasks : array_like of shape (n_tasks,) or (n_tasks, 1)
        The grid: ascending task angles in [0, 2π) (rad).
    n_samples : int
        Tasks in a set.
    n_draws : int, default=1
        Sets. "even" gives no set twice, hence no more than there are first tasks.
        Those drawn at random are independent of each other: on a small grid a set may
        come twice. They are no more than there are different ones.
    seed : int, default=0
        Seed of the draws. Set k does not depend on how many are drawn.

    Returns
    -------
    list of ndarray of shape (n_samples,)
        Indices of the tasks, ascending; no set holds a task twice.

    Raises
    ------
    ValueError
        If the design is another, there are too few tasks, samples or draws, or a task
        is no angle in [0, 2π).

    Examples
    --------
    >>> tasks = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    >>> draw_samples("even", tasks, 4, n_draws=30)
    [array([ 2,  5,  8, 11]), array([0, 3, 6, 9]), array([ 1,  4,  7, 10])]
    """
    angles = _check_angles(tasks)
    n_tasks = len(angles)
    if design not in DESIGNS:
        raise ValueError(f"design={design!r}; wanted one of {DESIGNS}")
    check_whole("n_samples", n_samples, 2, n_tasks)
    check_whole("n_draws", n_draws, 1)
    key = (seed, DESIGNS.index(design), n_samples)
    if design == "even":
        steps = n_tasks * np.arange(n_samples) // n_samples
        n_firsts = n_tasks - steps[-1]  # any further one leaves the grid
        firsts = np.random.default_rng(key).permutation(n_firsts)
        return [steps + first for first in firsts[:n_draws]]
    weights = task_density(angles) if design == "nonuniform" else np.ones(n_tasks)
    return [
        np.sort(
            np.random.default_rng((*key, number)).choice(
                n_tasks, n_samples, replace=False, p=weights / weights.sum()
            )
        )
        for number in range(min(n_draws, comb(n_tasks, n_samples)))
    ]


def task_density(tasks: ArrayLike) -> NDArray[np.float64]:
    """Say how often a task occurs, in the nonuniform design.

    Parameters
    ----------
    tasks : array_like
        Task angles (rad).

    Returns
    -------
    ndarray of the same shape
        P(τ) = (1 + 0.8 cos(τ - π)) / 2π: nine times as often opposite the cut as
        beside it (1/rad).

    Examples
    --------
    >>> task_density([np.pi]) / task_density([0.0])
    array([9.])
    """
    return np.asarray((1 + 0.8 * np.cos(np.asarray(tasks) - np.pi)) / (2 * np.pi))


def take_evenly(tasks: ArrayLike, n_samples: int) -> Indices:
    """Pick tasks evenly spaced over the circle, each the nearest there is.

    Parameters
    ----------
    tasks : array_like of shape (n_tasks, 1) or (n_tasks,)
        Ascending task angles in [0, 2π) (rad).
    n_samples : int
        How many to pick.

    Returns
    -------
    ndarray of shape (n_samples,)
        Their indices, ascending.

    Raises
    ------
    ValueError
        If a task would be picked twice or is no angle in [0, 2π), or fewer than two
        are asked for.

    Examples
    --------
    >>> take_evenly(np.linspace(0, 2 * np.pi, 12, endpoint=False), 4)
    array([0, 3, 6, 9])
    """
    angles = _check_angles(tasks)
    check_whole("n_samples", n_samples, 2)
    wanted = angles[0] + 2 * np.pi * np.arange(n_samples) / n_samples
    chosen = np.abs(angles - wanted[:, None]).argmin(axis=1)
    if len(np.unique(chosen)) < n_samples:
        raise ValueError(
            f"n_samples={n_samples} takes some of the {len(angles)} tasks twice; "
            f"wanted at most {len(angles)}"
        )
    return np.asarray(chosen)


def nearest_task(tasks_deg: ArrayLike, task_deg: float) -> int:
    """Find the task nearest to another, round the circle.

    Parameters
    ----------
    tasks_deg : array_like of shape (n_tasks,)
        Task angles (degrees).
    task_deg : float
        The other (degrees).

    Returns
    -------
    int
        Its index; the first, of two that are equally near.

    Examples
    --------
    >>> nearest_task([0, 120, 240], 359.9)
    0
    """
    apart = np.abs(np.asarray(tasks_deg, dtype=float) - task_deg) % 360
    return int(np.minimum(apart, 360 - apart).argmin())


def _check_angles(tasks: ArrayLike) -> NDArray[np.float64]:
    """Return the tasks in a row, if they are angles in [0, 2π)."""
    angles = to_floats("tasks", tasks)
    if angles.shape not in ((angles.size,), (angles.size, 1)):
        raise ValueError(f"tasks of shape {angles.shape}; wanted one angle a task")
    angles = angles.reshape(-1)
    bad = angles[~((angles >= 0) & (angles < 2 * np.pi))]
    if bad.size:
        raise ValueError(f"tasks hold {bad[0]:g}; wanted radians in [0, 2π)")
    return angles
