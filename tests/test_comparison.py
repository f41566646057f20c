import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc.comparison import Comparison, compare

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
    assert found.ratio == pytest.approx(errors["good"].mean() / errors["bad"].mean())
    assert found.low < found.ratio < found.high


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
    assert Comparison("error", "a", "b", 1.0, low, high).verdict == verdict


def test_the_same_tasks_are_compared_with_each_other():
    shuffled = errors.assign(bad=rng.permutation(errors["bad"]))
    paired, unpaired = (compared("good", "bad", table) for table in (errors, shuffled))
    assert paired.ratio == pytest.approx(unpaired.ratio)
    assert paired.high - paired.low < 0.3 * (unpaired.high - unpaired.low)


@settings(max_examples=10, deadline=None)
@given(st.floats(1e-3, 1e3))
def test_units_do_not_matter(unit):
    scaled, found = compared("good", "bad", unit * errors), compared("good", "bad")
    assert scaled.ratio == pytest.approx(found.ratio)
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


def test_it_is_said_in_a_sentence():
    found = Comparison("MSE", "charts", "mean", 0.5, 0.25, 0.75)
    sentence = "MSE: 0.50 × mean [0.25, 0.75]: lower"
    assert str(found) == repr(found) == sentence
