"""The warning about the scale of tasks, told from their gaps, column by column."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.cluster import KMeans
from sklearn.linear_model import LinearRegression

from msc import CrKR, ParameterizedSkill
from msc._checks import warn_of_scale
from msc.learn import gaussian_process

TURN = 2 * np.pi
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


repeats = pytest.mark.parametrize("copies", [1, 2, 3, 8, 17, 20, 50])
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
@pytest.mark.parametrize("kind", ["grid", "random", "swapped", "third"])
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


@settings(max_examples=200, deadline=None)
@given(
    st.integers(0, 2**32),
    st.integers(1, 3),
    st.one_of(st.integers(5, 12), st.sampled_from([24, 60, 200, 500])),
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
