"""The readings of the elbow: on curves and charts whose number is known."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc import SMCE
from msc.learn import SELECTION_CRITERIA, elbow, read_elbows
from msc.learn._spectral import knee
from msc.study import choose_criterion, measure_elbows, most_picked
from msc.study._selection import FROM_POLICIES

tasks = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None]
offsets = 40 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
policies = np.c_[np.sin(tasks), np.cos(tasks)] + offsets[np.repeat(range(4), 12)]
falling = st.lists(st.floats(0, 100), min_size=3, max_size=12)


@pytest.fixture(scope="module")
def readings():
    return read_elbows(tasks, policies, max_charts=8)


# One reading


@pytest.mark.parametrize("name", ["squares", "squares_knee", "cross_validation"])
def test_four_pieces_far_apart_are_four_charts(readings, name):
    assert readings[name]["picked"] == 4


def test_four_clouds_far_apart_are_an_eigengap_of_four():
    clouds = (
        np.random.default_rng(0).normal(size=(80, 2)) + offsets[np.arange(80) // 20]
    )
    readings = read_elbows(np.arange(80.0)[:, None], clouds, max_charts=6, n_folds=2)
    assert readings["eigengap"]["picked"] == 4


def test_every_reading_has_a_curve_and_picks_a_number_on_it(readings):
    assert list(readings) == list(SELECTION_CRITERIA)
    for reading in readings.values():
        assert len(reading["curve"]) == 8
        assert np.isfinite(reading["curve"]).all()
        assert reading["picked"] in range(1, 9)
    assert json.loads(json.dumps(readings)) == readings


def test_squares_are_the_curve_of_smce(readings):
    model = SMCE(max_clusters=8, random_state=0).fit(policies)
    np.testing.assert_allclose(readings["squares"]["curve"], model.elbow_curve_)
    assert readings["squares"]["picked"] == model.n_clusters_


def test_eigengaps_are_differences_of_the_eigenvalues_of_smce(readings):
    values = SMCE(random_state=0).fit(policies).eigenvalues_
    expected = np.diff(values)[:8]
    np.testing.assert_allclose(readings["eigengap"]["curve"], expected, atol=1e-9)


def test_rows_of_m_are_clustered_directly(readings):
    rows = SMCE(random_state=0).fit(policies).affinity_matrix_.toarray()
    curve = np.array(readings["rows_of_m"]["curve"])
    np.testing.assert_allclose(curve[0], ((rows - rows.mean(axis=0)) ** 2).sum())
    assert (np.diff(curve) < 0).all()
    assert readings["rows_of_m"]["picked"] == elbow(curve)


def test_cross_validation_never_sees_a_held_out_policy():
    noise = np.random.default_rng(0).normal(size=(48, 2))
    readings = read_elbows(tasks, noise, max_charts=3)
    assert (
        min(readings["cross_validation"]["curve"]) > 0.7 * (noise**2).mean()
    )  # nothing to be learned


def test_only_the_cross_validation_looks_at_the_tasks(readings):
    shuffled = np.random.default_rng(0).permutation(tasks)
    other = read_elbows(shuffled, policies, max_charts=8)
    for name in FROM_POLICIES:
        assert other[name] == readings[name]
    assert other["cross_validation"] != readings["cross_validation"]


@pytest.mark.parametrize("n_tasks", [3, 4, 5, 8])
def test_few_tasks(n_tasks):
    few = slice(0, 48, 48 // n_tasks)
    for reading in read_elbows(tasks[few], policies[few]).values():
        assert np.isfinite(reading["curve"]).all()
        assert 1 <= reading["picked"] <= len(reading["curve"]) < n_tasks + 1


# The knee


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        ([9, 4, 1, 0.9, 0.8], 3),
        ([100, 40, 38, 36, 34, 6, 4, 2, 0], 2),  # stands out; the chord's is the 6th
        ([100, 85, 70, 62, 50, 36, 5, 2, 0], 7),  # the third does not stand out
        ([4, 3, 2, 1], 1),
        ([1, 1, 1, 1], 1),
        ([2, 1], 1),
    ],
)
def test_knee_is_the_first_that_stands_out(curve, expected):
    assert knee(curve) == expected


@settings(max_examples=50, deadline=None)
@given(falling)
def test_knee_lies_below_the_chord_no_deeper_than_the_elbow(curve):
    curve = np.sort(curve)[::-1]
    found = knee(curve)
    if np.ptp(curve) < 1e-3 or found == 1:
        return
    below = 1 - np.linspace(0, 1, len(curve)) - (curve - curve[-1]) / np.ptp(curve)
    assert 0 < below[found - 1] <= below[elbow(curve) - 1] + 1e-12
    assert below[found - 1] >= max(below[found - 2], below[found]) - 1e-12


def test_a_convex_curve_has_one_knee_and_it_is_the_elbow():
    curve = 1 / np.arange(1.0, 11.0)
    assert knee(curve) == elbow(curve) == 3


# Many parts


@pytest.fixture(scope="module")
def measured():
    return measure_elbows(tasks, policies, n_resamples=2, max_charts=5)


def test_parts_are_counted_and_workers_do_not_matter(measured):
    assert measured["n_samples"] == 48
    for name, reading in measured["readings"].items():
        assert sum(reading["resampled"].values()) == 2, name
    assert json.loads(json.dumps(measured)) == measured
    again = measure_elbows(tasks, policies, n_resamples=2, max_charts=5, jobs=2)
    assert again == measured


def test_parts_depend_on_the_seed():
    noise = np.random.default_rng(0).normal(size=(15, 2))
    one, other = (
        measure_elbows(tasks[:15], noise, n_resamples=4, max_charts=5, seed=seed)
        for seed in (0, 1)
    )
    counts = [[r["resampled"] for r in m["readings"].values()] for m in (one, other)]
    assert counts[0] != counts[1]


def made(**resampled):
    """Return measurements with given counts; the first reading picks nothing firmly."""
    loose = {str(count): 1 for count in range(1, 10)}
    return {
        "readings": {
            name: {"curve": [0.0] * 10, "resampled": resampled.get(name, loose)}
            for name in SELECTION_CRITERIA
        }
    }


def test_criterion_takes_the_reading_that_picks_most_firmly():
    one, other = made(squares={"3": 8, "4": 2}), made(squares={"4": 4, "5": 6})
    assert choose_criterion(one) == choose_criterion(one, other) == "squares"
    rival = made(squares={"3": 8, "4": 2}, squares_knee={"3": 9, "4": 1})
    assert choose_criterion(rival) == "squares_knee"
    assert choose_criterion(rival, other) == "squares"  # on the average


def test_criterion_counts_no_pick_at_the_end_and_no_cross_validation():
    ends = {"eigengap": {"10": 9, "9": 1}, "cross_validation": {"5": 10}}
    assert choose_criterion(made(**ends, squares={"3": 2, "4": 3})) == "squares"
    assert most_picked(made(**ends), "eigengap") == (9, 0.1)
    assert most_picked(made(eigengap={"10": 4}), "eigengap") == (0, 0.0)


def test_one_chart_is_an_answer_that_counts():
    firm = made(squares_knee={"1": 9, "2": 1}, squares={"3": 6, "4": 4})
    assert most_picked(firm, "squares_knee") == (1, 0.9)
    assert choose_criterion(firm) == "squares_knee"


def test_criterion_gives_ties_to_the_paper_s_words():
    assert choose_criterion(made()) == "rows_of_m"


# Errors


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"max_charts": 0}, "max_charts=0; wanted at least 1, whole"),
        ({"max_charts": 2.5}, "max_charts=2.5; wanted at least 1, whole"),
        ({"n_folds": 1}, "n_folds=1; wanted at least 2, whole"),
    ],
)
def test_numbers_out_of_range(arguments, message):
    with pytest.raises(ValueError, match=message):
        read_elbows(tasks, policies, **arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_resamples": 0}, "n_resamples=0; wanted at least 1, whole"),
        ({"share": 1.5}, "share=1.5 of 48 tasks must be from 3 to all of them"),
        ({"share": np.nan}, "share=nan of 48 tasks must be from 3 to all of them"),
        ({"share": 0.01}, "share=0.01 of 48 tasks must be from 3 to all of them"),
    ],
)
def test_resampling_out_of_range(arguments, message):
    with pytest.raises(ValueError, match=message):
        measure_elbows(tasks, policies, **arguments)


@pytest.mark.parametrize(
    ("X", "y", "message"),
    [
        (tasks[:2], policies[:2], "minimum of 3 is required"),
        (tasks, policies[:-1], "inconsistent numbers of samples"),
        ([[0.0], [1.0], [np.nan]], policies[:3], "Input X contains NaN"),
        (tasks[:3], [[0.0], [1.0], [np.inf]], "Input y contains infinity"),
    ],
)
def test_data_out_of_range(X, y, message):
    with pytest.raises(ValueError, match=message):
        read_elbows(X, y)
