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
from msc.plots._style import SMALL, WORLD_STYLES, styled
from msc.plots._tables import lay_out

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
def plot_benchmark(
    costs: Timings, tables: Mapping[str, pd.DataFrame] | None = None
) -> Figure:
    """Draw what a rollout costs, and how a task's search shrinks among others.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.
    tables : mapping from str to DataFrame, optional
        Searched policies of whole worlds, as `load_dataset` gives them.

    Returns
    -------
    Figure
        Left every way to do a rollout in units of its raw steps; right the rollouts
        that a task takes over the number of tasks searched together.
    """
    figure, (ways, growth) = plt.subplots(
        1, 2, figsize=(7.4, 3.5), width_ratios=(1.15, 1)
    )
    _draw_ways(ways, costs)
    _draw_growth(growth, costs, tables or {})
    return figure


def benchmark_table(costs: Timings, what: str) -> pd.DataFrame:
    """List what something costs.

    Parameters
    ----------
    costs : mapping
        What `load_benchmark` gives.
    what : {"rollouts", "tasks", "growth", "data", "learners", "SMCE"}
        Rollouts beside other ways to do them; tasks, searched and predicted; searches
        of more tasks, by more workers; the tables of searched policies; the skill
        beside a single regression, and SMCE beside cvxpy; fits of SMCE to more points,
        each in a process of its own on one core.

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


def _list_tasks(costs: Timings) -> _Columns:
    """Compare searches with predictions, one column a world."""
    columns = {}
    for world, search in costs["searches"].items():
        skill = costs["skill"][world]
        one, many = (skill[f"predict_{n}_microseconds"] for n in ("one", "many"))
        seconds = search["seconds_per_task"]
        samples, calls = skill["n_samples"], skill["n_predicted"]
        columns[world] = {
            "searched: rollouts": f"{search['evaluations_per_task']:.0f}",
            "searched: seconds": seconds,
            "ms a rollout, CMA-ES included": search["milliseconds_per_evaluation"],
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
        minutes = rollouts * search["milliseconds_per_evaluation"] / 60_000
        columns[world] = {
            "tasks": len(searched),
            "rollouts": rollouts,
            "rollouts/task": rollouts / len(searched),
            "minutes of one core": minutes,
        }
    return columns


def _list_learners(costs: Timings) -> _Columns:
    """Compare the skill, and SMCE, with other ways to do the same."""
    smce = costs["learners"]["smce"]
    rows = {
        f"SMCE, {smce['n_points']} points: seconds to fit": smce["fit_seconds"],
        "one cvxpy problem a point: seconds": smce["one_by_one_seconds"],
        "cvxpy / SMCE": smce["one_by_one_over_fit"],
    }
    for world, skill in costs["learners"]["skill"].items():
        head = f"{world}, {skill['n_samples']} samples"
        for step, asked in (("fit", ""), ("predict", f" {skill['n_predicted']}")):
            task, charts = f"{head}: ms to {step}{asked}", f"{skill['n_charts']} charts"
            rows[f"{task}, {charts}"] = skill[f"{step}_charts_milliseconds"]
            rows[f"{task}, single"] = skill[f"{step}_single_milliseconds"]
            rows[f"{head}: {step}, charts / single"] = skill[
                f"{step}_charts_over_single"
            ]
    return {"": rows}


def _list_smce(costs: Timings) -> _Columns:
    """List fits of SMCE, one row a number of points."""
    fits = pd.DataFrame(costs["learners"]["fits"]).set_index("n_points")
    fits = fits.rename_axis("points")
    return {
        "seconds": fits["seconds"],
        "ms a point": 1000 * fits["seconds"] / fits.index,
        "MB, at most": fits["peak_mb"],
        "MB before": fits["before_mb"],
    }


_LISTS = {
    "rollouts": _list_rollouts,
    "tasks": _list_tasks,
    "growth": _list_growth,
    "data": _list_data,
    "learners": _list_learners,
    "SMCE": _list_smce,
}


def _draw_ways(axis: Axes, costs: Timings) -> None:
    """Draw the times of a rollout, medians and the middle four fifths of rounds."""
    timed = {world: one["milliseconds"] for world, one in costs["rollouts"].items()}
    ways = [way for way in reversed(_WAYS) if all(one[way] for one in timed.values())]
    look: Any = {"ls": "", "ms": 5, "mec": "white", "mew": 0.5, "elinewidth": 1.2}
    for number, (world, times) in enumerate(timed.items()):
        keys = "low", "median", "high"
        low, middle, high = (np.array([times[way][k] for way in ways]) for k in keys)
        raw = times["raw_steps"]["median"]
        axis.errorbar(
            middle / raw,
            np.arange(len(ways)) + 0.24 * (0.5 - number),
            xerr=np.array([middle - low, high - middle]) / raw,
            label=world,
            **look,
            **WORLD_STYLES[world],
        )
    axis.axvline(ROLLOUT_LIMIT, color="0.3", lw=1, ls="--")
    axis.text(ROLLOUT_LIMIT, -0.4, f" {ROLLOUT_LIMIT:g} ×", fontsize=SMALL, va="bottom")
    axis.set_xscale("log")
    left, right = axis.get_xlim()
    ticks = [tick for tick in (0.5, 1, 2, 5, 10, 20, 50) if left <= tick <= right]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)
    axis.set_yticks(range(len(ways)), [_WAYS[way] for way in ways])
    axis.set(ylim=(-0.5, len(ways) - 0.5), xlabel="time (multiples of raw steps)")
    axis.set_title("one rollout", loc="left")
    axis.legend(loc="upper right")


def _draw_growth(
    axis: Axes, costs: Timings, tables: Mapping[str, pd.DataFrame]
) -> None:
    """Draw rollouts per task: alone, in the benchmark's circles, in the tables."""
    growth = costs["growth"]
    runs = {(run["n_tasks"], run["evaluations_per_task"]) for run in growth["runs"]}

    def draw(world: str, name: str, *places: Any, **look: Any) -> None:
        axis.plot(*places, label=f"{world}, {name}", **look, **WORLD_STYLES[world])

    draw(growth["workspace"], "benchmark's circle", *np.transpose(sorted(runs)), ms=5)
    for world, alone in costs["searches"].items():
        spent = alone["evaluations_per_task"]
        draw(world, "one task alone", 1, spent, ls="", mfc="none")
    for world, table in tables.items():
        place = len(table), table["evaluations"].mean()
        draw(world, "the data set", *place, ls="", ms=8, mec="black")
    counts = sorted({1, *(n for n, _ in runs), *map(len, tables.values())})
    axis.set_xscale("log")
    axis.set_xticks(counts, [f"{count}" for count in counts])
    axis.set_xticks([], minor=True)
    axis.set(xlabel="tasks searched together", ylabel="rollouts per task")
    axis.set_title("one task", loc="left")
    axis.set_ylim(bottom=0)
    axis.figure.legend(
        *axis.get_legend_handles_labels(), ncols=3, loc="outside lower right"
    )
