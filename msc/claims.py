"""Verdicts on the paper's claims: what was measured, held against margins fixed before.

Every verdict is computed. An interval decides: the whole of it must lie where the claim
wants it, or the whole of it where the claim does not.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any

import pandas as pd

from msc.claim_file import Claim, Reading, load_claims
from msc.effects import Effect, widened
from msc.measured import measure
from msc.tables import checksum

REPRODUCED = "reproduced"
PARTLY = "partly"
NOT = "not reproduced"
UNDECIDED = "undecided"
BUILT_IN = "by construction"
UNTESTABLE = "cannot be tested"
SYMBOLS = {
    REPRODUCED: "●",
    PARTLY: "◐",
    NOT: "○",
    UNDECIDED: "?",
    BUILT_IN: "◇",
    UNTESTABLE: "–",
}
DIFFERING = (PARTLY, NOT, UNDECIDED)  # from what the paper says

# What is made of a result file that is not there.
_COMMANDS = {
    "study": "msc evaluate --profile full",
    "audit": "msc audit",
    "results": "make bench",
}


@dataclass(frozen=True)
class ReadingVerdict:
    """What a reading of a claim came to.

    Attributes
    ----------
    name : str
        The reading.
    verdict : str
        A key of `SYMBOLS`.
    effect : Effect or None
        What was measured; of several numbers the one that favours the claim least.
    unit : str
        What follows it in a sentence.
    sentence : str
        All of it in words.
    """

    name: str
    verdict: str
    effect: Effect | None
    unit: str
    sentence: str

    @property
    def measured(self) -> str:
        """The number with interval and unit."""
        return "" if self.effect is None else f"{self.effect} {self.unit}".strip()


@dataclass(frozen=True)
class Verdict:
    """What a claim came to.

    Attributes
    ----------
    claim : Claim
        The claim.
    verdict : str
        A key of `SYMBOLS`.
    readings : tuple of ReadingVerdict
        What each reading came to.
    why : str
        Why that differs from the paper, its placeholders filled.
    """

    claim: Claim
    verdict: str
    readings: tuple[ReadingVerdict, ...]
    why: str = ""

    @property
    def effect(self) -> Effect | None:
        """What the first reading measured, the paper's own."""
        return self.readings[0].effect

    @property
    def sentence(self) -> str:
        """Which reading gave which verdict."""
        if len(self.readings) == 1:
            return self.readings[0].sentence
        groups: dict[str, list[str]] = {}
        for reading in self.readings:
            groups.setdefault(reading.verdict, []).append(reading.name)
        return "; ".join(f"{key}: {' / '.join(names)}" for key, names in groups.items())

    @property
    def unexplained(self) -> bool:
        """Whether it differs from the paper and no measurement is quoted to say why."""
        return self.verdict in DIFFERING and "{" not in self.claim.why


def load_results(claims: Iterable[Claim], root: Path) -> dict[str, Any]:
    """Load the result files that claims need.

    Parameters
    ----------
    claims : iterable of Claim
        The claims.
    root : Path
        The repository.

    Returns
    -------
    dict
        Contents by name: of tables a DataFrame.

    Raises
    ------
    ValueError
        If a file is missing, or was made from other tables than are there now.
    """
    results: dict[str, Any] = {}
    for claim in claims:
        for name in sorted(claim.files - set(results)):
            path = root / name
            if not path.is_file():
                command = _COMMANDS.get(path.stem.partition("_")[0], "")
                hint = f"; make it: {command}" if command else ""
                raise ValueError(f"claim {claim.id!r}: {name} is not there{hint}")
            if path.suffix == ".csv":
                results[name] = pd.read_csv(path)
            else:
                results[name] = json.loads(path.read_text(encoding="utf-8"))
                _refuse_stale(name, results[name], root / "data")
    return results


def judge(claim: Claim, results: Mapping[str, Any]) -> Verdict:
    """Hold what was measured against a claim.

    Parameters
    ----------
    claim : Claim
        The claim.
    results : mapping
        Contents of the result files, by name.

    Returns
    -------
    Verdict
        That of the readings if they agree, and "by construction" if the first, the
        paper's own, is. Otherwise "partly" if any is reproduced; else "not reproduced",
        since one refutes the claim and none confirms it.

    Raises
    ------
    ValueError
        If a number is missing; the message names the claim and the reading.

    Notes
    -----
    A reading is reproduced if its predicate holds on the whole of each interval; not
    reproduced if it fails on the whole of one, widened for as many as were looked at;
    otherwise undecided. One that the design of the experiment makes true is "by
    construction" where it would be reproduced.
    """
    readings = []
    try:
        for one in claim.readings:
            name = one.name
            readings.append(_judge_reading(one, results))
        quoted = {one.name: one.measured for one in readings}
        for name, support in claim.support.items():
            effects = measure(support, results)
            quoted[name] = ", ".join(map(str, effects))
    except ValueError as error:
        raise ValueError(f"claim {claim.id!r}, {name!r}: {error}") from None
    verdicts = [one.verdict for one in readings if one.verdict != UNTESTABLE]
    if not verdicts:
        overall = UNTESTABLE
    elif verdicts[0] == BUILT_IN or len(set(verdicts)) == 1:
        overall = verdicts[0]
    else:
        overall = PARTLY if {REPRODUCED, BUILT_IN} & set(verdicts) else NOT
    why = claim.why.format_map(quoted)
    return Verdict(claim, overall, tuple(readings), why)


def _judge_reading(reading: Reading, results: Mapping[str, Any]) -> ReadingVerdict:
    """Hold one measurement against its predicate."""
    if reading.measurement is None:
        reason = reading.cannot_be_tested
        return ReadingVerdict(reading.name, UNTESTABLE, None, "", reason)
    measured = measure(reading.measurement, results)
    effects = [effect for effect in measured if not isnan(effect.value)]
    if not effects:
        reason = "no test task is of this kind"
        return ReadingVerdict(reading.name, UNTESTABLE, None, "", reason)
    hold = [_holds(reading, effect) for effect in effects]
    fail = [_fails(reading, widened(effect, len(effects))) for effect in effects]
    verdict = REPRODUCED if all(hold) else NOT if any(fail) else UNDECIDED
    if verdict == REPRODUCED and reading.by_construction:
        verdict = BUILT_IN
    least = _least_favourable(reading, effects)
    words = reading.predicate.replace("_", " ")
    wanted = f"{words} {reading.threshold:g}".replace("equals ", "")
    sentence = f"{least} {reading.unit}".strip() + f", wanted {wanted}: {verdict}"
    if len(effects) > 1:
        sentence = (
            f"{wanted} at {sum(hold)} of {len(effects)}, "
            f"undecided at {len(effects) - sum(hold) - sum(fail)}, "
            f"not at {sum(fail)}: {verdict}; least so, {least.label}: {least} "
        ) + reading.unit
    if len(effects) < len(measured):
        n_without = len(measured) - len(effects)
        sentence = f"{sentence.strip()} ({n_without} without such test tasks)"
    return ReadingVerdict(reading.name, verdict, least, reading.unit, sentence.strip())


def _holds(reading: Reading, effect: Effect) -> bool:
    """Whether a predicate holds on a whole interval."""
    (low, high), wanted = effect.bounds, reading.threshold
    return {
        "below": high < wanted,
        "above": low > wanted,
        "equals": low == high == wanted,
        "at_least": low >= wanted,
    }[reading.predicate]


def _fails(reading: Reading, effect: Effect) -> bool:
    """Whether a predicate fails on a whole interval."""
    (low, high), wanted = effect.bounds, reading.threshold
    return {
        "below": low > wanted or low == high == wanted,
        "above": high < wanted or low == high == wanted,
        "equals": not low <= wanted <= high,
        "at_least": high < wanted,
    }[reading.predicate]


def _least_favourable(reading: Reading, effects: list[Effect]) -> Effect:
    """Choose the number that speaks most against the claim."""
    keys = {
        "below": lambda effect: -effect.value,
        "equals": lambda effect: -abs(effect.value - reading.threshold),
    }
    return min(effects, key=keys.get(reading.predicate, lambda effect: effect.value))


def judge_all(root: Path) -> list[Verdict]:
    """Judge all claims of a repository.

    Parameters
    ----------
    root : Path
        The repository: `book/claims.yml` and the result files that it names.

    Returns
    -------
    list of Verdict
        In the order of the file.

    Raises
    ------
    ValueError
        If a claim or a result file is not as wanted.
    """
    claims = load_claims(root / "book" / "claims.yml")
    results = load_results(claims, root)
    return [judge(claim, results) for claim in claims]


def claims_table(verdicts: Iterable[Verdict]) -> pd.DataFrame:
    """Put all verdicts below one another.

    Parameters
    ----------
    verdicts : iterable of Verdict
        What `judge` returned.

    Returns
    -------
    DataFrame
        Index: the claims' names. Columns: the claim, the verdict, what the first
        reading measured, and which reading gave which verdict.
    """
    rows = {
        one.claim.id: {
            "claim": one.claim.claim,
            "verdict": f"{SYMBOLS[one.verdict]} {one.verdict}",
            "effect": one.readings[0].measured,
            "readings": one.sentence,
        }
        for one in verdicts
    }
    return pd.DataFrame.from_dict(rows, orient="index")


def summarise(verdicts: Iterable[Verdict]) -> dict[str, Any]:
    """Write verdicts as plain data.

    Parameters
    ----------
    verdicts : iterable of Verdict
        What `judge` returned.

    Returns
    -------
    dict
        By claim: the verdict, the sentence, and each reading's, with its number.
    """
    return {
        one.claim.id: {
            "verdict": one.verdict,
            "sentence": one.sentence,
            "readings": {
                reading.name: {
                    "verdict": reading.verdict,
                    **_rounded(reading.effect),
                    "unit": reading.unit,
                    "sentence": reading.sentence,
                }
                for reading in one.readings
            },
        }
        for one in verdicts
    }


def _rounded(effect: Effect | None) -> dict[str, float | None]:
    """Write a number and its interval to six digits, the same on any processor."""
    numbers = (None,) * 3 if effect is None else (effect.value, effect.low, effect.high)
    return {
        name: None if number is None else float(f"{number:.6g}")
        for name, number in zip(("value", "low", "high"), numbers, strict=True)
    }


def _refuse_stale(name: str, content: Any, data: Path) -> None:
    """Refuse a result file that was made from other tables than are there."""
    made_from = content.get("provenance", {}).get("data", {})
    if "hash" in content:
        made_from = {content["table"]: content["hash"]}
    for table, digest in made_from.items():
        if checksum(data / table) != digest:
            raise ValueError(f"{name} was made from another {table}; make it anew")
