"""Cost-regularized kernel regression with its practice, after Kober et al."""

import numpy as np
import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc import CrKR
from msc.study.rivals import PractisedCrKR

X = np.linspace(0, 6, 8)[:, None]
y = np.hstack([20 * np.sin(X), 5 + X])
start_costs = np.linspace(0.05, 0.4, 8)
new = np.linspace(-0.5, 6.5, 50)[:, None]


def execute(policies, X):
    best = np.hstack([20 * np.sin(X), 5 + X])
    return 0.05 + (((policies - best) / [10, 2]) ** 2).sum(axis=1)


class Squares:
    """Costs for estimator checks; told the same by every process."""

    def __call__(self, policies, X):
        return 1 + (policies**2).mean(axis=1)

    def __repr__(self):
        return "squares"


def test_without_practice_it_is_the_regression_of_standardised_policies():
    model = PractisedCrKR(execute=execute, n_rollouts=0, length_scale=0.7, beyond=False)
    model.fit(X, y, start_costs)
    mean, scale = y.mean(axis=0), y.std(axis=0)
    alone = CrKR(0.7).fit(X, (y - mean) / scale, start_costs)
    np.testing.assert_allclose(model.predict(new), alone.predict(new) * scale + mean)
    assert model.n_rollouts_ == 0


@pytest.mark.parametrize("n_together", [1, 4])
def test_every_draw_is_that_of_table_1(n_together):
    """Written out: K, C, means and variances by an inverse, sample after sample."""
    width, ridge = 0.8, 0.3
    model = PractisedCrKR(
        execute=execute,
        length_scale=width,
        ridge=ridge,
        beyond=False,
        n_rollouts=10,
        n_together=n_together,
        random_state=5,
    ).fit(X, y, start_costs)
    mean, scale = y.mean(axis=0), y.std(axis=0)
    noise = np.random.default_rng(5)
    S, G, C = X, (y - mean) / scale, start_costs

    def k(a, b):
        return np.exp(-((a - b.T) ** 2) / (2 * width**2))

    left = 10
    while left:
        n = min(left, n_together)
        left -= n
        states = noise.uniform(0, 6, (n, 1))
        normal = noise.standard_normal((n, 2))
        inverse = np.linalg.inv(k(S, S) + ridge * np.diag(C))
        drawn = []
        for state, step in zip(states, normal, strict=True):
            row = k(state[None], S)[0]
            sigma = np.sqrt(1 + ridge - row @ inverse @ row)
            drawn.append(row @ inverse @ G + sigma * step)
        S, G = np.vstack([S, states]), np.vstack([G, drawn])
        C = np.append(C, execute(np.array(drawn) * scale + mean, states))
    np.testing.assert_allclose(model.tasks_, S)
    np.testing.assert_allclose(model.policies_, G * scale + mean, rtol=1e-8)
    np.testing.assert_allclose(model.costs_, C, rtol=1e-7)


def test_trials_make_it_better_as_in_the_original_s_first_example():
    """From one demonstration, on tasks it was not given: errors fall with trials."""
    one, own = X[:1], y[:1] + np.array([3.0, 1.0])

    def missed(n_rollouts):
        model = PractisedCrKR(
            execute=lambda policies, X: execute(policies * [20, 5], X),
            beyond=False,
            n_rollouts=n_rollouts,
            span=(0.0, 6.0),
            random_state=1,
        ).fit(one, own / [20, 5], [5.0])
        return execute(model.predict(new[5:45]) * [20, 5], new[5:45]).mean()

    before, some, many = missed(0), missed(60), missed(400)
    assert many < some < before
    assert many < 0.35 * before


def test_costs_count_beyond_those_of_searched_policies():
    """Trials, which cost what tasks do, count as training tasks of no cost would."""
    found = PractisedCrKR(
        execute=lambda policies, X: 5 + X[:, 0],  # as searched, for every policy
        n_rollouts=30,
        random_state=0,
    ).fit(X, y, 5 + X[:, 0])
    least = np.full(len(found.costs_), 0.01 * (5 + X).mean())
    alone = CrKR().fit(found.tasks_, (found.policies_ - y.mean(0)) / y.std(0), least)
    np.testing.assert_allclose(
        found.predict(new), alone.predict(new) * y.std(0) + y.mean(0)
    )


def test_cheap_trials_count_and_dear_ones_do_not():
    """Of two policies of a task the mean is near the cheaper."""
    model = CrKR(1.0, 0.5).fit([[1.0], [1.0]], [[0.0], [1.0]], [100.0, 0.01])
    assert model.predict([[1.0]])[0, 0] == pytest.approx(1, abs=0.02)


def test_tuned_once_before_practice():
    given = {"execute": execute, "tune": True, "random_state": 0}
    before = PractisedCrKR(n_rollouts=0, **given).fit(X, y, start_costs).regressor_
    after = PractisedCrKR(n_rollouts=20, **given).fit(X, y, start_costs).regressor_
    assert before.length_scale_ == after.length_scale_ != 1
    assert before.ridge_ == after.ridge_ != 0.5


@parametrize_with_checks(
    [
        PractisedCrKR(
            execute=Squares(),
            n_rollouts=12,
            random_state=0,
        )
    ]
)
def test_scikit_learn(estimator, check):
    check(estimator)
