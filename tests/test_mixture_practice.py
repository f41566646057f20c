"""The mixture of movement primitives after practice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.linear_model import LogisticRegression
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc.study.rivals import MovementMixture, PractisedMixture
from msc.study.rivals._mixture_practice import draw_shares, regress_gate

few = settings(max_examples=10, deadline=None)
X = np.linspace(0, 6, 24)[:, None]
new = np.linspace(0, 6, 301)[:, None]


def right(X):
    return np.where(X < 3.1, np.sin(X), 5 + np.cos(X))  # jumps


def execute(policies, X):
    return 0.05 + np.minimum((policies - right(X))[:, 0] ** 2, 4)


class Squares:
    """Costs for estimator checks; told the same by every process."""

    def __call__(self, policies, X):
        return 1 + (policies**2).mean(axis=1)

    def __repr__(self):
        return "squares"


def test_without_practice_it_is_the_mixture():
    model = PractisedMixture(execute=execute, n_rollouts=0, width=0.2).fit(X, right(X))
    alone = MovementMixture(0.2).fit(X, right(X))
    np.testing.assert_array_equal(model.predict(new), alone.predict(new))


@few
@given(st.integers(0, 2**31), st.floats(0.1, 10))
def test_the_gate_is_a_logistic_regression_weighted_by_rewards(seed, strength):
    """Scikit-learn's: each trial once a movement, its weight reward times share."""
    rng = np.random.default_rng(seed)
    seen = np.column_stack([np.ones(40), rng.uniform(-3, 3, 40)])
    shares, rewards = rng.dirichlet(np.ones(4), 40), rng.uniform(0, 1, 40)
    found = regress_gate(seen, shares, rewards, np.zeros((4, 2)), strength)
    theirs = LogisticRegression(
        C=1 / strength, fit_intercept=False, tol=1e-10, max_iter=5000
    ).fit(
        np.repeat(seen, 4, axis=0),
        np.tile(np.arange(4), 40),
        sample_weight=(rewards[:, None] * shares).ravel(),
    )
    np.testing.assert_allclose(found, theirs.coef_, atol=1e-4)


def test_shares_drawn_are_those_of_the_gate_on_average():
    """Their moments are a Dirichlet's."""
    gate = np.tile([0.7, 0.2, 0.1, 0.0], (20_000, 1))
    drawn = draw_shares(np.random.default_rng(0), gate, 9.0)
    np.testing.assert_allclose(drawn.sum(axis=1), 1)
    np.testing.assert_allclose(drawn.mean(axis=0), gate[0], atol=5e-3)
    variance = gate[0] * (1 - gate[0]) / 10
    np.testing.assert_allclose(drawn.var(axis=0), variance, atol=1e-3)
    alone = draw_shares(np.random.default_rng(0), gate, 1e-4)  # one movement each
    assert (alone.max(axis=1) > 0.99).mean() > 0.99
    np.testing.assert_allclose(alone.mean(axis=0), gate[0], atol=1e-2)


def test_where_all_trials_pay_alike_the_gate_learns_nothing():
    given = {"width": 0.3, "n_rollouts": 400, "concentration": 1e6, "random_state": 0}
    alike = PractisedMixture(execute=lambda policies, X: np.ones(len(X)), **given)
    before = MovementMixture(0.3).fit(X, right(X)).gate(new)
    np.testing.assert_allclose(alike.fit(X, right(X)).gate(new), before, atol=5e-3)


def test_a_movement_that_always_fails_loses_its_tasks():
    stored = right(X)
    stored[5] = 50.0
    given = {"execute": execute, "width": 0.2, "random_state": 0}
    before = PractisedMixture(n_rollouts=0, **given).fit(X, stored)
    after = PractisedMixture(n_rollouts=900, n_together=50, **given).fit(X, stored)
    assert before.gate(X)[5, 5] > 0.5
    assert after.gate(X)[5, 5] < 0.1
    paid = [execute(model.predict(new), new).mean() for model in (before, after)]
    assert paid[1] < 0.75 * paid[0]


def test_practice_makes_it_cheaper_where_mixtures_fail():
    ratios = []
    for seed in range(2):
        given = {
            "execute": execute,
            "width": 0.6,
            "random_state": seed,
            "n_together": 50,
        }
        paid = [
            execute(model.fit(X, right(X)).predict(new), new).mean()
            for model in (
                PractisedMixture(n_rollouts=0, **given),
                PractisedMixture(n_rollouts=700, **given),
            )
        ]
        ratios.append(paid[1] / paid[0])
    assert np.mean(ratios) < 0.9
    assert max(ratios) < 1


def test_bad_parameters():
    for name in ("concentration", "temperature", "strength", "width"):
        with pytest.raises(ValueError, match=f"'{name}' parameter of PractisedMixture"):
            PractisedMixture(**{name: 0.0}).fit(X, right(X))


@parametrize_with_checks(
    [
        PractisedMixture(
            execute=Squares(),
            n_rollouts=12,
            random_state=0,
        )
    ]
)
def test_scikit_learn(estimator, check):
    check(estimator)
