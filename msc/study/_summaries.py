"""From the errors of many trials to a study: summaries and ratios, with intervals.

A study of one workspace is a dictionary, written to `data/results/study_<world>.json`
and laid out as `Study` says. Claims, tables and figures read it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from operator import methodcaller
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from msc.estimates import Average, six_digits
from msc.study._sampling import TEST_SUBSETS

if TYPE_CHECKING:
    from msc.study._trial import Experiment

SAME_KERNEL = ("charts, Matérn", "single, Matérn")  # compared besides "charts"
FEW = 10  # test tasks; fewer say too little of others

Array = NDArray[np.float64]
Errors = dict[str, pd.DataFrame]


class Measure(NamedTuple):
    """What is measured of every method."""

    key: str  # in a study
    name: str  # where it is shown
    errors: Callable[[Experiment], pd.DataFrame]  # a row a test task, a column a method
    unit: str = ""  # policy weights have none
    has_ratio: bool = True  # no share has: it is often zero
    is_spread: bool = False  # a standard deviation over the test tasks, not their mean
    of: str = ""  # what a mean squared error is taken of

    @property
    def label(self) -> str:
        """What it is called, with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @property
    def axis(self) -> str:
        """What an axis says."""
        return f"mean squared error\nof {self.of}" if self.of else self.label


def _mse(subset: str, *, standardised: bool = False) -> Measure:
    """Return the measure of squared errors of policies on a test subset."""
    word = "standardised " if standardised else ""
    errors = methodcaller("squared_errors", subset=subset, standardised=standardised)
    key, name = f"{word}mse, {subset}", f"{word}MSE, {subset}"
    return Measure(key, name, errors, of=f"{word}policies, {subset}")


def _is_near(experiment: Experiment) -> pd.DataFrame:
    """Tell who ended within a centimetre of the target."""
    return experiment.executed_by_method("error_cm") < 1


_ERROR, _EXCESS, _TOUCHED = (
    methodcaller("executed_by_method", column=column)
    for column in ("error_cm", "excess_cost", "touched")
)
_SPREAD = "spread of distances at the end"
MEASURES = {
    measure.key: measure
    for measure in (
        *map(_mse, TEST_SUBSETS),
        _mse("gate learned", standardised=True),
        Measure("error_cm", "distance at the end", _ERROR, "cm"),
        Measure("excess_cost", "excess cost", _EXCESS),
        Measure("under_1_cm", "under_1_cm", _is_near, has_ratio=False),
        Measure("touched", "touched", _TOUCHED, has_ratio=False),
        Measure("error_cm spread", _SPREAD, _ERROR, "cm", is_spread=True),
    )
}


class Summary(TypedDict):
    """A method's errors: over test tasks and training sets, and one mean a set.

    Of a measure that is a spread, the latter three are those over the training sets.
    """

    mean: float
    low: float  # with `high`: a 95 % interval, see `msc.estimates.Average`
    high: float
    std: float
    median: float
    p95: float
    n_tasks: int
    per_repetition: list[float]


class Ratio(TypedDict):
    """The mean of a method's errors over that of another's, see `Average`."""

    measure: str
    method: str
    baseline: str
    ratio: float
    low: float
    high: float


class Cell(TypedDict):
    """A design and a sample size, of training sets that are all there are or drawn.

    A measure that no test task belongs to is left out, as beside jumps where there are
    none. Ratios are those of "charts" over all others, and of "charts, Matérn" over
    "single, Matérn". Shares have none, nor has what fewer than ten test tasks measure,
    nor has a mean that is not positive, as excess cost may be.
    """

    design: str  # "even", "uniform" or "nonuniform"
    n_samples: int
    repetitions: int  # training sets
    measures: dict[str, dict[str, Summary]]  # by key of `MEASURES`, by method
    ratios: list[Ratio]


class SweepCell(TypedDict):
    """A number of charts and a sample size, evenly spaced, and the charts alone."""

    n_charts: int
    n_samples: int
    repetitions: int
    measures: dict[str, dict[str, Summary]]


class Provenance(TypedDict):
    """What made a study, of which tables (checksums), with which packages."""

    command: str
    data: dict[str, str]
    versions: dict[str, str]


class Study(TypedDict):
    """All methods in one workspace, at many sample sizes, on many training sets."""

    workspace: str  # "free" or "obstacles"
    profile: str  # "quick" or "full"
    seed: int
    n_charts: int
    provenance: Provenance
    cells: list[Cell]
    sweep: list[SweepCell]


def measure_errors(experiment: Experiment) -> Errors:
    """Measure an experiment in every way: a row a test task, a column a method."""
    return {key: measure.errors(experiment) for key, measure in MEASURES.items()}


def summarise_trials(
    trials: Sequence[Errors],
    weights: pd.Series | None = None,
) -> dict[str, Any]:
    """Summarise experiments that differ by their training sets alone.

    Test tasks count by the weights, indexed as the errors are. Standard deviation,
    median and 95th percentile are those of all errors, whichever the training set. Few
    test tasks tell nothing of others, hence no ratio of fewer than ten.
    """
    measures: dict[str, Any] = {}
    ratios: list[dict[str, Any]] = []
    for label, first in trials[0].items():
        if first.empty:
            continue
        counted = None if weights is None else weights.loc[first.index].to_numpy()
        spread = MEASURES[label].is_spread
        measures[label], averages = {}, {}
        for method in map(str, first):
            errors = np.array([trial[label][method] for trial in trials])
            found = Average(errors, counted, spread=spread)
            averages[method], per_set = found, found.per_set
            values = per_set if spread else errors.astype(float)
            measures[label][method] = {
                **found.estimate.stored("mean"),
                **_describe(values, None if spread else counted),
                "n_tasks": len(first),
                "per_repetition": [six_digits(value) for value in per_set],
            }
        if MEASURES[label].has_ratio and len(first) >= FEW:
            ratios += _divide(label, averages)
    return {"measures": measures, "ratios": ratios}


def find_cell(study: Mapping[str, Any], design: str, n_samples: int) -> dict[str, Any]:
    """Find a study's results for a design and a number of training tasks.

    Parameters
    ----------
    study : mapping
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


def most_picked(measured: Mapping[str, Any], name: str) -> tuple[int, float]:
    """Tell which number of charts a criterion picked most often.

    Parameters
    ----------
    measured : dict
        What `measure_elbows` returned.
    name : str
        A name of `SELECTION_CRITERIA`.

    Returns
    -------
    charts : int
        The number, the last one considered excepted; 0 if there is no other.
    share : float
        On what share of the parts it was picked; never NaN, there is a part at least.

    Examples
    --------
    >>> found = {"curve": [3, 2, 1], "resampled": {"2": 2, "3": 4}}
    >>> most_picked({"readings": {"eigengap": found}}, "eigengap")
    (2, 0.3333333333333333)
    """
    found = measured["readings"][name]  # by criterion
    times = {int(count): number for count, number in found["resampled"].items()}
    inside = {k: v for k, v in times.items() if k < len(found["curve"])} or {0: 0}
    best = max(inside, key=lambda count: inside[count])
    return best, inside[best] / sum(times.values())


def format_study(found: Mapping[str, Any]) -> str:
    """Write a study as JSON, a summary or a ratio a line.

    Parameters
    ----------
    found : mapping
        The study.

    Returns
    -------
    str
        The text.

    Examples
    --------
    >>> print(format_study({"seed": 0, "cells": [{"mean": 1.5, "per": [1, 2]}]}))
    {
      "seed": 0,
      "cells": [
        {"mean": 1.5, "per": [1, 2]}
      ]
    }
    <BLANKLINE>
    """
    text = json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False)
    for innermost in (r"\[[^][{}]*\]", r"\{[^{}]*\}"):
        text = re.sub(innermost, _join_lines, text)
    return text + "\n"


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


def _divide(label: str, averages: dict[str, Average]) -> list[dict[str, Any]]:
    """Divide the charts' mean by that of each other method, where both are positive."""
    pairs = [("charts", other) for other in averages if other != "charts"]
    return [
        {"measure": label, "method": ours, "baseline": theirs}
        | averages[ours].over(averages[theirs]).stored("ratio")
        for ours, theirs in [*pairs, SAME_KERNEL]
        if {ours, theirs} <= averages.keys()
        if min(averages[ours].value, averages[theirs].value) > 0
    ]


def _join_lines(found: re.Match[str]) -> str:
    """Put brackets, and all that is between them, on one line."""
    line = " ".join(found[0].split())
    return f"{line[0]}{line[1:-1].strip()}{line[-1]}"
