"""Where predicted movements mean to stop: whether all weights agree on it."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msc.plots._style import COLOURS, SMALL, styled
from msc.robot import DMP, forward_kinematics
from msc.study import Experiment


def planned_stops(experiment: Experiment, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return goals of the test tasks and where their predicted paths end (m).

    Parameters
    ----------
    experiment : Experiment
        With the method among its methods.
    name : str
        The method.

    Returns
    -------
    goals, stops : ndarray of shape (n_test_tasks, 2)
        In the plane of the arm.
    """
    world, degrees = experiment.workspace, experiment.test_table["task_deg"].to_numpy()
    start = forward_kinematics(world.home, world.link_lengths)[-1]
    goals = world.target(degrees)
    policies = experiment.predict(name, experiment.test_tasks)
    return goals, DMP().path(policies, start, goals, np.array([1.0]))[:, 0]


@styled
def plot_stops(experiment: Experiment, names: Sequence[str]) -> Figure:
    """Draw where predicted paths stop, beside their goals: plans, not what the arm did.

    Parameters
    ----------
    experiment : Experiment
        One training set.
    names : sequence of str
        Methods, a panel each.

    Returns
    -------
    Figure
        On the circle the goals of the test tasks; a line leads from each to where its
        path means to stop.
    """
    size = 7.4 / len(names)
    figure, axes = plt.subplots(1, len(names), figsize=(7.4, size + 0.3), sharey=True)
    for axis, name in zip(np.atleast_1d(axes), names, strict=True):
        goals, stops = planned_stops(experiment, name)
        missed = 100 * np.hypot(*(stops - goals).T)
        axis.plot(*goals.T, "o", ms=2.5, color="0.6")
        pairs = list(np.stack([goals, stops], axis=1))
        colour = COLOURS["single regression"]
        axis.add_collection(LineCollection(pairs, color=colour, lw=1))
        axis.plot(*stops.T, "x", ms=3, color=colour)
        axis.set(aspect="equal", xticks=[], yticks=[])
        axis.grid(visible=False)
        axis.spines[:].set_visible(False)
        axis.set_title(name, loc="left", fontsize=SMALL)
        axis.set_xlabel(f"{missed.mean():.2g} cm beside the goal", fontsize=SMALL)
    return figure
