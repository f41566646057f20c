"""Spectral clustering of an affinity graph.

By the algorithm of A. Ng, M. Jordan and Y. Weiss, "On Spectral Clustering", NIPS 2001,
whose steps are named below.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eigh
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh, splu
from sklearn.cluster import KMeans
from threadpoolctl import threadpool_limits

Array = NDArray[np.float64]
Product = Callable[[Array], Array]  # of a matrix with a vector

_LARGEST_DENSE = 500  # points; above, only the eigenvectors needed are computed
_TINY = 1e-6  # eigenvalues below this, rounding (1e-15) spoils in the ninth digit
_DEEP = 30  # steps across a graph; in deeper ones the small eigenvalues lie too close
_RESTARTS = 100  # of the iteration; with an inverse it needs a few
_BASIS = 40  # vectors that the iteration keeps, at least
_SHIFT = -1e-12  # below 0 by far more than rounding, far less than the next eigenvalue
_SAME = 1e-9  # of an eigenvalue: copies of a multiple one are no further apart
_NUDGE = 1e-4  # of the last row's length: far above rounding, nothing to an inertia


def laplacian_eigen(affinity: sp.csr_array, k: int, seed: int) -> tuple[Array, Array]:
    """Decompose the symmetric normalised Laplacian of an affinity graph.

    Parameters
    ----------
    affinity : sparse array of shape (n_points, n_points)
        Symmetric weights of the edges.
    k : int
        How many eigenvectors.
    seed : int
        Of the vectors from which an iteration begins.

    Returns
    -------
    values : ndarray
        Eigenvalues, ascending; of more than 500 points the first `k`. The smallest,
        too, are right to six digits.
    vectors : ndarray of shape (n_points, k)
        The first eigenvectors, as columns.

    Notes
    -----
    The eigenvalue 0 has as many eigenvectors as the graph has connected components,
    and any rotation of them will do. So that rounding does not choose one, the first S
    span the S - 1 largest components, one by one, and all the others together.
    """
    n_points = affinity.shape[0]
    n_components, component = connected_components(affinity, directed=False)
    null = _null_vectors(affinity, component, k)
    if n_points <= max(_LARGEST_DENSE, k + 1):
        values, vectors = eigh(_laplacian(affinity).toarray())
        n_tiny = int(np.searchsorted(values, _TINY))
        if n_tiny > n_components:
            zeros = _null_vectors(affinity, component, n_components)
            tiny = _separate(affinity, zeros, vectors[:, :n_tiny])
            values[:n_tiny] = np.r_[np.zeros(n_components), tiny[0]]
            vectors[:, n_components:n_tiny] = tiny[1]
        others = vectors[:, null.shape[1] : k]
    else:
        try:
            further, others = _smallest_but_null(affinity, component, k, seed)
        except (RuntimeError, MemoryError) as error:  # ARPACK's are RuntimeErrors
            raise LinAlgError(
                f"No eigenvectors of the graph of {n_points} points, in {n_components} "
                f"components, were found ({error}). Try fewer max_clusters or "
                "n_clusters, more n_neighbors, or fewer points."
            ) from error
        values = np.r_[np.zeros(null.shape[1]), further]
    return np.clip(values, 0.0, 2.0), np.hstack([null, others])


def _laplacian(affinity: sp.csr_array) -> sp.csr_array:
    """Return 1 - L of step 2."""
    scale = sp.diags_array(1 / np.sqrt(affinity.sum(axis=1)))
    return sp.eye_array(affinity.shape[0]) - scale @ affinity @ scale


def _null_vectors(affinity: sp.csr_array, component: NDArray[np.intp], k: int) -> Array:
    """Return the first eigenvectors of 0, at most k; see the notes above."""
    largest_first = np.argsort(-np.bincount(component), kind="stable")
    rank = np.argsort(largest_first)[component]
    roots = np.sqrt(affinity.sum(axis=1))
    left = rank[:, None] >= np.arange(min(k, len(largest_first)))
    return np.asarray(np.linalg.qr(np.where(left, roots[:, None], 0.0))[0])


def _smallest_but_null(
    affinity: sp.csr_array, component: NDArray[np.intp], k: int, seed: int
) -> tuple[Array, Array]:
    """Return the eigenvalues and vectors that follow the null ones, up to the k-th."""
    n_components = component.max() + 1
    n_further = max(k - n_components, 0)
    values, vectors = [np.empty(0)], [np.empty((len(component), 0))]
    for each in range(n_components if n_further else 0):
        members = np.flatnonzero(component == each)
        part = affinity[members][:, members]
        found, within = _smallest_of_one(part, min(n_further, len(members) - 1), seed)
        values.append(found)
        vectors.append(np.zeros((len(component), len(found))))
        vectors[-1][members] = within
    smallest = np.argsort(np.concatenate(values), kind="stable")[:n_further]
    return np.concatenate(values)[smallest], np.hstack(vectors)[:, smallest]


def _smallest_of_one(affinity: sp.csr_array, k: int, seed: int) -> tuple[Array, Array]:
    """Return the k smallest eigenvalues but 0, and vectors, of a connected graph."""
    laplacian, null = _laplacian(affinity), np.sqrt(affinity.sum(axis=1))[:, None]
    null /= np.linalg.norm(null)
    if len(null) <= max(_LARGEST_DENSE, 2 * k + 2):  # Lanczos' basis would be as large
        vectors = eigh(laplacian.toarray(), subset_by_index=[0, k])[1]
        return _separate(affinity, null, vectors)

    def find(product: Product) -> tuple[Array, Array]:
        values, vectors = np.full(k, np.inf), null[:, 1:]
        rng = np.random.default_rng(seed)
        for n_more in [k] + k * [1]:  # of a multiple eigenvalue, it may miss vectors
            known = np.hstack([null, vectors])
            more = np.hstack([known, _lanczos(product, known, n_more, rng)])
            found, basis = _separate(affinity, null, more)
            if not (found[:k] < (1 - _SAME) * values).any():
                break
            values, vectors = found[:k], basis[:, :k]
        return values, vectors

    if dijkstra(affinity, unweighted=True, indices=0).max() <= _DEEP:
        with contextlib.suppress(ArpackError):
            return find(lambda vector: 2 * vector - laplacian @ vector)
    # The small eigenvalues of a long chain lie very close: those of the inverse do not.
    shifted = laplacian - _SHIFT * sp.eye_array(len(null))
    factors = splu(  # in an order of little fill
        shifted.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return find(factors.solve)


def _lanczos(product: Product, known: Array, k: int, rng: np.random.Generator) -> Array:
    """Find a matrix' k eigenvectors of largest eigenvalues that are not known."""

    def apart(vector: Array) -> Array:
        return np.asarray(vector - known @ (known.T @ vector))

    n_points = len(known)
    operator = LinearOperator(
        (n_points, n_points), lambda vector: apart(product(apart(vector))), dtype=float
    )
    start = apart(rng.standard_normal(n_points))
    n_kept = min(max(2 * k + 2, _BASIS), n_points)
    options = {"v0": start, "ncv": n_kept, "maxiter": _RESTARTS, "rng": rng}
    return np.asarray(eigsh(operator, k, which="LA", **options)[1])


def _separate(
    affinity: sp.csr_array, null: Array, vectors: Array
) -> tuple[Array, Array]:
    """Return eigenvalues and vectors in the span of `vectors` but for that of null."""
    # By Rayleigh and Ritz. The Laplacian is B'B, where a row of B takes the difference
    # between the ends of an edge: the squares of B's singular values have the accuracy
    # of the vectors, however small they are, while differences of sums do not.
    n_further = vectors.shape[1] - null.shape[1]
    apart = vectors - null @ (null.T @ vectors)
    basis = np.linalg.svd(apart, full_matrices=False)[0][:, :n_further]
    edges = sp.triu(affinity, 1).tocoo()
    ends = basis / np.sqrt(affinity.sum(axis=1))[:, None]
    slopes = np.sqrt(edges.data)[:, None] * (ends[edges.row] - ends[edges.col])
    _, singular, turn = np.linalg.svd(slopes, full_matrices=False)
    return singular[::-1] ** 2, basis @ turn[::-1].T


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
    """Find 1, 2, … clusters, each among as many eigenvectors.

    Parameters
    ----------
    vectors : ndarray of shape (n_points, at least n_counts)
        What `laplacian_eigen` returns.
    n_counts : int
        The largest number of clusters.
    seed : int
        Seed of k-means.

    Returns
    -------
    list of n_counts ndarrays of shape (n_points,)
        Labels, from 0 on in order of appearance.
    """
    with threadpool_limits(1, "openmp"):  # so few rows: threads would only wait
        return [
            cluster_rows(unit_rows(vectors[:, :count]), seed)  # steps 3, 4 and 5
            for count in range(1, n_counts + 1)
        ]


def within_cluster_ss(X: Array, labels: NDArray[np.intp]) -> float:
    """Sum the squared distances of points from their chart's mean.

    Parameters
    ----------
    X : ndarray of shape (n_points, n_features)
        Points.
    labels : ndarray of shape (n_points,)
        Their charts.

    Returns
    -------
    float
        The sum; 0 if nothing but rounding tells points from means.
    """
    members = np.eye(labels.max() + 1)[labels]
    centers = (members.T @ X) / members.sum(axis=0)[:, None]
    apart = X - centers[labels]
    rounding = len(X) * np.finfo(float).eps * np.abs(X).max(initial=0.0)
    return 0.0 if np.abs(apart).max() <= rounding else float((apart**2).sum())
