"""The comparison of gates, on charts whose gate is known to be easy or hopeless."""

import json

import numpy as np
import pytest
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.model_selection import KFold, cross_val_score
from sklearn.neighbors import KNeighborsClassifier

from msc.learn import GATES
from msc.study import average_gates, compare_gates

tasks = np.linspace(0, 2 * np.pi, 40, endpoint=False)[:, None]
policies = np.c_[np.sin(tasks), np.cos(tasks)]


class Given(ClusterMixin, BaseEstimator):
    """Charts decided beforehand."""

    def __init__(self, labels=None):
        self.labels = labels

    def fit_predict(self, X, y=None):
        return np.asarray(self.labels)


def compare(labels, **options):
    return compare_gates(tasks, policies, charts=Given(labels), **options)


def test_nearest_gate_s_accuracy_is_scikit_learn_s():
    labels = np.repeat([0, 1, 0, 2], 10)
    found = compare(labels, n_splits=8, seed=3)
    folds = KFold(8, shuffle=True, random_state=3)
    scores = cross_val_score(KNeighborsClassifier(1), tasks, labels, cv=folds)
    np.testing.assert_allclose(found["accuracy"]["nearest"], scores.mean())
    assert found["n_charts"] == 3
    assert found["n_samples"] == 40
    assert list(found["accuracy"]) == list(GATES)
    assert json.loads(json.dumps(found)) == found


def test_contiguous_charts_are_told_and_chance_is_not():
    assert min(compare(np.repeat([0, 1], 20))["accuracy"].values()) > 0.9
    chance = np.random.default_rng(0).integers(0, 2, 40)
    assert max(compare(chance)["accuracy"].values()) < 0.8


def test_the_best_is_the_most_accurate_and_ties_go_to_the_first():
    found = compare(np.repeat([0, 1, 2, 3], 10))
    assert found["accuracy"][found["best"]] == max(found["accuracy"].values())
    assert compare(np.zeros(40, int))["best"] == "nearest"


def test_one_chart_or_one_left_in_a_fold_is_answered_by_it():
    assert set(compare(np.zeros(40, int))["accuracy"].values()) == {1.0}
    alone = compare(np.r_[1, np.zeros(39, int)], n_splits=40)
    accuracies = alone["accuracy"].values()
    assert 0.9 < min(accuracies) <= max(accuracies) <= 0.975  # it is never told


def test_smce_finds_the_charts_by_default():
    jumps = policies + 9.0 * (tasks > 3)
    found = compare_gates(tasks, jumps)
    assert found["n_charts"] == 2
    assert found["accuracy"]["nearest"] >= 0.95


@pytest.mark.parametrize("n_splits", [1, 0, 2.5])
def test_too_few_folds(n_splits):
    with pytest.raises(
        ValueError, match=f"n_splits={n_splits}; wanted at least 2, whole"
    ):
        compare(np.zeros(40, int), n_splits=n_splits)


def test_data_out_of_range():
    with pytest.raises(ValueError, match="inconsistent numbers of samples"):
        compare_gates(tasks, policies[:-1])
    with pytest.raises(ValueError, match="Input y contains NaN"):
        compare_gates(tasks[:2], [[np.nan], [1.0]])


def test_sets_of_one_size_are_averaged_apart_from_others():
    right = np.arange(40) // 20
    sets = [compare(right), compare(right[::-1]), compare(right, n_splits=5)]
    sets[2]["n_samples"] = 50
    small, large = average_gates(sets)
    assert (small["n_samples"], small["repetitions"]) == (40, 2)
    assert (large["n_samples"], large["repetitions"]) == (50, 1)
    mean = np.mean([one["accuracy"]["svm"] for one in sets[:2]])
    assert small["accuracy"]["svm"] == mean
    assert sum(small["best"].values()) == 2
