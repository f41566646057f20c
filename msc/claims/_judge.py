"""Claims judged: what was measured, held against what each of them wants.

Every verdict is computed. An interval decides: the whole of it must lie where the claim
wants it, or the whole of it where the claim does not. `judge_all` is the one way from
`book/claims.yml` and the result files to verdicts: for the command, chapters and pages.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import Any

import pandas as pd

from msc.claims._claims import Claim, Interpretation, load_claims, measure
from msc.data import find_data, read_result
from msc.estimates import Estimate, bonferroni

CLAIMS = "book/claims.yml"
VERDICTS = "data/results/claims.json"

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
_NONE = dict.fromkeys(("value", "low", "high"))


@dataclass(frozen=True)
class Finding:
    """What an interpretation of a claim came to."""

    name: str
    verdict: str  # a key of SYMBOLS
    estimate: Estimate | None  # of several, the one that favours the claim least
    measured: str  # the same in words, with its unit; or why it cannot be
    wanted: str = ""

    @property
    def sentence(self) -> str:
        """All of it in words."""
        wanted = f", wanted {self.wanted}" if self.wanted else ""
        return f"{self.measured}{wanted}: {self.verdict}"


@dataclass(frozen=True)
class Verdict:
    """What a claim came to."""

    claim: Claim
    findings: tuple[Finding, ...]
    why: str = ""  # it differs from the paper, with what was measured

    @property
    def words(self) -> str:
        """The verdict with its symbol."""
        return f"{SYMBOLS[self.verdict]} {self.verdict}"

    @property
    def literal(self) -> list[Finding]:
        """Findings of the interpretations that decide."""
        return [one for one in self.findings if one.name in self.claim.literal]

    @property
    def verdict(self) -> str:
        """A key of SYMBOLS: the literal ones joined, but for those without evidence."""
        tested = {one.verdict for one in self.literal}
        for no_evidence in (UNTESTABLE, BUILT_IN):
            tested = tested - {no_evidence} or {no_evidence}
        if len(tested) == 1:
            return tested.pop()
        return PARTLY if REPRODUCED in tested else NOT

    @property
    def measured(self) -> str:
        """What gave the verdict: a number; or, if it is "partly", which said what."""
        if self.verdict == PARTLY:
            return _grouped(self.literal)
        first = next(one for one in self.literal if one.verdict == self.verdict)
        name = f"{first.name}: " if len(self.findings) > 1 else ""
        return name + first.measured

    @property
    def differs(self) -> bool:
        """Whether an interpretation gave another verdict."""
        return any(one.verdict != self.verdict for one in self.findings)

    @property
    def sentence(self) -> str:
        """Which interpretation gave which verdict."""
        if len(self.findings) == 1:
            return self.findings[0].sentence
        return _grouped(self.findings)

    @property
    def unexplained(self) -> bool:
        """Whether it differs from the paper and no measurement is quoted to say why."""
        return self.verdict in DIFFERING and "{" not in self.claim.why


def _grouped(findings: Iterable[Finding]) -> str:
    """Say which interpretation gave which verdict."""
    groups: dict[str, list[str]] = {}
    for one in findings:
        groups.setdefault(one.verdict, []).append(one.name)
    return "; ".join(f"{key}: {' / '.join(names)}" for key, names in groups.items())


def judge_all(root: Path, *ids: str) -> list[Verdict]:
    """Judge the claims of a repository.

    Parameters
    ----------
    root : Path
        The repository: `book/claims.yml` and the result files that it names.
    *ids : str
        Which claims, in which order; by default all, in that of the file.

    Returns
    -------
    list of Verdict
        One a claim.

    Raises
    ------
    ValueError
        If a claim is unknown, or a claim or a result file is not as wanted: it is
        missing, or was made from other tables than are there now.
    FileNotFoundError
        If `root` holds no claims.
    """
    if not (root / CLAIMS).is_file():
        raise FileNotFoundError(f"{root} holds no claims: it has no {CLAIMS}")
    claims = {claim.id: claim for claim in load_claims(root / CLAIMS)}
    if unknown := set(ids) - set(claims):
        raise ValueError(f"ids: {sorted(unknown)}; wanted some of {list(claims)}")
    chosen = [claims[one] for one in ids or claims]
    results: dict[str, Any] = {}  # by name; of tables a DataFrame
    for claim in chosen:
        for name in sorted(claim.files - set(results)):
            try:
                results[name] = read_result(root / name, root / "data")
            except ValueError as error:
                raise ValueError(f"claim {claim.id!r}: {error}") from None
    return [judge(claim, results) for claim in chosen]


def show_claims(*ids: str) -> pd.DataFrame:
    """Judge claims from the results in the folder `data`, for a chapter.

    Parameters
    ----------
    *ids : str
        Claims, as "mse-free-24".

    Returns
    -------
    DataFrame
        One row a claim, and below it one an interpretation: the verdict, and what was
        measured. A page shows the claims' sentences in place of their names.

    Raises
    ------
    ValueError
        If a claim is unknown, or a result file is not as wanted.
    """
    rows, sentences = {}, {}
    for found in judge_all(find_data().parent, *ids):
        sentences[found.claim.id] = found.claim.claim
        rows[found.claim.id, "the claim"] = (found.verdict, "")
        for one in found.findings:
            rows[found.claim.id, one.name] = (one.verdict, one.measured)
    index = pd.MultiIndex.from_tuples(rows, names=["claim", "reading"])
    table = _Whole(list(rows.values()), index=index, columns=["verdict", "measured"])
    table.attrs["sentences"] = sentences
    return table


def summarise(verdicts: Iterable[Verdict]) -> dict[str, Any]:
    """Write verdicts as plain data.

    Parameters
    ----------
    verdicts : iterable of Verdict
        What `judge` returned.

    Returns
    -------
    dict
        By claim: the verdict, the sentence, whether it could fail, and each
        interpretation's verdict, with its number.
    """
    return {
        one.claim.id: {
            "verdict": one.verdict,
            "sentence": one.sentence,
            "could_fail": one.claim.could_fail,
            "readings": {
                finding.name: {
                    "verdict": finding.verdict,
                    **(finding.estimate.stored("value") if finding.estimate else _NONE),
                    "sentence": finding.sentence,
                }
                for finding in one.findings
            },
        }
        for one in verdicts
    }


def judge(claim: Claim, results: Mapping[str, Any]) -> Verdict:
    """Hold what was measured against a claim.

    An interpretation is reproduced if its predicate holds on the whole of each
    interval; not reproduced if it fails on the whole of one, widened for as many as
    were looked at; otherwise undecided. One that the design of the experiment makes
    true is "by construction" where it would be reproduced.

    A claim has the verdict of its literal interpretations if they agree. Otherwise it
    is "partly", if any is reproduced; else "not reproduced", since one refutes the
    claim and none confirms it. What cannot be tested, or is by construction, counts
    only where all literal ones are. Others are shown and decide nothing.
    """
    findings, quoted = [], {}
    name = ""
    try:
        for interpretation in claim.interpretations:
            name = interpretation.name
            findings.append(_find(interpretation, results))
            quoted[name] = findings[-1].measured
        for name, support in claim.support.items():
            quoted[name] = ", ".join(map(str, measure(support, results)))
    except ValueError as error:
        raise ValueError(f"claim {claim.id!r}, {name!r}: {error}") from None
    why = claim.why.format_map(quoted)
    return Verdict(claim, tuple(findings), why)


def _find(asked: Interpretation, results: Mapping[str, Any]) -> Finding:
    """Hold one measurement against its predicate."""
    if asked.measurement is None:
        return Finding(asked.name, UNTESTABLE, None, asked.cannot_be_tested)
    found = measure(asked.measurement, results)
    estimates = [estimate for estimate in found if not isnan(estimate.value)]
    if not estimates:
        reason = "no test task is of this kind"
        return Finding(asked.name, UNTESTABLE, None, reason)
    n_hold = sum(_holds(asked, estimate) for estimate in estimates)
    n_fail = sum(
        _fails(asked, bonferroni(estimate, len(estimates))) for estimate in estimates
    )
    verdict = NOT if n_fail else REPRODUCED if n_hold == len(estimates) else UNDECIDED
    if verdict == REPRODUCED and asked.by_construction:
        verdict = BUILT_IN
    least = min(estimates, key=lambda estimate: _favour(asked, estimate))
    measured = f"{least} {asked.unit}".strip()
    measured += f", {least.note}" if least.note and len(estimates) == 1 else ""
    wanted = f"{asked.predicate} {asked.threshold:g}".replace("_", " ")
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
    return Finding(asked.name, verdict, least, measured, wanted)


def _holds(asked: Interpretation, estimate: Estimate) -> bool:
    """Whether a predicate holds on a whole interval."""
    (low, high), wanted = estimate.bounds, asked.threshold
    return {
        "below": high < wanted,
        "above": low > wanted,
        "equals": low == high == wanted,
        "at_least": low >= wanted,
    }[asked.predicate]


def _fails(asked: Interpretation, estimate: Estimate) -> bool:
    """Whether a predicate fails on a whole interval."""
    (low, high), wanted = estimate.bounds, asked.threshold
    exact = estimate.low is None and low == wanted
    return {
        "below": low > wanted or exact,
        "above": high < wanted or exact,
        "equals": not low <= wanted <= high,
        "at_least": high < wanted,
    }[asked.predicate]


def _favour(asked: Interpretation, estimate: Estimate) -> float:
    """Say how much a number speaks for a claim."""
    if asked.predicate == "below":
        return -estimate.value
    if asked.predicate == "equals":
        return -abs(estimate.value - asked.threshold)
    return estimate.value


class _Whole(pd.DataFrame):
    """A table that is shown with its texts whole, and claims in words."""

    def _repr_html_(self) -> str:
        told = self.rename(index=self.attrs["sentences"], level="claim")
        with pd.option_context("display.max_colwidth", None):
            return pd.DataFrame(told).to_html()
