"""Sentences of the book that stand without a cell beside them: the data say the same.

Each test is named after what is said; its first line says where.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from msc import SMCE, find_jumps, load_dataset
from msc.data import load_results
from msc.plots import confirmed_jumps
from msc.study import find_cell

ROOT = Path(__file__).parents[1]
SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def ratio(world, measure, n_samples, baseline, method="charts"):
    """Return the charts' mean over another method's, with its interval."""
    (study,) = load_results(f"study_{world}")
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


@pytest.mark.parametrize(
    ("baseline", "method"),
    [("single regression", "charts"), ("single, Matérn", "charts, Matérn")],
)
def test_charts_end_two_to_three_times_nearer(baseline, method):
    # the first page, the README, Figure 7
    found, _, high = ratio("obstacles", "error_cm", 24, baseline, method)
    assert round(1 / found) in (2, 3)
    assert high < 1


@pytest.mark.parametrize("measure", ["error_cm", "excess_cost"])
@pytest.mark.parametrize(
    "baseline", ["CrKr", "nearest neighbour", "linear interpolation", "mean policy"]
)
def test_simpler_methods_are_better_than_both(measure, baseline):
    # the first page, the README, Figure 7
    _, low, _ = ratio("obstacles", measure, 24, baseline)
    assert low > 1


def test_where_what_needs_no_learning_is_better():
    # the first page
    def bounds(world, measure, baseline):
        return np.array([ratio(world, measure, n, baseline) for n in SIZES])

    line, nearest = "linear interpolation", "nearest neighbour"
    assert (bounds("obstacles", "mse, gate learned", line)[:, 2] > 1).all()
    assert (bounds("obstacles", "error_cm", line)[:, 1] > 1).all()
    assert (bounds("free", "mse, gate learned", nearest)[:, 2] < 1).all()
    middle = [SIZES.index(n) for n in (24, 36, 50)]
    assert (bounds("free", "mse, gate learned", line)[middle, 2] < 1).all()
    for baseline in (line, nearest):
        assert (bounds("free", "error_cm", baseline)[middle, 1] > 1).all()


def test_with_the_chart_known_errors_are_a_third_to_four_fifths():
    # Figure 8
    def over(measure, baseline):
        return [ratio("obstacles", measure, n, baseline)[0] for n in SIZES]

    known = over("mse, chart known", "single regression")
    assert 0.32 < min(known) < max(known) < 0.82
    assert 0.09 < min(over("mse, chart known", "CrKr")) < 0.12
    away = over("mse, away from jumps", "single regression")
    assert max(away) < 1
    assert np.mean(np.less(away, known)) > 0.5


def test_how_both_differ_in_excess_cost_nobody_would_see():
    # Figure 2
    (study,) = load_results("study_free")
    costs = find_cell(study, "even", 360)["measures"]["excess_cost"]
    assert max(costs[name]["mean"] for name in ("charts", "single regression")) < 1e-5


@pytest.mark.parametrize(
    ("baseline", "method"),
    [("single regression", "charts"), ("single, Matérn", "charts, Matérn")],
)
def test_executed_charts_are_better_at_nearly_every_size(baseline, method):
    # what an error costs
    found = [ratio("obstacles", "error_cm", n, baseline, method)[2] for n in SIZES]
    assert np.mean(np.less(found, 1)) >= 0.9


def test_with_obstacles_the_elbow_depends_on_the_seed_of_k_means():
    # how many charts?
    policies = load_dataset("obstacles")[1]
    picked = {SMCE(random_state=seed).fit(policies).n_clusters_ for seed in range(6)}
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
