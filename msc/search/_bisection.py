"""Is a large step between neighbouring tasks a jump? Close in on it and see."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import to_floats
from msc._parallel import call_in_order
from msc.data import find_jumps
from msc.robot import Workspace
from msc.search._policy import search_policy

FINEST_DEG = 1 / 8  # to which a jump is bisected
LASTING = 0.7  # share of a step that its larger half must keep to be a jump


def bisect_jumps(
    workspace: Workspace,
    tasks_deg: ArrayLike,
    policies: ArrayLike,
    *,
    seed: int,
    jobs: int = 1,
    progress: bool = False,
) -> list[dict[str, Any]]:
    """Settle which large steps between neighbouring tasks are jumps.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks_deg : array_like of shape (n_tasks,)
        Ascending task angles (degrees).
    policies : array_like of shape (n_tasks, n_params)
        Their policies.
    seed : int
        Seed of the searches.
    jobs : int, default=1
        Worker processes.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    list of dict
        For each step that `find_jumps` points to on the closed circle, see `bisect`.
    """
    tasks = to_floats("tasks_deg", tasks_deg)
    known = to_floats("policies", policies)
    steps = find_jumps(tasks, known, closed=True)
    after = np.append(tasks[1:], tasks[0] + 360)
    calls = [
        (
            workspace,
            (float(tasks[k]), float(after[k])),
            (known[k], known[(k + 1) % len(known)]),
        )
        for k in steps
    ]
    return call_in_order(
        partial(bisect, seed=seed),
        calls,
        jobs=jobs,
        label="jumps bisected",
        progress=progress,
    )


def bisect(
    workspace: Workspace,
    ends_deg: tuple[float, float],
    policies: tuple[NDArray[np.float64], NDArray[np.float64]],
    *,
    seed: int,
) -> dict[str, Any]:
    """Close in on a step between two tasks, as long as it stays a step.

    The task half-way is searched from both sides and independently; the larger half
    goes on, if it keeps at least 0.7 of the step.

    Parameters
    ----------
    workspace : Workspace
        The world.
    ends_deg : tuple of float
        Task angles before and after the step (degrees).
    policies : tuple of ndarray of shape (n_params,)
        Their policies.
    seed : int
        Seed of the searches.

    Returns
    -------
    dict
        The ends in the table and those closed in on (degrees), the size of the step at
        each halving, and whether it is a jump: still there at 1/8 degree or less.
    """
    (low, high), (before, after) = ends_deg, policies
    sizes = [float(np.linalg.norm(after - before))]
    while high - low > FINEST_DEG:
        middle = (low + high) / 2
        found = search_policy(
            workspace, middle, seed=seed, n_starts=1, start_policies=(before, after)
        ).policy
        halves = [float(np.linalg.norm(found - end)) for end in (before, after)]
        if max(halves) < LASTING * sizes[-1]:
            break
        if halves[0] > halves[1]:
            high, after = middle, found
        else:
            low, before = middle, found
        sizes.append(max(halves))
    return {
        "between_deg": list(ends_deg),
        "located_deg": [low, high],
        "step_sizes": sizes,
        "is_jump": high - low <= FINEST_DEG,
    }
