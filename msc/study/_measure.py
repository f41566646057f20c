"""What a method's predictions are worth: errors of policies, and of what these do.

A test task may lie half-way between two training tasks, and which is nearest is then
for rounding to say. So every test task is predicted twice, from just before it and from
just behind it, and each prediction counts half.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.data import Dataset
from msc.robot import Workspace, cached_arm, check_policies
from msc.search import cost

Array = NDArray[np.float64]

TRUE_GATE = ", true gate"  # of such a method: test tasks' own policies tell charts
RAW = ("mse", "standardised mse", "error_cm", "excess_cost", "touched")
SIDE = 1e-9  # rad; a test task is predicted from so far before and behind it
_OTHER = 1e-3  # of a weight; predictions so far apart are two
# What a policy did for a task, in a world: methods and training sets often predict the
# same, and it would do the same again, to the bit.
_DONE: dict[tuple[Any, ...], tuple[float, float, bool]] = {}
_MOST = 200_000  # some 50 MB


def measure_method(
    name: str,
    method: Any,
    workspace: Workspace,
    datasets: tuple[Dataset, Dataset],
    trained: NDArray[np.intp],
) -> dict[str, NDArray[Any]]:
    """Measure a fitted method in every way, one number a test task.

    Parameters
    ----------
    name : str
        What it is called.
    method : estimator
        The method.
    workspace : Workspace
        Where its policies are executed.
    datasets : (Dataset, Dataset)
        Grid and test tasks.
    trained : ndarray of int
        Which grid tasks it was fitted to.

    Returns
    -------
    dict from str to ndarray of shape (n_test_tasks,)
        "mse", "standardised mse", "error_cm", "excess_cost" and "touched"; of the
        charts also "mse, chart known".
    """
    grid, test = datasets
    known = {}
    if TRUE_GATE in name:
        known["chart"] = known_charts(method, grid.policies[trained], test.policies)
    predicted = predict_from_both_sides(method, test.tasks, **known)
    spread = grid.policies.var(axis=0)
    found = {
        "mse": squared_error(predicted, test.policies),
        "standardised mse": squared_error(predicted, test.policies, spread),
    }
    if name == "charts":
        chart = known_charts(method, grid.policies[trained], test.policies)
        told = predict_from_both_sides(method, test.tasks, chart=chart)
        found["mse, chart known"] = squared_error(told, test.policies)
    done = execute_both(workspace, predicted, test.table)
    columns = "error_cm", "excess_cost", "touched"
    return found | {column: done[column].to_numpy() for column in columns}


def known_charts(method: Any, trained: Array, policies: Array) -> NDArray[np.intp]:
    """Return charts of policies: that of the nearest training policy."""
    apart = np.linalg.norm(policies[:, None] - trained, axis=2)
    return np.asarray(method.charts_[apart.argmin(axis=1)])


def predict_from_both_sides(method: Any, tasks: Array, **known: Any) -> Array:
    """Predict tasks from before and from behind (2, n_tasks, n_params)."""
    return np.stack(
        [method.predict(side, **known) for side in (tasks - SIDE, tasks + SIDE)]
    )


def squared_error(
    predicted: Array, policies: Array, units: Array | float = 1.0
) -> Array:
    """Average squared errors over both sides and all weights, each in its unit."""
    return np.asarray(np.mean((predicted - policies) ** 2 / units, axis=(0, 2)))


def execute_both(
    workspace: Workspace, predicted: Array, table: pd.DataFrame
) -> pd.DataFrame:
    """Execute predictions; of two for a task the mean, and any contact, counts."""
    before, behind = predicted
    done = execute_policies(workspace, before, table)
    other = np.abs(behind - before).max(axis=1) > _OTHER
    again = execute_policies(workspace, behind[other], table[other])
    for column in ("error_cm", "excess_cost"):
        done.loc[other, column] = (done.loc[other, column] + again[column]) / 2
    done.loc[other, "touched"] |= again["touched"]
    return done


def execute_policies(
    workspace: Workspace, policies: ArrayLike, table: pd.DataFrame
) -> pd.DataFrame:
    """Execute one policy a task and measure it against the searched one.

    Parameters
    ----------
    workspace : Workspace
        Where.
    policies : array_like of shape (n_tasks, n_params)
        Weights of Eq. 7, in the order of the table.
    table : DataFrame
        The tasks, and what their searched policies cost: columns `task_deg`, further
        numbers of tasks if they have any, and `cost`.

    Returns
    -------
    DataFrame
        One row a task: `task_deg`, `error_cm` (distance of end effector and target at
        the end), `excess_cost` (cost of this policy minus that of the searched one)
        and `touched` (whether the arm met an obstacle).

    Raises
    ------
    ValueError
        If there is not one finite policy for each task.

    Examples
    --------
    >>> import numpy as np
    >>> tasks = pd.DataFrame({"task_deg": [90.0, 180.0], "cost": [0.05, 0.05]})
    >>> done = execute_policies(Workspace.free(), np.zeros((2, 6)), tasks)
    >>> bool((done["error_cm"] > 1).all()), done["touched"].tolist()
    (True, [False, False])
    """
    names = list(workspace.task_names)
    tasks = [tuple(task) for task in table[names].to_numpy().tolist()]
    rows = check_policies(policies, workspace.dmp.n_params)
    if len(rows) != len(tasks):
        raise ValueError(f"{len(rows)} policies for {len(tasks)} tasks; wanted as many")
    keys = [(workspace, *key) for key in zip(tasks, map(bytes, rows), strict=True)]
    known = {key: _DONE[key] for key in keys if key in _DONE}
    new = {key: place for place, key in enumerate(keys) if key not in known}
    asked: list[Any] = [task if workspace.further else task[0] for _, task, _ in new]
    rollouts = cached_arm(workspace).execute_many(rows[[*new.values()]], asked)
    for key, rollout in zip(new, rollouts, strict=True):
        paid = cost(rollout, workspace.cost)
        known[key] = 100 * rollout.error, paid, rollout.touched
    if len(_DONE) > _MOST:
        _DONE.clear()
    _DONE.update(known)
    error_cm, costs, touched = np.array([known[key] for key in keys]).reshape(-1, 3).T
    return pd.DataFrame(
        {
            "task_deg": table["task_deg"].to_numpy(),
            "error_cm": error_cm,
            "excess_cost": costs - table["cost"],
            "touched": touched.astype(bool),
        }
    )
