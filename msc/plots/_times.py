"""What each method takes to fit and to predict: a benchmark's file, shown."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msc.data import find_data
from msc.plots._leaderboard import APART
from msc.plots._style import COUNT_STYLES, SMALL, styled
from msc.plots._tables import WORLD_TITLES, Stored, lay_out
from msc.study import METHODS

_MIDDLE = "24"  # training tasks, by which methods are sorted
Times = Mapping[str, Any]  # the benchmark's file


def load_times(path: str | Path | None = None) -> dict[str, Any]:
    """Load what each method was found to take.

    Parameters
    ----------
    path : str or Path, optional
        The file; by default ``data/results/times.json``.

    Returns
    -------
    dict
        The times, see ``benchmarks/methods.py``.

    Raises
    ------
    ValueError
        If the file is missing.
    """
    file = Path(path or find_data() / "results" / "times.json")
    if not file.is_file():
        raise ValueError(f"{file} is not there; `make bench` writes it")
    return dict(json.loads(file.read_text(encoding="utf-8")))


def _by_time(times: Times, apart: Sequence[str] = ()) -> list[str]:
    """List the methods that were timed, the quickest to fit first."""
    found = times["methods"]
    key = _MIDDLE if all(_MIDDLE in one["fit"] for one in found.values()) else None

    def seconds(name: str) -> float:
        fits = found[name]["fit"]
        return float(fits[key or next(iter(fits))]["seconds"]["median"])

    out = {name for name in found if name in METHODS and METHODS[name].group in apart}
    return sorted(found.keys() - out, key=lambda name: (seconds(name), name))


def _sizes(times: Times) -> list[str]:
    """List the numbers of training tasks; not every method is timed at each."""
    return max((list(one["fit"]) for one in times["methods"].values()), key=len)


@styled
def plot_times(times: Times, *, apart: Sequence[str] = APART) -> Figure:
    """Draw how long each method fits, and predicts.

    Parameters
    ----------
    times : mapping
        What `load_times` gives.
    apart : sequence of str, default=("projected", "ladder", "choices")
        Groups of methods that are left out.

    Returns
    -------
    Figure
        A row a method, the quickest to fit on top; left the fit, tuning included, by
        the number of training tasks, right the prediction of all test tasks.
    """
    names = _by_time(times, apart)
    places = -np.arange(len(names))
    height = 1.1 + 0.19 * len(names)
    figure, axes = plt.subplots(
        1, 2, figsize=(7.4, height), sharey=True, width_ratios=(3, 2)
    )
    heads = "fit, tuned (s)", f"predict {times['n_predicted']} tasks (s)"
    for axis, what, head in zip(axes, ("fit", "predict"), heads, strict=True):
        sizes = _sizes(times)
        for size, look in zip(sizes, COUNT_STYLES, strict=False):
            timed = (times["methods"][name][what].get(size) for name in names)
            taken = [
                np.nan if one is None else one["seconds"]["median"] for one in timed
            ]
            more = look | {"ls": "", "ms": 4, "label": f"n = {size}"}
            axis.plot(taken, places, **more)
        axis.set(xscale="log")
        axis.set_title(head, loc="left")
    axes[0].set_yticks(places, names, fontsize=SMALL)
    axes[0].set_ylim(0.6 - len(names), 0.6)
    axes[0].legend(loc="upper right")
    return figure


def times_table(times: Times, *studies: Stored) -> pd.DataFrame:
    """List how long each method fits and predicts, and how many rollouts it spends.

    Parameters
    ----------
    times : mapping
        What `load_times` gives.
    *studies : dict
        Results of studies, whose rollouts are told.

    Returns
    -------
    DataFrame
        As text, a row a method of the comparison, the quickest to fit first, those that
        were not timed last: seconds of a fit by the number of training tasks, and as a
        multiple of the charts'; milliseconds of the prediction of all test tasks; mean
        rollouts per training set in each world.
    """
    known = times["methods"]
    listed = [name for name, method in METHODS.items() if method.sets != "sweep"]
    names = [*_by_time(times), *(name for name in listed if name not in known)]
    sizes = _sizes(times)
    size = _MIDDLE if _MIDDLE in sizes else sizes[0]

    def take(what: str, n: str, kind: str, unit: float = 1.0) -> list[float | None]:
        timed = (known.get(name, {}).get(what, {}).get(n) for name in names)
        return [None if one is None else unit * one[kind]["median"] for one in timed]

    columns: dict[tuple[str, str], list[Any]] = {
        ("fit (s)", f"n = {n}"): take("fit", n, "seconds") for n in sizes
    }
    columns["fit / charts", f"n = {size}"] = take("fit", size, "over_charts")
    predicted = take("predict", size, "seconds", 1000.0)
    columns[f"{times['n_predicted']} predictions (ms)", f"n = {size}"] = predicted
    for study in studies:
        spent = study.get("rollouts", {})
        title = WORLD_TITLES[study["workspace"]]
        columns["rollouts", title] = [round(spent.get(name, 0)) for name in names]
    table = lay_out(columns).set_index(pd.Index(names, name="method"))
    return table.replace("left out", "not timed")
