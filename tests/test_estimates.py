"""Ratios and their intervals; what becomes of intervals that are combined."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import t

from msc.estimates import (
    N_WAVES,
    WIDER,
    Average,
    Estimate,
    _find_waves,
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
def test_a_ratio_to_what_is_not_positive_decides_nothing(baseline):
    found = compare("excess", {"a": [0.1, 0.3], "b": baseline}, "a", "b")
    assert found.verdict == "undecided"


def test_the_same_tasks_are_compared_with_each_other():
    shuffled = errors.assign(bad=rng.permutation(errors["bad"]))
    paired, unpaired = (compared("good", "bad", table) for table in (errors, shuffled))
    assert paired.value == pytest.approx(unpaired.value)
    assert paired.high - paired.low < 0.3 * (unpaired.high - unpaired.low)


# The interval: against a calculation by hand, and by its properties

tables = arrays(float, st.tuples(st.integers(1, 4), st.integers(5, 9)),
                elements=st.floats(0.01, 100))  # fmt: skip


def ends_by_hand(influence):
    """Ends of an interval: two waves round the circle, Satterthwaite, Student's t."""
    n_sets, n_tasks = influence.shape
    of_task, of_set = influence.mean(axis=0), influence.mean(axis=1)
    angles = 2 * np.pi * np.arange(n_tasks) / n_tasks
    squares = [
        np.mean(of_task * shape(k * angles)) ** 2
        for k in (1, 2)
        for shape in (np.cos, np.sin)
    ]
    # Of noise of variance s² each such mean has the variance s²/2n, the mean s²/n.
    tasks = 2 * np.mean(squares)
    sets = np.sum((of_set - of_set.mean()) ** 2) / (n_sets - 1) / n_sets
    both = tasks + sets
    freedom = both**2 / (tasks**2 / 4 + sets**2 / (n_sets - 1))
    return WIDER * np.sqrt(both) * np.array(t.interval(0.95, freedom))


def test_the_interval_is_that_by_hand():
    assert N_WAVES == 2
    a, b = rng.exponential(size=(2, 6, 15))
    found = compared("a", "b", {"a": a, "b": b})
    ends = ends_by_hand(a / a.mean() - b / b.mean())
    np.testing.assert_allclose(np.log(found.bounds), np.log(found.value) + ends)
    found, ends = Average(a).estimate, ends_by_hand(a / a.mean())
    np.testing.assert_allclose(np.log(found.bounds), np.log(a.mean()) + ends)
    found, ends = Average(a - 1).estimate, ends_by_hand(a)
    np.testing.assert_allclose(found.bounds, a.mean() - 1 + ends)


def test_of_independent_errors_it_is_the_variance_of_their_mean():
    shares = np.full(40, 1 / 40)
    drawn = rng.normal(0, 3, size=(5000, 1, 40))
    found = [np.mean(np.abs(_find_waves(one, shares)) ** 2) for [one] in drawn]
    assert np.mean(found) == pytest.approx(9 / 40, rel=0.03)
    # A chi-squared of four degrees of freedom has the variance 2/4 of its square mean.
    assert np.var(found) == pytest.approx(np.mean(found) ** 2 / 2, rel=0.1)


@pytest.mark.parametrize("spread", [False, True])
def test_an_influence_is_what_a_task_adds(spread):
    values, step = rng.exponential(size=(3, 8)), 1e-6
    found = Average(values, spread=spread)
    slopes = []
    for task in range(8):
        weights = np.ones(8)
        weights[task] += 8 * step
        moved = Average(values, weights / weights.sum(), spread=spread).value
        slopes.append((moved - found.value) / step)
    waves = _find_waves(np.array(slopes), np.full(8, 1 / 8))
    np.testing.assert_allclose(found.waves, waves, rtol=1e-4, atol=1e-4)


@settings(max_examples=30, deadline=None)
@given(tables, st.integers(1, 8), st.floats(1e-3, 1e3))
def test_neither_units_nor_where_the_circle_begins_matter(values, shift, unit):
    one = {"a": values, "b": values[:, ::-1]}
    other = {key: unit * np.roll(some, shift, axis=1) for key, some in one.items()}
    found, expected = compared("a", "b", other), compared("a", "b", one)
    assert found.value == pytest.approx(expected.value)
    assert found.bounds == pytest.approx(expected.bounds, rel=1e-6)


@settings(max_examples=30, deadline=None)
@given(tables)
def test_turned_round_it_is_the_inverse(values):
    table = {"a": values, "b": values[:, ::-1]}
    forth, back = compared("a", "b", table), compared("b", "a", table)
    assert forth.value * back.value == pytest.approx(1)
    assert forth.low * back.high == pytest.approx(1)
    assert compared("a", "a", table) == Estimate(1.0, 1.0, 1.0, "error", "a")


@settings(max_examples=30, deadline=None)
@given(tables, st.booleans())
def test_tasks_without_weight_may_be_left_out(values, spread):
    weights = np.arange(values.shape[1]) % 3
    found = Average(values, weights, spread=spread).estimate
    left = Average(values[:, weights > 0], weights[weights > 0], spread=spread).estimate
    assert found.value == pytest.approx(left.value)
    assert found.bounds == pytest.approx(left.bounds)


def test_weights_are_repeated_tasks():
    values = {"a": rng.exponential(size=(4, 6)), "b": rng.exponential(size=(4, 6))}
    counts = np.array([1, 2, 1, 3, 1, 1])
    repeated = {name: np.repeat(e, counts, axis=1) for name, e in values.items()}
    assert compared("a", "b", values, weights=counts).value == pytest.approx(
        compared("a", "b", repeated).value
    )


def test_a_spread_is_the_mean_of_standard_deviations():
    values = rng.exponential(size=(3, 7))
    found = Average(values, spread=True)
    np.testing.assert_allclose(found.per_set, values.std(axis=1, ddof=1))
    assert found.value == pytest.approx(found.per_set.mean())
    assert Average(np.ones((3, 7)), spread=True).estimate == Estimate(0.0, 0.0, 0.0)


def test_a_share_stays_between_none_and_all():
    hits = rng.random((5, 30)) < 0.1
    found, missed = Average(hits).estimate, Average(~hits).estimate
    assert 0 < found.low < found.value < found.high < 1
    low, high = found.bounds
    assert missed.bounds == pytest.approx((1 - high, 1 - low))
    for all_alike in (np.zeros((2, 3), bool), np.ones((2, 3), bool)):
        found = Average(all_alike, [1, 2, 7]).estimate
        assert found.bounds == pytest.approx((found.value, found.value))


def test_errors_of_either_sign_have_an_interval_round_their_mean():
    values = rng.normal(size=(4, 20))
    found, moved = Average(values).estimate, Average(values - 7).estimate
    assert found.value - found.low == pytest.approx(found.high - found.value)
    assert np.subtract(found.bounds, moved.bounds) == pytest.approx(7)
    assert np.isfinite(Average(values - values.mean()).estimate.bounds).all()


def test_one_task_or_one_set_tells_nothing_of_others():
    values = rng.exponential(size=(4, 1))
    assert Average(values[:1]).estimate.bounds == (values[0, 0], values[0, 0])
    alone = Average(values).estimate
    assert alone.low < alone.value < alone.high
    padded = np.hstack([values, values + 1])
    assert Average(padded, [1, 0]).estimate == alone


@pytest.mark.parametrize("spread", [False, True])
def test_what_is_stored_divides_as_what_was_measured(spread):
    one, other = (
        Average(values, spread=spread)
        for values in rng.lognormal(0, 1, size=(2, 7, 40))
    )
    again, others = (Average.read(average.stored()) for average in (one, other))
    for found, wanted in [
        (again.over(others), one.over(other)),
        (again.over(other), one.over(other)),
        (again.estimate, one.estimate),
    ]:
        assert found.value == pytest.approx(wanted.value, rel=1e-5)
        assert found.bounds == pytest.approx(wanted.bounds, rel=1e-4)


def test_other_training_sets_are_not_paired():
    sets = np.linspace(1, 2, 10)[:, np.newaxis] * np.ones((10, 6))
    every, fewer = Average(sets), Average(sets[:-1])
    same, apart = every.over(every), every.over(fewer)
    assert same.bounds == (1, 1)
    assert apart.low < apart.value < apart.high
    # Two independent means: their variances add up, as do those of their logarithms.
    variances = [x.per_set.var(ddof=1) / len(x.per_set) / x.value**2
                 for x in (every, fewer)]  # fmt: skip
    freedom = sum(variances) ** 2 / (variances[0] ** 2 / 9 + variances[1] ** 2 / 8)
    half = WIDER * t.ppf(0.975, freedom) * np.sqrt(sum(variances))
    assert np.log(apart.high / apart.value) == pytest.approx(half)


def draw_smooth(seed, n_sets):
    """Draw errors of two methods, alike among ten neighbours; the ratio is a half."""
    drawn = np.random.default_rng(seed)
    of_set = drawn.gamma(4, 1 / 4, size=(2, n_sets, 1))
    white = drawn.exponential(1, size=(2, 1, 120))
    of_task = np.mean([np.roll(white, k, axis=2) for k in range(10)], axis=0)
    return np.array([[[1]], [[2]]]) * of_set * of_task


@pytest.mark.parametrize("n_sets", [1, 5, 25])
def test_the_interval_covers_other_tasks_and_other_sets(n_sets):
    covered = narrow = 0
    for seed in range(100):
        a, b = draw_smooth(seed, n_sets)
        truth = 0.5
        if n_sets == 1:  # it is of that set
            luck = np.random.default_rng(seed).gamma(4, 1 / 4, size=(2, 1, 1)).ravel()
            truth *= luck[0] / luck[1]
        low, high = compared("a", "b", {"a": a, "b": b}).bounds
        covered += low <= truth <= high
        apart = (a / a.mean() - b / b.mean()).mean(axis=0)
        half = 1.96 * apart.std() / np.sqrt(120)  # as if tasks were independent
        narrow += abs(np.log(a.mean() / b.mean() / truth)) < half
    assert covered >= 95  # stretched for longer tails than these
    assert narrow < 75


ones = np.ones((3, 4))


@pytest.mark.parametrize(
    ("table", "options", "complaint"),
    [
        ({"a": ones}, {}, r"no errors of 'b'; there are those of \['a'\]"),
        ({"a": ones, "b": ones[:, 1:]}, {}, r"\(3, 4\), of 'b' \(3, 3\); wanted"),
        ({"a": ones, "b": ones[0]}, {}, r"\(3, 4\), of 'b' \(4,\); wanted the same"),
        (
            {"a": ones[None], "b": ones[None]},
            {},
            r"errors have shape \(1, 3, 4\); wanted",
        ),
        ({"a": [], "b": []}, {}, r"errors have shape \(0,\); wanted"),
        ({"a": ones, "b": ones}, {"weights": [1]}, r"weights have shape \(1,\); wan"),
        ({"a": ones, "b": ones}, {"weights": ones}, r"weights have shape \(3, 4\);"),
        ({"a": ones, "b": ones}, {"weights": [0] * 4}, "weights from 0 to 0; wanted"),
        ({"a": ones, "b": ones}, {"weights": [2, 1, 1, -1]}, "weights from -1 to 2; w"),
    ],
)
def test_what_does_not_fit_is_named(table, options, complaint):
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
    assert (low, high) == pytest.approx((-2.434, 4.868), abs=1e-3)


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
