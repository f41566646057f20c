"""What several sliders show: a world from above, the task axis, films of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.plots._slider import Mark, Panel
from msc.plots._style import GOAL
from msc.robot import Rollout, Workspace, forward_kinematics

FLAT = 0.6  # height over width of the panels beside the arm
TASK_AXIS: dict[str, Any] = {
    "x_label": "task angle (degrees)",
    "x_ticks": (0, 90, 180, 270, 360),
}
WEIGHT_NAMES = ("w₁ˣ", "w₂ˣ", "w₃ˣ", "w₁ʸ", "w₂ʸ", "w₃ʸ")  # as `WEIGHT_LABELS`


def mark_world(workspace: Workspace) -> list[Mark]:
    """Show what stands still in a world from above.

    Parameters
    ----------
    workspace : Workspace
        The world.

    Returns
    -------
    list of Mark
        The circle of goals, and the obstacles.
    """
    circle = Mark("ring", [[0, 0]], radius=workspace.goal_radius, colour=GOAL)
    obstacles = (Mark("disc", [[x, y]], radius=r) for x, y, r in workspace.circles)
    return [circle, *obstacles]


def world_panel(alt: str, marks: Sequence[Mark]) -> Panel:
    """Show a world from above.

    Parameters
    ----------
    alt : str
        What it shows, for those who do not see it.
    marks : sequence of Mark
        What is drawn, from back to front.

    Returns
    -------
    Panel
        One metre to every side of the base.
    """
    return Panel(alt, (-1.0, 1.0), (-1.0, 1.0), marks)


def films(
    rollouts: Sequence[Rollout], world: Workspace, frame: int
) -> NDArray[np.float64]:
    """Place the arm at moments of movements.

    Parameters
    ----------
    rollouts : sequence of Rollout
        The movements.
    world : Workspace
        Whose arm.
    frame : int
        Time steps from one moment to the next.

    Returns
    -------
    ndarray of shape (n_rollouts, n_times, 4, 2)
        What `forward_kinematics` gives (m).
    """
    joints = np.array([one.joints[::frame] for one in rollouts])
    return forward_kinematics(joints, world.link_lengths)


def uprights(degrees: ArrayLike, bottom: float = 0.0) -> Mark:
    """Mark the chosen task by a vertical line.

    Parameters
    ----------
    degrees : array_like of shape (n_steps,)
        The tasks on the slider (degrees).
    bottom : float, default=0.0
        Where the panel begins.

    Returns
    -------
    Mark
        One line a step.
    """
    points = [[[float(angle), bottom]] for angle in np.asarray(degrees)]
    return Mark("upright", points, "step", width=1.0, opacity=0.5)
