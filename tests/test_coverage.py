"""How often intervals hold the truth: what is simulated, and what was found."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import bootstrap

from msc.data import load_results
from msc.estimates import N_WAVES, WIDER, Average
from msc.plots import (
    GOOD_COVERAGE,
    coverage_table,
    plot_coverage,
    plot_other_coverage,
)

ROOT = Path(__file__).parents[1]


def load(path):
    """Import a program under another name: "coverage" is also a package."""
    spec = importlib.util.spec_from_file_location("simulated_coverage", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


simulated = load(ROOT / "benchmarks" / "coverage.py")
USUAL = simulated.Scatter(0.3, 1.2, 0.7, 0.88, 0.4)


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return load_results("coverage")[0]


@pytest.fixture(scope="module")
def measured(found):
    return {name: simulated.Scatter(**one) for name, one in found["scatter"].items()}


# What was found


def test_what_is_committed_is_about_the_interval_that_is_used(found):
    assert (found["n_waves"], found["wider"]) == (N_WAVES, WIDER)
    assert found["chosen"] == simulated.CHOSEN
    assert found["n_studies"] == 1000


def test_the_interval_covers_under_every_condition_that_it_must(found):
    rows = pd.DataFrame(found["main"])
    rows = rows[(rows["interval"] == found["chosen"]) & (rows["wider"] == WIDER)]
    asked = {"sets": {1, 10, 15}, "correlation": {0, 0.5, 0.9}, "ratio": {0.5, 0.8, 1}}
    assert {key: {*rows[key]} for key in asked} == asked
    assert len(rows) == 27
    assert rows["coverage"].between(*GOOD_COVERAGE).all()


def test_a_mean_alone_is_covered_as_well_and_has_a_long_interval(found):
    rows = pd.DataFrame(found["means"])
    assert rows["sets"].tolist() == [10, 15]
    assert rows["coverage"].between(*GOOD_COVERAGE).all()
    assert rows["length"].between(50, 70).all()  # the protocol: fifty or more


def test_a_ratio_of_standard_deviations_is_covered_too_seldom(found):
    rows = pd.DataFrame(found["spreads"])
    assert rows["correlation"].tolist() == [0, 0.5, 0.9]
    spans = rows["coverage"].min(), rows["coverage"].max()
    text = "{:.0f} to {:.0f} %".format(*(100 * one for one in spans))
    page = (ROOT / "book" / "how_sure.ipynb").read_text("utf-8")
    assert f"executed errors have them: {text};" in page


def test_every_interval_was_tried_as_it_is_and_stretched(found):
    rows = pd.DataFrame(found["main"])
    tried = {*zip(rows["interval"], rows["wider"], strict=True)}
    assert tried == {(name, x) for name in simulated.CANDIDATES for x in (1, WIDER)}
    assert len(rows) == 27 * len(tried)


def test_it_is_found_again_from_the_same_seed(found, measured):
    conditions = simulated.list_conditions(measured)
    for kind, (part, number) in enumerate([("main", 13), ("others", 30)]):
        condition, names = conditions[kind][number], [simulated.CHOSEN]
        again = simulated.try_intervals(condition, names, 1000, [0, kind, number])
        assert all(row in found[part] for row in again), condition


# What is simulated


def draw(n_studies=300, **changes):
    condition = replace(simulated.Condition("", USUAL, n_sets=4), **changes)
    rng = np.random.default_rng(0)
    return [*simulated.draw_pairs(condition, n_studies, rng)]


@pytest.mark.parametrize("ratio", [1.0, 0.5])
def test_means_have_the_true_ratio(ratio):
    ours, theirs = np.mean([pair.errors for pair in draw(ratio=ratio)], axis=(0, 2, 3))
    assert ours / theirs == pytest.approx(ratio, rel=0.1)


def test_of_one_set_the_truth_is_its_own():
    scatter = simulated.Scatter(0.5, 0.05, 0.05, 0.5, 0.5)  # all but the set is small
    pairs = draw(scatter=scatter, n_sets=1, of_others=False)
    logs = np.array([(simulated.found_in(p), np.log(p.ratio)) for p in pairs])
    assert logs.std() > 0.3
    np.testing.assert_allclose(logs[:, 0], logs[:, 1], atol=0.1)


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_methods_and_neighbours_are_as_alike_as_asked(correlation):
    pairs = draw(correlation=correlation)
    ours, theirs = np.log([pair.errors for pair in pairs]).swapaxes(0, 1).reshape(2, -1)
    assert np.corrcoef(ours, theirs)[0, 1] == pytest.approx(correlation, abs=0.05)
    rng = np.random.default_rng(0)
    errors = np.exp(simulated.draw_round(rng, 1.0, 0.88, 20_000))
    assert np.log(errors).std() == pytest.approx(1, rel=0.01)
    assert errors.mean() == pytest.approx(np.exp(0.5), rel=0.01)
    beside = np.corrcoef(errors[:, 0], errors[:, -1])[0, 1]
    assert beside == pytest.approx(0.88, abs=0.02)


def test_the_scatter_of_what_is_drawn_is_measured_again():
    few = simulated.Scatter(0.3, 0.4, 0.5, 0.6, 0.4)
    again = simulated.measure_again(simulated.Condition("", few, n_sets=60))
    for name, size in vars(few).items():
        assert vars(again)[name] == pytest.approx(size, abs=0.05), name


def test_of_long_tails_one_circle_shows_less_than_there_is(found):
    drawn, again = (found["scatter"][f"drawn{x}"] for x in ("", ", measured again"))
    assert again["tasks"] < 0.8 * drawn["tasks"]
    for name in ("sets", "rest"):
        assert again[name] == pytest.approx(drawn[name], abs=0.05)


def test_weights_are_those_of_the_study():
    for counted, number in (
        ("all", 120), ("60 in six arcs", 60), ("30 in three arcs", 30),
        ("30 in one arc", 30),
    ):  # fmt: skip
        assert simulated.weigh(counted).sum() == number
    density = simulated.weigh("by the density")
    assert density.min() == pytest.approx(0.2, abs=0.001)
    assert density[60] == pytest.approx(1.8, abs=0.001)


# The intervals


def test_the_chosen_one_is_that_of_the_package():
    for counted in ("all", "30 in three arcs"):
        (pair,) = draw(1, counted=counted)
        ours, theirs = (Average(one, pair.weights) for one in pair.errors)
        expected = np.log(ours.over(theirs).bounds) - np.log(ours.over(theirs).value)
        below, above = simulated.CANDIDATES[simulated.CHOSEN](pair)
        np.testing.assert_allclose([-WIDER * below, WIDER * above], expected)


def test_with_one_training_set_the_bootstrap_is_scipy_s():
    (pair,) = draw(1, n_sets=1)
    interval = bootstrap(
        tuple(one[0] for one in pair.errors),
        lambda a, b, axis: np.log(a.mean(axis=axis) / b.mean(axis=axis)),
        paired=True,
        n_resamples=5000,
        method="percentile",
        rng=np.random.default_rng(1),
    ).confidence_interval
    below, above = simulated.CANDIDATES[simulated.BEFORE](pair)
    ends = np.array([-below, above]) + simulated.found_in(pair)
    assert np.ptp(ends) == pytest.approx(np.ptp(interval), rel=0.06)
    assert ends.mean() == pytest.approx(np.mean(interval), abs=0.1 * np.ptp(interval))


@pytest.mark.parametrize(("length", "moving"), [(1, False), (15, False), (30, True)])
def test_a_bootstrap_draws_whole_arcs_and_as_many_tasks(length, moving):
    times = simulated.Bootstrap(length, moving=moving)._tasks
    assert (times.sum(axis=1) == 120).all()
    assert times.mean(axis=0) == pytest.approx(1, abs=0.3)
    ends = np.count_nonzero(np.diff(times, axis=1), axis=1)
    assert ends.max() <= 2 * 120 / length
    at_arcs = {*(1 + np.nonzero(np.diff(times, axis=1))[1] % length)} <= {length}
    assert at_arcs is not moving or length == 1


def test_left_out_one_by_one_it_is_the_jack_knife():
    (pair,) = draw(1, n_sets=1)
    ours, theirs = (one[0].reshape(8, 15) for one in pair.errors)
    logs = [
        np.log(np.delete(ours, arc, 0).mean() / np.delete(theirs, arc, 0).mean())
        for arc in range(8)
    ]
    error = np.sqrt(7 / 8 * np.sum((logs - np.mean(logs)) ** 2))
    below, above = simulated.leave_out(pair)
    assert below == above == pytest.approx(2.3646 * error, rel=1e-4)  # t of seven


def test_intervals_are_judged_by_the_truth_and_by_one():
    rows = np.array([[0.0, 0.5, 0.3, 0.3], [1.0, 0.5, 0.3, 0.3]])
    assert simulated.judge(rows, 1.0) == {
        "coverage": 0, "length": pytest.approx(np.exp(0.6), rel=1e-3), "power": 0.5
    }  # fmt: skip
    assert simulated.judge(rows, 2.0)["coverage"] == 1


# How it is shown


def test_every_condition_is_a_mark(found):
    left, right = plot_coverage(found).axes
    marks = {line.get_label(): len(line.get_xdata()) for line in left.lines}
    n_kinds = len(simulated.CANDIDATES)
    assert marks["as it is"] == marks[f"stretched, {WIDER:g} ×"] == 27 * n_kinds
    assert [len(line.get_xdata()) for line in right.lines] == [n_kinds] * 3
    (axis,) = plot_other_coverage(found).axes
    marks = {line.get_label(): len(line.get_xdata()) for line in axis.lines}
    assert marks["before"] == marks["now"] == len(found["others"]) / 4


def test_the_table_has_the_range_and_the_power(found):
    row = coverage_table(found).loc[found["chosen"], f"{WIDER:g} ×"]
    rows = pd.DataFrame(found["main"])
    rows = rows[(rows["interval"] == found["chosen"]) & (rows["wider"] == WIDER)]
    least, most = rows["coverage"].min(), rows["coverage"].max()
    assert row["coverage"] == f"{least:.1%} to {most:.1%}"
    usual = rows[(rows["sets"] == 15) & (rows["ratio"] == 0.5)].set_index("correlation")
    shares = [f"{usual.loc[one, 'power']:.0%}" for one in (0, 0.5, 0.9)]
    assert row["decides at 0.5"] == " / ".join(shares)
