"""From the errors of many trials to summaries and ratios, each with its interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.estimates import Resamples, bounded, six_digits
from msc.study._trial import MEASURES, Trial

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
    return {key: measure.errors(trial) for key, measure in MEASURES.items()}


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
        spread = MEASURES[label].is_spread
        measures[label], averages = {}, {}
        for method in map(str, first):
            errors = np.array([trial[label][method] for trial in trials], dtype=float)
            per_set = draws.per_set(errors, counted, spread=spread)
            averages[method] = draws.average(per_set)
            values = per_set[:1].T if spread else errors
            measures[label][method] = {
                **bounded(averages[method]).stored("mean"),
                **_describe(values, None if spread else counted),
                "n_tasks": shape[1],
                "per_repetition": [six_digits(value) for value in per_set[0]],
            }
        if MEASURES[label].has_ratio and shape[1] >= FEW:
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
        "std": six_digits(np.sqrt(variance)),
        "median": six_digits(median),
        "p95": six_digits(p95),
    }


def _divide(label: str, averages: dict[str, Array]) -> list[dict[str, Any]]:
    """Divide the charts' mean by that of each other method, where that is positive."""
    pairs = [("charts", other) for other in averages if other != "charts"]
    return [
        {"measure": label, "method": ours, "baseline": theirs}
        | bounded(averages[ours] / averages[theirs]).stored("ratio")
        for ours, theirs in [*pairs, SAME_KERNEL]
        if {ours, theirs} <= averages.keys() and (averages[theirs] > 0).all()
    ]


def find_cell(study: dict[str, Any], design: str, n_samples: int) -> dict[str, Any]:
    """Find a study's results for a design and a number of training tasks.

    Parameters
    ----------
    study : dict
        Results of a study.
    design : {"even", "uniform", "nonuniform"}
        How training tasks were drawn.
    n_samples : int
        How many.

    Returns
    -------
    dict
        The entry of its "cells".

    Raises
    ------
    StopIteration
        If there is none.
    """
    found: dict[str, Any] = next(
        cell
        for cell in study["cells"]
        if (cell["design"], cell["n_samples"]) == (design, n_samples)
    )
    return found
