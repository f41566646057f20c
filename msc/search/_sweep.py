"""The search of many tasks: parallel, resumable, the same whatever the workers.

From coarse to fine: first tasks about ten degrees apart, from two independent starts
each, then those between, from the policies on either side and an independent start; all
from more starts until two agree on what was found. After each level, the consistency
pass: tasks in even places, then those in odd places, are searched again from their
neighbours' policies, keeping whatever costs least, until no behaviour spreads any
further. The pass only lowers costs, and its order does not depend on which worker is
done first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc
from tqdm import tqdm

from msc._checks import check_whole, to_floats
from msc._parallel import Runner, open_workers
from msc.data import find_neighbors, name_weights, task_edges
from msc.robot import Workspace
from msc.search._journal import Journal, identify_code
from msc.search._lockstep import N_PARALLEL, Search, run_in_lockstep
from msc.search._options import SearchOptions
from msc.search._policy import SearchResult, search_steps

# Whose policies start runs.
_GIVEN = {"given 0": "task before", "given 1": "task after"}

_SHARE = 2 * N_PARALLEL  # tasks that a worker takes at a time, at most

_Policy = NDArray[np.float64]

# What is asked of a phase: by task number, policies to start from and what is known.
_Work = dict[int, tuple[Sequence[NDArray[np.float64]], SearchResult | None]]


@dataclass(frozen=True)
class SweepPlan:
    """What to search, and all that the outcome depends on.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks_deg : tuple of float, or of tuples of float
        Task angles (degrees), evenly spaced; or tasks of several numbers, each part of
        which from the beginning is spread over all of them, see `draw_tasks`.
    seed : int
        Seed of every draw.
    n_starts : int
        Independent starts a task, at most; one fewer where neighbours are known.
    guide : tuple of (float or tuple of float, tuple of float)
        Tasks and policies found earlier: neighbours that are known from the beginning.
    options : SearchOptions
        How the searches go about it.
    """

    workspace: Workspace
    tasks_deg: tuple[Any, ...]
    seed: int
    n_starts: int = 3
    guide: tuple[tuple[Any, tuple[float, ...]], ...] = ()
    options: SearchOptions = field(default_factory=SearchOptions)


def grid(n_tasks: int, offset_deg: float = 0.0) -> tuple[float, ...]:
    """Space task angles evenly.

    Parameters
    ----------
    n_tasks : int
        How many.
    offset_deg : float, default=0.0
        The first angle (degrees).

    Returns
    -------
    tuple of float
        Angles in [0, 360) (degrees).

    Raises
    ------
    ValueError
        If there are fewer than two, or the offset reaches past the first step.

    Examples
    --------
    >>> grid(4, offset_deg=7.5)
    (7.5, 97.5, 187.5, 277.5)
    """
    if n_tasks < 2:
        raise ValueError(f"tasks={n_tasks}; wanted at least 2")
    if not 0 <= offset_deg < 360 / n_tasks:
        raise ValueError(
            f"offset={offset_deg}; wanted degrees from 0 to below {360 / n_tasks:g}"
        )
    return tuple(offset_deg + 360 * k / n_tasks for k in range(n_tasks))


def draw_tasks(
    workspace: Workspace, n_tasks: int, *, skip: int = 0, seed: int = 0
) -> tuple[Any, ...]:
    """Spread tasks over all that a world asks for.

    Parameters
    ----------
    workspace : Workspace
        The world.
    n_tasks : int
        How many.
    skip : int, default=0
        So many of the same sequence come before them, as those trained on.
    seed : int, default=0
        Seed of the sequence.

    Returns
    -------
    tuple
        Task angles (degrees), or tuples of all numbers of a task: a scrambled Halton
        sequence, of which each part is spread evenly, rounded to 0.001 degree and
        0.1 mm.

    Examples
    --------
    >>> tasks = draw_tasks(Workspace.free(), 3)
    >>> len(tasks), 0 <= min(tasks) <= max(tasks) < 360
    (3, True)
    """
    check_whole("n_tasks", n_tasks, 1)
    check_whole("skip", skip, 0)
    check_whole("seed", seed, 0)
    n_numbers, rng = len(workspace.task_names), np.random.default_rng(seed)
    points = qmc.Halton(n_numbers, rng=rng).random(skip + n_tasks)[skip:]
    points = qmc.scale(points, *workspace.task_bounds)
    digits = [4 if name.endswith("_m") else 3 for name in workspace.task_names]
    rows = [
        tuple(round(number, n) for number, n in zip(row, digits, strict=True))
        for row in points.tolist()
    ]
    rows = [(angle % 360, *others) for angle, *others in rows]
    return tuple(rows if workspace.further else (angle for (angle,) in rows))


def search_tasks(
    plan: SweepPlan,
    *,
    jobs: int = 1,
    dask: str | None = None,
    journal: Path | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Search the policies of many tasks.

    Parameters
    ----------
    plan : SweepPlan
        What to search.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, ``"tcp://host:port"``, whose workers do the work
        instead.
    journal : Path, optional
        File that keeps what is done, so that an interrupted search goes on from there.
        It is removed at the end by whoever keeps the table.
    progress : bool, default=False
        Whether to show progress bars on standard error.

    Returns
    -------
    DataFrame
        One row a task, with the columns of `msc.data.COLUMNS`.

    Raises
    ------
    ValueError
        If the journal is in use by another search, or `dask` is not installed.
    """
    tasks, n_tasks = plan.tasks_deg, len(plan.tasks_deg)
    results: dict[int, SearchResult] = {}
    with (
        open_workers(jobs, dask, code=identify_code) as run,
        Journal(journal, plan) as done,
    ):
        search = partial(_batch, plan, run, done, progress=progress)
        for number, level in enumerate(_levels(plan)):
            new = [k for k in level.neighbors if k not in results]
            known: list[tuple[Any, ArrayLike]] = list(plan.guide)
            known += [(tasks[k], result.policy) for k, result in results.items()]
            starts = _nearby(plan, known, [tasks[k] for k in new])
            work: _Work = {k: (one, None) for k, one in zip(new, starts, strict=True)}
            results |= search(f"level {number}", work)
            _make_consistent(search, f"level {number}", level, results, plan.options)
    rows = [_row(plan, tasks[k], results[k]) for k in range(n_tasks)]
    return pd.DataFrame(rows)


class _Level(NamedTuple):
    """Tasks that are searched together, and in whose order.

    Neighbours of a task, by its number, and its colour: no two neighbours have the
    same (unless a ring has an odd number), so that tasks of one may be searched again
    all at a time.
    """

    neighbors: dict[int, tuple[int, ...]]
    colors: dict[int, int]


def _levels(plan: SweepPlan) -> list[_Level]:
    """Tell in which steps the tasks are searched, from coarse to fine."""
    n_tasks, is_planar = len(plan.tasks_deg), bool(plan.workspace.further)
    n_coarse = 360 / plan.options.coarse_deg
    if is_planar:  # as far apart, in every direction
        units = plan.workspace.task_units[1:]
        spans = [o.high - o.low for o in plan.workspace.further]
        widths = np.rad2deg(spans / units) / plan.options.coarse_deg
        n_coarse *= float(np.prod(np.maximum(1, widths)))
    stride = 1 if plan.guide else max(1, round(n_tasks / n_coarse))
    strides = [stride]
    while strides[-1] > 1:  # 10, 5, 1: the tasks of a level are among those of the next
        strides.append(1 if strides[-1] % 2 else strides[-1] // 2)
    if is_planar:
        return [_graph_level(plan, -(-n_tasks // stride)) for stride in strides]
    return [_ring_level(range(0, n_tasks, stride)) for stride in strides]


def _ring_level(ring: Sequence[int]) -> _Level:
    """Let tasks on a circle have one neighbour on either side."""
    n = len(ring)
    neighbors: dict[int, tuple[int, ...]]
    neighbors = {k: (ring[p - 1], ring[(p + 1) % n]) for p, k in enumerate(ring)}
    return _Level(neighbors, {k: place % 2 for place, k in enumerate(ring)})


def _graph_level(plan: SweepPlan, n_tasks: int) -> _Level:
    """Let the first tasks have those nearest to them, see `task_edges`."""
    edges = task_edges(coordinates(plan.workspace, plan.tasks_deg[:n_tasks]))
    beside: dict[int, list[int]] = {k: [] for k in range(n_tasks)}
    for one, other in edges.tolist():
        beside[one].append(other)
        beside[other].append(one)
    colors: dict[int, int] = {}
    for k in range(n_tasks):  # the first colour that no neighbour has
        taken = {colors.get(other) for other in beside[k]}
        colors[k] = next(c for c in range(n_tasks) if c not in taken)
    return _Level({k: tuple(others) for k, others in beside.items()}, colors)


def _make_consistent(
    search: Callable[[str, _Work], dict[int, SearchResult]],
    name: str,
    level: _Level,
    results: dict[int, SearchResult],
    options: SearchOptions,
) -> None:
    """Search tasks again from their neighbours' policies until nothing spreads."""
    stale, tried = set(level.neighbors), dict[tuple[int, int], _Policy]()
    n_colors = max(2, 1 + max(level.colors.values()))
    for sweep in range(options.max_sweeps * n_colors // 2):
        turn = [k for k in sorted(stale) if level.colors[k] == sweep % n_colors]
        work: _Work = {}
        for k in turn:
            own, starts = results[k].policy, []
            for other in level.neighbors[k]:
                policy = results[other].policy
                before = tried.get((k, other), own)
                if options.apart and (
                    _is_near(policy, own, options.apart)
                    or _is_near(policy, before, options.same)
                ):
                    continue
                starts.append(policy)
                tried[k, other] = policy
            if starts:
                work[k] = starts, results[k]
        better = search(f"{name}, sweep {sweep}", work)
        stale -= set(turn)
        for k, result in better.items():
            if not _is_near(result.policy, results[k].policy, options.same):
                stale |= set(level.neighbors[k])
        results |= better
        if not stale:
            break


def _is_near(policy: _Policy, other: _Policy, share: float) -> bool:
    """Whether a policy is no farther from another than a share of its norm."""
    return bool(np.linalg.norm(policy - other) <= share * np.linalg.norm(other))


def _batch(
    plan: SweepPlan,
    run: Runner,
    done: Journal,
    phase: str,
    work: _Work,
    *,
    progress: bool,
) -> dict[int, SearchResult]:
    """Search the tasks of one phase, those that the journal knows excepted."""
    left = [k for k in work if (phase, k) not in done.results]
    bar = tqdm(
        desc=phase,
        initial=len(work) - len(left),
        total=len(work),
        unit="task",
        disable=not progress or not left,
    )
    size = max(1, min(_SHARE, len(left) // 4))  # of four, also where tasks are few
    shares = [left[first : first + size] for first in range(0, len(left), size)]
    calls = [(plan, {k: work[k] for k in share}) for share in shares]
    with bar:
        for _, found in run(_search, calls):
            for k, result in found.items():
                done.append(phase, k, result)
            bar.update(len(found))
    return {k: done.results[phase, k] for k in work}


def _search(plan: SweepPlan, work: _Work) -> dict[int, SearchResult]:
    """Search some tasks, in a worker."""
    searches = [(plan.tasks_deg[k], _steps(plan, k, *work[k])) for k in work]
    numbers, found = list(work), run_in_lockstep(plan.workspace, searches)
    return {numbers[number]: result for number, result in found}


def _steps(
    plan: SweepPlan,
    k: int,
    starts: Sequence[NDArray[np.float64]],
    incumbent: SearchResult | None,
) -> Search[SearchResult]:
    """Search one task: from its neighbours, and independently until one confirms it."""
    search = partial(search_steps, plan.workspace, plan.tasks_deg[k])
    search = partial(search, seed=plan.seed, options=plan.options)
    # Two runs have to agree: without a neighbour, two independent ones.
    n_first = 0 if incumbent else min(1 if starts else 2, plan.n_starts)
    result = yield from search(
        n_starts=n_first, start_policies=starts, incumbent=incumbent
    )
    n_most = 0 if incumbent else plan.n_starts - bool(starts)
    for _ in range(n_most - n_first):
        if result.is_confirmed:
            break
        result = yield from search(n_starts=1, incumbent=result)
    return result


def coordinates(workspace: Workspace, tasks: ArrayLike) -> NDArray[np.float64]:
    """Return tasks as points: the angle (rad), and all else in units that weigh alike.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks : array_like of shape (n_tasks,) or (n_tasks, n_numbers)
        Task angles (degrees), or all numbers of each task.

    Returns
    -------
    ndarray of shape (n_tasks, n_numbers)
        The points, see `Workspace.task_units`.

    Examples
    --------
    >>> coordinates(Workspace.free(), [90.0]).round(3)
    array([[1.571]])
    """
    numbers = np.array(tasks, dtype=float)
    numbers = numbers.reshape(len(numbers), -1)
    angles = _is_angle(workspace)
    return np.where(angles, np.deg2rad(numbers), numbers) / workspace.task_units


def tasks_at(workspace: Workspace, points: ArrayLike) -> NDArray[np.float64]:
    """Return the tasks that points are: undo `coordinates`.

    Parameters
    ----------
    workspace : Workspace
        The world.
    points : array_like of shape (n_tasks, n_numbers)
        The angle (rad), and all else in units that weigh alike.

    Returns
    -------
    ndarray of shape (n_tasks,) or (n_tasks, n_numbers)
        Task angles (degrees), as they are given to a world; where tasks have further
        numbers, rows of them.

    Raises
    ------
    ValueError
        If points have not as many numbers as tasks do.

    Examples
    --------
    >>> tasks_at(Workspace.free(), [[np.pi / 2]])
    array([90.])
    """
    rows, names = to_floats("points", points), workspace.task_names
    if rows.ndim != 2 or rows.shape[1] != len(names):
        raise ValueError(
            f"points have shape {rows.shape}; wanted {len(names)} columns: "
            f"{', '.join(names)}"
        )
    numbers = rows * workspace.task_units
    tasks = np.where(_is_angle(workspace), np.rad2deg(numbers), numbers)
    return np.asarray(tasks if workspace.further else tasks[:, 0])


def _is_angle(workspace: Workspace) -> list[bool]:
    """Tell which numbers of a task are angles."""
    return [name.endswith("_deg") for name in workspace.task_names]


def _nearby(
    plan: SweepPlan, known: Sequence[tuple[Any, ArrayLike]], tasks: Sequence[Any]
) -> list[tuple[NDArray[np.float64], ...]]:
    """Return the known policies next to each task: on a circle, one on either side."""
    if not known:
        return [()] * len(tasks)
    if not plan.workspace.further:
        return [_on_either_side(known, task) for task in tasks]
    points = coordinates(plan.workspace, [task for task, _ in known])
    queries, n_numbers = coordinates(plan.workspace, tasks), points.shape[1]
    found = find_neighbors(points, queries, n_numbers + 1)
    return [tuple(np.asarray(known[k][1]) for k in row) for row in found]


def _on_either_side(
    known: Sequence[tuple[float, ArrayLike]], task: float
) -> tuple[NDArray[np.float64], ...]:
    """Return the known policies next to a task, before and after it."""
    before = min(known, key=lambda other: (task - other[0]) % 360)
    after = min(known, key=lambda other: (other[0] - task) % 360)
    return np.asarray(before[1]), np.asarray(after[1])


def _row(plan: SweepPlan, task: Any, result: SearchResult) -> dict[str, Any]:
    """Put a result into columns."""
    names, pays = plan.workspace.task_names, plan.workspace.cost
    return {
        **dict(zip(names, np.atleast_1d(task).tolist(), strict=True)),
        **dict(zip(name_weights(result.policy.size), result.policy, strict=True)),
        "distance_m": result.error,
        "energy_rad2_per_s": result.energy,
        "cost": result.cost,
        "cost_distance": pays.error * result.error**2,
        "cost_energy": pays.energy * result.energy,
        "contact_impulse_n_s": result.contact_impulse,
        "evaluations": result.evaluations,
        "starts": len(result.runs),
        "starts_agreeing": result.n_agreeing,
        "margin": result.margin,
        "winner": _winner(plan, result.winner),
        "seed": plan.seed,
    }


def _winner(plan: SweepPlan, name: str) -> str:
    """Say where the run began that won."""
    if name.startswith("given") and plan.workspace.further:
        return "neighbour"
    return _GIVEN.get(name, name)
