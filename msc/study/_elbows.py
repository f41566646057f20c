"""The elbow, read by every criterion that the number of charts may be chosen by."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.cluster import KMeans
from sklearn.model_selection import KFold
from sklearn.neighbors import KNeighborsClassifier

from msc._checks import check_whole, validate_sample
from msc.learn import (
    SMCE,
    cluster_each,
    elbow,
    gaussian_process,
    knee,
    laplacian_eigen,
    within_cluster_ss,
)

Array = NDArray[np.float64]
Charts = NDArray[np.intp]


def read_elbows(
    tasks: ArrayLike,
    policies: ArrayLike,
    *,
    max_charts: int = 10,
    n_folds: int = 5,
    seed: int = 0,
) -> dict[str, dict[str, Any]]:
    """Read the elbow by every criterion.

    Parameters
    ----------
    tasks : array-like of shape (n_tasks, n_task_params)
        Tasks, in radians; only the cross-validation looks at them.
    policies : array-like of shape (n_tasks, n_params)
        Their policies.
    max_charts : int, default=10
        Largest number of charts; clipped to the tasks that a fold trains on.
    n_folds : int, default=5
        Folds of the cross-validation; clipped to the number of tasks.
    seed : int, default=0
        Seed of the clustering and of the folds.

    Returns
    -------
    dict
        By the names of `SELECTION_CRITERIA`: ``"curve"``, a list over 1, 2, … charts,
        and ``"picked"``, a number of them.

    Raises
    ------
    ValueError
        If the data are not finite, of different lengths or fewer than three, or a
        number is too small.

    Notes
    -----
    - *squares within charts*: sum of squared distances from the charts' means, in the
      space of policies; charts by SMCE. *chord* picks the point furthest below the line
      between the curve's ends, *knee* the first that stands out (`knee`).
    - *eigengap*: difference of successive eigenvalues of the normalised Laplacian;
      picks the largest.
    - *rows of M*: the rows of the affinity matrix taken as points, as the paper words
      it; sum of squares of k-means, chord.
    - *cross-validated error*: in every fold charts, gate (nearest task) and one
      Gaussian process a chart are made anew from the other folds. Its hyper-parameters
      stay at their initial values, so that fifty resamples take minutes. Picks the
      least mean squared error.

    Examples
    --------
    >>> tasks = np.linspace(0, 6, 40)[:, np.newaxis]
    >>> policies = np.c_[np.sin(tasks), np.cos(tasks)] + 9 * (tasks > 3)
    >>> read_elbows(tasks, policies, max_charts=6)["squares"]["picked"]
    2
    """
    check_whole("max_charts", max_charts, 1)
    check_whole("n_folds", n_folds, 2)
    X, y = validate_sample(tasks, policies)
    folds = list(KFold(min(n_folds, len(X)), shuffle=True, random_state=seed).split(X))
    n_counts = min(max_charts, *(len(train) for train, _ in folds))
    affinity, values, charts = _cut(y, n_counts, seed)
    squares = np.array([within_cluster_ss(y, labels) for labels in charts])
    gaps = np.diff(values)[:n_counts]
    starts = (KMeans(S, n_init=10, random_state=seed) for S in range(1, n_counts + 1))
    rows = np.array([k_means.fit(affinity).inertia_ for k_means in starts])
    errors = np.mean([_fold_errors(X, y, fold, n_counts, seed) for fold in folds], 0)
    picked = {
        "rows_of_m": (rows, elbow(rows)),
        "squares": (squares, elbow(squares)),
        "squares_knee": (squares, knee(squares)),
        "eigengap": (gaps, int(np.argmax(gaps)) + 1),
        "cross_validation": (errors, int(np.argmin(errors)) + 1),
    }
    return {
        name: {"curve": curve.tolist(), "picked": count}
        for name, (curve, count) in picked.items()
    }


def _cut(policies: Array, n_counts: int, seed: int) -> tuple[Any, Array, list[Charts]]:
    """Return affinity, eigenvalues, and the charts for 1 to n_counts of them."""
    affinity = SMCE(1, max_clusters=1).fit(policies).affinity_matrix_
    size = min(n_counts + 1, len(policies))
    values, vectors = laplacian_eigen(affinity, size, seed)
    return affinity, values, cluster_each(vectors, n_counts, seed)


def _fold_errors(
    X: Array, y: Array, fold: tuple[Charts, Charts], n_counts: int, seed: int
) -> list[float]:
    """Return the mean squared error on held-out tasks for 1 to n_counts charts."""
    (train, test), errors = fold, []
    for labels in _cut(y[train], n_counts, seed)[2]:
        gate = KNeighborsClassifier(1).fit(X[train], labels)
        asked = gate.predict(X[test])
        predicted = np.empty((len(test), y.shape[1]))
        for chart in np.unique(asked):
            regressor = gaussian_process().set_params(optimizer=None)
            regressor.fit(X[train][labels == chart], y[train][labels == chart])
            here = X[test][asked == chart]
            predicted[asked == chart] = regressor.predict(here).reshape(len(here), -1)
        errors.append(float(((predicted - y[test]) ** 2).mean()))
    return errors
