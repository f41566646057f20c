"""The search of many tasks: parallel, resumable, the same whatever the workers.

First every task on its own, then the consistency pass: tasks in even places, then those
in odd places, are searched again from their neighbours' policies, keeping whatever
costs least, until no behaviour spreads any further. The pass only lowers costs, and its
order does not depend on which worker is done first.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from joblib import Parallel, delayed, parallel_config
from numpy.typing import NDArray
from tqdm.auto import tqdm

from msc.search import (
    ENERGY_WEIGHT,
    ERROR_WEIGHT,
    SearchResult,
    Start,
    search_policy,
)
from msc.tables import WEIGHTS
from msc.workspace import Workspace

MAX_SWEEPS = 6  # of the consistency pass; it has always come to rest earlier
_NEIGHBOURS = ("task before", "task after", "guide before", "guide after")


@dataclass(frozen=True)
class Plan:
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
        Independent starts a task.
    guide : tuple of (float, tuple of float)
        Tasks and policies found earlier; the nearest on either side of each task are
        further neighbours in the consistency pass.
    """

    workspace: Workspace
    tasks_deg: tuple[float, ...]
    seed: int
    n_starts: int = 4
    guide: tuple[tuple[float, tuple[float, ...]], ...] = ()


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
    plan: Plan, *, jobs: int = 1, journal: Path | None = None, progress: bool = False
) -> pd.DataFrame:
    """Search the policies of many tasks.

    Parameters
    ----------
    plan : Plan
        What to search.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    journal : Path, optional
        File that keeps what is done, so that an interrupted search goes on from there.
        It is removed at the end by whoever keeps the table.
    progress : bool, default=False
        Whether to show progress bars on standard error.

    Returns
    -------
    DataFrame
        One row a task, with the columns of `msc.tables.COLUMNS`.
    """
    done = _Journal(journal, plan)
    tasks, n_tasks = plan.tasks_deg, len(plan.tasks_deg)
    guides = [_nearest_guides(plan, task) for task in tasks]
    jobs_done = {"search": {k: ((), None) for k in range(n_tasks)}}
    with parallel_config("loky", inner_max_num_threads=1):
        results = _batch(plan, jobs_done["search"], done, "search", jobs, progress)
        stale = set(range(n_tasks))
        for sweep in range(2 * MAX_SWEEPS):
            turn = [k for k in sorted(stale) if k % 2 == sweep % 2]
            work = {
                k: (
                    (
                        results[k - 1].policy,
                        results[(k + 1) % n_tasks].policy,
                        *(guides[k] if sweep < 2 else ()),
                    ),
                    results[k],
                )
                for k in turn
            }
            better = _batch(plan, work, done, f"sweep {sweep}", jobs, progress)
            stale -= set(turn)
            for k, result in better.items():
                if _differ(result, results[k]):
                    stale |= {(k - 1) % n_tasks, (k + 1) % n_tasks}
                results[k] = result
            if not stale:
                break
    return pd.DataFrame(
        [_row(plan.seed, tasks[k], results[k]) for k in range(n_tasks)]
    )


_Work = dict[int, tuple[Sequence[NDArray[np.float64]], SearchResult | None]]


def _batch(
    plan: Plan, work: _Work, done: _Journal, phase: str, jobs: int, progress: bool
) -> dict[int, SearchResult]:
    """Search the tasks of one phase, those that the journal knows excepted."""
    known = {k: done.results[phase, k] for k in work if (phase, k) in done.results}
    calls = (
        delayed(_search)(plan, k, *arguments)
        for k, arguments in work.items()
        if k not in known
    )
    found = Parallel(n_jobs=jobs, return_as="generator_unordered")(calls)
    bar = tqdm(
        found,
        desc=phase,
        initial=len(known),
        total=len(work),
        unit="task",
        disable=not progress or len(known) == len(work),
    )
    for k, result in bar:
        done.append(phase, k, result)
        known[k] = result
    return dict(sorted(known.items()))


def _search(
    plan: Plan,
    k: int,
    start_policies: Sequence[NDArray[np.float64]],
    incumbent: SearchResult | None,
) -> tuple[int, SearchResult]:
    """Search one task, in a worker."""
    return k, search_policy(
        plan.workspace,
        plan.tasks_deg[k],
        seed=plan.seed,
        n_starts=0 if incumbent else plan.n_starts,
        start_policies=start_policies,
        incumbent=incumbent,
    )


def _differ(one: SearchResult, other: SearchResult) -> bool:
    """Whether two results are different behaviours, not one a little further on."""
    apart = np.linalg.norm(one.policy - other.policy)
    return bool(apart > 0.05 * np.linalg.norm(other.policy))


def _nearest_guides(plan: Plan, task: float) -> tuple[NDArray[np.float64], ...]:
    """Return the policies of the guides next to a task, before and after it."""
    if not plan.guide:
        return ()
    before = min(plan.guide, key=lambda guide: (task - guide[0]) % 360)
    after = min(plan.guide, key=lambda guide: (guide[0] - task) % 360)
    return np.array(before[1]), np.array(after[1])


def _row(seed: int, task: float, result: SearchResult) -> dict[str, Any]:
    """Put a result into columns."""
    kind, _, number = result.winner.partition(" ")
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
        "starts": len(result.starts),
        "starts_agreeing": result.n_agreeing,
        "winner": _NEIGHBOURS[int(number)] if kind == "given" else result.winner,
        "seed": seed,
    }


class _Journal:
    """What a search has finished so far, one line of JSON a result."""

    def __init__(self, path: Path | None, plan: Plan) -> None:
        self.results: dict[tuple[str, int], SearchResult] = {}
        self._path = path
        header = json.dumps({"plan": _fingerprint(plan)})
        if path is None:
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text().split("\n") if path.is_file() else [""]
        if lines[0] != header:
            path.write_text(header + "\n")
            return
        path.write_text("".join(f"{line}\n" for line in lines[:-1]))  # no torn last line
        for line in lines[1:-1]:
            entry = json.loads(line)
            self.results[entry["phase"], entry["k"]] = _result(entry["result"])

    def append(self, phase: str, k: int, result: SearchResult) -> None:
        """Keep a result."""
        self.results[phase, k] = result
        if self._path is not None:
            entry = {"phase": phase, "k": k, "result": asdict(result)}
            with self._path.open("a") as file:
                file.write(json.dumps(entry, default=np.ndarray.tolist) + "\n")


def _result(entry: dict[str, Any]) -> SearchResult:
    """Rebuild a result from its JSON."""
    starts = tuple(
        Start(**{**start, "policy": np.array(start["policy"])})
        for start in entry["starts"]
    )
    fields = {**entry, "policy": np.array(entry["policy"]), "starts": starts}
    return SearchResult(**fields)


def _fingerprint(plan: Plan) -> str:
    """Identify a plan together with the code that carries it out."""
    digest = hashlib.sha256(repr(plan).encode())
    for name in ("workspace", "dmp", "kinematics", "arm", "search", "dataset"):
        digest.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return digest.hexdigest()
