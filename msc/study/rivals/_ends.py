"""Where the movements of tasks begin and end, tasks as a learner is given them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from msc.robot import DMP, Workspace, forward_kinematics
from msc.search import tasks_at

Array = NDArray[np.float64]


def find_homes(workspace: Workspace, X: Array) -> Array:
    """Return joint angles in which movements begin: (n_tasks, 3) radians."""
    return workspace.home_of(tasks_at(workspace, X))


def find_ends(workspace: Workspace, X: Array) -> tuple[Array, Array]:
    """Return where the end effector starts, and the goals, each (n_tasks, 2) metres."""
    arms = forward_kinematics(find_homes(workspace, X), workspace.link_lengths)
    return arms[:, -1], workspace.target(tasks_at(workspace, X))


def find_ways(workspace: Workspace, X: Array) -> Array:
    """Return from where movements start to their goals: (n_tasks, 2) metres."""
    starts, goals = find_ends(workspace, X)
    return np.asarray(goals - starts)


def check_fit(workspace: Workspace, dmp: DMP, X: Array, y: Array) -> None:
    """Refuse what are no tasks of a world, or no policies of a DMP."""
    wanted = len(workspace.task_names), dmp.n_params
    if (X.shape[1:], y.shape[1:]) != ((wanted[0],), (wanted[1],)):
        raise ValueError(
            f"X has shape {X.shape} and y {y.shape}; wanted (n_tasks, {wanted[0]}) and "
            f"(n_tasks, {wanted[1]})"
        )
