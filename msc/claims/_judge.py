"""The paper's claims, judged: from `book/claims.yml` and result files to verdicts."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from msc.claims._file import Claim, load_claims
from msc.claims._verdicts import Verdict, judge
from msc.data import find_data, read_result

CLAIMS = "book/claims.yml"
VERDICTS = "data/results/claims.json"
_NONE = dict.fromkeys(("value", "low", "high"))


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
    claims = load_claims(root / CLAIMS)
    results = read_results(claims, root)
    return [judge(claim, results) for claim in claims]


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
        measured.

    Raises
    ------
    ValueError
        If a claim is unknown, or a result file is not as wanted.
    """
    root = find_data().parent
    claims = {claim.id: claim for claim in load_claims(root / CLAIMS)}
    if unknown := set(ids) - set(claims):
        raise ValueError(f"ids: {sorted(unknown)}; wanted some of {list(claims)}")
    chosen = [claims[one] for one in ids]
    results = read_results(chosen, root)
    rows = {}
    for found in (judge(claim, results) for claim in chosen):
        rows[found.claim.id, "the claim"] = (found.verdict, "")
        for one in found.findings:
            rows[found.claim.id, one.name] = (one.verdict, one.measured)
    index = pd.MultiIndex.from_tuples(rows, names=["claim", "reading"])
    return _Whole(list(rows.values()), index=index, columns=["verdict", "measured"])


class _Whole(pd.DataFrame):
    """A table that is shown with its texts whole, however long."""

    def _repr_html_(self) -> str:
        with pd.option_context("display.max_colwidth", None):
            return self.to_html()


def read_results(claims: Iterable[Claim], root: Path) -> dict[str, Any]:
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
            try:
                results[name] = read_result(root / name, root / "data")
            except ValueError as error:
                raise ValueError(f"claim {claim.id!r}: {error}") from None
    return results


def summarise(verdicts: Iterable[Verdict]) -> dict[str, Any]:
    """Write verdicts as plain data.

    Parameters
    ----------
    verdicts : iterable of Verdict
        What `judge` returned.

    Returns
    -------
    dict
        By claim: the verdict, the sentence, and each interpretation's, with its number.
    """
    return {
        one.claim.id: {
            "verdict": one.verdict,
            "sentence": one.sentence,
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
