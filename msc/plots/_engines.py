"""Policies searched in one engine and executed in the other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from msc.plots._style import TRIO, styled

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
    left.legend(loc="upper left")
    right.set(xlabel="cost in the other engine, over its own")
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
        Over the steps in one of the controller's, a line a world and an engine: left
        the impulse of all contacts, the mean over movements; right by how much a cost
        differs from that with the finest steps, the largest over movements.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 2.9))
    looks = {
        "pybullet": {"color": TRIO[0], "marker": "o", "ls": "-", "label": "PyBullet"},
        "mujoco": {"color": TRIO[1], "marker": "s", "ls": "--", "label": "MuJoCo"},
    }
    for world in engines["steps"].values():
        for engine, look in looks.items():
            costs = np.array(world[engine]["cost"])
            impulses = np.mean(world[engine]["impulse_n_s"], axis=1)
            left.plot(world["substeps"], impulses, ms=4, lw=1, **look)
            apart = 100 * np.abs(costs / costs[-1] - 1).max(axis=1)
            right.plot(world["substeps"][:-1], apart[:-1], ms=4, lw=1, **look)
            look["label"] = ""
    for axis in (left, right):
        axis.set_xscale("log", base=2)
        axis.xaxis.set_major_formatter("{x:g}")
        axis.set_xlabel("steps of the physics in one of the controller's")
    left.set(yscale="log", ylabel="impulse, mean (N s)")
    left.yaxis.set_major_formatter("{x:g}")
    right.set_ylabel("cost, largest change (%)")
    left.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=2)
    return figure
