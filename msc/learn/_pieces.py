"""How well clusterers find the pieces that jumps leave of the policies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from sklearn.cluster import AgglomerativeClustering, KMeans
from sklearn.metrics import adjusted_rand_score

from msc._arrays import to_floats
from msc.learn._smce import SMCE


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
    for count in counts:
        ways: dict[str, Any] = {
            "SMCE": SMCE(count, random_state=seed),
            "k-means": KMeans(count, n_init=10, random_state=seed),
            "single linkage": AgglomerativeClustering(count, linkage="single"),
        }
        for name, clusterer in ways.items():
            labels = clusterer.fit_predict(points)
            borders = np.flatnonzero(np.diff(labels))
            agreement = adjusted_rand_score(pieces, labels)
            rows[count, name] = np.isin(at, borders).sum(), len(borders), agreement
    columns = [f"of {len(at)} jumps, at a border", "borders", "adjusted Rand index"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=columns)
    table.index = pd.MultiIndex.from_tuples(table.index, names=["charts", "found by"])
    return table
