"""What rollouts, searches and predictions cost: the benchmark's file, tables, figure.

`make bench` writes ``benchmarks/results.json``. All that the book says of speed is read
from there by the functions below.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msc.looks import SMALL, STYLE, WORLDS
from msc.tables import find_data

LIMIT = 2.0  # what a rollout may cost, in units of its bare physics

_RATIOS = {
    "rollouts_per_second": "rollouts a second, one process",
    "rollout_over_raw_steps": "rollout / raw steps",
    "rollout_over_own_steps": "rollout / own steps",
    "naive_over_raw_steps": "NumPy loop / raw steps",
    "floats_over_raw_steps": "float loop / raw steps",
    "speedup_over_naive": "NumPy loop / rollout",
    "speedup_over_floats": "float loop / rollout",
    "rollout_over_mujoco": "rollout / MuJoCo's, open loop",
}
_WAYS = {
    "mujoco": "MuJoCo, open loop",
    "raw_steps": "raw steps",
    "own_steps": "own steps",
    "search": "rollout in the search",
    "floats": "loop, floats",
    "naive": "loop, NumPy",
}
_Figures = Mapping[str, Any]


def load_costs(path: str | Path | None = None) -> dict[str, Any]:
    """Load what the benchmark measured.

    Parameters
    ----------
    path : str or Path, optional
        The file; by default ``benchmarks/results.json``, beside the folder `data`.

    Returns
    -------
    dict
        The figures, see ``benchmarks/bench.py``.

    Raises
    ------
    ValueError
        If the file is missing or holds something else.

    Examples
    --------
    >>> costs = load_costs()
    >>> sorted(costs["rollouts"])
    ['free', 'obstacles']
    """
    file = Path(path or find_data().parent / "benchmarks" / "results.json")
    if not file.is_file():
        raise ValueError(f"{file} is not there; `make bench` writes it")
    figures = json.loads(file.read_text(encoding="utf-8"))
    parts = (
        "machine",
        "memory",
        "rollouts",
        "searches",
        "growth",
        "skill",
        "learners",
    )
    missing = [part for part in parts if part not in figures]
    if missing:
        raise ValueError(f"{file} lacks {', '.join(missing)}; `make bench` renews it")
    return dict(figures)


def rollout_table(figures: _Figures) -> pd.DataFrame:
    """List what a rollout costs beside other ways to do it.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a ratio, one column a world: the median over the rounds, and in brackets
        where the middle four fifths of them lie.
    """
    return pd.DataFrame(
        {
            world: {label: _text(measured[key]) for key, label in _RATIOS.items()}
            for world, measured in figures["rollouts"].items()
        }
    )


def task_table(figures: _Figures) -> pd.DataFrame:
    """List what a task costs: searched, and predicted.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a figure, one column a world.
    """
    columns = {}
    for world, search in figures["searches"].items():
        skill = figures["skill"][world]
        predicted = skill["predict_one_microseconds"]
        seconds = search["seconds_per_task"]
        columns[world] = {
            "searched: rollouts": f"{search['evaluations_per_task']:.0f}",
            "searched: seconds": _digits(seconds),
            "ms a rollout, CMA-ES included": _digits(
                search["milliseconds_per_evaluation"]
            ),
            f"skill of {skill['n_samples']} samples: seconds to fit": _digits(
                skill["fit_seconds"]
            ),
            "predicted: µs": _text(predicted),
            f"predicted, {skill['n_predicted']} a call: µs each": _text(
                skill["predict_many_microseconds"]
            ),
            "searched / predicted": f"{1e6 * seconds / predicted['median']:,.0f}",
        }
    return pd.DataFrame(columns)


def growth_table(figures: _Figures) -> pd.DataFrame:
    """List what it costs to search more tasks, by more workers.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a search.
    """
    runs = pd.DataFrame(figures["growth"]["runs"]).sort_values(["workers", "n_tasks"])
    names = {
        "workers": "workers",
        "n_tasks": "tasks",
        "seconds": "seconds",
        "tasks_per_second": "tasks/s",
        "evaluations_per_task": "rollouts/task",
    }
    shown = runs[list(names)].rename(columns=names).set_index(["workers", "tasks"])
    return shown.map(_digits)


def data_table(figures: _Figures, tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """List what tables of searched policies took.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.
    tables : mapping from str to DataFrame
        Searched policies of whole worlds, as `load_dataset` gives them.

    Returns
    -------
    DataFrame
        One row a figure, one column a world.
    """
    columns = {}
    for world, table in tables.items():
        milliseconds = figures["searches"][world]["milliseconds_per_evaluation"]
        rollouts = table["evaluations"].sum()
        columns[world] = {
            "tasks": f"{len(table)}",
            "rollouts": f"{rollouts:,}",
            "rollouts/task": _digits(rollouts / len(table)),
            "minutes of one core": _digits(rollouts * milliseconds / 60_000),
        }
    return pd.DataFrame(columns)


def plot_costs(
    figures: _Figures, tables: Mapping[str, pd.DataFrame] | None = None
) -> Figure:
    """Draw what a rollout costs, and how a task's search shrinks among others.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.
    tables : mapping from str to DataFrame, optional
        Searched policies of whole worlds, as `load_dataset` gives them.

    Returns
    -------
    Figure
        Left every way to do a rollout in units of its raw steps; right the rollouts
        that a task takes over the number of tasks searched together.
    """
    with plt.rc_context(STYLE):
        figure, (ways, growth) = plt.subplots(
            1, 2, figsize=(7.4, 3.0), width_ratios=(1.15, 1)
        )
        _draw_ways(ways, figures)
        _draw_growth(growth, figures, tables or {})
    plt.close(figure)
    return figure


def _draw_ways(axis: Axes, figures: _Figures) -> None:
    """Draw the times of a rollout, medians and the middle four fifths of rounds."""
    worlds = figures["rollouts"]
    ways = [
        way
        for way in reversed(_WAYS)
        if all(measured["milliseconds"][way] for measured in worlds.values())
    ]
    for number, (world, measured) in enumerate(worlds.items()):
        times = [measured["milliseconds"][way] for way in ways]
        low, middle, high = (
            np.array([time[key] for time in times]) for key in ("low", "median", "high")
        )
        raw = measured["milliseconds"]["raw_steps"]["median"]
        axis.errorbar(
            middle / raw,
            np.arange(len(ways)) + 0.24 * (0.5 - number),
            xerr=np.array([middle - low, high - middle]) / raw,
            ls="",
            ms=5,
            mec="white",
            mew=0.5,
            elinewidth=1.2,
            label=world,
            **WORLDS[world],
        )
    axis.axvline(LIMIT, color="0.3", lw=1, ls="--")
    axis.text(LIMIT, -0.4, f" {LIMIT:g} ×", fontsize=SMALL, va="bottom")
    axis.set_xscale("log")
    ticks = [tick for tick in (0.5, 1, 2, 5, 10, 20, 50) if _within(tick, axis)]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(ways)), [_WAYS[way] for way in ways])
    axis.set(ylim=(-0.5, len(ways) - 0.5), xlabel="time, in units of raw steps")
    axis.set_title("one rollout", loc="left")
    axis.legend(loc="upper right")


def _draw_growth(
    axis: Axes, figures: _Figures, tables: Mapping[str, pd.DataFrame]
) -> None:
    """Draw rollouts per task: alone, in the benchmark's circles, in the tables."""
    growth = figures["growth"]
    runs = sorted(
        {(run["n_tasks"], run["evaluations_per_task"]) for run in growth["runs"]}
    )
    look = WORLDS[growth["workspace"]]
    axis.plot(*np.transpose(runs), ms=5, label=f"{growth['workspace']}, bench", **look)
    for world, searched in figures["searches"].items():
        axis.plot(
            1,
            searched["evaluations_per_task"],
            ls="",
            mfc="none",
            label=f"{world}, alone",
            **WORLDS[world],
        )
    for world, table in tables.items():
        axis.plot(
            len(table),
            table["evaluations"].mean(),
            ls="",
            ms=8,
            mec="black",
            label=f"{world}, data/",
            **WORLDS[world],
        )
    counts = sorted({1, *(n for n, _ in runs), *map(len, tables.values())})
    axis.set_xscale("log")
    axis.set_xticks(counts, [f"{count}" for count in counts])
    axis.set_xticks([], minor=True)
    axis.set(xlabel="tasks searched together", ylabel="rollouts per task")
    axis.set_title("one task", loc="left")
    axis.set_ylim(bottom=0)
    axis.legend(ncols=2, loc="lower center")


def _within(tick: float, axis: Axes) -> bool:
    """Whether a tick lies in the range of the x axis."""
    low, high = axis.get_xlim()
    return low <= tick <= high


def _text(measured: Mapping[str, float] | None) -> str:
    """Write a median and its range, or that there is none."""
    if measured is None:
        return "left out"
    low, high = _digits(measured["low"]), _digits(measured["high"])
    return f"{_digits(measured['median'])} ({low}–{high})"


def _digits(value: float) -> str:
    """Write a number with three digits, a large one with all before the point."""
    return f"{value:,.0f}" if value >= 100 else f"{value:#.3g}".rstrip(".")
