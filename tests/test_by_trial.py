"""Settings of methods with rollouts, chosen by rollouts; and budgets."""

import numpy as np
import pytest
from sklearn.base import BaseEstimator, clone
from sklearn.model_selection import ParameterGrid

from msc import Workspace
from msc.study.rivals import (
    N_CHECKS,
    PRACTICE,
    SEARCH,
    SETTINGS,
    ChosenByTrial,
    PractisedCrKR,
    practising_method,
)
from msc.study.rivals._by_trial import CIRCLE

X = np.linspace(0, 6, 9)[:, None]
y = np.hstack([np.sin(X), np.cos(X)])


class Constant(BaseEstimator):
    """Predicts one number, and says that it spent as many rollouts as it was told."""

    def __init__(self, value=0.0, n_rollouts=7, execute=None):
        self.value, self.n_rollouts, self.execute = value, n_rollouts, execute
        self.workspace = self.dmp = None
        self.span, self.random_state = (2.0, 3.0), 4

    def fit(self, X, y):
        self.n_rollouts_ = self.n_rollouts
        return self

    def predict(self, X):
        return np.full((len(X), 2), self.value)


def choose(execute, values, **more):
    settings = [{"value": values}]
    return ChosenByTrial(Constant(execute=execute), settings, **more).fit(X, y)


def test_the_setting_that_is_cheapest_on_new_tasks_is_kept_and_all_is_counted():
    asked = []

    def execute(policies, tasks):
        asked.append(tasks)
        return (policies[:, 0] - tasks[:, 0]) ** 2

    found = choose(execute, [0.0, 2.5, 9.0], n_checks=20)
    tasks = asked[0]
    assert all(np.array_equal(tasks, more) for more in asked[1:])
    assert tasks.shape == (20, 1)
    assert ((tasks >= 2) & (tasks <= 3)).all()  # the span, not the training tasks
    expected = [((v - tasks) ** 2).mean() for v in (0.0, 2.5, 9.0)]
    np.testing.assert_allclose(found.costs_, expected)
    assert found.best_params_ == {"value": 2.5}
    assert found.n_rollouts_ == 3 * (7 + 20)
    np.testing.assert_array_equal(found.predict(X), np.full((9, 2), 2.5))


def test_of_equally_cheap_settings_the_first_is_kept():
    found = choose(lambda policies, tasks: np.ones(len(tasks)), [3.0, 1.0])
    assert found.best_params_ == {"value": 3.0}


def test_tasks_are_drawn_by_another_stream_than_practice():
    asked = []

    def execute(policies, tasks):
        asked.append(tasks)
        return 1 + (policies**2).sum(axis=1)

    model = PractisedCrKR(execute=execute, n_rollouts=9, span=CIRCLE, random_state=1)
    ChosenByTrial(model, [{}], n_checks=9).fit(X, y)
    practised, checked = asked
    assert not np.isin(checked, practised).any()


def test_costs_reach_an_estimator_that_takes_them():
    cost = np.linspace(0.05, 0.4, 9)
    model = PractisedCrKR(
        execute=lambda policies, tasks: np.ones(len(tasks)), n_rollouts=0
    )
    found = ChosenByTrial(model, [{}]).fit(X, y, cost)
    np.testing.assert_array_equal(found.best_estimator_.costs_, cost)


@pytest.mark.parametrize("name", SETTINGS)
def test_a_method_has_the_budget_and_the_settings_of_the_table(name):
    one = practising_method(name, Workspace.obstacles(), 5)
    assert one.estimator.workspace == Workspace.obstacles()
    assert (one.estimator.random_state, one.n_checks) == (5, N_CHECKS)
    assert one.estimator.span == CIRCLE == (0, 2 * np.pi)
    budget = PRACTICE if "practice" in name else SEARCH
    assert one.estimator.n_rollouts == budget
    for setting in ParameterGrid(one.settings):
        clone(one.estimator).set_params(**setting)  # all are parameters of it


def test_all_that_practise_may_spend_alike():
    spent = {len(ParameterGrid(s)) for n, s in SETTINGS.items() if "practice" in n}
    assert len(spent) == 1
    spent = {len(ParameterGrid(s)) for n, s in SETTINGS.items() if "search" in n}
    assert len(spent) == 1
