"""Which large steps between neighbouring tasks are jumps: closed in on by bisection.

The task half-way between two neighbours is searched, from both sides and independently;
the larger half goes on, as long as it is as large as made the step a large one. So a
step may hold several jumps, where on the one-degree grids of the headline worlds
`audit_table` wants a half to keep most of it. All steps of a world are halved together.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import (
    Dataset,
    describe_origin,
    find_jump_edges,
    find_jumps,
    find_pieces,
    load_dataset,
    step_sizes,
    task_edges,
)
from msc.robot import Workspace, read_world
from msc.search import search_policies
from msc.worlds._each import fill
from msc.worlds._search import check_searched

N_HALVINGS = 6  # of a step of five degrees: to less than 1/8
N_SAMPLED = 20  # large steps of a world with many

Array = NDArray[np.float64]


def locate_jumps(
    folder: Path,
    out: Path,
    names: Iterable[str],
    *,
    seed: int = 0,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Settle which large steps of worlds are jumps, of those that are not settled yet.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    out : Path
        Where results go, `jumps_NAME.json` a world.
    names : iterable of str
        Which worlds.
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes, a world each; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, whose workers do the work instead.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    list of str
        The worlds that were looked at.
    """
    files = {name: out / f"jumps_{name}.json" for name in names}

    def load(name: str) -> tuple[tuple[Workspace, Dataset], dict[str, Any]]:
        check_searched(folder, name)
        paths = folder / f"{name}.csv", folder / f"{name}.toml"
        made_by = f"msc worlds jumps {name} --seed {seed}"
        call = read_world(paths[1]), load_dataset(paths[0])
        return call, describe_origin(made_by, *paths)

    how: dict[str, Any] = {"jobs": jobs, "dask": dask, "progress": progress}
    return fill("jumps", bisect_world, files, load, seed=seed, **how)


def bisect_world(world: Workspace, data: Dataset, seed: int = 0) -> dict[str, Any]:
    """Bisect the large steps of a world: all on a circle, else a sample.

    Parameters
    ----------
    world : Workspace
        The world.
    data : Dataset
        Its training tasks.
    seed : int, default=0
        Seed of the searches, and of the sample.

    Returns
    -------
    dict
        Of a circle, closed: "jumps", laid out as `audit_table` has them. Of other
        tasks: how many edges there are, "large" ones, and pieces that these leave;
        "bisected", a sample: the tasks at both ends, the size of the step at each
        halving, and whether it is a jump. The cut is no edge.
    """
    names = list(world.task_names)
    rows = data.table[names].to_numpy()
    if not world.further:
        jumps = find_jumps(data.tasks, data.policies, closed=True)
        pairs = np.stack([jumps, (jumps + 1) % len(rows)], axis=1)
        ends = rows[pairs]
        ends[pairs[:, 1] == 0, 1] += 360
        _, least = step_sizes(data.policies, closed=True)
        found = _bisect(world, ends, data.policies[pairs], least, seed)
        return {
            "jumps": [
                {
                    "between_deg": ends[k, :, 0].tolist(),
                    "located_deg": one["located"][:, 0].tolist(),
                    "step_sizes": one["step_sizes"],
                    "is_jump": one["is_jump"],
                }
                for k, one in enumerate(found)
            ]
        }
    edges = task_edges(data.tasks / world.task_units, closed=False)
    large = find_jump_edges(data.policies, edges)
    rng = np.random.default_rng(seed)
    drawn = np.sort(rng.permutation(large)[:N_SAMPLED])
    pairs = edges[drawn]
    steps = np.linalg.norm(np.diff(data.policies[edges], axis=1)[:, 0], axis=1)
    least = np.delete(steps, large).max()  # of those that are not large, the largest
    found = _bisect(world, rows[pairs], data.policies[pairs], least, seed)
    pieces = find_pieces(len(rows), edges, large)
    return {
        "edges": len(edges),
        "large": len(large),
        "pieces": np.bincount(pieces).tolist(),
        "bisected": [
            {
                "between": rows[pair].tolist(),
                "step_sizes": one["step_sizes"],
                "is_jump": one["is_jump"],
            }
            for pair, one in zip(pairs, found, strict=True)
        ],
    }


def _bisect(
    world: Workspace, ends: Array, policies: Array, least: float, seed: int
) -> list[dict[str, Any]]:
    """Halve steps between tasks (n_steps, 2, n_numbers), as long as they are large."""
    ends, policies = ends.copy(), policies.copy()
    sizes = [[float(np.linalg.norm(np.diff(pair, axis=0)))] for pair in policies]
    going = list(range(len(ends)))
    for _ in range(N_HALVINGS):
        middles = ends[going].mean(axis=1)
        tasks = middles.tolist() if world.further else middles[:, 0].tolist()
        found = search_policies(
            world, tasks, seed=seed, n_starts=1, start_policies=policies[going]
        )
        for k, middle, result in zip([*going], middles, found, strict=True):
            halves = np.linalg.norm(policies[k] - result.policy, axis=1)
            if halves.max() <= least:
                going.remove(k)
                continue
            side = int(halves[0] > halves[1])  # the end that comes nearer
            ends[k, side], policies[k, side] = middle, result.policy
            sizes[k].append(float(halves.max()))
        if not going:
            break
    return [
        {"located": ends[k], "step_sizes": sizes[k], "is_jump": k in going}
        for k in range(len(ends))
    ]
