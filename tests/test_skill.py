import pickle
import re
import warnings

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from joblib import parallel_config
from scipy.sparse import csr_array
from sklearn import config_context
from sklearn.base import BaseEstimator, ClusterMixin, clone
from sklearn.cluster import DBSCAN, KMeans
from sklearn.dummy import DummyClassifier
from sklearn.ensemble import RandomForestRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    RBF,
    ConstantKernel,
    RationalQuadratic,
    WhiteKernel,
)
from sklearn.kernel_ridge import KernelRidge
from sklearn.linear_model import LinearRegression, LogisticRegression
from sklearn.model_selection import GridSearchCV, cross_val_predict
from sklearn.neighbors import KNeighborsRegressor
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler
from sklearn.svm import SVR
from sklearn.utils.estimator_checks import (
    check_dataframe_column_names_consistency,
    parametrize_with_checks,
)
from weights import REFUSED, hold

import msc.learn._gaussian
from msc import SMCE, CrKR, ParameterizedSkill, load_dataset
from msc.learn import gaussian_process

pytestmark = pytest.mark.filterwarnings("ignore:The graph has")

tasks = np.linspace(0, 2 * np.pi, 48, endpoint=False)[:, None]
pieces = np.repeat([0, 1, 2], 16)
offsets = np.array([[0.0, 0.0], [6.0, -4.0], [-5.0, 5.0]])
policies = np.c_[np.sin(tasks), np.cos(tasks)] + offsets[pieces]
new_tasks = tasks[:-1] + 0.04


class Given(ClusterMixin, BaseEstimator):
    """Charts decided beforehand."""

    def __init__(self, labels=None):
        self.labels = labels

    def fit_predict(self, X, y=None):
        return np.asarray(self.labels)


class Refusing(Given):
    """Return labels as they were given."""

    def fit_predict(self, X, y=None):
        return self.labels

    def __repr__(self):
        return "Given()"


def fast(charts="smce", **parameters):
    parameters = {"regressor": KernelRidge(alpha=1e-6, kernel="rbf"), **parameters}
    return ParameterizedSkill(charts, random_state=0, **parameters)


# Charts


def test_charts_are_those_of_smce_on_the_policies():
    skill = fast().fit(tasks, policies)
    expected = SMCE(random_state=0).fit_predict(policies)
    np.testing.assert_array_equal(skill.charts_, expected)
    assert skill.n_charts_ == len(set(expected)) == len(skill.regressors_)
    np.testing.assert_array_equal(skill.clusterer_.labels_, expected)


@pytest.mark.parametrize("charts", [KMeans(3), SMCE(3, n_neighbors=6)])
def test_any_clusterer_finds_the_charts(charts):
    skill = fast(charts).fit(tasks, policies)
    assert skill.n_charts_ == 3
    assert len(set(zip(pieces, skill.charts_, strict=True))) == 3
    assert not hasattr(charts, "labels_")


def test_noise_is_a_chart_of_its_own():
    skill = fast(DBSCAN(eps=1, min_samples=3)).fit(
        np.r_[tasks, [[7.0]]], np.r_[policies, [[99.0, 99.0]]]
    )
    assert skill.clusterer_.labels_[-1] == -1
    assert skill.n_charts_ == 4
    assert (skill.charts_ == skill.charts_[-1]).sum() == 1


@settings(max_examples=8, deadline=None)
@given(st.lists(st.integers(-1, 3), min_size=48, max_size=48))
def test_each_chart_is_fitted_and_predicted_alone(labels):
    skill = fast(Given(labels)).fit(tasks, policies)
    np.testing.assert_array_equal(
        skill.charts_, np.unique(labels, return_inverse=True)[1]
    )
    predicted = skill.predict(new_tasks, chart=skill.charts_[:-1])
    for c in range(skill.n_charts_):
        mine = skill.charts_ == c
        if mine.sum() > 1:
            alone = clone(skill.regressor).fit(tasks[mine], policies[mine])
            expected = alone.predict(new_tasks[mine[:-1]].reshape(-1, 1))
        else:
            expected = np.broadcast_to(policies[mine], (mine[:-1].sum(), 2))
        np.testing.assert_allclose(predicted[mine[:-1]], expected, atol=1e-9)


def test_charts_save_what_a_single_regression_smears():
    truth = np.c_[np.sin(new_tasks), np.cos(new_tasks)] + offsets[pieces[:-1]]

    def error(skill, **known):
        predicted = skill.fit(tasks, policies).predict(new_tasks, **known)
        return ((predicted - truth) ** 2).mean()

    charts = ParameterizedSkill(KMeans(3), random_state=0)
    single = error(ParameterizedSkill(None))
    known = clone(charts).fit(tasks, policies).charts_[:-1]
    assert error(charts) < 0.1 * single
    assert error(charts, chart=known) < 1e-6


# One chart is a plain regression


@pytest.mark.parametrize("return_std", [False, True])
def test_one_chart_is_the_plain_gaussian_process(return_std):
    skill = ParameterizedSkill(None, random_state=0).fit(tasks, policies)
    predicted = skill.predict(new_tasks, return_std=return_std)
    plain = [gaussian_process().fit(tasks, y) for y in policies.T]
    expected = [gp.predict(new_tasks, return_std=return_std) for gp in plain]
    np.testing.assert_array_equal(predicted, np.stack(expected, axis=-1))
    assert isinstance(skill.gate_, DummyClassifier)
    assert skill.clusterer_ is None
    np.testing.assert_array_equal(skill.predict_chart(new_tasks), 0)


def test_a_given_regressor_is_cloned_per_chart_and_dimension():
    model = RandomForestRegressor(5)
    skill = fast(KMeans(3), regressor=model).fit(tasks, policies)
    flat = [regressor for chart in skill.regressors_ for regressor in chart]
    assert len({id(regressor) for regressor in flat}) == 6
    assert not hasattr(model, "estimators_")
    assert model.random_state is None
    again = clone(skill).fit(tasks, policies)
    np.testing.assert_array_equal(again.predict(tasks), skill.predict(tasks))


@pytest.mark.parametrize("charts", ["smce", None])
def test_one_dimension_in_one_dimension_out(charts):
    flat = fast(charts).fit(tasks, policies[:, 0])
    column = fast(charts).fit(tasks, policies[:, :1])
    assert flat.predict(new_tasks).shape == (47,)
    np.testing.assert_array_equal(
        flat.predict(new_tasks), column.predict(new_tasks)[:, 0]
    )


@pytest.mark.parametrize("n_task_params", [2, 3])
@pytest.mark.parametrize("n_params", [1, 3])
def test_tasks_of_several_parameters(n_task_params, n_params):
    grid = np.random.default_rng(0).uniform(0, 3, (40, n_task_params))
    y = np.c_[grid.sum(axis=1), np.sin(grid).prod(axis=1)][:, np.arange(n_params) % 2]
    skill = ParameterizedSkill(KMeans(2), random_state=0).fit(grid, y)
    mean, std = skill.predict(grid, return_std=True)
    assert mean.shape == std.shape == (40, n_params)
    np.testing.assert_allclose(mean, y, atol=0.1)
    assert skill.n_features_in_ == n_task_params
    copy = pickle.loads(pickle.dumps(skill))
    np.testing.assert_array_equal(copy.predict(grid), mean)


# The default Gaussian process


def likelihoods(y, X=tasks):
    """Compare ours with the best of many random restarts."""
    ours = gaussian_process()
    theirs = GaussianProcessRegressor(
        ours.kernel, normalize_y=True, n_restarts_optimizer=4, random_state=0
    )
    return [gp.fit(X, y).log_marginal_likelihood_value_ for gp in (ours, theirs)]


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@pytest.mark.parametrize("step", [2, 8])
def test_fixed_starts_find_what_many_random_ones_find(step):
    t = tasks[:, 0]
    for y in (
        np.sin(2 * t),
        np.sin(t) + 0.1 * np.random.default_rng(0).normal(size=48),
        policies[:, 0],
        np.sin(t) + 5 * (t > 1) - 4 * (t > 3) + 2 * (t > 4.7),
    ):
        ours, theirs = likelihoods(y[::step], tasks[::step])
        assert ours > theirs - 0.01


@pytest.mark.parametrize("y", [np.ones(48), tasks[:, 0], tasks[:, 0] ** 2])
@pytest.mark.parametrize("step", [1, 8])
def test_gaussian_process_follows_simple_shapes_without_a_warning(y, step):
    gp = gaussian_process().fit(tasks[::step], y[::step])
    inner = slice(0, 40)
    np.testing.assert_allclose(gp.predict(tasks[inner]), y[inner], atol=0.35)
    np.testing.assert_allclose(gp.predict(tasks[::step]), y[::step], atol=1e-2)


@pytest.mark.parametrize(
    "kernel",
    [
        RBF(),
        RBF() + WhiteKernel(),
        ConstantKernel() * RationalQuadratic() + WhiteKernel(),
    ],
)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_another_kernel_starts_from_its_own_values(kernel):
    y = np.sin(tasks[:, 0])
    ours = gaussian_process().set_params(kernel=kernel).fit(tasks, y)
    theirs = GaussianProcessRegressor(kernel, normalize_y=True).fit(tasks, y)
    best = theirs.log_marginal_likelihood_value_
    assert ours.log_marginal_likelihood_value_ >= best - 1e-6


def test_gaussian_process_has_no_randomness():
    one, other = (gaussian_process().fit(tasks, policies[:, 0]) for _ in range(2))
    np.testing.assert_array_equal(one.kernel_.theta, other.kernel_.theta)


def waves(n_tasks, n_params=3):
    """Return tasks, irregular, and policies that one kernel suits and another."""
    X = np.sort(np.random.default_rng(0).uniform(0, 6, (n_tasks, 1)), axis=0)
    return X, np.sin(X * (1 + np.arange(n_params)) + 0.1) + [0.0, 5.0, 0.0][:n_params]


# A kernel for each dimension, or one for all


@pytest.mark.parametrize("kernel", ["squared exponential", "matern", "periodic"])
def test_all_of_a_chart_share_length_scale_and_ratio_of_noise(kernel):
    X, y = waves(30)
    y = y + 0.05 * np.random.default_rng(1).normal(size=y.shape)
    charts, given = Given(X[:, 0] > 3), gaussian_process(kernel)
    skill = ParameterizedSkill(charts, regressor=given, kernel_per="chart").fit(X, y)
    for c, models in enumerate(skill.regressors_):
        mine = skill.charts_ == c
        amplitudes, scales, noises = np.exp([gp.kernel_.theta for gp in models]).T
        np.testing.assert_array_equal(scales, scales[0])
        np.testing.assert_allclose(noises / amplitudes, noises[0] / amplitudes[0], 1e-6)
        together = clone(given).fit(X[mine], y[mine])  # scikit-learn's, one amplitude
        found = sum(gp.log_marginal_likelihood_value_ for gp in models)
        assert found >= together.log_marginal_likelihood_value_ - 1e-3
        for gp, values in zip(models, y[mine].T, strict=True):
            alone = clone(given).fit(X[mine], values)
            best = alone.log_marginal_likelihood_value_
            assert gp.log_marginal_likelihood_value_ <= best + 1e-6


def test_with_one_kernel_a_linear_condition_is_kept():
    X, y = waves(14, 2)
    y = np.c_[y, 1 - y @ [0.3, 0.5]]
    errors = {}
    for kernel_per in ("param", "chart"):
        skill = ParameterizedSkill(None, kernel_per=kernel_per).fit(X, y)
        mean, std = skill.predict(X[:-1] + 0.2, return_std=True)
        errors[kernel_per] = np.abs(mean @ [0.3, 0.5, 1.0] - 1).max()
        assert (std > 0).all()
    assert errors["chart"] < 1e-9
    assert errors["param"] > 1e-6


def test_one_dimension_has_its_own_kernel_either_way():
    X, y = waves(20, 1)
    pair = [ParameterizedSkill(None, kernel_per=each) for each in ("param", "chart")]
    one, other = (skill.fit(X, y).predict(X + 0.1, return_std=True) for skill in pair)
    np.testing.assert_array_equal(one, other)


def test_a_given_regressor_is_fitted_once_a_chart_to_all_dimensions():
    given = GaussianProcessRegressor(RBF(), alpha=1e-3, optimizer=None)
    skill = fast(Given(pieces), regressor=given, kernel_per="chart")
    skill.fit(tasks, policies)
    assert [len(models) for models in skill.regressors_] == [1, 1, 1]
    alone = fast(Given(pieces), regressor=given).fit(tasks, policies)
    found = skill.predict(new_tasks, return_std=True)
    np.testing.assert_allclose(found, alone.predict(new_tasks, return_std=True))
    single = fast(regressor=SVR(), kernel_per="chart")
    with pytest.raises(
        ValueError, match=r"kernel_per='chart' .* regressor=SVR\(\) takes"
    ):
        single.fit(tasks, policies)
    assert single.fit(tasks, policies[:, 0]).predict(tasks).shape == (48,)
    with pytest.raises(ValueError, match="'kernel_per' parameter of ParameterizedSk"):
        fast(kernel_per="weight").fit(tasks, policies)


# Small charts


def test_a_chart_of_one_task_is_constant_and_unsure():
    skill = ParameterizedSkill(Given([0] * 47 + [1])).fit(tasks, policies)
    mean, std = skill.predict([[0.0], [9.0]], return_std=True, chart=[1, 1])
    np.testing.assert_array_equal(mean, policies[[47, 47]])
    np.testing.assert_allclose(std, [policies.std(axis=0)] * 2)


def test_a_single_task():
    mean, std = (
        ParameterizedSkill(None).fit([[1.0]], [[2.0, 3.0]]).predict([[5.0]], True)
    )
    np.testing.assert_array_equal(mean, [[2.0, 3.0]])
    np.testing.assert_array_equal(std, 0)


@pytest.mark.parametrize("kernel", [None, "matern"])
def test_a_chart_of_two_tasks_keeps_the_initial_hyper_parameters(kernel):
    given = gaussian_process(kernel) if kernel else None
    skill = ParameterizedSkill(None, regressor=given)
    skill.fit([[0.0], [1.0]], [[2.0], [3.0]])
    gp = skill.regressors_[0][0]
    initial = (given or gaussian_process()).kernel.theta
    np.testing.assert_array_equal(gp.kernel_.theta, initial)
    np.testing.assert_allclose(skill.predict([[0.0], [1.0]]), [[2], [3]], atol=2e-3)
    np.testing.assert_allclose(skill.predict([[0.5]]), [[2.5]])  # half-way: the mean


@pytest.mark.parametrize("n_tasks", [2, 3, 4, 5, 8])
def test_few_tasks(n_tasks):
    few = slice(0, 48, 48 // n_tasks)
    skill = ParameterizedSkill(random_state=0).fit(tasks[few], policies[few])
    mean, std = skill.predict(new_tasks, return_std=True)
    assert np.isfinite(mean).all()
    assert (std > 0).all()


def test_equal_tasks_and_equal_policies():
    for X, y in ((np.ones((9, 1)), policies[:9]), (tasks[:9], np.ones((9, 2)))):
        skill = ParameterizedSkill(random_state=0).fit(X, y)
        assert np.isfinite(skill.predict(X)).all()


# The gate


@pytest.mark.parametrize("gate", ["nearest", "svm", "gp", LogisticRegression()])
def test_every_gate_learns_contiguous_charts(gate):
    skill = fast(Given(pieces), gate=gate).fit(tasks, policies)
    charts = skill.predict_chart(tasks)
    assert (charts == pieces).mean() > 0.8
    if isinstance(gate, str):
        np.testing.assert_array_equal(charts, pieces)
    by_gate = skill.predict(tasks)
    np.testing.assert_array_equal(by_gate, skill.predict(tasks, chart=charts))


@pytest.mark.parametrize("gate", ["nearest", "svm", "gp"])
def test_every_gate_sees_a_narrow_chart(gate):
    narrow = np.repeat([0, 1, 2], [22, 4, 22])
    skill = fast(Given(narrow), gate=gate).fit(tasks, policies)
    np.testing.assert_array_equal(skill.predict_chart(tasks), narrow)


def test_nearest_gate_takes_the_nearest_training_task():
    skill = fast(Given(pieces)).fit(tasks, policies)
    found = skill.predict_chart(new_tasks)
    nearest = abs(new_tasks - tasks.T).argmin(axis=1)
    np.testing.assert_array_equal(found, pieces[nearest])


@pytest.mark.parametrize("gate", ["nearest", "svm", "gp"])
def test_a_gate_for_one_chart_is_trivial(gate):
    skill = fast(Given(np.zeros(48, int)), gate=gate).fit(tasks, policies)
    assert isinstance(skill.gate_, DummyClassifier)
    np.testing.assert_array_equal(skill.predict_chart(tasks), 0)


def test_known_charts_overrule_the_gate():
    skill = fast(Given(pieces)).fit(tasks, policies)
    here, there = (skill.predict([[0.5]], chart=[c])[0, 0] for c in (0, 1))
    assert abs(here - np.sin(0.5)) < 0.01
    assert abs(there - here) > 1


# Errors


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"charts": "kmeans"}, "'charts' parameter of ParameterizedSkill.*'kmeans'"),
        ({"charts": 4}, "'charts' parameter of ParameterizedSkill.*Got 4"),
        ({"gate": "magic"}, "'gate' parameter of ParameterizedSkill.*'magic'"),
        ({"gate": None}, "'gate' parameter of ParameterizedSkill.*Got None"),
        ({"regressor": "gp"}, "'regressor' parameter of ParameterizedSkill.*'gp'"),
        ({"charts": SMCE(49)}, "n_clusters=49 must be at most n_samples=48"),
        ({"charts": SMCE(form="printed")}, "'form' parameter of SMCE.*'printed'"),
        ({"charts": KMeans(49)}, "n_samples=48 should be >= n_clusters=49"),
    ],
)
def test_parameters_out_of_range(parameters, message):
    with pytest.raises(ValueError, match=message):
        ParameterizedSkill(**parameters).fit(tasks, policies)


@pytest.mark.parametrize(
    ("chart", "message"),
    [
        ([0, 1, 3], r"chart must hold integers from 0 to 2. Got \[3\]"),
        ([0, 1, -1], r"chart must hold integers from 0 to 2. Got \[-1\]"),
        ([0, 1, 0.5], r"chart must hold integers from 0 to 2. Got \[0.5\]"),
        ([0, 1, np.nan], r"chart must hold integers from 0 to 2. Got \[nan\]"),
        (["0", "1", "2"], "chart must hold integers from 0 to 2"),
        ([0, 1], r"chart must have shape \(3,\).*Got shape \(2,\)"),
        (1, r"chart must have shape \(3,\).*Got shape \(\)"),
        ([[0], [1], [2]], r"chart must have shape \(3,\).*Got shape \(3, 1\)"),
    ],
)
def test_known_charts_out_of_range(chart, message):
    skill = fast(Given(pieces)).fit(tasks, policies)
    with pytest.raises(ValueError, match=message):
        skill.predict(tasks[:3], chart=chart)


def test_data_out_of_range():
    with pytest.raises(ValueError, match="inconsistent numbers of samples"):
        fast().fit(tasks, policies[:-1])
    with pytest.raises(ValueError, match="Input X contains NaN"):
        fast().fit([[0.0], [np.nan]], policies[:2])
    with pytest.raises(ValueError, match="Input y contains NaN"):
        fast().fit(tasks[:2], [[0.0], [np.nan]])
    with pytest.raises(ValueError, match="Input X contains infinity"):
        fast().fit([[0.0], [np.inf]], policies[:2])
    with pytest.raises(ValueError, match="Input y contains infinity"):
        fast().fit(tasks[:2], [[0.0], [-np.inf]])
    with pytest.raises(ValueError, match=r"X must hold numbers.*'a'"):
        fast().fit([["a"], ["b"]], policies[:2])
    with pytest.raises(ValueError, match=r"y must hold numbers.*'b'"):
        fast().fit(tasks[:2], [["b"], ["c"]])
    with pytest.raises(TypeError, match="Sparse data was passed for y"):
        fast().fit(tasks, csr_array(policies))
    with pytest.raises(ValueError, match="Input X contains NaN"):
        fast(None).fit(tasks, policies).predict([[np.nan]])
    with pytest.raises(ValueError, match=r"X must hold numbers.*'a'"):
        fast(None).fit(tasks, policies).predict([["a"]])
    with pytest.raises(ValueError, match="minimum of 2 is required by SMCE"):
        fast().fit(tasks[:1], policies[:1])
    for scale in (1e-200, 1e150):
        with pytest.raises(ValueError, match="y must have its largest magnitude from"):
            fast().fit(tasks, scale * policies)
    with pytest.raises(ValueError, match="y must hold floats: int too large"):
        fast().fit(tasks[:2], [10**400, 1])
    with pytest.raises(ValueError, match="Input y contains infinity"):
        fast().fit(tasks[:2], np.array([1, 2]) * np.longdouble("1e400"))
    with pytest.raises(ValueError, match="X has 2 features"):
        fast(None).fit(tasks, policies).predict([[0.0, 1.0]])


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (np.zeros((48, 1), int), r"labels of shape \(48, 1\)"),
        (np.eye(48, 3), r"labels of shape \(48, 3\)"),
        ([0] * 47, r"labels of shape \(47,\)"),
        ([0] * 49, r"labels of shape \(49,\)"),
        ([], r"labels of shape \(0,\)"),
        (None, r"labels of shape \(\)"),
        (csr_array(np.zeros((48, 1))), r"labels of shape \(\)"),
        ([[0], [1, 2]] * 24, r"the label \[0\]"),
        ([0, "a"] * 24, "the label 'a'"),
        (["a", 0] * 24, "the label 'a'"),
        ([0, None] * 24, "the label None"),
        ([None] * 48, "the label None"),
        ([0.0, np.nan] * 24, "the label nan"),
        ([0.0, -np.inf] * 24, "the label -inf"),
        ([0, 1j] * 24, "the label 1j"),
        (pd.Series([1, pd.NA] * 24, dtype="Int64"), "the label <NA>"),
        ([(0, 1)] * 48, r"labels of shape \(48, 2\)"),
        (["a"] * 47 + [np.nan], "the label nan"),
        (["a", None] * 24, "the label None"),
        (np.ma.masked_array([0, 1] * 24, [False, True] * 24), "masked labels"),
        (np.ma.masked_all(48, dtype=int), "masked labels"),
    ],
)
def test_what_is_no_label_for_each_policy_is_refused(labels, message):
    wanted = "wanted one for each of the 48 policies: a number, or all strings"
    with pytest.raises(
        ValueError, match=rf"charts=Given.* returned {message}; {wanted}"
    ):
        fast(Refusing(labels)).fit(tasks, policies)


@pytest.mark.parametrize(
    "labels",
    [
        ["left", "right"] * 24,
        [0.0, 1.5] * 24,
        [False, True] * 24,
        [-1, 7] * 24,
        np.array([0, 1] * 24, dtype=object),
        np.array(["a", "b"] * 24, dtype=object),
        np.array([0, 1] * 24, dtype=np.uint8),
        pd.Series([3, 9] * 24, index=range(48, 0, -1)),
        pd.Categorical(["a", "b"] * 24),
        [0, 10**400] * 24,
        [0, 2**64] * 24,
        np.ma.masked_array([0, 1] * 24),
    ],
)
def test_labels_may_be_numbers_or_strings_of_any_kind(labels):
    skill = fast(Refusing(labels)).fit(tasks, policies)
    np.testing.assert_array_equal(skill.charts_, [0, 1] * 24)


class Writing(Given):
    def fit_predict(self, X):
        X[:] = 0.0
        return super().fit_predict(X)


def test_a_clusterer_cannot_change_the_policies():
    given = policies.copy()
    skill = fast(Writing(pieces)).fit(tasks, given)
    np.testing.assert_array_equal(given, policies)
    wanted = fast(Given(pieces)).fit(tasks, policies).predict(tasks)
    np.testing.assert_array_equal(skill.predict(tasks), wanted)


@pytest.mark.parametrize(
    ("skill", "name", "message"),
    [
        (fast(), "charts__n_clusters", r"charts='smce': pass charts=SMCE\(\)"),
        (fast(None), "charts__n_clusters", r"charts=None: pass charts=SMCE\(\)"),
        (fast(gate="svm"), "gate__C", r"gate='svm': pass gate=SVC\(\)"),
        (
            ParameterizedSkill(),
            "regressor__alpha",
            r"regressor=None: pass regressor=gauss",
        ),
    ],
)
def test_a_parameter_of_a_part_without_parameters_says_what_to_pass(
    skill, name, message
):
    with pytest.raises(ValueError, match=rf"{name} cannot be set while {message}"):
        clone(skill).set_params(**{name: 2})
    with pytest.raises(ValueError, match=rf"{name} cannot be set while {message}"):
        GridSearchCV(skill, {name: [2, 3]}, cv=2).fit(tasks, policies)


def test_parameters_of_the_charts_can_be_searched():
    order = np.random.default_rng(0).permutation(48)
    grid = {"charts": [SMCE(n_neighbors=6, max_clusters=1)]}
    grid |= {"charts__n_clusters": [1, 3]}
    found = GridSearchCV(fast(), grid, cv=3).fit(tasks[order], policies[order])
    assert found.best_params_["charts__n_clusters"] == 3
    assert fast().set_params(charts=SMCE(), charts__n_clusters=2).charts.n_clusters == 2
    with pytest.raises(ValueError, match="Invalid parameter 'chart' for estimator"):
        fast().set_params(chart__n_clusters=2)


def odd(kind):
    """Return policies of a kind that are no real numbers, and what is said of them."""
    y = policies[:, 0]
    times = pd.date_range("2020", periods=48)
    return {
        "complex": (y + 0j, "Complex data"),
        "complex list": ([[complex(value)] for value in y], "Complex data"),
        "complex objects": (
            np.array([*y[1:], np.complex64(1)], object),
            "Complex data",
        ),
        "complex frame": (pd.DataFrame({"a": y + 1j, "b": ["1"] * 48}), "Complex data"),
        "complex strings": (["1+2j"] * 48, "{0} must hold numbers: could not convert"),
        "dates": (times, "{0} must hold numbers. Got dates"),
        "durations": (times - times[0], "{0} must hold numbers. Got dates"),
        "date and number": (pd.DataFrame({0: y, 1: times}), "{0} must hold num"),
        "masked": (np.ma.masked_array(y, y > 0), "{0} must hold numbers. Got masked"),
        "categories": (pd.Series(["a", "b"] * 24).astype("category"), "{0} must hold"),
        "dictionaries": ([{"a": 1}] * 48, "{0} must hold numbers: float"),
        "ragged": ([[1, 2], [1]] * 24, "{0} must hold numbers: setting an array"),
        "sparse rows": ([csr_array(policies[:1])] * 48, "{0} must hold numbers: set"),
        "foreign": (Foreign(), "{0} must hold numbers: float"),
    }[kind]


class Foreign:
    """A column of another library that NumPy cannot read."""

    def __len__(self):
        return 48


@pytest.mark.parametrize("learner", [fast(None), CrKR(), SMCE()])
@pytest.mark.parametrize(
    "kind",
    """complex, complex list, complex objects, complex frame, complex strings, dates,
    durations, date and number, masked, categories, dictionaries, ragged, sparse rows,
    foreign""".replace("\n   ", "").split(", "),
)
def test_what_is_no_real_number_is_refused_by_name(learner, kind):
    values, message = odd(kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if not isinstance(learner, SMCE):
            with pytest.raises(ValueError, match=message.format("y")):
                clone(learner).fit(tasks, values)
            with pytest.raises((ValueError, TypeError), match=message.format("X")):
                clone(learner).fit(tasks, policies).predict(values)
        with pytest.raises((ValueError, TypeError), match=message.format("X")):
            clone(learner).fit(values, policies)


@pytest.mark.parametrize("learner", [fast(None), CrKR()])
def test_a_single_number_is_no_policy_for_each_task(learner):
    with pytest.raises(ValueError, match=r"y must hold one policy a task. Got 3\.0"):
        learner.fit(tasks, 3.0)


def test_a_known_chart_is_no_complex_number():
    skill = fast(Given(pieces)).fit(tasks, policies)
    with pytest.raises(ValueError, match="Complex data not supported: chart"):
        skill.predict(tasks[:1], chart=[1 + 0j])


def test_a_regressor_without_standard_deviation_says_so():
    skill = fast(None, regressor=KNeighborsRegressor()).fit(tasks, policies)
    with pytest.raises(ValueError, match=r"return_std=True.*KNeighborsRegressor"):
        skill.predict(tasks, return_std=True)


# Manners


def test_randomness_is_local_and_repeatable():
    before = pickle.dumps(np.random.get_state())  # noqa: NPY002
    for charts in ("smce", KMeans(3)):
        for seed in (None, np.random.RandomState(1), np.random.default_rng(1)):
            regressor = RandomForestRegressor(2)
            ParameterizedSkill(
                charts, gate="svm", regressor=regressor, random_state=seed
            ).fit(tasks, policies)
    assert pickle.dumps(np.random.get_state()) == before  # noqa: NPY002


def test_a_generator_is_asked_for_the_next_seed_as_a_random_state_is():
    for kind in (np.random.default_rng, np.random.RandomState):
        skill = fast(KMeans(3)).set_params(random_state=kind(1))
        seeds = [skill.fit(tasks, policies).clusterer_.random_state for _ in range(2)]
        again = clone(skill).set_params(random_state=kind(1)).fit(tasks, policies)
        assert seeds[0] == again.clusterer_.random_state != seeds[1]
    with pytest.raises(ValueError, match=r"'random_state' parameter.*Generator.*'1'"):
        fast().set_params(random_state="1").fit(tasks, policies)


def test_a_seed_of_ones_own_is_kept():
    charts = KMeans(3, random_state=7)
    assert fast(charts).fit(tasks, policies).clusterer_.random_state == 7
    assert fast(KMeans(3)).fit(tasks, policies).clusterer_.random_state == 0


@pytest.mark.parametrize("gate", ["nearest", "svm", "gp"])
def test_pickle_and_clone(gate):
    skill = fast(KMeans(3), gate=gate).fit(tasks[::2], policies[::2])
    copy = pickle.loads(pickle.dumps(skill))
    np.testing.assert_array_equal(copy.predict(tasks), skill.predict(tasks))
    fresh = clone(skill)
    assert not hasattr(fresh, "charts_")
    np.testing.assert_array_equal(
        fresh.fit(tasks[::2], policies[::2]).predict(tasks), skill.predict(tasks)
    )


def test_nothing_of_the_search_is_shared_between_fits():
    starts = msc.learn._gaussian.LENGTH_SCALES
    gp = GaussianProcessRegressor(RBF(2.0), optimizer=None)
    fast(None, regressor=gp).fit(tasks, policies)
    assert not hasattr(gp, "kernel_")
    assert starts == msc.learn._gaussian.LENGTH_SCALES == (0.2, 0.7, 2.5)


FIXED = GaussianProcessRegressor(RBF(), alpha=1e-3, optimizer=None)


def what_fails(skill):
    """Say which checks of scikit-learn need not hold, and why."""
    if skill.regressor is None or skill.kernel_per == "chart":
        return REFUSED
    check = "check_sample_weight_equivalence_on_dense_data"
    return {} if skill.charts is None else {check: "copies move the charts"}


@parametrize_with_checks(
    [
        ParameterizedSkill(None),
        ParameterizedSkill(KMeans(2), regressor=FIXED, kernel_per="chart"),
        ParameterizedSkill(SMCE(2, max_clusters=2), regressor=LinearRegression()),
        ParameterizedSkill(None, regressor=KernelRidge()),
    ]
)
def test_scikit_learn(estimator, check):
    hold(check, estimator, what_fails(estimator))


def test_weights_are_those_of_the_regressions():
    """Each chart's ridge as if alone, its tasks as often as they weigh."""
    times = np.random.default_rng(0).integers(0, 4, len(tasks))
    charts = KMeans(3, random_state=0)
    skill = ParameterizedSkill(charts, regressor=KernelRidge(kernel="rbf"))
    skill.fit(tasks, policies, sample_weight=times)
    np.testing.assert_array_equal(skill.charts_, skill.fit(tasks, policies).charts_)
    skill.fit(tasks, policies, sample_weight=times)
    for chart in range(3):
        here = skill.charts_ == chart
        X, y = (
            np.repeat(all_[here], times[here], axis=0) for all_ in (tasks, policies)
        )
        alone = KernelRidge(kernel="rbf").fit(X, y)
        found = skill.predict(new_tasks, chart=np.full(len(new_tasks), chart))
        np.testing.assert_allclose(found, alone.predict(new_tasks), rtol=1e-8)


@pytest.mark.parametrize("regressor", [None, KNeighborsRegressor(2)])
def test_a_regression_without_weights_says_so(regressor):
    name = "gaussian_process()" if regressor is None else repr(regressor)
    with pytest.raises(ValueError, match=re.escape(f"{name} takes no sample_weight")):
        ParameterizedSkill(regressor=regressor).fit(tasks, policies, pieces)


def test_weights_are_routed_and_a_skill_is_a_part_like_any():
    skill = ParameterizedSkill(None, regressor=KernelRidge(kernel="rbf"))
    frame = pd.DataFrame({"angle": tasks[:, 0], "mass": np.arange(48) % 7})
    weights = np.arange(48) % 5
    with config_context(enable_metadata_routing=True), parallel_config("threading"):
        scale = StandardScaler().set_fit_request(sample_weight=False)
        skill.set_fit_request(sample_weight=True)
        skill.set_score_request(sample_weight=True)
        line = Pipeline([("scale", scale), ("skill", skill)])
        search = GridSearchCV(line, {"skill__regressor__gamma": [0.1, 1.0]}, n_jobs=2)
        search.fit(frame, policies, sample_weight=weights)
        how = {"params": {"sample_weight": weights}}
        found = cross_val_predict(search.best_estimator_, frame, policies, **how)
    points = StandardScaler().fit_transform(frame)
    gamma = search.best_params_["skill__regressor__gamma"]
    alone = KernelRidge(kernel="rbf", gamma=gamma).fit(points, policies, weights)
    best = pickle.loads(pickle.dumps(search.best_estimator_))
    np.testing.assert_allclose(best.predict(frame), alone.predict(points))
    assert best.feature_names_in_.tolist() == ["angle", "mass"]
    assert found.shape == policies.shape


def test_polars_tables_are_taken_by_their_names():
    polars = pytest.importorskip("polars")
    X, y = polars.DataFrame({"angle": tasks[:, 0]}), polars.DataFrame(policies)
    skill = ParameterizedSkill(None).fit(X, y)
    assert skill.feature_names_in_.tolist() == ["angle"]
    same = ParameterizedSkill(None).fit(tasks, policies)
    np.testing.assert_array_equal(skill.predict(X), same.predict(tasks))
    with pytest.raises(ValueError, match="feature names"):
        skill.predict(X.rename({"angle": "angel"}))
    assert SMCE(3).fit(y).feature_names_in_.tolist() == [*y.columns]


def test_names_of_columns_are_kept_and_compared():
    check_dataframe_column_names_consistency("ParameterizedSkill", fast())


def test_names_of_task_parameters_are_kept_without_a_warning():
    tasks = pd.DataFrame({"angle": np.linspace(0, 6, 20)})
    skill = ParameterizedSkill(KMeans(2)).fit(tasks, np.sin(tasks.to_numpy()))
    assert skill.feature_names_in_.tolist() == ["angle"]
    assert skill.predict(tasks).shape == (20, 1)


def test_a_pipeline_hands_on_the_standard_deviation():
    tasks = np.linspace(0, 6, 12)[:, np.newaxis]
    process = GaussianProcessRegressor(RBF(), alpha=0.1, optimizer=None)
    pair = [
        ParameterizedSkill(None, regressor=regressor).fit(tasks, np.sin(tasks))
        for regressor in (process, make_pipeline(FunctionTransformer(), process))
    ]
    found = [skill.predict(tasks + 0.1, return_std=True) for skill in pair]
    np.testing.assert_allclose(*found)


# The scale of tasks


@pytest.mark.parametrize("scale", [1e-4, 1e3])
@pytest.mark.parametrize("learner", [ParameterizedSkill(None), CrKR(tune=True)])
def test_a_scale_on_which_nothing_is_learned_is_told(learner, scale):
    X = np.linspace(0, 1, 61)[:, None]
    y = np.hstack([np.sin(6 * X), np.cos(6 * X)])
    assert clone(learner).fit(X[::2], y[::2]).score(X[1::2], y[1::2]) > 0.999
    with pytest.warns(UserWarning, match="tasks span .* one unit"):
        learner.fit(scale * X[::2], y[::2])
    assert learner.score(scale * X[1::2], y[1::2]) < 0.1


@pytest.mark.parametrize(
    ("workspace", "noise", "n_copies"), [("free", 0.0, 4), ("obstacles", 1e-4, 2)]
)
def test_tasks_given_again_change_no_prediction(workspace, noise, n_copies):
    tasks, policies, _ = load_dataset(workspace)
    X, y, new = tasks[::12], policies[::12], tasks[6::60]
    step = noise * np.linalg.norm(np.diff(y, axis=0), axis=1).min()
    shake = step * np.random.default_rng(0).standard_normal((n_copies * len(y), 6))
    one = ParameterizedSkill(SMCE(4, random_state=0), random_state=0)
    many = clone(one).fit(X.repeat(n_copies, 0), y.repeat(n_copies, 0) + shake)
    one.fit(X, y)
    np.testing.assert_array_equal(many.charts_, one.charts_.repeat(n_copies))
    tolerance = 0.01 * np.std(y)
    np.testing.assert_allclose(many.predict(new), one.predict(new), atol=tolerance)
