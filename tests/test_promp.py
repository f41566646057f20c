"""Probabilistic movement primitives, conditioned on the end point."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sklearn.base import clone
from sklearn.covariance import ledoit_wolf

from msc import DMP, Workspace, load_dataset
from msc.robot import forward_kinematics
from msc.study.rivals import ConditionedProMP

world = Workspace.free()
start = forward_kinematics(world.home, world.link_lengths)[-1]
tasks, policies, _ = load_dataset("free")
tasks, policies = tasks[::15], policies[::15]
new = np.linspace(0.05, 6.2, 30)[:, None]


def goals(X, there=world):
    return there.target(np.rad2deg(X[:, 0]))


@pytest.fixture(scope="module")
def model():
    return ConditionedProMP().fit(tasks, policies)


def weights_of(X, y):
    """Weights of the spring's and the basis' responses, x before y (m)."""
    rows = []
    for way, policy in zip(goals(X) - start, y, strict=True):
        x, y = policy[:3], policy[3:]
        rows.append(np.r_[way[0] * np.r_[1, x], way[1] * np.r_[1, y]])
    return np.array(rows)


def place(u, time):
    """Where movements of weights u are: the sum of basis functions."""
    unit = DMP().path(np.eye(6)[:3], [0, 0], [1, 1], [time])[:, 0, 0]
    spring = DMP().path(np.zeros(6), [0, 0], [1, 1], [time])[0, 0]
    basis = np.r_[spring, unit - spring]
    return start + np.stack([u[..., :4] @ basis, u[..., 4:] @ basis], axis=-1)


def test_movements_end_at_their_goals(model):
    found = DMP().path(model.predict(new), start, goals(new), [1.0])[:, 0]
    assert_allclose(found, goals(new), atol=1e-9)


@pytest.mark.parametrize(
    ("options", "n_params"),
    [({"end_time": 0.7}, 6), ({"dmp": DMP(n_basis=5, spring=40.0)}, 10)],
)
def test_others_do_too(options, n_params):
    dmp, end_time = options.get("dmp", DMP()), options.get("end_time", 1.0)
    draws = np.random.default_rng(0).normal(0, 20, (24, n_params))
    found = ConditionedProMP(**options).fit(tasks, draws).predict(new)
    ends = dmp.path(found, start, goals(new), [0.5, end_time])[:, -1]
    assert_allclose(ends, goals(new), atol=1e-9)


def test_the_distribution_is_that_of_the_movements(model):
    found = weights_of(tasks, policies)
    path = DMP().path(policies, start, goals(tasks), [0.4])[:, 0]
    assert_allclose(place(found, 0.4), path, atol=1e-9)
    assert_allclose(model.mean_, found.mean(axis=0))
    assert_allclose(model.covariance_, ledoit_wolf(found)[0])


def test_the_policy_is_the_likeliest_of_those_that_reach_the_goal(model):
    """By Lagrange's multipliers: density's gradient is a sum of the conditions'."""
    found = weights_of(new, model.predict(new))
    assert_allclose(place(found, 1.0), goals(new), atol=1e-9)
    free = np.linalg.svd(
        np.vstack([place(np.eye(8), 1.0).T - start[:, None], np.eye(8)[[0, 4]]])
    )[2][4:]  # directions that change neither the end nor the first weights
    gradient = np.linalg.solve(model.covariance_, (found - model.mean_).T)
    scale = np.abs(gradient).max()
    assert_allclose(free @ gradient / scale, 0, atol=1e-7)


def test_it_is_the_paper_s_conditioning_of_a_noisy_end_as_noise_vanishes(model):
    """As in Paraschos and others, with a variance of the wanted end."""
    ends = (place(np.eye(8), 1.0) - start).T
    seen = np.vstack([ends, np.eye(8)[[0, 4]]])
    spread = model.covariance_ @ seen.T
    gain = spread @ np.linalg.inv(1e-9 * np.eye(4) + seen @ spread)
    ways = goals(new) - start
    wanted = np.hstack([ways, ways])
    mean = model.mean_ + (wanted - seen @ model.mean_) @ gain.T
    assert_allclose(mean, weights_of(new, model.predict(new)), atol=1e-4)
    std = np.sqrt(np.diag(model.covariance_ - gain @ seen @ model.covariance_))
    _, found = model.predict(new, return_std=True)
    shares = found * np.abs(ways).repeat(3, axis=1)
    assert_allclose(shares, np.tile(std[[1, 2, 3, 5, 6, 7]], (30, 1)), rtol=1e-3)


def test_manners(model):
    assert clone(model).get_params()["end_time"] == 1.0
    again = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(again.predict(new), model.predict(new))
    mean, std = model.predict(new, return_std=True)
    np.testing.assert_array_equal(mean, model.predict(new))
    assert mean.shape == std.shape == (30, 6)
    turned = Workspace(cut_deg=159.5)
    other = ConditionedProMP(turned).fit(tasks, policies).predict(new)
    ends = DMP().path(other, start, goals(new, turned), [1.0])[:, 0]
    assert_allclose(ends, goals(new, turned), atol=1e-9)


def test_bad_input(model):
    with pytest.raises(TypeError, match="workspace='free'; wanted a Workspace"):
        ConditionedProMP("free").fit(tasks, policies)
    with pytest.raises(TypeError, match="dmp=3; wanted a DMP"):
        ConditionedProMP(dmp=3).fit(tasks, policies)
    with pytest.raises(ValueError, match="end_time=-1; wanted a positive"):
        ConditionedProMP(end_time=-1).fit(tasks, policies)
    with pytest.raises(ValueError, match=r"X has shape \(24, 2\).*wanted \(n_tasks, 1"):
        ConditionedProMP().fit(np.c_[tasks, tasks], policies)
    with pytest.raises(ValueError, match=r"y \(24, 5\); wanted .*\(n_tasks, 6\)"):
        ConditionedProMP().fit(tasks, policies[:, :5])
    with pytest.raises(ValueError, match=r"X has shape \(1, 1\).*at least two tasks"):
        ConditionedProMP().fit(tasks[:1], policies[:1])
    with pytest.raises(ValueError, match="X has 2 features, but ConditionedProMP is"):
        model.predict([[0.0, 1.0]])
