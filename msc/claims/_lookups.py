"""Where each kind of number stands in a result file."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from typing import Any

import pandas as pd

from msc.estimates import Estimate
from msc.study import find_cell


def _is_empty(study: dict[str, Any], cell: dict[str, Any], name: str) -> bool:
    """Whether no test task counts here for a measure that other cells have."""
    others = (name in other["measures"] for other in study["cells"])
    return name not in cell["measures"] and any(others)


def _ratio(
    study: dict[str, Any],
    name: str,
    design: str,
    n_samples: int,
    baseline: str,
    *,
    method: str = "charts",
) -> Estimate:
    """Find the charts' error over another method's, a paired comparison."""
    cell = find_cell(study, design, n_samples)
    if _is_empty(study, cell, name):
        return Estimate(nan)
    wanted = name, method, baseline
    ratios = {(r["measure"], r["method"], r["baseline"]): r for r in cell["ratios"]}
    if wanted not in ratios and baseline in cell["measures"][name]:  # few test tasks
        return Estimate(nan)
    found = ratios[wanted]
    return Estimate.read(found, "ratio")


def _same_kernel(
    study: dict[str, Any], name: str, design: str, n_samples: int
) -> Estimate:
    """Find the charts' error over one regression's, both with a Matérn kernel."""
    ours, theirs = "charts, Matérn", "single, Matérn"
    return _ratio(study, name, design, n_samples, theirs, method=ours)


def _mean(
    study: dict[str, Any], name: str, design: str, n_samples: int, method: str
) -> Estimate:
    """Find a method's mean."""
    cell = find_cell(study, design, n_samples)
    if _is_empty(study, cell, name):
        return Estimate(nan)
    found = cell["measures"][name][method]
    return Estimate.read(found, "mean")


def _sweep(study: dict[str, Any], name: str, n_samples: int, n_charts: int) -> Estimate:
    """Find the mean of so many charts."""
    found = next(
        entry["measures"][name]["charts"]
        for entry in study["sweep"]
        if (entry["n_samples"], entry["n_charts"]) == (n_samples, n_charts)
    )
    return Estimate.read(found, "mean")


def _jumps(audit: dict[str, Any], where: str) -> Estimate:
    """Count confirmed jumps, "besides the cut" or "on the circle"."""
    closed = {"besides the cut": False, "on the circle": True}[where]
    confirmed = [jump for jump in audit["jumps"] if jump["is_jump"]]
    return Estimate(sum(closed or jump["between_deg"][1] < 360 for jump in confirmed))


def _picked(elbow: dict[str, Any], curve: str) -> Estimate:
    """Find how many charts the elbow of a curve picks on all tasks."""
    return Estimate(elbow["readings"][curve]["picked"])


def _picked_share(elbow: dict[str, Any], curve: str, count: int) -> Estimate:
    """Find how often it picks so many on parts of them, with Wilson's interval."""
    from scipy.stats import binomtest  # noqa: PLC0415 (takes a second to load)

    picks = elbow["readings"][curve]["resampled"]
    found = binomtest(picks.get(str(count), 0), sum(picks.values()))
    interval = found.proportion_ci(method="wilson")
    return Estimate(found.statistic, float(interval.low), float(interval.high))


def _column_mean(table: pd.DataFrame, column: str) -> Estimate:
    """Average a column of a table of searched policies."""
    return Estimate(float(table[column].mean()))


def _seconds(costs: dict[str, Any], what: str, world: str) -> Estimate:
    """Find what a "search" or a "prediction" takes, with the range that was timed."""
    if what == "search":
        times = costs["searches"][world]["seconds"]
        return Estimate(sum(times) / len(times), min(times), max(times))
    times = {"prediction": costs["skill"][world]["predict_one_microseconds"]}[what]
    return Estimate(*(times[key] / 1e6 for key in ("median", "low", "high")))


QUANTITIES: dict[str, tuple[Callable[..., Estimate], tuple[str, ...]]] = {
    "ratio": (_ratio, ("file", "design", "n_samples", "baseline")),
    "ratio_same_kernel": (_same_kernel, ("file", "design", "n_samples")),
    "mean": (_mean, ("file", "design", "n_samples", "method")),
    "sweep": (_sweep, ("file", "n_samples", "n_charts")),
    "jumps": (_jumps, ("file",)),
    "picked": (_picked, ("file",)),
    "picked_share": (_picked_share, ("file", "count")),
    "column_mean": (_column_mean, ("file",)),
    "seconds": (_seconds, ("file", "world")),
}
FIELDS = sorted({name for _, needs in QUANTITIES.values() for name in needs})
