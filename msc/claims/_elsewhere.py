"""What other worlds, and other choices of ours, answer to the claims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from msc.estimates import Estimate
from msc.worlds import ANSWERS, Question, count_answers

OVER_WORLDS = "data/results/worlds/verdicts.json"
_SIGNS = dict(zip(ANSWERS, ("●", "✕", "○", "–"), strict=True))
_FREE = "arm", "free"  # whose worlds have no obstacles

Counts = Mapping[str, Mapping[str, int]]


def count_elsewhere(
    verdicts: Mapping[str, Any], questions: Sequence[Question]
) -> dict[str, dict[str, dict[str, int]]]:
    """Count what worlds, and changed choices, answer to each claim.

    A claim about a workspace with obstacles is asked where there are some, and one
    about a workspace without where there are none. Of several questions about a claim
    the first decides.

    Parameters
    ----------
    verdicts : mapping
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.

    Returns
    -------
    dict
        By claim, and by "worlds" and "assumptions": how often it holds, fails, cannot
        be told, and is not asked.
    """
    worlds = verdicts["worlds"].values()
    over = {
        "worlds": [
            (one["family"], one["answers"])
            for one in worlds
            if one["family"] != "variant"
        ],
        "assumptions": [
            (row["of"], row["answers"])
            for row in verdicts["assumptions"]
            if row["changed"]
        ],
    }
    return {
        claim: {
            name: count_answers(
                answers[asked.id]["answer"] if _is_of(claim, family) else ANSWERS[-1]
                for family, answers in rows
            )
            for name, rows in over.items()
        }
        for asked in reversed(questions)
        for claim in asked.claims
    }


def _is_of(claim: str, family: str) -> bool:
    """Whether a claim speaks of such worlds."""
    words = claim.split("-")
    if "free" in words:
        return family in _FREE
    return "obstacles" not in words or family not in _FREE


def write_counts(counts: Mapping[str, int]) -> str:
    """Write counts with the signs of their answers.

    Parameters
    ----------
    counts : mapping of str to int
        How often each of `msc.worlds.ANSWERS` was given.

    Returns
    -------
    str
        All but "not asked"; that, if there are no others.

    Examples
    --------
    >>> write_counts({"holds": 3, "fails": 20, "cannot tell": 1, "not asked": 8})
    '● 3, ✕ 20, ○ 1'
    """
    asked = {one: counts[one] for one in ANSWERS[:3]}
    if not any(asked.values()):
        return ANSWERS[-1]
    return ", ".join(f"{_SIGNS[one]} {number}" for one, number in asked.items())


def elsewhere_values(verdicts: Mapping[str, Any]) -> dict[str, str]:
    """Write what pages quote of the worlds: each answer of each family.

    Parameters
    ----------
    verdicts : mapping
        What `msc.worlds.judge_worlds` returned.

    Returns
    -------
    dict of str to str
        ``worlds_QUESTION_FAMILY``, the mean with its interval; with ``_answer`` behind
        it the answer; with ``_holds``, ``_fails`` and ``_n`` how many worlds hold,
        fail, and there are. Hyphens are underscores.
    """
    told: dict[str, str] = {}
    for question, families in verdicts["families"].items():
        for family, one in families.items():
            name = f"worlds_{question}_{family}".replace("-", "_")
            told[name] = f"{Estimate.read(one, 'value')}"
            told[f"{name}_answer"] = one["answer"]
            told |= {f"{name}_{key}": f"{one[key]}" for key in ("holds", "fails")}
            told[f"{name}_n"] = f"{sum(one[key] for key in ANSWERS[:3])}"
    return told
