"""A slider over one weight of a policy: the path bends, the cost answers."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from msc.plots._execution import FRAME
from msc.plots._marks import WEIGHT_NAMES, films, mark_world, world_panel
from msc.plots._slider import Mark, Panel, Slider
from msc.plots._style import GOAL, TRIO, styled
from msc.plots._world import draw_arm, draw_world
from msc.robot import Arm, Rollout, check_policies
from msc.search import cost


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
    moving = films(rollouts, arm.workspace, FRAME)
    return Slider(
        name=f"change of {called}",
        labels=[f"{change:+.3g}" for change in added],
        captions=captions,
        panels=[
            _arm_panel(arm, task_deg, moving),
            _force_panel(arm, policies, weight),
            _cost_panel(added, costs),
        ],
        poster=_poster(arm, task_deg, rollouts, first),
        poster_alt="The way of the end effector, bent by one weight changed in steps.",
        first=first,
        n_times=moving.shape[1],
    )


def _arm_panel(arm: Arm, task_deg: float, moving: NDArray[np.float64]) -> Panel:
    """Show the arm from above, and the way of its end effector."""
    world = arm.workspace
    marks = mark_world(world)
    goal = [world.target(task_deg)]
    marks.append(Mark("disc", goal, colour=GOAL, radius=0.025))
    trail: dict[str, Any] = {"width": 2.0, "opacity": 1.0}
    look: dict[str, Any] = {"colour": TRIO[0], "width": 4.0, "opacity": 0.5}
    marks.append(Mark("line", moving, "time", trail=trail, **look))
    alt = "The arm from above, with the goal and the way of its end effector."
    return world_panel(alt, marks)


def _force_panel(arm: Arm, policies: NDArray[np.float64], weight: int) -> Panel:
    """Show the force that the weight belongs to, over time."""
    dmp = arm.dmp
    times = np.linspace(0, 1, 41)
    basis = dmp.forcing_basis(np.exp(-dmp.alpha * times / dmp.time_scale))
    own = slice(weight // dmp.n_basis * dmp.n_basis, None)
    forces = policies[:, own][:, : dmp.n_basis] @ basis.T
    low, high = min(0.0, float(forces.min())), max(0.0, float(forces.max()))
    margin = 0.08 * (high - low)
    box = (0.0, 1.0), (low - margin, high + margin)
    marks = [Mark("line", [[0, 0], [1, 0]], width=0.8, opacity=0.6)]
    moving = [np.c_[times, force] for force in forces]
    marks.append(Mark("line", moving, "step", colour=TRIO[0], width=2.5))
    name = "xy"[weight // dmp.n_basis]
    return Panel(
        f"The force of {name} over time.",
        *box,
        marks,
        x_label="time (s)",
        y_label=f"force f of {name}",
        x_ticks=(0, 0.5, 1),
        y_ticks=(round(low), 0, round(high)),
    )


def _cost_panel(added: NDArray[np.float64], costs: NDArray[np.float64]) -> Panel:
    """Show the cost over the change, with the chosen one marked."""
    points, top = np.c_[added, costs], float(costs.max())
    look: dict[str, Any] = {"colour": TRIO[0]}
    marks = [Mark("line", points, width=1.5, **look)]
    marks.append(Mark("dots", [[point] for point in points], "step", width=5, **look))
    ends = float(added[0]), float(added[-1])
    return Panel(
        "The cost over the change of the weight, with the chosen one marked.",
        ends,
        (-0.04 * top, 1.05 * top),
        marks,
        x_label="change of the weight",
        y_label="cost",
        x_ticks=(ends[0], 0, ends[1]),
        y_ticks=(0, float(f"{top / 2:.1g}"), float(f"{top:.1g}")),
    )


@styled
def _poster(arm: Arm, task_deg: float, rollouts: list[Rollout], first: int) -> Figure:
    """Draw all ways in one picture, and the pose at the end of one."""
    world = arm.workspace
    figure, axis = plt.subplots(figsize=(4.2, 4.2))
    draw_world(axis, world)
    for rollout in rollouts[:: max(1, len(rollouts) // 9)]:
        axis.plot(*rollout.path.T, color="0.75", lw=1)
    axis.plot(*rollouts[first].path.T, color=TRIO[0], lw=2.5)
    draw_arm(axis, world, rollouts[first].joints[-1], alpha=0.5)
    axis.plot(*world.target(task_deg), "o", color=GOAL, ms=8, zorder=5)
    return figure
