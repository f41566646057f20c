"""Evidence on a table of policies: executed again, searched again, jumps bisected."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from msc._parallel import call_in_order
from msc.data import (
    Dataset,
    describe_origin,
    find_jumps,
    find_table,
    find_world,
    load_dataset,
    read_package,
)
from msc.robot import Arm, Workspace
from msc.search import (
    N_PARALLEL,
    SearchOptions,
    SearchResult,
    search_policies,
    search_policy,
)

N_STARTS = 4  # of a search done again, none of them from a known policy
COST_TOLERANCE = 0.005  # share of a cost; differing by more tells of another policy
FINEST_DEG = 1 / 8  # to which a jump is bisected
LASTING = 0.7  # share of a step that its larger half must keep to be a jump

_Search = Callable[..., SearchResult]
_Call = Callable[..., list[Any]]


def audit_table(
    path: str | Path,
    workspace: str | None = None,
    *,
    n_sample: int = 36,
    seed: int = 1,
    jobs: int = 1,
    progress: bool = False,
    options: SearchOptions | None = None,
) -> dict[str, Any]:
    """Examine a table of searched policies.

    Parameters
    ----------
    path : str or Path
        The table, or a name that `load_dataset` knows.
    workspace : str, optional
        Where its policies were searched, as `find_world` knows it; by default as the
        data package beside it has it.
    n_sample : int, default=36
        Tasks to search again, drawn at random.
    seed : int, default=1
        Seed of that draw and of the new searches; another one than the table's.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    dict
        Beside the table's name, workspace and origin: under "executed" how many final
        distances came back to the last bit, and the largest difference (m); under
        "searched" the tasks drawn (degrees), the change of each one's cost relative to
        the stored one, and how many are more than 0.5 % cheaper; under "jumps", for
        each step that `find_jumps` points to on the closed circle, its ends in the
        table and those closed in on (degrees), the size of the step at each halving,
        and whether it is a jump: still there at 1/8 degree or less. Tasks of several
        numbers have no such steps, and no "jumps".

    Raises
    ------
    ValueError
        If the workspace is unknown or another than the data package's, there are fewer
        tasks than are to be drawn, or the seed is one that the table was made with.
    """
    data, path = load_dataset(path), find_table(path)
    options = options or SearchOptions()
    where = find_world(_find_workspace(path, workspace))
    if not 1 <= n_sample <= len(data.table):
        raise ValueError(f"sample={n_sample}; wanted from 1 to {len(data.table)} tasks")
    if seed in set(data.table["seed"]):
        raise ValueError(f"seed={seed} made this table; wanted a fresh one")
    command = f"msc audit data/{path.name} --sample {n_sample} --seed {seed}"
    command += f" --workspace {workspace}" if workspace else ""
    command += "".join(f" --set {changed}" for changed in options.changed)
    drawn = np.random.default_rng(seed).choice(len(data.table), n_sample, replace=False)
    sample = data.table.iloc[np.sort(drawn)]
    search = partial(search_policy, seed=seed, options=options)
    call = partial(call_in_order, jobs=jobs, progress=progress)
    found = {
        "table": path.name,
        "workspace": where.name,
        "n_tasks": len(data.table),
        "seed": seed,
        "provenance": describe_origin(command, path),
        "executed": _execute_again(where, data),
        "searched": _search_again(where, sample, seed, options, call),
    }
    if not where.further:
        found["jumps"] = _bisect_jumps(where, data, search, call)
    return found


def _find_workspace(path: Path, given: str | None) -> str:
    """Return the workspace of a table: as given, or as its data package has it."""
    known = {one["path"]: one for one in read_package(path.parent)["resources"]}
    resource = known.get(path.name, {})
    recorded, command = resource.get("workspace"), str(resource.get("command"))
    if not recorded and command.split()[:2] == ["msc", "search"]:
        told = re.search(r"\s--workspace[\s=]+(\S+)", command)
        recorded = told[1] if told else "free"
    if given is None and recorded is None:
        raise ValueError(
            f"{path.name}: no data package beside it tells its workspace; wanted "
            "--workspace, as free, obstacles or a .toml file"
        )
    if given is not None and recorded is not None and given != recorded:
        raise ValueError(
            f"workspace={given!r}, but the data package beside {path.name} says "
            f"{recorded!r}; wanted the same, or none given"
        )
    return str(given or recorded)


def _execute_again(workspace: Workspace, data: Dataset) -> dict[str, Any]:
    """Execute all policies and compare the final distances with the stored ones."""
    with Arm(workspace) as arm:
        rollouts = arm.execute_many(data.policies, workspace.tasks_in(data.table))
    changes = [rollout.error for rollout in rollouts] - data.table["distance_m"]
    return {
        "identical": int((changes == 0).sum()),
        "largest_difference_m": float(changes.abs().max()),
    }


def _search_again(
    workspace: Workspace,
    sample: pd.DataFrame,
    seed: int,
    options: SearchOptions,
    call: _Call,
) -> dict[str, Any]:
    """Search tasks from scratch and compare the costs with the stored ones."""
    tasks = workspace.tasks_in(sample).tolist()
    shares = [tasks[k : k + N_PARALLEL] for k in range(0, len(tasks), N_PARALLEL)]
    search = partial(search_policies, seed=seed, n_starts=N_STARTS, options=options)
    found = call(
        search, [(workspace, share) for share in shares], label="searched again"
    )
    costs = np.array([result.cost for share in found for result in share])
    changes = costs / sample["cost"] - 1
    return {
        "task_deg": tasks,
        "change_of_cost": changes.to_list(),
        "n_cheaper": int((changes < -COST_TOLERANCE).sum()),
        "n_starts": N_STARTS,
    }


def _bisect_jumps(
    workspace: Workspace, data: Dataset, search: _Search, call: _Call
) -> list[dict[str, Any]]:
    """Settle which large steps between neighbouring tasks are jumps."""
    tasks, policies = data.task_deg, data.policies
    ends = np.stack([tasks, np.append(tasks[1:], tasks[0] + 360)], axis=1).tolist()
    pairs = np.stack([policies, np.roll(policies, -1, axis=0)], axis=1)
    jumps = find_jumps(tasks, policies, closed=True)
    calls = [(search, workspace, ends[k], pairs[k]) for k in jumps]
    return call(_bisect, calls, label="jumps bisected")


def _bisect(
    search: _Search,
    workspace: Workspace,
    ends_deg: Sequence[float],
    policies: Sequence[NDArray[np.float64]],
) -> dict[str, Any]:
    """Close in on a step between two tasks, as long as it stays a step."""
    (low, high), (before, after) = ends_deg, policies
    sizes = [float(np.linalg.norm(after - before))]
    while high - low > FINEST_DEG:
        # The task half-way, from both sides and independently; the larger half goes on.
        middle, sides = (low + high) / 2, (before, after)
        found = search(workspace, middle, n_starts=1, start_policies=sides).policy
        halves = [float(np.linalg.norm(found - side)) for side in sides]
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
