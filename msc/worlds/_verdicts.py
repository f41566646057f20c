"""Claims over worlds: what is asked, what each world answers, and what all of them do.

`data/worlds/asked.yml` was written before the first world was searched. A question is a
number a world, with one predicate and a smallest effect of interest.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.stats import binomtest, norm, spearmanr, t

from msc.data import load_dataset, step_sizes
from msc.estimates import Average, Estimate, quotient, six_digits
from msc.robot import read_world
from msc.study import find_cell
from msc.worlds._draw import family_of

HOLDS, FAILS, CANNOT_TELL, NOT_ASKED = "holds", "fails", "cannot tell", "not asked"
ANSWERS = (HOLDS, FAILS, CANNOT_TELL, NOT_ASKED)
ASKED = "asked.yml"
_N_RESAMPLES = 10_000
_PREDICATES = ("below", "at_least", "equals")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Question:
    """What is asked of worlds.

    Attributes
    ----------
    id : str
        Its name.
    question : str
        In words.
    families : tuple of str
        Of whose worlds it is asked.
    claims : tuple of str
        Claims of the paper that it is of; none, if it is our own.
    measure : str
        A key of `msc.study.MEASURES`; or "jumps".
    sizes : tuple of int
        Numbers of training tasks.
    method : str
        Whose error is divided,
    baselines : tuple of str
        by whose; "cost": by what the searched policies of the test tasks cost.
    predicate : {"below", "at_least", "equals"}
        Where the number must lie,
    wanted : float
        of this.
    effect : float
        Between this and `wanted` an effect is too small to be of interest.
    """

    id: str
    question: str
    families: tuple[str, ...]
    claims: tuple[str, ...]
    measure: str
    predicate: str
    wanted: float
    effect: float
    sizes: tuple[int, ...] = ()
    method: str = ""
    baselines: tuple[str, ...] = ()


def load_questions(path: Path) -> list[Question]:
    """Read what is asked.

    Parameters
    ----------
    path : Path
        `data/worlds/asked.yml`.

    Returns
    -------
    list of Question
        In the order of the file.

    Raises
    ------
    ValueError
        If a question lacks a part or has not one predicate.
    """
    told = yaml.safe_load(path.read_text("utf-8"))
    return [_question(one) for one in told["questions"]]


def _question(told: Mapping[str, Any]) -> Question:
    """Read a question."""
    predicates = [name for name in _PREDICATES if name in told]
    if len(predicates) != 1 or not {"id", "question", "families"} <= told.keys():
        raise ValueError(
            f"question {told.get('id')!r}: wanted id, question, families and one of "
            f"{', '.join(_PREDICATES)}"
        )
    wanted = float(told[predicates[0]])
    return Question(
        id=told["id"],
        question=told["question"],
        families=tuple(told["families"]),
        claims=_listed(told.get("of", [])),
        measure="jumps" if "jumps" in told else told["measure"],
        predicate=predicates[0],
        wanted=wanted,
        effect=float(told.get("effect", wanted)),
        sizes=_listed(told.get("n_samples", [])),
        method=told.get("method", ""),
        baselines=_listed(told.get("baseline", [])),
    )


def _listed(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, list) else (value,)


def judge_worlds(folder: Path, results: Path) -> dict[str, Any]:
    """Ask every question of every world, and of each family of worlds.

    Parameters
    ----------
    folder : Path
        Where worlds, tables and `asked.yml` are.
    results : Path
        Where jumps and studies are.

    Returns
    -------
    dict
        Fit for JSON. "worlds": of each its family, jumps (how many, the sizes of all
        over the spread of policies, share of training tasks beside one), and "answers":
        by question the number, its interval and the answer. "families": by question and
        family the mean over worlds with its interval, the answer, how many worlds
        answer what, and the share in which it holds, with its interval. "payoff": how
        ratios go with the size of jumps, over layouts.
    """
    questions = load_questions(folder / ASKED)
    worlds: dict[str, Any] = {}
    parts: dict[str, dict[str, list[_Part]]] = {}
    for path in sorted(results.glob("jumps_*.json")):
        name = path.stem.removeprefix("jumps_")
        study_file = results / f"{name}.json"
        if not study_file.is_file():
            continue
        jumps = json.loads(path.read_text("utf-8"))
        study = json.loads(study_file.read_text("utf-8"))
        family = family_of(name).name
        test = load_dataset(folder / f"{name}_test.csv").table
        design = "uniform" if read_world(folder / f"{name}.toml").further else "even"
        parts[name] = {
            one.id: _measure(one, jumps, study, design, float(test["cost"].mean()))
            for one in questions
            if family in one.families
        }
        worlds[name] = {
            "family": family,
            **_discontinuity(folder / f"{name}.csv", jumps),
            "answers": {
                one.id: _answer(one, parts[name].get(one.id, [])) for one in questions
            },
        }
    families = {
        one.id: {
            family: _over_worlds(one, own)
            for family in one.families
            if (own := _of_family(parts, worlds, one, family))
        }
        for one in questions
    }
    return {
        "worlds": worlds,
        "families": families,
        "payoff": _payoff(worlds, questions),
    }


@dataclass(frozen=True)
class _Part:
    """A number of a world: with its interval, and its sets' ratios, if any."""

    estimate: Estimate
    tops: Array
    bottoms: Array


def _measure(
    asked: Question,
    jumps: Mapping[str, Any],
    study: Mapping[str, Any],
    design: str,
    searched_cost: float,
) -> list[_Part]:
    """Find the numbers that a question is about, in a world; none if not measured."""
    nothing = np.empty(0)
    if asked.measure == "jumps":
        return [_Part(Estimate(_count_jumps(jumps)), nothing, nothing)]
    found = []
    for size in asked.sizes:
        measures = find_cell(study, design, size)["measures"]
        of = measures[asked.measure]
        top = of.get(asked.method)
        for baseline in asked.baselines:
            if baseline == "cost":
                one = Average.read(top).estimate
                ratio = quotient(one, Estimate(searched_cost))
                bottoms = np.full(len(top["per_repetition"]), searched_cost)
            else:
                bottom = of.get(baseline) or measures["mse, gate learned"][baseline]
                ratio = Average.read(top).over(Average.read(bottom))
                bottoms = np.array(bottom["per_repetition"])
            found.append(_Part(ratio, np.array(top["per_repetition"]), bottoms))
    return found


def _count_jumps(jumps: Mapping[str, Any]) -> int:
    """Count confirmed jumps besides the cut."""
    return sum(
        one["is_jump"] and one["between_deg"][1] < 360 for one in jumps.get("jumps", [])
    )


def _answer(asked: Question, parts: Sequence[_Part]) -> dict[str, Any]:
    """Answer a question in a world: of several numbers the least favourable decides."""
    if not parts:
        return {"answer": NOT_ASKED}
    answer = _joined([_judge(asked, part.estimate) for part in parts])
    worst = max(parts, key=lambda part: _distance(asked, part.estimate.value))
    return {"answer": answer, **worst.estimate.stored("value")}


def _joined(answers: Sequence[str]) -> str:
    """Join answers: one that fails decides, and all have to hold."""
    if FAILS in answers:
        return FAILS
    return HOLDS if set(answers) == {HOLDS} else CANNOT_TELL


def _distance(asked: Question, value: float) -> float:
    """Say how far a number is on the wrong side."""
    return value if asked.predicate == "below" else abs(value - asked.wanted)


def _judge(asked: Question, estimate: Estimate) -> str:
    """Hold a number against a predicate and the smallest effect of interest."""
    low, high = estimate.bounds
    if asked.predicate == "below":
        if high < asked.wanted and estimate.value <= asked.effect:
            return HOLDS
        return FAILS if low > asked.effect else CANNOT_TELL
    if asked.predicate == "at_least":
        return HOLDS if low >= asked.wanted else FAILS
    return HOLDS if low == high == asked.wanted else FAILS


def _of_family(
    parts: Mapping[str, Mapping[str, list[_Part]]],
    worlds: Mapping[str, Any],
    asked: Question,
    family: str,
) -> list[list[_Part]]:
    """Return the numbers of the worlds of a family."""
    return [
        parts[name][asked.id]
        for name, world in worlds.items()
        if world["family"] == family and parts[name].get(asked.id)
    ]


def _over_worlds(asked: Question, worlds: Sequence[list[_Part]]) -> dict[str, Any]:
    """Answer a question over worlds."""
    answers = [_answer(asked, parts)["answer"] for parts in worlds]
    n_holds = answers.count(HOLDS)
    share = binomtest(n_holds, len(answers)).proportion_ci(method="wilson")
    told: dict[str, Any] = {one: answers.count(one) for one in ANSWERS[:3]}
    bounds = {"share_low": share.low, "share_high": share.high}
    told |= {"share": six_digits(n_holds / len(answers))}
    told |= {name: six_digits(float(bound)) for name, bound in bounds.items()}
    if asked.measure == "jumps":  # a claim of all worlds: one decides
        counts = [parts[0].estimate.value for parts in worlds]
        mean = Estimate(float(np.mean(counts)), *resample(np.array(counts)))
        decided = {(True, False): HOLDS, (False, True): FAILS}
        key = share.low > 0.5, share.high < 0.5
        return {"answer": decided.get(key, CANNOT_TELL), **mean.stored("value"), **told}
    if len(worlds) == 1:  # it tells of no other
        return {**_answer(asked, worlds[0]), **told}
    n_parts = len(worlds[0])
    means = [
        _mean_ratio([parts[k] for parts in worlds], n_looks=n_parts)
        for k in range(n_parts)
    ]
    answer = _joined([_judge(asked, mean) for mean in means])
    worst = max(means, key=lambda mean: mean.value)
    return {"answer": answer, **worst.stored("value"), **told}


def _mean_ratio(parts: Sequence[_Part], n_looks: int) -> Estimate:
    """Average ratios over worlds, on a logarithmic scale where all are positive."""
    values = np.array([part.estimate.value for part in parts])
    rng = np.random.default_rng(0)
    picks = rng.integers(len(parts), size=(_N_RESAMPLES, len(parts)))
    drawn = np.empty((_N_RESAMPLES, len(parts)))
    for number, part in enumerate(parts):  # within a world, its training sets
        at = picks == number
        sets = rng.integers(len(part.tops), size=(int(at.sum()), len(part.tops)))
        pairs = len(part.tops) == len(part.bottoms)
        tops = part.tops[sets].mean(axis=1)
        bottoms = part.bottoms[sets].mean(axis=1) if pairs else part.bottoms.mean()
        drawn[at] = tops / bottoms
    if min(values.min(), drawn.min()) > 0:
        centre, means = np.log(values).mean(), np.log(drawn).mean(axis=1)
        low, high = np.exp(np.quantile(means, _levels(len(parts), n_looks)))
        return Estimate(float(np.exp(centre)), float(low), float(high))
    low, high = np.quantile(drawn.mean(axis=1), _levels(len(parts), n_looks))
    return Estimate(float(values.mean()), float(low), float(high))


def resample(values: Array) -> tuple[float, float]:
    """Bound the mean of a number a world, by drawing worlds again and again.

    Parameters
    ----------
    values : ndarray of shape (n_worlds,)
        The numbers.

    Returns
    -------
    low, high : float
        A 95 % interval: expanded percentiles [1]_, since with few worlds plain ones are
        too narrow.

    References
    ----------
    .. [1] T. C. Hesterberg, "What teachers should know about the bootstrap", The
       American Statistician 69(4), 2015.

    Examples
    --------
    >>> low, high = resample(np.array([1.0, 2.0, 3.0, 4.0]))
    >>> 1 <= low < 2.5 < high <= 4
    True
    """
    rng = np.random.default_rng(0)
    picks = rng.integers(len(values), size=(_N_RESAMPLES, len(values)))
    low, high = np.quantile(values[picks].mean(axis=1), _levels(len(values)))
    return float(low), float(high)


def _levels(n_worlds: int, n_looks: int = 1) -> tuple[float, float]:
    """Return which percentiles bound an interval, for so many worlds and looks."""
    if n_worlds < 2:
        return 0.0, 1.0
    wide = t.ppf(1 - 0.025 / n_looks, n_worlds - 1)
    level = float(norm.cdf(-wide * np.sqrt(n_worlds / (n_worlds - 1))))
    return level, 1 - level


def _discontinuity(table: Path, jumps: Mapping[str, Any]) -> dict[str, Any]:
    """Say how broken a world is: jumps, their sizes, tasks beside one."""
    data = load_dataset(table)
    spread = float(np.sqrt(data.policies.var(axis=0).sum()))
    if "jumps" not in jumps:  # tasks of several numbers
        kept = [one["is_jump"] for one in jumps["bisected"]]
        share = float(np.mean(kept)) if kept else nan
        told = {"jumps": None, "large": jumps["large"], "edges": jumps["edges"]}
        return told | {"confirmed": None if not kept else round(share, 6)}
    steps, _ = step_sizes(data.policies, closed=True)
    kept = [one for one in jumps["jumps"] if one["is_jump"]]
    inside = [one for one in kept if one["between_deg"][1] < 360]
    sizes = [one["step_sizes"][-1] / spread for one in inside]
    return {
        "jumps": len(inside),
        "size": round(float(np.sum(sizes)), 6),
        "beside": round(2 * len(inside) / len(steps), 6),
    }


def _payoff(
    worlds: Mapping[str, Any], questions: Iterable[Question]
) -> dict[str, dict[str, float]]:
    """Correlate ranks of ratios and of jump sizes, over layouts."""
    told: dict[str, Any] = {}
    layouts = [one for one in worlds.values() if one["family"] == "layout"]
    for asked in questions:
        if asked.predicate != "below" or len(layouts) < 4:
            continue
        values = [one["answers"][asked.id].get("value", nan) for one in layouts]
        found = spearmanr([one["size"] for one in layouts], values)
        n, rho = len(layouts), float(found.statistic)
        half = 1.96 * np.sqrt((1 + rho**2 / 2) / (n - 3))  # Bonett and Wright, 2000
        centre = np.arctanh(min(max(rho, -0.999), 0.999))
        low, high = np.tanh(centre - half), np.tanh(centre + half)
        told[asked.id] = Estimate(rho, float(low), float(high)).stored("rho")
    return told
