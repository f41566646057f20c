"""One parameter swept and inverted, after Hausknecht and Stone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.cross_decomposition import PLSRegression
from sklearn.utils.estimator_checks import parametrize_with_checks

from msc.study.rivals import InvertedSweep

few = settings(max_examples=25, deadline=None)
seeds = st.integers(0, 2**31)


def draw(seed, n_tasks=15):
    draws = np.random.default_rng(seed)
    X = draws.permutation(np.sort(draws.uniform(0, 6, n_tasks)))[:, None]
    return X, draws.normal(0, 20, (n_tasks, 6)), draws


@few
@given(seeds, st.sampled_from([-1, 1]))
def test_a_parameter_that_governs_the_task_is_inverted(seed, sign):
    """Kicks along one line: what came of a setting, read backwards."""
    X, _, draws = draw(seed)
    base, line = draws.normal(0, 20, (2, 6))

    def setting(task):
        return sign * (0.2 * task + task**3 / 50)

    model = InvertedSweep().fit(X, base + setting(X) * line)
    np.testing.assert_allclose(model.predict(X), base + setting(X) * line, atol=1e-7)
    new = np.linspace(-1, 7, 30)
    tried = np.sort(X[:, 0])
    between = np.interp(new, tried, setting(tried))[:, None]
    found = model.predict(new[:, None])
    np.testing.assert_allclose(found, base + between * line, atol=1e-7)


@few
@given(seeds)
def test_the_direction_is_that_of_partial_least_squares(seed):
    X, y, _ = draw(seed)
    theirs = PLSRegression(1, scale=False).fit(y, X[:, 0]).x_weights_[:, 0]
    ours = InvertedSweep().fit(X, y).direction_
    np.testing.assert_allclose(ours, theirs * np.sign(theirs @ ours), atol=1e-9)


@few
@given(seeds)
def test_one_number_is_all_that_varies(seed):
    X, y, _ = draw(seed)
    model = InvertedSweep().fit(X, y)
    found = model.predict(np.linspace(-1, 7, 50)[:, None])
    assert np.linalg.matrix_rank(found - model.base_, tol=1e-7) <= 1
    assert (np.diff(found @ model.direction_) >= -1e-9).all()
    swept = (y - model.base_) @ model.direction_
    assert swept.min() - 1e-9 <= model.settings_.min()
    assert model.settings_.max() <= swept.max() + 1e-9


def test_settings_with_the_same_outcome_count_by_their_mean():
    """Tasks 2 and 1 come in the wrong order: one outcome, 1.5, of two settings."""
    model = InvertedSweep().fit([[0.0], [2.0], [1.0], [3.0]], [0.0, 1.0, 2.0, 5.0])
    np.testing.assert_allclose(model.outcomes_, [0, 1.5, 3])
    np.testing.assert_allclose(
        model.predict([[0.75], [1.5], [2.25]]), [0.75, 1.5, 3.25]
    )


def test_policies_that_tell_nothing_leave_the_mean():
    model = InvertedSweep().fit([[0.0], [1.0], [2.0]], [[1.0], [4.0], [1.0]])
    np.testing.assert_array_equal(model.direction_, [0])
    np.testing.assert_allclose(model.predict([[0.0], [5.0]]), [[2], [2]])


def test_one_parameter_has_one_outcome():
    with pytest.raises(ValueError, match="X has 2 features; wanted one outcome"):
        InvertedSweep().fit([[0.0, 1.0], [1.0, 2.0]], [1.0, 2.0])


@parametrize_with_checks([InvertedSweep()])
def test_scikit_learn(estimator, check):
    said = ""
    try:
        check(estimator)
    except (ValueError, AssertionError) as error:
        said = f"{error} {error.__context__}"
        if "wanted one outcome" not in said:
            raise
    if said:  # apart: telling of it from there, with all its causes, takes a second
        pytest.xfail("the check's tasks have several parameters, here there is one")
