"""What one would pick today: libraries, and what none of them has."""

import warnings
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline
from sklearn.base import clone
from sklearn.linear_model import LinearRegression
from sklearn.neighbors import KNeighborsRegressor
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc.study.rivals import RANGES, ChangePointProcess, todays_methods
from msc.study.rivals._interpolation import Interpolation, RadialBasis
from msc.study.rivals._local import FewNeighbours, LocalLinear
from msc.study.rivals._today import QuietNetwork, to_circle

few = settings(max_examples=20, deadline=None)
seeds = st.integers(0, 2**31)
tasks = np.linspace(0.1, 6.1, 13)[:, None]
policies = np.hstack([np.sin(tasks), 10 * np.cos(tasks)])
CHEAP = [
    "nearest neighbours",
    "local linear regression",
    "interpolation",
    "radial basis functions",
    "change points",
]
DEAR = ["random forest", "gradient boosting", "neural network"]


def draw(seed, n_task_params=1, n_tasks=15):
    draws = np.random.default_rng(seed)
    X = draws.uniform(0, 6, (n_tasks, n_task_params))
    return (
        X,
        draws.normal(0, 20, (n_tasks, 3)),
        draws.uniform(0.5, 5.5, (9, X.shape[1])),
    )


# Local linear regression


@few
@given(seeds, st.integers(1, 2), st.floats(0.3, 3))
def test_local_regression_is_a_weighted_one_about_each_task(seed, n_params, width):
    X, y, new = draw(seed, n_params)
    found = LocalLinear(width, ridge=1e-12).fit(X, y).predict(new)
    for x, row in zip(new, found, strict=True):
        apart = ((X - x) ** 2).sum(axis=1)
        weights = np.exp((apart.min() - apart) / (2 * width**2))
        alone = LinearRegression().fit(X, y, sample_weight=weights)
        assert_allclose(row, alone.predict([x])[0], rtol=1e-3, atol=1e-2)


@few
@given(seeds, st.integers(1, 3), st.floats(0.5, 50))
def test_what_is_linear_stays_so(seed, n_params, width):
    X, _, new = draw(seed, n_params)
    slope = np.arange(1.0, 2 * n_params + 1).reshape(n_params, 2)
    found = LocalLinear(width, ridge=1e-12).fit(X, X @ slope + 3).predict(new)
    assert_allclose(found, new @ slope + 3, atol=1e-3)


def test_the_widest_is_linear_regression_and_the_stiffest_a_weighted_mean():
    X, y, new = draw(0, 2)
    wide = LocalLinear(1e5, 1e-12).fit(X, y).predict(new)
    assert_allclose(wide, LinearRegression().fit(X, y).predict(new), atol=1e-5)
    stiff = LocalLinear(0.8, 1e9).fit(X, y).predict(new)

    def gaussian(apart):
        return np.exp(-(apart**2) / (2 * 0.8**2))

    mean = KNeighborsRegressor(len(X), weights=gaussian).fit(X, y).predict(new)
    assert_allclose(stiff, mean, rtol=1e-6)


# Neighbours


@pytest.mark.parametrize("weights", ["uniform", "distance"])
def test_neighbours_are_scikit_learn_s_and_never_more_than_there_are(weights):
    X, y, new = draw(1)
    for asked, used in [(4, 4), (15, 15), (99, 15)]:
        ours = FewNeighbours(asked, weights=weights).fit(X, y)
        theirs = KNeighborsRegressor(used, weights=weights).fit(X, y)
        np.testing.assert_array_equal(ours.predict(new), theirs.predict(new))
    assert FewNeighbours(99).fit(X, y).kneighbors()[1].shape == (15, 14)


# Interpolation


@few
@given(seeds, st.integers(2, 3))
def test_what_is_linear_is_met_inside_and_the_nearest_outside(seed, n_params):
    X, _, new = draw(seed, n_params, n_tasks=30)
    corners = np.stack(np.meshgrid(*[[-1.0, 7.0]] * n_params), -1).reshape(-1, n_params)
    X = np.vstack([X, corners])
    y = X @ np.arange(1.0, n_params + 1) + 3
    model = Interpolation().fit(X, y)
    assert_allclose(model.predict(new), new @ np.arange(1.0, n_params + 1) + 3)
    beyond = corners + np.sign(corners)
    assert_allclose(model.predict(beyond), y[30:])


def test_a_circle_is_gone_round():
    model = Interpolation(2 * np.pi).fit(tasks, policies)
    ends = tasks[-1, 0], 2 * np.pi + tasks[0, 0]
    between = np.linspace(*ends, 5)
    expected = np.linspace(policies[-1], policies[0], 5)
    assert_allclose(model.predict(between[:, None]), expected, atol=1e-12)
    assert_allclose(model.predict(between[:, None] - 2 * np.pi), expected, atol=1e-12)


def test_tasks_without_an_area_have_the_nearest_policy():
    on_a_line = np.hstack([tasks, 2 * tasks])
    for n_tasks in (1, 2, 13):
        model = Interpolation().fit(on_a_line[:n_tasks], policies[:n_tasks])
        nearest = KNeighborsRegressor(1).fit(on_a_line[:n_tasks], policies[:n_tasks])
        new = np.random.default_rng(0).uniform(0, 9, (20, 2))
        np.testing.assert_array_equal(model.predict(new), nearest.predict(new))


# Radial basis functions


@few
@given(seeds)
def test_on_a_line_cubes_make_the_natural_spline_and_distances_the_polygon(seed):
    draws = np.random.default_rng(seed)
    X = np.cumsum(draws.uniform(0.1, 1, (12, 1)), axis=0)
    y, new = draws.normal(size=(12, 2)), draws.uniform(X[0], X[-1], (30, 1))
    spline = CubicSpline(X[:, 0], y, bc_type="natural")(new[:, 0])
    found = RadialBasis("cubic").fit(X, y).predict(new)
    assert_allclose(found, spline, atol=1e-6)
    polygon = Interpolation().fit(X, y).predict(new)
    assert_allclose(RadialBasis("linear").fit(X, y).predict(new), polygon, atol=1e-8)


@pytest.mark.parametrize("kernel", RANGES["radial basis functions"]["kernel"])
@pytest.mark.parametrize("n_params", [1, 2])
def test_it_goes_through_all_policies_but_means_of_equal_tasks(kernel, n_params):
    X, y, _ = draw(2, n_params)
    X[4] = X[7]
    model = RadialBasis(kernel, epsilon=2.0).fit(X, y)
    y[[4, 7]] = y[[4, 7]].mean(axis=0)
    assert_allclose(model.predict(X), y, atol=1e-4)
    smooth = RadialBasis(kernel, smoothing=1.0).fit(X, y).predict(X)
    assert np.abs(smooth - y).max() > 1


def test_few_tasks_are_enough():
    assert RadialBasis().fit([[1.0]], [[2.0, 3.0]]).predict([[5.0]]).tolist() == [
        [2, 3]
    ]
    RadialBasis("cubic").fit([[0.0, 0.0], [1.0, 1.0]], [0.0, 1.0]).predict([[0.5, 0.5]])


# All of them


def test_each_chooses_among_what_the_table_has_for_it():
    found = todays_methods()
    assert list(found) == list(todays_methods(closed=True))
    for name, method in found.items():
        if name in ("interpolation", "change points"):
            continue
        asked = method.param_distributions
        last = {key.rpartition("__")[2]: values for key, values in asked.items()}
        assert last == RANGES[name]
        for key, values in asked.items():
            for value in values:
                clone(method.estimator).set_params(**{key: value})
    others = {"chart gate", "support vector regression", "movement mixture"}
    assert set(RANGES) == {*found, *others} - {"interpolation"}


@pytest.mark.parametrize(
    ("name", "closed"),
    [*product(CHEAP, [False, True]), *((name, True) for name in DEAR)],
)
def test_each_learns_a_curve(name, closed):
    y = policies if name in CHEAP else policies[:, 1]
    X = tasks
    if name == "gradient boosting":
        y = y[:, None]
    method = todays_methods(closed=closed)[name]
    if name in DEAR:
        search = method[-1] if closed else method
        search.set_params(n_iter=1)
    new = tasks[1:-1] + 0.05
    truth = np.hstack([np.sin(new), 10 * np.cos(new)])
    truth = truth if name in CHEAP else truth[:, [1]]
    found = method.fit(X, y).predict(new).reshape(truth.shape)
    assert ((found - truth) ** 2).mean() < 0.25 * truth.var()
    if not closed:
        return
    again = todays_methods(closed=True)[name]
    if name in DEAR:
        again[-1].set_params(n_iter=1)
    found_again = again.fit(X, y).predict(new).reshape(truth.shape)
    np.testing.assert_array_equal(found, found_again)
    if name != "change points":
        ends = method.predict([[0.0], [2 * np.pi]])
        assert_allclose(*ends, atol=1e-6)


def test_change_points_are_not_closed():
    assert isinstance(todays_methods(closed=True)["change points"], ChangePointProcess)


def test_the_circle_has_one_angle():
    assert_allclose(to_circle(np.array([[0.0], [np.pi / 2]])), np.eye(2), atol=1e-15)
    with pytest.raises(ValueError, match="X has 2 features; wanted the angle"):
        to_circle(np.zeros((3, 2)))


def test_a_network_may_run_out_of_iterations():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        network = QuietNetwork(hidden_layer_sizes=(4,), solver="lbfgs", max_iter=2)
        assert network.fit(tasks, policies).n_iter_ == 2


# Bad input


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (LocalLinear(0), "'width' parameter of LocalLinear"),
        (LocalLinear(ridge=0), "'ridge' parameter of LocalLinear"),
        (Interpolation(-1.0), "'period' parameter of Interpolation"),
        (RadialBasis("round"), "'kernel' parameter of RadialBasis"),
        (RadialBasis(epsilon=0), "'epsilon' parameter of RadialBasis"),
        (RadialBasis(smoothing=-1), "'smoothing' parameter of RadialBasis"),
    ],
)
def test_bad_parameters(model, message):
    with pytest.raises(ValueError, match=message):
        model.fit(tasks, policies)


def test_a_period_is_of_one_parameter():
    with pytest.raises(ValueError, match=r"period=1\.0, but X has 2 features"):
        Interpolation(1.0).fit([[0.0, 1.0]], [1.0])
    with pytest.raises(ValueError, match="X has 5 features; wanted at most 4"):
        Interpolation().fit(np.zeros((9, 5)), np.zeros(9))


@parametrize_with_checks(
    [LocalLinear(), Interpolation(), RadialBasis(), FewNeighbours(3)]
)
def test_scikit_learn(estimator, check):
    said = ""
    try:
        check(estimator)
    except (ValueError, AssertionError) as error:
        said = f"{error} {error.__context__}"
        if "wanted at most 4" not in said:
            raise
    if said:  # apart: telling of it from there, with all its causes, takes a second
        pytest.xfail("triangles of more than four parameters take hours")
