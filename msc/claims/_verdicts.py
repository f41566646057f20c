"""A verdict on a claim: what was measured, held against what the claim wants.

Every verdict is computed. An interval decides: the whole of it must lie where the claim
wants it, or the whole of it where the claim does not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan
from typing import Any

from msc.claims._file import Claim, Interpretation
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
class Finding:
    """What an interpretation of a claim came to.

    Attributes
    ----------
    name : str
        The interpretation.
    verdict : str
        A key of `SYMBOLS`.
    estimate : Estimate or None
        What was measured; of several numbers the one that favours the claim least.
    measured : str
        The same in words, with its unit; or why it cannot be.
    wanted : str
        What the claim wants of it.
    """

    name: str
    verdict: str
    estimate: Estimate | None
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
    findings : tuple of Finding
        What each interpretation came to, the paper's own first.
    why : str
        Why that differs from the paper, with what was measured in its placeholders.
    """

    claim: Claim
    verdict: str
    findings: tuple[Finding, ...]
    why: str = ""

    @property
    def words(self) -> str:
        """The verdict with its symbol."""
        return f"{SYMBOLS[self.verdict]} {self.verdict}"

    @property
    def measured(self) -> str:
        """What the paper's own interpretation measured; of several, which it is."""
        first = self.findings[0]
        name = f"{first.name}: " if len(self.findings) > 1 else ""
        return name + first.measured

    @property
    def differs(self) -> bool:
        """Whether interpretations gave different verdicts."""
        return len({one.verdict for one in self.findings}) > 1

    @property
    def sentence(self) -> str:
        """Which interpretation gave which verdict."""
        if len(self.findings) == 1:
            return self.findings[0].sentence
        groups: dict[str, list[str]] = {}
        for one in self.findings:
            groups.setdefault(one.verdict, []).append(one.name)
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
        That of the interpretations if they agree, and "by construction" if the first,
        the paper's own, is. Otherwise "partly" if any is reproduced; else "not
        reproduced", since one refutes the claim and none confirms it.

    Raises
    ------
    ValueError
        If a number is missing; the message names the claim and the interpretation.

    Notes
    -----
    An interpretation is reproduced if its predicate holds on the whole of each
    interval; not reproduced if it fails on the whole of one, widened for as many as
    were looked at; otherwise undecided. One that the design of the experiment makes
    true is "by construction" where it would be reproduced.
    """
    findings, quoted = [], {}
    name = ""
    try:
        for interpretation in claim.interpretations:
            name = interpretation.name
            findings.append(_judge_interpretation(interpretation, results))
            quoted[name] = findings[-1].measured
        for name, support in claim.support.items():
            quoted[name] = ", ".join(map(str, measure(support, results)))
    except ValueError as error:
        raise ValueError(f"claim {claim.id!r}, {name!r}: {error}") from None
    why = claim.why.format_map(quoted)
    return Verdict(claim, _overall(findings), tuple(findings), why)


def _overall(findings: list[Finding]) -> str:
    """Join the verdicts of interpretations, apart from those that cannot be tested."""
    verdicts = [one.verdict for one in findings if one.verdict != UNTESTABLE]
    if not verdicts:
        return UNTESTABLE
    if verdicts[0] == BUILT_IN or len(set(verdicts)) == 1:
        return verdicts[0]
    return PARTLY if {REPRODUCED, BUILT_IN} & set(verdicts) else NOT


def _judge_interpretation(
    interpretation: Interpretation, results: Mapping[str, Any]
) -> Finding:
    """Hold one measurement against its predicate."""
    if interpretation.measurement is None:
        return Finding(
            interpretation.name, UNTESTABLE, None, interpretation.cannot_be_tested
        )
    found = measure(interpretation.measurement, results)
    estimates = [estimate for estimate in found if not isnan(estimate.value)]
    if not estimates:
        reason = "no test task is of this kind"
        return Finding(interpretation.name, UNTESTABLE, None, reason)
    n_hold = sum(_holds(interpretation, estimate) for estimate in estimates)
    n_fail = sum(
        _fails(interpretation, bonferroni(estimate, len(estimates)))
        for estimate in estimates
    )
    verdict = NOT if n_fail else REPRODUCED if n_hold == len(estimates) else UNDECIDED
    if verdict == REPRODUCED and interpretation.by_construction:
        verdict = BUILT_IN
    least = min(estimates, key=lambda estimate: _favour(interpretation, estimate))
    measured = f"{least} {interpretation.unit}".strip()
    wanted = f"{interpretation.predicate} {interpretation.threshold:g}".replace(
        "_", " "
    )
    wanted = wanted.removeprefix("equals ")
    if len(estimates) > 1:
        wanted += " at each"
        refuted = f", {n_fail} refuted" if n_fail else ""
        measured = (
            f"{n_hold} of {len(estimates)} as claimed{refuted}; "
            f"the worst {measured} ({least.label})"
        )
    if n_without := len(found) - len(estimates):
        wanted += f", {n_without} without such test tasks left out"
    return Finding(interpretation.name, verdict, least, measured, wanted)


def _holds(interpretation: Interpretation, estimate: Estimate) -> bool:
    """Whether a predicate holds on a whole interval."""
    (low, high), wanted = estimate.bounds, interpretation.threshold
    return {
        "below": high < wanted,
        "above": low > wanted,
        "equals": low == high == wanted,
        "at_least": low >= wanted,
    }[interpretation.predicate]


def _fails(interpretation: Interpretation, estimate: Estimate) -> bool:
    """Whether a predicate fails on a whole interval."""
    (low, high), wanted = estimate.bounds, interpretation.threshold
    exact = estimate.low is None and low == wanted
    return {
        "below": low > wanted or exact,
        "above": high < wanted or exact,
        "equals": not low <= wanted <= high,
        "at_least": high < wanted,
    }[interpretation.predicate]


def _favour(interpretation: Interpretation, estimate: Estimate) -> float:
    """Say how much a number speaks for a claim."""
    if interpretation.predicate == "below":
        return -estimate.value
    if interpretation.predicate == "equals":
        return -abs(estimate.value - interpretation.threshold)
    return estimate.value
