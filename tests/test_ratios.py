"""Forests: every ratio is a mark on its row, and every interval a line."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msc.estimates import Estimate
from msc.plots import plot_comparisons, plot_ratios
from msc.plots._ratios import FARTHEST, _find_reach

LOWER, OPEN, HIGHER = (
    Estimate(*ends) for ends in ((0.5, 0.4, 0.6), (1.2, 0.5, 3.0), (2.0, 1.5, 2.5))
)


def marks(axis):
    """Return by row what is drawn: the mark, its fill, its place, the line's ends."""
    found = {}
    for line in axis.lines:
        x, y = line.get_xdata(), line.get_ydata()
        if line.get_marker() in ("o", "X"):
            fill = line.get_markerfacecolor()
            found.setdefault(-y[0], {})["mark"] = line.get_marker(), fill, x[0]
        elif len(x) == 2 and y[0] == y[1]:
            found.setdefault(-y[0], {})["line"] = tuple(x)
    return found


def test_marks_tell_verdicts_and_lines_intervals():
    column = pd.Series([LOWER, OPEN, HIGHER], index=[8, 12, 24], dtype=object)
    (axis,) = plot_ratios(pd.DataFrame({"CrKr": column})).axes
    drawn = marks(axis)
    assert drawn[0] == {"mark": ("o", "0.2", 0.5), "line": (0.4, 0.6)}
    assert drawn[1] == {"mark": ("o", "white", 1.2), "line": (0.5, 3.0)}
    assert drawn[2] == {"mark": ("X", "0.2", 2.0), "line": (1.5, 2.5)}
    names = [label.get_text() for label in axis.get_yticklabels()]
    assert names == ["8", "12", "24"]
    written = [text.get_text() for text in axis.texts]
    assert written[0] == "●\N{NBSP}0.5 [0.4,\N{NBSP}0.6]"


def test_heads_lay_out_panels_and_what_is_missing_is_a_dash():
    heads = [("free", "a"), ("free", "b"), ("obstacles", "a")]
    columns = {head: pd.Series([OPEN], dtype=object) for head in heads[:2]}
    columns[heads[2]] = pd.Series([np.nan], dtype=object)
    first, second, third, fourth = plot_ratios(pd.DataFrame(columns)).axes
    titles = [axis.get_title("left") for axis in (first, second, third)]
    assert titles == ["a", "b", "a"]
    assert (first.get_ylabel(), third.get_ylabel()) == ("free", "obstacles")
    assert [text.get_text() for text in third.texts] == ["–"]
    assert not fourth.axison
    assert not first.texts


def test_what_leaves_the_axis_ends_in_an_arrow():
    far = Estimate(50, 1e-9, np.inf)
    column = pd.Series([far, LOWER], dtype=object)
    (axis,) = plot_ratios(pd.DataFrame({"": column})).axes
    arrows = [line.get_marker() for line in axis.lines if line.get_marker() in "<>"]
    assert sorted(arrows) == ["<", ">"]
    assert axis.get_xlim() == pytest.approx((1 / FARTHEST, FARTHEST))


def test_comparisons_name_the_other_method_where_there_are_several():
    one = Estimate(0.5, 0.4, 0.7, "MSE", "CrKr")
    other = Estimate(2, 1, 3, "error", "nearest")
    (axis,) = plot_comparisons(one, other).axes
    names = [label.get_text() for label in axis.get_yticklabels()]
    assert names == ["MSE, over CrKr", "error, over nearest"]
    (axis,) = plot_comparisons(one, one).axes
    assert axis.get_title("left") == "over CrKr"


ratios = st.floats(1e-9, 1e9)


@given(st.lists(st.tuples(ratios, ratios, ratios).map(sorted), min_size=1))
def test_an_axis_reaches_all_ends_or_as_far_as_it_may(rows):
    column = pd.Series([Estimate(v, low, high) for low, v, high in rows], dtype=object)
    reach = _find_reach(pd.DataFrame({"": column}))
    farthest = max(max(end, 1 / end) for row in rows for end in row)
    assert reach == FARTHEST or reach >= farthest
    assert 2 <= reach <= FARTHEST
