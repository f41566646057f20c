"""How many charts, and found by what: what the study measures of these choices.

How firmly each criterion picks a number of charts, when it is asked again on parts of
the data; from this follows the default one, without a look at any regression. How well
clusterers find the pieces that jumps leave of the policies.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from sklearn.cluster import AgglomerativeClustering, KMeans
from sklearn.metrics import adjusted_rand_score

from msc._checks import check_whole, to_floats, validate_sample
from msc._parallel import call_in_order
from msc.learn import SELECTION_CRITERIA, SMCE
from msc.study._elbows import read_elbows

FROM_POLICIES = tuple(name for name in SELECTION_CRITERIA if name != "cross_validation")
"""The criteria that need nothing but the policies."""


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
    """Read the elbow by every criterion, and again on many parts of the data.

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
        `SELECTION_CRITERIA`, ``"curve"`` and ``"picked"`` of all tasks and
        ``"resampled"``, on how many parts each number was picked.

    Raises
    ------
    ValueError
        If the data are not finite or too few, or a number is out of range.
    """
    check_whole("max_charts", max_charts, 1)
    check_whole("n_resamples", n_resamples, 1)
    X, y = validate_sample(tasks, policies)
    size = round(share * len(X)) if 0 < share <= 1 else 0  # NaN is neither
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
            name: {**whole[name], "resampled": _count(one[name] for one in resampled)}
            for name in SELECTION_CRITERIA
        },
    }


def most_picked(measured: Mapping[str, Any], name: str) -> tuple[int, float]:
    """Tell which number of charts a criterion picked most often.

    Parameters
    ----------
    measured : dict
        What `measure_elbows` returned.
    name : str
        A name of `SELECTION_CRITERIA`.

    Returns
    -------
    charts : int
        The number, the last one considered excepted; 0 if there is no other.
    share : float
        On what share of the parts it was picked; never NaN, there is a part at least.

    Examples
    --------
    >>> found = {"curve": [3, 2, 1], "resampled": {"2": 2, "3": 4}}
    >>> most_picked({"readings": {"eigengap": found}}, "eigengap")
    (2, 0.3333333333333333)
    """
    found = measured["readings"][name]  # by criterion
    times = {int(count): number for count, number in found["resampled"].items()}
    inside = {k: v for k, v in times.items() if k < len(found["curve"])} or {0: 0}
    best = max(inside, key=lambda count: inside[count])
    return best, inside[best] / sum(times.values())


def choose_criterion(*measured: Mapping[str, Any]) -> str:
    """Choose the default criterion, without a look at any regression.

    It must need nothing but the policies, be defined for any number of them, and pick
    the same number most often over the parts of the data, on the average over the
    workspaces. The last number considered is no elbow and does not count. One chart
    does: all criteria can answer it, and a knee that always says so is firm. Ties go to
    the criterion nearest the paper's words.

    Parameters
    ----------
    *measured : dict
        What `measure_elbows` returned, one a workspace.

    Returns
    -------
    str
        A name of `SELECTION_CRITERIA`.
    """
    means = {
        name: np.mean([most_picked(one, name)[1] for one in measured])
        for name in FROM_POLICIES
    }
    return max(means, key=lambda name: means[name])  # the first of equals


def compare_clusterers(
    policies: ArrayLike,
    jumps: ArrayLike,
    counts: Sequence[int] = (4, 6),
    *,
    seed: int = 0,
) -> pd.DataFrame:
    """Cluster policies in several ways and hold the clusters against their jumps.

    Parameters
    ----------
    policies : array_like of shape (n_tasks, n_params)
        Policies, in the order of their tasks.
    jumps : array_like of int
        Indices i for which the step from policy i to the next is a jump.
    counts : sequence of int, default=(4, 6)
        Numbers of clusters asked for.
    seed : int, default=0
        Seed of SMCE and of k-means.

    Returns
    -------
    DataFrame
        One row a number and clusterer: how many jumps lie between two clusters, of how
        many steps that do, and the adjusted Rand index of the clusters and the pieces
        between jumps (1: the same, 0: no more alike than by chance).

    Examples
    --------
    >>> policies = [[0.0], [0.1], [0.2], [5.0], [5.1], [9.0]]
    >>> table = compare_clusterers(policies, [2, 4], [3])
    >>> table.loc[(3, "k-means")].tolist()
    [2.0, 2.0, 1.0]
    """
    points, at = to_floats("policies", policies), np.asarray(jumps, dtype=int)
    pieces = np.searchsorted(at, np.arange(len(points)))
    rows = {}
    for way, labels in find_clusters(points, counts, seed=seed).items():
        borders = np.flatnonzero(np.diff(labels))
        agreement = adjusted_rand_score(pieces, labels)
        rows[way] = np.isin(at, borders).sum(), len(borders), agreement
    columns = [f"of {len(at)} jumps, at a border", "borders", "adjusted Rand index"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    table.index = pd.MultiIndex.from_tuples(table.index, names=["charts", "found by"])
    return table


def find_clusters(
    policies: ArrayLike, counts: Sequence[int] = (4, 6), *, seed: int = 0
) -> dict[tuple[int, str], NDArray[np.intp]]:
    """Cluster policies in several ways.

    Parameters
    ----------
    policies : array_like of shape (n_tasks, n_params)
        Policies.
    counts : sequence of int, default=(4, 6)
        Numbers of clusters asked for.
    seed : int, default=0
        Seed of SMCE and of k-means.

    Returns
    -------
    dict of (int, str) to ndarray of shape (n_tasks,)
        By number and clusterer: the cluster of each policy.

    Examples
    --------
    >>> found = find_clusters([[0.0], [0.1], [5.0], [5.1]], [2])
    >>> found[2, "single linkage"].tolist()
    [0, 0, 1, 1]
    """
    points = to_floats("policies", policies)
    found = {}
    for count in counts:
        ways: dict[str, Any] = {
            "SMCE": SMCE(count, random_state=seed),
            "k-means": KMeans(count, n_init=10, random_state=seed),
            "single linkage": AgglomerativeClustering(count, linkage="single"),
        }
        for name, clusterer in ways.items():
            found[count, name] = clusterer.fit_predict(points)
    return found


def _count(findings: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Count how often each number was picked, the smallest number first."""
    picked = Counter(finding["picked"] for finding in findings)
    return {str(count): picked[count] for count in sorted(picked)}
