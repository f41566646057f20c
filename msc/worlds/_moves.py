"""Movements in layouts of obstacles: of policies searched, and of those predicted.

For a page whose reader drags the goal: methods are fitted to evenly spaced tasks, and
the arm executes what they predict for every test task.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import Dataset
from msc.robot import Arm, Workspace
from msc.study import fit_methods, take_evenly
from msc.worlds._draw import family_of
from msc.worlds._each import fill
from msc.worlds._study import load_for, write_lines

SIZE = 24  # training tasks
EVERY = 6  # time steps from one pose that is kept to the next: a tenth of a second
TICK = 4e-4  # rad; the end of the arm is 0.4 mm off at most
SEARCHED = "searched"
MOVED = (
    "charts",
    "single regression",
    "charts, one kernel",
    "single, one kernel",
    "linear interpolation",
    "CrKr",
)

Array = NDArray[np.float64]


def locate_moves(
    folder: Path,
    out: Path,
    names: Iterable[str],
    *,
    seed: int = 0,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Execute what methods predict in layouts, in those where it was not done yet.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    out : Path
        Where results go, `moves_NAME.json` a world.
    names : iterable of str
        Which worlds; of other families they are left out.
    seed : int, default=0
        Seed of the clustering.
    jobs : int, default=1
        Worker processes, a world each; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, whose workers do the work instead.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    list of str
        The worlds that were looked at.
    """
    own = [name for name in names if family_of(name).name == "layout"]
    files = {name: out / f"moves_{name}.json" for name in own}
    how: dict[str, Any] = {"jobs": jobs, "dask": dask, "progress": progress}
    load = load_for("moves", folder, seed)
    return fill("moves", move_world, files, load, write_lines, seed=seed, **how)


def move_world(
    world: Workspace, train: Dataset, test: Dataset, seed: int = 0
) -> dict[str, Any]:
    """Execute what is searched and what is predicted for the test tasks of a layout.

    Parameters
    ----------
    world : Workspace
        The world; its tasks are angles.
    train, test : Dataset
        Its tables.
    seed : int, default=0
        Seed of the clustering.

    Returns
    -------
    dict
        "trained_deg", 24 evenly spaced tasks; "task_deg", the test tasks, and to which
        "chart" the gate gives each; and "methods", "searched" among them, with, of each
        movement, "error_cm" and "touched", and "joints", poses for `unpack_joints`.
    """
    chosen = take_evenly(train.tasks, SIZE)
    known = train.tasks[chosen], train.policies[chosen], train.table["cost"][chosen]
    fitted = fit_methods(*known, names=MOVED, seed=seed, workspace=world)
    policies = {SEARCHED: test.policies}
    policies |= {name: one.predict(test.tasks) for name, one in fitted.items()}
    told = {}
    with Arm(world) as arm:
        for name, some in policies.items():
            rollouts = arm.execute_many(some, world.tasks_in(test.table))
            told[name] = {
                "error_cm": [round(100 * one.error, 3) for one in rollouts],
                "touched": [int(one.touched) for one in rollouts],
                "joints": pack_joints(np.array([one.joints for one in rollouts])),
            }
    return {
        "trained_deg": train.task_deg[chosen].tolist(),
        "task_deg": test.task_deg.tolist(),
        "chart": fitted["charts"].predict_chart(test.tasks).tolist(),
        "methods": told,
    }


def pack_joints(joints: Array) -> str:
    """Write every sixth pose but the first, home, in base 64: two bytes an angle.

    Joint angles (rad) have the shape (n_movements, n_times, 3).
    """
    ticks = np.round(joints[:, EVERY::EVERY] / TICK)
    return base64.b64encode(ticks.astype("<i2").tobytes()).decode()


def unpack_joints(text: str, world: Workspace, n_moves: int) -> Array:
    """Read the poses of movements.

    Parameters
    ----------
    text : str
        As `move_world` tells them.
    world : Workspace
        The world, whose home pose is the first of each movement.
    n_moves : int
        How many movements there are.

    Returns
    -------
    ndarray of shape (n_moves, n_poses, 3)
        Joint angles (rad), a tenth of a second apart.
    """
    raw = np.frombuffer(base64.b64decode(text), dtype="<i2")
    poses = TICK * raw.reshape(n_moves, -1, len(world.home))
    home = np.broadcast_to(world.home, (n_moves, 1, len(world.home)))
    return np.concatenate([home, poses], axis=1)
