"""The world and the arm, drawn from above and at a slant."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc
from numpy.typing import ArrayLike

from msc.plots._scene import Scene
from msc.plots._style import TRIO, styled
from msc.robot import Workspace, forward_kinematics

WEIGHT_LABELS = ("$w_1^x$", "$w_2^x$", "$w_3^x$", "$w_1^y$", "$w_2^y$", "$w_3^y$")


@styled
def plot_workspaces(*workspaces: Workspace) -> Figure:
    """Draw workspaces as the paper's Figure 1, and as the smooth view shows them.

    Parameters
    ----------
    *workspaces : Workspace
        One row each.

    Returns
    -------
    Figure
        Left the drawing from above, in metres: goal circle red, obstacles black; right
        the same seen at a slant.
    """
    n_rows = len(workspaces)
    figure, axes = plt.subplots(n_rows, 2, figsize=(7.4, 3.5 * n_rows), squeeze=False)
    for (plan, view), world in zip(axes, workspaces, strict=True):
        draw_world(plan, world)
        draw_arm(plan, world, world.home)
        plan.set_title(world.name)
        view.imshow(Scene(world, size=720).shoot(world.home))
        view.set_axis_off()
    return figure


def draw_world(axis: Axes, world: Workspace) -> None:
    """Draw goal circle, cut and obstacles into a panel.

    Parameters
    ----------
    axis : Axes
        The panel.
    world : Workspace
        The world.
    """
    axis.add_patch(Disc((0, 0), world.goal_radius, fill=False, color="red", lw=1.5))
    for circle in world.circles:
        axis.add_patch(Disc((circle.x, circle.y), circle.radius, color="black"))
    cut = world.target(0)
    axis.plot(*np.outer((0.93, 1.07), cut).T, color="red", lw=1.5)
    for angle in (0, 90):
        x, y = 0.8 * world.target(angle)
        axis.text(x, y, f"{angle}°", ha="center", va="center", color="red")
    axis.set(xlim=(-1, 1), ylim=(-1, 1), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    axis.set_axisbelow(True)


def draw_arm(axis: Axes, world: Workspace, joints: ArrayLike, **style: Any) -> None:
    """Draw the arm in one pose.

    Parameters
    ----------
    axis : Axes
        The panel.
    world : Workspace
        Whose arm.
    joints : array_like of shape (3,)
        Joint angles (rad).
    **style : dict
        Passed on to `Axes.plot`.
    """
    look = {"color": "0.45", "lw": 5, "solid_capstyle": "round", "zorder": 2}
    points = forward_kinematics(joints, world.link_lengths).T
    axis.plot(*points, **{**look, **style})
    axis.plot(*points[:, :-1], "o", color="white", mec="0.3", ms=5, zorder=3)
    axis.plot(*points[:, -1], "o", color=TRIO[0], ms=6, zorder=3)
