"""Intervals of combined numbers, against simulation and by their properties."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc.estimates import Estimate, average, bonferroni, difference, quotient

positive = st.floats(1e-3, 1e3)
factors = st.floats(1.0, 10.0)


@st.composite
def effects(draw):
    value = draw(positive)
    return Estimate(value, value / draw(factors), value * draw(factors), "n = 8")


def test_the_interval_of_a_quotient_covers_as_often_as_it_says():
    rng = np.random.default_rng(0)
    scales, truths = (0.1, 0.2), (3.0, 2.0)
    covered = 0
    for _ in range(2_000):
        drawn = np.log(truths) + scales * rng.standard_normal(2)
        top, bottom = (
            Estimate(*np.exp([value, value - 1.96 * scale, value + 1.96 * scale]))
            for value, scale in zip(drawn, scales, strict=True)
        )
        low, high = quotient(top, bottom).bounds
        covered += low <= 1.5 <= high
    assert covered / 2_000 == pytest.approx(0.95, abs=0.015)


@settings(max_examples=30, deadline=None)
@given(effects(), effects())
def test_a_quotient_turned_round_is_the_inverse(one, other):
    forth, back = quotient(one, other), quotient(other, one)
    assert forth.value * back.value == pytest.approx(1)
    assert forth.low * back.high == pytest.approx(1)
    assert forth.label == "n = 8"


@settings(max_examples=30, deadline=None)
@given(effects(), effects())
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
@given(effects(), st.integers(2, 50))
def test_more_looks_widen_an_interval(effect, n_looks):
    assert bonferroni(effect, 1).bounds == pytest.approx(effect.bounds)
    wider = bonferroni(effect, n_looks)
    assert wider.value == pytest.approx(effect.value)
    assert 0 < wider.low <= effect.low * (1 + 1e-9)
    assert wider.high >= effect.high * (1 - 1e-9)


def test_widening_without_interval_or_through_zero():
    assert bonferroni(Estimate(4.0), 20) == Estimate(4.0)
    low, high = bonferroni(Estimate(0.0, -1.0, 2.0), 20).bounds
    assert (low, high) == pytest.approx((-1.543, 3.085), abs=1e-3)


def test_numbers_are_said_to_three_digits():
    assert str(Estimate(2336.4, 0.12345, 1e6)) == "2,340 [0.123, 1e+06]"
    assert str(Estimate(-4)) == "−4"
