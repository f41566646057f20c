"""The mixture of movement primitives after Mülling, Kober, Kroemer and Peters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from sklearn.neighbors import KNeighborsRegressor
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc import DMP
from msc.study.rivals import RANGES, MovementMixture, tune

rng = np.random.default_rng(0)
few = settings(max_examples=25, deadline=None)
seeds = st.integers(0, 2**31)


def draw(seed, n_task_params=1, n_tasks=12):
    draws = np.random.default_rng(seed)
    X = draws.uniform(0, 6, (n_tasks, n_task_params))
    return X, draws.normal(0, 20, (n_tasks, 6)), draws.uniform(-1, 7, (8, X.shape[1]))


@few
@given(seeds, st.integers(1, 3), st.floats(0.05, 5))
def test_shares_are_those_of_neighbours_weighted_by_a_gaussian(seed, n_params, width):
    X, y, new = draw(seed, n_params)

    def gaussian(apart):
        nearest = apart.min(axis=1, keepdims=True)  # cancels from the shares
        return np.exp((nearest**2 - apart**2) / (2 * width**2))

    theirs = KNeighborsRegressor(len(X), weights=gaussian).fit(X, y)
    ours = MovementMixture(width).fit(X, y)
    np.testing.assert_allclose(ours.predict(new), theirs.predict(new), atol=1e-6)


@few
@given(seeds, st.floats(0.5, 5))
def test_the_gate_is_exponential_in_the_task(seed, width):
    """Logarithms of two shares differ by a linear function of the task."""
    X, y, _ = draw(seed)
    gate = MovementMixture(width).fit(X, y).gate
    line = X.mean() + width**2 * np.linspace(-1, 1, 3)[:, None]
    logs = np.log(gate(line))
    curved = np.diff(logs - logs[:, :1], n=2, axis=0)
    np.testing.assert_allclose(curved, 0, atol=1e-7)


@few
@given(seeds)
def test_mixing_policies_is_mixing_what_the_primitives_say(seed):
    """At every moment: the movement of the mixture is the mean of the movements."""
    X, y, new = draw(seed)
    mixture = MovementMixture(0.7).fit(X, y)
    start, goal, times = [-0.6, -0.6], [0.1, 0.4], np.linspace(0, 1, 30)
    movements = DMP().path(y, start, goal, times)
    mixed = np.einsum("np,ptd->ntd", mixture.gate(new), movements)
    found = DMP().path(mixture.predict(new), start, goal, times)
    np.testing.assert_allclose(found, mixed, atol=1e-9)


def test_a_narrow_gate_picks_the_nearest_and_a_wide_one_the_mean():
    X, y, new = draw(1)
    nearest = y[cdist(new, X).argmin(axis=1)]
    found = MovementMixture(1e-3).fit(X, y).predict(new)
    np.testing.assert_allclose(found, nearest, atol=1e-6)
    found = MovementMixture(1e6).fit(X, y).predict(new)
    np.testing.assert_allclose(found, np.tile(y.mean(axis=0), (8, 1)), atol=1e-6)


@few
@given(seeds, st.floats(0.02, 5))
def test_a_mixture_stays_among_what_is_stored(seed, width):
    X, y, new = draw(seed)
    mixture = MovementMixture(width).fit(X, y)
    np.testing.assert_allclose(mixture.gate(new).sum(axis=1), 1)
    assert (mixture.gate(new) >= 0).all()
    assert (mixture.predict(new) <= y.max(axis=0) + 1e-9).all()
    assert (mixture.predict(new) >= y.min(axis=0) - 1e-9).all()


def test_practice_has_a_gate_to_change():
    X, y, new = draw(2)
    mixture = MovementMixture().fit(X, y)
    mixture.gate_weights_[3] += [1e4, 0]  # always the fourth
    np.testing.assert_allclose(mixture.predict(new), np.tile(y[3], (8, 1)))


def test_its_width_is_chosen_among_all_that_the_table_has():
    X = np.linspace(0, 6, 40)[:, None]
    found = tune(MovementMixture(), "movement mixture").fit(X, np.sin(X))
    assert found.cv_results_["params"] == [
        {"width": width} for width in RANGES["movement mixture"]["width"]
    ]
    assert 0.04 <= found.best_params_["width"] <= 0.3
    noisy = np.sin(X) + rng.normal(0, 1, X.shape)
    wider = tune(MovementMixture(), "movement mixture").fit(X, noisy)
    assert wider.best_params_["width"] > found.best_params_["width"]


def test_bad_parameters():
    for bad in (0, -1.0, np.nan, "wide"):
        with pytest.raises(ValueError, match="'width' parameter of MovementMixture"):
            MovementMixture(bad).fit([[0.0]], [1.0])


@parametrize_with_checks([MovementMixture()])
def test_scikit_learn(estimator, check):
    check(estimator)
