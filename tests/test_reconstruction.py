"""The programs of all points against one solver call per point, of another solver."""

from functools import cache

import cvxpy as cp
import numpy as np
import pytest
from scipy.spatial.distance import cdist

import msc.learn._reconstruction
from msc import load_dataset
from msc.learn import reconstruct
from msc.learn._reconstruction import READABLE, SOLVERS, solve_qps

SHAPES = [  # points, features, neighbours
    (12, 1, 4),
    (12, 2, 11),
    (20, 3, 6),
    (20, 6, 8),
    (15, 6, 14),
    (25, 10, 5),
    (15, 30, 12),
    (12, 100, 8),
    (30, 2, 3),
    (10, 4, 1),
]


def sample(seed, n_points, n_features, n_neighbors):
    """Draw points, with columns of unlike scale, and find their neighbours."""
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(n_points, n_features)) * rng.uniform(0.1, 10, n_features)
    distances = np.linalg.norm(X[:, None] - X, axis=2)
    np.fill_diagonal(distances, np.inf)
    return X, np.argsort(distances, axis=1)[:, :n_neighbors]


def optimum(x, others, regularization, is_normalized):
    """Solve Eq. 3 for one point, by OSQP: operator splitting, then an active set."""
    columns = (others - x).T
    distances = np.linalg.norm(columns, axis=0)
    if is_normalized:
        columns = columns / distances
    c = cp.Variable(len(others))
    penalty = cp.norm1(cp.multiply(regularization * distances / distances.sum(), c))
    cost = penalty + cp.sum_squares(columns @ c) / 2
    return cp.Problem(cp.Minimize(cost), [cp.sum(c) == 1]).solve(
        cp.OSQP, eps_abs=1e-9, eps_rel=1e-9, max_iter=200_000, polishing=True
    )


@cache
def optima(number, regularization, is_normalized):
    X, neighbors = sample(number, *SHAPES[number])
    return [
        optimum(x, X[others], regularization, is_normalized)
        for x, others in zip(X, neighbors, strict=True)
    ]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize("number", range(len(SHAPES)))
def test_objectives_are_those_of_another_solver(number, is_normalized, solver):
    X, neighbors = sample(number, *SHAPES[number])
    regularization = (1.0, 10.0, 100.0)[number % 3]
    coef, distances, objective = reconstruct(
        X,
        neighbors,
        regularization=regularization,
        is_normalized=is_normalized,
        solver=solver,
    )
    np.testing.assert_allclose(coef.sum(axis=1), 1, rtol=1e-13)
    np.testing.assert_allclose(
        distances, np.linalg.norm(X[neighbors] - X[:, None], axis=2)
    )
    expected = optima(number, regularization, is_normalized)
    np.testing.assert_allclose(objective, expected, rtol=1e-6)


def solve_on_support(columns, penalty, c):
    """Solve the conditions of optimality, given which coefficients vanish.

    They are sufficient, so that what they hold of is the optimum; None if they fail.
    """
    for least in np.logspace(-10, -3, 8):
        support = abs(c) > least
        kept, signs = columns[:, support], np.sign(c[support])
        ones = np.ones((1, len(signs)))
        system = np.block([[kept.T @ kept, -ones.T], [ones, np.zeros((1, 1))]])
        wanted = np.r_[-penalty[support] * signs, 1]
        *found, multiplier = np.linalg.lstsq(system, wanted, rcond=None)[0]
        error = kept @ found
        room = penalty * (1 + 1e-9) - abs(columns.T @ error - multiplier)
        if (np.sign(found) == signs).all() and (room >= 0).all():
            return penalty[support] @ abs(np.array(found)) + error @ error / 2
    return None


@pytest.mark.parametrize("workspace", ["free", "obstacles"])
@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize(("solver", "step"), [("batched", 1), ("cvxpy", 5)])
def test_on_the_policies_it_is_within_a_ten_billionth(
    workspace, is_normalized, solver, step
):
    X = load_dataset(workspace)[1][::step]
    neighbors = np.argsort(cdist(X, X), axis=1, kind="stable")[:, 1:21]
    coef, distances, objective = reconstruct(
        X,
        neighbors,
        regularization=10.0,
        is_normalized=is_normalized,
        solver=solver,
    )
    penalty = 10 * distances / distances.sum(axis=1, keepdims=True)
    columns = (X[neighbors] - X[:, None]).transpose(0, 2, 1)
    if is_normalized:
        columns = columns / distances[:, None]
    expected = [
        solve_on_support(*each) for each in zip(columns, penalty, coef, strict=True)
    ]
    np.testing.assert_allclose(objective, np.array(expected, float), rtol=1e-10)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("chunk", [1, 7, 30])
def test_chunks_change_nothing(chunk, monkeypatch, solver):
    X, neighbors = sample(0, 30, 3, 8)
    arguments = {"regularization": 10.0, "is_normalized": True, "solver": solver}
    whole = reconstruct(X, neighbors, **arguments)
    monkeypatch.setattr(msc.learn._reconstruction, "_CHUNK", chunk)
    parts = reconstruct(X, neighbors, **arguments)
    assert [part.shape for part in parts] == [(30, 8), (30, 8), (30,)]
    np.testing.assert_array_equal(parts[1], whole[1])
    np.testing.assert_allclose(parts[2], whole[2], rtol=1e-9)
    np.testing.assert_allclose(parts[0], whole[0], atol=1e-5)


def test_a_chunk_of_copies_alone_needs_no_solver(monkeypatch):
    monkeypatch.setattr(msc.learn._reconstruction, "_solve", None)
    coef, _, objective = reconstruct(
        np.ones((4, 2)),
        np.array([[1, 2], [0, 2], [0, 1], [0, 1]]),
        regularization=10.0,
        is_normalized=True,
    )
    np.testing.assert_array_equal(coef, 0.5)
    np.testing.assert_array_equal(objective, 0)


def objectives(X, neighbors, regularization, is_normalized, solver):
    options = {"is_normalized": is_normalized, "solver": solver}
    return reconstruct(X, neighbors, regularization=regularization, **options)[2]


@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize("regularization", [0.0, 1e-3, 1.0, 1e5])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 300.0])
def test_both_solvers_find_the_same_optima(regularization, is_normalized, scale):
    X, neighbors = sample(1, 40, 4, 12)
    arguments = (scale * X, neighbors, regularization, is_normalized)
    stated, batched = (objectives(*arguments, solver) for solver in SOLVERS)
    np.testing.assert_allclose(batched, stated, rtol=1e-7, atol=1e-18)


@pytest.mark.parametrize("n_points", [READABLE, READABLE + 1])
def test_the_default_is_cvxpy_for_few_points_and_batched_for_more(n_points):
    X, neighbors = sample(3, n_points, 3, 6)
    options = {"regularization": 10.0, "is_normalized": True}
    by_default = reconstruct(X, neighbors, **options)[0]
    stated, batched = (
        reconstruct(X, neighbors, **options, solver=solver)[0] for solver in SOLVERS
    )
    assert (stated != batched).any()
    np.testing.assert_array_equal(
        by_default, stated if n_points == READABLE else batched
    )


def test_an_unknown_solver_is_named():
    with pytest.raises(ValueError, match=r"solver='cvx'; wanted one of .*, or None"):
        objectives(*sample(1, 40, 4, 12), 10.0, True, "cvx")


def test_what_cannot_be_certified_goes_to_cvxpy(monkeypatch):
    X, neighbors = sample(2, 40, 4, 12)
    stated = objectives(X, neighbors, 10.0, True, "cvxpy")
    some = 9  # steps: some programs are done by then, some not
    monkeypatch.setattr(msc.learn._reconstruction, "_STEPS", some)
    coef = solve_qps(
        np.random.default_rng(0).normal(size=(99, 3, 9)), np.full((99, 9), 0.1)
    )
    assert 0 < np.isnan(coef[:, 0]).sum() < 99
    batched = objectives(X, neighbors, 10.0, True, "batched")
    np.testing.assert_allclose(batched, stated, rtol=1e-9)


def test_the_interior_point_method_leaves_exact_zeros_and_certifies():
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(200, 3, 12))
    columns /= np.linalg.norm(columns, axis=1)[:, None]
    penalty = rng.uniform(0.2, 2, (200, 12))
    coef = solve_qps(columns, penalty)
    assert not np.isnan(coef).any()
    assert (coef == 0).mean() > 0.5  # at most four are needed in three dimensions
    assert (np.count_nonzero(coef, axis=1) <= 4).all()
    np.testing.assert_allclose(coef.sum(axis=1), 1, rtol=1e-7)
    slopes = np.einsum("ijk,ij->ik", columns, np.einsum("ijk,ik->ij", columns, coef))
    multiplier = np.where(coef, slopes + penalty * np.sign(coef), np.nan)
    np.testing.assert_allclose(
        np.nanstd(multiplier, axis=1), 0, atol=1e-6
    )  # optimality
    bound = penalty + 1e-6
    assert (abs(slopes - np.nanmean(multiplier, axis=1, keepdims=True)) <= bound).all()
