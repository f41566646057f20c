"""How the world's two free constants were fixed: by measurements made beforehand."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from msc.dataset import Plan, grid, search_tasks
from msc.jumps import find_jumps
from msc.search import search_policy
from msc.tables import WEIGHTS
from msc.workspace import Workspace, random_circles

MAX_DISTANCE = 0.01  # m; farther from its target a task counts as unreachable
MIN_JUMPS = 3  # the premise of the paper's Experiment 2


def locate_cut(
    *, seed: int = 0, jobs: int = 1, step_deg: float = 5.0
) -> dict[str, Any]:
    """Find where reaching round either side of the base costs the same.

    The free circle is walked from both sides, each search starting from the policy
    before, until each walk is well past the other: two branches of policies, one for
    either side.

    Parameters
    ----------
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes, of which two are of use.
    step_deg : float, default=5.0
        Step of the walks (degrees).

    Returns
    -------
    dict
        The costs of both branches over world angles, the angle of the tie (degrees)
        and the constant: that angle rounded up to the next half degree, so that no
        task of a one-degree grid lies at the tie.
    """
    middle = 45.0  # opposite the end effector's home; the tie is near
    angles = middle + step_deg * np.arange(-12, 13)
    walks = [angles, angles[::-1]]
    below, above = Parallel(n_jobs=min(jobs, 2))(
        delayed(_walk)(walk.tolist(), seed) for walk in walks
    )
    advantage = np.array(below) - np.array(above[::-1])
    tie = float(np.interp(0.0, advantage, angles))
    return {
        "world_angle_deg": angles.tolist(),
        "cost_from_below": below,
        "cost_from_above": above[::-1],
        "tie_deg": tie,
        "cut_deg": math.ceil(2 * tie) / 2,
        "seed": seed,
    }


def choose_layout(
    *, seed: int = 0, jobs: int = 1, journals: Path, n_tasks: int = 72
) -> dict[str, Any]:
    """Find the first layout of obstacles that fulfils the premise of Experiment 2.

    Layouts of seed 0, 1, 2, … are searched one after the other, with two starts a task
    and the consistency pass, until one is found whose tasks are all reachable and
    whose policies have at least three jumps besides the cut.

    Parameters
    ----------
    seed : int, default=0
        Seed of the searches.
    jobs : int, default=1
        Worker processes.
    journals : Path
        Folder that keeps what is done, so that an interrupted survey goes on.
    n_tasks : int, default=36
        Tasks on the circle.

    Returns
    -------
    dict
        The layout chosen, and for each one looked at its jumps and largest distance.
    """
    looked_at: list[dict[str, Any]] = []
    while not (looked_at and looked_at[-1]["chosen"]):
        layout = len(looked_at)
        world = replace(
            Workspace.free(), name=f"layout {layout}", circles=random_circles(layout)
        )
        plan = Plan(world, grid(n_tasks), seed, n_starts=2)
        journal = journals / f"layout_{layout}.partial"
        table = search_tasks(plan, jobs=jobs, journal=journal, progress=True)
        jumps = find_jumps(table["task_deg"], table[list(WEIGHTS)])
        farthest = float(table["distance_m"].max())
        looked_at.append(
            {
                "layout": layout,
                "circles": [list(circle) for circle in world.circles],
                "jumps_after_deg": table["task_deg"][jumps].tolist(),
                "largest_distance_m": farthest,
                "chosen": farthest < MAX_DISTANCE and len(jumps) >= MIN_JUMPS,
            }
        )
    return {
        "chosen": len(looked_at) - 1,
        "n_tasks": n_tasks,
        "seed": seed,
        "layouts": looked_at,
    }


def _walk(angles: list[float], seed: int) -> list[float]:
    """Return the costs along a branch of policies."""
    world = Workspace(cut_deg=0.0)
    found = search_policy(world, angles[0], seed=seed)
    costs = [found.cost]
    for angle in angles[1:]:
        found = search_policy(
            world, angle, seed=seed, n_starts=0, start_policies=[found.policy]
        )
        costs.append(found.cost)
    return costs
