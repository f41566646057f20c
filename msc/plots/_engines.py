"""Policies searched in one engine and executed in the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from msc.data import Dataset, find_jumps
from msc.plots._style import SMALL, TRIO, WEIGHT_NAMES, styled

_TOUCHED = "touched", "touched_elsewhere"


@styled
def plot_engines(engines: Mapping[str, Any]) -> Figure:
    """Draw how far movements differ between the engines.

    Parameters
    ----------
    engines : dict
        What `msc.worlds.compare_engines` wrote.

    Returns
    -------
    Figure
        Left, shares of movements whose joints differ by no more than so much; right,
        what they cost elsewhere over what they cost where they were searched. Apart:
        those that met an obstacle in neither engine, and the others.
    """
    apart, own, elsewhere, *touched = (
        np.concatenate([np.asarray(one[key]) for one in engines["worlds"].values()])
        for key in ("joints_rad", "cost", "cost_elsewhere", *_TOUCHED)
    )
    ratio, met = elsewhere / own, np.any(touched, axis=0)
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 2.9))
    kinds = (
        ("no contact", ~met, TRIO[0], "-"),
        ("contact", met, TRIO[1], "--"),
    )
    for words, of, colour, dashes in kinds:
        if not of.any():
            continue
        share = (np.arange(of.sum()) + 1) / of.sum()
        look = {"color": colour, "ls": dashes, "label": f"{words} ({of.sum()})"}
        left.step(np.sort(np.maximum(apart[of], 1e-17)), share, where="post", **look)
        right.step(np.sort(ratio[of]), share, where="post", **look)
    left.set(xscale="log", xlabel="largest difference of a joint (rad)")
    left.set_ylabel("share of movements")
    left.legend(loc="center")
    right.set(xlabel="cost in the other engine, over its own")
    return figure


@styled
def plot_searched(datasets: Mapping[str, Dataset], weight: int = 0) -> Figure:
    """Draw the same tasks searched in either engine.

    Parameters
    ----------
    datasets : mapping of str to Dataset
        Of two engines, by their names; the same tasks round a circle.
    weight : int, default=0
        Which of the policy's weights is drawn.

    Returns
    -------
    Figure
        Above, the weight over the task, and the jumps that each engine has as ticks at
        its side; below, how far apart the two policies of a task are, over the spread
        of the first.
    """
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(7.4, 4.2), sharex=True, height_ratios=(3, 2)
    )
    looks = zip(TRIO, ("o", "x"), (0.97, 0.03), datasets.items(), strict=False)
    for colour, marker, side, (name, data) in looks:
        tasks = np.degrees(data.tasks[:, 0])
        look: dict[str, Any] = {"marker": marker, "ms": 5, "mfc": "none", "ls": "none"}
        look |= {"color": colour, "label": name}
        above.plot(tasks, data.policies[:, weight], **look)
        jumps = find_jumps(data.tasks, data.policies, closed=True)
        edges = tasks[jumps] + 180 / len(tasks)
        at = np.full(len(edges), side)
        where = above.get_xaxis_transform()
        above.plot(edges, at, "|", color=colour, ms=12, mew=1.5, transform=where)
    above.set(ylabel=f"weight {WEIGHT_NAMES[weight]}")
    above.legend(loc="upper left", bbox_to_anchor=(1, 1))
    one, other = (data.policies for data in datasets.values())
    spread = np.sqrt(one.var(axis=0).sum())
    apart = np.linalg.norm(one - other, axis=1) / spread
    below.plot(tasks, apart, color="0.3", marker=".", lw=0.8)
    below.set(yscale="log", ylabel="apart, of the spread")
    below.set(xlabel="task angle (degrees)")
    below.set_xticks(range(0, 361, 60))
    return figure


@styled
def plot_finer_steps(engines: Mapping[str, Any]) -> Figure:
    """Draw what finer steps of the physics change where the arm meets an obstacle.

    Parameters
    ----------
    engines : dict
        What `msc.worlds.compare_engines` wrote.

    Returns
    -------
    Figure
        Over the steps in one of the controller's, a line a world: the impulse of all
        contacts in each engine, the mean over movements; by how much a cost differs
        from that with the finest steps in the same engine, and by how much from that
        in the other engine with the same steps, the largest over movements.
    """
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(7.4, 2.6))
    middle.sharey(right)
    looks = {
        "pybullet": {"color": TRIO[0], "marker": "o", "ls": "-", "label": "PyBullet"},
        "mujoco": {"color": TRIO[1], "marker": "s", "ls": "--", "label": "MuJoCo"},
    }
    for world in engines["steps"].values():
        steps = world["substeps"]
        costs = {engine: np.array(world[engine]["cost"]) for engine in looks}
        for engine, look in looks.items():
            impulses = np.mean(world[engine]["impulse_n_s"], axis=1)
            left.plot(steps, impulses, ms=4, lw=1, **look)
            apart = _farthest(costs[engine], costs[engine][-1])
            middle.plot(steps[:-1], apart[:-1], ms=4, lw=1, **look)
            look["label"] = ""
        apart = _farthest(costs["mujoco"], costs["pybullet"])
        right.plot(steps, apart, color="0.3", marker="D", ms=4, lw=1)
        for axis in (left, middle, right):
            axis.set_xscale("log", base=4)
            axis.set_xticks(steps, [f"{one}" for one in steps])
            axis.minorticks_off()
    middle.set_xlabel("steps of the physics in one of the controller's")
    left.set(yscale="log", title="impulse (N s)")
    left.yaxis.set_major_formatter("{x:g}")
    middle.set_title("cost, off the finest (%)")
    right.set(title="cost, off the other engine (%)", ylim=(0, None))
    middle.legend(*left.get_legend_handles_labels(), loc="upper right", fontsize=SMALL)
    return figure


def _farthest(costs: NDArray[np.float64], others: NDArray[np.float64]) -> Any:
    """Return the largest difference of costs in each row (%)."""
    return 100 * np.abs(costs / others - 1).max(axis=1)
