"""One function from tasks to policies, searched on its mean cost."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone

from msc.study.rivals import MultiTaskSearch
from msc.study.rivals._trials import cosines

rng = np.random.default_rng(0)
X = 2 * np.pi * (np.arange(12)[:, None] + 0.5) / 12
new = np.linspace(0, 2 * np.pi, 30)[:, None]
best = np.hstack([2 * np.sin(X), np.where(X > 3, 1.0, -1.0)])  # no function of three
stiffness = np.array([[2.0, 0.5], [0.5, 1.0]])  # of every task,
weights = np.linspace(0.5, 2.0, 12)  # more or less


def execute(policies, X):
    which = np.rint(X[:, 0] * 12 / (2 * np.pi) - 0.5).astype(int)
    away = policies - best[which]
    return 0.1 + weights[which] * np.einsum("ni,ij,nj->n", away, stiffness, away)


def optimum(n_features):
    """Solve the normal equations: least squares, tasks weighted."""
    seen = cosines(X, n_features, (0, 2 * np.pi))
    root = np.sqrt(weights)[:, None]
    return np.linalg.lstsq(root * seen, root * best, rcond=None)[0].T


@pytest.mark.parametrize("from_policies", [False, True])
def test_quadratic_costs_make_it_weighted_least_squares(from_policies):
    model = MultiTaskSearch(
        execute=execute,
        n_features=3,
        from_policies=from_policies,
        step=1.0,
        random_state=0,
    ).fit(X, best)
    np.testing.assert_allclose(model.coef_, optimum(3), atol=0.01)
    predicted = cosines(new, 3, (0, 2 * np.pi)) @ optimum(3).T
    np.testing.assert_allclose(model.predict(new), predicted, atol=0.02)
    paid = execute(model.predict(X), X).mean()
    assert model.mean_cost_ == pytest.approx(paid, rel=1e-12)


def test_one_feature_makes_one_policy_for_all_tasks():
    model = MultiTaskSearch(execute=execute, n_features=1, step=1, random_state=0)
    mean = np.average(best, axis=0, weights=weights)
    np.testing.assert_allclose(model.fit(X, best).predict(new), [mean] * 30, atol=0.01)


def test_it_begins_at_the_fit_to_the_policies_or_at_zero():
    seen = []

    def first(policies, X):
        seen.append(policies)
        return execute(policies, X)

    given = {"execute": first, "n_features": 3, "step": 1e-9, "n_rollouts": 130}
    MultiTaskSearch(**given, random_state=0).fit(X, best)
    fit = np.linalg.lstsq(cosines(X, 3, (0, 2 * np.pi)), best, rcond=None)[0]
    expected = cosines(X, 3, (0, 2 * np.pi)) @ fit
    np.testing.assert_allclose(seen[0][:12], expected, atol=1e-6)
    seen.clear()
    MultiTaskSearch(**given, from_policies=False, random_state=0).fit(X, best)
    np.testing.assert_allclose(seen[0][:12], 0, atol=1e-6)


def test_a_first_step_is_that_of_policies():
    """Over tasks the standard deviation of the first policies is `step`."""
    seen = []

    def first(policies, X):
        seen.append(policies)
        return execute(policies, X)

    spread = []
    for seed in range(80):
        seen.clear()
        MultiTaskSearch(
            execute=first,
            n_features=3,
            step=5,
            n_rollouts=130,
            from_policies=False,
            random_state=seed,
        ).fit(X, best)
        spread.append(seen[0][:12])
    assert np.std(spread) == pytest.approx(5, rel=0.05)


def test_manners():
    model = MultiTaskSearch(n_features=3)
    assert clone(model).get_params() == model.get_params()
    fitted = MultiTaskSearch(execute=execute, n_features=1, random_state=0).fit(X, best)
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict(new), fitted.predict(new))
    with pytest.raises(ValueError, match=r"n_rollouts=50; wanted at least 84, a gen"):
        MultiTaskSearch(execute=execute, n_features=1, n_rollouts=50).fit(X, best)
    with pytest.raises(ValueError, match="X has 2 features, but MultiTaskSearch is"):
        fitted.predict(np.hstack([X, X]))
