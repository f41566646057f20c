"""The number of charts and the gate, chosen where both are known."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.model_selection import KFold, cross_val_score
from sklearn.neighbors import KNeighborsClassifier

from msc import SMCE
from msc.learn import GATES, SELECTION_CRITERIA, elbow, knee
from msc.study import (
    average_gates,
    choose_criterion,
    compare_clusterers,
    compare_gates,
    measure_elbows,
    most_picked,
    read_elbows,
)
from msc.study._choices import FROM_POLICIES

tasks = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None]
offsets = 40 * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
policies = np.c_[np.sin(tasks), np.cos(tasks)] + offsets[np.repeat(range(4), 12)]
forty = np.linspace(0, 2 * np.pi, 40, endpoint=False)[:, None]
circle = np.c_[np.sin(forty), np.cos(forty)]
falling = st.lists(st.floats(0, 100), min_size=3, max_size=12)


@pytest.fixture(scope="module")
def picks():
    return read_elbows(tasks, policies, max_charts=6)


# One criterion


@pytest.mark.parametrize("name", ["squares", "squares_knee", "cross_validation"])
def test_four_pieces_far_apart_are_four_charts(picks, name):
    assert picks[name]["picked"] == 4


def test_four_clouds_far_apart_are_an_eigengap_of_four():
    clouds = (
        np.random.default_rng(0).normal(size=(80, 2)) + offsets[np.arange(80) // 20]
    )
    picks = read_elbows(np.arange(80.0)[:, None], clouds, max_charts=6, n_folds=2)
    assert picks["eigengap"]["picked"] == 4


def test_every_criterion_has_a_curve_and_picks_a_number_on_it(picks):
    assert list(picks) == list(SELECTION_CRITERIA)
    for found in picks.values():
        assert len(found["curve"]) == 6
        assert np.isfinite(found["curve"]).all()
        assert found["picked"] in range(1, 7)
    assert json.loads(json.dumps(picks)) == picks


def test_squares_are_the_curve_of_smce(picks):
    model = SMCE(max_clusters=6, random_state=0).fit(policies)
    np.testing.assert_allclose(picks["squares"]["curve"], model.elbow_curve_)
    assert picks["squares"]["picked"] == model.n_clusters_


def test_eigengaps_are_differences_of_the_eigenvalues_of_smce(picks):
    values = SMCE(random_state=0).fit(policies).eigenvalues_
    expected = np.diff(values)[:6]
    np.testing.assert_allclose(picks["eigengap"]["curve"], expected, atol=1e-9)


def test_rows_of_m_are_clustered_directly(picks):
    rows = SMCE(random_state=0).fit(policies).affinity_matrix_.toarray()
    curve = np.array(picks["rows_of_m"]["curve"])
    np.testing.assert_allclose(curve[0], ((rows - rows.mean(axis=0)) ** 2).sum())
    assert (np.diff(curve) < 0).all()
    assert picks["rows_of_m"]["picked"] == elbow(curve)


def test_cross_validation_never_sees_a_held_out_policy():
    noise = np.random.default_rng(0).normal(size=(48, 2))
    picks = read_elbows(tasks, noise, max_charts=3)
    assert (
        min(picks["cross_validation"]["curve"]) > 0.7 * (noise**2).mean()
    )  # nothing to be learned


def test_only_the_cross_validation_looks_at_the_tasks(picks):
    shuffled = np.random.default_rng(0).permutation(tasks)
    other = read_elbows(shuffled, policies, max_charts=6)
    for name in FROM_POLICIES:
        assert other[name] == picks[name]
    assert other["cross_validation"] != picks["cross_validation"]


@pytest.mark.parametrize("n_tasks", [3, 5])
def test_few_tasks(n_tasks):
    few = slice(0, 48, 48 // n_tasks)
    for found in read_elbows(tasks[few], policies[few]).values():
        assert np.isfinite(found["curve"]).all()
        assert 1 <= found["picked"] <= len(found["curve"]) < n_tasks + 1


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
    return measure_elbows(tasks, policies, n_resamples=2, max_charts=3)


def test_parts_are_counted_and_workers_do_not_matter(measured):
    assert measured["n_samples"] == 48
    for name, found in measured["readings"].items():
        assert sum(found["resampled"].values()) == 2, name
    assert json.loads(json.dumps(measured)) == measured
    again = measure_elbows(tasks, policies, n_resamples=2, max_charts=3, jobs=2)
    assert again == measured


def test_parts_depend_on_the_seed(monkeypatch):
    """Read by criteria that pick a number for the tasks that are there."""

    def read(X, y, **_):
        found = {"curve": [], "picked": int(1e6 * X.sum())}
        return dict.fromkeys(SELECTION_CRITERIA, found)

    monkeypatch.setattr("msc.study._choices.read_elbows", read)
    one, other, again = (
        measure_elbows(tasks, policies, n_resamples=4, seed=seed)["readings"]
        for seed in (0, 1, 0)
    )
    assert one != other
    assert one == again


def made(**resampled):
    """Return measurements with given counts; the first criterion is never firm."""
    loose = {str(count): 1 for count in range(1, 10)}
    return {
        "readings": {
            name: {"curve": [0.0] * 10, "resampled": resampled.get(name, loose)}
            for name in SELECTION_CRITERIA
        }
    }


def test_the_criterion_is_taken_that_picks_most_firmly():
    one, other = made(squares={"3": 8, "4": 2}), made(squares={"4": 4, "5": 6})
    assert choose_criterion(one) == choose_criterion(one, other) == "squares"
    rival = made(squares={"3": 8, "4": 2}, squares_knee={"3": 9, "4": 1})
    assert choose_criterion(rival) == "squares_knee"
    assert choose_criterion(rival, other) == "squares"  # on the average


def test_no_pick_at_the_end_counts_and_no_cross_validation():
    ends = {"eigengap": {"10": 9, "9": 1}, "cross_validation": {"5": 10}}
    assert choose_criterion(made(**ends, squares={"3": 2, "4": 3})) == "squares"
    assert most_picked(made(**ends), "eigengap") == (9, 0.1)
    assert most_picked(made(eigengap={"10": 4}), "eigengap") == (0, 0.0)


def test_one_chart_is_an_answer_that_counts():
    firm = made(squares_knee={"1": 9, "2": 1}, squares={"3": 6, "4": 4})
    assert most_picked(firm, "squares_knee") == (1, 0.9)
    assert choose_criterion(firm) == "squares_knee"


def test_ties_go_to_the_paper_s_words():
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


# Gates


class Given(ClusterMixin, BaseEstimator):
    """Charts decided beforehand."""

    def __init__(self, labels=None):
        self.labels = labels

    def fit_predict(self, X, y=None):
        return np.asarray(self.labels)


def compare_on(labels, **options):
    return compare_gates(forty, circle, charts=Given(labels), **options)


def test_nearest_gate_s_accuracy_is_scikit_learn_s():
    labels = np.repeat([0, 1, 0, 2], 10)
    found = compare_on(labels, n_splits=4, seed=3)
    folds = KFold(4, shuffle=True, random_state=3)
    scores = cross_val_score(KNeighborsClassifier(1), forty, labels, cv=folds)
    np.testing.assert_allclose(found["accuracy"]["nearest"], scores.mean())
    assert found["n_charts"] == 3
    assert found["n_samples"] == 40
    assert list(found["accuracy"]) == list(GATES)
    assert json.loads(json.dumps(found)) == found


def test_contiguous_charts_are_told_and_chance_is_not():
    told = compare_on(np.repeat([0, 1], 20), n_splits=5)
    assert min(told["accuracy"].values()) > 0.9
    chance = np.random.default_rng(0).integers(0, 2, 40)
    assert max(compare_on(chance, n_splits=5)["accuracy"].values()) < 0.8


def test_the_best_is_the_most_accurate_and_ties_go_to_the_first():
    found = compare_on(np.repeat([0, 1, 2, 3], 10), n_splits=4)
    assert found["accuracy"][found["best"]] == max(found["accuracy"].values())
    assert compare_on(np.zeros(40, int))["best"] == "nearest"


def test_one_chart_or_one_left_in_a_fold_is_answered_by_it():
    assert set(compare_on(np.zeros(40, int))["accuracy"].values()) == {1.0}
    few = slice(0, 40, 4)
    labels = Given(np.r_[1, np.zeros(9, int)])
    alone = compare_gates(forty[few], circle[few], charts=labels, n_splits=10)
    accuracies = alone["accuracy"].values()
    assert 0.7 < min(accuracies) <= max(accuracies) <= 0.9  # it is never told


def test_smce_finds_the_charts_by_default():
    jumps = circle + 9.0 * (forty > 3)
    found = compare_gates(forty, jumps)
    assert found["n_charts"] == 2
    assert found["accuracy"]["nearest"] >= 0.95


@pytest.mark.parametrize("n_splits", [1, 0, 2.5])
def test_too_few_folds(n_splits):
    with pytest.raises(
        ValueError, match=f"n_splits={n_splits}; wanted at least 2, whole"
    ):
        compare_on(np.zeros(40, int), n_splits=n_splits)


def test_data_that_no_gate_is_compared_on():
    with pytest.raises(ValueError, match="inconsistent numbers of samples"):
        compare_gates(forty, circle[:-1])
    with pytest.raises(ValueError, match="Input y contains NaN"):
        compare_gates(forty[:2], [[np.nan], [1.0]])


def test_sets_of_one_size_are_averaged_apart_from_others():
    right = np.arange(40) // 20
    mirrored = right[::-1]
    sets = [compare_on(labels, n_splits=3) for labels in (right, mirrored, right)]
    sets[2]["n_samples"] = 50
    small, large = average_gates(sets)
    assert (small["n_samples"], small["repetitions"]) == (40, 2)
    assert (large["n_samples"], large["repetitions"]) == (50, 1)
    mean = np.mean([one["accuracy"]["svm"] for one in sets[:2]])
    assert small["accuracy"]["svm"] == mean
    assert sum(small["best"].values()) == 2


# Clusterers


@pytest.fixture(scope="module")
def table():
    """Three far, curved pieces of different lengths, with jumps after 19 and 49."""
    angle = np.linspace(0, 1, 90)
    piece = np.repeat([0, 1, 2], [20, 30, 40])
    curve = np.c_[np.sin(angle), np.cos(angle), 5 * piece]
    return compare_clusterers(
        curve + 1e-3 * np.random.default_rng(0).normal(size=(90, 3)), [19, 49], (3, 4)
    )


def test_every_clusterer_finds_pieces_that_lie_apart(table):
    assert (table.loc[3] == [2, 2, 1.0]).all(axis=None)


def test_a_chart_too_many_is_a_border_that_is_no_jump(table):
    assert (table.loc[4, "of 2 jumps, at a border"] == 2).all()
    assert (table.loc[4, "borders"] > 2).all()
    assert (table.loc[4, "adjusted Rand index"] < 1).all()
