"""Points written as affine combinations of their neighbours, near ones preferred.

Every point has a small convex program of its own. The programs of a chunk of points are
solved together, so that solvers are called seldom and memory stays bounded.
"""

from __future__ import annotations

import contextlib
import warnings

import cvxpy as cp
import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from msc.learn._interior import solve_qps

Array = NDArray[np.float64]

_CHUNK = 500  # points solved together; more are not faster, and take more memory
_FEW = (
    100  # points; up to here cvxpy, which needs some hundredths of a second for so many
)
_ZERO = 1e-10  # coefficients; the solver leaves about 1e-13 where the optimum has 0
_COPY = 1e-10  # of the furthest neighbour's distance, and of one from zero: rounding
_TOLERANCES = {
    f"{kind}tol_{of}": value
    for kind, value in (("", 1e-12), ("reduced_", 1e-8))  # if rounding stops it early
    for of in ("gap_abs", "gap_rel", "feas")
}


def reconstruct(
    X: Array,
    neighbors: NDArray[np.intp],
    *,
    regularization: float,
    is_normalized: bool,
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
        If the solver finds no optimum.

    Notes
    -----
    The program is stated in the notes of `SMCE`. Up to 100 points are stated to
    cvxpy as one program; each point's own is divided by its value at the nearest
    neighbour, so that the solver's tolerance of 1e-12 binds all of them and not only
    their sum. More points are solved by `solve_qps`, where calling a solver takes no
    time, and cvxpy gets what cannot be certified there: very small penalties. A point
    with copies among its neighbours is reconstructed by these in equal shares, at no
    cost. Copies are at most 1e-10 of the furthest neighbour's distance away, and of a
    distance from zero, the point's own or the median of all: rounding makes copies,
    a far outlier does not.

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
    sizes = np.linalg.norm(X, axis=1)
    sizes = np.maximum(sizes, np.median(sizes))
    parts = [
        _reconstruct(
            X[neighbors[chunk]] - X[chunk, None],
            sizes[chunk],
            regularization,
            is_normalized,
        )
        for chunk in np.split(np.arange(len(X)), range(_CHUNK, len(X), _CHUNK))
    ]
    coef, distances, objective = map(np.concatenate, zip(*parts, strict=True))
    return coef, distances, objective


def _reconstruct(
    differences: Array, sizes: Array, regularization: float, is_normalized: bool
) -> tuple[Array, Array, Array]:
    """Do it for one chunk, given its neighbours less its points, and their sizes."""
    distances = np.linalg.norm(differences, axis=2)
    extent = np.minimum(distances.max(axis=1), sizes)
    copies = distances <= _COPY * extent[:, None]
    columns = differences.transpose(0, 2, 1)  # (n_points, n_features, n_neighbors)
    if is_normalized:
        columns = columns / np.where(copies, np.inf, distances)[:, None]
    totals = distances.sum(axis=1, keepdims=True)
    penalty = regularization * distances / np.where(totals, totals, 1.0)  # Eq. 4
    coef = copies / np.maximum(copies.sum(axis=1, keepdims=True), 1)
    rest = ~copies.any(axis=1)
    if rest.any():
        coef[rest] = _solve(columns[rest], penalty[rest])
    errors = np.einsum("ijk,ik->ij", columns, coef)
    objective = (penalty * abs(coef)).sum(axis=1) + 0.5 * (errors**2).sum(axis=1)
    return coef, distances, objective


def _solve(columns: Array, penalty: Array) -> Array:
    """Minimise penalty @ |c| + |columns @ c|^2 / 2 with sum(c) = 1, for every point."""
    nearest = penalty[:, :1] + 0.5 * (columns[:, :, 0] ** 2).sum(axis=1, keepdims=True)
    columns, penalty = columns / np.sqrt(nearest)[:, :, None], penalty / nearest
    coef = np.full(penalty.shape, np.nan)
    if len(penalty) > _FEW and penalty.all():
        coef = solve_qps(columns, penalty)
    rest = np.isnan(coef).any(axis=1)
    if rest.any():
        coef[rest] = _state(columns[rest], penalty[rest])
    return np.asarray(coef / coef.sum(axis=1, keepdims=True))


def _state(columns: Array, penalty: Array) -> Array:
    """Do it by stating the programs of all points to cvxpy as one."""
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
