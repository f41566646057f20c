import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import LinAlgError
from scipy.optimize import approx_fprime
from scipy.sparse import csr_array
from scipy.spatial.distance import cdist
from scipy.stats import multivariate_normal
from sklearn.base import clone
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF
from sklearn.kernel_ridge import KernelRidge
from sklearn.utils.estimator_checks import (
    check_dataframe_column_names_consistency,
    parametrize_with_checks,
)
from weights import hold

from msc import CrKR
from msc.study.rivals._crkr import _negative_log_likelihood

reference = np.load(Path(__file__).parent / "golden" / "crkr_uniform_cost.npz")

rng = np.random.default_rng(0)
tasks = np.sort(rng.uniform(0, 6, (25, 1)), axis=0)
policies = np.c_[np.sin(tasks), 3 * np.cos(2 * tasks)] + rng.normal(0, 0.1, (25, 2))
cost = rng.uniform(0.2, 5, 25)
new_tasks = np.linspace(-1, 7, 40)[:, None]


# The formulas


def test_reference():
    model = CrKR(float(reference["sigma"]), float(reference["lam"]))
    model.fit(reference["S"], reference["D"], reference["cost"])
    mean, std = model.predict(reference["Sq"], return_std=True)
    np.testing.assert_allclose(mean, reference["mean"], atol=1e-13)
    np.testing.assert_allclose(std, reference["std"], atol=1e-13)
    np.testing.assert_allclose(std**2, reference["var"], atol=1e-13)


positive = st.floats(0.05, 5)
few = settings(max_examples=20, deadline=None)


@few
@given(positive, positive)
def test_equal_costs_make_kernel_ridge_regression(length_scale, ridge):
    ours = CrKR(length_scale, ridge).fit(tasks, policies)
    gamma = 1 / (2 * length_scale**2)
    theirs = KernelRidge(alpha=ridge, kernel="rbf", gamma=gamma).fit(tasks, policies)
    expected = theirs.predict(new_tasks)
    np.testing.assert_allclose(ours.predict(new_tasks), expected, atol=1e-10)
    np.testing.assert_allclose(ours.dual_coef_, theirs.dual_coef_, atol=1e-10)


@few
@given(positive, positive, st.integers(0, 2**31))
def test_costs_are_the_noise_of_a_gaussian_process(length_scale, ridge, seed):
    costs = np.random.default_rng(seed).uniform(0.1, 10, len(tasks))
    ours = CrKR(length_scale, ridge).fit(tasks, policies[:, 0], costs)
    theirs = GaussianProcessRegressor(
        RBF(length_scale), alpha=ridge * costs, optimizer=None
    ).fit(tasks, policies[:, 0])
    mean, std = ours.predict(new_tasks, return_std=True)
    gp_mean, gp_std = theirs.predict(new_tasks, return_std=True)
    np.testing.assert_allclose(mean, gp_mean, atol=1e-10)
    np.testing.assert_allclose(std**2, gp_std**2 + ridge, atol=1e-9)


@few
@given(positive)
def test_only_ridge_times_cost_matters_for_the_mean(factor):
    one = CrKR(ridge=0.5 * factor).fit(tasks, policies, cost)
    other = CrKR(ridge=0.5).fit(tasks, policies, factor * cost)
    np.testing.assert_allclose(one.predict(tasks), other.predict(tasks), atol=1e-12)


def test_a_costly_sample_counts_for_little():
    dear = np.ones(25)
    dear[12] = 1e9
    kept = np.delete(np.arange(25), 12)
    with_it = CrKR(ridge=0.1).fit(tasks, policies, dear)
    without = CrKR(ridge=0.1).fit(tasks[kept], policies[kept])
    np.testing.assert_allclose(
        with_it.predict(new_tasks), without.predict(new_tasks), atol=1e-6
    )


def test_far_from_all_tasks_nothing_is_known():
    mean, std = CrKR(ridge=0.5).fit(tasks, policies).predict([[99.0]], return_std=True)
    np.testing.assert_allclose(mean, [[0, 0]], atol=1e-12)
    np.testing.assert_allclose(std, np.sqrt(1.5))


# Tuning


@pytest.mark.parametrize("point", [[0.0, -2.0], [0.5, -5.0], [-1.0, 0.3]])
def test_likelihood_is_greatest_over_the_signal_variance(point):
    length_scale, noise = np.exp(point)
    gram = np.exp(-cdist(tasks, tasks, "sqeuclidean") / (2 * length_scale**2))
    gram += noise * np.diag(cost)
    squares = cdist(tasks, tasks, "sqeuclidean")

    def ours(z):
        return _negative_log_likelihood(z, squares, policies, cost)[0]

    def best(y):
        variances = np.exp(np.linspace(-15, 15, 3001))
        weight, logdet = y @ np.linalg.solve(gram, y), np.linalg.slogdet(gram)[1]
        values = -0.5 * (
            weight / variances + logdet + 25 * np.log(2 * np.pi * variances)
        )
        at = variances[values.argmax()]
        exact = multivariate_normal(np.zeros(25), at * gram).logpdf(y)
        np.testing.assert_allclose(values.max(), exact)
        return values.max()

    constant = 25 * (1 + np.log(2 * np.pi))  # of two policy dimensions, 25 / 2 each
    expected = -best(policies[:, 0]) - best(policies[:, 1]) - constant
    np.testing.assert_allclose(ours(point), expected, atol=2e-3)
    gradient = _negative_log_likelihood(np.array(point), squares, policies, cost)[1]
    numerical = approx_fprime(np.array(point), ours, 1e-6)
    np.testing.assert_allclose(gradient, numerical, rtol=1e-3, atol=1e-3)


jumps = np.sin(tasks) + 5 * (tasks > 1) - 4 * (tasks > 3) + 2 * (tasks > 4.7)


@pytest.mark.parametrize("y", [policies, jumps, np.sin(4 * tasks)])
@pytest.mark.parametrize("costs", [None, cost, 1e6 * cost])
def test_tuned_values_are_the_likeliest(y, costs):
    model = CrKR(tune=True).fit(tasks, y, costs)
    used = np.ones(25) if costs is None else costs
    squares = cdist(tasks, tasks, "sqeuclidean")

    def value(length_scale, ridge):
        z = np.log([length_scale, ridge * used.mean()])
        return _negative_log_likelihood(z, squares, y, used / used.mean())[0]

    best = value(model.length_scale_, model.ridge_)
    grid = [
        value(length_scale, noise / used.mean())
        for length_scale in np.geomspace(0.01, 100, 17)
        for noise in np.geomspace(1e-8, 1e3, 12)
    ]
    assert best <= min(grid) + 1e-6


def test_tuning_ignores_the_scale_of_policies_and_of_cost():
    one = CrKR(tune=True).fit(tasks, policies, cost)
    other = CrKR(tune=True).fit(tasks, [10.0, 0.1] * policies, 7 * cost)
    np.testing.assert_allclose(other.length_scale_, one.length_scale_, rtol=1e-3)
    np.testing.assert_allclose(7 * other.ridge_, one.ridge_, rtol=1e-3)


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1e-120, 1e120, 1e150, 1e200])
def test_tuning_finds_the_same_at_extreme_scales(scale):
    one = CrKR(tune=True).fit(tasks, policies, cost)
    other = CrKR(tune=True).fit(tasks, policies * [1.0, scale], cost)
    np.testing.assert_allclose(other.length_scale_, one.length_scale_, rtol=1e-3)
    np.testing.assert_allclose(other.ridge_, one.ridge_, rtol=1e-3)
    np.testing.assert_allclose(
        other.predict(new_tasks) / [1.0, scale], one.predict(new_tasks), atol=1e-3
    )


def test_tuning_beats_the_defaults():
    def error(model):
        truth = np.c_[np.sin(new_tasks), 3 * np.cos(2 * new_tasks)][5:-5]
        found = model.fit(tasks, policies).predict(new_tasks[5:-5])
        return ((found - truth) ** 2).mean()

    assert error(CrKR(tune=True)) < 0.2 * error(CrKR())


@pytest.mark.parametrize(
    ("X", "y"),
    [
        ([[1.0]], [2.0]),
        ([[1.0], [1.0]], [2.0, 2.0]),
        ([[1.0], [2.0], [3.0]], [0.0, 0.0, 0.0]),
        (tasks, np.ones(25)),
        (np.repeat(tasks, 3, axis=0), np.repeat(policies, 3, axis=0)),
    ],
)
def test_tuning_on_awkward_data(X, y):
    mean, std = CrKR(tune=True).fit(X, y).predict(X, return_std=True)
    assert np.isfinite(mean).all()
    assert (std > 0).all()


def test_without_tuning_the_given_values_are_used():
    model = CrKR(2.0, 0.1).fit(tasks, policies)
    assert (model.length_scale_, model.ridge_) == (2.0, 0.1)


def test_too_many_digits_lost_is_as_unlikely_as_can_be():
    squares = np.zeros((3, 3))
    value, gradient = _negative_log_likelihood(
        np.array([0.0, -80.0]), squares, np.ones((3, 1)), np.ones(3)
    )
    assert value == np.inf
    np.testing.assert_array_equal(gradient, [0, 0])


# Errors


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"length_scale": 0}, "'length_scale' parameter of CrKR.*Got 0"),
        ({"ridge": -0.5}, "'ridge' parameter of CrKR.*Got -0.5"),
        ({"ridge": np.nan}, "'ridge' parameter of CrKR.*Got nan"),
        ({"length_scale": np.inf}, "'length_scale' parameter of CrKR.*Got inf"),
        ({"tune": "yes"}, "'tune' parameter of CrKR.*Got 'yes'"),
    ],
)
def test_parameters_out_of_range(parameters, message):
    with pytest.raises(ValueError, match=message):
        CrKR(**parameters).fit(tasks, policies)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (np.zeros(25), "cost must be positive and finite. Got 0.0"),
        (-cost, "cost must be positive and finite. Got -"),
        (np.full(25, np.nan), "cost must be positive and finite. Got nan"),
        (np.full(25, np.inf), "cost must be positive and finite. Got inf"),
        (np.r_[cost[:-1], 0], "cost must be positive and finite. Got 0.0"),
        (np.r_[-1.5, cost[1:]], "cost must be positive and finite. Got -1.5"),
        (np.r_[cost[:-1], np.nan], "cost must be positive and finite. Got nan"),
        (cost[:-1], r"cost must have shape \(25,\), one entry.*Got shape \(24,\)"),
        (np.ones((25, 2)), r"cost must have shape \(25,\).*Got shape \(25, 2\)"),
        (3.0, r"cost must have shape \(25,\).*Got shape \(\)"),
        (["dear"] * 25, "cost must hold numbers: could not convert.*'dear'"),
        ([None] * 24 + [{}], "cost must hold numbers: float"),
    ],
)
def test_costs_out_of_range(bad, message):
    with pytest.raises(ValueError, match=message):
        CrKR().fit(tasks, policies, bad)


def test_data_out_of_range():
    with pytest.raises(ValueError, match="inconsistent numbers of samples"):
        CrKR().fit(tasks, policies[:-1])
    with pytest.raises(ValueError, match="Input X contains NaN"):
        CrKR().fit([[np.nan]], [1.0])
    with pytest.raises(ValueError, match="Input y contains NaN"):
        CrKR().fit([[1.0]], [np.nan])
    with pytest.raises(ValueError, match="Input X contains infinity"):
        CrKR().fit([[np.inf]], [1.0])
    with pytest.raises(ValueError, match="Input y contains infinity"):
        CrKR().fit([[1.0]], [-np.inf])
    with pytest.raises(ValueError, match=r"X must hold numbers.*'a'"):
        CrKR().fit([["a"]], [1.0])
    with pytest.raises(ValueError, match=r"y must hold numbers.*'b'"):
        CrKR().fit([[1.0]], [["b"]])
    with pytest.raises(TypeError, match="Sparse data was passed for y"):
        CrKR().fit(tasks, csr_array(policies))
    with pytest.raises(ValueError, match="Input X contains NaN"):
        CrKR().fit(tasks, policies).predict([[np.nan]])
    with pytest.raises(ValueError, match="X has 2 features, but CrKR is expecting 1"):
        CrKR().fit(tasks, policies).predict([[1.0, 2.0]])


def test_a_ridge_lost_in_rounding_names_the_remedy():
    with pytest.raises(LinAlgError, match="ridge=1e-30 is too small: increase it"):
        CrKR(ridge=1e-30).fit([[1.0], [1.0]], [1.0, 2.0])


# Manners


def test_shapes_follow_the_policies():
    for y, shape in ((policies, (40, 2)), (policies[:, 0], (40,))):
        mean, std = CrKR().fit(tasks, y).predict(new_tasks, return_std=True)
        assert mean.shape == CrKR().fit(tasks, y).predict(new_tasks).shape == shape
        assert std.shape == (40,)


def test_pickle_and_clone():
    model = CrKR(0.7, ridge=0.2, tune=True).fit(tasks, policies, cost)
    copy = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(copy.predict(tasks), model.predict(tasks))
    assert clone(model).get_params() == model.get_params()
    assert not hasattr(clone(model), "dual_coef_")


@pytest.mark.parametrize("given", [None, cost])
def test_a_weight_is_so_many_copies(given):
    times = rng.integers(0, 4, len(tasks))
    told = CrKR().fit(tasks, policies, given, sample_weight=times)
    X, y = (np.repeat(one, times, axis=0) for one in (tasks, policies))
    same = CrKR().fit(X, y, None if given is None else np.repeat(given, times))
    for one, other in zip(
        told.predict(new_tasks, True), same.predict(new_tasks, True), strict=True
    ):
        np.testing.assert_allclose(one, other, rtol=1e-8)


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        (np.ones(3), "one entry per task"),
        (np.r_[-1.0, np.ones(24)], "must not be negative. Got -1"),
        (np.zeros(25), "zero for all tasks"),
    ],
)
def test_bad_weights(weights, words):
    with pytest.raises(ValueError, match=words):
        CrKR().fit(tasks, policies, sample_weight=weights)


@parametrize_with_checks([CrKR(), CrKR(tune=True)])
def test_scikit_learn(estimator, check):
    check_name = "check_sample_weight_equivalence_on_dense_data"
    failing = {check_name: "copies tell of the noise"} if estimator.tune else {}
    hold(check, estimator, failing)


def test_names_of_columns_are_kept_and_compared():
    check_dataframe_column_names_consistency("CrKR", CrKR())


def test_what_is_done_to_the_data_afterwards_changes_nothing():
    X = np.linspace(0, 6, 9)[:, np.newaxis]
    model = CrKR().fit(X, np.sin(X[:, 0]))
    before = model.predict([[1.0]])
    X[:] = 0
    np.testing.assert_array_equal(model.predict([[1.0]]), before)
