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

    Its `plan` gives joint angles for `Arm.follow`. Returns "error_cm", "excess_cost"
    and "touched", as `measure_method` does, but no errors of policies.
    """
    angles = test.table["task_deg"].tolist()
    arm = cached_arm(workspace)
    sides = [
        arm.follow(method.plan(side), angles)
        for side in (test.tasks - SIDE, test.tasks + SIDE)
    ]
    paid = [[cost(rollout) for rollout in side] for side in sides]
    missed = [[100 * rollout.error for rollout in side] for side in sides]
    touched = [[rollout.touched for rollout in side] for side in sides]
    return {
        "error_cm": np.mean(missed, axis=0),
        "excess_cost": np.mean(paid, axis=0) - test.table["cost"].to_numpy(),
        "touched": np.any(touched, axis=0),
    }
