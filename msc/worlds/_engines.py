"""Policies searched in one engine, executed in the other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from msc.data import Dataset, describe_origin, load_dataset
from msc.estimates import six_digits
from msc.robot import ENGINES, Arm, Rollout, Workspace, read_world
from msc.search import cost
from msc.worlds._search import check_searched
from press import write_json

FINER = ("layout01", "layout02", "layout03", "layout04")  # where steps are divided
SUBSTEPS = (4, 16, 64)


def compare_engines(
    folder: Path, out: Path, names: Iterable[str], *, progress: bool = False
) -> None:
    """Execute the policies of worlds in both engines, and in `FINER` with finer steps.

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

    Raises
    ------
    ValueError
        If one of them is not searched.
    """
    listed, tables, worlds, steps = list(names), [], {}, {}
    for name in listed:
        check_searched(folder, name)
    for name in tqdm(listed, desc="engines", unit="world", disable=not progress):
        world = read_world(folder / f"{name}.toml")
        tables += [folder / f"{name}.csv", folder / f"{name}.toml"]
        data = load_dataset(folder / f"{name}.csv")
        worlds[name] = execute_elsewhere(world, data)
        if name in FINER:
            steps[name] = refine_steps(world, data)
    origin = describe_origin("msc worlds engines", *tables)
    write_json(out, {"provenance": origin, "worlds": worlds, "steps": steps})


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
            told[f"{key}{suffix}"] = [six_digits(value) for value in values]
    apart = [
        float(np.abs(a.joints - b.joints).max()) for a, b in zip(*pair, strict=True)
    ]
    return told | {"joints_rad": [float(f"{value:.3g}") for value in apart]}


def refine_steps(
    world: Workspace, data: Dataset, substeps: Sequence[int] = SUBSTEPS
) -> dict[str, Any]:
    """Execute policies in both engines with ever finer steps of the physics.

    Parameters
    ----------
    world : Workspace
        The world.
    data : Dataset
        Its tasks and policies.
    substeps : sequence of int, default=(4, 16, 64)
        Steps of the physics in one of the controller, the world's own first.

    Returns
    -------
    dict
        "substeps", and by engine "cost" and "impulse_n_s": of each number of steps a
        list, with the movements that meet an obstacle in both engines at the first.
    """
    tasks = world.tasks_in(data.table)
    finest: dict[tuple[str, int], list[Rollout]] = {}
    for engine, number in product(ENGINES, substeps):
        physics = replace(world.physics, engine=engine, substeps=number)
        with Arm(replace(world, physics=physics)) as arm:
            finest[engine, number] = arm.execute_many(data.policies, tasks)
    first = [[one.touched for one in finest[name, substeps[0]]] for name in ENGINES]
    met = np.flatnonzero(np.all(first, axis=0))
    told: dict[str, Any] = {"substeps": list(substeps)}
    for name in ENGINES:
        kept = [[finest[name, number][k] for k in met] for number in substeps]
        told[name] = {
            "cost": [
                [six_digits(cost(one, world.cost)) for one in row] for row in kept
            ],
            "impulse_n_s": [
                [six_digits(one.contact_impulse) for one in row] for row in kept
            ],
        }
    return told
