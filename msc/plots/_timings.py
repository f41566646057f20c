"""What rollouts, searches, fits and predictions cost: the benchmark's file, shown.

`make bench` writes ``data/results/bench.json``. All that the book says of speed is read
from there by the functions below.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msc.data import find_data, load_dataset
from msc.plots._style import CHART_MARKERS, SMALL, TRIO, WORLD_STYLES, styled
from msc.plots._tables import lay_out
from msc.study import COST_TOLERANCE

ROLLOUT_LIMIT = 2.0  # what a rollout may cost, in units of its bare physics

_RATIOS = {
    "rollouts_per_second": "rollouts a second, one process",
    "rollout_over_raw_steps": "rollout / raw steps",
    "rollout_over_own_steps": "rollout / own steps",
    "speedup_over_naive": "NumPy loop / rollout",
    "speedup_over_floats": "float loop / rollout",
    "rollout_over_mujoco": "rollout / MuJoCo's, open loop",
}
_WAYS = {  # from below
    "naive": "Python loop, NumPy",
    "floats": "Python loop, floats",
    "search": "rollout in the search",
    "own_steps": "own steps",
    "raw_steps": "raw steps",
    "mujoco": "MuJoCo, open loop",
}
_SEARCHES = {  # from below
    "fmin2": "pycma, fmin2",
    "lq_surr2": "pycma, fmin_lq_surr2",
    "plain": "before, plain CMA-ES",
    "alone": "msc, one by one",
    "lockstep": "msc, in lock-step",
}
_LIBRARIES = {"msc": "-", "scikit-learn": "--", "GPy": ":"}
_TICKS = [base * 10**k for k in range(-2, 4) for base in (1, 2, 5)]
_PARTS = ["machine", "memory", "rollouts", "searches", "growth", "skill", "learners"]
Timings = Mapping[str, Any]  # the benchmark's file
_Columns = Mapping[Any, Any] | pd.DataFrame


def load_benchmark(path: str | Path | None = None) -> dict[str, Any]:
    """Load what the benchmark measured.

    Parameters
    ----------
    path : str or Path, optional
        The file; by default ``data/results/bench.json``.

    Returns
    -------
    dict
        The costs, see ``benchmarks/bench.py``.

    Raises
    ------
    ValueError
        If the file is missing or holds something else.
    """
    file = Path(path or find_data() / "results" / "bench.json")
    if not file.is_file():
        raise ValueError(f"{file} is not there; `make bench` writes it")
    costs = json.loads(file.read_text(encoding="utf-8"))
    missing = [part for part in _PARTS if part not in costs]
    if missing:
        raise ValueError(f"{file} lacks {', '.join(missing)}; `make bench` renews it")
    return dict(costs)


@styled
def plot_benchmark(costs: Timings) -> Figure:
    """Draw what a rollout and the search of a task cost, each way to do them.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.

    Returns
    -------
    Figure
        Left a rollout in units of its raw steps; right the seconds of a task. Medians,
        and where the middle four fifths of rounds and of tasks lie.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.3))
    for number, world in enumerate(costs["rollouts"]):
        times = costs["rollouts"][world]["milliseconds"]
        times = {_WAYS[way]: pd.Series(times[way]) for way in _WAYS if times[way]}
        rollouts = pd.DataFrame(times) / times["raw steps"]["median"]
        _draw_ways(left, world, number, rollouts.loc[["low", "median", "high"]])
        by = costs["searches"][world]["ways"]
        spent = pd.DataFrame({_SEARCHES[way]: by[way]["seconds"] for way in _SEARCHES})
        _draw_ways(right, world, number, spent.quantile([0.1, 0.5, 0.9]))
    left.axvline(ROLLOUT_LIMIT, color="0.3", lw=1, ls="--")
    left.text(ROLLOUT_LIMIT, -0.4, f" {ROLLOUT_LIMIT:g} ×", fontsize=SMALL, va="bottom")
    left.set_xlabel("time (multiples of raw steps)")
    left.set_title("one rollout", loc="left")
    left.legend()
    right.set_xlabel("time (s)")
    right.set_title("one task searched", loc="left")
    return figure


def _draw_ways(axis: Axes, world: str, number: int, times: pd.DataFrame) -> None:
    """Draw a world's low, middle and high times, one column a way, from below."""
    low, middle, _ = times.to_numpy()
    place, span = np.arange(len(low)) + 0.24 * (0.5 - number), np.diff(times, axis=0)
    look: Any = {"ls": "", "ms": 5, "label": world, **WORLD_STYLES[world]}
    axis.errorbar(middle, place, xerr=span, **look)
    axis.set_yticks(range(len(low)), times.columns)
    axis.set(ylim=(-0.5, len(low) - 0.5), xscale="log")
    start, end = axis.get_xlim()
    ticks = [tick for tick in _TICKS if start <= tick <= end]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)


@styled
def plot_fits(costs: Timings) -> Figure:
    """Draw what learning takes over the number of samples.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.

    Returns
    -------
    Figure
        From left to right fits of regressions, by this package and by others; fits of
        SMCE, and dotted what grows as their number; the largest memory of these.
    """
    figure, axes = plt.subplots(1, 3, figsize=(7.4, 3.6))
    skills = pd.DataFrame(costs["learners"]["skills"])
    names = [name for name in skills["learner"].unique() if "SMCE" not in name]
    for (name, library), some in skills.groupby(["learner", "by"], sort=False):
        if name in names:
            look = {"ls": _LIBRARIES[str(library)], "label": f"{name}, {library}"}
            look |= _look(names.index(name))
            axes[0].plot(some["samples"], some["fit (s)"], **look)
    fits = pd.DataFrame(costs["learners"]["fits"]).dropna()
    for number, (shape, some) in enumerate(fits.groupby("of")):
        axes[1].plot(some["points"], some["seconds"], label=shape, **_look(number))
        axes[2].plot(some["points"], some["MB, at most"], **_look(number))
    least = fits.groupby("points")["seconds"].min()
    slope = 0.6 * least.iloc[-1] * least.index / least.index[-1]
    axes[1].plot(least.index, slope, color="0.4", ls=":", label="as their number")
    axes[1].legend()
    titles = "fits of regressions (s)", "fits of SMCE (s)", "their memory (MB)"
    for axis, title in zip(axes, titles, strict=True):
        axis.set(xscale="log", yscale="log", xlabel="samples")
        axis.set_title(title, loc="left")
    axes[2].set(yscale="linear", ylim=0)
    legend = axes[0].get_legend_handles_labels()
    figure.legend(*legend, ncols=3, loc="outside lower center")
    return figure


def _look(number: int) -> dict[str, Any]:
    return {"color": TRIO[number], "marker": CHART_MARKERS[number], "ms": 4}


def benchmark_table(costs: Timings, what: str) -> pd.DataFrame:
    """List what something costs.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.
    what : {"rollouts", "searches", "tasks", "growth", "data", "SMCE", "skills"}
        Rollouts, and searches of tasks, beside other ways to do them; tasks, searched
        and predicted; searches of more tasks, by more workers; the tables of searched
        policies; fits of SMCE; skills, with our Gaussian processes and with others'.

    Returns
    -------
    DataFrame
        As text: of what was timed in rounds the median, and in brackets where the
        middle four fifths of them lie.

    Raises
    ------
    ValueError
        If it is something else.
    """
    if what not in _LISTS:
        raise ValueError(f"what={what!r}; wanted one of {tuple(_LISTS)}")
    return lay_out(_LISTS[what](costs))


def _list_searches(costs: Timings) -> _Columns:
    """Compare searches of the same tasks, one row a world and way."""
    rows = {}
    for world, measured in costs["searches"].items():
        best = np.min([way["cost"] for way in measured["ways"].values()], axis=0)
        quickest = np.mean(measured["ways"]["lockstep"]["seconds"])
        for way, name in reversed(_SEARCHES.items()):
            found = pd.DataFrame(measured["ways"][way])
            means, dearer = found.mean(), found.div(best, axis=0) - 1
            rows[world, name] = {
                "rollouts": round(means["evaluations"]),
                "of the first start": round(means["first_evaluations"]),
                "seconds": means["seconds"],
                "× lock-step": means["seconds"] / quickest,
                "ms a rollout": 1000 * means["seconds"] / means["evaluations"],
                "above the least cost": f"{dearer['cost'].mean():.1%}",
                "first start": f"{dearer['first_cost'].mean():.1%}",
                "as good": f"{sum(dearer['cost'] <= COST_TOLERANCE)} of {len(best)}",
            }
    return pd.DataFrame.from_dict(rows, orient="index")


def _list_tasks(costs: Timings) -> _Columns:
    """Compare searches with predictions, one column a world."""
    columns = {}
    for world, skill in costs["skill"].items():
        seconds = np.mean(costs["searches"][world]["ways"]["alone"]["seconds"])
        one, many = (skill[f"predict_{n}_microseconds"] for n in ("one", "many"))
        columns[world] = {
            "searched alone: seconds": seconds,
            f"skill of {skill['n_samples']}: seconds to fit": skill["fit_seconds"],
            "predicted: µs": one,
            f"predicted, {skill['n_predicted']} a call: µs each": many,
            "searched / predicted": round(1e6 * seconds / one["median"]),
        }
    return columns


def _list_data(costs: Timings) -> _Columns:
    """Sum up what the tables of searched policies took, one column a world."""
    columns = {}
    for world, search in costs["searches"].items():
        spent = pd.DataFrame(search["ways"]["lockstep"]).sum()
        rollouts = load_dataset(world).table["evaluations"]
        minutes = rollouts.sum() * spent["seconds"] / spent["evaluations"] / 60
        columns[world] = {
            "tasks": len(rollouts),
            "rollouts": rollouts.sum(),
            "rollouts/task": rollouts.mean(),
            "minutes of one core": minutes,
        }
    return columns


def _list_skills(costs: Timings) -> _Columns:
    """Compare skills with others' Gaussian processes, one row a library's."""
    skills = _rows(costs["learners"]["skills"], "learner", "samples", "by")
    skills = skills.sort_index(level="learner", sort_remaining=False, kind="stable")
    ours = skills.groupby(["learner", "samples"]).transform("first")  # msc comes first
    ratios = (skills / ours).drop(columns="ln p").add_suffix(" / msc")
    apart = (skills["ln p"] - ours["ln p"]).round(1) + 0.0
    return skills.drop(columns="ln p").join(ratios).assign(**{"ln p - msc": apart})


def _rows(rows: list[dict[str, Any]], *names: str) -> pd.DataFrame:
    return pd.DataFrame(rows).set_index([*names])


_LISTS: dict[str, Callable[[Timings], _Columns]] = {
    "rollouts": lambda costs: {
        world: {label: measured[key] for key, label in _RATIOS.items()}
        for world, measured in costs["rollouts"].items()
    },
    "searches": _list_searches,
    "tasks": _list_tasks,
    "growth": lambda costs: pd.DataFrame(costs["growth"]).set_index(
        ["workers", "tasks"]
    ),
    "data": _list_data,
    "SMCE": lambda costs: pd.DataFrame(costs["learners"]["fits"]).set_index(
        ["points", "of"]
    ),
    "skills": _list_skills,
}
