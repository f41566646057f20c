"""Which number of which result file: addresses as data, and what stands there.

A measurement is a mapping with one *quantity* among its keys and, beside it, what the
quantity needs. A list in place of one value asks for several numbers::

    {"ratio": "mse, gate learned", "file": "data/results/study_free.json",
     "design": "even", "n_samples": [24, 360], "baseline": "CrKr"}

A quotient or a difference is made of two measurements, which take from the outer one
what they do not say themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import isnan, nan
from typing import Any

import pandas as pd

from msc.estimates import Estimate, average, difference, quotient
from msc.study import find_cell

_WORDS = {"n_samples": "n = {}", "n_charts": "charts: {}", "baseline": "against {}"}


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
SIDES = {"quotient": ("top", "bottom"), "difference": ("plus", "minus")}


@dataclass(frozen=True)
class Measurement:
    """Where a number stands, or how it is made of two others."""

    quantity: str  # a key of QUANTITIES or of SIDES
    fields: dict[str, Any]  # what it needs; its own value is under its name
    parts: tuple[Measurement, ...] = ()  # the sides of a quotient or a difference
    average: bool = False  # several numbers into one

    @property
    def files(self) -> set[str]:
        """The result files that it needs."""
        own = {self.fields["file"]} if self.fields else set()
        return own.union(*(part.files for part in self.parts))

    @property
    def unit(self) -> str:
        """What the number is a multiple of, if that is another method's."""
        baseline = self.fields.get("baseline")
        return f"× {baseline}" if isinstance(baseline, str) else ""


def parse(given: Any, shared: Mapping[str, Any]) -> Measurement:
    """Read a measurement; fields of `shared` count where `given` lacks them."""
    found = [key for key in given if key in QUANTITIES or key in SIDES]
    if len(found) != 1:
        wanted = ", ".join([*QUANTITIES, *SIDES])
        raise ValueError(f"quantity: got {found}; wanted one of {wanted}")
    [quantity] = found
    if unknown := set(given) - {quantity, "average", *FIELDS}:
        raise ValueError(f"{min(unknown)}: unknown; wanted one of {', '.join(FIELDS)}")
    averaged = bool(given.get("average", False))
    known = {**shared, **{key: given[key] for key in given if key in FIELDS}}
    if quantity in SIDES:
        sides = given[quantity]
        if not isinstance(sides, Mapping) or set(sides) != set(SIDES[quantity]):
            raise ValueError(f"{quantity}: wanted two measurements, {SIDES[quantity]}")
        parts = tuple(parse(sides[side], known) for side in SIDES[quantity])
        return Measurement(quantity, {}, parts, averaged)
    if missing := [name for name in QUANTITIES[quantity][1] if name not in known]:
        raise ValueError(f"{missing[0]}: missing, but {quantity} needs it")
    needed = {name: known[name] for name in QUANTITIES[quantity][1]}
    return Measurement(quantity, {quantity: given[quantity], **needed}, (), averaged)


def measure(measurement: Measurement, results: Mapping[str, Any]) -> list[Estimate]:
    """Look numbers up and combine them: one, or as many as lists ask for.

    NaN where no test task counts, as away from jumps if training tasks lie far apart.
    """
    quantity = measurement.quantity
    if quantity in SIDES:
        first, second = (measure(part, results) for part in measurement.parts)
        combine = quotient if quantity == "quotient" else difference
        if len(second) == 1:
            second = second * len(first)
        if len(first) != len(second):
            raise ValueError(f"{quantity}: {len(first)} numbers and {len(second)}")
        estimates = [combine(*pair) for pair in zip(first, second, strict=True)]
    else:
        estimates = _look_up(measurement, results)
    if not measurement.average:
        return estimates
    known = [estimate for estimate in estimates if not isnan(estimate.value)]
    return [average(known, geometric=quantity in ("ratio", "quotient"))]


def _look_up(measurement: Measurement, results: Mapping[str, Any]) -> list[Estimate]:
    """Find the numbers of a measurement that is not made of others."""
    fields = dict(measurement.fields)
    file = fields.pop("file")
    content = results[file]
    function = QUANTITIES[measurement.quantity][0]
    if fields.get("n_samples") == "all":
        cells = [c for c in content["cells"] if c["design"] == fields["design"]]
        fields["n_samples"] = [cell["n_samples"] for cell in cells]
    lists = [value if isinstance(value, list) else [value] for value in fields.values()]
    estimates = []
    for values in product(*lists):
        one = dict(zip(fields, values, strict=True))
        try:
            found = function(content, *values)
        except (KeyError, IndexError, StopIteration, TypeError):
            asked = ", ".join(f"{name}: {value}" for name, value in one.items())
            raise ValueError(f"{file} has no {asked}") from None
        listed = (name for name in fields if isinstance(fields[name], list))
        label = ", ".join(_WORDS.get(name, "{}").format(one[name]) for name in listed)
        estimates.append(replace(found, label=label))
    return estimates
