"""A slider over the generations of a search."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.plots._generations import STARTS, draw_generation, square_around
from msc.plots._marks import FLAT, WEIGHT_NAMES, mark_world
from msc.plots._slider import Mark, Panel, Slider, choose_ticks
from msc.plots._style import GOAL, styled
from msc.robot import Workspace, forward_kinematics
from msc.search import SearchTrace

N_STEPS = 40  # of the slider: every early generation, then ever fewer
EVERY = 2  # time steps from one point of a path to the next


def slide_generations(
    workspace: Workspace, task_deg: float, run: SearchTrace
) -> Slider:
    """Let the reader walk through the generations of a start.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    run : SearchTrace
        The start.

    Returns
    -------
    Slider
        Three panels: the movements of a generation, their costs, and the two weights
        that vary most.
    """
    n_generations = len(run.costs)
    spaced = np.geomspace(1, n_generations, N_STEPS).round().astype(int)
    steps = np.unique(np.r_[1 : min(13, n_generations + 1), spaced]) - 1
    order = run.costs[steps].argsort(axis=1)  # the cheapest first
    policies = np.take_along_axis(run.policies[steps], order[..., None], axis=1)
    costs = np.take_along_axis(run.costs[steps], order, axis=1)
    joints = run.joints[steps, :, ::EVERY]
    joints = np.take_along_axis(joints, order[..., None, None], axis=1)
    places = forward_kinematics(joints, workspace.link_lengths)
    missed = 100 * np.linalg.norm(
        places[:, 0, -1, -1] - workspace.target(task_deg), axis=-1
    )
    captions = [
        f"Generation {step + 1}, {run.evaluations[step]} rollouts so far. Its policies "
        f"cost {_cost(some[0])} to {_cost(some[-1])}; the cheapest ends {away:.2f} cm "
        "from the goal."
        for step, some, away in zip(steps, costs, missed, strict=True)
    ]
    return Slider(
        name="generation",
        labels=[f"generation {step + 1}" for step in steps],
        captions=captions,
        panels=[
            _movements_panel(workspace, task_deg, places),
            _costs_panel(run, steps, costs),
            _weights_panel(run, policies),
        ],
        poster=_poster(workspace, task_deg, run, int(steps[0])),
        poster_alt=f"The ways of the end effector. {captions[0]}",
        seconds=6.0,
        walks=True,
        legend={"nine policies": STARTS[0], "the cheapest": "currentColor"},
    )


def _cost(value: float) -> str:
    return f"{value:#.3g}"


def _movements_panel(
    workspace: Workspace, task_deg: float, places: NDArray[np.float64]
) -> Panel:
    """Show the ways of the end effector, and the cheapest policy's arm at the end."""
    marks = mark_world(workspace)
    marks.append(Mark("disc", [workspace.target(task_deg)], colour=GOAL, radius=0.025))
    home = forward_kinematics(workspace.home, workspace.link_lengths)
    marks.append(Mark("line", home, width=6.0, opacity=0.15))
    best = places[:, 0, -1]
    marks.append(Mark("line", best, "step", width=6.0, opacity=0.4))
    paths = places[:, :, :, -1]
    marks += [
        Mark("line", paths[:, rank], "step", colour=STARTS[0], width=1.5)
        for rank in range(1, paths.shape[1])
    ]
    marks.append(Mark("line", paths[:, 0], "step", width=2.5))
    alt = "Nine ways of the end effector from above, and the arm at the best one's end."
    x, y = square_around(workspace, places)
    return Panel(alt, x, y, marks)


def _costs_panel(
    run: SearchTrace, steps: NDArray[np.intp], costs: NDArray[np.float64]
) -> Panel:
    """Show the costs over the rollouts, the chosen generation's marked."""
    n_policies = run.costs.shape[1]
    low, high = np.log10(run.costs.min()), np.log10(run.costs.max())
    spent = run.evaluations / 1000
    every = np.c_[np.repeat(spent, n_policies), np.log10(run.costs).ravel()]
    here = [
        np.c_[np.full(n_policies, spent[step]), np.log10(some)]
        for step, some in zip(steps, costs, strict=True)
    ]
    digits = (1,) if high - low > 1.5 else (1, 2, 5)
    ticks = [k * 10.0**power for power in range(-4, 4) for k in digits]
    ticks = [tick for tick in ticks if low <= np.log10(tick) <= high]
    return Panel(
        "The cost of policies over the rollouts spent, logarithmic.",
        (0.0, float(spent[-1])),
        (float(low) - 0.1, float(high) + 0.1),
        [
            Mark("dots", every, colour=STARTS[0], width=1.0, opacity=0.3),
            Mark("line", np.c_[spent, np.log10(run.best_costs)], opacity=0.6),
            Mark("dots", here, "step", colour=STARTS[0], width=3.5),
            Mark("dots", [some[:1] for some in here], "step", width=4.5),
        ],
        aspect=FLAT,
        x_label="rollouts (thousands)",
        y_label="cost",
        x_ticks=tuple(float(x) for x in np.arange(0, spent[-1], 0.5)),
        y_ticks=tuple(np.log10(ticks).tolist()),
        y_names=tuple(f"{tick:g}" for tick in ticks),
    )


def _weights_panel(run: SearchTrace, policies: NDArray[np.float64]) -> Panel:
    """Show the two weights that vary most over all that was tried."""
    tried = run.policies.reshape(-1, run.policies.shape[-1])
    across, up = np.sort(np.argsort(tried.std(axis=0))[-2:])
    plane = [across, up]
    low, high = tried[:, plane].min(axis=0), tried[:, plane].max(axis=0)
    margin = 0.05 * (high - low)
    (left, bottom), (right, top) = low - margin, high + margin
    return Panel(
        "Two weights of the policies, those of the chosen generation marked.",
        (float(left), float(right)),
        (float(bottom), float(top)),
        [
            Mark("dots", tried[:, plane], colour=STARTS[0], width=1.0, opacity=0.3),
            Mark("dots", policies[..., plane], "step", colour=STARTS[0], width=3.5),
            Mark("dots", policies[:, :1, plane], "step", width=4.5),
        ],
        aspect=FLAT,
        x_label=f"policy weight {WEIGHT_NAMES[across]}",
        y_label=f"policy weight {WEIGHT_NAMES[up]}",
        x_ticks=choose_ticks(left, right),
        y_ticks=choose_ticks(bottom, top),
    )


@styled
def _poster(
    workspace: Workspace, task_deg: float, run: SearchTrace, generation: int
) -> Figure:
    """Draw one generation as a picture."""
    figure, axis = plt.subplots(figsize=(4.2, 4.2))
    draw_generation(axis, workspace, task_deg, run, generation)
    axis.set_title(f"generation {generation + 1}")
    return figure
