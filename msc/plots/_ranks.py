"""Average ranks of methods, and what tells them apart."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from msc.plots._style import COLOURS, SMALL, styled
from msc.study import METHODS, Ranks


@styled
def plot_ranks(ranks: Ranks) -> Figure:
    """Draw average ranks, the best on top, and join whom the test does not tell apart.

    Parameters
    ----------
    ranks : Ranks
        What `msc.study.rank_methods` gives.

    Returns
    -------
    Figure
        A row a method; a bar at the right for each run of methods that are nearer than
        the critical difference, drawn above; below, who is not ranked and why.
    """
    names, values = list(ranks.means.index), ranks.means.to_numpy()
    n_methods, ties = len(names), ranks.ties
    places = -np.arange(n_methods)
    height = 1.3 + 0.19 * n_methods
    figure, (axis, bars) = plt.subplots(
        1, 2, figsize=(7.2, height), sharey=True, width_ratios=(3, 1)
    )
    paper = [name in METHODS and METHODS[name].group == "paper" for name in names]
    colours = [COLOURS["charts"] if ours else "0.35" for ours in paper]
    axis.hlines(places, 1, values, color="0.85", lw=1)
    axis.scatter(values, places, color=colours, s=22, zorder=2)
    axis.set_yticks(places, names, fontsize=SMALL)
    axis.set(xlim=(0.5, n_methods + 0.5), ylim=(0.6 - n_methods, 1.8))
    lacking = [f"not ranked: {name}, {why}" for name, why in ranks.left_out.items()]
    axis.set_xlabel("\n".join(["average rank, 1 is the best", *lacking]))
    end = 1 + ranks.critical
    axis.plot((1, end), (1, 1), color="0.2", marker="|", ms=7)
    text = f" critical difference {ranks.critical:.1f}, {ranks.n_blocks} arcs"
    axis.text(end, 1, text, va="center", fontsize=SMALL)
    for number, (first, last) in enumerate(ties):
        bars.plot([number] * 2, (places[first], places[last]), color="0.3", lw=2.5)
    bars.set(xlim=(-1, max(len(ties), 6)), xticks=[])
    bars.tick_params(left=False)
    bars.spines[:].set_visible(False)
    bars.grid(visible=False)
    bars.set_title("not told apart", loc="left")
    return figure
