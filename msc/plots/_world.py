"""A world and its arm from above, for figures and for sliders alike.

What stands in a world is listed once, by `outlines`. `draw_world` draws it into a panel
of a figure, in one of the `VIEWS`; `mark_world` makes marks of a slider of it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc
from numpy.typing import ArrayLike

from msc.plots._film import Scene
from msc.plots._slider import Mark, Panel
from msc.plots._style import GOAL, TRIO, Array, styled
from msc.robot import Circle, Rollout, Workspace, forward_kinematics

Span = tuple[float, float]


class View(NamedTuple):
    """How figures of one kind show a world: in the words of Matplotlib."""

    goals: dict[str, Any]  # the circle of goals
    goal: dict[str, Any]  # the task's
    frame: dict[str, Any]  # the axes, which are seen if they have names


_METRES: dict[str, Any] = {"xlabel": "x (m)", "ylabel": "y (m)"}
_HALVES = (-1, -0.5, 0, 0.5)
_RING = {"marker": "o", "mfc": "none", "zorder": 5}
_STAR = {"marker": "*", "color": GOAL, "mec": "white", "zorder": 6}

VIEWS = {
    "plan": View(  # the paper's Figure 1, and posters of sliders
        {"color": "red", "lw": 1.5},
        {"marker": "o", "color": GOAL, "ms": 8, "zorder": 5},
        {"xlim": (-1, 1), "ylim": (-1, 1), **_METRES},
    ),
    "sketch": View(  # what explains the arm
        {"color": GOAL, "lw": 1.2},
        {**_RING, "mec": GOAL, "ms": 9, "mew": 2},
        {"xlim": (-1, 0.8), "ylim": (-1, 0.8), "xticks": _HALVES, "yticks": _HALVES}
        | _METRES,
    ),
    "skill": View(
        {"color": GOAL, "lw": 1},
        {**_STAR, "ms": 13},
        {"xlim": (-0.95, 0.8), "ylim": (-0.95, 0.8)},
    ),
    "search": View(
        {"color": GOAL, "lw": 0.8}, {**_RING, "mec": GOAL, "ms": 8, "mew": 1.6}, {}
    ),
    "movement": View(
        {"color": "red", "lw": 0.8}, {**_RING, "mec": "red", "ms": 8, "mew": 1.6}, {}
    ),
}
FRAME = 3  # time steps from one picture of a film to the next: 20 pictures a second
TOUCHED = {"ec": TRIO[1], "lw": 2}  # the rim of an obstacle


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
    for (above, slant), world in zip(axes, workspaces, strict=True):
        draw_world(above, world)
        draw_arm(above, world, world.home)
        above.set_title(world.name)
        slant.imshow(Scene(world, size=720).shoot(world.home))
        slant.set_axis_off()
    return figure


# What stands in a world.


def outlines(world: Workspace) -> list[tuple[str, Circle]]:
    """List what is round and stands still: the circle of goals, and obstacles."""
    goals = Circle(0.0, 0.0, world.goal_radius)
    return [("ring", goals), *(("disc", circle) for circle in world.circles)]


def place_arm(rollouts: Sequence[Rollout], world: Workspace, every: int = 1) -> Array:
    """Return the arm's places (m) at every n-th step: (n_rollouts, n_times, 4, 2)."""
    joints = np.array([one.joints[::every] for one in rollouts])
    return forward_kinematics(joints, world.link_lengths)


def bounds_of(circles: Iterable[Circle], places: Array) -> tuple[Array, Array]:
    """Return lower and upper bounds (m) of circles and places."""
    centres, radii = np.split(np.array([*circles]).reshape(-1, 3), [2], axis=1)
    corners = np.concatenate([places.reshape(-1, 2), centres - radii, centres + radii])
    return corners.min(axis=0), corners.max(axis=0)


def square_around(world: Workspace, places: Array) -> tuple[Span, Span]:
    """Find a square (ranges of x and y, m) that holds a world and many places."""
    low, high = bounds_of((circle for _, circle in outlines(world)), places)
    middle, half = (low + high) / 2, 0.52 * (high - low).max()
    (left, bottom), (right, top) = (middle - half).tolist(), (middle + half).tolist()
    return (left, right), (bottom, top)


# In figures.


def draw_world(
    axis: Axes,
    world: Workspace,
    task_deg: float | None = None,
    *,
    view: str = "plan",
    touched: Collection[Circle] = (),
    **goal: Any,
) -> None:
    """Draw what stands in a world, and the goal of a task, into a panel."""
    look = VIEWS[view]
    for kind, circle in outlines(world):
        looks = {"fill": False, **look.goals} if kind == "ring" else {"fc": "black"}
        if kind == "disc":
            looks |= TOUCHED if circle in touched else {"ec": "black"}
        axis.add_patch(Disc((circle.x, circle.y), circle.radius, **looks))
    if view == "plan":
        draw_cut(axis, world, color="red")
        for angle in (0, 90):
            x, y = 0.8 * world.target(angle)
            axis.text(x, y, f"{angle}°", ha="center", va="center", color="red")
    if task_deg is not None:
        axis.plot(*world.target(task_deg), ls="", **{**look.goal, **goal})
    axis.set(aspect="equal", **look.frame)
    axis.set_axisbelow(True)
    if "xlabel" not in look.frame:
        axis.set_axis_off()


def draw_cut(axis: Axes, world: Workspace, color: str) -> None:
    """Draw where the circle of goals is cut open: the task of 0°."""
    axis.plot(*np.outer((0.93, 1.07), world.target(0)).T, color=color, lw=1.5)


def draw_arm(axis: Axes, world: Workspace, joints: ArrayLike, **links: Any) -> None:
    """Draw the arm in one pose: links, joints white, the end effector blue."""
    places = forward_kinematics(joints, world.link_lengths)
    draw_links(axis, places, {"lw": 5, "color": "0.45", "zorder": 2, **links})
    axis.plot(*places[-1], "o", color=TRIO[0], ms=6, zorder=3)


def draw_links(axis: Axes, places: Array, links: dict[str, Any], **joints: Any) -> None:
    """Draw links with round ends, and white joints at theirs."""
    axis.plot(*places.T, **{"solid_capstyle": "round", **links})
    looks = {"color": "white", "mec": "0.3", "ms": 5, "zorder": 3, **joints}
    axis.plot(*places[:-1].T, "o", **looks)


# In sliders.


def mark_world(world: Workspace) -> list[Mark]:
    """Show what stands in a world."""
    colours = {"ring": GOAL, "disc": "ink"}
    return [
        Mark(kind, [[x, y]], radius=radius, colour=colours[kind])
        for kind, (x, y, radius) in outlines(world)
    ]


def mark_goal(
    world: Workspace, task_deg: ArrayLike, kind: str = "disc", **look: Any
) -> Mark:
    """Show the goal of a task, or of one task a step."""
    look = {"radius": 0.025, "colour": GOAL, **look}
    if np.ndim(task_deg) == 0:
        return Mark(kind, [world.target(task_deg)], **look)
    return Mark(kind, world.target(task_deg)[:, None], "step", **look)


def mark_arm(
    rollouts: Sequence[Rollout], world: Workspace, every: int = FRAME, **look: Any
) -> Mark:
    """Show the arm at every n-th time step of one movement a step of the slider."""
    look = {"trail": {"width": 1.2, "opacity": 1.0, "dash": [4, 3]}, **look}
    return Mark("line", place_arm(rollouts, world, every), "time", **look)


def world_panel(
    alt: str,
    world: Workspace,
    marks: Sequence[Mark],
    bounds: tuple[Span, Span] = ((-1.0, 1.0), (-1.0, 1.0)),
) -> Panel:
    """Show a world from above, a metre to every side of the base, and marks on it."""
    return Panel(alt, *bounds, [*mark_world(world), *marks])
