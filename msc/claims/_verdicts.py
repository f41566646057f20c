"""A verdict on a claim: what was measured, held against what the claim wants.

Every verdict is computed. An interval decides: the whole of it must lie where the claim
wants it, or the whole of it where the claim does not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan
from typing import Any

from msc.claims._file import Claim, Reading
from msc.claims._measured import measure
from msc.estimates import Estimate, bonferroni

REPRODUCED = "reproduced"
PARTLY = "partly"
NOT = "not reproduced"
UNDECIDED = "undecided"
BUILT_IN = "by construction"
UNTESTABLE = "cannot be tested"
SYMBOLS = {
    REPRODUCED: "●",
    PARTLY: "◐",
    NOT: "✕",
    UNDECIDED: "○",
    BUILT_IN: "◇",
    UNTESTABLE: "–",
}
DIFFERING = (PARTLY, NOT, UNDECIDED)  # from what the paper says


@dataclass(frozen=True)
class ReadingVerdict:
    """What a reading of a claim came to.

    Attributes
    ----------
    name : str
        The reading.
    verdict : str
        A key of `SYMBOLS`.
    effect : Estimate or None
        What was measured; of several numbers the one that favours the claim least.
    measured : str
        The same in words, with its unit; or why it cannot be.
    wanted : str
        What the claim wants of it.
    """

    name: str
    verdict: str
    effect: Estimate | None
    measured: str
    wanted: str = ""

    @property
    def sentence(self) -> str:
        """All of it in words."""
        wanted = f", wanted {self.wanted}" if self.wanted else ""
        return f"{self.measured}{wanted}: {self.verdict}"


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
        What each reading came to, the paper's own first.
    why : str
        Why that differs from the paper, with what was measured in its placeholders.
    """

    claim: Claim
    verdict: str
    readings: tuple[ReadingVerdict, ...]
    why: str = ""

    @property
    def words(self) -> str:
        """The verdict with its symbol."""
        return f"{SYMBOLS[self.verdict]} {self.verdict}"

    @property
    def measured(self) -> str:
        """What the paper's own reading measured; of several readings, which it is."""
        first = self.readings[0]
        name = f"{first.name}: " if len(self.readings) > 1 else ""
        return name + first.measured

    @property
    def differs(self) -> bool:
        """Whether readings gave different verdicts."""
        return len({reading.verdict for reading in self.readings}) > 1

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
    readings, quoted = [], {}
    name = ""
    try:
        for reading in claim.readings:
            name = reading.name
            readings.append(_judge_reading(reading, results))
            quoted[name] = readings[-1].measured
        for name, support in claim.support.items():
            quoted[name] = ", ".join(map(str, measure(support, results)))
    except ValueError as error:
        raise ValueError(f"claim {claim.id!r}, {name!r}: {error}") from None
    why = claim.why.format_map(quoted)
    return Verdict(claim, _overall(readings), tuple(readings), why)


def _overall(readings: list[ReadingVerdict]) -> str:
    """Join the verdicts of readings, apart from those that cannot be tested."""
    verdicts = [one.verdict for one in readings if one.verdict != UNTESTABLE]
    if not verdicts:
        return UNTESTABLE
    if verdicts[0] == BUILT_IN or len(set(verdicts)) == 1:
        return verdicts[0]
    return PARTLY if {REPRODUCED, BUILT_IN} & set(verdicts) else NOT


def _judge_reading(reading: Reading, results: Mapping[str, Any]) -> ReadingVerdict:
    """Hold one measurement against its predicate."""
    if reading.measurement is None:
        return ReadingVerdict(reading.name, UNTESTABLE, None, reading.cannot_be_tested)
    found = measure(reading.measurement, results)
    effects = [effect for effect in found if not isnan(effect.value)]
    if not effects:
        reason = "no test task is of this kind"
        return ReadingVerdict(reading.name, UNTESTABLE, None, reason)
    n_hold = sum(_holds(reading, effect) for effect in effects)
    n_fail = sum(
        _fails(reading, bonferroni(effect, len(effects))) for effect in effects
    )
    verdict = NOT if n_fail else REPRODUCED if n_hold == len(effects) else UNDECIDED
    if verdict == REPRODUCED and reading.by_construction:
        verdict = BUILT_IN
    least = min(effects, key=lambda effect: _favour(reading, effect))
    measured = f"{least} {reading.unit}".strip()
    wanted = f"{reading.predicate} {reading.threshold:g}".replace("_", " ")
    wanted = wanted.removeprefix("equals ")
    if len(effects) > 1:
        wanted += " at each"
        refuted = f", {n_fail} refuted" if n_fail else ""
        measured = (
            f"{n_hold} of {len(effects)} as claimed{refuted}; "
            f"the worst {measured} ({least.label})"
        )
    if n_without := len(found) - len(effects):
        wanted += f", {n_without} without such test tasks left out"
    return ReadingVerdict(reading.name, verdict, least, measured, wanted)


def _holds(reading: Reading, effect: Estimate) -> bool:
    """Whether a predicate holds on a whole interval."""
    (low, high), wanted = effect.bounds, reading.threshold
    return {
        "below": high < wanted,
        "above": low > wanted,
        "equals": low == high == wanted,
        "at_least": low >= wanted,
    }[reading.predicate]


def _fails(reading: Reading, effect: Estimate) -> bool:
    """Whether a predicate fails on a whole interval."""
    (low, high), wanted = effect.bounds, reading.threshold
    exact = effect.low is None and low == wanted
    return {
        "below": low > wanted or exact,
        "above": high < wanted or exact,
        "equals": not low <= wanted <= high,
        "at_least": high < wanted,
    }[reading.predicate]


def _favour(reading: Reading, effect: Estimate) -> float:
    """Say how much a number speaks for a claim."""
    if reading.predicate == "below":
        return -effect.value
    if reading.predicate == "equals":
        return -abs(effect.value - reading.threshold)
    return effect.value
