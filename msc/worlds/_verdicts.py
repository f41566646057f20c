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
from numpy.typing import NDArray
from scipy.stats import binomtest, norm, rankdata, spearmanr, t

from msc.data import Dataset, load_dataset, step_sizes
from msc.estimates import Average, Estimate, quotient, six_digits
from msc.worlds._draw import family_of
from msc.worlds._questions import (
    ASKED,
    Question,
    is_asked,
    load_choices,
    load_kin,
    load_questions,
)
from msc.worlds._study import ALWAYS
from msc.worlds._variants import UNCHANGED, VARIANTS

HOLDS, FAILS, CANNOT_TELL, NOT_ASKED = "holds", "fails", "cannot tell", "not asked"
ANSWERS = (HOLDS, FAILS, CANNOT_TELL, NOT_ASKED)
_N_RESAMPLES = 5000
_FAR, _SIZE = "error_cm", 24  # measure and training tasks of the standings

Array = NDArray[np.float64]


def judge_worlds(folder: Path, results: Path) -> dict[str, Any]:
    """Ask every question of every world, of each family, and of each choice of ours.

    Parameters
    ----------
    folder : Path
        Where worlds, tables and `asked.yml` are.
    results : Path
        Where jumps and studies are.

    Returns
    -------
    dict
        Fit for JSON.

        - "worlds": of each its family, jumps (how many, the sizes of all over the
          spread of policies, share of training tasks beside one), and "answers": by
          question the number, its interval and the answer.
        - "families": by question and family the mean over worlds with its interval,
          the answer, how many worlds answer what, and the share in which it holds,
          with its interval.
        - "assumptions": rows of one choice changed: "of" a headline world or a family,
          "choice" in words, "answers" by question, and of how many of them the answer
          without the change "stands"; the first row of each has nothing changed.
        - "counts": by question how many worlds, and how many changed choices, answer
          what.
        - "payoff": how ratios go with the size of jumps, over layouts.
        - "standings": by family and method, with 24 tasks, how far from the goal
          executed policies end (cm): the mean over worlds of logarithms with its
          interval, the mean rank, and in how many worlds it ends nearest.
    """
    questions, kin = load_questions(folder / ASKED), load_kin(folder / ASKED)
    found = _load_worlds(folder, results)
    worlds: dict[str, Any] = {}
    for one in found:
        asked = [each for each in questions if is_asked(each, one.name, kin)]
        answers = {each.id: _answer(each, one.measure(each)) for each in asked}
        nothing = {each.id: {"answer": NOT_ASKED} for each in questions}
        broken = _discontinuity(one.train, one.jumps)
        told = {"family": one.family, **broken, "answers": nothing | answers}
        worlds[one.name] = told
    families = {
        asked.id: {
            family: _over_worlds(asked, own)
            for family in asked.families
            if (own := _of_family(found, asked, family))
        }
        for asked in questions
    }
    assumptions = [
        *_rows_of_variants(worlds, kin),
        *_rows_of_choices(found, load_choices(folder / ASKED), families, kin),
    ]
    return {
        "worlds": worlds,
        "families": families,
        "assumptions": assumptions,
        "counts": {one.id: _count(one, worlds, assumptions) for one in questions},
        "payoff": _payoff(worlds, questions),
        "standings": _standings(found),
    }


@dataclass(frozen=True)
class _World:
    """What is known of a world."""

    name: str
    family: str
    train: Dataset
    searched_cost: float  # of a test task
    jumps: Mapping[str, Any]
    study: Mapping[str, Any]

    def measure(self, asked: Question) -> list[_Part]:
        """Find the numbers that a question is about; none if not measured."""
        nothing = np.empty(0)
        if asked.measure == "jumps":
            count = len(_besides_the_cut(self.jumps))
            return [_Part(Estimate(count), nothing, nothing)]
        found = []
        for size in asked.sizes:
            if (top := self.average(asked.measure, asked.method, size)) is None:
                return []
            for baseline in asked.baselines:
                if baseline == "cost":
                    ratio = quotient(top.estimate, Estimate(self.searched_cost))
                    bottoms = np.full(len(top.per_set), self.searched_cost)
                else:
                    bottom = self.average(asked.measure, baseline, size)
                    if bottom is None:  # it has no charts to be known
                        bottom = self.average("mse, gate learned", baseline, size)
                    if bottom is None:
                        return []
                    ratio, bottoms = top.over(bottom), bottom.per_set
                found.append(_Part(ratio, top.per_set, bottoms))
        return found

    def average(self, measure: str, method: str, size: int) -> Average | None:
        """Average a method's errors over all training sets of a size."""
        found = [
            of[method]
            for cell in self.study["cells"]
            if cell["n_samples"] == size
            and method in (of := cell["measures"].get(measure, {}))
        ]
        return _pool(found) if found else None


def _pool(found: Sequence[Mapping[str, Any]]) -> Average:
    """Join averages over training sets of several designs."""
    weights = [len(one["per_repetition"]) for one in found]
    averages = np.average([one["mean"] for one in found], weights=weights)
    waves = np.average([one["waves"] for one in found], axis=0, weights=weights)
    sets = np.concatenate([one["per_repetition"] for one in found])
    told = {"mean": float(averages), "per_repetition": sets, "waves": waves}
    return Average.read({"n_tasks": found[0]["n_tasks"], **told})


def _load_worlds(folder: Path, results: Path) -> list[_World]:
    """Load the worlds of which both jumps and a study are there."""
    found = []
    for path in sorted(results.glob("jumps_*.json")):
        name = path.stem.removeprefix("jumps_")
        study = results / f"{name}.json"
        if not study.is_file():
            continue
        test = load_dataset(folder / f"{name}_test.csv").table
        world = _World(
            name=name,
            family=family_of(name).name,
            train=load_dataset(folder / f"{name}.csv"),
            searched_cost=float(test["cost"].mean()),
            jumps=json.loads(path.read_text("utf-8")),
            study=json.loads(study.read_text("utf-8")),
        )
        found.append(world)
    return found


def _rows_of_variants(
    worlds: Mapping[str, Any], kin: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Hold the answers of variants beside those of the worlds that they vary."""
    rows = []
    for base in kin:
        for name, (words, _) in VARIANTS.items():
            world = worlds.get(f"{base}-{name}")
            if world is not None and f"{base}-{UNCHANGED}" in worlds:
                unchanged = worlds[f"{base}-{UNCHANGED}"]["answers"]
                rows.append(_row(base, words, world["answers"], unchanged))
    return rows


def _rows_of_choices(
    worlds: Sequence[_World],
    choices: Mapping[str, Sequence[Question]],
    families: Mapping[str, Mapping[str, Any]],
    kin: Mapping[str, str],
) -> list[dict[str, Any]]:
    """Ask again over the worlds of a family, with other methods in the questions."""
    rows = []
    for family in kin.values():
        nothing = {name: {"answer": NOT_ASKED} for name in families}
        asked_again = {one.id for asked in choices.values() for one in asked}
        unchanged = nothing | {
            name: of[family]
            for name, of in families.items()
            if name in asked_again and family in of
        }
        if unchanged == nothing:
            continue
        rows.append(_row(family, VARIANTS[UNCHANGED][0], unchanged, unchanged))
        for words, asked in choices.items():
            answers = nothing | {
                one.id: _over_worlds(one, parts)
                for one in asked
                if family in one.families and (parts := _of_family(worlds, one, family))
            }
            rows.append(_row(family, words, answers, unchanged))
    return rows


def _row(
    of: str,
    words: str,
    answers: Mapping[str, dict[str, Any]],
    unchanged: Mapping[str, dict[str, Any]],
) -> dict[str, Any]:
    """Tell what becomes of the answers if a choice is another."""
    firm = [name for name, one in unchanged.items() if one["answer"] in (HOLDS, FAILS)]
    stands = [
        name for name in firm if answers[name]["answer"] == unchanged[name]["answer"]
    ]
    told = {"of": of, "choice": words, "changed": answers is not unchanged}
    return told | {"firm": len(firm), "stands": len(stands), "answers": dict(answers)}


def _count(
    asked: Question, worlds: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]
) -> dict[str, dict[str, int]]:
    """Count answers over worlds, variants left out, and over changed choices."""
    drawn = [one for one in worlds.values() if one["family"] != "variant"]
    changed = [row for row in rows if row["changed"]]
    return {
        over: count_answers(one["answers"][asked.id]["answer"] for one in of)
        for over, of in (("worlds", drawn), ("assumptions", changed))
    }


def count_answers(answers: Iterable[str]) -> dict[str, int]:
    """Count answers.

    Parameters
    ----------
    answers : iterable of str
        Some of `ANSWERS`.

    Returns
    -------
    dict of str to int
        How often each of them was given.
    """
    given = list(answers)
    return {one: given.count(one) for one in ANSWERS}


@dataclass(frozen=True)
class _Part:
    """A number of a world: with its interval, and its sets' ratios, if any."""

    estimate: Estimate
    tops: Array
    bottoms: Array


def _confirmed(jumps: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the confirmed jumps of a circle; none of other tasks."""
    return [one for one in jumps.get("jumps", []) if one["is_jump"]]


def _besides_the_cut(jumps: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return those that are not at the cut."""
    return [one for one in _confirmed(jumps) if one["between_deg"][1] < 360]


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
    worlds: Sequence[_World], asked: Question, family: str
) -> list[list[_Part]]:
    """Return the numbers of the worlds of a family."""
    own = [one for one in worlds if one.family == family]
    return [parts for one in own if (parts := one.measure(asked))]


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


def _discontinuity(data: Dataset, jumps: Mapping[str, Any]) -> dict[str, Any]:
    """Say how broken a world is: jumps, their sizes, tasks beside one.

    Somewhere round the circle reaching round either side of the base costs the same:
    one jump of "on_circle" no arm can avoid.
    """
    spread = float(np.sqrt(data.policies.var(axis=0).sum()))
    if "jumps" not in jumps:  # tasks of several numbers
        kept = [one["is_jump"] for one in jumps["bisected"]]
        share = float(np.mean(kept)) if kept else nan
        told = {"jumps": None, "large": jumps["large"], "edges": jumps["edges"]}
        return told | {"confirmed": None if not kept else round(share, 6)}
    steps, _ = step_sizes(data.policies, closed=True)
    inside = _besides_the_cut(jumps)
    sizes = [one["step_sizes"][-1] / spread for one in inside]
    return {
        "jumps": len(inside),
        "on_circle": len(_confirmed(jumps)),
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
        sizes = [one["size"] for one in layouts]
        values = [one["answers"][asked.id].get("value", nan) for one in layouts]
        if not np.ptp(sizes) or not np.ptp(values):
            continue
        found = spearmanr(sizes, values)
        n, rho = len(layouts), float(found.statistic)
        half = 1.96 * np.sqrt((1 + rho**2 / 2) / (n - 3))  # Bonett and Wright, 2000
        centre = np.arctanh(min(max(rho, -0.999), 0.999))
        low, high = np.tanh(centre - half), np.tanh(centre + half)
        told[asked.id] = Estimate(rho, float(low), float(high)).stored("rho")
    return told


def _standings(worlds: Sequence[_World]) -> dict[str, dict[str, Any]]:
    """Compare the methods that are tried on all training sets, over each family."""
    told: dict[str, dict[str, Any]] = {}
    for family in dict.fromkeys(one.family for one in worlds):
        own = [one for one in worlds if one.family == family and family != "variant"]
        averages = [[one.average(_FAR, name, _SIZE) for name in ALWAYS] for one in own]
        errors = [[one.value for one in row if one is not None] for row in averages]
        if not errors:
            continue
        logs, ranks = np.log(errors), rankdata(errors, axis=1)
        told[family] = {
            name: {
                **geometric_mean(logs[:, k]).stored("error_cm"),
                "rank": six_digits(float(ranks[:, k].mean())),
                "first": int((ranks[:, k] == 1).sum()),
            }
            for k, name in enumerate(ALWAYS)
        }
    return told


def geometric_mean(logs: Array) -> Estimate:
    """Average a number a world, given as its logarithm, over worlds."""
    low, high = np.exp(resample(logs))
    return Estimate(float(np.exp(logs.mean())), float(low), float(high))
