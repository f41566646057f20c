"""Evidence on a table of policies: executed again, searched again, jumps bisected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from numpy.typing import ArrayLike, NDArray
from tqdm import tqdm

from msc.arm import Arm
from msc.jumps import find_jumps
from msc.search import search_policy
from msc.tables import load_dataset
from msc.workspace import Workspace

N_STARTS = 4  # of a search done again, none of them from a known policy
LOWER = 0.005  # a cost this share below the stored one tells of a missed policy
FINEST_DEG = 1 / 8  # to which a jump is bisected
LASTING = 0.7  # share of a step that its larger half must keep to be a jump


def audit_table(
    path: Path,
    *,
    workspace: Workspace | None = None,
    n_sample: int = 36,
    seed: int = 1,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Examine a table of searched policies.

    Parameters
    ----------
    path : Path
        The table.
    workspace : Workspace, optional
        Where its policies were searched; by default the one that its file is named
        after.
    n_sample : int, default=36
        Tasks to search again, drawn at random.
    seed : int, default=1
        Seed of that draw and of the new searches; another one than the table's.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        What `execute_again`, `search_again` and `bisect_jumps` found, under the keys
        "executed", "searched" and "jumps".

    Raises
    ------
    ValueError
        If the workspace is unknown, there are fewer tasks than are to be drawn, or the
        seed is one that the table was made with.
    """
    _, policies, table = load_dataset(path)
    world = workspace or Workspace.named(Path(path).stem.partition("_")[0])
    if not 1 <= n_sample <= len(table):
        raise ValueError(f"sample={n_sample}; wanted from 1 to {len(table)} tasks")
    if seed in set(table["seed"]):
        raise ValueError(f"seed={seed} made this table; wanted a fresh one")
    tasks = table["task_deg"].to_numpy()
    sample = np.random.default_rng(seed).choice(len(table), n_sample, replace=False)
    return {
        "table": Path(path).name,
        "workspace": world.name,
        "n_tasks": len(table),
        "seed": seed,
        "executed": execute_again(world, table, policies),
        "searched": search_again(
            world,
            table.iloc[np.sort(sample)],
            seed=seed,
            jobs=jobs,
            progress=progress,
        ),
        "jumps": bisect_jumps(
            world, tasks, policies, seed=seed, jobs=jobs, progress=progress
        ),
    }


def execute_again(
    workspace: Workspace, table: pd.DataFrame, policies: ArrayLike
) -> dict[str, Any]:
    """Execute all policies and compare the final distances with the stored ones.

    Parameters
    ----------
    workspace : Workspace
        Where they were searched.
    table : DataFrame
        What is stored of them.
    policies : array_like of shape (n_tasks, n_params)
        The policies.

    Returns
    -------
    dict
        How many are identical to the last bit, and the largest difference (m).
    """
    with Arm(workspace) as arm:
        rollouts = arm.execute_many(policies, table["task_deg"].to_list())
    stored = table["distance_m"].to_numpy()
    found = np.array([rollout.error for rollout in rollouts])
    return {
        "identical": int((found == stored).sum()),
        "largest_difference_m": float(np.abs(found - stored).max()),
    }


def search_again(
    workspace: Workspace,
    table: pd.DataFrame,
    *,
    seed: int,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Search tasks from scratch and compare the costs with the stored ones.

    Parameters
    ----------
    workspace : Workspace
        Where they were searched.
    table : DataFrame
        The tasks and what is stored of them.
    seed : int
        Seed of the searches.
    jobs : int, default=1
        Worker processes.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Tasks (degrees), the change of cost relative to the stored one, and how many
        tasks turned out more than 0.5 % cheaper.
    """
    tasks = table["task_deg"].to_list()
    calls = (
        delayed(search_policy)(workspace, task, seed=seed, n_starts=N_STARTS)
        for task in tasks
    )
    found = list(_in_parallel(calls, jobs, progress, "searched again", len(tasks)))
    changes = [
        result.cost / stored - 1
        for result, stored in zip(found, table["cost"], strict=True)
    ]
    return {
        "task_deg": tasks,
        "change_of_cost": changes,
        "n_cheaper": int(np.sum(np.array(changes) < -LOWER)),
        "n_starts": N_STARTS,
    }


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
    tasks = np.asarray(tasks_deg, dtype=float)
    known = np.asarray(policies, dtype=float)
    steps = find_jumps(tasks, known, closed=True)
    after = np.append(tasks[1:], tasks[0] + 360)
    calls = (
        delayed(bisect)(
            workspace,
            (float(tasks[k]), float(after[k])),
            (known[k], known[(k + 1) % len(known)]),
            seed=seed,
        )
        for k in steps
    )
    found = _in_parallel(calls, jobs, progress, "jumps bisected", len(steps))
    return sorted(found, key=lambda jump: jump["between_deg"][0])


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


def _in_parallel(calls: Any, jobs: int, progress: bool, label: str, total: int) -> Any:
    """Run delayed calls, with a bar."""
    found = Parallel(n_jobs=jobs, return_as="generator")(calls)
    return tqdm(found, desc=label, total=total, unit="task", disable=not progress)
