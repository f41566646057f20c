"""The number of charts: what "the elbow" may mean, and how firmly each reading picks.

The paper reads the number of charts from an elbow and does not say of which curve. Here
are the readings that can be defended, each a curve over the number of charts and a rule
that picks one, and a criterion for the default that looks at no regression.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.cluster import KMeans
from sklearn.model_selection import KFold
from sklearn.neighbors import KNeighborsClassifier
from sklearn.utils import check_X_y

from msc.gaussian import gaussian_process
from msc.parallel import call_in_order
from msc.smce import SMCE
from msc.spectral import (
    cluster_each,
    elbow,
    knee,
    laplacian_eigen,
    within_chart_squares,
)

Array = NDArray[np.float64]
Charts = NDArray[np.intp]

READINGS = {
    "rows_of_m": "rows of M, k-means",
    "squares": "squares within charts, chord",
    "squares_knee": "squares within charts, knee",
    "eigengap": "eigengap",
    "cross_validation": "cross-validated error",
}
"""The readings and what they are called, those nearest the paper's words first."""

FROM_POLICIES = tuple(name for name in READINGS if name != "cross_validation")
"""The readings that need nothing but the policies."""


def read_elbows(
    tasks: ArrayLike,
    policies: ArrayLike,
    *,
    max_charts: int = 10,
    n_folds: int = 5,
    seed: int = 0,
) -> dict[str, dict[str, Any]]:
    """Read the elbow in every way.

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
        By the names of `READINGS`: ``"curve"``, a list over 1, 2, … charts, and
        ``"picked"``, a number of them.

    Raises
    ------
    ValueError
        If the data are not finite, of different lengths or fewer than three, or a
        number is too small.

    Notes
    -----
    - *squares within charts*: sum of squared distances from the charts' means, in the
      space of policies; charts by SMCE. *chord* picks the point furthest below the line
      between the curve's ends, *knee* the first that stands out (`msc.spectral.knee`).
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
    >>> readings = read_elbows(tasks, policies, max_charts=6)
    >>> readings["squares"]["picked"]
    2
    """
    X, y = _check(tasks, policies, max_charts=max_charts, n_folds=n_folds)
    folds = list(KFold(min(n_folds, len(X)), shuffle=True, random_state=seed).split(X))
    n_counts = min(max_charts, *(len(train) for train, _ in folds))
    affinity, values, charts = _cut(y, n_counts, seed)
    squares = np.array([within_chart_squares(y, labels) for labels in charts])
    gaps = np.diff(values)[:n_counts]
    rows = np.array(
        [
            KMeans(count, n_init=10, random_state=seed).fit(affinity).inertia_
            for count in range(1, n_counts + 1)
        ]
    )
    errors = np.mean(
        [_fold_errors(X, y, fold, n_counts, seed) for fold in folds], axis=0
    )
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


def measure_elbows(
    tasks: ArrayLike,
    policies: ArrayLike,
    *,
    n_resamples: int = 50,
    share: float = 0.8,
    max_charts: int = 10,
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Read the elbow in every way, and again on many parts of the data.

    Parameters
    ----------
    tasks : array-like of shape (n_tasks, n_task_params)
        Tasks, in radians.
    policies : array-like of shape (n_tasks, n_params)
        Their policies.
    n_resamples : int, default=50
        How many parts, drawn at random without replacement.
    share : float, default=0.8
        Share of the tasks in a part.
    max_charts : int, default=10
        Largest number of charts.
    seed : int, default=0
        Seed of all that is random.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Fit for JSON: what was asked for, and under ``"readings"``, by the names of
        `READINGS`, ``"curve"`` and ``"picked"`` of all tasks and ``"resampled"``, on
        how many parts each number was picked.

    Raises
    ------
    ValueError
        If the data are not finite or too few, or a number is out of range.
    """
    X, y = _check(tasks, policies, max_charts=max_charts, n_resamples=n_resamples)
    size = round(share * len(X))
    if not 3 <= size <= len(X):
        raise ValueError(
            f"share={share!r} of {len(X)} tasks must be from 3 to all of them"
        )
    rng = np.random.default_rng(seed)
    parts = [np.arange(len(X))]
    parts += [np.sort(rng.permutation(len(X))[:size]) for _ in range(n_resamples)]
    whole, *resampled = call_in_order(
        partial(read_elbows, max_charts=max_charts, seed=seed),
        [(X[part], y[part]) for part in parts],
        jobs=jobs,
        label="elbows",
        progress=progress,
    )
    return {
        "n_samples": len(X),
        "n_resamples": n_resamples,
        "share": share,
        "max_charts": max_charts,
        "seed": seed,
        "readings": {
            name: {**whole[name], "resampled": _count(resampled, name)}
            for name in READINGS
        },
    }


def choose_reading(*measured: Mapping[str, Any]) -> str:
    """Choose the default reading by a criterion that looks at no regression.

    The reading must need nothing but the policies, be defined for any number of them,
    and pick the same number most often over the parts of the data, on the average over
    the workspaces. The last number considered is no elbow and does not count. Ties go
    to the reading nearest the paper's words.

    Parameters
    ----------
    *measured : dict
        What `measure_elbows` returned, one a workspace.

    Returns
    -------
    str
        A name of `READINGS`.
    """
    means = {
        name: np.mean([most_picked(one, name)[1] for one in measured])
        for name in FROM_POLICIES
    }
    return max(means, key=lambda name: means[name])  # the first of equals


def most_picked(measured: Mapping[str, Any], name: str) -> tuple[int, float]:
    """Tell which number of charts a reading picked most often.

    Parameters
    ----------
    measured : dict
        What `measure_elbows` returned.
    name : str
        A name of `READINGS`.

    Returns
    -------
    charts : int
        The number, the last one considered excepted; 0 if there is no other.
    share : float
        On what share of the parts it was picked.

    Examples
    --------
    >>> reading = {"curve": [3, 2, 1], "resampled": {"2": 2, "3": 4}}
    >>> most_picked({"readings": {"eigengap": reading}}, "eigengap")
    (2, 0.3333333333333333)
    """
    reading = measured["readings"][name]
    times = {int(count): number for count, number in reading["resampled"].items()}
    inside = {k: v for k, v in times.items() if k < len(reading["curve"])} or {0: 0}
    best = max(inside, key=lambda count: inside[count])
    return best, inside[best] / sum(times.values())


def _count(resampled: list[dict[str, Any]], name: str) -> dict[str, int]:
    """Count how often each number was picked, the smallest number first."""
    picked = Counter(readings[name]["picked"] for readings in resampled)
    return {str(count): picked[count] for count in sorted(picked)}


def _check(tasks: ArrayLike, policies: ArrayLike, **least: int) -> tuple[Array, Array]:
    """Return tasks and policies as floats; numbers must be positive integers."""
    for name, number in least.items():
        lowest = 2 if name == "n_folds" else 1
        if not isinstance(number, int | np.integer) or number < lowest:
            raise ValueError(
                f"{name}={number!r} must be an integer of {lowest} or more"
            )
    X, y = check_X_y(
        tasks, policies, dtype=np.float64, multi_output=True, ensure_min_samples=3
    )
    return X, y.astype(np.float64).reshape(len(X), -1)


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
