"""Which number of which result file: addresses as data, and what stands there.

A measurement is a mapping with one *quantity* among its keys and, beside it, what the
quantity needs. A list in place of one value asks for several numbers::

    {"ratio": "mse, gate learned", "file": "data/results/study_free.json",
     "design": "even", "n_samples": [24, 360], "baseline": "CrKr"}

A quotient or a difference is made of two measurements, which take from the outer one
what they do not say themselves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import isnan
from typing import Any

from msc.claims._lookups import FIELDS, QUANTITIES
from msc.estimates import Estimate, average, difference, quotient

SIDES = {"quotient": ("top", "bottom"), "difference": ("plus", "minus")}


@dataclass(frozen=True)
class Measurement:
    """Where a number stands, or how it is made of two others.

    Attributes
    ----------
    quantity : str
        A key of `QUANTITIES` or of `SIDES`.
    fields : dict
        What the quantity needs; its own value is under its name.
    parts : tuple of Measurement
        The two sides of a quotient or a difference.
    average : bool
        Whether several numbers are averaged into one.
    """

    quantity: str
    fields: dict[str, Any]
    parts: tuple[Measurement, ...] = ()
    average: bool = False

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
    """Read a measurement.

    Parameters
    ----------
    given : mapping
        One quantity and what it needs.
    shared : mapping
        Fields that count where `given` does not have them.

    Returns
    -------
    Measurement
        Complete, without the fields that its quantity does not need.

    Raises
    ------
    ValueError
        If the quantity is unknown, or a field missing or unknown; the message begins
        with the field.

    Examples
    --------
    >>> given = {"jumps": "besides the cut"}
    >>> parse(given, {"file": "data/results/audit_free.json"}).files
    {'data/results/audit_free.json'}
    """
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
    """Look numbers up and combine them.

    Parameters
    ----------
    measurement : Measurement
        Which.
    results : mapping
        Contents of the result files, by name.

    Returns
    -------
    list of Estimate
        One, or as many as lists ask for; NaN where no test task counts, as away from
        jumps if training tasks lie far apart.

    Raises
    ------
    ValueError
        If a number is not there; the message says what was looked for, and where.
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


_WORDS = {"n_samples": "n = {}", "n_charts": "charts: {}", "baseline": "against {}"}
