"""The skill of da Silva, Konidaris and Barto, and how hyper-parameters are chosen."""

import re
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from sklearn.base import clone
from sklearn.datasets import make_swiss_roll
from sklearn.manifold import Isomap
from sklearn.metrics import adjusted_rand_score
from sklearn.model_selection import GridSearchCV
from sklearn.svm import SVC, SVR
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc.study.rivals import (
    N_FOLDS,
    N_TRIALS,
    RANGES,
    NeighbourComponents,
    isomap_skill,
    tune,
)
from msc.study.rivals._tuning import Folds

rng = np.random.default_rng(0)
tasks = np.linspace(0, 6, 30)[:, None]
policies = np.hstack([np.sin(tasks), np.cos(tasks), tasks]) + 9 * (tasks > 3.5)
few = settings(max_examples=20, deadline=None)


def draw(seed, n_points=40):
    """Draw points on several bent pieces, some of which touch."""
    draws = np.random.default_rng(seed)
    along = draws.uniform(0, 3, n_points)
    piece = draws.integers(0, 4, n_points)
    return np.c_[np.sin(along), np.cos(along), along] + 1.5 * piece[:, None]


def brute_components(points, n_neighbors):
    """Label by joining whatever is near, point by point."""
    apart = cdist(points, points)
    np.fill_diagonal(apart, np.inf)
    labels = np.arange(len(points))
    for i, row in enumerate(apart):
        for j in row.argsort()[:n_neighbors]:
            labels[labels == labels[j]] = labels[i]
    return labels


# Charts


@few
@given(st.integers(0, 2**31), st.integers(1, 12))
def test_components_are_those_of_joining_neighbours(seed, n_neighbors):
    points = draw(seed)
    found = NeighbourComponents(n_neighbors).fit(points)
    expected = brute_components(points, n_neighbors)
    assert adjusted_rand_score(found.labels_, expected) == 1
    assert found.n_components_ == len(set(expected)) == len(set(found.labels_))


@pytest.mark.parametrize("n_neighbors", [1, 2, 3, 5])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_components_are_as_many_as_isomap_warns_of(n_neighbors, seed):
    points = draw(seed)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Isomap(n_neighbors=n_neighbors).fit(points)
    told = [re.search(r"neighbors graph is (\d+) > 1", str(w.message)) for w in caught]
    numbers = [int(one[1]) for one in told if one] or [1]
    assert NeighbourComponents(n_neighbors).fit(points).n_components_ == numbers[0]


@few
@given(st.integers(0, 2**31), st.integers(1, 15))
def test_neighbours_are_the_fewest_that_leave_no_small_component(seed, min_size):
    points = draw(seed)
    found = NeighbourComponents(min_size=min_size).fit(points)
    assert np.bincount(found.labels_).min() >= min_size
    fewer = found.n_neighbors_ - 1
    if fewer:
        labels = NeighbourComponents(fewer).fit_predict(points)
        assert np.bincount(labels).min() < min_size
        merged = set(zip(labels, found.labels_, strict=True))
        assert len(merged) == labels.max() + 1  # components have only merged


def test_two_swiss_rolls_are_two_charts():
    roll, _ = make_swiss_roll(400, random_state=0)
    points = np.vstack([roll, roll + np.array([0, 40, 0])])
    found = NeighbourComponents(8).fit(points)
    assert found.n_components_ == 2
    np.testing.assert_array_equal(found.labels_, np.repeat([0, 1], 400))


@pytest.mark.parametrize("n_points", [1, 2, 3])
def test_too_few_points_are_one_component(n_points):
    found = NeighbourComponents().fit(np.arange(n_points)[:, None])
    assert found.labels_.tolist() == [0] * n_points
    assert found.n_neighbors_ <= n_points - 1


@pytest.mark.parametrize("options", [{"n_neighbors": 0}, {"min_size": 2.5}])
def test_bad_parameters(options):
    [name] = options
    with pytest.raises(ValueError, match=f"'{name}' parameter of NeighbourComponents"):
        NeighbourComponents(**options).fit(tasks)


@parametrize_with_checks([NeighbourComponents(), NeighbourComponents(3)])
def test_scikit_learn(estimator, check):
    check(estimator)


# The skill


def isomap():
    """Let the search for settings try few."""
    few = {"gate__n_iter": 6, "regressor__n_iter": 6}
    return isomap_skill(random_state=0).set_params(**few)


@pytest.fixture(scope="module")
def skill():
    return isomap().fit(tasks, policies)


def test_a_break_makes_two_charts_and_the_classifier_finds_it(skill):
    assert skill.n_charts_ == 2
    np.testing.assert_array_equal(np.flatnonzero(np.diff(skill.charts_)), [16])
    assert isinstance(skill.gate_.best_estimator_, SVC)
    np.testing.assert_array_equal(skill.predict_chart(tasks), skill.charts_)


def test_a_chart_s_regression_is_support_vector_regression_on_it_alone(skill):
    here = skill.charts_ == 1
    for k, model in enumerate(skill.regressors_[1]):
        chosen = {
            key.removeprefix("regressor__"): value
            for key, value in model.best_params_.items()
        }
        mean, std = policies[here, k].mean(), policies[here, k].std()
        alone = SVR(**chosen).fit(tasks[here], (policies[here, k] - mean) / std)
        expected = mean + std * alone.predict(tasks[here])
        np.testing.assert_allclose(model.predict(tasks[here]), expected)


def test_it_predicts_between_tasks_on_both_sides_of_the_break(skill):
    new = tasks[:-1] + 0.1
    truth = np.hstack([np.sin(new), np.cos(new), new]) + 9 * (new > 3.5)
    away = np.abs(new[:, 0] - 3.5) > 0.3
    assert np.abs(skill.predict(new) - truth)[away].max() < 0.2


def test_the_same_seed_gives_the_same_skill(skill):
    again = clone(skill).fit(tasks, policies)
    np.testing.assert_array_equal(again.predict(tasks), skill.predict(tasks))


# Tuning


def test_with_enough_trials_it_is_a_grid_search():
    X, y = tasks, policies[:, 0]
    mixed = {"C": [1.0, 100.0], "gamma": [0.1, 1.0, 10.0]}
    found = tune(SVR(), "support vector regression", random_state=0)
    found.set_params(param_distributions=mixed, n_iter=6).fit(X, y)
    theirs = GridSearchCV(SVR(), mixed, cv=Folds(), scoring="neg_mean_squared_error")
    assert theirs.fit(X, y).best_score_ == found.best_score_
    np.testing.assert_array_equal(theirs.predict(X), found.predict(X))


def test_trials_are_as_many_as_stated_and_all_differ():
    for name in ("support vector regression", "nearest neighbours"):
        found = tune(SVR(), name, random_state=0)
        n_settings = np.prod([len(values) for values in RANGES[name].values()])
        assert found.n_iter == min(N_TRIALS, n_settings)
    found = tune(SVR(), "support vector regression", random_state=0)
    tried = found.fit(tasks, policies[:, 0]).cv_results_["params"]
    assert len({str(one) for one in tried}) == N_TRIALS


@pytest.mark.parametrize("n_samples", [1, 2, 4, 5, 30])
def test_folds_part_the_samples(n_samples):
    X = np.arange(n_samples)
    judged = [test for _, test in Folds().split(X)]
    assert len(judged) == Folds().get_n_splits(X) == min(N_FOLDS, n_samples)
    assert sorted(np.concatenate(judged)) == X.tolist()
    if n_samples > 1:
        assert all(not set(train) & set(test) for train, test in Folds().split(X))


def test_every_fold_has_every_chart():
    y = np.repeat([0, 1], [5, 20])
    for train, test in Folds(is_stratified=True).split(y, y):
        assert set(y[train]) == set(y[test]) == {0, 1}
    assert Folds(is_stratified=True).get_n_splits(y, np.repeat([0, 1], [1, 24])) == 1
