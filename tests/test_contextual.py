"""Contextual policy search: a CMA-ES that sees the task."""

import pickle

import cma
import numpy as np
import pytest
from sklearn.base import clone

from msc.study.rivals import ContextualSearch
from msc.study.rivals._contextual import Strategy, regress
from msc.study.rivals._trials import cosines

span = 0.0, 2 * np.pi
new = np.linspace(*span, 40)[:, None]
root = np.random.default_rng(0).normal(size=(3, 3))
bend = root @ root.T + 0.1 * np.eye(3)


def bowl(policies, best):
    away = policies - best
    return np.einsum("ni,ij,nj->n", away, bend, away)


def test_without_context_it_is_cma_es():
    """pycma's, of the same constants, told the same policies and costs."""
    ours = Strategy(np.full((1, 3), 2.0), 0.7, np.eye(3))
    theirs = cma.CMAEvolutionStrategy(
        np.full(3, 2.0),
        0.7,
        {
            "popsize": ours.n_policies,
            "CMA_active": False,
            "CSA_dampfac": 1,
            "verbose": -9,
            "seed": 1,
        },
    )
    np.testing.assert_allclose(theirs.sp.weights.positive_weights, ours.weights[:3])
    theirs.sp.c1, theirs.sp.cmu, theirs.sp.cc = ours.c_1, ours.c_mu, ours.c_c
    theirs.adapt_sigma.initialize(theirs)
    theirs.adapt_sigma.cs, theirs.adapt_sigma.damps = ours.c_sigma, ours.damping
    seen = np.ones((ours.n_policies, 1))
    for _ in range(40):
        policies = np.array(theirs.ask())
        costs = bowl(policies, np.arange(3))
        theirs.tell(policies, costs.tolist())
        ours.learn(seen, policies, costs)
        assert ours.sigma == pytest.approx(theirs.sigma, rel=5e-3)
        np.testing.assert_allclose(ours.mean[0], theirs.mean, atol=1e-4)
        np.testing.assert_allclose(ours.covariance, theirs.C, rtol=1e-2, atol=5e-3)
    assert ours.sigma < 0.2


def test_draws_are_normal_about_the_mean_of_their_task():
    strategy = Strategy(np.array([[1.0, 2.0, 3.0], [0.5, 0.0, -1.0]]), 0.3, bend)
    seen = np.tile([1.0, 2.0], (100_000, 1))
    drawn = strategy.draw(seen, np.random.default_rng(0))
    np.testing.assert_allclose(drawn.mean(axis=0), [2, 2, 1], atol=0.01)
    np.testing.assert_allclose(np.cov(drawn.T), 0.09 * bend, atol=5e-3)


def test_the_mean_moves_by_weighted_least_squares():
    rng = np.random.default_rng(1)
    seen, values = rng.normal(size=(30, 4)), rng.normal(size=(30, 2))
    weights = rng.uniform(0, 1, 30)
    scale = np.sqrt(weights)[:, None]
    expected = np.linalg.lstsq(scale * seen, scale * values, rcond=None)[0]
    np.testing.assert_allclose(regress(seen, values, weights), expected, atol=1e-4)


def test_policies_that_are_linear_in_the_features_are_found():
    coef = np.random.default_rng(2).normal(0, 3, (3, 4))

    def execute(policies, X):
        # Some tasks cost much more than others, whatever one does.
        best = cosines(X, 4, span) @ coef.T
        return 50 * np.cos(2 * X[:, 0]) + bowl(policies, best)

    model = ContextualSearch(execute=execute, n_features=4, step=1, random_state=0)
    model.fit(new, np.zeros((40, 3)))
    np.testing.assert_allclose(model.coef_, coef, atol=0.02)
    np.testing.assert_allclose(
        model.predict(new), cosines(new, 4, span) @ coef.T, atol=0.05
    )
    assert np.trace(model.covariance_) < 1e-4
    assert 19_900 < model.n_rollouts_ <= 20_000


def test_it_begins_at_the_fit_to_the_policies_or_at_zero():
    y = np.hstack([np.cos(new), 1 + 0 * new])
    given = {
        "execute": lambda policies, X: 0 * X[:, 0],
        "n_rollouts": 0,
        "n_features": 5,
    }
    fit = ContextualSearch(**given, from_policies=True).fit(new, y)
    np.testing.assert_allclose(fit.predict(new), y, atol=1e-9)
    zero = ContextualSearch(**given).fit(new, y)
    np.testing.assert_array_equal(zero.predict(new), np.zeros_like(y))


def test_the_number_of_policies_is_bolero_s():
    for n_features, n_params in ((1, 6), (2, 6), (8, 6), (3, 20)):
        context = n_features - 1
        expected = 4 + int(3 * np.log(n_params + context)) * (1 + 2 * context)
        strategy = Strategy(np.zeros((n_features, n_params)), 1.0, np.eye(n_params))
        assert strategy.n_policies == expected == len(strategy.weights)
        assert strategy.weights.sum() == pytest.approx(1)


def test_manners():
    model = ContextualSearch(n_features=3)
    assert clone(model).get_params() == model.get_params()
    given = {"execute": lambda policies, X: bowl(policies, 1), "n_rollouts": 100}
    fitted = ContextualSearch(**given, n_features=2, random_state=0)
    fitted.fit(new, np.zeros((40, 3))).execute = None
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict(new), fitted.predict(new))
    with pytest.raises(ValueError, match="X has 2 features, but ContextualSearch is"):
        fitted.predict(np.hstack([new, new]))
