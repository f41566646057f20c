"""Average ranks, and how far apart they must be: against SciPy and published tables."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f, friedmanchisquare, rankdata

from msc.plots import plot_ranks
from msc.study import Ranks, critical_difference, rank_methods
from msc.study._ranks import correlate_neighbours, friedman, rank_blocks
from msc.study._store import Trials

# Table 5 (a) of Demšar 2006: the quantiles at 5 % by the number of methods.
DEMSAR = dict(
    zip(
        range(2, 11),
        (1.960, 2.343, 2.569, 2.728, 2.850, 2.949, 3.031, 3.102, 3.164),
        strict=True,
    )
)
SMALL = {"measures": ("error_cm",), "sizes": (12,)}


@pytest.mark.parametrize("n_methods", DEMSAR)
def test_critical_differences_are_those_of_the_published_table(n_methods):
    unit = np.sqrt(n_methods * (n_methods + 1) / (6 * 14))
    found = critical_difference(n_methods, 14) / unit
    assert found == pytest.approx(DEMSAR[n_methods], abs=1e-3)


def test_the_example_of_demsar():
    assert critical_difference(4, 14) == pytest.approx(1.25, abs=0.005)
    assert critical_difference(4, 14, 0.1) == pytest.approx(1.12, abs=0.005)


@pytest.mark.parametrize(
    ("name", "given"), [("n_methods", (1, 9)), ("n_blocks", (3, 0))]
)
def test_too_few_are_refused(name, given):
    with pytest.raises(ValueError, match=rf"{name}={min(given)}"):
        critical_difference(*given)


def test_with_one_condition_ranks_are_scipys():
    errors = np.random.default_rng(0).random((1, 6, 5))
    np.testing.assert_array_equal(rank_blocks(errors), rankdata(errors[0], axis=1))


def test_conditions_are_joined_by_their_ranks_and_not_by_their_size():
    # A is first in two of three conditions, though its one bad error is a million.
    errors = [[[1, 2, 3]], [[1e6, 2, 3]], [[1, 3, 2]]]
    np.testing.assert_array_equal(rank_blocks(errors), [[1, 2, 3]])  # 5/3, 2, 7/3
    np.testing.assert_array_equal(rank_blocks([[[1, 1, 0]]]), [[2.5, 2.5, 1]])


def test_friedmans_test_is_scipys_with_the_correction_of_iman_and_davenport():
    errors = np.random.default_rng(1).random((12, 4)) + np.array([0, 0.1, 0.2, 0.4])
    square = friedmanchisquare(*errors.T).statistic
    corrected = 11 * square / (12 * 3 - square)
    wanted = f.sf(corrected, 3, 33)
    assert friedman(rankdata(errors, axis=1)) == pytest.approx(wanted)
    assert friedman(np.tile([1.0, 2.0, 3.0], (5, 1))) == 0


def test_independent_blocks_correlate_as_independent_draws_do():
    rng = np.random.default_rng(2)
    circles = [rank_blocks(rng.random((1, 8, 30))) for _ in range(40)]
    assert correlate_neighbours(circles) == pytest.approx(-1 / 7, abs=0.03)
    assert correlate_neighbours([np.repeat(one, 4, axis=0) for one in circles]) > 0.6


def trials(**errors):
    """Make what methods did, each on sets of 16 test tasks."""
    return {
        name: Trials({}, {"even/12/error_cm": np.asarray(one, dtype=np.float32)})
        for name, one in errors.items()
    }


def test_methods_are_ranked_arc_by_arc_on_the_sets_that_all_have():
    left, right = np.repeat([[1.0, 0.0], [0.0, 1.0]], 8, axis=1)
    more = np.array([right, right, 9 * left, 9 * left])  # of sets that "a" has not
    found = rank_methods(
        {"free": trials(a=[left, left], b=more, c=2 + np.zeros((3, 16)))},
        ["c", "a", "b"],
        n_arcs=2,
        **SMALL,
    )
    # in either arc one of a and b is first, and c the last
    assert found.means.to_dict() == {"a": 1.5, "b": 1.5, "c": 3.0}
    assert found.n_blocks == 2
    assert found.critical == critical_difference(3, 2)


def test_whoever_lacks_a_result_is_named():
    there = np.ones((2, 16))
    failed = np.where(np.arange(16) < 9, there, np.nan)
    everywhere = trials(a=there, b=2 * there, c=failed)
    everywhere["e"] = Trials({}, {"even/12/touched": there})
    everywhere["f"] = Trials({}, {"even/50/error_cm": there})
    found = rank_methods(
        {"free": everywhere, "obstacles": everywhere}, [*"abcdef"], **SMALL
    )
    assert list(found.means.index) == ["a", "b"]
    assert found.left_out == {
        "c": "failed in 'free' at n = 12",
        "d": "no results in 'free'",
        "e": "has no error_cm",
        "f": "not tried in 'free' at n = 12",
    }
    other = SMALL | {"sizes": (12, 24)}
    with pytest.raises(ValueError, match=r"\[\] have results everywhere; wanted two"):
        rank_methods({"free": everywhere}, ["a", "b"], **other)


def imagine(means, critical, **left_out):
    names = [*"abcdefgh"][: len(means)]
    return Ranks(pd.Series(means, index=names), 16, critical, 0.0, 0.0, left_out)


@pytest.mark.parametrize(
    ("means", "ties"),
    [
        ([1.0, 1.5, 2.5, 5.0], [(0, 1), (1, 2)]),
        ([1.0, 3.0, 5.0], []),
        ([1.0, 1.1, 1.2], [(0, 2)]),
        ([1.0, 2.0, 2.1, 3.05], [(0, 1), (1, 2), (2, 3)]),
    ],
)
def test_ties_are_the_longest_runs_within_the_critical_difference(means, ties):
    assert imagine(means, 1.0).ties == ties


def test_the_picture_joins_ties_and_names_who_is_left_out():
    ranks = imagine([1.0, 1.5, 2.5, 5.0], 1.0, z="no results in 'free'")
    axis, bars = plot_ranks(ranks).axes
    assert [text.get_text() for text in axis.get_yticklabels()] == [*"abcd"]
    joined = [tuple(-line.get_ydata()) for line in bars.lines]
    assert joined == ranks.ties
    (ruler,) = axis.lines
    assert np.ptp(ruler.get_xdata()) == ranks.critical
    assert axis.get_xlabel().endswith("\nnot ranked: z, no results in 'free'")
