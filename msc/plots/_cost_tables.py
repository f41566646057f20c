"""What rollouts, searches, fits and predictions cost: the benchmark's file as tables.

`make bench` writes ``data/results/bench.json``. All that the book says of speed is read
from there by the functions below.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from msc.data import find_data

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
_Figures = Mapping[str, Any]


def load_costs(path: str | Path | None = None) -> dict[str, Any]:
    """Load what the benchmark measured.

    Parameters
    ----------
    path : str or Path, optional
        The file; by default ``data/results/bench.json``.

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
    file = Path(path or find_data() / "results" / "bench.json")
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


def smce_table(figures: _Figures) -> pd.DataFrame:
    """List what a fit of SMCE costs, over the number of points.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a number of points, each fitted in a process of its own on one core.
    """
    fits = pd.DataFrame(figures["learners"]["fits"])
    shown = pd.DataFrame(
        {
            "seconds": fits["seconds"],
            "ms a point": 1000 * fits["seconds"] / fits["n_points"],
            "MB, at most": fits["peak_mb"],
            "MB before": fits["before_mb"],
        }
    )
    return shown.map(_digits).set_index(fits["n_points"].rename("points"))


def learner_table(figures: _Figures) -> pd.DataFrame:
    """List what the skill costs beside a single regression, and SMCE beside cvxpy.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a figure: the median over the rounds, and in brackets where the middle
        four fifths of them lie.
    """
    smce = figures["learners"]["smce"]
    rows = {
        f"SMCE, {smce['n_points']} points: seconds to fit": smce["fit_seconds"],
        "one cvxpy problem a point: seconds": smce["one_by_one_seconds"],
        "cvxpy / SMCE": smce["one_by_one_over_fit"],
    }
    for world, skill in figures["learners"]["skill"].items():
        head = f"{world}, {skill['n_samples']} samples"
        for step, asked in (("fit", ""), ("predict", f" {skill['n_predicted']}")):
            what = f"{head}: ms to {step}{asked}"
            rows[f"{what}, {skill['n_charts']} charts"] = skill[
                f"{step}_charts_milliseconds"
            ]
            rows[f"{what}, single"] = skill[f"{step}_single_milliseconds"]
            rows[f"{head}: {step}, charts / single"] = skill[
                f"{step}_charts_over_single"
            ]
    return pd.DataFrame({"": {name: _text(value) for name, value in rows.items()}})


def _text(measured: Mapping[str, float] | None) -> str:
    """Write a median and its range, or that there is none."""
    if measured is None:
        return "left out"
    low, high = _digits(measured["low"]), _digits(measured["high"])
    return f"{_digits(measured['median'])} ({low}–{high})"


def _digits(value: float) -> str:
    """Write a number with three digits, a large one with all before the point."""
    return f"{value:,.0f}" if value >= 100 else f"{value:#.3g}".rstrip(".")
