"""Searches: how one converges, and the movements that many have found.

`Movements` has what the policy of each task of a table does, and how far neighbours are
apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.data import find_jumps, load_dataset
from msc.plots._slider import FLAT, Mark, Panel, Slider, choose_ticks, poster
from msc.plots._style import SMALL, TRIO, WEIGHT_NAMES, Array, styled, widen
from msc.plots._world import (
    bounds_of,
    draw_links,
    draw_world,
    mark_goal,
    place_arm,
    square_around,
    world_panel,
)
from msc.robot import Arm, Circle, Workspace, clearance, forward_kinematics
from msc.search import SearchCurve, SearchTrace, cost
from msc.study import take_evenly

STARTS = (TRIO[1], TRIO[0], TRIO[2], "0.3", "0.5", "0.7")
N_SHOWN = 40  # of the slider: every early generation, then ever fewer
EVERY = 2  # time steps from one point of a path to the next
CONTACT = 0.001  # m; an arm that came this close to an obstacle touched it
BREAK = TRIO[:2]  # of a break: before, after


@styled
def plot_generations(
    workspace: Workspace,
    task_deg: float,
    traces: Sequence[SearchTrace],
    shown: Sequence[int] = (1, 10, 20),
) -> Figure:
    """Draw what generations do, and what their policies cost.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    traces : sequence of SearchTrace
        The starts of one search.
    shown : sequence of int, default=(1, 10, 20)
        Generations of the first start, counted from 1.

    Returns
    -------
    Figure
        Top the ways of the end effector in generations of the first start, the cheapest
        dark, and what every start found; bottom their costs over the rollouts spent: as
        dots all policies, as lines the cheapest so far, dashed the generations above.
    """
    first = traces[0]
    numbers = [min(number, len(first.costs)) for number in shown]
    figure = plt.figure(figsize=(7.4, 4.5))
    grid = figure.add_gridspec(2, len(numbers) + 1, height_ratios=(1, 1.05))
    costs = figure.add_subplot(grid[1, :])
    for column, number in enumerate(numbers):
        axis = figure.add_subplot(grid[0, column])
        _draw_generation(axis, workspace, task_deg, first, number - 1)
        axis.set_title(f"generation {number}", fontsize=9)
        spent = first.evaluations[number - 1]
        costs.axvline(spent, color="0.5", lw=0.8, ls="--", zorder=0)
    found = figure.add_subplot(grid[0, len(numbers)])
    _draw_found(found, workspace, task_deg, traces)
    found.set_title("what every start found", fontsize=9)
    for trace, colour in zip(traces, STARTS, strict=False):
        _draw_costs(costs, trace, colour)
    costs.set(xlabel="rollouts of the start", xlim=(0, None))
    costs.set(ylabel="cost", yscale="log")
    costs.legend(loc="upper right")
    return figure


def slide_generations(
    workspace: Workspace, task_deg: float, trace: SearchTrace
) -> Slider:
    """Let the reader walk through the generations of a start.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    trace : SearchTrace
        The start.

    Returns
    -------
    Slider
        Three panels: the movements of a generation, their costs, and the two weights
        that vary most.
    """
    n_generations = len(trace.costs)
    spaced = np.geomspace(1, n_generations, N_SHOWN).round().astype(int)
    steps = np.unique(np.r_[1 : min(13, n_generations + 1), spaced]) - 1
    order = trace.costs[steps].argsort(axis=1)  # the cheapest first
    policies = trace.policies[steps[:, None], order]
    # Those that were not executed come last: the cheapest covers their marks.
    n_executed = np.isfinite(trace.costs[steps]).sum(axis=1)
    n_policies = order.shape[1]
    executed = np.arange(n_policies) < n_executed[:, None]
    ranked = steps[:, None], np.where(executed, order, order[:, :1])
    costs = trace.costs[ranked]
    joints = trace.joints[ranked][:, :, ::EVERY]
    places = forward_kinematics(joints, workspace.link_lengths)
    left = places[:, 0, -1, -1] - workspace.target(task_deg)
    error_cm = 100 * np.linalg.norm(left, axis=-1)
    captions = [
        f"Generation {step + 1}, {trace.evaluations[step]} rollouts so far; {count} of "
        f"its {n_policies} policies executed. The cheapest costs {some[0]:#.3g} and "
        f"ends {away:.2f} cm from the goal."
        for step, count, some, away in zip(
            steps, n_executed, costs, error_cm, strict=True
        )
    ]
    return Slider(
        name="generation",
        labels=[f"generation {step + 1}" for step in steps],
        captions=captions,
        panels=[
            _movements_panel(workspace, task_deg, places),
            _costs_panel(trace, steps, costs),
            _weights_panel(trace, policies),
        ],
        poster=_draw_step(workspace, task_deg, trace, int(steps[0])),
        poster_alt=f"The ways of the end effector. {captions[0]}",
        walks=True,
        legend={"a policy": STARTS[0], "the cheapest": "currentColor"},
    )


def _movements_panel(workspace: Workspace, task_deg: float, places: Array) -> Panel:
    """Show the ways of the end effector, and the cheapest policy's arm at the end."""
    home = forward_kinematics(workspace.home, workspace.link_lengths)
    best, *others = places[..., -1, :].swapaxes(0, 1)
    look: Any = {"colour": STARTS[0], "width": 1.5}
    marks = [
        mark_goal(workspace, task_deg),
        Mark("line", home, width=6.0, opacity=0.15),
        Mark("line", places[:, 0, -1], "step", width=6.0, opacity=0.4),
        *(Mark("line", paths, "step", **look) for paths in others),
        Mark("line", best, "step", width=2.5),
    ]
    alt = "Ways of the end effector from above, and the arm at the best one's end."
    return world_panel(alt, workspace, marks, square_around(workspace, places))


def _costs_panel(trace: SearchTrace, steps: NDArray[np.intp], costs: Array) -> Panel:
    """Show the costs over the rollouts, the chosen generation's marked."""
    spent, every = trace.evaluations, _executed(trace)
    every[:, 1] = np.log10(every[:, 1])
    low, high = every[:, 1].min(), every[:, 1].max()
    here = np.stack(np.broadcast_arrays(spent[steps, None], np.log10(costs)), axis=-1)
    digits = (1,) if high - low > 1.5 else (1, 2, 5)
    ticks = [k * 10.0**power for power in range(-4, 4) for k in digits]
    ticks = [tick for tick in ticks if low <= np.log10(tick) <= high]
    return Panel(
        "The cost of policies over the rollouts spent, logarithmic.",
        (0.0, float(spent[-1])),
        (float(low) - 0.1, float(high) + 0.1),
        [
            Mark("dots", every, colour=STARTS[0], width=1.0, opacity=0.3),
            Mark("line", np.c_[spent, np.log10(trace.best_costs)], opacity=0.6),
            Mark("dots", here, "step", colour=STARTS[0], width=3.5),
            Mark("dots", here[:, :1], "step", width=4.5),
        ],
        aspect=FLAT,
        x_label="rollouts",
        y_label="cost",
        x_ticks=choose_ticks(0.0, float(spent[-1])),
        y_ticks=tuple(np.log10(ticks).tolist()),
        y_names=tuple(f"{tick:g}" for tick in ticks),
    )


def _weights_panel(trace: SearchTrace, policies: Array) -> Panel:
    """Show the two weights that vary most over all that was tried."""
    tried = trace.policies.reshape(-1, trace.policies.shape[-1])
    across, up = np.sort(np.argsort(tried.std(axis=0))[-2:])
    plane = [across, up]
    x, y = (widen(values, 0.05) for values in tried[:, plane].T)
    return Panel(
        "Two weights of the policies, those of the chosen generation marked.",
        x,
        y,
        [
            Mark("dots", tried[:, plane], colour=STARTS[0], width=1.0, opacity=0.3),
            Mark("dots", policies[..., plane], "step", colour=STARTS[0], width=3.5),
            Mark("dots", policies[:, :1, plane], "step", width=4.5),
        ],
        aspect=FLAT,
        x_label=f"policy weight {WEIGHT_NAMES[across]}",
        y_label=f"policy weight {WEIGHT_NAMES[up]}",
        x_ticks=choose_ticks(*x),
        y_ticks=choose_ticks(*y),
    )


def _draw_generation(
    axis: Axes, workspace: Workspace, task_deg: float, trace: SearchTrace, number: int
) -> None:
    """Draw the ways of a generation's policies, the cheapest one dark."""
    _draw_home(axis, workspace, task_deg, trace)
    places = forward_kinematics(trace.joints[number], workspace.link_lengths)
    best = np.nanargmin(trace.costs[number])
    axis.plot(*places[best, -1].T, color="0.65", lw=4, solid_capstyle="round")
    for place in places:
        axis.plot(*place[:, -1].T, color=STARTS[0], lw=1.0)
    axis.plot(*places[best, :, -1].T, color="black", lw=1.6)


@poster
def _draw_step(
    axis: Axes, workspace: Workspace, task_deg: float, trace: SearchTrace, number: int
) -> None:
    """Draw one generation as a picture."""
    _draw_generation(axis, workspace, task_deg, trace, number)
    axis.set_title(f"generation {number + 1}")


def _draw_found(
    axis: Axes, workspace: Workspace, task_deg: float, traces: Sequence[SearchTrace]
) -> None:
    """Draw the cheapest movement of every start, and where the arm ends."""
    _draw_home(axis, workspace, task_deg, traces[0])
    widths = np.linspace(4.5, 1.2, len(traces))  # those below remain visible
    for trace, colour, width in zip(traces, STARTS, widths, strict=False):
        best = np.unravel_index(np.nanargmin(trace.costs), trace.costs.shape)
        places = forward_kinematics(trace.joints[best], workspace.link_lengths)
        axis.plot(*places[-1].T, color=colour, lw=4, alpha=0.4)
        axis.plot(*places[:, -1].T, color=colour, lw=width)


def _draw_home(
    axis: Axes, workspace: Workspace, task_deg: float, trace: SearchTrace
) -> None:
    """Draw the world and the arm at home, with room for all that was tried."""
    draw_world(axis, workspace, task_deg, view="search")
    home = forward_kinematics(workspace.home, workspace.link_lengths)
    axis.plot(*home.T, color="0.85", lw=4)
    executed = trace.joints[np.isfinite(trace.costs)]
    tried = forward_kinematics(executed, workspace.link_lengths)
    across, up = square_around(workspace, tried)
    axis.set(xlim=across, ylim=up)


def _draw_costs(axis: Axes, trace: SearchTrace, colour: str) -> None:
    """Draw the costs of a start: of every policy, and the least so far."""
    spent = trace.evaluations
    axis.plot(*_executed(trace).T, ".", ms=1.5, alpha=0.25, color=colour)
    axis.plot(spent, trace.best_costs, color=colour, lw=2, label=trace.run.name)
    axis.plot(spent[-1], trace.best_costs[-1], "o", ms=5, color=colour, mec="white")


def _executed(trace: SearchTrace) -> Array:
    """Return rollouts spent and cost of every policy that was executed."""
    generation, policy = np.isfinite(trace.costs).nonzero()
    paid = trace.costs[generation, policy]
    return np.column_stack([trace.evaluations[generation], paid]).astype(float)


@styled
def plot_rollouts_spent(traces: Sequence[SearchTrace], plain: SearchCurve) -> Figure:
    """Draw what the surrogate of a search saves.

    Parameters
    ----------
    traces : sequence of SearchTrace
        The starts of one search.
    plain : SearchCurve
        The same starts without a surrogate: plain CMA-ES, which executes all policies
        of a generation.

    Returns
    -------
    Figure
        Left the least cost over the rollouts of each start, solid with a surrogate,
        dashed without; right how many policies of each generation of the first start
        were executed.
    """
    figure, (costs, counts) = plt.subplots(1, 2, figsize=(7.4, 2.9))
    n_policies = traces[0].costs.shape[1]
    ours = [(one.run.name, one.evaluations, one.best_costs) for one in traces]
    theirs = _by_generation(plain, n_policies)
    for kind, style, way in ((ours, "-", "surrogate"), (theirs, "--", "plain")):
        for (name, spent, best), colour in zip(kind, STARTS, strict=False):
            label = f"{name}, {way}"
            costs.plot(spent, best, style, color=colour, lw=1.5, label=label)
            costs.plot(spent[-1], best[-1], "o", ms=4, color=colour, mec="white")
    costs.set(xlabel="rollouts of the start", ylabel="least cost", yscale="log")
    costs.legend(fontsize=SMALL)
    executed = np.isfinite(traces[0].costs).sum(axis=1)
    numbers = np.arange(1, len(executed) + 1)
    counts.bar(numbers, executed, width=1.0, color=STARTS[0])
    counts.axhline(n_policies, color="0.5", ls="--", lw=0.8)
    counts.set(xlabel="generation", ylabel="policies executed")
    counts.set(xlim=(0.5, len(executed) + 0.5), ylim=(0, n_policies + 0.5))
    return figure


def _by_generation(
    curve: SearchCurve, n_policies: int
) -> list[tuple[str, Array, Array]]:
    """Return name, rollouts spent and least cost of each start after generations."""
    runs = curve.result.runs
    ends = np.cumsum([run.evaluations for run in runs])
    last = slice(n_policies - 1, None, n_policies)  # rollouts of the generations
    found: list[tuple[str, Array, Array]] = []
    for run, own in zip(runs, np.split(curve.costs, ends[:-1]), strict=True):
        spent = np.arange(1.0, len(own) + 1)
        found.append((run.name, spent[last], np.minimum.accumulate(own)[last]))
    return found


class Movements:
    """What the arm does for each task of a table.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its table.

    Attributes
    ----------
    workspace : Workspace
        Where the movements take place.
    degrees : ndarray of shape (n_tasks,)
        Task angles, ascending (degrees).
    rollouts : list of Rollout
        What the policy of each task does.
    jumps : ndarray of int
        Indices of tasks after which the policies jump, the circle cut open.

    Examples
    --------
    >>> free = Movements("free")
    >>> len(free.rollouts) == len(free.degrees) == len(free.gaps)
    True
    """

    def __init__(self, name: str) -> None:
        self.workspace = Workspace.named(name)
        dataset = load_dataset(name)
        self._tasks, policies, _ = dataset
        self.degrees = dataset.task_deg
        self.jumps = find_jumps(self._tasks, policies)
        with Arm(self.workspace) as arm:
            self.rollouts = arm.execute_many(policies, self.degrees.tolist())

    @cached_property
    def places(self) -> Array:
        """Base, joints and end effector (m), of shape (n_tasks, n_steps + 1, 4, 2)."""
        return place_arm(self.rollouts, self.workspace)

    @property
    def gaps(self) -> Array:
        """How far each movement is from the next task's (m), of shape (n_tasks,).

        The farthest that any joint, or the end effector, is from where it is in the
        other movement at the same time. The last task's next is the first.
        """
        apart = np.roll(self.places, -1, axis=0) - self.places
        return np.asarray(np.linalg.norm(apart, axis=-1).max(axis=(1, 2)))

    @property
    def breaks(self) -> list[tuple[int, int]]:
        """Indices of the tasks on both sides of each jump and, last, of the cut."""
        last = len(self.degrees) - 1
        return [(int(k), int(k) + 1) for k in self.jumps] + [(last, 0)]

    @property
    def unbroken(self) -> Array:
        """The `gaps` elsewhere (m): without those of the jumps and of the cut."""
        return np.delete(self.gaps, [*self.jumps, len(self.degrees) - 1])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of all that moves or stands here, x and y (m)."""
        low, high = bounds_of(self.workspace.circles, self.places)
        return low - 0.03, high + 0.03

    def evenly(self, n_tasks: int) -> list[int]:
        """Pick tasks evenly spaced over the circle.

        Parameters
        ----------
        n_tasks : int
            How many.

        Returns
        -------
        list of int
            Their indices.

        Raises
        ------
        ValueError
            If there are fewer.
        """
        return [int(index) for index in take_evenly(self._tasks, n_tasks)]

    def touched(self, index: int) -> list[Circle]:
        """Find the obstacles that the arm touched.

        Parameters
        ----------
        index : int
            Which task.

        Returns
        -------
        list of Circle
            The obstacles.
        """
        return [
            circle
            for circle in self.workspace.circles
            if self.rollouts[index].touched
            and clearance(self.places[index], circle).min() < circle.radius + CONTACT
        ]

    def compare(self) -> pd.DataFrame:
        """Compare the movements on both sides of each jump and, last, of the cut.

        Returns
        -------
        DataFrame
            One row a break: the largest distance between the two movements (cm), see
            `gaps`; the cost before and after; whether the arm touched an obstacle; and
            the larger of the distances that were left to the goals (cm).
        """
        rows = {}
        for pair in self.breaks:
            before, after = (self.rollouts[index] for index in pair)
            rows[" | ".join(f"{self.degrees[index]:g}°" for index in pair)] = {
                "apart (cm)": 100 * self.gaps[pair[0]],
                "cost before": cost(before),
                "cost after": cost(after),
                "touched before": before.touched,
                "touched after": after.touched,
                "missed by (cm)": 100 * max(before.error, after.error),
            }
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("tasks")


@styled
def plot_tasks(
    movements: Movements, indices: Sequence[int], *, n_poses: int = 6
) -> Figure:
    """Draw movements in a grid, four in a row.

    Parameters
    ----------
    movements : Movements
        The movements.
    indices : sequence of int
        Which tasks.
    n_poses : int, default=6
        Poses in a panel, evenly spaced in time.

    Returns
    -------
    Figure
        One panel a task: poses from pale to dark, the way of the end effector blue,
        the goal a red ring, obstacles black, those touched with an orange rim.
    """
    figure, axes = _panels(len(indices), 4, 1.85, 2.05)
    for axis, index in zip(axes, indices, strict=False):
        _draw_movement(axis, movements, index, colour=BREAK[0], n_poses=n_poses)
        axis.set_title(f"{movements.degrees[index]:g}°", pad=2)
    return figure


@styled
def plot_breaks(
    movements: Movements, breaks: Sequence[tuple[int, int]], *, n_poses: int = 6
) -> Figure:
    """Draw the movements on both sides of breaks next to each other.

    Parameters
    ----------
    movements : Movements
        The movements.
    breaks : sequence of tuple of int
        Indices of the two tasks of each, see `Movements.breaks`.
    n_poses : int, default=6
        Poses in a panel, evenly spaced in time.

    Returns
    -------
    Figure
        Two panels a break, drawn as by `plot_tasks`: the way of the end effector blue
        before and orange after it, and dotted in the other's panel. One break in a
        row, or two if there are more than five.
    """
    n_columns, width = (2, 3.1) if len(breaks) <= 5 else (4, 1.85)
    figure, axes = _panels(2 * len(breaks), n_columns, width, width + 0.1)
    for panels, pair in zip(axes.reshape(-1, 2), breaks, strict=False):
        for k, axis in enumerate(panels):
            other = movements.rollouts[pair[1 - k]].path
            axis.plot(*other.T, ":", color=BREAK[1 - k], lw=1.3)
            _draw_movement(axis, movements, pair[k], colour=BREAK[k], n_poses=n_poses)
            axis.set_title(_caption(movements, pair[k]), pad=3, fontsize=SMALL)
    return figure


def _panels(
    n_panels: int, n_columns: int, width: float, height: float
) -> tuple[Figure, NDArray[Any]]:
    """Make panels of one size (inches), row by row; those of the last may be empty."""
    n_rows = -(-n_panels // n_columns)
    size = n_columns * width, n_rows * height
    figure, axes = plt.subplots(n_rows, n_columns, figsize=size, squeeze=False)
    for axis in axes.flat[n_panels:]:
        axis.set_axis_off()
    return figure, axes.ravel()


def _draw_movement(
    axis: Axes, movements: Movements, index: int, *, colour: str, n_poses: int
) -> None:
    """Draw poses of one movement, evenly spaced in time, and the end effector's way."""
    world, path = movements.workspace, movements.rollouts[index].path
    steps = np.linspace(0, len(path) - 1, n_poses).round().astype(int)
    greys = np.linspace(0.86, 0.30, n_poses)
    for order, (step, grey) in enumerate(zip(steps, greys, strict=True)):
        look: Any = {"color": str(grey), "zorder": 2 + order / n_poses}
        joints: Any = {"mfc": "white", "mec": None, "ms": 2.8, "mew": 0.8, **look}
        draw_links(axis, movements.places[index, step], {"lw": 2.8, **look}, **joints)
    axis.plot(*path.T, color=colour, lw=1.8, zorder=4)
    axis.plot(*path[steps].T, "o", color=colour, ms=3.2, zorder=4)
    task_deg, touched = movements.degrees[index], movements.touched(index)
    draw_world(axis, world, task_deg, view="movement", touched=touched)
    low, high = movements.bounds
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _caption(movements: Movements, index: int) -> str:
    """Say what task this is, what it costs, and whether an obstacle was touched."""
    rollout = movements.rollouts[index]
    contact = "contact" if rollout.touched else "no contact"
    return f"{movements.degrees[index]:g}°\ncost {cost(rollout):.3f}, {contact}"
