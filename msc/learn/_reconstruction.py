"""Points written as affine combinations of their neighbours, near ones preferred.

Every point has a small convex program of its own. Two solvers take them, and each is
the other's oracle in the tests. *cvxpy* gets the programs in the form in which they are
printed, as one. *batched* is an interior point method, of which a step is a handful of
array operations for all programs that are not finished yet. What it cannot certify, it
leaves to cvxpy: very small penalties, mostly.

Programs are solved in chunks of points, so that memory stays bounded.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable

import cvxpy as cp
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]

SOLVERS = ("cvxpy", "batched")
READABLE = 100  # points; for so many the one that can be read is fast enough

_CHUNK = 500  # points solved together; more are not faster, and take more memory
_COPY = 1e-10  # of the furthest neighbour's distance, and of one from zero: rounding

# cvxpy
_ZERO = 1e-10  # coefficients; the solver leaves about 1e-13 where the optimum has 0
_TOLERANCES = {
    f"{kind}tol_{of}": value
    for kind, value in (("", 1e-12), ("reduced_", 1e-8))  # if rounding stops it early
    for of in ("gap_abs", "gap_rel", "feas")
}

# batched
_GAP = 1e-11  # between a program's value and its bound, relative to the value
_STEPS = 40  # far more than the usual ten
_FLOOR = 1e-15  # of the matrices' size: keeps them invertible


def reconstruct(
    X: Array,
    neighbors: NDArray[np.intp],
    *,
    regularization: float,
    is_normalized: bool,
    solver: str | None = None,
) -> tuple[Array, Array, Array]:
    """Reconstruct every point from its neighbours by Eqs. 3 and 4.

    Parameters
    ----------
    X : ndarray of shape (n_points, n_features)
        Points.
    neighbors : ndarray of shape (n_points, n_neighbors)
        Indices of each point's neighbours, nearest first, itself not among them.
    regularization : float
        Weight, >= 0, of the proximity term.
    is_normalized : bool
        Whether points are reconstructed from unit directions towards the neighbours;
        otherwise from the differences.
    solver : {"cvxpy", "batched"} or None, default=None
        What solves the programs, see `SMCE`.

    Returns
    -------
    coef : ndarray of shape (n_points, n_neighbors)
        Coefficients of the neighbours; rows sum to one.
    distances : ndarray of shape (n_points, n_neighbors)
        Distances to the neighbours.
    objective : ndarray of shape (n_points,)
        Value of each point's program at its coefficients.

    Raises
    ------
    ValueError
        If there is no such solver, or it finds no optimum.

    Notes
    -----
    The program is stated in the notes of `SMCE`. Each point's own is divided by its
    value at the nearest neighbour, so that a solver's tolerance binds all of them and
    not only their sum. A point with copies among its neighbours is reconstructed by
    these in equal shares, at no cost. Copies are at most 1e-10 of the furthest
    neighbour's distance away, and of a distance from zero, the point's own or the
    median of all: rounding makes copies, a far outlier does not.

    Examples
    --------
    A point half-way between two others is their mean.

    >>> import numpy as np
    >>> points = np.array([[0.0], [1.0], [2.0]])
    >>> neighbors = np.array([[1, 2], [0, 2], [1, 0]])
    >>> coef, _, _ = reconstruct(
    ...     points, neighbors, regularization=10.0, is_normalized=True
    ... )
    >>> coef[1].round(6)
    array([0.5, 0.5])
    """
    if solver is None:
        solver = "cvxpy" if len(X) <= READABLE else "batched"
    if solver not in SOLVERS:
        raise ValueError(f"solver={solver!r}; wanted one of {SOLVERS}, or None")
    sizes = np.linalg.norm(X, axis=1)
    sizes = np.maximum(sizes, np.median(sizes))
    parts = []
    for chunk in np.split(np.arange(len(X)), range(_CHUNK, len(X), _CHUNK)):
        differences = X[neighbors[chunk]] - X[chunk, None]
        distances = np.linalg.norm(differences, axis=2)
        extent = np.minimum(distances.max(axis=1), sizes[chunk])
        copies = distances <= _COPY * extent[:, None]
        columns = differences.transpose(0, 2, 1)  # (points, features, neighbours)
        if is_normalized:
            columns = columns / np.where(copies, np.inf, distances)[:, None]
        totals = distances.sum(axis=1, keepdims=True)
        penalty = regularization * distances / np.where(totals, totals, 1.0)  # Eq. 4
        coef = copies / np.maximum(copies.sum(axis=1, keepdims=True), 1)
        rest = ~copies.any(axis=1)
        if rest.any():
            coef[rest] = _solve(columns[rest], penalty[rest], solver)
        errors = np.einsum("ijk,ik->ij", columns, coef)
        objective = (penalty * abs(coef)).sum(axis=1) + 0.5 * (errors**2).sum(axis=1)
        parts.append((coef, distances, objective))
    coef, distances, objective = map(np.concatenate, zip(*parts, strict=True))
    return coef, distances, objective


def _solve(columns: Array, penalty: Array, solver: str) -> Array:
    """Minimise penalty @ |c| + |columns @ c|^2 / 2 with sum(c) = 1, for every point."""
    nearest = penalty[:, :1] + 0.5 * (columns[:, :, 0] ** 2).sum(axis=1, keepdims=True)
    columns, penalty = columns / np.sqrt(nearest)[:, :, None], penalty / nearest
    coef = np.full(penalty.shape, np.nan)
    if solver == "batched" and penalty.all():
        coef = solve_qps(columns, penalty)
    rest = np.isnan(coef).any(axis=1)
    if rest.any():
        coef[rest] = _solve_by_cvxpy(columns[rest], penalty[rest])
    return np.asarray(coef / coef.sum(axis=1, keepdims=True))


def _solve_by_cvxpy(columns: Array, penalty: Array) -> Array:
    """Minimise it by stating the programs of all points to cvxpy as one."""
    n_points, n_neighbors = penalty.shape
    errors = sp.block_diag(list(np.linalg.qr(columns, mode="r")), format="csc")
    sums = sp.kron(sp.eye_array(n_points), np.ones((1, n_neighbors)), format="csc")
    c = cp.Variable(n_points * n_neighbors)
    cost = penalty.ravel() @ cp.abs(c) + 0.5 * cp.sum_squares(errors @ c)
    program = cp.Problem(cp.Minimize(cost), [sums @ c == 1])  # Eq. 3, for all i
    with warnings.catch_warnings():  # the reduced tolerances are accurate enough
        warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
        with contextlib.suppress(cp.SolverError):  # then there is no optimum either
            program.solve(solver=cp.CLARABEL, **_TOLERANCES)
    if program.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise ValueError(
            f"The solver found no reconstruction (status {program.status!r}). "
            "Rescale X, raise regularization or use form='normalized'."
        )
    coef = np.asarray(c.value).reshape(n_points, n_neighbors)
    coef[abs(coef) < _ZERO] = 0.0
    return coef


def solve_qps(columns: Array, penalty: Array) -> Array:
    """Minimise penalty @ |c| + |columns @ c|^2 / 2 with sum(c) = 1, many times.

    Mehrotra's predictor-corrector method: algorithm 16.4 of J. Nocedal and S. Wright,
    "Numerical Optimization", 2nd edition, 2006. The positive and the negative part x of
    c are kept positive, and so are their slopes s, which vanish where the other does
    not. With G = columns' columns and the multiplier m of the constraint, optimal are::

        penalty + (G c - m) = s    for the positive parts,    x s = 0,
        penalty - (G c - m) = s    for the negative ones,     sum(c) = 1
    """
    n_programs, n_columns = penalty.shape
    found = np.full(penalty.shape, np.nan)
    left = np.arange(n_programs)
    gram = columns.transpose(0, 2, 1) @ columns
    floor = _FLOOR * (1 + np.trace(gram, axis1=1, axis2=2)[:, None])
    x = np.full((n_programs, 2 * n_columns), 0.1)
    x[:, :n_columns] += 1 / n_columns
    s, multiplier = np.ones(x.shape), np.zeros((n_programs, 1))
    with np.errstate(all="ignore"):  # what overflows is not finished
        for _ in range(_STEPS):
            c = x[:, :n_columns] - x[:, n_columns:]
            slope = np.einsum("ijk,ik->ij", gram, c)
            sides = [penalty + slope - multiplier, penalty - slope + multiplier]
            dual_residual = np.hstack(sides) - s
            primal_residual = 1 - c.sum(axis=1, keepdims=True)
            gap = _dot(x, s)  # to the dual program's value, were there no residuals
            value = _dot(penalty, abs(c)) + _dot(c, slope) / 2
            off = gap + _dot(x, abs(dual_residual)) + abs(multiplier * primal_residual)
            done = (off <= _GAP * value)[:, 0]
            kept = np.where(x > s, x, 0.0)[done]
            found[left[done]] = kept[:, :n_columns] - kept[:, n_columns:]
            go = ~done & np.isfinite(off[:, 0])
            if not go.any():
                break
            left, gram, penalty, floor, x, s, multiplier, gap = (
                each[go] for each in (left, gram, penalty, floor, x, s, multiplier, gap)
            )
            residuals = dual_residual[go], primal_residual[go]
            newton = _newton(x, s, residuals, gram, floor)
            affine_x, affine_s, _ = newton(-x * s)  # alg. 16.4, predictor
            ahead_x = x + _longest(x, affine_x) * affine_x
            ahead_s = s + _longest(s, affine_s) * affine_s
            sigma = (_dot(ahead_x, ahead_s) / gap) ** 3
            target = sigma * gap / x.shape[1] - x * s - affine_x * affine_s
            step_x, step_s, step_multiplier = newton(target)  # alg. 16.4, corrector
            length = 0.995 * np.minimum(_longest(x, step_x), _longest(s, step_s))
            x, s = x + length * step_x, s + length * step_s
            multiplier = multiplier + length * step_multiplier
    return found


def _newton(
    x: Array, s: Array, residuals: tuple[Array, Array], gram: Array, floor: Array
) -> Callable[[Array], tuple[Array, Array, Array]]:
    """Return a function: growth of x * s -> Newton's step of x, s and multiplier."""
    (dual_residual, primal_residual), n_columns = residuals, gram.shape[1]
    ratio = x / s
    both = ratio[:, :n_columns] + ratio[:, n_columns:]
    diagonal = np.arange(n_columns)
    matrix = gram.copy()
    matrix[:, diagonal, diagonal] += 1 / both + floor
    inverse = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    by_multiplier = inverse.sum(axis=2)

    def step(target: Array) -> tuple[Array, Array, Array]:
        # x ds + s dx = target, and ds = dual_residual ± rise with rise = G dc - dm:
        # dx = ratio (push ∓ rise), whose difference is dc = free - both * rise.
        push = target / x - dual_residual
        pushed = ratio * push
        free = pushed[:, :n_columns] - pushed[:, n_columns:]
        # So (G + 1 / both) dc = free / both + dm; then sum(dc) = primal_residual.
        bare = np.einsum("ijk,ik->ij", inverse, free / both)
        missing = primal_residual - bare.sum(axis=1, keepdims=True)
        multiplier = missing / by_multiplier.sum(axis=1, keepdims=True)
        rise = (free - bare - by_multiplier * multiplier) / both
        step_x = ratio * (push - np.hstack([rise, -rise]))
        return step_x, (target - s * step_x) / x, multiplier

    return step


def _longest(values: Array, step: Array) -> Array:
    """Return how much of a step, at most all of it, leaves the values positive."""
    reach = np.where(step < 0, -values / step, np.inf).min(axis=1, keepdims=True)
    return np.asarray(np.minimum(reach, 1.0))


def _dot(one: Array, other: Array) -> Array:
    """Multiply row by row, as a column."""
    return np.asarray(np.einsum("ij,ij->i", one, other)[:, None])
