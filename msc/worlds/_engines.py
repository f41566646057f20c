"""Policies searched in one engine, executed in the other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from msc.data import Dataset, describe_origin, load_dataset
from msc.robot import ENGINES, Arm, Workspace, read_world
from msc.search import cost
from press import write_json


def compare_engines(
    folder: Path, out: Path, names: Iterable[str], *, progress: bool = False
) -> None:
    """Execute the policies of worlds in both engines.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    out : Path
        A `.json` file.
    names : iterable of str
        Which worlds.
    progress : bool, default=False
        Whether to show a progress bar on standard error.
    """
    listed, tables, worlds = list(names), [], {}
    for name in tqdm(listed, desc="engines", unit="world", disable=not progress):
        world = read_world(folder / f"{name}.toml")
        tables += [folder / f"{name}.csv", folder / f"{name}.toml"]
        worlds[name] = execute_elsewhere(world, load_dataset(folder / f"{name}.csv"))
    origin = describe_origin("msc worlds engines", *tables)
    write_json(out, {"provenance": origin, "worlds": worlds})


def execute_elsewhere(world: Workspace, data: Dataset) -> dict[str, Any]:
    """Execute policies in the engine they were searched in, and in the other.

    Parameters
    ----------
    world : Workspace
        The world.
    data : Dataset
        Its tasks and policies.

    Returns
    -------
    dict
        "engine", in which they were searched, and of each movement: "touched" and
        "touched_elsewhere", "joints_rad", the largest difference of a joint angle at
        any time, "error_cm" and "error_cm_elsewhere", "cost" and "cost_elsewhere",
        "impulse_n_s" and "impulse_n_s_elsewhere".
    """
    own = world.physics.engine
    (other,) = set(ENGINES) - {own}
    elsewhere = replace(world, physics=replace(world.physics, engine=other))
    tasks = world.tasks_in(data.table)
    with Arm(world) as here, Arm(elsewhere) as there:
        pair = [arm.execute_many(data.policies, tasks) for arm in (here, there)]
    told: dict[str, Any] = {"engine": own}
    for rollouts, suffix in zip(pair, ("", "_elsewhere"), strict=True):
        told[f"touched{suffix}"] = [one.touched for one in rollouts]
        numbers = {
            "error_cm": [100 * one.error for one in rollouts],
            "cost": [cost(one, world.cost) for one in rollouts],
            "impulse_n_s": [one.contact_impulse for one in rollouts],
        }
        for key, values in numbers.items():
            told[f"{key}{suffix}"] = [float(f"{value:.6g}") for value in values]
    apart = [
        float(np.abs(a.joints - b.joints).max()) for a, b in zip(*pair, strict=True)
    ]
    return told | {"joints_rad": [float(f"{value:.3g}") for value in apart]}
