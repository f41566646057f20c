"""The Gaussian process with change points, after Garnett and others."""

from itertools import combinations, pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.stats import multivariate_normal
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc.study.rivals import RANGES, ChangePointProcess
from msc.study.rivals._changepoints import best_division, piece_evidence, to_kernel

few = settings(max_examples=15, deadline=None)
seeds = st.integers(0, 2**31)
tasks = np.linspace(0, 6, 25)[:, None]
broken = np.hstack([np.sin(tasks), np.cos(tasks)])
broken += 4 * (tasks > 1.9) - 6 * (tasks > 4.6)


def draw(seed, n_tasks=8):
    draws = np.random.default_rng(seed)
    X = np.sort(draws.uniform(0, 6, (n_tasks, 1)), axis=0)
    return X, draws.normal(size=(n_tasks, 2)) + 2 * (draws.uniform(0, 6) < X)


@few
@given(seeds, st.floats(0.2, 3), st.floats(1e-3, 0.1), st.floats(0.1, 10))
def test_a_piece_s_evidence_is_scikit_learn_s(seed, length_scale, noise, amplitude):
    X, y = draw(seed)
    found = piece_evidence(X, y, length_scale, noise, [amplitude])[0]
    kernel = to_kernel(length_scale, noise, amplitude)
    for i, j in [(0, 7), (2, 5), (3, 3), (6, 7)]:
        model = GaussianProcessRegressor(kernel, optimizer=None)
        model.fit(X[i : j + 1], y[i : j + 1])
        assert_allclose(found[i, j], model.log_marginal_likelihood_value_, rtol=1e-6)
    assert np.isneginf(found[np.tril_indices(8, -1)]).all()


@few
@given(seeds)
def test_no_division_of_all_is_likelier(seed):
    X, y = draw(seed)
    evidence = piece_evidence(X, y, 0.5, 1e-2, [1.0])[0]
    value, starts = best_division(evidence, np.diff(X[:, 0]))

    def brute(cuts):
        edges = [0, *cuts, 8]
        pieces = sum(evidence[i, j - 1] for i, j in pairwise(edges))
        return pieces - len(cuts) * np.log(7)

    every = [cuts for n in range(8) for cuts in combinations(range(1, 8), n)]
    assert len(every) == 2**7
    assert_allclose(value, max(map(brute, every)))
    assert_allclose(value, brute(starts[1:]))


def test_the_evidence_is_that_of_a_kernel_that_is_zero_across_change_points():
    model = ChangePointProcess().fit(tasks, broken)
    piece = np.searchsorted(model.change_points_, tasks[:, 0])
    gram = np.zeros((25, 25))
    for number, regressor in enumerate(model.regressors_):
        inside = np.outer(piece == number, piece == number)
        gram += regressor.kernel_(tasks) * inside
    targets = (broken - broken.mean(axis=0)) / broken.std(axis=0)
    told = sum(multivariate_normal(np.zeros(25), gram).logpdf(one) for one in targets.T)
    told -= len(model.change_points_) * np.log(24) + len(model.regressors_) * np.log(54)
    assert_allclose(model.log_evidence_, told, rtol=1e-6)


def test_breaks_are_found_where_they_are():
    model = ChangePointProcess().fit(tasks, broken)
    assert_allclose(model.change_points_, [1.875, 4.625])
    new = np.linspace(0, 6, 200)[:, None]
    truth = np.hstack([np.sin(new), np.cos(new)])
    truth += 4 * (new > 1.875) - 6 * (new > 4.625)
    assert np.abs(model.predict(new) - truth).max() < 0.1


def test_a_smooth_curve_is_not_broken_and_regressed_on_as_by_scikit_learn():
    smooth = np.sin(tasks[:, 0])
    model = ChangePointProcess().fit(tasks, smooth)
    assert model.change_points_.size == 0
    (piece,) = model.regressors_
    plain = GaussianProcessRegressor(piece.kernel_, optimizer=None, normalize_y=True)
    new = np.linspace(-1, 7, 30)[:, None]
    for one, other in zip(
        model.predict(new, return_std=True),
        plain.fit(tasks, smooth).predict(new, return_std=True),
        strict=True,
    ):
        assert_allclose(one, other, atol=1e-9)
    told = plain.log_marginal_likelihood_value_ - np.log(54)
    assert_allclose(model.log_evidence_, told, rtol=1e-4)


def test_no_setting_of_the_table_is_likelier_in_any_piece():
    model = ChangePointProcess().fit(tasks, broken)
    ranges = RANGES["change points"]
    edges = [0, 8, 19, 25]
    targets = (broken - broken.mean(axis=0)) / broken.std(axis=0)
    for (i, j), used in zip(pairwise(edges), model.regressors_, strict=True):
        for setting in product(*(ranges[k] for k in ("length_scale", "noise"))):
            for amplitude in ranges["amplitude"]:
                kernel = to_kernel(*setting, amplitude)
                other = GaussianProcessRegressor(kernel, optimizer=None)
                other.fit(tasks[i:j], targets[i:j])
                best = used.log_marginal_likelihood_value_
                assert other.log_marginal_likelihood_value_ <= best + 1e-2


def test_what_lies_beyond_a_change_point_has_no_influence():
    """But for the scale of policies."""
    moved = broken + 0.0
    moved[tasks[:, 0] > 4.6] = moved[tasks[:, 0] > 4.6][::-1]
    one, other = (ChangePointProcess().fit(tasks, y) for y in (broken, moved))
    assert_allclose(one.change_points_, other.change_points_)
    new = np.linspace(0, 4.5, 30)[:, None]
    assert_allclose(one.predict(new), other.predict(new), atol=1e-9)
    far = np.linspace(4.7, 6, 9)[:, None]
    assert np.abs(one.predict(far) - other.predict(far)).max() > 0.1


def test_equal_tasks_are_never_parted_and_order_does_not_matter():
    X = np.array([0, 1, 2, 2, 3, 4.0])[:, None]  # best parted between the equal ones
    y = np.array([0.0, 0, 0, 9, 9, 9])
    model = ChangePointProcess().fit(X, y)
    assert not np.isin(model.change_points_, X).any()
    order = np.random.default_rng(1).permutation(len(X))
    again = ChangePointProcess().fit(X[order], y[order])
    assert_allclose(again.change_points_, model.change_points_)
    assert_allclose(again.predict(tasks), model.predict(tasks), atol=1e-9)


def test_a_task_is_one_number():
    with pytest.raises(ValueError, match="X has 2 features; wanted one to break along"):
        ChangePointProcess().fit([[0.0, 1.0]], [1.0])


@parametrize_with_checks([ChangePointProcess()])
def test_scikit_learn(estimator, check):
    try:
        check(estimator)
    except (ValueError, AssertionError) as error:
        if "wanted one to break along" not in f"{error} {error.__context__}":
            raise
    else:
        return
    # Outside of the clause: pytest would parse the sources of all that led to it.
    pytest.xfail("the check's tasks have several parameters, here there is one")
