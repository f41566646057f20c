import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.optimize import minimize
from scipy.stats import multivariate_normal
from sklearn.base import clone
from sklearn.dummy import DummyRegressor
from sklearn.ensemble import RandomForestRegressor
from sklearn.linear_model import LinearRegression

from msc import DMP, CrKR, ParameterizedSkill
from msc.study.rivals import GoalProjected

rng = np.random.default_rng(0)
tasks = np.sort(rng.uniform(0, 6, (15, 1)), axis=0)
policies = 20 * np.hstack([np.sin(tasks + k) for k in range(6)])
METHODS = [
    DummyRegressor(),
    LinearRegression(),
    CrKR(),
    RandomForestRegressor(5, random_state=0),
    ParameterizedSkill(None, random_state=0),
]
seeds = st.integers(0, 2**31)
few = settings(max_examples=30, deadline=None)


def ends(policy, goal, dmp=None, end_time=1.0):
    path = (dmp or DMP()).path(policy, [-0.6, -0.6], goal, [0.5 * end_time, end_time])
    return path[..., -1, :]


def draw(seed):
    draws = np.random.default_rng(seed)
    root = draws.normal(size=(6, 6))
    return draws, root @ root.T + 0.1 * np.eye(6)


def projected(metric=None, **options):
    model = GoalProjected(DummyRegressor(), metric=metric, **options)
    n_params = (options.get("dmp") or DMP()).n_params
    return model.fit(np.zeros((2, 1)), np.zeros((2, n_params)))


# The condition


@pytest.mark.parametrize("method", METHODS, ids=lambda one: type(one).__name__)
def test_any_methods_movements_end_at_their_goals(method):
    new = np.linspace(-1, 7, 20)[:, None]
    goals = 0.45 * np.hstack([np.cos(new), np.sin(new)])
    plain = method.fit(tasks, policies).predict(new)
    assert np.abs(ends(plain, goals) - goals).max() > 1e-3
    found = GoalProjected(method).fit(tasks, policies).predict(new)
    assert_allclose(ends(found, goals), goals, atol=1e-9)


@pytest.mark.parametrize(
    ("dmp", "end_time"),
    [(DMP(n_basis=5), 1.0), (DMP(spring=150.0, time_scale=2.0), 1.7), (None, 0.6)],
)
def test_other_movements_end_at_their_goals_too(dmp, end_time):
    model = projected(dmp=dmp, end_time=end_time)
    found = model.project(rng.normal(0, 30, (7, (dmp or DMP()).n_params)))
    goals = rng.normal(size=(7, 2))
    assert_allclose(ends(found, goals, dmp, end_time), goals, atol=1e-9)


# The nearest point


@few
@given(seeds)
def test_a_policy_that_ends_there_does_not_move(seed):
    draws, metric = draw(seed)
    model = projected(metric)
    there = model.project(draws.normal(0, 30, (4, 6)))
    assert_allclose(model.project(there), there, atol=1e-9)
    assert_allclose(projected().project(there), there, atol=1e-9)


@few
@given(seeds, st.floats(-3, 3))
def test_the_projection_is_affine(seed, share):
    draws, metric = draw(seed)
    one, other = draws.normal(0, 30, (2, 6))
    project = projected(metric).project
    mixed = project([share * one + (1 - share) * other])[0]
    apart = share * project([one])[0] + (1 - share) * project([other])[0]
    assert_allclose(mixed, apart, atol=1e-8)


@few
@given(seeds)
def test_no_other_policy_that_ends_there_is_nearer(seed):
    draws, metric = draw(seed)
    given = draws.normal(0, 30, 6)
    model = projected(metric)
    nearest = model.project([given])[0]
    others = model.project(nearest + draws.normal(0, 10, (20, 6)))

    def length(policy):
        return np.einsum("...i,ij,...j", policy - given, metric, policy - given)

    assert (length(others) >= length(nearest) - 1e-9).all()


def test_an_optimiser_finds_the_same():
    draws, metric = draw(1)
    given = draws.normal(0, 3, 6)

    def length(policy):
        return (policy - given) @ metric @ (policy - given)

    at_goal = {
        "type": "eq",
        "fun": lambda policy: ends(policy, [0.1, 0.2]) - [0.1, 0.2],
    }
    found = minimize(length, given, constraints=at_goal, tol=1e-12)
    assert_allclose(projected(metric).project([given])[0], found.x, atol=1e-4)


def test_a_gaussian_that_is_conditioned_on_the_end_has_the_same_mean():
    """Among policies that end there the density is greatest at the projection."""
    draws, metric = draw(2)
    given = draws.normal(0, 3, 6)
    model = projected(metric)
    density = multivariate_normal(given, np.linalg.inv(metric)).logpdf
    nearest = model.project([given])
    around = model.project(nearest + draws.normal(0, 0.1, (500, 6)))
    assert density(nearest[0]) > density(around).max()
    assert_allclose(density(2 * nearest - around), density(around))


# Manners


def test_standard_deviations_are_what_draws_say():
    method = ParameterizedSkill(None, random_state=0)
    model = GoalProjected(method, metric=draw(3)[1]).fit(tasks, policies)
    mean, std = model.predict([[2.2]], return_std=True)
    plain, spread = model.estimator_.predict([[2.2]], return_std=True)
    drawn = model.project(rng.normal(plain[0], spread[0], (200_000, 6)))
    assert_allclose(mean, model.predict([[2.2]]))
    assert_allclose(std[0], drawn.std(axis=0), rtol=0.01)


def test_no_standard_deviation_is_made_up():
    model = GoalProjected(LinearRegression()).fit(tasks, policies)
    with pytest.raises(ValueError, match=r"needs a method whose predict.*LinearReg"):
        model.predict(tasks, return_std=True)
    model = GoalProjected(CrKR()).fit(tasks, policies)
    message = r"for each weight, of shape \(15, 6\). Got \(15,\) from CrKR\(\)"
    with pytest.raises(ValueError, match=message):
        model.predict(tasks, return_std=True)


def test_the_cost_reaches_a_method_that_takes_it():
    cost = rng.uniform(0.1, 5, 15)
    given = GoalProjected(CrKR()).fit(tasks, policies, cost)
    alone = CrKR().fit(tasks, policies, cost)
    assert_allclose(given.predict(tasks), given.project(alone.predict(tasks)))
    GoalProjected(LinearRegression()).fit(tasks, policies, cost)


def test_parameters_reach_the_method():
    model = GoalProjected(CrKR(), metric=np.eye(6))
    assert model.get_params()["estimator__ridge"] == 0.5
    copy = clone(model.set_params(estimator__ridge=0.1, end_time=0.8))
    assert copy.estimator.ridge == 0.1
    assert copy.end_time == 0.8
    assert not hasattr(copy, "estimator_")
    fitted = model.fit(tasks, policies)
    assert not hasattr(model.estimator, "dual_coef_")  # a clone was fitted
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict(tasks), fitted.predict(tasks))
    assert fitted.n_features_in_ == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"metric": np.eye(5)}, r"metric must be .*\(6, 6\). Got shape \(5, 5\)"),
        ({"metric": np.tri(6)}, "metric must be .* Got one that is not symmetric"),
        ({"metric": -np.eye(6)}, "metric must be .* Got another .*positive def"),
        ({"dmp": DMP(n_basis=4)}, r"y has shape \(15, 6\); wanted \(n_tasks, 8\)"),
        ({"end_time": 0.0}, "end_time=0.0; wanted a positive number"),
    ],
)
def test_bad_parameters(options, message):
    with pytest.raises(ValueError, match=message):
        GoalProjected(LinearRegression(), **options).fit(tasks, policies)


def test_bad_data():
    with pytest.raises(TypeError, match="dmp=16; wanted a DMP"):
        GoalProjected(LinearRegression(), 16).fit(tasks, policies)
    with pytest.raises(ValueError, match=r"y has shape \(15,\); wanted \(n_tasks, 6"):
        GoalProjected(LinearRegression()).fit(tasks, policies[:, 0])
    with pytest.raises(ValueError, match=r"X has 2 features, but GoalProjected is exp"):
        GoalProjected(LinearRegression()).fit(tasks, policies).predict([[0.0, 1.0]])
    with pytest.raises(ValueError, match="cost must be positive"):
        GoalProjected(CrKR()).fit(tasks, policies, np.zeros(15))
