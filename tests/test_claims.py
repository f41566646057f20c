"""Verdicts on synthetic results; and the paper's claims themselves, recomputed."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from imagined import imagine

from msc.claims import claim_fragments, judge_all, load_claims, summarise
from msc.claims._judge import SYMBOLS, judge
from msc.claims._page import sections_markdown, table_markdown
from msc.cli import main
from press import checksum, pages

ROOT = Path(__file__).parents[1]
PAGE = {"fig3_free_24": "Figure 3"}
COMMITTED = ROOT / "data" / "results" / "claims.json"
IDS = [
    "manifold-free-continuous",
    "manifold-obstacles-broken",
    "elbow-free",
    "elbow-obstacles",
    "mse-free-360",
    "mse-free-24",
    "mse-obstacles-360",
    "mse-obstacles-24",
    "exec-free",
    "exec-obstacles",
    "fig8-free",
    "fig8-obstacles",
    "fig8-gap",
    "fig8-stable",
    "crkr-stuck",
    "as-good-as-search",
    "cheaper-than-search",
    "more-charts-help",
    "too-many-charts",
    "fewer-samples-hurt-single",
]
STUDY = "data/results/study_free.json"
OTHER = "data/results/study_obstacles.json"
BELOW = {"ratio": "mse", "below": 1}
MEASURED = {"file": STUDY, "design": "even", "n_samples": 24, "baseline": "single"}
CLAIM = {
    "id": "lower",
    "claim": "Charts err less.",
    "quote": "an overall better prediction",
    "section": "IV",
    "chapter": "fig3_free_24",
    "measured": MEASURED,
    "interpretations": {"gate learned": BELOW},
    "margin": "Half is half.",
}


def study(**cells):
    """Return a study: by measure, the triples of value, low and high at each size."""
    sizes = sorted({size for triples in cells.values() for size in triples})
    return {
        "cells": [
            {
                "design": "even",
                "n_samples": size,
                "measures": {
                    measure: dict.fromkeys(
                        ("charts", "single"),
                        dict(zip(("mean", "low", "high"), at, strict=True))
                        | {"n_tasks": 120, "per_repetition": [at[0]], "waves": [0, 1]},
                    )
                    for measure, triples in cells.items()
                    if (at := triples.get(size))
                },
                "ratios": [
                    {"measure": measure, "method": "charts", "baseline": "single"}
                    | dict(zip(("ratio", "low", "high"), at, strict=True))
                    for measure, triples in cells.items()
                    if (at := triples.get(size))
                ],
            }
            for size in sizes
        ]
    }


def claims_of(tmp_path, **changes):
    """Write a file of one claim and read it; a change to None takes a field out."""
    claim = {
        key: value for key, value in (CLAIM | changes).items() if value is not None
    }
    path = tmp_path / "claims.yml"
    path.write_text(yaml.safe_dump([claim], sort_keys=False), "utf-8")
    return load_claims(path)


@pytest.fixture
def verdict_on(tmp_path):
    """Return a function that judges interpretations of a study."""

    def verdict_on(interpretations, results, **changes):
        [claim] = claims_of(tmp_path, interpretations=interpretations, **changes)
        files = results if STUDY in results else {STUDY: results}
        return judge(claim, files)

    return verdict_on


@pytest.mark.parametrize(
    ("predicate", "low", "high", "verdict"),
    [
        ({"below": 1}, 0.4, 0.9, "reproduced"),
        ({"below": 1}, 1.1, 1.5, "not reproduced"),
        ({"below": 1}, 0.9, 1.1, "undecided"),
        ({"below": 1}, 0.9, 1.0, "undecided"),
        ({"below": 0.5}, 0.6, 0.9, "not reproduced"),
        ({"above": 1}, 1.1, 1.5, "reproduced"),
        ({"above": 1}, 0.4, 0.9, "not reproduced"),
        ({"above": 1}, 0.9, 1.1, "undecided"),
        ({"at_least": 1}, 1.0, 1.5, "reproduced"),
        ({"at_least": 1}, 0.5, 1.0, "undecided"),
        ({"at_least": 1}, 0.5, 0.9, "not reproduced"),
        ({"equals": 1}, 0.5, 1.5, "undecided"),
        ({"equals": 1}, 1.5, 1.7, "not reproduced"),
    ],
)
def test_the_whole_interval_decides(predicate, low, high, verdict, verdict_on):
    value = (low + high) / 2
    interpretations = {"gate learned": {"ratio": "mse"} | predicate}
    found = verdict_on(interpretations, study(mse={24: (value, low, high)}))
    assert found.verdict == verdict
    assert found.findings[0].estimate.bounds == (low, high)
    assert found.sentence.endswith(f": {verdict}")
    assert f"{low:g}, {high:g}] × single" in found.sentence


@pytest.mark.parametrize(
    ("predicate", "n_jumps", "verdict"),
    [
        ({"equals": 0}, 0, "reproduced"),
        ({"equals": 0}, 1, "not reproduced"),
        ({"at_least": 3}, 3, "reproduced"),
        ({"at_least": 3}, 2, "not reproduced"),
        ({"below": 3}, 3, "not reproduced"),
        ({"above": 3}, 3, "not reproduced"),
    ],
)
def test_counts_decide_by_themselves(predicate, n_jumps, verdict, verdict_on):
    jumps = [{"between_deg": [k, k + 1], "is_jump": True} for k in range(n_jumps)]
    jumps += [{"between_deg": [90, 91], "is_jump": False}]
    jumps += [{"between_deg": [359, 360], "is_jump": True}]
    audit = {"jumps": jumps}
    interpretations = {"cut": {"jumps": "besides the cut"} | predicate}
    assert verdict_on(interpretations, audit).verdict == verdict
    closed = {"closed": {"jumps": "on the circle", "equals": n_jumps + 1}}
    assert verdict_on(closed, audit).verdict == "reproduced"


LOW, HIGH, OPEN = (0.5, 0.4, 0.6), (2.0, 1.5, 3.0), (1.0, 0.5, 2.0)


@pytest.mark.parametrize(
    ("first", "second", "verdict"),
    [
        (LOW, LOW, "reproduced"),
        (LOW, OPEN, "partly"),
        (OPEN, LOW, "partly"),
        (LOW, HIGH, "partly"),
        (HIGH, HIGH, "not reproduced"),
        (OPEN, HIGH, "not reproduced"),
        (OPEN, OPEN, "undecided"),
    ],
)
def test_literal_interpretations_are_joined(first, second, verdict, verdict_on):
    interpretations = {"one": BELOW, "two": BELOW | {"ratio": "mse, known"}}
    results = study(**{"mse": {24: first}, "mse, known": {24: second}})
    found = verdict_on(interpretations, results, literal=["one", "two"])
    assert found.verdict == verdict
    assert found.findings[0].estimate.value == first[0]
    assert all(name in found.sentence for name in interpretations)
    if verdict == "partly":
        assert found.measured == found.sentence
    else:  # the number of one that has this verdict
        [number] = {
            one.measured for one in found.findings if one.measured in found.measured
        }
        assert verdict in {
            one.verdict for one in found.findings if one.measured == number
        }


@settings(max_examples=20, deadline=None)
@given(
    first=st.sampled_from([LOW, HIGH, OPEN]),
    others=st.lists(st.sampled_from([LOW, HIGH, OPEN]), max_size=3),
)
def test_adding_a_reading_changes_no_verdict(tmp_path_factory, first, others):
    numbers = [first, *others]
    results = study(**{f"mse {k}": {24: one} for k, one in enumerate(numbers)})
    readings = {f"{k}": BELOW | {"ratio": f"mse {k}"} for k in range(len(numbers))}
    folder = tmp_path_factory.mktemp("claims")
    verdicts = []
    for some in ({"0": readings["0"]}, readings):
        [claim] = claims_of(folder, interpretations=some)
        verdicts.append(judge(claim, {STUDY: results}))
    assert verdicts[0].verdict == verdicts[1].verdict
    assert verdicts[1].differs == any(one != first for one in others)


def test_what_the_design_makes_true_is_no_evidence(verdict_on):
    built_in = BELOW | {"by_construction": "We made it so."}
    known = BELOW | {"ratio": "mse, known"}
    both = {"one": built_in, "two": known}
    for first, overall in ((LOW, "by construction"), (HIGH, "not reproduced")):
        results = study(**{"mse": {24: first}, "mse, known": {24: HIGH}})
        assert verdict_on({"one": built_in}, results).verdict == overall
        assert verdict_on(both, results).verdict == overall


@pytest.mark.parametrize(
    ("known", "verdict"),
    [(LOW, "reproduced"), (HIGH, "not reproduced"), (OPEN, "undecided")],
)
def test_no_evidence_beside_some_does_not_count(known, verdict, verdict_on):
    both = {
        "one": BELOW | {"by_construction": "We made it so."},
        "two": BELOW | {"ratio": "mse, known"},
    }
    results = study(**{"mse": {24: LOW}, "mse, known": {24: known}})
    found = verdict_on(both, results, literal=list(both))
    assert found.verdict == verdict
    assert found.measured.startswith("two: ")


def test_sets_of_other_sizes_are_others_however_many_there_are(verdict_on):
    results = study(mse={24: (1.0, 0.5, 2.0), 50: (1.0, 0.5, 2.0)})
    for cell in results["cells"]:
        cell["measures"]["mse"]["charts"]["per_repetition"] = [0.5, 1.5]
    means = {"mean": "mse", "method": "charts"}

    def bounds(n_samples):
        sides = {"top": means, "bottom": means | {"n_samples": n_samples}}
        asked = {"half": {"quotient": sides, "below": 2, "n_samples": 24}}
        return verdict_on(asked, results).findings[0].estimate.bounds

    assert bounds(24) == (1, 1)
    low, high = bounds(50)
    assert low < 1 < high


def test_what_cannot_be_tested_says_why_and_does_not_count(verdict_on):
    never = {"theirs": {"cannot_be_tested": "Their data are not public."}}
    found = verdict_on(never, study(mse={24: LOW}))
    assert found.verdict == "cannot be tested"
    assert found.sentence.startswith("Their data are not public.")
    assert found.findings[0].estimate is None
    readings = {**never, "ours": BELOW}
    both = verdict_on(readings, study(mse={24: LOW}), literal=list(readings))
    assert both.verdict == "reproduced"
    assert verdict_on(readings, study(mse={24: LOW})).verdict == "cannot be tested"


EVERY = {"gate learned": BELOW | {"n_samples": "all"}}


@pytest.mark.parametrize(
    ("triples", "verdict"),
    [
        ({8: LOW, 24: LOW, 50: LOW}, "reproduced"),
        ({8: LOW, 24: OPEN, 50: LOW}, "undecided"),
        ({8: LOW, 24: HIGH, 50: LOW}, "not reproduced"),
        # Excludes one, but would not if it stood for the worst of three.
        ({8: LOW, 24: (1.2, 1.01, 1.42), 50: LOW}, "undecided"),
    ],
)
def test_a_claim_about_every_size_must_hold_at_each(triples, verdict, verdict_on):
    found = verdict_on(EVERY, study(mse=triples))
    assert found.verdict == verdict
    worst = max(triples, key=lambda size: triples[size][0])
    assert found.findings[0].estimate.label == f"n = {worst}"
    n_low = sum(triple == LOW for triple in triples.values())
    assert f"{n_low} of 3 as claimed" in found.sentence
    assert (", 1 refuted" in found.sentence) == (verdict == "not reproduced")


def test_sizes_without_such_tasks_are_left_out_but_not_a_mistyped_measure(verdict_on):
    results = study(away={24: LOW}, mse={8: LOW, 24: LOW})
    away = {"away": BELOW | {"ratio": "away", "n_samples": [8, 24]}}
    found = verdict_on(away, results)
    assert found.verdict == "reproduced"
    assert "1 without such test tasks" in found.sentence
    only = {"away": BELOW | {"ratio": "away", "n_samples": 8}}
    assert verdict_on(only, results).verdict == "cannot be tested"
    wrong = {"away": BELOW | {"ratio": "mes"}}
    message = f"claim 'lower', 'away': {STUDY} has no ratio: mes, design: even"
    with pytest.raises(ValueError, match=message):
        verdict_on(wrong, results)


def test_numbers_from_two_files_are_combined(verdict_on):
    results = {
        STUDY: study(mse={24: (2.0, 1.0, 4.0), 50: (1.0, 1.0, 1.0)}),
        OTHER: study(mse={24: (8.0, 8.0, 8.0), 50: (1.0, 1.0, 1.0)}),
    }
    one = {"ratio": "mse", "n_samples": "all", "average": True}
    sides = {"top": one | {"file": OTHER}, "bottom": one}
    found = verdict_on({"gap": {"quotient": sides, "above": 1}}, results)
    assert found.findings[0].estimate.value == pytest.approx(2)
    assert found.findings[0].estimate.bounds == pytest.approx((2**0.5, 8**0.5))
    means = {"mean": "mse", "method": "charts"}
    sides = {"plus": means | {"file": OTHER}, "minus": means}
    found = verdict_on({"gap": {"difference": sides, "above": 5}}, results)
    assert found.findings[0].estimate.bounds == (4.0, 7.0)


def test_a_quotient_of_means_of_the_same_tasks_knows_that_they_are(verdict_on):
    results = study(
        mse={24: (4.0, 1.0, 16.0), 50: (2.0, 1.0, 4.0), 72: (4.0, 1.0, 9.0)}
    )
    means = {"mean": "mse", "method": "charts"}
    every = {
        "top": means | {"n_samples": [24, 50]},
        "bottom": means | {"n_samples": 72},
    }
    found = verdict_on({"stable": {"quotient": every, "below": 5}}, results)
    assert found.findings[0].estimate.label == "n = 24"
    # The same errors at 24 and at 72: no doubt is left, wide as both intervals are.
    assert found.findings[0].estimate.bounds == (1.0, 1.0)
    half = {"half": {"quotient": every, "below": 0.9} | {"n_samples": 50}}
    half["half"]["quotient"] = {"top": means, "bottom": means | {"n_samples": 72}}
    low, high = verdict_on(half, results).findings[0].estimate.bounds
    assert low < 0.5 < high


def test_how_many_training_sets_agree_is_told(verdict_on):
    results = study(mse={24: OPEN})
    means = results["cells"][0]["measures"]["mse"]
    means["charts"] = means["charts"] | {"per_repetition": [1, 2, 3, 4]}
    means["single"] = means["single"] | {"per_repetition": [2, 3, 4]}
    assert verdict_on({"ours": BELOW}, results).measured.endswith(
        "× single, lower on 3 of 3 training sets"
    )
    again = verdict_on({"ours": BELOW}, study(mse={24: OPEN}))
    assert again.measured.endswith("× single")  # a single set is no more than the ratio


def test_a_mean_of_a_fit_that_failed_is_not_there(verdict_on):
    results = study(mse={24: (1.0, 1.0, 1.0)})
    results["cells"][0]["measures"]["mse"]["charts"] |= {"mean": None}
    with pytest.raises(ValueError, match="has no mean: mse, design: even"):
        verdict_on({"low": {"mean": "mse", "method": "charts", "below": 1}}, results)


def test_the_elbow_must_pick_four_mostly(verdict_on):
    elbow = {"readings": {"squares": {"picked": 4, "resampled": {"4": 40, "5": 10}}}}
    share = {"picked_share": "squares", "count": 4, "above": 0.5}
    interpretations = {"pick": {"picked": "squares", "equals": 4}, "share": share}
    found = verdict_on(interpretations, elbow)
    assert found.verdict == "reproduced"
    low, high = found.findings[1].estimate.bounds
    assert 0.6 < low < 0.8 < high < 0.9
    assert (
        verdict_on({"share": share | {"count": 5}}, elbow).verdict == "not reproduced"
    )


def test_times_are_joined_over_their_range(verdict_on):
    costs = {
        "searches": {"free": {"ways": {"alone": {"seconds": [4.0, 6.0]}}}},
        "skill": {
            "free": {
                "predict_one_microseconds": {"median": 1e4, "low": 1e4, "high": 1e4}
            }
        },
    }
    sides = {"top": {"seconds": "search"}, "bottom": {"seconds": "prediction"}}
    interpretations = {"time": {"quotient": sides, "world": "free", "above": 100}}
    found = verdict_on(interpretations, costs)
    assert found.findings[0].estimate.bounds == pytest.approx((400, 600))


def interpretation(**changes):
    return {"interpretations": {"gate learned": BELOW | changes}}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"quote": None}, r"claim 'lower', quote: missing"),
        ({"id": None}, r"claim 'number 1', id: missing"),
        ({"title": "x"}, r"claim 'lower', title: unknown"),
        ({"section": 4}, r"claim 'lower', section: 4; wanted a text"),
        ({"literal": "gate learned"}, r"literal: 'gate learned'; wanted a list"),
        ({"literal": []}, r"literal: \[\]; wanted some of \['gate learned'\]"),
        ({"literal": ["gate"]}, r"literal: \['gate'\]; wanted some of"),
        (
            {"interpretations": ["x"]},
            r"claim 'lower', interpretations: \['x'\]; wanted a mapping",
        ),
        ({"quote": "word " * 41}, r"claim 'lower', quote: 41 words; wanted at most 40"),
        ({"measured": {"sise": 3}}, r"claim 'lower', measured: 'sise' unknown"),
        (
            interpretation(above=1),
            r"'gate learned': predicates \['below', 'above'\]; wanted",
        ),
        (interpretation(below="1"), r"'gate learned': below: '1'; wanted a number"),
        (interpretation(sise=3), r"'gate learned': sise: unknown"),
        (
            interpretation(mean="mse"),
            r"quantity: got \['ratio', 'mean'\]; wanted one of ratio",
        ),
        (interpretation(cannot_be_tested="x"), r"cannot_be_tested stands alone"),
        (
            {"interpretations": {"gate": 3}},
            r"interpretations: 'gate': wanted a mapping",
        ),
        (
            {"interpretations": {"a.b": BELOW}},
            r"interpretations: 'a.b'; wanted a name without",
        ),
        (
            {"measured": {"file": STUDY, "design": "even", "n_samples": 24}},
            r"interpretations: 'gate learned': baseline: missing, but ratio needs it",
        ),
        (
            {
                "interpretations": {
                    "gap": {"quotient": {"top": {"ratio": "mse"}}, "below": 1}
                }
            },
            r"'gap': quotient: wanted two measurements, \('top', 'bottom'\)",
        ),
        (
            {**interpretation(below=0.5), "margin": None},
            r"claim 'lower', margin: missing",
        ),
        ({"why": "It fell by 20 %: {gate learned}."}, r"why: has a typed number"),
        ({"why": "See {gate}."}, r"why: \{gate\} unknown; wanted one of gate learned"),
        ({"support": {"mean": {"mean": "mse"}}}, r"support: 'mean': method: missing"),
    ],
)
def test_a_bad_claim_names_itself_and_the_field(changes, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        claims_of(tmp_path, **changes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- id: [", r"claims\.yml is not YAML"),
        ("id: x", r"claims\.yml: wanted a list of claims"),
        (yaml.safe_dump([CLAIM, CLAIM]), r"claim 'lower', id: used twice"),
    ],
)
def test_a_bad_file_is_refused(text, message, tmp_path):
    path = tmp_path / "claims.yml"
    path.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=message):
        load_claims(path)


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """Lay out a repository of one claim and its study; work there."""
    (tmp_path / "book").mkdir()
    (tmp_path / "data" / "results").mkdir(parents=True)
    (tmp_path / "book" / "claims.yml").write_text(yaml.safe_dump([CLAIM]), "utf-8")
    (tmp_path / STUDY).write_text(json.dumps(study(mse={24: OPEN})), "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_missing_result_file_names_the_claim_and_the_command(repository, capsys):
    (repository / STUDY).unlink()
    assert main(["claims"]) == 2
    assert capsys.readouterr().err == (
        "msc: error: claim 'lower': study_free.json is not there; "
        "make it: msc evaluate --profile full\n"
    )


def test_results_of_other_tables_are_refused(repository):
    table = repository / "data" / "free.csv"
    table.write_text("a\n1\n", "utf-8")
    provenance = {"provenance": {"data": {"free.csv": checksum(table)}}}
    (repository / STUDY).write_text(
        json.dumps(study(mse={24: LOW}) | provenance), "utf-8"
    )
    assert [one.verdict for one in judge_all(repository)] == ["reproduced"]
    table.write_text("a\n2\n", "utf-8")
    with pytest.raises(ValueError, match=r"study_free\.json rests on another free"):
        judge_all(repository)


def test_the_command_prints_and_writes_verdicts(repository, capsys):
    assert main(["claims", "--out", "data/results/claims.json"]) == 0
    printed = capsys.readouterr().out
    assert "lower  ○ undecided" in printed
    assert "1 [0.5, 2] × single" in printed
    assert "lower: undecided, but no `why` quotes a measurement" in printed
    written = json.loads((repository / "data/results/claims.json").read_text("utf-8"))
    assert written == summarise(judge_all(repository))
    assert written["lower"]["readings"]["gate learned"]["high"] == 2
    assert main(["claims", "--out", "claims.csv"]) == 2


def test_a_why_quotes_what_was_measured(verdict_on):
    support = {"at fifty": {"ratio": "mse", "n_samples": 50}}
    why = "It is {gate learned}, but {at fifty} with more, see Figure 8."
    results = study(mse={24: OPEN, 50: LOW})
    found = verdict_on({"gate learned": BELOW}, results, why=why, support=support)
    assert found.why == (
        "It is 1 [0.5, 2] × single, but 0.5 [0.4, 0.6] with more, see Figure 8."
    )
    assert not found.unexplained
    assert verdict_on({"gate learned": BELOW}, results).unexplained
    idle = verdict_on({"gate learned": BELOW}, results, why="Who knows.")
    assert idle.unexplained


def test_tables_link_each_claim_and_verdict(verdict_on):
    built_in = BELOW | {"by_construction": "We made it so."}
    found = verdict_on(
        {"one": built_in, "two": BELOW | {"baseline": ["single"]}},
        study(mse={24: LOW}),
    )
    *_, row, _ = table_markdown([found], PAGE, {}).splitlines()
    assert row == (
        "| [Charts err less.](fig3_free_24) "
        "| [◇ by construction](claim-lower) | one: 0.5 [0.4, 0.6] × single; "
        "[other readings differ](claim-lower) |"
    )
    assert "| Charts err less. |" in table_markdown([found], {}, {})
    section = sections_markdown([found], PAGE, {})
    assert section.count("| reading | measured | wanted | verdict |") == 1
    assert section.startswith(
        "### Figure 3\n\n[The chapter](fig3_free_24) shows it.\n\n"
        ":::{dropdown} Charts err less. **◇ by construction**\n:name: claim-lower\n\n> "
    )
    assert section.endswith("\n:::\n")
    measured = "0.5 [0.4, 0.6] × single | below 1"
    assert f"| **one** | {measured} | by construction |" in section
    assert "**By construction.** We made it so." in section
    assert "**Margin.** Half is half." in section


def test_claims_stand_by_chapter_in_the_order_of_the_book(verdict_on):
    one = verdict_on({"one": BELOW}, study(mse={24: LOW}))
    chapters = {"b": "last", "a": "first", "c": "last"}
    three = [
        replace(one, claim=replace(one.claim, id=name, chapter=chapter))
        for name, chapter in chapters.items()
    ]
    text = sections_markdown(three, {"first": "One", "other": "Two"}, {})
    assert re.findall("^(?:### |:name: claim-)(.+)", text, re.MULTILINE) == [
        *("One", "a"),
        *("last", "b", "c"),
    ]


def test_a_book_without_verdicts_yet_says_so(repository):
    for told in claim_fragments([], {}).values():
        assert "No verdicts yet" in told
    fragments = claim_fragments(judge_all(repository), {})
    assert sorted(fragments) == ["claims_readings.md", "claims_table.md"]
    assert "○ undecided" in fragments["claims_readings.md"]


CLAIMS = load_claims(ROOT / "book" / "claims.yml")


def test_every_claim_is_there_once():
    assert [claim.id for claim in CLAIMS] == IDS


def test_verdicts_can_be_told_apart_without_colour():
    assert len(set(SYMBOLS.values())) == len(SYMBOLS)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_quotations_are_short(claim):
    assert len(claim.quote.split()) < 40


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_a_claim_can_come_out_either_way(claim):
    built_in = any(one.by_construction for one in claim.interpretations)
    confirmed = judge(claim, imagine(right=True))
    assert confirmed.verdict == ("by construction" if built_in else "reproduced")
    assert {one.verdict for one in confirmed.findings} <= {
        "reproduced",
        confirmed.verdict,
    }
    refuted = judge(claim, imagine(right=False))
    assert {one.verdict for one in refuted.findings} == {"not reproduced"}


@pytest.fixture(scope="module")
def verdicts():
    return judge_all(ROOT)


def test_the_committed_verdicts_are_those_of_the_committed_results(verdicts):
    assert summarise(verdicts) == json.loads(COMMITTED.read_text("utf-8"))


def test_the_committed_results_are_of_the_full_profile():
    files = {file for claim in CLAIMS for file in claim.files if "study" in file}
    for file in files:
        told = (ROOT / file).read_text("utf-8")
        assert re.findall(r'^ *"profile": "(.+)",$', told, re.M) == ["full"]


def test_every_claim_has_its_chapter(verdicts):
    known = {page.stem for page in pages(ROOT)}
    assert {one.claim.chapter for one in verdicts} <= known


def test_every_verdict_that_differs_says_why(verdicts):
    assert [one.claim.id for one in verdicts if one.unexplained] == []


def test_a_page_without_a_place_is_refused_before_anything_is_written(tmp_path, capsys):
    page = tmp_path / "README.md"
    for text, said in (
        (None, "No such file"),
        ("# No marks\n", "no lines .* to write"),
    ):
        if text is not None:
            page.write_text(text, encoding="utf-8")
        out = tmp_path / "claims.json"
        assert main(["claims", "--out", str(out), "--readme", str(page)]) == 2
        told = capsys.readouterr()
        assert re.search(said, told.err)
        assert not told.out
        assert not out.exists()
