"""Gaussian processes against scikit-learn's, and the warning about tasks' scale."""

import pickle
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from sklearn.base import clone
from sklearn.cluster import KMeans
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    ConstantKernel,
    ExpSineSquared,
    WhiteKernel,
)
from sklearn.linear_model import LinearRegression

from msc import CrKR, ParameterizedSkill
from msc._checks import warn_of_scale
from msc.learn import gaussian_process

TURN = 2 * np.pi
KERNELS = ("squared exponential", "matern", "periodic")


def from_three_starts(obj_func, initial_theta, bounds):
    """Search as scikit-learn does, with the likeliest noise at each length scale."""
    found = []
    for length_scale in (0.2, 0.7, 2.5):
        starts = [np.log([1.0, length_scale, noise]) for noise in (1e-6, 1e-3, 0.1)]
        start = min(starts, key=lambda start: obj_func(start, eval_gradient=False))
        found.append(minimize(obj_func, start, jac=True, bounds=bounds))
    best = min(found, key=lambda each: each.fun)
    return best.x, best.fun


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 2**32),
    st.one_of(st.integers(1, 5), st.sampled_from([9, 24, 50])),
    st.sampled_from([(d, k) for d in (1, 2, 3) for k in KERNELS]),
    st.sampled_from(["smooth", "jump", "constant", "line"]),
    st.tuples(st.sampled_from([0.0, 0.0, 1e-4, 1e-2, 0.3]), st.booleans()),
)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@pytest.mark.filterwarnings("ignore:Predicted variances smaller than 0")
def test_as_likely_and_as_sure_as_scikit_learn(seed, n, design, shape, sample):
    rng, (n_columns, kernel) = np.random.default_rng(seed), design
    X, (noise, is_repeated) = rng.uniform(0, TURN, (n, n_columns)), sample
    if is_repeated:
        X = X[rng.integers(0, n, n)]
    y = np.sin(X).sum(axis=1) + 3 * (shape == "jump") * (X[:, 0] > 3)
    y = {"constant": np.full(n, 2.5), "line": X[:, 0]}.get(shape, y)
    y = y + noise * rng.normal(size=n)
    ours = gaussian_process(kernel).fit(X, y)
    theirs = GaussianProcessRegressor(
        ours.kernel, normalize_y=True, optimizer=from_three_starts
    ).fit(X, y)
    amplitude, _, floor = np.exp(ours.kernel_.theta)
    rounding = np.finfo(float).eps * n * amplitude / floor  # relative, of theirs
    best, found = (each.log_marginal_likelihood_value_ for each in (theirs, ours))
    assert found >= best - 1e-3 - n * rounding
    assert (ours.kernel_.bounds.T[0] <= ours.kernel_.theta).all()
    assert (ours.kernel_.theta <= ours.kernel_.bounds.T[1]).all()
    fixed = clone(theirs).set_params(kernel=ours.kernel_, optimizer=None).fit(X, y)
    again = clone(ours).set_params(kernel=ours.kernel_, optimizer=None).fit(X, y)
    new = rng.uniform(X.min(axis=0), X.max(axis=0), (50, X.shape[1]))
    expected, spread = fixed.predict(new, return_std=True), y.std() or 1.0
    for each in (ours, again, pickle.loads(pickle.dumps(ours))):
        likely = fixed.log_marginal_likelihood_value_
        np.testing.assert_allclose(
            each.log_marginal_likelihood_value_, likely, atol=1e-3 + n * rounding
        )
        found = each.predict(new, return_std=True)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * spread)
        mean, cov = each.predict(new, return_cov=True)
        np.testing.assert_array_equal(mean, each.predict(new))
        np.testing.assert_allclose(np.sqrt(np.diag(cov)), found[1], atol=1e-6 * spread)


def test_kernels_of_several_angles_need_not_be_positive():
    """scikit-learn's periodic kernel of a distance in the plane is none."""
    X = np.random.default_rng(0).uniform(0, 3, (30, 2))
    kernel = ExpSineSquared(1.0, 2 * np.pi, (1e-2, 1e2), "fixed")
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * kernel + WhiteKernel(1e-3, (1e-8, 1))
    ours = gaussian_process().set_params(kernel=kernel)
    ours.fit(X, np.sin(X).sum(axis=1))
    fixed = GaussianProcessRegressor(ours.kernel_, normalize_y=True, optimizer=None)
    expected = fixed.fit(X, np.sin(X).sum(axis=1)).predict(X, return_std=True)
    np.testing.assert_allclose(ours.predict(X, return_std=True), expected, atol=1e-6)


@pytest.mark.parametrize("n_columns", [1, 2])
def test_few_nodes_stand_for_many_tasks(n_columns):
    rng = np.random.default_rng(0)
    X = np.r_[rng.uniform(0, 3, (600, n_columns)), np.full((1, n_columns), 9.0)]
    y = np.sin(X).sum(axis=1) + 1e-3 * rng.normal(size=601)
    ours = gaussian_process().fit(X, y)
    fixed = GaussianProcessRegressor(ours.kernel_, normalize_y=True, optimizer=None)
    fixed.fit(X, y)
    for new in (X[::7], X[::7] + 0.01, X[-1:] - 1.0):
        expected = fixed.predict(new, return_std=True)
        found = ours.predict(new, return_std=True)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)
    np.testing.assert_allclose(
        ours.log_marginal_likelihood_value_, fixed.log_marginal_likelihood_value_
    )
    assert len(pickle.dumps(ours)) < 1e6  # 3 MB if all tasks stood for themselves


def test_other_bounds_and_a_sample():
    X = np.linspace(0, TURN, 20)[:, None]
    gp = gaussian_process().set_params(kernel__k1__k2__length_scale_bounds=(5.0, 9.0))
    assert 4.99 < gp.fit(X, np.sin(X[:, 0])).kernel_.k1.k2.length_scale < 5.01
    assert gp.sample_y(X, 3).shape == (20, 3)
    both = gp.fit(X, np.hstack([np.sin(X), np.cos(X)]))  # as scikit-learn has it
    assert both.predict(X).shape == (20, 2)


def test_what_only_scikit_learn_does_is_left_to_it():
    X = np.linspace(0, TURN, 12)[:, None]
    y, gp = np.sin(X[:, 0]), gaussian_process()

    def stay(obj_func, initial_theta, bounds):
        return initial_theta, obj_func(initial_theta, eval_gradient=False)

    own = clone(gp).set_params(optimizer=stay).fit(X, y)
    np.testing.assert_array_equal(own.kernel_.theta, gp.kernel.theta)
    gp.fit(X, np.c_[y, y]).fit(X, y)
    assert not {"L_", "alpha_"} & set(vars(gp))  # of two targets
    with pytest.raises(RuntimeError, match="At most one of return_std or return_cov"):
        gp.predict(X, return_std=True, return_cov=True)
    for params in ({"alpha": -1.0}, {"optimizer": "none"}, {"n_targets": 2}):
        with pytest.raises(ValueError, match=next(iter(params))):
            clone(gp).set_params(**params).fit(X, y)


def test_tasks_may_be_written_over_after_the_fit():
    X = np.random.default_rng(0).uniform(0, TURN, (9, 1))
    for kernel in KERNELS:
        mine = X.copy()
        gp = gaussian_process(kernel).fit(mine, np.sin(X[:, 0]))
        before = gp.predict(X + 0.1, return_std=True)
        mine[:] = 99.0
        np.testing.assert_array_equal(gp.predict(X + 0.1, return_std=True), before)


@pytest.mark.parametrize("value", [0.5, 0.1, 1 / 3, 1e6 / 3])
def test_a_constant_that_rounds_is_as_unsure_as_one_that_does_not(value):
    X = np.linspace(0, TURN, 20)[:, None]
    mean, std = gaussian_process().fit(X, np.full(20, value)).predict(X, True)
    np.testing.assert_allclose(mean, value)
    expected = gaussian_process().fit(X, np.zeros(20)).predict(X, True)[1]
    np.testing.assert_allclose(std, expected, rtol=1e-6)


@pytest.mark.parametrize("value", [0.5, 0.1])
def test_constant_dimensions_leave_a_shared_kernel_to_the_others(value):
    X = np.linspace(0, 6.2, 24)[:, None]
    y = np.hstack([np.sin(X), np.cos(X), np.sin(2 * X)])
    skill = ParameterizedSkill(None, kernel_per="chart")
    expected = skill.fit(X, y).predict(X + 0.1)
    both = skill.fit(X, np.hstack([y, np.full((24, 10), value)])).predict(X + 0.1)
    np.testing.assert_array_equal(both[:, :3], expected)
    np.testing.assert_allclose(both[:, 3:], value)


ROUND = 15.0 * np.arange(24)[:, None]  # degrees


def square(width, n_side=7, start=300.0):
    """Return a grid of tasks: a turn in radians beside a column in another unit."""
    sides = np.linspace(0, TURN, n_side), np.linspace(start, start + width, n_side)
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


def repeat(tasks, copies, noise):
    """Give every task several times, in any order, off by a share of the gaps."""
    rng = np.random.default_rng(0)
    gaps = np.ptp(tasks, axis=0) / (len(tasks) ** (1 / tasks.shape[1]) - 1)
    many = np.repeat(tasks, copies, axis=0)
    return rng.permutation(many + noise * gaps * rng.uniform(-1, 1, many.shape))


repeats = pytest.mark.parametrize("copies", [1, 3, 17, 50])
noises = pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-4, 0.03])


@repeats
@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-4, 0.03, 0.05])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_repeated_tasks_far_apart_are_told(copies, noise, offset):
    tasks = repeat(ROUND, copies, noise) + offset
    constant = np.full_like(tasks, 0.45)
    for columns in ([tasks], [constant, tasks], [constant, tasks, constant]):
        column = min(1, len(columns) - 1)
        said = rf"span 34\d and lie 1\d(\.\d)? apart in column {column} \(divide it by"
        with pytest.warns(UserWarning, match=rf"tasks {said} 5[78], say\), but .* one"):
            warn_of_scale(np.hstack(columns))


@repeats
@noises
@pytest.mark.parametrize("kind", ["random", "swapped", "third"])
def test_a_column_in_another_unit_is_told_by_its_number(copies, noise, kind):
    tasks = square(1000.0)
    if kind == "random":
        tasks *= np.random.default_rng(1).uniform(size=tasks.shape)
    tasks = repeat(tasks, copies, noise)
    if kind == "swapped":
        tasks = tasks[:, ::-1]
    if kind == "third":
        tasks = np.hstack([np.sin(tasks[:, :1]), tasks])
    column = {"swapped": 0, "third": 2}.get(kind, 1)
    with pytest.warns(
        UserWarning, match=rf"^tasks span [\d.e+]+ and .* column {column}"
    ):
        warn_of_scale(tasks)


@repeats
def test_a_column_too_narrow_to_be_seen_is_told(copies):
    tasks = repeat(square(1.0, start=0.0), copies, 0.01)
    for width in (1e-6, 5e-3, 0.05):
        with pytest.warns(
            UserWarning, match=r"^tasks span [\de.-]+ and .* in column 1 "
        ):
            warn_of_scale(tasks * [1, width])
    with pytest.warns(UserWarning, match=r"column 0 .*; span .* column 1 \(divide"):
        warn_of_scale(tasks * 1e-4)


@settings(max_examples=100, deadline=None)
@given(
    st.integers(0, 2**32),
    st.integers(1, 3),
    st.one_of(st.integers(5, 12), st.sampled_from([24, 60, 200])),
    st.sampled_from(["random", "grid", "two groups", "curve"]),
    st.tuples(st.integers(1, 8), st.sampled_from([0.0, 1e-3])),
)
def test_tasks_in_radians_raise_no_false_alarm(seed, n_columns, n, design, repeated):
    rng, (copies, off) = np.random.default_rng(seed), repeated
    spans = rng.choice([0.2, 1.0, TURN], n_columns)
    if design == "grid":
        side = np.linspace(0, 1, max(2, round(n ** (1 / n_columns))))
        tasks = np.stack(np.meshgrid(*[side] * n_columns), axis=-1)
    elif design == "curve":
        phase = np.linspace(0, 5, n)[:, None]
        tasks = 0.5 + 0.5 * np.sin(phase + np.arange(n_columns))
    else:
        tasks = rng.uniform(0, 1, (n, n_columns))
        if design == "two groups":
            tasks = np.where(rng.random((n, 1)) < 0.5, 0.1 * tasks, 1 - 0.1 * tasks)
    tasks = np.repeat(tasks.reshape(-1, n_columns), copies, axis=0)
    tasks = spans * (tasks + off * rng.normal(size=tasks.shape))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_of_scale(tasks)
        warn_of_scale(tasks + 1e6)


def test_what_cannot_be_told_is_not():
    for tasks in ([[0.0]], [[0.0], [99.0]], [[0.0]] * 9, [[0.0, 9.0], [99.0, 9.0]] * 5):
        warn_of_scale(np.array(tasks))
    warn_of_scale(np.arange(40.0)[:, None])  # numbers of tasks
    warn_of_scale(np.hstack([np.linspace(0, 6, 24)[:, None], np.full((24, 1), 1e6)]))


LEARNERS = [
    ParameterizedSkill(None),
    ParameterizedSkill(None, regressor=gaussian_process("matern")),
    CrKR(tune=True),
]


@pytest.mark.parametrize("learner", LEARNERS)
def test_the_warning_tells_of_a_loss_that_rescaling_mends(learner):
    """Every other task is held out; what is missed is told, and mended as advised."""
    angles = np.deg2rad(ROUND)
    tasks, policies = np.repeat(ROUND, 2, axis=0), np.repeat(np.sin(angles), 2)
    train = np.repeat(np.arange(24) % 2 == 0, 2)
    learner = clone(learner)
    with pytest.warns(UserWarning, match="in column 0") as told:
        learner.fit(tasks[train], policies[train])
    assert learner.score(tasks[~train], policies[~train]) < 0.1
    assert told[0].filename == __file__
    divisor = float(str(told[0].message).partition("by ")[2].partition(",")[0])
    learner.fit(tasks[train] / divisor, policies[train])
    assert learner.score(tasks[~train] / divisor, policies[~train]) > 0.99


def test_only_who_is_tuned_warns():
    y = np.sin(np.deg2rad(ROUND))
    with pytest.warns(UserWarning, match="tasks span 345"):
        ParameterizedSkill(KMeans(3), random_state=0).fit(ROUND, y)
    CrKR(length_scale=30.0).fit(ROUND, y)
    ParameterizedSkill(None, regressor=LinearRegression()).fit(ROUND, y)
