"""Pictures that explain the arm: its poses, and what each weight does to a path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch
from matplotlib.patches import Circle as Disc
from numpy.typing import ArrayLike, NDArray

from msc.plots._style import GOAL, TRIO, styled
from msc.plots._world import draw_arm
from msc.robot import DMP, Rollout, Workspace, forward_kinematics

DASHES = ("-", "--", "-.", ":")
N_HEADINGS = 4  # of the last link at the goal; each gives up to two poses


@styled
def plot_poses(world: Workspace, task_deg: float) -> Figure:
    """Draw the arm's angles, and several poses that reach one goal.

    Parameters
    ----------
    world : Workspace
        Whose arm.
    task_deg : float
        The task (degrees).

    Returns
    -------
    Figure
        Left the home pose with its three joint angles, the goal circle and the task
        angle; right poses of the same arm whose end effector is at the goal.
    """
    goal = world.target(task_deg)
    figure, (angles, poses) = plt.subplots(1, 2, figsize=(7.4, 3.9))
    for axis in (angles, poses):
        _draw_ground(axis, world, goal)
    draw_arm(angles, world, world.home)
    _draw_angles(angles, world)
    _draw_task(angles, world, task_deg)
    angles.set_title("a pose is three angles, a task is one")
    for joints in poses_at(world, goal, N_HEADINGS):
        draw_arm(poses, world, joints, lw=3, color="0.6")
    poses.plot(*goal, "o", color=GOAL, ms=8, zorder=5)
    poses.set_title("many poses reach the same goal")
    return figure


def poses_at(
    world: Workspace, place: ArrayLike, n_headings: int
) -> NDArray[np.float64]:
    """Find poses that put the end effector at a place.

    Parameters
    ----------
    world : Workspace
        Whose arm.
    place : array_like of shape (2,)
        Where (m).
    n_headings : int
        How many headings of the last link are tried, evenly spaced.

    Returns
    -------
    ndarray of shape (n_poses, 3)
        Joint angles (rad); two poses, an elbow to either side, for every heading that
        leaves the last joint within reach of the other two links.

    Examples
    --------
    >>> world = Workspace.free()
    >>> joints = poses_at(world, (0.3, 0.4), 8)
    >>> ends = forward_kinematics(joints, world.link_lengths)[:, -1]
    >>> ends.round(9).tolist() == [[0.3, 0.4]] * 16
    True
    """
    first, second, third = world.link_lengths
    found = []
    for heading in np.linspace(0, 2 * np.pi, n_headings, endpoint=False):
        wrist = complex(*np.asarray(place, dtype=float)) - third * np.exp(1j * heading)
        cosine = (abs(wrist) ** 2 - first**2 - second**2) / (2 * first * second)
        if abs(cosine) <= 1:
            for elbow in (np.arccos(cosine), -np.arccos(cosine)):
                base = np.angle(wrist / (first + second * np.exp(1j * elbow)))
                found.append((base, elbow, heading - base - elbow))
    return np.array(found).reshape(-1, 3)


@styled
def plot_weights(world: Workspace, task_deg: float, strength: float) -> Figure:
    """Draw the basis functions over time, and the paths that single weights make.

    Parameters
    ----------
    world : Workspace
        Where.
    task_deg : float
        The task (degrees).
    strength : float
        The weight given to one basis function of x at a time, and its opposite.

    Returns
    -------
    Figure
        Left, over time: the shares of the basis functions, and what a weight of one
        adds to the way; right the paths, in the colours of their basis functions.
    """
    dmp = DMP()
    times = np.linspace(0, 1, 101)
    shares = dmp.forcing_basis(np.exp(-dmp.alpha * times / dmp.time_scale))
    ends = (
        forward_kinematics(world.home, world.link_lengths)[-1],
        world.target(task_deg),
    )
    units = np.eye(dmp.n_params)[: dmp.n_basis]
    response = dmp.path(units, (0, 0), (1, 1), times)[..., 0]
    response -= dmp.path(0 * units, (0, 0), (1, 1), times)[..., 0]
    figure = plt.figure(figsize=(7.4, 4.1))
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25))
    top = figure.add_subplot(grid[0, 0])
    low = figure.add_subplot(grid[1, 0], sharex=top)
    plane = figure.add_subplot(grid[:, 1])
    _draw_ground(plane, world, ends[1])
    plane.plot(*ends[0], "o", color="black", ms=5)
    plane.annotate("start", tuple(ends[0]), (8, -10), textcoords="offset points")
    plane.annotate(
        "goal", tuple(ends[1]), (8, 4), textcoords="offset points", color=GOAL
    )
    for k, colour in enumerate(TRIO[: dmp.n_basis]):
        look: Any = {"color": colour, "ls": DASHES[k]}
        top.plot(times, shares[:, k], **look)
        top.fill_between(times, shares[:, k], color=colour, alpha=0.12, lw=0)
        low.plot(times, 100 * response[k], label=f"$w_{k + 1}^x$", **look)
        for sign in (1, -1):
            path = dmp.path(sign * strength * units[k], *ends, times)
            plane.plot(*path.T, **look)
    for sign, text in ((1, "+"), (-1, "−")):
        end = dmp.path(sign * strength * units[0], *ends, times)[-1]
        plane.annotate(
            f"{text}{strength:g}",
            end,
            (6 * sign, 5),
            textcoords="offset points",
            ha="left" if sign > 0 else "right",
        )
    still = dmp.path(np.zeros(dmp.n_params), *ends, times)
    plane.plot(*still.T, color="black", lw=2.5)
    plane.set_title("the paths they make (black: no weights)")
    top.set(title="when each weight acts", ylabel="share $ψ_i / Σψ$")
    low.set(xlabel="time (s)", ylabel="moves by (% of the way)", xlim=(0, 1))
    low.set_title("what a weight of 1 adds")
    low.legend()
    return figure


@styled
def plot_followed(
    world: Workspace,
    task_deg: float,
    planned: Mapping[str, ArrayLike],
    rollouts: Mapping[str, Rollout],
) -> Figure:
    """Draw planned and executed paths, and how far apart they are.

    Parameters
    ----------
    world : Workspace
        Where.
    task_deg : float
        The task (degrees).
    planned : mapping from str to array_like of shape (n_steps + 1, 2)
        Places planned for the end effector (m), by name.
    rollouts : mapping from str to Rollout
        What the arm did, by the same names.

    Returns
    -------
    Figure
        Left the plane, planned ways as broad pale lines and executed ones on top of
        them; right the distances from the goal over time.
    """
    goal = world.target(task_deg)
    figure, (plane, left) = plt.subplots(
        1, 2, figsize=(7.4, 3.5), width_ratios=(1.1, 1)
    )
    _draw_ground(plane, world, goal)
    for k, (name, rollout) in enumerate(rollouts.items()):
        look: Any = {"color": TRIO[k % 3], "ls": DASHES[k % 4]}
        plan = np.asarray(planned[name])
        plane.plot(*plan.T, color="0.8", lw=6, solid_capstyle="round")
        plane.plot(*rollout.path.T, zorder=3, **look)
        draw_arm(plane, world, rollout.joints[-1], lw=3, alpha=0.3)
        times = np.arange(len(rollout.path)) / 60
        distance = 100 * np.hypot(*(rollout.path - goal).T)
        left.plot(times, distance, label=name, **look)
    plane.set_title("planned (broad) and executed")
    left.set(title="how far the hand is from its goal", xlabel="time (s)")
    left.set(ylabel="distance (cm)", ylim=(0, None))
    left.axvspan(1, times[-1], color="0.93", lw=0, zorder=0)
    left.legend()
    return figure


def _draw_ground(axis: Axes, world: Workspace, goal: NDArray[np.float64]) -> None:
    """Draw the goal circle, the goal, obstacles and the base's place."""
    axis.add_patch(Disc((0, 0), world.goal_radius, fill=False, color=GOAL, lw=1.2))
    for circle in world.circles:
        axis.add_patch(Disc((circle.x, circle.y), circle.radius, color="black"))
    axis.plot(*goal, "o", mfc="none", mec=GOAL, ms=9, mew=2, zorder=5)
    axis.set(xlim=(-1, 0.8), ylim=(-1, 0.8), aspect="equal", xlabel="x (m)")
    axis.set(ylabel="y (m)", xticks=(-1, -0.5, 0, 0.5), yticks=(-1, -0.5, 0, 0.5))
    axis.set_axisbelow(True)


def _draw_angles(axis: Axes, world: Workspace) -> None:
    """Write the joint angles beside the joints of the home pose."""
    places = forward_kinematics(world.home, world.link_lengths)
    before = np.rad2deg(np.cumsum((0.0, *world.home[:2])))
    for k, (angle, place) in enumerate(zip(world.home, places, strict=False)):
        start, turn = before[k], np.rad2deg(angle)
        ahead = place + 0.2 * np.array(
            [np.cos(np.deg2rad(start)), np.sin(np.deg2rad(start))]
        )
        axis.plot(*np.transpose([place, ahead]), color="0.3", lw=0.8, ls=":")
        ends = sorted((start, start + turn))
        look: Any = {"theta1": ends[0], "theta2": ends[1], "color": TRIO[0]}
        axis.add_patch(Arc(place, 0.26, 0.26, lw=1.5, **look))
        middle = np.deg2rad(start + turn / 2)
        at = place + 0.2 * np.array([np.cos(middle), np.sin(middle)])
        axis.text(at[0], at[1], f"$q_{k + 1}$", color=TRIO[0], ha="center", va="center")
    axis.annotate("end effector", places[-1], (6, -12), textcoords="offset points")
    axis.annotate("base", places[0], (8, -4), textcoords="offset points")


def _draw_task(axis: Axes, world: Workspace, task_deg: float) -> None:
    """Draw the task angle, from the cut to the goal."""
    cut, radius = world.target(0), 0.62 * world.goal_radius
    axis.plot(*np.outer((0.93, 1.07), cut).T, color=GOAL, lw=1.5)
    axis.annotate("0°", tuple(1.1 * cut), color=GOAL, ha="center", va="bottom")
    turn = np.deg2rad(np.linspace(0, task_deg, 60) + world.cut_deg)
    axis.plot(radius * np.cos(turn), radius * np.sin(turn), color=GOAL, lw=1)
    axis.add_patch(
        FancyArrowPatch(
            (radius * np.cos(turn[-4]), radius * np.sin(turn[-4])),
            (radius * np.cos(turn[-1]), radius * np.sin(turn[-1])),
            arrowstyle="-|>",
            mutation_scale=9,
            color=GOAL,
        )
    )
    middle = turn[len(turn) // 2]
    at = 1.1 * radius * np.array([np.cos(middle), np.sin(middle)])
    axis.annotate(
        f"$τ$ = {task_deg:g}°", tuple(at), color=GOAL, ha="center", va="bottom"
    )
    for end in (0.0, task_deg):
        axis.plot(*np.outer((0, 1), world.target(end)).T, color=GOAL, lw=0.6, ls=":")
