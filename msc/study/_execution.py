"""What predicted policies do when the arm executes them."""

from __future__ import annotations

import pandas as pd
from numpy.typing import ArrayLike

from msc.robot import Workspace, cached_arm
from msc.search import cost


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
        The tasks, and what their searched policies cost: columns `task_deg` and `cost`.

    Returns
    -------
    DataFrame
        One row a task: `task_deg`, `error_cm` (distance of end effector and target at
        the end), `excess_cost` (cost of this policy minus that of the searched one)
        and `touched` (whether the arm met an obstacle).

    Examples
    --------
    >>> import numpy as np
    >>> tasks = pd.DataFrame({"task_deg": [90.0, 180.0], "cost": [0.05, 0.05]})
    >>> done = execute_policies(Workspace.free(), np.zeros((2, 6)), tasks)
    >>> bool((done["error_cm"] > 1).all()), done["touched"].tolist()
    (True, [False, False])
    """
    rollouts = cached_arm(workspace).execute_many(policies, table["task_deg"].tolist())
    return pd.DataFrame(
        {
            "task_deg": table["task_deg"].to_numpy(),
            "error_cm": [100 * rollout.error for rollout in rollouts],
            "excess_cost": [cost(rollout) for rollout in rollouts] - table["cost"],
            "touched": [rollout.touched for rollout in rollouts],
        }
    )


def summarise_execution(executed: pd.DataFrame) -> pd.DataFrame:
    """Summarise what execution costs, one row a method.

    Parameters
    ----------
    executed : DataFrame
        Rows as of `execute_policies`, with a column `method`.

    Returns
    -------
    DataFrame
        Excess cost (mean, median), centimetres (mean, standard deviation, median, 95th
        percentile), the share of tasks missed by less than 1 cm, and that which met an
        obstacle.
    """
    groups = executed.groupby("method", sort=False)
    error, excess = groups["error_cm"], groups["excess_cost"]
    return pd.DataFrame(
        {
            "excess cost, mean": excess.mean(),
            "excess cost, median": excess.median(),
            "error (cm), mean": error.mean(),
            "error (cm), std": error.std(),
            "error (cm), median": error.median(),
            "error (cm), 95 %": error.quantile(0.95),
            "share under 1 cm": error.agg(lambda cm: float((cm < 1).mean())),
            "share that touched": groups["touched"].mean(),
        }
    )
