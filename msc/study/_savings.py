"""What predicting saves: predictions as starts of searches, and what all of it costs.

A rollout is the unit. Searches of test tasks begin at a prediction, with the small step
with which searches begin at a neighbour's policy, or from scratch. Each is timed: after
how many rollouts is it within a factor of what the task's policy in the table costs? A
search that ends in a worse basin never is; it counts as just that.
"""

from __future__ import annotations

import hashlib
import json
import math
import shutil
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc._parallel import call_in_order
from msc.data import Dataset, describe_origin, find_data, load_dataset
from msc.robot import Workspace
from msc.search import SearchOptions, search_curves
from msc.study._methods import build_method, fit_methods
from msc.study._sampling import draw_samples
from msc.study._store import identify_estimator, identify_module
from press import checksum, replace_file

SAVERS = (
    "charts",
    "single regression",
    "charts, one kernel",
    "single, one kernel",
    "CrKr",
    "nearest neighbour",
    "linear interpolation",
    "after Liu: mapped",
)
"""Whose predictions searches start from."""

N_SAMPLES, N_SETS, EVERY = 24, 3, 3  # training tasks, sets of them; of the test tasks
_PART = 5  # test tasks that a worker searches at a time

SCRATCH = "from scratch"
"""What searches without a prediction are called among methods."""

ONCE = "from scratch, one start"
"""And what they are called with a single start, as searches from predictions have."""

FACTORS = (1.05, 1.01)
"""Near enough: cost of the best policy so far, over that of the searched one."""


def measure_savings(
    workspace: Workspace,
    table: pd.DataFrame,
    starts: Mapping[str, ArrayLike],
    *,
    seed: int,
    n_starts: int = 4,
    factors: Sequence[float] = FACTORS,
    options: SearchOptions | None = None,
) -> pd.DataFrame:
    """Search test tasks from predictions and from scratch, and time the searches.

    Parameters
    ----------
    workspace : Workspace
        The world.
    table : DataFrame
        The test tasks, and what their searched policies cost: columns `task_deg` and
        `cost`.
    starts : mapping from str to array_like of shape (n_tasks, n_params)
        Predictions of each method, in the order of the table.
    seed : int
        Seed of all random draws.
    n_starts : int, default=4
        Independent starts of a search from scratch. From a prediction there is one run.
    factors : sequence of float, default=(1.05, 1.01)
        Shares of the searched cost that are near enough.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    DataFrame
        As `time_searches` has it, methods in order, those from scratch first.

    Raises
    ------
    ValueError
        If a method is called as searches from scratch are, or has not as many
        predictions as there are tasks.

    Examples
    --------
    >>> import numpy as np
    >>> table = pd.DataFrame({"task_deg": [200.0], "cost": [1e-9]})
    >>> found = measure_savings(
    ...     Workspace.free(),
    ...     table,
    ...     {"zero": np.zeros((1, 6))},
    ...     seed=0,
    ...     n_starts=1,
    ...     options=SearchOptions(max_evaluations=9),
    ... )
    >>> found[["method", "factor", "is_reached"]].to_numpy().tolist()
    [['from scratch', 1.05, False], ['from scratch', 1.01, False],
     ['zero', 1.05, False], ['zero', 1.01, False]]
    """
    if SCRATCH in starts:
        raise ValueError(f"starts has {SCRATCH!r}; wanted another name for a method")
    tasks, tables = table["task_deg"].tolist(), []
    given: dict[str, ArrayLike | None] = {SCRATCH: None, **starts}
    for name, policies in given.items():
        curves = search_curves(
            workspace,
            tasks,
            policies,
            seed=seed,
            n_starts=n_starts if policies is None else 0,
            options=options,
        )
        costs = [curve.costs for curve in curves]
        timed = time_searches(costs, table, factors=factors)
        tables.append(timed.assign(method=name))
    found = pd.concat(tables, ignore_index=True)
    return found[["method", *found.columns.drop("method")]]


def time_searches(
    costs: Sequence[NDArray[np.float64]],
    table: pd.DataFrame,
    *,
    factors: Sequence[float] = FACTORS,
) -> pd.DataFrame:
    """Count the rollouts until searches come near the searched cost.

    Parameters
    ----------
    costs : sequence of ndarray of shape (n_rollouts,)
        Of each task the costs of all its rollouts, in order.
    table : DataFrame
        The tasks: columns `task_deg` and `cost`.
    factors : sequence of float, default=(1.05, 1.01)
        Shares of the searched cost that are near enough.

    Returns
    -------
    DataFrame
        One row a task and factor, no entry of it missing: `task_deg`; `searched`, the
        cost in the table; `first` and `last`, cost of the first rollout (the jump-start
        of a prediction) and the least in the end (the asymptote); `n_rollouts` that the
        search took till it ended by itself; `factor`; `is_reached`; and `rollouts`
        until it was. Where it was not, these are all that were spent, as censored times
        are written.

    Raises
    ------
    ValueError
        If a task has no rollout, or there are not as many as in the table.

    Examples
    --------
    >>> table = pd.DataFrame({"task_deg": [0.0], "cost": [2.0]})
    >>> timed = time_searches([np.array([9.0, 2.1, 3.0, 2.05])], table)
    >>> timed[["factor", "is_reached", "rollouts"]].to_numpy().tolist()
    [[1.05, True, 2], [1.01, False, 4]]
    """
    if len(costs) != len(table) or not all(map(len, costs)):
        raise ValueError(
            f"costs are of {len(costs)} searches, {sum(map(bool, map(len, costs)))} of "
            f"them with a rollout; wanted one, with rollouts, for each of {len(table)} "
            "tasks"
        )
    rows = []
    for paid, task, searched in zip(
        costs, table["task_deg"], table["cost"], strict=True
    ):
        for factor in factors:
            near = np.flatnonzero(paid <= factor * searched)
            rows.append(
                {
                    "task_deg": float(task),
                    "searched": float(searched),
                    "first": float(paid[0]),
                    "last": float(paid.min()),
                    "n_rollouts": len(paid),
                    "factor": float(factor),
                    "is_reached": bool(near.size),
                    "rollouts": int(near[0]) + 1 if near.size else len(paid),
                }
            )
    return pd.DataFrame(rows)


def summarise_savings(timed: pd.DataFrame) -> pd.DataFrame:
    """Summarise timed searches, one row a method and factor.

    Parameters
    ----------
    timed : DataFrame
        From `measure_savings`.

    Returns
    -------
    DataFrame
        - `method`, `factor`, `n_tasks`;
        - `reached`: share of tasks that came near enough;
        - `worse_basin`: share of tasks whose run ended above 1.05 times the searched
          cost;
        - `median_rollouts`: until near enough, where never is longer than any time:
          infinite if half of all tasks never are;
        - `mean_rollouts`: until near enough, if searches that never are go on from
          scratch, and pay for both;
        - `reached_after_all`: share of tasks that are near enough then; those that even
          so are not count in the mean with all that they spent, which is too little;
        - `mean_spent`: rollouts till runs end by themselves, which is what is paid by
          who does not know what the searched policy costs;
        - `jump_start`, `asymptote`: median cost of the first rollout, and the least in
          the end, over the searched cost.

    Raises
    ------
    ValueError
        If there are no searches from scratch, or of other tasks.

    Examples
    --------
    >>> table = pd.DataFrame({"task_deg": [0.0, 9.0], "cost": [2.0, 2.0]})
    >>> scratch = [np.array([9.0, 5.0, 2.0])] * 2
    >>> given = [np.array([2.0]), np.array([3.0, 2.5])]
    >>> timed = pd.concat(
    ...     [
    ...         time_searches(scratch, table, factors=[1.05]).assign(method=SCRATCH),
    ...         time_searches(given, table, factors=[1.05]).assign(method="ours"),
    ...     ]
    ... )
    >>> summary = summarise_savings(timed).set_index("method")
    >>> summary[["reached", "median_rollouts", "mean_rollouts"]].loc["ours"].tolist()
    [0.5, inf, 3.0]
    """
    keys = ["task_deg", "factor"]
    scratch = timed[timed["method"] == SCRATCH].set_index(keys)
    rows = []
    for (method, factor), group in timed.groupby(["method", "factor"], sort=False):
        own = group.set_index(keys)
        if not own.index.isin(scratch.index).all():
            raise ValueError(
                f"{method!r} has searches of tasks that no {SCRATCH!r} has; wanted one "
                "of each"
            )
        reached, took = own["is_reached"], own["rollouts"]
        again = scratch.loc[own.index]
        goes_on = ~reached & (method != SCRATCH)
        never = took.astype(float).where(reached, math.inf)
        rows.append(
            {
                "method": method,
                "factor": factor,
                "n_tasks": len(own),
                "reached": float(reached.mean()),
                "worse_basin": float((own["last"] > 1.05 * own["searched"]).mean()),
                "median_rollouts": _median(never),
                "mean_rollouts": float((took + goes_on * again["rollouts"]).mean()),
                "reached_after_all": float((reached | again["is_reached"]).mean()),
                "mean_spent": float(own["n_rollouts"].mean()),
                "jump_start": float((own["first"] / own["searched"]).median()),
                "asymptote": float((own["last"] / own["searched"]).median()),
            }
        )
    return pd.DataFrame(rows)


def _median(values: ArrayLike) -> float:
    """Return the median of values that may be infinite."""
    ascending = np.sort(np.asarray(values, dtype=float))
    n = len(ascending)
    lower, upper = ascending[(n - 1) // 2], ascending[n // 2]
    return float(upper if math.isinf(upper) else (lower + upper) / 2)


def break_even(fixed: float, per_task: float, per_task_scratch: float) -> float:
    """Return the fewest tasks for which predicting costs less than searching each.

    Parameters
    ----------
    fixed : float
        Rollouts that come before the first prediction: searches of the training tasks,
        and practice.
    per_task : float
        Rollouts a task then; 0 if the prediction is taken as it is.
    per_task_scratch : float
        Rollouts of a search from scratch.

    Returns
    -------
    float
        How many tasks; infinite if never.

    Examples
    --------
    >>> break_even(2400, 20, 100), break_even(2400, 100, 100)
    (31.0, inf)
    """
    saved = per_task_scratch - per_task
    return math.floor(fixed / saved) + 1.0 if saved > 0 else math.inf


def run_savings(
    world: str,
    *,
    folder: Path | None = None,
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Search test tasks of a workspace from what methods predict.

    Parameters
    ----------
    world : {"free", "obstacles"}
        The workspace and its data.
    folder : Path, optional
        Where searches are kept till all are done, so that a run that was interrupted
        goes on; those of other tables, methods or code are not taken for these.
    seed : int, default=0
        Seed of the training sets, of methods and of the searches.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Fit for JSON; what is infinite is None. Under "summary" a row a method and
        factor, see `summarise_savings`; under "break_even" how many further tasks it
        takes until 24 searches, and searches of these from predictions, cost less than
        to search these from scratch. A search costs its rollouts until within 1.05
        times the searched cost; one that never is goes on from scratch, and pays for
        both.
    """
    grid, test = load_dataset(world), load_dataset(f"{world}_test")
    sets = draw_samples("even", grid.tasks, N_SAMPLES, n_draws=N_SETS, seed=seed)
    chosen = np.arange(0, len(test.tasks), EVERY)
    parts = [chosen[k : k + _PART] for k in range(0, len(chosen), _PART)]
    kept = None if folder is None else folder / _identify(world, seed)
    search = partial(_search_part, world, (grid, test), sets, seed=seed, kept=kept)
    found = call_in_order(
        search,
        [(part,) for part in parts],
        jobs=jobs,
        label=f"savings, {world}",
        progress=progress,
    )
    timed = pd.concat(found, ignore_index=True)
    once = timed.drop_duplicates(["method", "task_deg", "set"])  # of two factors
    summary = summarise_savings(timed)
    near = summary[summary["factor"] == max(FACTORS)].set_index("method")
    each = near["mean_rollouts"].drop(ONCE)
    scratch = float(each.pop(SCRATCH))
    rows = [
        {"method": method, "tasks": break_even(N_SAMPLES * scratch, paid, scratch)}
        for method, paid in each.items()
    ]
    if kept is not None:
        shutil.rmtree(kept)
    return {
        "workspace": world,
        "seed": seed,
        "n_samples": N_SAMPLES,
        "n_sets": len(sets),
        "n_tasks": len(chosen),
        "rollouts": int(once["n_rollouts"].sum()),
        "provenance": describe_origin(f"msc savings --seed {seed}", *_tables(world)),
        "summary": _plain(summary),
        "break_even": _plain(pd.DataFrame(rows)),
    }


def _tables(world: str) -> list[Path]:
    return [find_data() / f"{name}.csv" for name in (world, f"{world}_test")]


def _identify(world: str, seed: int) -> str:
    """Name what searches rest on."""
    where = Workspace.named(world)
    told = [f"{world} {seed} {SAVERS}", identify_module(__name__)]
    told += [checksum(table) for table in _tables(world)]
    built = (build_method(name, seed=seed, workspace=where) for name in SAVERS)
    told += [identify_estimator(one) for one in built]
    return f"{world}-{hashlib.sha256(' '.join(told).encode()).hexdigest()[:16]}"


def _search_part(
    world: str,
    datasets: tuple[Dataset, Dataset],
    sets: Sequence[NDArray[np.intp]],
    part: NDArray[np.intp],
    *,
    seed: int,
    kept: Path | None,
) -> pd.DataFrame:
    """Search some test tasks from scratch, and from the predictions of all methods."""
    path = None if kept is None else kept / f"{part[0]}.json"
    if path is not None and path.is_file():
        return pd.DataFrame(json.loads(path.read_text("utf-8")))
    (grid, test), where = datasets, Workspace.named(world)
    starts: dict[str, ArrayLike] = {}
    for number, chosen in enumerate(sets):
        known = grid.tasks[chosen], grid.policies[chosen], grid.table["cost"][chosen]
        fitted = fit_methods(*known, names=SAVERS, seed=seed, workspace=where)
        for name, method in fitted.items():
            starts[f"{number} {name}"] = method.predict(test.tasks[part])
    table = test.table.iloc[part]
    once = measure_savings(where, table, {}, seed=seed, n_starts=1)
    timed = measure_savings(where, table, starts, seed=seed)
    timed = pd.concat([once.assign(method=ONCE), timed], ignore_index=True)
    numbers = timed["method"].str.extract(r"^(\d+) ", expand=False).fillna("0")
    names = timed["method"].str.replace(r"^\d+ ", "", regex=True)
    timed = timed.assign(method=names, set=numbers.astype(int))
    if path is not None:
        replace_file(path, json.dumps(timed.to_dict("list")))
    return timed


def _plain(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Turn a table into rows fit for JSON."""
    return [
        {f"{key}": None if value == math.inf else value for key, value in row.items()}
        for row in table.to_dict("records")
    ]
