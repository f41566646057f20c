"""From the errors of many trials to summaries and ratios, each with its interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.study._comparison import Resamples, interval
from msc.study._trial import Trial

SHARES = ("under_1_cm", "touched")  # no ratios: a share is often zero
SAME_KERNEL = ("charts, Matérn", "single, Matérn")  # compared besides "charts"
FEW = 10  # test tasks; of fewer, a bootstrap's interval is far too narrow

Array = NDArray[np.float64]
Errors = dict[str, pd.DataFrame]


def measure_errors(trial: Trial) -> Errors:
    """Measure a trial in every way.

    Parameters
    ----------
    trial : Trial
        One training set and the methods fitted to it.

    Returns
    -------
    dict from str to DataFrame
        For each measure one row a test task, one column a method.
    """
    errors = {
        f"mse, {reading}": trial.squared_errors(reading)
        for reading in ("gate learned", "chart known", "away from jumps")
    }
    error = trial.executed_by_method("error_cm")
    return errors | {
        "mse, beside jumps": trial.squared_errors("beside jumps"),
        "standardised mse, gate learned": trial.squared_errors(standardised=True),
        "error_cm": error,
        "excess_cost": trial.executed_by_method("excess_cost"),
        "under_1_cm": error < 1,
        "touched": trial.executed_by_method("touched"),
        "error_cm spread": error,
    }


def summarise_trials(
    trials: Sequence[Errors],
    weights: pd.Series | None = None,
    *,
    n_resamples: int = 1_000,
    seed: int = 0,
) -> dict[str, Any]:
    """Summarise trials that differ by their training sets alone.

    Parameters
    ----------
    trials : sequence of dict
        What `measure_errors` returned, one entry a training set.
    weights : Series, optional
        How much each test task counts, indexed as the errors are; by default all the
        same.
    n_resamples : int, default=1000
        Bootstrap resamples.
    seed : int, default=0
        Seed of the resampling.

    Returns
    -------
    dict
        Under "measures", by measure and method, a summary; under "ratios" the charts'
        mean over that of each other method, and those of the two with a Matérn kernel,
        with the interval of `compare`. A measure without a test task, as beside jumps
        where there are none, is left out. One of fewer than ten has no ratios: with
        three test tasks an interval that is meant to miss one time in twenty misses one
        in four.

    Notes
    -----
    A summary's standard deviation, median and 95th percentile are those of all errors,
    whichever the training set; those of "error_cm spread", which is one number a
    training set, are over the training sets.
    """
    measures: dict[str, Any] = {}
    ratios: list[dict[str, Any]] = []
    for label, first in trials[0].items():
        if first.empty:
            continue
        counted = None if weights is None else weights.loc[first.index].to_numpy()
        shape = (len(trials), len(first))
        draws = Resamples(shape, n_resamples=n_resamples, seed=seed)
        spread = label.endswith("spread")
        measures[label], averages = {}, {}
        for method in map(str, first):
            errors = np.array([trial[label][method] for trial in trials], dtype=float)
            per_set = draws.per_set(errors, counted, spread=spread)
            averages[method] = draws.average(per_set)
            values = per_set[:1].T if spread else errors
            measures[label][method] = {
                **_bound(averages[method], "mean"),
                **_describe(values, None if spread else counted),
                "n_tasks": shape[1],
                "per_repetition": [_plain(value) for value in per_set[0]],
            }
        if label not in SHARES and shape[1] >= FEW:
            ratios += _divide(label, averages)
    return {"measures": measures, "ratios": ratios}


def _describe(errors: Array, weights: ArrayLike | None) -> dict[str, float]:
    """Describe how errors scatter over training sets and test tasks."""
    values, counted, rule = errors.ravel(), None, "linear"
    if weights is not None:  # of the rules for quantiles one allows weights
        counted = np.broadcast_to(weights, errors.shape).ravel()
        rule = "inverted_cdf"
    centred = values - np.average(values, weights=counted)
    variance = np.average(centred**2, weights=counted)
    variance *= len(values) / max(1, len(values) - 1)
    quantiles: Any = {"weights": counted, "method": rule}
    median, p95 = np.quantile(values, [0.5, 0.95], **quantiles)
    return {
        "std": _plain(np.sqrt(variance)),
        "median": _plain(median),
        "p95": _plain(p95),
    }


def _divide(label: str, averages: dict[str, Array]) -> list[dict[str, Any]]:
    """Divide the charts' mean by that of each other method, where that is positive."""
    pairs = [("charts", other) for other in averages if other != "charts"]
    return [
        {"measure": label, "method": ours, "baseline": theirs}
        | _bound(averages[ours] / averages[theirs], "ratio")
        for ours, theirs in [*pairs, SAME_KERNEL]
        if {ours, theirs} <= averages.keys() and (averages[theirs] > 0).all()
    ]


def _bound(values: Array, name: str) -> dict[str, float]:
    """Name a statistic, the first of its values, and bound it by the resampled ones."""
    low, high = interval(values[1:])
    return {name: _plain(values[0]), "low": _plain(low), "high": _plain(high)}


def _plain(value: float) -> float:
    """Keep six digits: more than any interval deserves, and fewer to store."""
    return float(f"{value:.6g}")
