"""Methods against each other in each of the worlds, a file a world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import (
    Dataset,
    describe_origin,
    find_jump_edges,
    load_dataset,
    task_edges,
)
from msc.robot import Workspace, read_world
from msc.search import coordinates
from msc.study import (
    METHODS,
    draw_samples,
    fit_methods,
    format_study,
    measure_method,
    measure_plans,
    summarise_cell,
)
from msc.worlds._draw import family_of
from msc.worlds._each import Load, fill
from msc.worlds._search import check_searched
from press import replace_file

SIZES = (12, 24, 50)
N_FULL = 3  # training sets on which all methods are tried
N_SETS = 10  # of each size and design, if there are so many
# On all training sets those that questions are asked about, and what is as quick; the
# others on evenly spaced sets of 24 tasks, or three random ones.
ALWAYS = (
    "charts",
    "single regression",
    "CrKr",
    "nearest neighbour",
    "linear interpolation",
    "mean policy",
    "zero policy",
    "charts, SVM gate",
    "charts, Matérn",
    "single, Matérn",
    "charts, one kernel",
    "single, one kernel",
    "charts, Matérn, one kernel",
    "single, Matérn, one kernel",
    "ladder: SMCE, true gate",
    "1 chart",
    "8 charts",
)
CHOICES_ASKED = "layout", "arm"  # families; there, on all sets of 24 tasks, too:
CHOICES = (
    "charts, k-means",
    "charts, GP gate",
    "charts, λ 1",
    "charts, λ 100",
    "charts, 10 neighbours",
    "charts, raw form",
    "2 charts",
    "3 charts",
    "6 charts",
)
WITH_ROLLOUTS = "layout01", "layout02", "layout03", "layout04"  # where they are tried
_ALL_AT = 24
_KEPT = ("mean", "per_repetition", "waves", "n_tasks")
_VERSIONS = ("numpy", "scikit-learn", "cvxpy", "pybullet")

Array = NDArray[np.float64]


def study_worlds(
    folder: Path,
    out: Path,
    names: Iterable[str],
    *,
    seed: int = 0,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Fit methods to training sets of worlds, and test them; those that are not yet.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    out : Path
        Where results go, a file a world.
    names : iterable of str
        Which worlds.
    seed : int, default=0
        Seed of the training sets and the clustering.
    jobs : int, default=1
        Worker processes, a world each; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, whose workers do the work instead.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    list of str
        The worlds that were studied.
    """
    files = {name: out / f"{name}.json" for name in names}
    how: dict[str, Any] = {"jobs": jobs, "dask": dask, "progress": progress}
    load = load_for("study", folder, seed)
    return fill("study", study_world, files, load, write_lines, seed=seed, **how)


def load_for(step: str, folder: Path, seed: int) -> Load:
    """Give a function that loads a world, by its name, for a step of `msc worlds`."""
    return lambda name: load_world(
        folder, name, f"msc worlds {step} {name} --seed {seed}"
    )


def write_lines(path: Path, told: Mapping[str, Any]) -> None:
    """Write a result as studies are written, a list of numbers a line."""
    replace_file(path, format_study(told))


def load_world(
    folder: Path, name: str, made_by: str
) -> tuple[tuple[Workspace, Dataset, Dataset], dict[str, Any]]:
    """Load a world and both its tables; say what a result of them rests on."""
    check_searched(folder, name)
    tables = [folder / f"{name}{end}" for end in (".csv", "_test.csv")]
    path = folder / f"{name}.toml"
    told = describe_origin(made_by, *tables, path)
    told |= {"versions": {one: metadata.version(one) for one in _VERSIONS}}
    train, test = map(load_dataset, tables)
    return (read_world(path), train, test), told


def study_world(
    world: Workspace, train: Dataset, test: Dataset, seed: int = 0
) -> dict[str, Any]:
    """Try all methods in a world.

    Parameters
    ----------
    world : Workspace
        The world.
    train, test : Dataset
        Its tables.
    seed : int, default=0
        Seed of the training sets and the clustering.

    Returns
    -------
    dict
        "cells", each a design and a size: as those of `msc.study.Study`, without what
        a mean does not need; "failed": what could not be fitted, and why.
    """
    units = world.task_units
    grid, new = (one._replace(tasks=one.tasks / units) for one in (train, test))
    cells, failed = [], {}
    for design, n_samples, sets in list_world_sets(grid.tasks, seed):
        found: dict[str, dict[str, list[Any]]] = {}
        is_first = design == ("uniform" if world.further else "even")
        for number, chosen in enumerate(sets):
            is_full = is_first and number < N_FULL
            for name in _list_methods(world, n_samples, full=is_full):
                told = _try(name, world, (grid, new), chosen, seed)
                if isinstance(told, str):
                    failed[f"{name}/{design}/{n_samples}/{number}"] = told
                    continue
                for key, errors in told.items():
                    found.setdefault(name, {}).setdefault(key, []).append(errors)
        raw = {
            name: {key: np.array(rows) for key, rows in of.items()}
            for name, of in found.items()
        }
        away = are_away(world, grid, new.tasks, n_samples)
        summary = summarise_cell(raw, away, np.ones(len(away)))["measures"]
        cells.append(
            {
                "design": design,
                "n_samples": n_samples,
                "repetitions": len(sets),
                "measures": {
                    measure: {
                        name: {key: one[key] for key in _KEPT}
                        for name, one in of.items()
                    }
                    for measure, of in summary.items()
                },
            }
        )
    return {"cells": cells, "failed": failed}


def _list_methods(world: Workspace, n_samples: int, *, full: bool) -> tuple[str, ...]:
    """List the methods that are tried on a training set, a full one or not."""
    family = family_of(world.name).name
    if n_samples != _ALL_AT or family == "variant":
        return ALWAYS
    if full:
        return _list_all(world)
    return (*ALWAYS, *CHOICES) if family in CHOICES_ASKED else ALWAYS


def _list_all(world: Workspace) -> tuple[str, ...]:
    """List all methods that fit its tasks; those with rollouts in four worlds alone."""
    n_numbers = len(world.task_names)
    return tuple(
        name
        for name, method in METHODS.items()
        if method.n_numbers in (None, n_numbers)
        and (method.group != "rollouts" or world.name in WITH_ROLLOUTS)
    )


def list_world_sets(
    tasks: Array, seed: int
) -> list[tuple[str, int, list[NDArray[np.intp]]]]:
    """Draw all training sets of a world: by design and size.

    Evenly spaced ones of tasks on a circle, as far as there are any, and as many at
    random.
    """
    if len(tasks) == _ALL_AT:  # there is no other set
        return [("even", _ALL_AT, [np.arange(_ALL_AT)])]
    designs = ("even", "uniform") if tasks.shape[1] == 1 else ("uniform",)
    places = np.linspace(0, 2 * np.pi, len(tasks), endpoint=False)  # which, not where
    return [
        (design, size, draw_samples(design, places, size, n_draws=N_SETS, seed=seed))
        for design in designs
        for size in SIZES
    ]


def _try(
    name: str,
    world: Workspace,
    datasets: tuple[Dataset, Dataset],
    chosen: NDArray[np.intp],
    seed: int,
) -> dict[str, NDArray[Any]] | str:
    """Fit a method to a training set and test it; or tell why that failed."""
    grid, test = datasets
    known = grid.tasks[chosen], grid.policies[chosen], grid.table["cost"][chosen]
    try:
        method = fit_methods(*known, names=[name], seed=seed, workspace=world)[name]
        if hasattr(method, "plan"):
            return measure_plans(method, world, test)
        return measure_method(name, method, world, datasets, chosen)
    except Exception as error:  # whatever a method of others raises
        return f"{type(error).__name__}: {error}"


def are_away(
    world: Workspace, grid: Dataset, tasks: Array, n_samples: int
) -> NDArray[np.bool_]:
    """Tell which test tasks are farther from every jump than n samples lie apart."""
    edges = task_edges(grid.tasks)
    at = edges[find_jump_edges(grid.policies, edges)]
    places = (grid.tasks[at[:, 0]] + grid.tasks[at[:, 1]]) / 2
    spans = np.diff(coordinates(world, world.task_bounds), axis=0)
    apart = (np.prod(spans) / n_samples) ** (1 / tasks.shape[1])
    gaps = np.linalg.norm(tasks[:, None] - places, axis=-1)
    return np.asarray((gaps > apart).all(axis=1))
