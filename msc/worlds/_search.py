"""The tables of all worlds: one call, resumable, the same whatever the workers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from msc.data import read_package, save_table
from msc.robot import LINK_RADIUS, Workspace, read_world
from msc.search import (
    SearchOptions,
    SweepPlan,
    draw_tasks,
    grid,
    search_tasks,
)
from msc.worlds._draw import FAMILIES, family_of
from msc.worlds._each import do_each
from press import checksum

OPTIONS = SearchOptions(apart=0.3)  # tasks five degrees apart share less than near ones
# Of so many test tasks, evenly spaced, so that none is a training task.
_OFFSETS_DEG = {60: 0.5, 36: 2.5}


def list_worlds(folder: Path, *, searched: bool = False) -> list[str]:
    """List the worlds of a folder that are of a family, in the order of search.

    Parameters
    ----------
    folder : Path
        Where their files are.
    searched : bool, default=False
        Whether to leave out those that are not searched yet.

    Returns
    -------
    list of str
        Their names, family by family as `FAMILIES` has them.

    Raises
    ------
    ValueError
        If there are none.
    """
    names = sorted(path.stem for path in folder.glob("*.toml"))
    families = [family_of(name).name for name in names]
    found = [
        name
        for family in FAMILIES
        for name, own in zip(names, families, strict=True)
        if own == family
    ]
    if not found:
        raise ValueError(f"{folder} has no worlds; make some: msc worlds make")
    if searched and not (found := [one for one in found if _are_there(folder, one)]):
        raise ValueError(f"{folder}: no world is searched; do so: msc worlds search")
    return found


def list_tasks(workspace: Workspace) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """List the training and the test tasks of a world of a family.

    Parameters
    ----------
    workspace : Workspace
        The world.

    Returns
    -------
    train, test : tuple
        Task angles (degrees), evenly spaced, or tuples of all numbers of a task: the
        test tasks are those next in the sequence of `draw_tasks`. A goal nearer to an
        obstacle than the end effector is thick cannot be reached, and is left out.

    Examples
    --------
    >>> train, test = list_tasks(Workspace(name="layout01"))
    >>> len(train), len(test), set(train) & set(test)
    (72, 60, set())
    """
    family = family_of(workspace.name)
    train: tuple[Any, ...]
    test: tuple[Any, ...]
    if workspace.further:
        train = draw_tasks(workspace, family.n_train)
        test = draw_tasks(workspace, family.n_test, skip=family.n_train)
    else:
        offset = _OFFSETS_DEG[family.n_test]
        train, test = grid(family.n_train), grid(family.n_test, offset)
    return _reachable(workspace, train), _reachable(workspace, test)


def _reachable(workspace: Workspace, tasks: tuple[Any, ...]) -> tuple[Any, ...]:
    """Leave out the tasks whose goals no end effector can be at."""
    goals, circles = workspace.target(tasks), workspace.circles_of(tasks)
    apart = np.linalg.norm(circles[..., :2] - goals[:, None], axis=-1)
    is_free = (apart > circles[..., 2] + LINK_RADIUS).all(axis=1)
    return tuple(task for task, free in zip(tasks, is_free, strict=True) if free)


def search_worlds(
    folder: Path,
    names: Iterable[str],
    *,
    seed: int = 0,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Search the tables of worlds that are not there yet.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    names : iterable of str
        Which worlds.
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes, a world each; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, whose workers do the work instead.
    progress : bool, default=False
        Whether to show a progress bar on standard error, over all tasks.

    Returns
    -------
    list of str
        The worlds that were searched.

    Raises
    ------
    ValueError
        If a world's file is missing or amiss.
    """
    worlds = {name: read_world(folder / f"{name}.toml") for name in names}
    tasks = {name: list_tasks(world) for name, world in worlds.items()}
    left = [name for name in worlds if not _are_there(folder, name, seed)]
    sizes = {name: sum(map(len, both)) for name, both in tasks.items()}
    journals = None if dask else folder
    calls = [(worlds[name], tasks[name], seed, journals) for name in left]
    bar = tqdm(
        desc="worlds",
        initial=sum(sizes[name] for name in worlds if name not in left),
        total=sum(sizes.values()),
        unit="task",
        disable=not progress,
    )

    def keep(number: int, found: tuple[pd.DataFrame, pd.DataFrame]) -> None:
        _save(folder, left[number], seed, *found)
        bar.set_postfix_str(left[number], refresh=False)

    paid = [sizes[name] for name in left]
    do_each(_search_both, calls, keep, bar, sizes=paid, jobs=jobs, dask=dask)
    return left


def _search_both(
    world: Workspace, tasks: Sequence[tuple[Any, ...]], seed: int, folder: Path | None
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Search training tasks, then, guided by them, test tasks, in a worker."""
    train, test = tasks
    names = _journal(folder, world.name), _journal(folder, f"{world.name}_test")
    known = search_tasks(
        SweepPlan(world, train, seed, options=OPTIONS), journal=names[0]
    )
    guide = tuple(zip(train, _policies(known), strict=True))
    plan = SweepPlan(world, test, seed, guide=guide, options=OPTIONS)
    return known, search_tasks(plan, journal=names[1])


def _policies(table: pd.DataFrame) -> list[tuple[float, ...]]:
    """Return the policies of a table."""
    return [tuple(row) for row in table.filter(like="weight_").to_numpy().tolist()]


def _journal(folder: Path | None, name: str) -> Path | None:
    """Tell where a search keeps what is done, if on this machine."""
    return None if folder is None else folder / f".{name}.csv.partial"


def check_searched(folder: Path, name: str) -> None:
    """Refuse a world whose tables are missing, or of another world."""
    if not (folder / f"{name}.toml").is_file():
        raise ValueError(f"{folder} has no {name}.toml; wanted the name of a world")
    if not _are_there(folder, name):
        raise ValueError(
            f"{name}: {folder} has no tables of it, or of another world; wanted them "
            f"searched: msc worlds search {name}"
        )


def _are_there(folder: Path, name: str, seed: int | None = None) -> bool:
    """Whether both tables are, of this world and, if given, seed."""
    package = {one["path"]: one for one in read_package(folder)["resources"]}
    wanted: dict[str, Any] = {"world": checksum(folder / f"{name}.toml")}
    wanted |= {} if seed is None else {"seed": seed}
    for table in (f"{name}.csv", f"{name}_test.csv"):
        told, path = package.get(table, {}), folder / table
        if not path.is_file() or {key: told.get(key) for key in wanted} != wanted:
            return False
        if checksum(path) != told.get("hash"):
            return False
    return True


def _save(
    folder: Path, name: str, seed: int, train: pd.DataFrame, test: pd.DataFrame
) -> None:
    """Write both tables, and let go of what was kept meanwhile."""
    command = f"msc worlds search {name} --seed {seed}"
    world = checksum(folder / f"{name}.toml")
    for stem, table in ((name, train), (f"{name}_test", test)):
        out = folder / f"{stem}.csv"
        told = {"workspace": name, "world": world, "options": list(OPTIONS.changed)}
        save_table(table, out, command=command, seed=seed, **told)
        out.with_name(f".{out.name}.partial").unlink(missing_ok=True)
