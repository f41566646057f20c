"""A few tasks that stand for many: spread over all of them, and drawn by a seed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_AMONG = 10  # times as many as are wanted, from which these are taken


def spread_out(
    points: NDArray[np.float64], n_wanted: int, seed: int
) -> NDArray[np.intp]:
    """Choose points that fill the space which all of them lie in.

    Each is the one farthest from those before it (T. F. Gonzalez, "Clustering to
    minimize the maximum intercluster distance", Theoretical Computer Science 38, 1985),
    among ten times as many as are wanted, drawn at random.

    >>> spread_out(np.arange(9.0)[:, None], 3, seed=0)
    array([0, 4, 8])
    """
    n_points = len(points)
    if n_points <= n_wanted:
        return np.arange(n_points)
    rng = np.random.default_rng(seed)
    some = np.sort(rng.choice(n_points, min(n_points, _AMONG * n_wanted), False))
    among = points[some]
    center = among.mean(axis=0)
    chosen = [int(((among - center) ** 2).sum(axis=1).argmax())]
    apart = ((among - among[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < n_wanted and apart.max() > 0:
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, ((among - among[chosen[-1]]) ** 2).sum(axis=1))
    others = np.setdiff1d(np.arange(len(some)), chosen)  # copies, if there are no more
    chosen += rng.permutation(others)[: n_wanted - len(chosen)].tolist()
    return np.asarray(np.sort(some[chosen]))
