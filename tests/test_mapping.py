"""A movement carried over to another goal, after Liu and Stone."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import procrustes
from scipy.spatial.distance import cdist
from sklearn.base import clone

from msc import DMP, Workspace, load_dataset
from msc.robot import forward_kinematics
from msc.study.rivals import MappedMovement

world = Workspace.free()
start = forward_kinematics(world.home, world.link_lengths)[-1]
times = np.linspace(0, 1, 30)
tasks, policies, _ = load_dataset("free")
X, y = tasks[::15], policies[::15]
new = np.linspace(0.05, 6.2, 40)[:, None]
few = settings(max_examples=25, deadline=None)


def goals(X):
    return world.target(np.rad2deg(np.asarray(X)[:, 0]))


@few
@given(st.floats(0, 6.28), st.floats(0, 6.28), st.integers(0, 2**31))
def test_the_movement_is_turned_and_stretched(one, other, seed):
    """Procrustes finds no difference but a similarity, from start to start."""
    weights = np.random.default_rng(seed).normal(0, 20, (1, 6))
    moved = MappedMovement().fit([[one]], weights).predict([[other]])
    before = DMP().path(weights, start, goals([[one]]), times)[0]
    after = DMP().path(moved, start, goals([[other]]), times)[0]
    assert procrustes(before, after)[2] < 1e-9
    np.testing.assert_allclose(after[0], start, atol=1e-12)
    # and all distances by what the ways are apart
    stretch = np.linalg.norm(goals([[other]]) - start)
    stretch /= np.linalg.norm(goals([[one]]) - start)
    np.testing.assert_allclose(
        cdist(after, after), stretch * cdist(before, before), atol=1e-9
    )


def test_it_turns_and_does_not_mirror():
    weights = np.array([[30.0, -20.0, 5.0, 0.0, 10.0, -5.0]])
    moved = MappedMovement().fit([[1.0]], weights).predict([[4.0]])

    def area(policy, task):  # signed, between path and chord
        path = DMP().path(policy, start, goals([[task]]), times)[0] - start
        return np.sum(path[:-1, 0] * path[1:, 1] - path[:-1, 1] * path[1:, 0])

    assert area(weights, 1.0) * area(moved, 4.0) > 0


def test_what_reaches_its_goal_reaches_the_other():
    model = MappedMovement().fit(X, y)
    ends = DMP().path(y, start, goals(X), [1.0])[:, 0]
    missed = np.linalg.norm(ends - goals(X), axis=1).max()
    ends = DMP().path(model.predict(new), start, goals(new), [1.0])[:, 0]
    assert missed < 0.01
    assert np.linalg.norm(ends - goals(new), axis=1).max() < 2 * missed


def test_a_source_maps_onto_itself():
    np.testing.assert_allclose(MappedMovement().fit(X, y).predict(X), y, atol=1e-9)


def test_the_source_is_the_nearest_round_the_circle():
    model = MappedMovement().fit([[0.2], [3.0]], y[:2])
    for task, source in ((6.2, 0), (1.5, 0), (1.7, 1), (4.6, 1), (4.8, 0)):
        alone = MappedMovement().fit([[0.2], [3.0]][source : source + 1], y[[source]])
        found = model.predict([[task]])
        np.testing.assert_array_equal(found, alone.predict([[task]]))


def test_it_is_not_the_policy_left_as_it_is():
    model = MappedMovement().fit(X, y)
    apart = np.abs(model.predict(new) - y[cdist(new, X).argmin(axis=1)])
    assert np.median(apart.max(axis=1)) > 0.1


def test_manners():
    model = MappedMovement(Workspace.obstacles())
    assert clone(model).get_params() == model.get_params()
    model.fit(X, y)
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.predict(new), model.predict(new))
    with pytest.raises(TypeError, match="workspace='free'; wanted a Workspace"):
        MappedMovement("free").fit(X, y)
    with pytest.raises(TypeError, match="dmp=3; wanted a DMP"):
        MappedMovement(dmp=3).fit(X, y)
    with pytest.raises(ValueError, match="dmp is gated"):
        MappedMovement(dmp=DMP(gated=True)).fit(X, y)
    with pytest.raises(ValueError, match=r"y \(24, 5\); wanted .*\(n_tasks, 6\)"):
        MappedMovement().fit(X, y[:, :5])
