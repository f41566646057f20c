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
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from tqdm import tqdm

from msc._parallel import Runner, open_workers
from msc.data import WEIGHTS
from msc.robot import Workspace
from msc.search._journal import Journal, identify_code
from msc.search._lockstep import N_PARALLEL, Search, run_in_lockstep
from msc.search._options import SearchOptions
from msc.search._policy import ENERGY_WEIGHT, ERROR_WEIGHT, SearchResult, search_steps

# Whose policies start runs.
_GIVEN = {"given 0": "task before", "given 1": "task after"}

_SHARE = 2 * N_PARALLEL  # tasks that a worker takes at a time, at most

# What is asked of a phase: by task number, policies to start from and what is known.
_Work = dict[int, tuple[Sequence[NDArray[np.float64]], SearchResult | None]]


@dataclass(frozen=True)
class SweepPlan:
    """What to search, and all that the outcome depends on.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks_deg : tuple of float
        Task angles (degrees).
    seed : int
        Seed of every draw.
    n_starts : int
        Independent starts a task, at most; one fewer where neighbours are known.
    guide : tuple of (float, tuple of float)
        Tasks and policies found earlier: neighbours that are known from the beginning.
    options : SearchOptions
        How the searches go about it.
    """

    workspace: Workspace
    tasks_deg: tuple[float, ...]
    seed: int
    n_starts: int = 3
    guide: tuple[tuple[float, tuple[float, ...]], ...] = ()
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
    stride = 1 if plan.guide else max(1, round(plan.options.coarse_deg * n_tasks / 360))
    strides = [stride]
    while strides[-1] > 1:  # 10, 5, 1: the tasks of a level are among those of the next
        strides.append(1 if strides[-1] % 2 else strides[-1] // 2)
    levels = [range(0, n_tasks, stride) for stride in strides]
    results: dict[int, SearchResult] = {}
    with (
        open_workers(jobs, dask, code=identify_code) as run,
        Journal(journal, plan) as done,
    ):
        search = partial(_batch, plan, run, done, progress=progress)
        for level, ring in enumerate(levels):
            new = [k for k in ring if k not in results]
            known: list[tuple[float, ArrayLike]] = list(plan.guide)
            known += [(tasks[k], result.policy) for k, result in results.items()]
            work: _Work = {k: (_on_either_side(known, tasks[k]), None) for k in new}
            results |= search(f"level {level}", work)
            _make_consistent(search, f"level {level}", ring, results, plan.options)
    return pd.DataFrame([_row(plan.seed, tasks[k], results[k]) for k in range(n_tasks)])


def _make_consistent(
    search: Callable[[str, _Work], dict[int, SearchResult]],
    level: str,
    ring: Sequence[int],
    results: dict[int, SearchResult],
    options: SearchOptions,
) -> None:
    """Search tasks again from their neighbours' policies until nothing spreads."""
    stale = set(range(len(ring)))
    for sweep in range(options.max_sweeps):
        turn = [place for place in sorted(stale) if place % 2 == sweep % 2]
        work: _Work = {}
        for place in turn:
            sides = results[ring[place - 1]], results[ring[(place + 1) % len(ring)]]
            starts = tuple(side.policy for side in sides)
            work[ring[place]] = starts, results[ring[place]]
        better = search(f"{level}, sweep {sweep}", work)
        stale -= set(turn)
        for place in turn:
            new, old = better[ring[place]].policy, results[ring[place]].policy
            if np.linalg.norm(new - old) > options.same * np.linalg.norm(old):
                stale |= {(place - 1) % len(ring), (place + 1) % len(ring)}
        results |= better
        if not stale:
            break


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


def _on_either_side(
    known: Sequence[tuple[float, ArrayLike]], task: float
) -> tuple[NDArray[np.float64], ...]:
    """Return the known policies next to a task, before and after it."""
    if not known:
        return ()
    before = min(known, key=lambda other: (task - other[0]) % 360)
    after = min(known, key=lambda other: (other[0] - task) % 360)
    return np.asarray(before[1]), np.asarray(after[1])


def _row(seed: int, task: float, result: SearchResult) -> dict[str, Any]:
    """Put a result into columns."""
    return {
        "task_deg": task,
        **dict(zip(WEIGHTS, result.policy.tolist(), strict=True)),
        "distance_m": result.error,
        "energy_rad2_per_s": result.energy,
        "cost": result.cost,
        "cost_distance": ERROR_WEIGHT * result.error**2,
        "cost_energy": ENERGY_WEIGHT * result.energy,
        "contact_impulse_n_s": result.contact_impulse,
        "evaluations": result.evaluations,
        "starts": len(result.runs),
        "starts_agreeing": result.n_agreeing,
        "margin": result.margin,
        "winner": _GIVEN.get(result.winner, result.winner),
        "seed": seed,
    }
