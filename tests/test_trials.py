"""Trials by rivals: executed, counted, and what they start from."""

import numpy as np
import pytest
from scipy.fft import dct

from msc import DMP, Arm, Workspace, load_dataset
from msc.search import cost, initial_covariance
from msc.study.rivals import (
    ContextualSearch,
    MultiTaskSearch,
    PractisedCrKR,
    PractisedMixture,
)
from msc.study.rivals._trials import Trials, cosines, draw_tasks

tasks, policies, table = load_dataset("obstacles")
some = slice(0, 360, 30)
X, y = tasks[some], policies[some]
PRACTISED = [
    PractisedCrKR(n_rollouts=20, n_together=7),
    PractisedMixture(n_rollouts=20, n_together=7),
    MultiTaskSearch(n_features=1, n_rollouts=200, from_policies=False),
    ContextualSearch(n_features=2, n_rollouts=100),
]
by_name = pytest.mark.parametrize(
    "model", PRACTISED, ids=lambda one: type(one).__name__
)


def test_a_trial_costs_what_the_table_says():
    world = Workspace.obstacles()
    trials = Trials(world, None, None)
    found = trials(y, X)
    np.testing.assert_allclose(found, table["cost"][some], rtol=1e-9)
    with Arm(world) as arm:
        alone = [
            cost(arm.execute(*pair))
            for pair in zip(y, np.rad2deg(X[:, 0]), strict=False)
        ]
    np.testing.assert_array_equal(found, alone)
    assert trials.n_rollouts == 12


def test_features_are_the_discrete_cosine_transform():
    n = 16
    middles = 2 * np.pi * (np.arange(n) + 0.5)[:, None] / n
    basis = dct(np.eye(n), norm="ortho", axis=0).T  # by rows: times
    found = cosines(middles, 6, (0, 2 * np.pi))
    np.testing.assert_allclose(found, np.sqrt(n) * basis[:, :6], atol=1e-12)


def test_tasks_are_drawn_between_bounds():
    rng = np.random.default_rng(0)
    found = draw_tasks(rng, 4000, X, (1.0, 3.0))
    assert found.shape == (4000, 1)
    assert 1 <= found.min() < 1.01
    assert 2.99 < found.max() < 3
    found = draw_tasks(rng, 4000, np.array([[0.0, -5.0], [1.0, 5.0]]), None)
    np.testing.assert_allclose(found.min(axis=0), [0, -5], atol=0.02)
    with pytest.raises(ValueError, match=r"span=\(2, 1\); wanted its lower bound"):
        draw_tasks(rng, 1, X, (2, 1))


def test_the_first_spread_is_that_of_one_task_if_there_is_only_one():
    trials = Trials(Workspace.free(), None, None)
    own = initial_covariance(Workspace.free(), np.rad2deg(X[3, 0]), DMP())
    found = trials.spread(X[[3, 3]], 6)
    np.testing.assert_allclose(found, own, rtol=1e-6)
    assert np.linalg.det(trials.spread(X, 6)) == pytest.approx(1)


def counted():
    """Return a cost of which all calls are counted."""
    calls = []

    def execute(policies, X):
        calls.append(len(X))
        return 0.1 + ((policies - np.cos(X)) ** 2).mean(axis=1)

    return execute, calls


@by_name
def test_every_rollout_is_counted(model):
    execute, calls = counted()
    found = model.__class__(**{**model.get_params(), "execute": execute}).fit(X, y)
    assert 0 < found.n_rollouts_ == sum(calls) <= model.n_rollouts


@by_name
def test_the_same_seed_gives_the_same_and_global_state_is_left_alone(model):
    execute, _ = counted()
    before = np.random.get_state()[1].copy()  # noqa: NPY002

    def found(seed):
        params = {**model.get_params(), "execute": execute, "random_state": seed}
        return model.__class__(**params).fit(X, y).predict(tasks)

    np.testing.assert_array_equal(found(3), found(3))
    assert np.abs(found(3) - found(4)).max() > 1e-9
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


@by_name
def test_it_executes_in_a_world(model):
    params = {**model.get_params(), "workspace": Workspace.obstacles()}
    found = model.__class__(**{**params, "random_state": 0}).fit(X, y)
    assert found.n_rollouts_ > 0
    assert np.isfinite(found.predict(tasks)).all()


@by_name
def test_what_cannot_be_executed_is_refused(model):
    def refit(**changed):
        return model.__class__(**{**model.get_params(), **changed}).fit(X, y)

    with pytest.raises(TypeError, match="workspace='free'; wanted a Workspace"):
        refit(workspace="free")
    with pytest.raises(TypeError, match="execute=3; wanted a function"):
        refit(execute=3)
    with pytest.raises(ValueError, match=r"execute gave .* finite costs, one a policy"):
        refit(execute=lambda policies, X: np.full(len(X), np.nan))
    with pytest.raises(ValueError, match="'n_rollouts' parameter of"):
        refit(n_rollouts=-1)


def test_a_world_has_as_many_numbers_as_its_tasks():
    for model in PRACTISED:
        message = r"points have shape .* 1 columns: task_deg|bounds 1 numbers; wanted 2"
        with pytest.raises(ValueError, match=message):
            model.fit(np.hstack([X, X]), y)


def test_one_number_a_task_is_refused_where_it_is_no_policy():
    for model in PRACTISED[2:]:
        with pytest.raises(ValueError, match=r"y has shape \(12,\); wanted \(n_tasks"):
            model.fit(X, y[:, 0])
