"""Spectral clustering of an affinity graph, and the elbow of a curve over charts.

By the algorithm of A. Ng, M. Jordan and Y. Weiss, "On Spectral Clustering", NIPS 2001,
whose steps are named below.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from sklearn.cluster import KMeans
from threadpoolctl import threadpool_limits

Array = NDArray[np.float64]

_LARGEST_DENSE = 2000  # points; above, only the eigenvectors needed are computed
_NUDGE = 1e-4  # of the last row's length: far above rounding, nothing to an inertia
_SHIFT = -1e-8  # below 0, the least eigenvalue, by less than the next of a long chain


def laplacian_eigen(affinity: sp.csr_array, k: int, seed: int) -> tuple[Array, Array]:
    """Decompose the symmetric normalised Laplacian of an affinity graph.

    Returns its eigenvalues, ascending (of more than 2000 points the first `k`), and the
    first `k` eigenvectors as columns.

    Notes
    -----
    The eigenvalue 0 has as many eigenvectors as the graph has connected components,
    and any rotation of them will do. So that rounding does not choose one, the first S
    span the S - 1 largest components, one by one, and all the others together.
    """
    n_points = affinity.shape[0]
    scale = sp.diags_array(1 / np.sqrt(affinity.sum(axis=1)))
    laplacian = sp.eye_array(n_points) - scale @ affinity @ scale  # 1 - L of step 2
    null = _null_vectors(affinity, k)
    if n_points <= max(_LARGEST_DENSE, k + 1):  # the iterative solver finds fewer
        values, vectors = eigh(laplacian.toarray())
        vectors = np.hstack([null, vectors[:, null.shape[1] : k]])
    else:
        further, others = _smallest_but_null(laplacian, null, k, seed)
        values = np.r_[np.zeros(null.shape[1]), further]
        vectors = np.hstack([null, others])
    return np.clip(values, 0.0, 2.0), vectors


def _null_vectors(affinity: sp.csr_array, k: int) -> Array:
    """Return the first eigenvectors of 0, at most k; see the notes above."""
    n_components, component = connected_components(affinity, directed=False)
    largest_first = np.argsort(-np.bincount(component), kind="stable")
    rank = np.argsort(largest_first)[component]
    roots = np.sqrt(affinity.sum(axis=1))
    left = rank[:, None] >= np.arange(min(k, n_components))
    return np.asarray(np.linalg.qr(np.where(left, roots[:, None], 0.0))[0])


def _smallest_but_null(
    laplacian: sp.csr_array, null: Array, k: int, seed: int
) -> tuple[Array, Array]:
    """Return the eigenvalues and vectors that follow the null ones, up to the k-th."""
    # ARPACK in shift-invert mode: it iterates with the inverse of (Laplacian - shift),
    # since the small eigenvalues of a long chain lie very close; and in the complement
    # of the null vectors, which are known and would drown them.
    n_points, n_null = null.shape
    if n_null == k:
        return np.empty(0), np.empty((n_points, 0))
    factors = splu(  # in an order of little fill
        (laplacian - _SHIFT * sp.eye_array(n_points)).tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )

    def apart(vector: Array) -> Array:
        return np.asarray(vector - null @ (null.T @ vector))

    def solve(vector: Array) -> Array:
        return apart(np.asarray(factors.solve(apart(vector)), dtype=float))

    inverse = LinearOperator(laplacian.shape, matvec=solve, dtype=float)
    start = apart(np.asarray(np.random.default_rng(seed).standard_normal(n_points)))
    values, vectors = eigsh(
        laplacian, k - n_null, sigma=_SHIFT, v0=start, OPinv=inverse
    )
    order = np.argsort(values)
    return values[order], vectors[:, order]


def unit_rows(vectors: Array) -> Array:
    """Scale every row to unit length; rows of zeros stay."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0))


def cluster_rows(embedding: Array, seed: int) -> NDArray[np.intp]:
    """Find as many clusters as there are columns; number them as they appear.

    Notes
    -----
    Rows of different components of the graph are orthogonal: those of a component in
    which k-means does not start are equally far from all starts. Lest rounding decide,
    rows are shortened, each by a little more than the one before.
    """
    if embedding.shape[1] == 1:
        return np.zeros(len(embedding), dtype=np.intp)
    # As many distinct rows, at least: the eigenvectors are linearly independent.
    k_means = KMeans(embedding.shape[1], n_init=10, random_state=seed)
    shortened = np.linspace(1, 1 - _NUDGE, len(embedding))
    found = k_means.fit_predict(shortened[:, np.newaxis] * embedding)
    _, first, inverse = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def cluster_each(vectors: Array, n_counts: int, seed: int) -> list[NDArray[np.intp]]:
    """Find 1, 2, … clusters, each among as many eigenvectors."""
    with threadpool_limits(1, "openmp"):  # so few rows: threads would only wait
        return [
            cluster_rows(unit_rows(vectors[:, :count]), seed)  # steps 3, 4 and 5
            for count in range(1, n_counts + 1)
        ]


def within_cluster_ss(X: Array, labels: NDArray[np.intp]) -> float:
    """Sum the squared distances of points from their chart's mean."""
    members = np.eye(labels.max() + 1)[labels]
    centers = (members.T @ X) / members.sum(axis=0)[:, None]
    apart = X - centers[labels]
    rounding = len(X) * np.finfo(float).eps * np.abs(X).max(initial=0.0)
    return 0.0 if np.abs(apart).max() <= rounding else float((apart**2).sum())


def elbow(curve: Array) -> int:
    """Find the elbow of a falling curve: the entry furthest below its chord.

    Rescaling an axis cannot change it.

    Parameters
    ----------
    curve : ndarray of shape (n_counts,)
        A value for each count 1, 2, …

    Returns
    -------
    int
        The count at the elbow.

    Examples
    --------
    >>> elbow(np.array([9.0, 4.0, 1.0, 0.9, 0.8]))
    3
    """
    chord = np.linspace(curve[0], curve[-1], len(curve))
    return int(np.argmax(chord - curve)) + 1
