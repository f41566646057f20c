import numpy as np
import pytest

from msc.study import compare_clusterers

rng = np.random.default_rng(0)


@pytest.fixture(scope="module")
def table():
    """Three far, curved pieces of different lengths, with jumps after 19 and 49."""
    angle = np.linspace(0, 1, 90)
    piece = np.repeat([0, 1, 2], [20, 30, 40])
    curve = np.c_[np.sin(angle), np.cos(angle), 5 * piece]
    return compare_clusterers(curve + 1e-3 * rng.normal(size=(90, 3)), [19, 49], (3, 4))


def test_every_clusterer_finds_pieces_that_lie_apart(table):
    assert (table.loc[3] == [2, 2, 1.0]).all(axis=None)


def test_a_chart_too_many_is_a_border_that_is_no_jump(table):
    assert (table.loc[4, "of 2 jumps, at a border"] == 2).all()
    assert (table.loc[4, "borders"] > 2).all()
    assert (table.loc[4, "adjusted Rand index"] < 1).all()
