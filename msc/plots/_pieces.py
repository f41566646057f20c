"""Which tasks belong together: pieces between jumps and clusters, as coloured bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from msc.plots._style import SMALL, chart_colour, styled


@styled
def plot_pieces(
    task_deg: ArrayLike, parts: Mapping[str, ArrayLike], jumps: Sequence[int]
) -> Figure:
    """Draw a bar over the tasks for each way to part them.

    Parameters
    ----------
    task_deg : array_like of shape (n_tasks,)
        Task angles, ascending (degrees).
    parts : mapping of str to array_like of shape (n_tasks,)
        For each way, from top to bottom, the part of each task.
    jumps : sequence of int
        Indices of tasks for which the step to the next is a jump.

    Returns
    -------
    Figure
        A change of colour is a border; colours are given in the order in which parts
        begin. Dotted lines through all bars are the jumps.
    """
    degrees = np.asarray(task_deg, dtype=float)
    edges = np.r_[degrees[0], (degrees[1:] + degrees[:-1]) / 2, degrees[-1]]
    figure, axis = plt.subplots(figsize=(7.4, 0.5 + 0.3 * len(parts)))
    for place, labels in enumerate(parts.values()):
        numbers = pd.factorize(np.asarray(labels))[0]
        starts = np.r_[0, np.flatnonzero(np.diff(numbers)) + 1]
        left, right = edges[starts], edges[np.r_[starts[1:], len(degrees)]]
        colours: Any = [chart_colour(number) for number in numbers[starts]]
        axis.barh([-place] * len(starts), right - left, 0.75, left, color=colours)
    for jump in jumps:
        axis.axvline(edges[jump + 1], color="black", lw=1, ls=":")
    axis.set_yticks(-np.arange(len(parts)), list(parts), fontsize=SMALL)
    axis.tick_params(axis="y", length=0)
    axis.spines["left"].set_visible(False)
    axis.grid(visible=False)
    axis.set(xlabel="task angle (degrees)", xticks=range(0, 361, 60))
    axis.margins(x=0, y=0.02)
    return figure
