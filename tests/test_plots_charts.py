"""The figure and the table of the readings of the elbow, from made files."""

import json

import numpy as np
import pytest

from msc.elbows import READINGS
from msc.plots_charts import elbow_table, load_elbows, plot_elbows


def measured(picked, resampled, n_counts=6):
    """Return measurements in which all readings agree."""
    curve = (1.0 / np.arange(1, n_counts + 1)).tolist()
    reading = {"curve": curve, "picked": picked, "resampled": resampled}
    return {"n_resamples": 10, "readings": dict.fromkeys(READINGS, reading)}


@pytest.fixture
def elbows():
    return {
        "free": measured(3, {"3": 7, "4": 3}),
        "obstacles": measured(5, {"5": 4, "6": 6}),
    }


@pytest.fixture
def folder(elbows, tmp_path):
    for world, found in elbows.items():
        (tmp_path / f"elbow_{world}.json").write_text(json.dumps(found))
    return tmp_path


def test_files_are_loaded_by_workspace(folder, elbows):
    assert load_elbows(folder) == elbows


def test_table_tells_picks_and_shares(elbows):
    table = elbow_table(elbows)
    assert list(table.index) == list(READINGS.values())
    assert table["free"].iloc[0].tolist() == ["3", "30%", "3 (70%)"]
    assert table["obstacles"].iloc[-1].tolist() == ["5", "0%", "5 (40%)"]
    assert elbow_table(elbows, count=5)["obstacles", "picks 5"].iloc[0] == "40%"


def test_figure_marks_every_pick_and_draws_every_share(elbows):
    axes = np.reshape(plot_elbows(elbows).axes, (len(READINGS), 2))
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
    elbows["free"]["readings"] = dict.fromkeys(READINGS, flat)
    assert plot_elbows(elbows)


def test_a_missing_or_old_file_is_named(folder):
    (folder / "elbow_free.json").write_text('{"readings": {"squares": {}}}')
    with pytest.raises(
        ValueError, match=r"elbow_free\.json lacks cross_validation, eigengap, rows_of"
    ):
        load_elbows(folder)
    (folder / "elbow_free.json").unlink()
    with pytest.raises(ValueError, match=r"elbow_free\.json is not there; `msc eval"):
        load_elbows(folder)
