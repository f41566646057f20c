"""Evidence on a table of policies: executed again, searched again, jumps bisected."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msc._parallel import call_in_order
from msc.data import describe_origin, load_dataset, read_package
from msc.robot import Arm, Workspace
from msc.search._bisection import bisect_jumps
from msc.search._policy import search_policy

N_STARTS = 4  # of a search done again, none of them from a known policy
LOWER = 0.005  # a cost this share below the stored one tells of a missed policy


def audit_table(
    path: Path,
    workspace: str | None = None,
    *,
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
    workspace : {"free", "obstacles"}, optional
        Where its policies were searched; by default as the data package beside it has
        it.
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
        If the workspace is unknown or another than the data package's, there are fewer
        tasks than are to be drawn, or the seed is one that the table was made with.
    """
    _, policies, table = load_dataset(path)
    world = Workspace.named(_find_workspace(path, workspace))
    if not 1 <= n_sample <= len(table):
        raise ValueError(f"sample={n_sample}; wanted from 1 to {len(table)} tasks")
    if seed in set(table["seed"]):
        raise ValueError(f"seed={seed} made this table; wanted a fresh one")
    tasks = table["task_deg"].to_numpy()
    sample = np.random.default_rng(seed).choice(len(table), n_sample, replace=False)
    command = f"msc audit data/{path.name} --sample {n_sample} --seed {seed}"
    command += f" --workspace {workspace}" if workspace else ""
    return {
        "table": path.name,
        "workspace": world.name,
        "n_tasks": len(table),
        "seed": seed,
        "provenance": describe_origin(command, path),
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


def _find_workspace(path: Path, given: str | None) -> str:
    """Return the workspace of a table: as given, or as its data package has it."""
    known = {one["path"]: one for one in read_package(path.parent)["resources"]}
    resource = known.get(path.name, {})
    recorded = resource.get("workspace") or _of_command(str(resource.get("command")))
    if given is None and recorded is None:
        raise ValueError(
            f"{path.name}: no data package beside it tells its workspace; wanted "
            "--workspace free or obstacles"
        )
    if given is not None and recorded is not None and given != recorded:
        raise ValueError(
            f"workspace={given!r}, but the data package beside {path.name} says "
            f"{recorded!r}; wanted the same, or none given"
        )
    return str(given or recorded)


def _of_command(command: str) -> str | None:
    """Return the workspace of a command line `msc search …`; None of any other."""
    if command.split()[:2] != ["msc", "search"]:
        return None
    told = re.search(r"\s--workspace[\s=]+(\S+)", command)
    return told[1] if told else "free"


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
    again = partial(search_policy, seed=seed, n_starts=N_STARTS)
    found = call_in_order(
        again,
        [(workspace, task) for task in tasks],
        jobs=jobs,
        label="searched again",
        progress=progress,
    )
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
