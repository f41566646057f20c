"""The paper's claims as data: a YAML file, read and checked, and the numbers it names.

A claim has one or several interpretations, of which the literal ones decide: the first,
or those that `literal` names. Each says what is measured and, by one predicate, where
that must lie for the claim to hold. A measurement is a mapping with
one *quantity* among its keys and, beside it, what the quantity needs. A list in place
of one value asks for several numbers::

    {"ratio": "mse, gate learned", "file": "data/results/study_free.json",
     "design": "even", "n_samples": [24, 360], "baseline": "CrKr"}

A quotient or a difference is made of two measurements, which take from the outer one
what they do not say themselves.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from math import isnan, nan
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from msc.estimates import Average, Estimate, average, difference, quotient
from msc.study import count_ahead, find_cell

PREDICATES = ("below", "above", "equals", "at_least")
N_WORDS = 40  # that a quotation may have

_TEXTS = ["id", "claim", "quote", "section", "chapter", "margin", "why", "hardly_fails"]
_NEEDED = (*_TEXTS[:5], "interpretations")
_KINDS = {
    **dict.fromkeys(_TEXTS, str),
    **dict.fromkeys(("interpretations", "measured", "support"), dict),
    "literal": list,
}
_WANTED = {str: "a text", dict: "a mapping", list: "a list"}
_BESIDE = {"unit", "by_construction", "cannot_be_tested", *PREDICATES}
_ID = re.compile(r"[A-Za-z0-9-]+")  # it is an anchor, and names a row
_REFERENCE = re.compile(r"\{[^{}]*\}|(?:Figures?|Eqs?\.|Section) \d+")
_WORDS = {"n_samples": "n = {}", "n_charts": "charts: {}", "baseline": "against {}"}


# What is measured


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
    found = Estimate.read(ratios[wanted], "ratio")
    n_ahead, n_sets = count_ahead(cell, name, method, baseline)
    note = f"lower on {n_ahead} of {n_sets} training sets" if n_sets > 1 else ""
    return replace(found, note=note)


def _mean(
    study: dict[str, Any], name: str, design: str, n_samples: int, method: str
) -> Estimate:
    """Find a method's mean."""
    cell = find_cell(study, design, n_samples)
    if _is_empty(study, cell, name):
        return Estimate(nan)
    return _of_summary(cell["measures"][name][method])


def _of_summary(summary: dict[str, Any]) -> Estimate:
    """Take a mean, with what it takes to divide it by another."""
    if summary["mean"] is None:
        raise KeyError("a fit failed")
    return replace(Estimate.read(summary, "mean"), of=Average.read(summary))


def _sweep(study: dict[str, Any], name: str, n_samples: int, n_charts: int) -> Estimate:
    """Find the mean of so many charts."""
    found = next(
        entry["measures"][name]["charts"]
        for entry in study["sweep"]
        if (entry["n_samples"], entry["n_charts"]) == (n_samples, n_charts)
    )
    return _of_summary(found)


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
        times = costs["searches"][world]["ways"]["alone"]["seconds"]
        return Estimate(sum(times) / len(times), min(times), max(times))
    times = {"prediction": costs["skill"][world]["predict_one_microseconds"]}[what]
    return Estimate(*(times[key] / 1e6 for key in ("median", "low", "high")))


def _same_kernel(
    study: dict[str, Any], name: str, design: str, n_samples: int, kernel: str
) -> Estimate:
    """Find the charts' error over the single regression's, both with another kernel."""
    methods = {"method": f"charts, {kernel}", "baseline": f"single, {kernel}"}
    return _ratio(study, name, design, n_samples, **methods)


QUANTITIES: dict[str, tuple[Callable[..., Estimate], tuple[str, ...]]] = {
    "ratio": (_ratio, ("file", "design", "n_samples", "baseline")),
    "ratio_same_kernel": (_same_kernel, ("file", "design", "n_samples", "kernel")),
    "mean": (_mean, ("file", "design", "n_samples", "method")),
    "sweep": (_sweep, ("file", "n_samples", "n_charts")),
    "jumps": (_jumps, ("file",)),
    "picked": (_picked, ("file",)),
    "picked_share": (_picked_share, ("file", "count")),
    "column_mean": (_column_mean, ("file",)),
    "seconds": (_seconds, ("file", "world")),
}
FIELDS = sorted({name for _, needs in QUANTITIES.values() for name in needs})
PARTS = {"quotient": ("top", "bottom"), "difference": ("plus", "minus")}


@dataclass(frozen=True)
class Measurement:
    """Where a number stands, or how it is made of two others."""

    quantity: str  # a key of QUANTITIES or of PARTS
    fields: dict[str, Any]  # what it needs; its own value is under its name
    parts: tuple[Measurement, ...] = ()  # the sides of a quotient or a difference
    average: bool = False  # several numbers into one

    @property
    def files(self) -> set[str]:
        """The result files that it needs."""
        own = {self.fields["file"]} if self.fields else set()
        return own.union(*(part.files for part in self.parts))

    @property
    def training_sets(self) -> tuple[Any, Any]:
        """What tells which training sets it is of: how they are drawn, and how large.

        A sweep over numbers of charts, which names no design, has evenly spaced ones.
        """
        return self.fields.get("design", "even"), self.fields.get("n_samples")

    @property
    def unit(self) -> str:
        """What the number is a multiple of, if that is another method's."""
        baseline = self.fields.get("baseline")
        return f"× {baseline}" if isinstance(baseline, str) else ""


def parse(given: Any, shared: Mapping[str, Any]) -> Measurement:
    """Read a measurement; fields of `shared` count where `given` lacks them."""
    found = [key for key in given if key in QUANTITIES or key in PARTS]
    if len(found) != 1:
        wanted = ", ".join([*QUANTITIES, *PARTS])
        raise ValueError(f"quantity: got {found}; wanted one of {wanted}")
    [quantity] = found
    if unknown := set(given) - {quantity, "average", *FIELDS}:
        raise ValueError(f"{min(unknown)}: unknown; wanted one of {', '.join(FIELDS)}")
    averaged = bool(given.get("average", False))
    known = {**shared, **{key: given[key] for key in given if key in FIELDS}}
    if quantity in PARTS:
        sides = given[quantity]
        if not isinstance(sides, Mapping) or set(sides) != set(PARTS[quantity]):
            raise ValueError(f"{quantity}: wanted two measurements, {PARTS[quantity]}")
        parts = tuple(parse(sides[side], known) for side in PARTS[quantity])
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
    if quantity in PARTS:
        first, second = (measure(part, results) for part in measurement.parts)
        combine = quotient if quantity == "quotient" else difference
        if quantity == "quotient" and len(measurement.files) == 1:
            # Errors on the same test tasks rise and fall together.
            top, bottom = (part.training_sets for part in measurement.parts)
            combine = partial(_divide, same_sets=top == bottom)
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


def _divide(top: Estimate, bottom: Estimate, *, same_sets: bool) -> Estimate:
    """Divide two means of errors on the same test tasks, or other numbers."""
    if top.of is None or bottom.of is None:
        return quotient(top, bottom)
    found = top.of.over(bottom.of, same_sets=same_sets)
    return replace(found, label=top.label)


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


# The file


@dataclass(frozen=True)
class Interpretation:
    """One way to understand a claim."""

    name: str
    measurement: Measurement | None = None  # None if nothing can be measured
    predicate: str = "below"
    threshold: float = 1.0
    unit: str = ""  # what follows the number in a sentence
    by_construction: str = ""  # what in our design makes the predicate hold
    cannot_be_tested: str = ""  # why not


@dataclass(frozen=True)
class Claim:
    """One sentence of the paper, and how it is tested."""

    id: str
    claim: str  # in our words
    quote: str  # in the paper's
    section: str
    chapter: str  # page of the book that shows it
    interpretations: tuple[Interpretation, ...]
    literal: tuple[str, ...]  # which of them together are what the paper says
    margin: str = ""  # why the thresholds are what they are
    hardly_fails: str = ""  # why it could hardly come out another way
    support: dict[str, Measurement] = field(default_factory=dict)  # what `why` quotes
    why: str = ""  # our verdict differs; {name} is what that measured

    @property
    def could_fail(self) -> bool:
        """Whether it counts where verdicts are counted."""
        return not self.hardly_fails

    @property
    def files(self) -> set[str]:
        """The result files that it needs."""
        measured = [one.measurement for one in self.interpretations if one.measurement]
        return set().union(*(one.files for one in (*measured, *self.support.values())))


def load_claims(path: str | Path) -> list[Claim]:
    """Read the claims.

    Parameters
    ----------
    path : str or Path
        A YAML file: a list of claims.

    Returns
    -------
    list of Claim
        In the order of the file.

    Raises
    ------
    ValueError
        If a claim is not as wanted; the message names the claim and the field.
    """
    path = Path(path)
    try:
        given = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ValueError(f"{path.name} is not YAML: {error}") from None
    if not isinstance(given, list) or not all(isinstance(one, dict) for one in given):
        raise ValueError(f"{path.name}: wanted a list of claims")
    claims: list[Claim] = []
    for number, one in enumerate(given, start=1):
        name = one.get("id", f"number {number}")
        try:
            if name in {claim.id for claim in claims}:
                raise ValueError("id: used twice")
            claims.append(_claim(one))
        except ValueError as error:
            raise ValueError(f"{path.name}, claim {name!r}, {error}") from None
    return claims


def _claim(given: dict[str, Any]) -> Claim:
    """Check the fields of a claim."""
    if missing := [name for name in _NEEDED if not given.get(name)]:
        raise ValueError(f"{missing[0]}: missing")
    if unknown := set(given) - set(_KINDS):
        raise ValueError(f"{min(unknown)}: unknown")
    for name, value in given.items():
        if not isinstance(value, _KINDS[name]):
            raise ValueError(f"{name}: {value!r}; wanted {_WANTED[_KINDS[name]]}")
    if not _ID.fullmatch(given["id"]):
        raise ValueError(f"id: {given['id']!r}; wanted letters, digits and hyphens")
    if (n_words := len(given["quote"].split())) > N_WORDS:
        raise ValueError(f"quote: {n_words} words; wanted at most {N_WORDS}")
    shared = given.get("measured", {})
    if unknown := set(shared) - set(FIELDS):
        raise ValueError(f"measured: {min(unknown)!r} unknown; wanted one of {FIELDS}")
    interpretations = [
        _interpretation(name, one, shared)
        for name, one in given["interpretations"].items()
    ]
    support = {
        name: _measurement("support", name, one, shared)
        for name, one in given.get("support", {}).items()
    }
    names = [one.name for one in interpretations]
    literal = given.get("literal", names[:1])
    if not literal or any(one not in names for one in literal):
        raise ValueError(f"literal: {literal!r}; wanted some of {names}")
    texts = {name: given[name].strip() for name in _TEXTS if name in given}
    claim = Claim(
        **texts,
        interpretations=tuple(interpretations),
        literal=tuple(literal),
        support=support,
    )
    _check_prose(claim)
    return claim


def _interpretation(name: str, given: Any, shared: Mapping[str, Any]) -> Interpretation:
    """Check an interpretation: a reason why not, or a measurement and one predicate."""
    where = f"interpretations: {name!r}"
    if not isinstance(given, dict):
        raise ValueError(f"{where}: wanted a mapping")
    reason = given.get("cannot_be_tested", "")
    if reason:
        if len(given) > 1:
            raise ValueError(f"{where}: cannot_be_tested stands alone")
        return Interpretation(name, cannot_be_tested=reason)
    named = [one for one in PREDICATES if one in given]
    if len(named) != 1:
        raise ValueError(f"{where}: predicates {named}; wanted one of {PREDICATES}")
    threshold = given[named[0]]
    if isinstance(threshold, bool) or not isinstance(threshold, int | float):
        raise ValueError(f"{where}: {named[0]}: {threshold!r}; wanted a number")
    what = {key: value for key, value in given.items() if key not in _BESIDE}
    measurement = _measurement("interpretations", name, what, shared)
    return Interpretation(
        name,
        measurement,
        named[0],
        threshold,
        given.get("unit", measurement.unit),
        given.get("by_construction", "").strip(),
    )


def _measurement(
    group: str, name: str, given: Any, shared: Mapping[str, Any]
) -> Measurement:
    if re.search(r"[][.!:{}]", name):
        raise ValueError(f"{group}: {name!r}; wanted a name without . ! : [ ] {{ }}")
    try:
        return parse(given, shared)
    except ValueError as error:
        raise ValueError(f"{group}: {name!r}: {error}") from None


def _check_prose(claim: Claim) -> None:
    """Refuse a margin without a reason, and typed or unknown numbers in `why`."""
    plain = {("below", 1), ("above", 1), ("below", 0), ("above", 0)}
    chosen = any(
        one.measurement and (one.predicate, one.threshold) not in plain
        for one in claim.interpretations
    )
    if chosen and not claim.margin:
        raise ValueError("margin: missing; say why the thresholds are what they are")
    if re.search(r"\d", _REFERENCE.sub("", claim.why)):
        raise ValueError("why: has a typed number; quote a measurement, as {name}")
    known = {one.name for one in claim.interpretations if one.measurement} | set(
        claim.support
    )
    quoted = set(re.findall(r"\{([^{}]*)\}", claim.why))
    if unknown := quoted - known:
        wanted = ", ".join(sorted(known))
        raise ValueError(f"why: {{{min(unknown)}}} unknown; wanted one of {wanted}")
