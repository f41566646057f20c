"""The figure and the table of the readings of the elbow, from made files."""

import numpy as np
import pytest

from msc.learn import SELECTION_CRITERIA
from msc.plots import elbow_table, gate_table, plot_elbows


def measured(world, picked, resampled, n_counts=6):
    """Return measurements in which all readings agree."""
    curve = (1.0 / np.arange(1, n_counts + 1)).tolist()
    reading = {"curve": curve, "picked": picked, "resampled": resampled}
    readings = dict.fromkeys(SELECTION_CRITERIA, reading)
    return {"workspace": world, "n_resamples": 10, "readings": readings}


@pytest.fixture
def elbows():
    return [
        measured("free", 3, {"3": 7, "4": 3}),
        measured("obstacles", 5, {"5": 4, "6": 6}),
    ]


def test_table_tells_picks_and_shares(elbows):
    table = elbow_table(*elbows)
    assert list(table.index) == list(SELECTION_CRITERIA.values())
    assert table["free"].iloc[0].tolist() == ["3", "30%", "3 (70%)"]
    assert table["obstacles"].iloc[-1].tolist() == ["5", "0%", "5 (40%)"]
    assert elbow_table(*elbows, count=5)["obstacles", "picks 5"].iloc[0] == "40%"


def test_figure_marks_every_pick_and_draws_every_share(elbows):
    axes = np.reshape(plot_elbows(*elbows).axes, (len(SELECTION_CRITERIA), 2))
    for column, picked, shares in (
        (axes[:, 0], 3, [0, 0, 0.7, 0.3, 0, 0]),
        (axes[:, 1], 5, [0, 0, 0, 0, 0.4, 0.6]),
    ):
        for axis in column:
            (diamond,) = [line for line in axis.lines if line.get_marker() == "D"]
            assert diamond.get_xdata().tolist() == [picked]
            heights = [bar.get_height() for bar in axis.patches]
            np.testing.assert_allclose(heights, shares)


def test_a_flat_curve_can_be_drawn(elbows):
    flat = {"curve": [0.0], "picked": 1, "resampled": {"1": 10}}
    elbows[0]["readings"] = dict.fromkeys(SELECTION_CRITERIA, flat)
    assert plot_elbows(*elbows)


def test_gates_are_told_by_world_and_size():
    found = {
        "n_samples": 24,
        "repetitions": 9,
        "accuracy": {"nearest": 0.75, "svm": 0.5},
        "best": {"nearest": 8, "svm": 1},
    }
    table = gate_table({"workspace": "free", "gates": [found]})
    assert table.loc["free", 24].to_dict() == {
        "training sets": 9,
        "nearest": "0.75 (8)",
        "svm": "0.50 (1)",
    }
