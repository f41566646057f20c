"""Sentences of the book that stand without a cell beside them: the data say the same.

Each test is named after what is said; its first line says where.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from msc import SMCE, find_jumps, load_dataset
from msc.data import load_results
from msc.plots import confirmed_jumps
from msc.study import count_ahead, find_cell

ROOT = Path(__file__).parents[1]
SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


@cache
def one_result(name):
    (found,) = load_results(name)
    return found


def ratio(world, measure, n_samples, baseline, method="charts"):
    """Return the charts' mean over another method's, with its interval."""
    study = one_result(f"study_{world}")
    wanted = {"measure": measure, "method": method, "baseline": baseline}
    (found,) = (
        one
        for one in find_cell(study, "even", n_samples)["ratios"]
        if wanted.items() <= one.items()
    )
    return found["ratio"], found["low"], found["high"]


def test_all_large_steps_but_two_survive_bisection():
    # Figure 5, the gallery, the protocol
    (audit,) = load_results("audit_obstacles")
    steps = find_jumps(*load_dataset("obstacles")[:2])
    assert len(steps) == len(confirmed_jumps(audit)) + 2


def test_a_short_piece_is_cut_first_and_other_jumps_stay_inside_charts():
    # Finding the charts
    tasks, policies, _ = load_dataset("obstacles")
    steps = find_jumps(tasks, policies)
    for n_charts in range(2, 7):
        charts = SMCE(n_charts, random_state=0).fit(policies).labels_
        borders = np.flatnonzero(np.diff(charts))
        cut = np.intersect1d(borders, steps).tolist()
        assert cut == ([steps[1]] if n_charts == 3 else [steps[0], steps[1]])


def mean(world, measure, n_samples, method):
    study = one_result(f"study_{world}")
    return find_cell(study, "even", n_samples)["measures"][measure][method]["mean"]


def ahead(world, measure, n_samples, baseline):
    """Return on how many training sets charts err less, and of how many."""
    study = one_result(f"study_{world}")
    return count_ahead(find_cell(study, "even", n_samples), measure, "charts", baseline)


def test_executed_charts_end_nearer_on_13_of_15_training_sets():
    # the first page, the README, Figure 7
    assert ahead("obstacles", "error_cm", 24, "single regression") == (13, 15)
    assert ahead("obstacles", "mse, gate learned", 24, "single regression") == (11, 15)


def test_with_one_kernel_both_end_far_nearer():
    # the first page, the README, Figure 7
    names = "charts", "single regression", "charts, one kernel", "single, one kernel"
    found = [mean("obstacles", "error_cm", 24, name) for name in names]
    assert np.round(found, 1).tolist() == [2.2, 5.6, 0.3, 0.4]


def test_without_obstacles_charts_help_with_all_samples_and_not_with_24():
    # the first page, Figures 2 to 4
    for n_samples, times in ((360, 0.25), (24, 2.0)):
        found, *_ = ratio("free", "mse, gate learned", n_samples, "single regression")
        assert found == pytest.approx(times, rel=0.1)
    assert ahead("free", "error_cm", 24, "single regression") == (15 - 12, 15)


def test_where_what_needs_no_learning_is_better():
    # the first page, the README, Figure 7
    def over(world, measure, baseline, sizes=SIZES):
        return np.array([ratio(world, measure, n, baseline)[0] for n in sizes])

    line, nearest, error = "linear interpolation", "nearest neighbour", "error_cm"
    mse = "mse, gate learned"
    assert (over("obstacles", error, line) > 1).all()
    assert (over("obstacles", mse, line) > 1).tolist() == [True] * 8 + [False] * 2
    for baseline in (line, nearest, "mean policy", "CrKr"):
        assert ahead("obstacles", error, 24, baseline) == (0, 15)
    assert (over("free", mse, line, SIZES[3:-1]) < 1).all()
    assert (over("free", mse, nearest) < 1).all()


def test_nobody_who_executes_nothing_ends_nearer_than_interpolation():
    # the first page
    study = one_result("study_obstacles")
    means = find_cell(study, "even", 24)["measures"]["error_cm"]
    ranked = sorted(means, key=lambda name: means[name]["mean"])
    assert ranked[:2] == ["Mülling's practice", "linear interpolation"]
    assert ranked[0] in study["rollouts"]
    one, other = (means[name]["per_repetition"][:3] for name in ranked[:2])
    assert 0.9 < sum(one) / sum(other) < 1


def test_the_true_pieces_known_leave_a_third_of_the_error():
    # the first page
    told = mean("obstacles", "mse, gate learned", 24, "ladder: pieces, true gate")
    ours = mean("obstacles", "mse, gate learned", 24, "charts")
    assert told / ours == pytest.approx(1 / 3, rel=0.1)


def test_predicting_saves_searching():
    # the first page
    worlds = load_results("savings_free", "savings_obstacles")
    for found, times, tasks in zip(worlds, (100, 3), (25, 36), strict=True):
        near = {
            one["method"]: one["mean_rollouts"]
            for one in found["summary"]
            if one["factor"] == 1.05
        }
        assert near["from scratch"] / near["charts"] == pytest.approx(times, rel=0.02)
        even = {one["method"]: one["tasks"] for one in found["break_even"]}
        assert even["charts"] == tasks
        least = sorted(near, key=near.get)[:3]
    line, nearest = "linear interpolation", "nearest neighbour"
    assert {*least} == {"after Liu: mapped", line, nearest}


def test_without_obstacles_charts_have_the_higher_error_from_12_to_24_tasks():
    # Figure 8
    found = [ratio("free", "mse, gate learned", n, "single regression")[0]
             for n in SIZES]  # fmt: skip
    higher = [n for n, one in zip(SIZES, found, strict=True) if one > 1]
    assert higher == [12, 16, 24]
    assert round(max(found)) == 8
    for n in SIZES:  # and with obstacles both are near each other
        one, *_ = ratio("obstacles", "mse, gate learned", n, "single regression")
        assert 0.65 < one < 1.25


def test_with_the_chart_known_errors_are_a_third_to_four_fifths():
    # Figure 8
    def over(measure, baseline):
        return [ratio("obstacles", measure, n, baseline)[0] for n in SIZES]

    known = over("mse, chart known", "single regression")
    assert 0.32 < min(known) < max(known) < 0.82
    assert round(1 / min(over("mse, chart known", "CrKr"))) == 9
    away = over("mse, away from jumps", "single regression")
    assert max(away) < 1
    assert np.mean(np.less(away, known)) > 0.5


def test_how_both_differ_in_excess_cost_nobody_would_see():
    # Figure 2
    study = one_result("study_free")
    costs = find_cell(study, "even", 360)["measures"]["excess_cost"]
    assert max(costs[name]["mean"] for name in ("charts", "single regression")) < 1e-5


def test_executed_with_obstacles_charts_are_ahead_at_every_size():
    # what an error costs
    found = [ratio("obstacles", "error_cm", n, "single regression")[0] for n in SIZES]
    assert max(found) < 1
    assert (round(1 / max(found)), round(1 / min(found))) == (2, 7)


def test_with_obstacles_the_elbow_depends_on_the_seed_of_k_means():
    # how many charts?
    policies = load_dataset("obstacles")[1]
    picked = {SMCE(random_state=seed).fit(policies).n_clusters_ for seed in range(4)}
    assert picked == {4, 6}


def test_with_none_of_36_better_at_most_some_8_percent_could_be():
    # how good are the policies?
    for audit in load_results("audit_free", "audit_obstacles"):
        assert audit["searched"]["n_cheaper"] == 0
        n = len(audit["searched"]["change_of_cost"])
        assert (n, round(100 * (1 - 0.05 ** (1 / n)))) == (36, 8)


def test_the_protocol_tells_how_often_intervals_hold_the_truth():
    (found,) = load_results("coverage")
    main, others = (pd.DataFrame(found[part]) for part in ("main", "others"))
    page = " ".join((ROOT / "book" / "protocol.md").read_text("utf-8").split())

    def span(rows, what="coverage", kind=found["chosen"], wider=found["wider"]):
        some = rows[(rows["interval"] == kind) & (rows["wider"] == wider)][what]
        return f"{100 * some.min():.0f} to {100 * some.max():.0f} %"

    def other(*names):
        return others[others["condition"].isin(names)]

    assert f"holds the truth in {span(main)} of studies" in page
    assert f"without stretching it would in {span(main, wider=1)}," in page
    before = span(main, kind=found["before"], wider=1)
    assert f"one by one, as this book had it before, in {before}." in page
    heavier = other("heavier tails", "neighbours more alike")
    assert f"more alike ({span(heavier)})" in page
    assert f"three arcs: {span(other('tasks: 30 in three arcs'))})" in page
    twice = main[(main["sets"] == 15) & (main["ratio"] == 0.5)]
    assert f"to be better in {span(twice, 'power')} of" in page
