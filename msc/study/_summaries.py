"""From the errors of many trials to a study: summaries and ratios, with intervals.

A study of one workspace is a dictionary, written to `data/results/study_<world>.json`
and laid out as `Study` says. Claims, tables and figures read it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.estimates import Average, six_digits

SAME_KERNEL = (  # compared besides "charts" with all others
    ("charts, Matérn", "single, Matérn"),
    ("charts, one kernel", "single, one kernel"),
    ("charts, Matérn, one kernel", "single, Matérn, one kernel"),
)
FEW = 10  # test tasks; fewer say too little of others

Array = NDArray[np.float64]


class Measure(NamedTuple):
    """What is measured of every method."""

    key: str  # in a study
    name: str  # where it is shown
    raw: (
        str  # what of `Experiment.measure` it is taken from; "mse" if that is not there
    )
    unit: str = ""  # policy weights have none
    side: str = ""  # test tasks "away" from jumps or "beside" them; all, if empty
    has_ratio: bool = True  # no share has: it is often zero
    is_near: bool = False  # whether it is below one
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


def _mse(subset: str, raw: str = "mse", side: str = "") -> Measure:
    """Return the measure of squared errors of policies on a test subset."""
    word = "standardised " if "standardised" in raw else ""
    key, name = f"{word}mse, {subset}", f"{word}MSE, {subset}"
    return Measure(key, name, raw, side=side, of=f"{word}policies, {subset}")


MEASURES = {
    measure.key: measure
    for measure in (
        _mse("gate learned"),
        _mse("chart known", "mse, chart known"),
        _mse("away from jumps", side="away"),
        _mse("beside jumps", side="beside"),
        _mse("gate learned", "standardised mse"),
        Measure("error_cm", "distance at the end", "error_cm", "cm"),
        Measure("excess_cost", "excess cost", "excess_cost"),
        Measure("under_1_cm", "under_1_cm", "error_cm", has_ratio=False, is_near=True),
        Measure("touched", "touched", "touched", has_ratio=False),
        Measure(
            "error_cm spread",
            "spread of distances at the end",
            "error_cm",
            "cm",
            is_spread=True,
        ),
    )
}


class Summary(TypedDict):
    """A method's errors: over test tasks and training sets, and one mean a set.

    Of a measure that is a spread, the latter three are those over the training sets.
    All are None, if it could not be fitted to one of the sets.
    """

    mean: float | None
    low: float | None  # with `high`: a 95 % interval, see `msc.estimates.Average`
    high: float | None
    std: float | None
    median: float | None
    p95: float | None
    n_tasks: int
    per_repetition: list[float]
    waves: list[float]  # real and imaginary parts, see `msc.estimates.Average`


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
    failed: dict[str, dict[str, str]]  # by method, by "design/n_samples/set": why
    rollouts: dict[str, float]  # of its own, by method: their mean over training sets
    cells: list[Cell]
    sweep: list[SweepCell]


def summarise_cell(
    found: Mapping[str, Mapping[str, NDArray[Any]]],
    away: NDArray[np.bool_],
    weights: Array,
) -> dict[str, Any]:
    """Summarise what methods did on the training sets of a design and size.

    Parameters
    ----------
    found : mapping
        By method, and by raw measure, an array with a row a training set and a column a
        test task. A method may have fewer sets than another, the first ones.
    away : ndarray of shape (n_test_tasks,)
        Which test tasks are away from jumps.
    weights : ndarray of shape (n_test_tasks,)
        How much each counts.

    Returns
    -------
    dict
        "measures" and "ratios" of a `Cell`. What could not be fitted has no mean.
    """
    measures: dict[str, dict[str, Any]] = {}
    ratios: list[dict[str, Any]] = []
    for key, measure in MEASURES.items():
        sides = {"": np.ones_like(away), "away": away, "beside": ~away}
        counted = weights * sides[measure.side]
        if not counted.any():
            continue
        values = {
            name: _take(raw, measure)
            for name, raw in found.items()
            if measure.raw in raw or "mse" in raw  # a planner has no errors of policies
        }
        measures[key] = {
            name: _summarise(errors, counted, measure)
            for name, errors in values.items()
        }
        if measure.has_ratio and np.count_nonzero(counted) >= FEW:
            ratios += _divide(values, counted, measure)
    return {"measures": measures, "ratios": ratios}


def _take(raw: Mapping[str, NDArray[Any]], measure: Measure) -> NDArray[Any]:
    """Return a method's errors by a measure."""
    errors = raw[measure.raw if measure.raw in raw else "mse"]
    if np.isnan(errors).any():  # what a failed fit did is unknown, not far
        return errors
    return errors < 1 if measure.is_near else errors


def _summarise(errors: NDArray[Any], weights: Array, measure: Measure) -> Any:
    """Summarise a method's errors on all of its training sets."""
    if np.isnan(errors).any():  # of a fit that failed: no mean tells of the others
        names = "mean", "low", "high", "std", "median", "p95"
        lists: dict[str, Any] = {"per_repetition": [], "waves": []}
        return {**dict.fromkeys(names), "n_tasks": 0, **lists}
    found = Average(errors, weights, spread=measure.is_spread)
    counts = weights > 0
    values, counted = found.per_set, None
    if not measure.is_spread:
        values, counted = errors[:, counts].astype(float), weights[counts]
    return {**found.stored(), **_describe(values, counted)}


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


def count_ahead(
    cell: Mapping[str, Any], measure: str, method: str, baseline: str
) -> tuple[int, int]:
    """Count the training sets on which a method errs less than another.

    This tells of the tasks of this one circle, whatever training set is drawn; an
    interval of the ratio tells of others.

    Parameters
    ----------
    cell : mapping
        An entry of a study's "cells".
    measure : str
        A key of `MEASURES`.
    method, baseline : str
        The two.

    Returns
    -------
    n_ahead, n_sets : int
        Of how many that both were fitted to.

    Examples
    --------
    >>> means = {"a": {"per_repetition": [1, 2, 3]}, "b": {"per_repetition": [2, 1]}}
    >>> count_ahead({"measures": {"error_cm": means}}, "error_cm", "a", "b")
    (1, 2)
    """
    means = cell["measures"][measure]
    ours, theirs = (means[name]["per_repetition"] for name in (method, baseline))
    pairs = [*zip(ours, theirs, strict=False)]
    return sum(one < other for one, other in pairs), len(pairs)


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


def _divide(
    values: Mapping[str, NDArray[Any]], weights: Array, measure: Measure
) -> list[dict[str, Any]]:
    """Divide means of pairs by each other, on the training sets that both have."""
    ratios = []
    others = [("charts", other) for other in values if other != "charts"]
    for pair in [*others, *SAME_KERNEL]:
        if not set(pair) <= values.keys():
            continue
        n_sets = min(len(values[name]) for name in pair)
        both = [values[name][:n_sets] for name in pair]
        if any(np.isnan(errors).any() for errors in both):
            continue
        top, bottom = (Average(e, weights, spread=measure.is_spread) for e in both)
        if min(top.value, bottom.value) > 0:
            of = {"measure": measure.key, "method": pair[0], "baseline": pair[1]}
            ratios.append(of | top.over(bottom).stored("ratio"))
    return ratios


def _join_lines(found: re.Match[str]) -> str:
    """Put brackets, and all that is between them, on one line."""
    line = " ".join(found[0].split())
    return f"{line[0]}{line[1:-1].strip()}{line[-1]}"
