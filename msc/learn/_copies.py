"""Points given more than once: which ones repeat another, exactly or nearly.

A demonstration that was recorded twice, or a task that was solved twice, gives points
that say the same. They are no neighbours to reconstruct a point from.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import DisjointSet
from scipy.sparse.csgraph import minimum_spanning_tree
from sklearn.neighbors import NearestNeighbors

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_MOST = 12  # copies of a point that are looked for, itself among them
_TIGHT = 1 / 3  # of the step to the next point: the longest step between copies
_FAR = 2.5  # median steps to a next point: a longer one counts as so long
_COVER = 0.85  # of a group's points: smaller groups that cover so many may replace it
_CHANCE = 0.75  # copies a point that points at random on a curve have, times the ratio
_EVIDENCE = 18.0  # the least logarithm of the likelihood ratio of copies to chance
_REACH = 10.0  # times the ratio of most evidence: groups up to there are copies, too
_EVEN = 0.98  # the mean step of a group over its longest: so even is a piece's spacing
_ROUNDING = 1e-10  # of the step to the next point, and of the distance from zero


class _Group(NamedTuple):
    """Points that keep to themselves; a single one, too."""

    members: list[int]
    apart: float  # step to the next point
    ratio: float  # to this step of the longest one between members
    evenness: float  # the mean step between members, over the longest


class _Part(NamedTuple):
    """A cluster of single linkage: its steps, and the groups found within it."""

    members: list[int]
    longest: float
    total: float
    groups: list[_Group]


def find_copies(X: Array) -> Indices:
    """Find for every point the one that it repeats.

    Parameters
    ----------
    X : ndarray of shape (n_points, n_features)
        Points.

    Returns
    -------
    ndarray of shape (n_points,)
        Index of the first point that says the same: the point's own if there is none
        before it.

    Notes
    -----
    Equal rows are always copies. Others are when they keep to themselves: single
    linkage joins at most 12 of them by steps that are all shorter than a third of the
    step from there to any other point. A group's *ratio* is that of its longest step
    to this one, whatever the scale around it.

    Points at random on a curve have such groups by chance: up to a ratio r, less than
    0.75 r copies a point, and fewer on a sheet. Near copies count only where there are
    more than that: at the r where the Poisson likelihood ratio is greatest it has to
    exceed exp(18). Then groups are copies up to ten times this r. They have to be more
    than the largest of them has points (a few far clusters are clusters) and not, most
    of them, evenly spaced (so are pieces of a curve); and a step counts as at most 2.5
    median ones (a small piece far from all others is a piece). What nothing tells from
    copies are many far clusters of at most 12 points each.
    Groups with a ratio below 1e-10, and steps below 1e-10 of their distance from zero,
    differ by rounding and always count.

    Examples
    --------
    >>> demonstrations = np.repeat(np.arange(12.0), 2)[:, None]
    >>> demonstrations[1::2] += 0.01
    >>> find_copies(demonstrations)[:8]
    array([0, 0, 2, 2, 4, 4, 6, 6])
    """
    _, first, inverse = np.unique(
        X + 0.0, axis=0, return_index=True, return_inverse=True
    )
    distinct, exact = np.sort(first), first[inverse.ravel()]
    found = distinct.copy()
    for members in _near_copies(X[distinct]):
        found[members] = found[min(members)]
    return found[np.searchsorted(distinct, exact)]


def _near_copies(X: Array) -> list[list[int]]:
    """Return the groups of distinct points that say the same."""
    n_points = len(X)
    if n_points < 3:
        return []
    search = NearestNeighbors(n_neighbors=min(_MOST, n_points - 1), algorithm="kd_tree")
    graph = search.fit(X).kneighbors_graph(mode="distance")
    tree = minimum_spanning_tree(graph.maximum(graph.T)).tocoo()
    edges = sorted(
        zip(tree.data.tolist(), tree.row.tolist(), tree.col.tolist(), strict=True)
    )
    groups = _group(edges, n_points, math.inf)
    reach = 0.0
    if _common_ratio(groups, n_points):
        spacing = float(np.median([group.apart for group in groups]))
        groups = _group(edges, n_points, _FAR * spacing)
        reach = min(_REACH * _common_ratio(groups, n_points), _TIGHT)
    sizes = np.linalg.norm(X, axis=1)
    sizes = np.maximum(sizes, np.median(sizes))

    def by_rounding(group: _Group) -> bool:
        largest = min(group.apart, sizes[group.members].max())
        return bool(group.ratio * group.apart <= _ROUNDING * largest)

    return [
        group.members
        for group in groups
        if len(group.members) > 1 and (group.ratio <= reach or by_rounding(group))
    ]


def _group(
    edges: list[tuple[float, int, int]], n_points: int, far: float
) -> list[_Group]:
    """Group points by single linkage, given the tree's edges, shortest first."""
    found: list[_Group] = []
    joined = DisjointSet(range(n_points))
    parts = {i: _Part([i], 0.0, 0.0, []) for i in range(n_points)}  # by joined's roots
    for step, *ends in edges:
        one, other = (parts.pop(joined[end]) for end in ends)
        groups = _close(one, min(step, far)) + _close(other, min(step, far))
        members = one.members + other.members
        if len(members) > _MOST:  # no group any more
            found += groups
            members, groups = members[: _MOST + 1], []
        joined.merge(*ends)
        total = one.total + other.total + step
        parts[joined[ends[0]]] = _Part(members, step, total, groups)
    return found + [group for part in parts.values() for group in part.groups]


def _close(part: _Part, step: float) -> list[_Group]:
    """Choose the whole part or what is within, now that the next step is known."""
    n_members = len(part.members)
    if n_members == 1:
        return [_Group(part.members, step, 0.0, 1.0)]
    ratio = part.longest / step
    inner = [group for group in part.groups if len(group.members) > 1]
    # A tight whole is a group, unless smaller ones nearly cover it and are tighter.
    is_covered = sum(len(group.members) for group in inner) >= _COVER * n_members
    are_tighter = math.prod(group.ratio for group in inner) < ratio
    if n_members > _MOST or ratio > _TIGHT or (is_covered and are_tighter):
        return part.groups
    mean = part.total / (n_members - 1)
    return [_Group(part.members, step, ratio, mean / part.longest)]


def _common_ratio(groups: list[_Group], n_points: int) -> float:
    """Return up to which ratio groups are most surely more than chance; 0 if not so."""
    evenness = [g.evenness for g in groups if len(g.members) > 2]
    if evenness and np.median(evenness) > _EVEN:
        return 0.0
    tight = sorted((g.ratio, len(g.members)) for g in groups if len(g.members) > 1)
    if not tight:
        return 0.0
    ratios, sizes = np.array(tight).T
    copies = np.cumsum(sizes - 1)
    expected = _CHANCE * n_points * np.maximum(ratios, np.finfo(float).tiny)
    more = np.maximum(copies, expected)  # than chance; by the Poisson likelihood ratio
    evidence = more * np.log(more / expected) - (more - expected)
    best = int(evidence.argmax())
    is_sure = evidence[best] > _EVIDENCE
    is_many = sizes[: best + 1].max() < n_points - copies[best]
    return float(ratios[best]) if is_sure and is_many else 0.0
