"""Charts of a manifold: sparse self-reconstruction, then spectral clustering.

Every point is written as an affine combination of a few of its neighbours. Points
which reconstruct each other lie on the same smooth piece, a *chart*, however near
another piece may pass.
"""

from __future__ import annotations

import warnings
from numbers import Integral, Real
from typing import Any, ClassVar, Self

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.neighbors import NearestNeighbors
from sklearn.utils._param_validation import Interval, StrOptions

from msc._checks import (
    RANDOM_STATE,
    RandomState,
    check_magnitude,
    seed_of,
    validate_points,
)
from msc.learn._copies import find_copies
from msc.learn._elbow import elbow
from msc.learn._reconstruction import SOLVERS, reconstruct
from msc.learn._spectral import (
    cluster_graph,
    cluster_rows,
    unit_rows,
    within_cluster_ss,
)

Array = NDArray[np.float64]


class SMCE(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Cluster points into the charts of the manifold they were sampled from.

    Sparse Manifold Clustering and Embedding tells apart pieces that nearly touch,
    where clustering by distance fails.

    Parameters
    ----------
    n_clusters : int or None, default=None
        Number of charts. None reads it from the elbow of `elbow_curve_`. There are no
        more charts than distinct points.
    regularization : float, default=10.0
        Weight, >= 0, of using distant neighbours against the error of reconstruction.
        In the normalized form results hardly change between 10 and 100; in the raw
        form it competes with squared distances, so the data's scale matters.
    n_neighbors : int, default=20
        Neighbours that may reconstruct a point, itself not counted; clipped to
        n_samples - 1. Curves need few.
    form : {"normalized", "raw"}, default="normalized"
        "normalized" reconstructs from unit directions towards the neighbours, as in
        [1]_, and ignores the scale of the data; "raw" from the differences, as in [2]_.
    prune : float, default=0.95
        Share, in (0, 1], of each point's affinity that is kept, largest entries first.
    max_clusters : int, default=10
        Largest number of charts on the elbow curve; clipped to n_samples.
    random_state : int, RandomState instance, Generator or None, default=None
        Seed of the k-means starts. None draws fresh entropy; NumPy's global generator
        is left alone.
    solver : {"cvxpy", "batched"} or None, default=None
        What solves the points' programs: "cvxpy", to which they are stated as printed
        below, or "batched", an interior point method of our own, which is faster. None
        is "cvxpy" for up to 100 distinct points. Values agree within 1e-8; where a
        minimum is flat, coefficients do within 1e-5, and charts may differ.

    Attributes
    ----------
    coef_ : sparse array of shape (n_samples, n_samples)
        Row i reconstructs point i and sums to one; before pruning. A copy has the row
        of its point.
    objective_ : ndarray of shape (n_samples,)
        Value of each point's program at `coef_`.
    affinity_matrix_ : sparse array of shape (n_samples, n_samples)
        Symmetric, non-negative, zero on the diagonal. A copy's only one is to its
        point, 1.
    eigenvalues_ : ndarray
        Of the normalised Laplacian of the distinct points, ascending; all of them up to
        500 points, of more as many as charts are considered. The small ones are right
        to six digits too; but count components by `n_components_`, not by their zeros.
    n_components_ : int
        Connected components of the graph of `affinity_matrix_`.
    copy_of_ : ndarray of shape (n_samples,)
        Index of the first point that says the same: a point's own if it is no copy.
    embedding_ : ndarray of shape (n_samples, n_clusters)
        Unit rows, among which k-means finds the charts.
    elbow_curve_ : ndarray of shape (min(max_clusters, n_samples),)
        Entry S - 1 is the within-chart sum of squares of the distinct points for S
        charts.
    n_clusters_ : int
        Number of charts.
    labels_ : ndarray of shape (n_samples,)
        Chart of each point, numbered in order of first appearance.
    n_features_in_ : int
        Number of columns of `X`.

    Notes
    -----
    Point i solves, over its neighbours j at distances d_j (Eqs. 3 and 4 of [2]_)::

        minimise  regularization * sum_j q_j |c_j|  +  1/2 |sum_j c_j y_j|^2
        subject to  sum_j c_j = 1,        q_j = d_j / sum_t d_t

    with y_j = (x_j - x_i) / d_j, or without the division in the raw form. They are
    solved many at a time (`msc.learn.reconstruct`): on the policies in `data/` within
    1e-10 of the optimum, relative to it, in either form; on others at worst within the
    solver's own 1e-8 of a point's value at its nearest neighbour.

    Points given more than once, exactly or nearly (`find_copies` says what counts),
    are clustered once, as their mean, and copies are in the chart of their point: they
    would use up its neighbours, and the graph would fall into as many components as
    there are points. Near copies, 2 to 8 of every point, are found up to a noise of
    0.05 of the distance to the next point: all but, on the policies with obstacles,
    some of points far from all others. Charts then stay what they are without (adjusted
    Rand index at least 0.95, with 6 to 20 neighbours), but for those that hang on a few
    points. At a noise of 0.1 and 0.2 most are found; at 0.5 none is, and charts are
    arbitrary unless `n_neighbors` reaches beyond them.

    Affinities are the row-normalised `|c_j / d_j|`, in the raw form `|c_j|`, pruned and
    symmetrised by the larger of both directions; clustering follows [3]_. Where the
    graph has more components than charts, the data do not determine which components
    share a chart: here the smallest do, and a warning says how many there are.

    [2]_ does not name the curve that the elbow is read from. Here it is `elbow_curve_`,
    measured in the fixed space of `X` because the embedding changes with the number of
    charts, and the elbow is its point furthest below the chord between its ends.

    References
    ----------
    .. [1] E. Elhamifar and R. Vidal, "Sparse Manifold Clustering and Embedding",
       NIPS 2011.
    .. [2] "Task-Based Behavior Generalization via Manifold Clustering", section III.
    .. [3] A. Ng, M. Jordan and Y. Weiss, "On Spectral Clustering: Analysis and an
       Algorithm", NIPS 2001.

    Examples
    --------
    >>> import numpy as np
    >>> from msc import SMCE
    >>> angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    >>> circle = np.c_[np.cos(angle), np.sin(angle)]
    >>> rings = np.r_[circle, 2 * circle]
    >>> SMCE(n_clusters=2, n_neighbors=6, random_state=0).fit_predict(rings)[::8]
    array([0, 0, 0, 0, 0, 1, 1, 1, 1, 1])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "n_clusters": [Interval(Integral, 1, None, closed="left"), None],
        "regularization": [Interval(Real, 0, None, closed="left")],
        "n_neighbors": [Interval(Integral, 1, None, closed="left")],
        "form": [StrOptions({"normalized", "raw"})],
        "prune": [Interval(Real, 0, 1, closed="right")],
        "max_clusters": [Interval(Integral, 1, None, closed="left")],
        "random_state": RANDOM_STATE,
        "solver": [StrOptions(set(SOLVERS)), None],
    }

    def __init__(
        self,
        n_clusters: int | None = None,
        *,
        regularization: float = 10.0,
        n_neighbors: int = 20,
        form: str = "normalized",
        prune: float = 0.95,
        max_clusters: int = 10,
        random_state: RandomState = None,
        solver: str | None = None,
    ) -> None:
        self.n_clusters = n_clusters
        self.regularization = regularization
        self.n_neighbors = n_neighbors
        self.form = form
        self.prune = prune
        self.max_clusters = max_clusters
        self.random_state = random_state
        self.solver = solver

    def fit(self, X: Any, y: Any = None) -> Self:  # noqa: ARG002
        """Find the charts.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Points on the manifold; at least two.
        y : None
            Ignored; present by convention.

        Returns
        -------
        SMCE
            The fitted clusterer.

        Raises
        ------
        ValueError
            If a parameter is out of range, or `X` not finite, too large or too small.
        LinAlgError
            If the graph's eigenvectors cannot be found.

        Warns
        -----
        UserWarning
            If the graph has more components than there are charts (and not one was
            asked for), or `X` fewer distinct points than `n_clusters`.
        """
        self._validate_params()
        X = validate_points(self, X, ensure_min_samples=2)
        n_samples, seed = len(X), seed_of(self.random_state)
        if self.n_clusters is not None and self.n_clusters > n_samples:
            raise ValueError(
                f"n_clusters={self.n_clusters} must be at most n_samples={n_samples}."
            )
        check_magnitude("X", X)
        self.copy_of_ = find_copies(X)
        points, place = np.unique(self.copy_of_, return_inverse=True)
        distinct = _means(X, points, place)
        affinity = self._connect(distinct, points.astype(np.int32), place)
        self.n_components_, component = connected_components(affinity, directed=False)

        curve_length = min(self.max_clusters, n_samples)
        wanted = min(max(self.n_clusters or 1, curve_length), len(points))
        self.eigenvalues_, vectors, charts = cluster_graph(
            affinity, wanted, min(curve_length, len(points)), seed
        )
        charts += charts[-1:] * (curve_length - len(charts))
        self.elbow_curve_ = np.array(
            [within_cluster_ss(distinct, each) for each in charts]
        )
        count = min(self.n_clusters or elbow(self.elbow_curve_), len(points))
        self.n_clusters_ = count
        self._warn_of_too_few(len(points), np.bincount(component))
        embedding = unit_rows(vectors[:, :count])
        known = count <= curve_length
        labels = charts[count - 1] if known else cluster_rows(embedding, seed)
        self.embedding_, self.labels_ = embedding[place], labels[place]
        return self

    def _connect(
        self, distinct: Array, points: NDArray[np.int32], place: NDArray[np.intp]
    ) -> sp.csr_array:
        """Reconstruct the distinct points, rows `points`; return their affinities."""
        n_samples, n_points = len(place), len(points)
        shape = (n_samples, n_samples)
        copies = np.setdiff1d(np.arange(n_samples, dtype=np.int32), points)
        ends = copies, points[place][copies]
        pointing = sp.csr_array((np.ones(len(copies)), ends), shape)
        self.affinity_matrix_ = pointing + pointing.T  # a copy's is to its point, 1
        if n_points == 1:  # there is nothing but copies to reconstruct it from
            self.coef_ = pointing + sp.csr_array(([1.0], ([0], [1])), shape)
            self.objective_ = np.zeros(n_samples)
            return sp.csr_array(np.ones((1, 1)))
        n_neighbors = min(self.n_neighbors, n_points - 1)
        search = NearestNeighbors(n_neighbors=n_neighbors, algorithm="kd_tree")
        neighbors = search.fit(distinct).kneighbors(return_distance=False)
        coef, distances, objective = reconstruct(
            distinct,
            neighbors,
            regularization=self.regularization,
            is_normalized=self.form == "normalized",
            solver=self.solver,
        )
        weights = abs(coef)
        if self.form == "normalized":  # at distance zero, a point has all the weight
            weights /= np.where(distances > 0, distances, 1.0)
        directed = _to_sparse(_prune(weights, self.prune), neighbors, n_points)
        affinity = directed.maximum(directed.T).tocsr()
        self.coef_ = _to_sparse(coef[place], points[neighbors][place], n_samples)
        self.objective_ = objective[place]
        among = affinity.tocoo()
        entries = (among.data, (points[among.row], points[among.col]))
        self.affinity_matrix_ += sp.csr_array(entries, shape)
        return affinity

    def _warn_of_too_few(self, n_points: int, sizes: NDArray[np.intp]) -> None:
        """Say where there are fewer distinct points, or charts, than it takes."""
        count = self.n_clusters_
        if self.n_clusters is not None and self.n_clusters > n_points:
            warnings.warn(
                f"X has {n_points} distinct points, so n_clusters={self.n_clusters} "
                f"charts cannot be found: there are {n_points}.",
                stacklevel=3,
            )
        if len(sizes) > count and self.n_clusters != 1:
            largest = "" if count == 1 else f"the {count - 1} largest are charts, "
            warnings.warn(
                f"The graph has {len(sizes)} components, of {sizes.min()} to "
                f"{sizes.max()} points, but n_clusters_ is {count}: {largest}"
                f"{len(sizes) - count + 1} share one. More n_neighbors than "
                f"{self.n_neighbors} may connect them.",
                stacklevel=3,
            )


def _means(X: Array, points: NDArray[np.intp], place: NDArray[np.intp]) -> Array:
    """Return the distinct points: means of copies; to the bit, where they are equal."""
    if len(points) == len(X):
        return X
    first = X[points]
    sums = np.zeros_like(first)
    np.add.at(sums, place, X - first[place])
    return np.asarray(first + sums / np.bincount(place)[:, None])


def _prune(weights: Array, share: float) -> Array:
    """Normalise rows to sum to one; keep the largest entries that hold `share`."""
    weights = weights / weights.sum(axis=1, keepdims=True)
    order = np.argsort(-weights, axis=1, kind="stable")
    largest_first = np.take_along_axis(weights, order, axis=1)
    held_before = largest_first.cumsum(axis=1) - largest_first
    kept = np.where(held_before < share, largest_first, 0.0)
    np.put_along_axis(weights, order, kept, axis=1)
    return np.asarray(weights)


def _to_sparse(
    rows: Array, neighbors: NDArray[np.intp], n_columns: int
) -> sp.csr_array:
    starts = np.arange(0, rows.size + 1, rows.shape[1], dtype=np.int32)
    entries = (rows.ravel(), neighbors.ravel().astype(np.int32), starts)
    matrix = sp.csr_array(entries, shape=(len(rows), n_columns), copy=True)
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix
