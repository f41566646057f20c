"""The recipes run as they stand, and find what they are made to find."""

import re
import runpy
from pathlib import Path

import numpy as np
import pytest

PAGE = (Path(__file__).parents[1] / "book" / "recipes.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE, re.M | re.S)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Run all blocks one after another, as a reader would."""
    folder = tmp_path_factory.mktemp("recipes")
    script = folder / "blocks.py"
    script.write_text("\n\n".join(BLOCKS), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return runpy.run_path(str(script))


def test_there_are_six():
    assert len(re.findall(r"^## \d\.", PAGE, re.M)) == 6


def test_a_pipeline_predicts_in_the_units_of_the_table(ran):
    found = ran["pipeline"].predict(ran["new"])
    place, load = ran["new"].to_numpy().T
    far = place > 600
    truth = np.c_[np.sin(place / 300) + 3 * far, load / 100 - 2 * far]
    assert np.abs(found - truth).max() < 0.3
    with pytest.raises(ValueError, match="feature names should match"):
        ran["pipeline"].predict(ran["new"][["load_g", "place_mm"]])


def test_a_circle_is_closed(ran):
    before, behind = ran["turning"].predict(ran["ends"]).ravel()
    assert before == pytest.approx(behind, abs=1e-9)


def test_the_two_errors_disagree_on_the_number_of_charts_as_the_page_says(ran):
    best = ran["by_n_charts"].set_axis(["squared", "median"], axis=1).idxmax() + 1
    assert best.tolist() == [1, 2]
    assert list(ran["search"].best_params_.values()) == [2]


def test_the_gate_doubts_beside_the_break(ran):
    doubtful = ran["tasks"].iloc[ran["doubt"].argmax()]
    assert abs(doubtful["place_mm"] - 600) < 100


def test_conformal_bands_are_wider_than_nothing_and_hold_the_mean(ran):
    low, high = (
        ran["bands"]
        .predict_int(ran["means"][:, 0], sigmas=ran["new_stds"][:, 0], confidence=0.9)
        .T
    )
    assert (low < ran["means"][:, 0]).all()
    assert (ran["means"][:, 0] < high).all()


def test_what_weighs_more_is_met_more_nearly(ran):
    assert ran["weighted"].best_params_ == {"method": "random forest"}
    errors = [
        np.median(np.abs(ran[name].predict(ran["tasks"])[:, 1] - ran["push"]))
        for name in ("weighted", "plain")
    ]
    assert 2 * errors[0] < errors[1]
