"""What a planner's movements are worth, of which there is no policy to compare."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import Dataset
from msc.robot import Workspace, cached_arm
from msc.search import cost
from msc.study._measure import SIDE


def measure_plans(
    method: Any, workspace: Workspace, test: Dataset
) -> dict[str, NDArray[Any]]:
    """Measure a fitted planner, one number a test task, from before and behind it.

    Parameters
    ----------
    method : estimator
        The planner: its `plan` gives joint angles for `Arm.follow`.
    workspace : Workspace
        Where they are executed.
    test : Dataset
        Test tasks.

    Returns
    -------
    dict from str to ndarray of shape (n_test_tasks,)
        "error_cm", "excess_cost" and "touched", as of `measure_method`: there are no
        policies to have errors.
    """
    tasks = workspace.tasks_in(test.table)
    arm = cached_arm(workspace)
    sides = [
        arm.follow(method.plan(side), tasks)
        for side in (test.tasks - SIDE, test.tasks + SIDE)
    ]
    paid = [[cost(rollout, workspace.cost) for rollout in side] for side in sides]
    missed = [[100 * rollout.error for rollout in side] for side in sides]
    touched = [[rollout.touched for rollout in side] for side in sides]
    return {
        "error_cm": np.mean(missed, axis=0),
        "excess_cost": np.mean(paid, axis=0) - test.table["cost"].to_numpy(),
        "touched": np.any(touched, axis=0),
    }
