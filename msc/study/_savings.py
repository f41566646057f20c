"""What predicting saves: predictions as starts of searches, and what all of it costs.

A rollout is the unit. Searches of test tasks begin at a prediction, with the small step
with which searches begin at a neighbour's policy, or from scratch. Each is timed: after
how many rollouts is it within a factor of what the task's policy in the table costs? A
search that ends in a worse basin never is; it counts as just that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc._parallel import call_in_order
from msc.data import Dataset, describe_origin, find_data, load_dataset
from msc.robot import Workspace
from msc.search import SearchOptions, search_curves
from msc.study._methods import fit_methods
from msc.study._sampling import draw_samples

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
                    "rollouts": int(once["n_rollouts"].sum()),
        "provenance": describe_origin(f"msc savings --seed {seed}", *tables),
        "summary": _plain(summary),
        "break_even": _plain(pd.DataFrame(rows)),
    }


def _search_part(
    world: str,
    datasets: tuple[Dataset, Dataset],
    sets: Sequence[NDArray[np.intp]],
    seed: int,
    part: NDArray[np.intp],
) -> pd.DataFrame:
    """Search some test tasks from scratch, and from the predictions of all methods."""
    (grid, test), where = datasets, Workspace.named(world)
    starts: dict[str, ArrayLike] = {}
    for number, chosen in enumerate(sets):
        known = grid.tasks[chosen], grid.policies[chosen], grid.table["cost"][chosen]
        fitted = fit_methods(*known, names=SAVERS, seed=seed, workspace=where)
        for name, method in fitted.items():
            starts[f"{number} {name}"] = method.predict(test.tasks[part])
    timed = measure_savings(where, test.table.iloc[part], starts, seed=seed)
    numbers = timed["method"].str.extract(r"^(\d+) ", expand=False).fillna("0")
    names = timed["method"].str.replace(r"^\d+ ", "", regex=True)
    return timed.assign(method=names, set=numbers.astype(int))


def _plain(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Turn a table into rows fit for JSON."""
    return [
        {f"{key}": None if value == math.inf else value for key, value in row.items()}
        for row in table.to_dict("records")
    ]
