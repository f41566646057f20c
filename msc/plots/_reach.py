"""A goal that the reader drags: in one world, or in any of several.

`_reach_page` draws the picture of a world, `_layouts` many worlds to choose from.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from msc.plots._layouts import Layouts, load_layouts
from msc.plots._reach_page import Reach, find_apart
from msc.plots._skill import execute_all
from msc.robot import Arm
from msc.study import Experiment

EVERY = 6  # time steps from one pose that a page is told to the next: a tenth second
FIRST = "charts", "single regression", "linear interpolation"  # shown before one asks
SEARCHED = "searched"


def drag_goal(
    of: Experiment | Sequence[str],
    *,
    shown: Sequence[str] = FIRST,
    every: int = 1,
    folder: Path | None = None,
    results: Path | None = None,
) -> Reach | Layouts:
    """Let the reader drag the goal, and see how every method's arm moves there.

    Parameters
    ----------
    of : Experiment or sequence of str
        What was trained on what; all its methods are drawn, and what was searched. Or
        names of layouts, to choose one among them; there movements are those that
        `msc.worlds.locate_moves` found.
    shown : sequence of str, default=("charts", "single regression", \
"linear interpolation")
        The methods that are seen before the reader switches any on or off.
    every : int, default=1
        Every how many-th test task is a goal.
    folder, results : Path, optional
        Where layouts are, and what was found in them; by default in the book's data.

    Returns
    -------
    Reach or Layouts
        A picture that follows the hand. At first it shows, in each world, the goal at
        which the shown movements end farther apart than at three quarters of all goals.

    Raises
    ------
    ValueError
        If a method that is to be shown is none of those trained.
    """
    if not isinstance(of, Experiment):
        return load_layouts(of, shown, every, folder, results)
    names = of.names
    if unknown := [name for name in shown if name not in names]:
        raise ValueError(f"shown={unknown}: not trained; wanted some of {names}")
    world, some = of.workspace, slice(None, None, every)
    tasks = of.test_tasks[some]
    degrees = of.test_table["task_deg"].to_numpy()[some]
    policies = {SEARCHED: of.test_policies[some]}
    policies |= {name: of.predict(name, tasks) for name in names[::-1]}
    with Arm(world) as arm:
        rollouts, error_cm = execute_all(arm, policies, degrees)
    return Reach(
        world,
        degrees,
        np.rad2deg(of.tasks[of.chosen, 0]),
        {n: np.array([one.joints[::EVERY] for one in rollouts[n]]) for n in policies},
        error_cm,
        {n: np.array([one.touched for one in rollouts[n]]) for n in policies},
        tuple(shown),
        find_apart([[one.path[-1] for one in rollouts[name]] for name in shown]),
    )
