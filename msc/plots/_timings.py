"""What rollouts, searches, fits and predictions cost: the benchmark's file, shown.

`make bench` writes ``data/results/bench.json``. All that the book says of speed is read
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

from msc.data import find_data, load_dataset
from msc.plots._style import SMALL, TRIO, WORLD_STYLES, styled
from msc.plots._tables import lay_out
from msc.study import COST_TOLERANCE

ROLLOUT_LIMIT = 2.0  # what a rollout may cost, in units of its bare physics

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
    "floats": "Python loop, floats",
    "naive": "Python loop, NumPy",
}
_SEARCHES = {
    "lockstep": "msc, in lock-step",
    "alone": "msc, one by one",
    "plain": "before: plain CMA-ES",
    "lq_surr2": "pycma, fmin_lq_surr2",
    "fmin2": "pycma, fmin2",
}
_LIBRARIES = {"msc": "-", "scikit-learn": "--", "GPy": ":"}
_TICKS = [base * 10**k for k in range(-2, 4) for base in (1, 2, 5)]
_FIFTHS = 10, 50, 90  # percentiles: the middle four fifths, and their middle
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

    Examples
    --------
    >>> costs = load_benchmark()
    >>> sorted(costs["rollouts"])
    ['free', 'obstacles']
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
    """Draw what a rollout costs, and the search of a task, each way to do it.

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
    figure, (rollouts, searches) = plt.subplots(1, 2, figsize=(7.4, 3.3))
    times, spent = {}, {}
    for world, measured in costs["rollouts"].items():
        found = {k: one for k, one in measured["milliseconds"].items() if one}
        raw = found["raw_steps"]["median"]
        times[world] = {
            _WAYS[way]: [found[way][k] / raw for k in ("low", "median", "high")]
            for way in reversed(_WAYS)
            if way in found
        }
        spent[world] = {
            name: np.percentile(
                costs["searches"][world]["ways"][way]["seconds"], _FIFTHS
            )
            for way, name in reversed(_SEARCHES.items())
        }
    _draw_ways(rollouts, times, "time (multiples of raw steps)")
    rollouts.axvline(ROLLOUT_LIMIT, color="0.3", lw=1, ls="--")
    place = ROLLOUT_LIMIT, -0.4
    rollouts.text(*place, f" {ROLLOUT_LIMIT:g} ×", fontsize=SMALL, va="bottom")
    rollouts.set_title("one rollout", loc="left")
    rollouts.legend(loc="upper right")
    _draw_ways(searches, spent, "time (s)")
    searches.set_title("one task searched", loc="left")
    return figure


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
        From left to right fits of regressions, by this package and by others, fits of
        SMCE, and its largest memory; dotted, what grows as the number does.
    """
    figure, axes = plt.subplots(1, 3, figsize=(7.4, 3.4), width_ratios=(1.2, 1, 1))
    skills = pd.DataFrame(costs["learners"]["skills"])
    skills = skills[skills["learner"] != "four charts, by SMCE"]
    for (learner, by), some in skills.groupby(["learner", "by"], sort=False):
        number = list(skills["learner"].unique()).index(learner)
        look = {"color": TRIO[number], "ls": _LIBRARIES[by], "marker": "os^"[number]}
        label = f"{learner}, {by}"
        axes[0].plot(some["n_samples"], some["fit_seconds"], label=label, ms=4, **look)
    growth = pd.DataFrame(costs["learners"]["growth"])
    for number, (shape, some) in enumerate(growth.groupby("shape")):
        look = {"color": TRIO[number], "marker": "os^"[number], "label": shape, "ms": 4}
        for axis, key in zip(axes[1:], ("seconds", "peak_mb"), strict=True):
            axis.plot(some["n_points"], some[key], **look)
    first = growth["seconds"].iloc[-3:].min() / growth["n_points"].iloc[-1]
    counts = growth["n_points"].unique()
    axes[1].plot(counts, first * counts, color="0.4", ls=":", label="as the number")
    titles = "fits of regressions (s)", "fits of SMCE (s)", "its memory (MB)"
    for axis, title in zip(axes, titles, strict=True):
        axis.set(xscale="log", xlabel="samples")
        axis.set_title(title, loc="left")
    axes[0].set_yscale("log")
    axes[1].set_yscale("log")
    axes[2].set_ylim(bottom=0)
    axes[1].legend()
    handles = axes[0].get_legend_handles_labels()
    figure.legend(*handles, ncols=3, loc="outside lower center")
    return figure


def benchmark_table(costs: Timings, what: str) -> pd.DataFrame:
    """List what something costs.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.
    what : {"rollouts", "searches", "tasks", "growth", "data", "SMCE", "fits", "skills"}
        Rollouts beside other ways to do them; searches of the same tasks; tasks,
        searched and predicted; searches of more tasks, by more workers; the tables of
        searched policies; SMCE beside cvxpy; fits of SMCE to more points, each in a
        process of its own on one core; skills with others' Gaussian processes.

    Returns
    -------
    DataFrame
        As text: of what was timed in rounds the median, and in brackets where the
        middle four fifths of them lie.

    Raises
    ------
    ValueError
        If it is something else.

    Examples
    --------
    >>> benchmark_table(load_benchmark(), "data").loc["tasks"].tolist()
    ['360', '360']
    """
    if what not in _LISTS:
        raise ValueError(f"what={what!r}; wanted one of {tuple(_LISTS)}")
    return lay_out(_LISTS[what](costs))


def _list_rollouts(costs: Timings) -> _Columns:
    """Compare rollouts: one row a ratio, one column a world."""
    return {
        world: {label: measured[key] for key, label in _RATIOS.items()}
        for world, measured in costs["rollouts"].items()
    }


def _list_searches(costs: Timings) -> _Columns:
    """Compare searches of the same tasks, one row a world and way."""
    rows = {}
    for world, measured in costs["searches"].items():
        ways = measured["ways"]
        best = np.min([way["cost"] for way in ways.values()], axis=0)
        for way, name in _SEARCHES.items():
            one = {key: np.array(values) for key, values in ways[way].items()}
            dearer = one["cost"] / best - 1
            seconds = one["seconds"].mean()
            rows[world, name] = {
                "rollouts": round(one["evaluations"].mean()),
                "first start": round(one["first_evaluations"].mean()),
                "seconds": seconds,
                "ms a rollout": 1000 * _rollout_seconds(ways[way]),
                "× lock-step": seconds / np.mean(ways["lockstep"]["seconds"]),
                "cost above the best": f"{dearer.mean():.2%}",
                "first start's": f"{(one['first_cost'] / best - 1).mean():.2%}",
                "as good": f"{(dearer <= COST_TOLERANCE).sum()} of {len(best)}",
            }
    return pd.DataFrame(rows).T


def _rollout_seconds(way: Timings) -> float:
    """Return what a rollout takes in a search, all that the search does included."""
    return float(np.sum(way["seconds"]) / np.sum(way["evaluations"]))


def _list_tasks(costs: Timings) -> _Columns:
    """Compare searches with predictions, one column a world."""
    columns = {}
    for world, search in costs["searches"].items():
        skill, alone = costs["skill"][world], search["ways"]["alone"]
        one, many = (skill[f"predict_{n}_microseconds"] for n in ("one", "many"))
        seconds = np.mean(alone["seconds"])
        samples, calls = skill["n_samples"], skill["n_predicted"]
        columns[world] = {
            "searched alone: rollouts": round(np.mean(alone["evaluations"])),
            "searched alone: seconds": seconds,
            f"skill of {samples} samples: seconds to fit": skill["fit_seconds"],
            "predicted: µs": one,
            f"predicted, {calls} a call: µs each": many,
            "searched / predicted": round(1e6 * seconds / one["median"]),
        }
    return columns


def _list_growth(costs: Timings) -> _Columns:
    """List searches of several tasks, one row a search."""
    runs = pd.DataFrame(costs["growth"]["runs"]).sort_values(["workers", "n_tasks"])
    runs = runs.set_index(["workers", "n_tasks"]).rename_axis(["workers", "tasks"])
    names = {"tasks_per_second": "tasks/s", "evaluations_per_task": "rollouts/task"}
    return runs.rename(columns=names)[["seconds", *names.values()]]


def _list_data(costs: Timings) -> _Columns:
    """Sum up what the tables of searched policies took, one column a world."""
    columns = {}
    for world, search in costs["searches"].items():
        searched = load_dataset(world).table["evaluations"]
        rollouts = searched.sum()
        minutes = rollouts * _rollout_seconds(search["ways"]["lockstep"]) / 60
        columns[world] = {
            "tasks": len(searched),
            "rollouts": rollouts,
            "rollouts/task": rollouts / len(searched),
            "minutes of one core": minutes,
        }
    return columns


def _list_smce(costs: Timings) -> _Columns:
    """Compare SMCE with one problem a point."""
    smce = costs["learners"]["smce"]
    rows = {
        f"SMCE, {smce['n_points']} points: seconds to fit": smce["fit_seconds"],
        "one cvxpy problem a point: seconds": smce["one_by_one_seconds"],
        "cvxpy / SMCE": smce["one_by_one_over_fit"],
    }
    return {"": rows}


def _list_fits(costs: Timings) -> _Columns:
    """List fits of SMCE, one row a number of points and a shape."""
    fits = pd.DataFrame(costs["learners"]["growth"])
    fits = fits.rename(columns={"n_points": "points"}).set_index(["shape", "points"])
    fits["ms a point"] = 1000 * fits["seconds"] / fits.index.get_level_values("points")
    names = {"peak_mb": "MB, at most", "before_mb": "MB before"}
    return fits.rename(columns=names)[["seconds", "ms a point", *names.values()]]


def _list_skills(costs: Timings) -> _Columns:
    """Compare skills with other libraries' Gaussian processes, one row a fit of ours."""
    rows = pd.DataFrame(costs["learners"]["skills"])
    rows = rows.rename(columns={"n_samples": "samples"})
    table = rows.set_index(["learner", "samples", "by"]).unstack("by")
    ours = table.xs("msc", axis=1, level="by")
    columns: dict[Any, Any] = {}
    for key, title in (("fit_seconds", "fit (s)"), ("predict_seconds", "predict (s)")):
        for by in _LIBRARIES:
            found = (key, by) in table
            columns[f"{title}, {by}"] = table[key, by] if found else [None] * len(table)
    for by in [by for by in _LIBRARIES if ("fit_seconds", by) in table][1:]:
        columns[f"{by} / msc, fit"] = table["fit_seconds", by] / ours["fit_seconds"]
        apart = ours["log_likelihood"] - table["log_likelihood", by]
        columns[f"ln p, msc - {by}"] = apart.map("{:+.1f}".format, na_action="ignore")
    return pd.DataFrame(columns, table.index, dtype=object)


_LISTS = {
    "rollouts": _list_rollouts,
    "searches": _list_searches,
    "tasks": _list_tasks,
    "growth": _list_growth,
    "data": _list_data,
    "SMCE": _list_smce,
    "fits": _list_fits,
    "skills": _list_skills,
}


def _draw_ways(axis: Axes, times: Mapping[str, Mapping[str, Any]], unit: str) -> None:
    """Draw low, middle and high times of ways from below, by world."""
    look: Any = {"ls": "", "ms": 5, "mec": "white", "mew": 0.5, "elinewidth": 1.2}
    for number, (world, ways) in enumerate(times.items()):
        low, middle, high = np.transpose(list(ways.values()))
        axis.errorbar(
            middle,
            np.arange(len(ways)) + 0.24 * (0.5 - number),
            xerr=np.array([middle - low, high - middle]),
            label=world,
            **look,
            **WORLD_STYLES[world],
        )
    axis.set_xscale("log")
    left, right = axis.get_xlim()
    ticks = [tick for tick in _TICKS if left <= tick <= right]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(ways)), list(ways))
    axis.set(ylim=(-0.5, len(ways) - 0.5), xlabel=unit)
