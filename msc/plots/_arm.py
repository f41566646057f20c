"""Pictures that explain the arm: its poses, and what each weight does to a path."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyArrowPatch
from numpy.typing import ArrayLike

from msc.plots._slider import Mark, Panel, Slider, poster
from msc.plots._style import GOAL, TRIO, WEIGHT_NAMES, Array, styled
from msc.plots._world import (
    draw_arm,
    draw_cut,
    draw_world,
    mark_arm,
    mark_goal,
    world_panel,
)
from msc.robot import DMP, Arm, Rollout, Workspace, check_policies, forward_kinematics
from msc.search import cost

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
        draw_world(axis, world, task_deg, view="sketch")
    draw_arm(angles, world, world.home)
    _draw_angles(angles, world)
    _draw_task(angles, world, task_deg)
    angles.set_title("a pose is three angles, a task is one")
    for joints in poses_at(world, goal, N_HEADINGS):
        draw_arm(poses, world, joints, lw=3, color="0.6")
    poses.plot(*goal, "o", color=GOAL, ms=8, zorder=5)
    poses.set_title("many poses reach the same goal")
    return figure


def poses_at(world: Workspace, place: ArrayLike, n_headings: int) -> Array:
    """Find poses (rad) that put the end effector at a place, by headings of its link.

    An elbow to either side, for every heading that leaves the wrist within reach.

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
    shares = _shares(dmp, times)
    start = forward_kinematics(world.home, world.link_lengths)[-1]
    ends = start, world.target(task_deg)
    units = np.eye(dmp.n_params)[: dmp.n_basis]
    response = dmp.path(units, (0, 0), (1, 1), times)[..., 0]
    response -= dmp.path(0 * units, (0, 0), (1, 1), times)[..., 0]
    figure = plt.figure(figsize=(7.4, 4.1))
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25))
    top = figure.add_subplot(grid[0, 0])
    low = figure.add_subplot(grid[1, 0], sharex=top)
    plane = figure.add_subplot(grid[:, 1])
    draw_world(plane, world, task_deg, view="sketch")
    plane.plot(*start, "o", color="black", ms=5)
    beside: Any = {"textcoords": "offset points"}
    plane.annotate("start", tuple(start), (8, -10), **beside)
    plane.annotate("goal", tuple(ends[1]), (8, 4), color=GOAL, **beside)
    for k, colour in enumerate(TRIO[: dmp.n_basis]):
        look: Any = {"color": colour, "ls": DASHES[k]}
        top.plot(times, shares[:, k], **look)
        top.fill_between(times, shares[:, k], color=colour, alpha=0.12, lw=0)
        low.plot(times, 100 * response[k], label=f"$w_{k + 1}^x$", **look)
        for sign in (1, -1):
            path = dmp.path(sign * strength * units[k], *ends, times)
            plane.plot(*path.T, **look)
    for sign, text, side in ((1, "+", "left"), (-1, "−", "right")):
        end = dmp.path(sign * strength * units[0], *ends, times)[-1]
        plane.annotate(f"{text}{strength:g}", end, (6 * sign, 5), ha=side, **beside)
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
    draw_world(plane, world, task_deg, view="sketch")
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


def _shares(dmp: DMP, times: Array) -> Array:
    """Return the shares of the basis functions over time (s), which add up to one."""
    return dmp.forcing_basis(np.exp(-dmp.alpha * times / dmp.time_scale))


def _towards(angle_deg: ArrayLike) -> Array:
    """Return points at a distance of one."""
    angle = np.deg2rad(angle_deg)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _draw_angles(axis: Axes, world: Workspace) -> None:
    """Write the joint angles beside the joints of the home pose."""
    places = forward_kinematics(world.home, world.link_lengths)
    turns = np.rad2deg(world.home)
    before = np.cumsum([0.0, *turns[:2]])  # where the link before points to
    for k, (start, turn, place) in enumerate(zip(before, turns, places, strict=False)):
        ahead = place + 0.2 * _towards(start)
        axis.plot(*np.transpose([place, ahead]), color="0.3", lw=0.8, ls=":")
        low, high = sorted((start, start + turn))
        arc = Arc(place, 0.26, 0.26, theta1=low, theta2=high, lw=1.5, color=TRIO[0])
        axis.add_patch(arc)
        at = place + 0.2 * _towards(start + turn / 2)
        axis.text(at[0], at[1], f"$q_{k + 1}$", color=TRIO[0], ha="center", va="center")
    axis.annotate("end effector", places[-1], (6, -12), textcoords="offset points")
    axis.annotate("base", places[0], (8, -4), textcoords="offset points")


def _draw_task(axis: Axes, world: Workspace, task_deg: float) -> None:
    """Draw the task angle, from the cut to the goal."""
    look: Any = {"color": GOAL, "ha": "center", "va": "bottom"}
    draw_cut(axis, world, GOAL)
    axis.annotate("0°", tuple(1.1 * world.target(0)), **look)
    turn = 0.62 * world.target(np.linspace(0, task_deg, 60))
    axis.plot(*turn.T, color=GOAL, lw=1)
    ends: Any = turn[[-4, -1]]
    head = FancyArrowPatch(*ends, arrowstyle="-|>", mutation_scale=9, color=GOAL)
    axis.add_patch(head)
    axis.annotate(f"$τ$ = {task_deg:g}°", tuple(1.1 * turn[30]), **look)
    for end in (0.0, task_deg):
        axis.plot(*np.outer((0, 1), world.target(end)).T, color=GOAL, lw=0.6, ls=":")


def slide_weight(
    arm: Arm, policy: ArrayLike, task_deg: float, weight: int, changes: ArrayLike
) -> Slider:
    """Let the reader change one weight of a policy and see what the arm does.

    Parameters
    ----------
    arm : Arm
        What executes the policies.
    policy : array_like of shape (n_params,)
        The policy that is changed.
    task_deg : float
        The task (degrees).
    weight : int
        Which weight, counted from 0.
    changes : array_like of shape (n_steps,)
        What is added to it, step by step, in ascending order.

    Returns
    -------
    Slider
        Three panels: the arm, the force over time, the cost over the change.

    Raises
    ------
    ValueError
        If the policy has no such weight.
    """
    base = check_policies(policy, arm.dmp.n_params, single=True)
    added = np.asarray(changes, float)
    if not 0 <= weight < len(base):
        raise ValueError(f"weight={weight}; wanted one from 0 to {len(base) - 1}")
    policies = base + added[:, None] * np.eye(len(base))[weight]
    rollouts = arm.execute_many(policies, task_deg)
    costs = np.array([cost(rollout) for rollout in rollouts])
    called = WEIGHT_NAMES[weight]
    first = int(np.argmax(np.abs(added) == np.abs(added).max()))
    captions = [
        f"{called} = {policies[k, weight]:.1f} ({change:+.3g}): ends "
        f"{100 * rollout.error:.1f} cm from the goal, cost {costs[k]:.3f}."
        for k, (change, rollout) in enumerate(zip(added, rollouts, strict=True))
    ]
    return Slider(
        name=f"change of {called}",
        labels=[f"{change:+.3g}" for change in added],
        captions=captions,
        panels=[
            _arm_panel(arm, task_deg, rollouts),
            _force_panel(arm, policies, weight),
            _cost_panel(added, costs),
        ],
        poster=_draw_ways(arm, task_deg, rollouts, first),
        poster_alt="The way of the end effector, bent by one weight changed in steps.",
        first=first,
    )


def _arm_panel(arm: Arm, task_deg: float, rollouts: list[Rollout]) -> Panel:
    """Show the arm from above, and the way of its end effector."""
    world, trail = arm.workspace, {"width": 2.0, "opacity": 1.0}
    look: Any = {"colour": TRIO[0], "width": 4.0, "opacity": 0.5, "trail": trail}
    marks = mark_goal(world, task_deg), mark_arm(rollouts, world, **look)
    alt = "The arm from above, with the goal and the way of its end effector."
    return world_panel(alt, world, marks)


def _force_panel(arm: Arm, policies: Array, weight: int) -> Panel:
    """Show the force that the weight belongs to, over time."""
    dmp = arm.dmp
    times = np.linspace(0, 1, 41)
    dimension = weight // dmp.n_basis
    own = slice(dimension * dmp.n_basis, (dimension + 1) * dmp.n_basis)
    forces = policies[:, own] @ _shares(dmp, times).T
    low, high = min(0.0, float(forces.min())), max(0.0, float(forces.max()))
    margin = 0.08 * (high - low)
    moving = [np.c_[times, force] for force in forces]
    return Panel(
        f"The force of {'xy'[dimension]} over time.",
        (0.0, 1.0),
        (low - margin, high + margin),
        [
            Mark("line", [[0, 0], [1, 0]], width=0.8, opacity=0.6),
            Mark("line", moving, "step", colour=TRIO[0], width=2.5),
        ],
        x_label="time (s)",
        y_label=f"push f of {'xy'[dimension]}",
        x_ticks=(0, 0.5, 1),
        y_ticks=(round(low), 0, round(high)),
    )


def _cost_panel(added: Array, costs: Array) -> Panel:
    """Show the cost over the change, with the chosen one marked."""
    points, top = np.c_[added, costs], float(costs.max())
    ends = float(added[0]), float(added[-1])
    return Panel(
        "The cost over the change of the weight, with the chosen one marked.",
        ends,
        (-0.04 * top, 1.05 * top),
        [
            Mark("line", points, colour=TRIO[0]),
            Mark("dots", points[:, None], "step", colour=TRIO[0], width=5),
        ],
        x_label="change of the weight",
        y_label="cost",
        x_ticks=(ends[0], 0, ends[1]),
        y_ticks=(0, float(f"{top / 2:.1g}"), float(f"{top:.1g}")),
    )


@poster
def _draw_ways(
    axis: Axes, arm: Arm, task_deg: float, rollouts: list[Rollout], first: int
) -> None:
    """Draw all ways in one picture, and the pose at the end of one."""
    draw_world(axis, arm.workspace, task_deg)
    for rollout in rollouts[:: max(1, len(rollouts) // 9)]:
        axis.plot(*rollout.path.T, color="0.75", lw=1)
    axis.plot(*rollouts[first].path.T, color=TRIO[0], lw=2.5)
    draw_arm(axis, arm.workspace, rollouts[first].joints[-1], alpha=0.5)
