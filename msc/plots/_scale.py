"""What many worlds cost, on one machine and on many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msc.plots._style import chart_colour, chart_marker, styled

STEPS = {"search": "search", "jumps": "bisection", "study": "study"}
N_WORLDS = 1000
N_CORES = 2, 16, 128, 1024

Cost = Mapping[str, Any]


@styled
def plot_scale(cost: Cost) -> Figure:
    """Draw how long many worlds take, over the number of cores.

    Parameters
    ----------
    cost : mapping
        `data/results/worlds_cost.json`: by step the "core_seconds" of one world, and
        of the same few worlds the "seconds" through "dask" with some numbers of
        workers.

    Returns
    -------
    Figure
        Left, worlds searched a minute with as many Dask workers as were measured, and
        what that many times one would be, dashed. Right, hours that `N_WORLDS`
        worlds take in each step over the number of cores, if each is kept as busy as
        by the measured workers of a machine whose cores they do not share.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 2.9))
    dask = cost["dask"]
    workers = np.array([int(n) for n in dask["seconds"]])
    rate = 60 * dask["worlds"] / np.array([*dask["seconds"].values()])
    left.plot(workers, rate[0] * workers, ls="--", color="0.5", lw=1)
    left.plot(workers, rate, marker="o", color=chart_colour(0))
    left.set(xlabel="Dask workers", ylabel="worlds a minute", xticks=workers)
    left.set(ylim=(0, None))
    left.set_title(f"{dask['tasks'] // dask['worlds']} tasks a world", loc="left")
    hours = scale_table(cost)
    for number, step in enumerate(hours.columns):
        look: dict[str, Any] = {"color": chart_colour(number)}
        look |= {"marker": chart_marker(number), "ms": 4.5}
        right.plot(hours.index, hours[step], label=step, **look)
    right.set(xscale="log", yscale="log", xlabel="cores", ylabel="hours")
    right.set_xticks(hours.index, [f"{n}" for n in hours.index])
    right.yaxis.set_major_formatter("{x:g}")
    right.minorticks_off()
    right.set_title(f"{N_WORLDS} worlds", loc="left")
    right.legend(frameon=False)
    return figure


def scale_table(
    cost: Cost, n_worlds: int = N_WORLDS, n_cores: Sequence[int] = N_CORES
) -> pd.DataFrame:
    """Work out how long many worlds take on so many cores.

    Parameters
    ----------
    cost : mapping
        `data/results/worlds_cost.json`.
    n_worlds : int, default=1000
        How many.
    n_cores : sequence of int, default=(2, 16, 128, 1024)
        Cores of a cluster, a worker each.

    Returns
    -------
    DataFrame
        Hours: a row a number of cores, a column a step, and one for all of them.

    Examples
    --------
    >>> cost = {"core_seconds": {"search": 360.0, "jumps": 36.0, "study": 720.0}}
    >>> cost |= {"machine": {"cores": 2}, "dask": {"seconds": {"1": 8.0, "2": 5.0}}}
    >>> scale_table(cost, n_cores=[100])  # each core busy for 8 of 10 seconds
           search  bisection  study   all
    cores
    100      1.25      0.125    2.5  3.875
    """
    busy = kept_busy(cost)
    hours = {
        words: [
            n_worlds * cost["core_seconds"][step] / n / busy / 3600 for n in n_cores
        ]
        for step, words in STEPS.items()
    }
    table = pd.DataFrame(hours, index=pd.Index(n_cores, name="cores"))
    return table.assign(all=table.sum(axis=1))


def kept_busy(cost: Cost) -> float:
    """Tell which share of their time workers are of use, as many as there are cores.

    Parameters
    ----------
    cost : mapping
        `data/results/worlds_cost.json`.

    Returns
    -------
    float
        How much quicker they are than one, over how many.
    """
    seconds = cost["dask"]["seconds"]
    n_workers = max(int(n) for n in seconds if int(n) <= cost["machine"]["cores"])
    return float(seconds["1"] / seconds[f"{n_workers}"] / n_workers)
