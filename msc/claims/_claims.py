"""The paper's claims as data: a YAML file, read and checked before anything is judged.

A claim has one or several interpretations. Each says what is measured (see
`Measurement`) and, by one predicate, where that must lie for the claim to hold.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from msc.claims._measures import FIELDS, Measurement, parse

PREDICATES = ("below", "above", "equals", "at_least")
N_WORDS = 40  # that a quotation may have

_NEEDED = ("id", "claim", "quote", "section", "chapter", "interpretations")
_TEXTS = ("id", "claim", "quote", "section", "chapter", "margin", "why")
_MAPPINGS = ("interpretations", "measured", "support")
_BESIDE = {"unit", "by_construction", "cannot_be_tested", *PREDICATES}
_ID = re.compile(r"[A-Za-z0-9-]+")  # it is an anchor, and names a row
_REFERENCE = re.compile(r"\{[^{}]*\}|(?:Figures?|Eqs?\.|Section) \d+")


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
    interpretations: tuple[Interpretation, ...]  # the paper's own first
    margin: str = ""  # why the thresholds are what they are
    support: dict[str, Measurement] = field(default_factory=dict)  # what `why` quotes
    why: str = ""  # our verdict differs; {name} is what that measured

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
    if unknown := set(given) - {*_TEXTS, *_MAPPINGS}:
        raise ValueError(f"{min(unknown)}: unknown")
    for name, value in given.items():
        if not isinstance(value, dict if name in _MAPPINGS else str):
            wanted = "a mapping" if name in _MAPPINGS else "text"
            raise ValueError(f"{name}: {value!r}; wanted {wanted}")
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
    texts = {name: given[name].strip() for name in _TEXTS if name in given}
    claim = Claim(**texts, interpretations=tuple(interpretations), support=support)
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
