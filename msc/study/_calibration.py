"""How the world's two free constants were fixed: by measurements made beforehand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from msc._parallel import call_in_order
from msc.data import find_jumps
from msc.robot import (
    DMP,
    Workspace,
    clearance,
    forward_kinematics,
    inverse_kinematics,
    random_circles,
)
from msc.search import (
    ENERGY_WEIGHT,
    ERROR_WEIGHT,
    CmaRun,
    SearchOptions,
    grid,
    initial_covariance,
    minimize,
    search_policy,
)

N_TASKS = 72  # on the circle, of every layout
KNOT = 1 / 60  # s; step of the plans looked at
DEPTH_WEIGHT = 100.0  # 1/(m s); a centimetre deep for a tenth of a second costs 0.1
MAX_DEPTH = 0.002  # m; an arm that has to enter an obstacle deeper cannot reach

MAX_DISTANCE = 0.01  # m; farther from its target a task counts as unreachable
MIN_JUMPS = 3  # the premise of the paper's Experiment 2

_Array = NDArray[np.float64]


def locate_cut(
    workspace: Workspace | None = None,
    *,
    seed: int = 0,
    jobs: int = 1,
    options: SearchOptions | None = None,
) -> dict[str, Any]:
    """Find where reaching round either side of the base costs the same.

    The free circle is walked from both sides, each search starting from the policy
    before, until each walk is well past the other: two branches of policies, one for
    either side.

    Parameters
    ----------
    workspace : Workspace, optional
        Whose arm; its obstacles are left out. By default ``Workspace.free()``.
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes, of which two are of use.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    dict
        The costs of both branches over world angles, the angle of the tie (degrees)
        and the constant: that angle rounded up to the next half degree, so that no
        task of a one-degree grid lies at the tie.

    Raises
    ------
    ValueError
        If there is no tie within 60 degrees of where it is to be expected.
    """
    world = replace(workspace or Workspace.free(), cut_deg=0.0, circles=())
    x, y = forward_kinematics(world.home, world.link_lengths)[-1]
    middle = round(math.degrees(math.atan2(-y, -x)))  # opposite home; the tie is near
    angles = middle + 5.0 * np.arange(-12, 13)
    options = options or SearchOptions()
    walks = [(world, walk.tolist(), seed, options) for walk in (angles, angles[::-1])]
    below, above = call_in_order(_walk, walks, jobs=min(jobs, 2), label="walks")
    above = above[::-1]
    if not below[0] < above[0] or not below[-1] > above[-1]:
        raise ValueError(
            f"workspace {world.name!r}: reaching round either side of the base costs "
            f"the same nowhere between {angles[0]:g} and {angles[-1]:g} degrees"
        )
    tie = float(np.interp(0.0, np.subtract(below, above), angles))
    return {
        "world_angle_deg": angles.tolist(),
        "cost_from_below": below,
        "cost_from_above": above,
        "tie_deg": tie,
        "cut_deg": math.ceil(2 * tie) / 2,
        "seed": seed,
        **_told(options),
    }


def choose_layout(
    *, seed: int = 0, jobs: int = 1, options: SearchOptions | None = None
) -> dict[str, Any]:
    """Find the first layout of obstacles that fulfils the premise of Experiment 2.

    Layouts 0, 1, 2, … are searched until one is found whose tasks are all reachable
    and whose policies have at least three jumps besides the cut. To look at many, the
    arm is taken to do exactly what is planned, and the depth to which a link enters an
    obstacle is penalised; the searches in PyBullet then have to confirm the premise.

    Parameters
    ----------
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes; layouts are looked at that many at a time.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    dict
        The layout chosen, and for each one looked at its jumps and largest distance.
    """
    looked_at: list[dict[str, Any]] = []
    options = options or SearchOptions()
    with tqdm(desc="layouts", unit="layout") as bar:
        while not any(layout["fit"] for layout in looked_at):
            batch = range(len(looked_at), len(looked_at) + jobs)
            calls = [(layout, N_TASKS, seed, options) for layout in batch]
            looked_at += call_in_order(_look_at, calls, jobs=jobs, label="batch")
            bar.update(jobs)
    chosen = next(layout["layout"] for layout in looked_at if layout["fit"])
    return {
        "chosen": chosen,
        "n_tasks": N_TASKS,
        "seed": seed,
        **_told(options),
        "layouts": looked_at[: chosen + 1],
    }


def _told(options: SearchOptions) -> dict[str, list[str]]:
    """Say which options are not the defaults, if any."""
    return {"options": list(options.changed)} if options.changed else {}


def _walk(
    world: Workspace, angles: list[float], seed: int, options: SearchOptions
) -> list[float]:
    """Return the costs along a branch of policies."""
    search = partial(search_policy, world, seed=seed, options=options)
    found = [search(angles[0])]
    for angle in angles[1:]:
        found.append(search(angle, n_starts=0, start_policies=[found[-1].policy]))
    return [one.cost for one in found]


def _look_at(
    layout: int, n_tasks: int, seed: int, options: SearchOptions
) -> dict[str, Any]:
    """Search a layout without dynamics: two starts a task, then the neighbours'."""
    dmp = DMP()
    options = replace(options, agreement=2.0)  # costs are cheaper than a surrogate
    workspace = replace(Workspace.free(), circles=random_circles(layout))
    first, small = options.first_step * dmp.spring, options.small_step * dmp.spring
    tasks = grid(n_tasks)
    tools = [
        (_planned_cost(workspace, dmp, task), initial_covariance(workspace, task, dmp))
        for task in tasks
    ]
    best: list[CmaRun] = []
    for task, (cost, cov) in zip(tasks, tools, strict=True):
        rng = np.random.default_rng([seed, layout, round(1000 * task)])
        x0 = np.zeros(dmp.n_params)
        runs = [minimize(cost, x0, first, rng, cov, options=options)]
        x0 = first * rng.standard_normal(dmp.n_params)
        runs += [minimize(cost, x0, first, rng, cov, known=runs, options=options)]
        best.append(min(runs, key=lambda run: run.cost))
    for k in [*range(n_tasks), *range(n_tasks)]:
        rng = np.random.default_rng([seed, layout, 1, k])
        cost, cov = tools[k]
        for neighbour in (best[k - 1], best[(k + 1) % n_tasks]):
            x0, known = neighbour.policy, [best[k]]
            run = minimize(cost, x0, small, rng, cov, known=known, options=options)
            best[k] = min(best[k], run, key=lambda run: run.cost)
    policies = np.array([run.policy for run in best])
    jumps = find_jumps(tasks, policies)
    _, path, depth = _plan_joints(workspace, dmp, policies, np.array(tasks))
    farthest = float(np.hypot(*(path[:, -1] - workspace.target(tasks)).T).max())
    deepest = float(depth.max())
    is_reached = farthest < MAX_DISTANCE and deepest < MAX_DEPTH
    return {
        "layout": layout,
        "circles": [list(circle) for circle in workspace.circles],
        "jumps_after_deg": [tasks[jump] for jump in jumps],
        "largest_distance_m": farthest,
        "largest_depth_m": deepest,
        "fit": is_reached and len(jumps) >= MIN_JUMPS,
    }


def _planned_cost(
    workspace: Workspace, dmp: DMP, task: float
) -> Callable[[_Array], list[float]]:
    """Give the cost of policies if the arm did what is planned."""

    def costs(policies: _Array) -> list[float]:
        tasks = np.full(len(policies), task)
        joints, path, depth = _plan_joints(workspace, dmp, policies, tasks)
        energy = np.sum(np.diff(joints, axis=1) ** 2, axis=(1, 2)) / KNOT
        missed = np.sum((path[:, -1] - workspace.target(task)) ** 2, axis=1)
        planned = ERROR_WEIGHT * missed + ENERGY_WEIGHT * energy
        return list(planned + DEPTH_WEIGHT * KNOT * depth.sum(axis=1))

    return costs


def _plan_joints(
    workspace: Workspace, dmp: DMP, policies: _Array, tasks: _Array
) -> tuple[_Array, _Array, _Array]:
    """Plan joints, the end effector's path and the depth of links in obstacles."""
    times = np.arange(0, 1 + KNOT / 2, KNOT)
    start = forward_kinematics(workspace.home, workspace.link_lengths)[-1]
    path = dmp.path(policies, start, workspace.target(tasks), times)
    joints = inverse_kinematics(path, workspace.home, workspace.link_lengths)
    points = forward_kinematics(joints, workspace.link_lengths)
    gaps = [clearance(points, circle) - circle.radius for circle in workspace.circles]
    return joints, points[..., -1, :], np.maximum(0, -np.min(gaps, axis=0))
