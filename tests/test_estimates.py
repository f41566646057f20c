"""Ratios and their intervals; what becomes of intervals that are combined."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import bootstrap

from msc.estimates import (
    Estimate,
    Resamples,
    average,
    bonferroni,
    compare,
    difference,
    quotient,
)

rng = np.random.default_rng(0)
difficulty = rng.lognormal(0, 2, size=60)  # of the task, for all methods alike
noise = rng.lognormal(0, 0.1, size=(2, 60))
errors = pd.DataFrame(
    {"good": difficulty * noise[0], "bad": 1.5 * difficulty * noise[1]}
)


def compared(method, baseline, errors=errors, **options):
    return compare("error", errors, method, baseline, **options)


def test_the_ratio_is_that_of_the_means():
    found = compared("good", "bad")
    assert found.value == pytest.approx(errors["good"].mean() / errors["bad"].mean())
    assert found.low < found.value < found.high


@pytest.mark.parametrize(
    ("method", "baseline", "verdict"),
    [
        ("good", "bad", "lower"),
        ("bad", "good", "higher"),
        ("good", "good", "undecided"),
    ],
)
def test_verdicts(method, baseline, verdict):
    assert compared(method, baseline).verdict == verdict


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (0.5, 0.9, "lower"),
        (0.5, 1.0, "undecided"),
        (0.9, 1.1, "undecided"),
        (1.0, 2.0, "undecided"),
        (1.1, 2.0, "higher"),
    ],
)
def test_a_verdict_needs_the_whole_interval(low, high, verdict):
    assert Estimate(1.0, low, high).verdict == verdict


@pytest.mark.parametrize("baseline", [[-0.15, -0.05], [0.0, 0.0]])
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_a_ratio_to_what_is_not_positive_decides_nothing(baseline):
    found = compare("excess", {"a": [0.1, 0.3], "b": baseline}, "a", "b")
    assert found.verdict == "undecided"


def test_the_same_tasks_are_compared_with_each_other():
    shuffled = errors.assign(bad=rng.permutation(errors["bad"]))
    paired, unpaired = (compared("good", "bad", table) for table in (errors, shuffled))
    assert paired.value == pytest.approx(unpaired.value)
    assert paired.high - paired.low < 0.3 * (unpaired.high - unpaired.low)


@settings(max_examples=10, deadline=None)
@given(st.floats(1e-3, 1e3))
def test_units_do_not_matter(unit):
    scaled, found = compared("good", "bad", unit * errors), compared("good", "bad")
    assert scaled.value == pytest.approx(found.value)
    assert (scaled.low, scaled.high) == pytest.approx((found.low, found.high))


def test_the_interval_is_a_function_of_the_seed():
    assert compared("good", "bad", seed=1) == compared("good", "bad", seed=1)
    assert compared("good", "bad", seed=1) != compared("good", "bad", seed=2)


def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    covered = 0
    for seed in range(100):
        drawn = np.random.default_rng(seed).exponential([1.0, 2.0], size=(60, 2))
        table = pd.DataFrame(drawn, columns=["a", "b"])
        found = compared("a", "b", table, n_resamples=200)
        covered += found.low <= 0.5 <= found.high
    assert 85 <= covered <= 100


# Against others' intervals


def ratio_of_means(top, bottom, axis):
    return top.mean(axis=axis) / bottom.mean(axis=axis)


def ratio_of_spreads(top, bottom, axis):
    return top.std(axis=axis, ddof=1) / bottom.std(axis=axis, ddof=1)


@pytest.mark.parametrize(
    ("spread", "statistic"), [(False, ratio_of_means), (True, ratio_of_spreads)]
)
def test_with_one_training_set_it_is_scipy_s_interval(spread, statistic):
    interval = bootstrap(
        (errors["good"], errors["bad"]),
        statistic,
        paired=True,
        n_resamples=5_000,
        method="percentile",
        rng=np.random.default_rng(1),
    ).confidence_interval
    found = compared("good", "bad", spread=spread, n_resamples=5_000)
    np.testing.assert_allclose(found.value, statistic(*errors.to_numpy().T, axis=0))
    np.testing.assert_allclose([found.low, found.high], interval, rtol=0.03)
    table = {name: values.to_numpy()[None] for name, values in errors.items()}
    assert compared("good", "bad", table, spread=spread, n_resamples=5_000) == found


def test_the_variance_of_a_mean_is_that_of_the_pigeonhole_bootstrap():
    n_sets, n_tasks = 7, 11
    values = rng.normal(size=(n_sets, 1)) + 2 * rng.normal(size=n_tasks)
    values += 0.5 * rng.normal(size=(n_sets, n_tasks))
    draws = Resamples(values.shape, n_resamples=50_000)
    found = draws.average(draws.per_set(values))[1:]
    rows, columns = values.mean(axis=1), values.mean(axis=0)
    rest = values - rows[:, None] - columns + values.mean()
    expected = rows.var() / n_sets + columns.var() / n_tasks
    expected += rest.var() / (n_sets * n_tasks)  # exactly, over all resamples
    assert found.mean() == pytest.approx(values.mean(), abs=0.02)
    assert found.var() == pytest.approx(expected, rel=0.04)


def test_averages_are_those_of_the_sets_and_tasks_drawn():
    values, weights = rng.exponential(size=(3, 5)), rng.uniform(1, 2, size=5)
    draws = Resamples(values.shape, n_resamples=20)
    for spread in (False, True):
        per_set = draws.per_set(values, spread=spread)
        averages = draws.average(per_set)
        for sets, tasks, found in zip(draws._sets, draws._tasks, averages, strict=True):
            drawn = values[np.repeat(range(3), sets.astype(int))]
            drawn = drawn[:, np.repeat(range(5), tasks.astype(int))]
            if spread:  # resampled tasks, but the sample's own correction of n - 1
                expected = drawn.std(axis=1).mean() * np.sqrt(5 / 4)
            else:
                expected = drawn.mean()
            assert found == pytest.approx(expected)
    weighted = draws.per_set(values, weights)[0]
    np.testing.assert_allclose(weighted, np.average(values, axis=1, weights=weights))


def test_weights_are_repeated_tasks():
    values = {"a": rng.exponential(size=(4, 6)), "b": rng.exponential(size=(4, 6))}
    counts = np.array([1, 2, 1, 3, 1, 1])
    repeated = {name: np.repeat(e, counts, axis=1) for name, e in values.items()}
    assert compared("a", "b", values, weights=counts).value == pytest.approx(
        compared("a", "b", repeated).value
    )


@pytest.mark.parametrize(("n_sets", "at_least"), [(5, 72), (25, 88)])
def test_the_interval_covers_other_training_sets_too(n_sets, at_least):
    covered, narrow = 0, 0
    for seed in range(100):
        draws = np.random.default_rng(seed)
        of_set = draws.gamma(4, 1 / 4, size=(2, n_sets, 1))  # luck of the training set
        of_task = draws.exponential(1, size=40)
        both = np.array([[[1]], [[2]]]) * of_set * of_task
        table = dict(zip("ab", both, strict=True))
        found = compared("a", "b", table, n_resamples=200)
        covered += found.low <= 0.5 <= found.high
        pooled = {name: values.mean(axis=0) for name, values in table.items()}
        found = compared("a", "b", pooled, n_resamples=200)
        narrow += found.low <= 0.5 <= found.high
    assert covered >= at_least
    assert narrow < 30  # what leaving the training sets out would cost


ones = np.ones((3, 4))


@pytest.mark.parametrize(
    ("table", "options", "complaint"),
    [
        ({"a": ones}, {}, r"no errors of 'b'; there are those of \['a'\]"),
        ({"a": ones, "b": ones[:, 1:]}, {}, r"\(3, 4\), those of 'b' \(3, 3\); wanted"),
        ({"a": ones, "b": ones[0]}, {}, r"\(3, 4\), those of 'b' \(1, 4\); wanted"),
        ({"a": ones[None], "b": ones}, {}, r"'a' have shape \(1, 3, 4\); wanted"),
        ({"a": [], "b": []}, {}, r"'a' have shape \(0,\); wanted"),
        ({"a": ones, "b": ones}, {"weights": [1]}, r"weights have shape \(1,\); wan"),
        ({"a": ones, "b": ones}, {"weights": ones}, r"weights have shape \(3, 4\);"),
        ({"a": ones, "b": ones}, {"n_resamples": 0}, "n_resamples=0; wanted at lea"),
        ({"a": ones, "b": ones}, {"n_resamples": 2.5}, r"n_resamples=2\.5; wanted at"),
    ],
)
def test_shapes_that_do_not_fit_are_named(table, options, complaint):
    with pytest.raises(ValueError, match=complaint):
        compared("a", "b", table, **options)


def test_it_is_said_in_a_sentence():
    found = Estimate(0.5, 0.25, 0.75, "MSE", "mean")
    sentence = "MSE: 0.5 [0.25, 0.75] × mean: lower"
    assert str(found) == repr(found) == sentence


# Combined: against simulation, and by their properties

positive = st.floats(1e-3, 1e3)
factors = st.floats(1.0, 10.0)


@st.composite
def estimates(draw):
    value = draw(positive)
    return Estimate(value, value / draw(factors), value * draw(factors), "n = 8")


def test_the_interval_of_a_quotient_covers_as_often_as_it_says():
    seeded = np.random.default_rng(0)
    scales, truths = (0.1, 0.2), (3.0, 2.0)
    covered = 0
    for _ in range(2_000):
        drawn = np.log(truths) + scales * seeded.standard_normal(2)
        top, bottom = (
            Estimate(*np.exp([value, value - 1.96 * scale, value + 1.96 * scale]))
            for value, scale in zip(drawn, scales, strict=True)
        )
        low, high = quotient(top, bottom).bounds
        covered += low <= 1.5 <= high
    assert covered / 2_000 == pytest.approx(0.95, abs=0.015)


@settings(max_examples=30, deadline=None)
@given(estimates(), estimates())
def test_a_quotient_turned_round_is_the_inverse(one, other):
    forth, back = quotient(one, other), quotient(other, one)
    assert forth.value * back.value == pytest.approx(1)
    assert forth.low * back.high == pytest.approx(1)
    assert forth.label == "n = 8"


@settings(max_examples=30, deadline=None)
@given(estimates(), estimates())
def test_a_difference_is_wider_than_either(one, other):
    found = difference(one, other)
    width = max(one.high - one.low, other.high - other.low)
    assert found.low <= found.value <= found.high
    assert found.high - found.low >= width * (1 - 1e-9)


def test_what_is_exact_only_scales_the_other():
    assert quotient(Estimate(4.0, -2.0, 6.0), Estimate(2.0)) == Estimate(2.0, -1.0, 3.0)
    assert quotient(Estimate(4.0), Estimate(2.0)) == Estimate(2.0)
    assert difference(Estimate(5.0), Estimate(2.0)) == Estimate(3.0)
    assert difference(Estimate(5.0, 4.0, 6.0), Estimate(2.0)) == Estimate(3.0, 2.0, 4.0)


def test_a_quotient_of_what_may_be_zero_is_refused():
    with pytest.raises(ValueError, match=r"1 \[−1, 2\]: wanted positive numbers"):
        quotient(Estimate(1.0, -1.0, 2.0), Estimate(1.0, 0.5, 2.0))


def test_exact_numbers_have_an_exact_average():
    assert average([Estimate(3.0), Estimate(5.0)], geometric=False) == Estimate(4.0)
    assert np.isnan(average([], geometric=True).value)
    with pytest.raises(ValueError, match="-1: wanted positive numbers"):
        average([Estimate(1.0, -1.0, 2.0)], geometric=True)


def test_averages_keep_the_widest_interval():
    same = [Estimate(2.0, 1.0, 4.0)] * 5
    assert str(average(same, geometric=True)) == "2 [1, 4]"
    two = [Estimate(1.0, 0.0, 2.0), Estimate(3.0, 2.0, 6.0)]
    assert average(two, geometric=False) == Estimate(2.0, 1.0, 4.0)


@settings(max_examples=30, deadline=None)
@given(estimates(), st.integers(2, 50))
def test_more_looks_widen_an_interval(estimate, n_looks):
    assert bonferroni(estimate, 1).bounds == pytest.approx(estimate.bounds)
    wider = bonferroni(estimate, n_looks)
    assert wider.value == pytest.approx(estimate.value)
    assert 0 < wider.low <= estimate.low * (1 + 1e-9)
    assert wider.high >= estimate.high * (1 - 1e-9)


def test_widening_without_interval_or_through_zero():
    assert bonferroni(Estimate(4.0), 20) == Estimate(4.0)
    low, high = bonferroni(Estimate(0.0, -1.0, 2.0), 20).bounds
    assert (low, high) == pytest.approx((-1.543, 3.085), abs=1e-3)


def test_numbers_are_said_to_three_digits():
    assert str(Estimate(2336.4, 0.12345, 1e6)) == "2,340 [0.123, 1e+06]"
    assert str(Estimate(-4)) == "−4"


@settings(max_examples=30, deadline=None)
@given(estimates())
def test_what_is_stored_is_read_again_to_six_digits(estimate):
    again = Estimate.read(estimate.stored("mean"), "mean")
    assert again.value == pytest.approx(estimate.value, rel=1e-5)
    assert again.bounds == pytest.approx(estimate.bounds, rel=1e-5)
    assert again.stored("mean") == estimate.stored("mean")
    assert Estimate(3.0).stored("n") == {"n": 3.0, "low": None, "high": None}
