"""Methods by their ranks, over everything that is measured of them.

Methods are ranked where they meet: in a *block*, an arc of the circle of test tasks in
a world. Blocks are what a rank test takes for independent draws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.stats import f as f_distribution
from scipy.stats import rankdata, studentized_range

from msc._checks import check_whole
from msc.study._store import Trials
from msc.study._summaries import MEASURES

N_ARCS = 8  # of 45° each: neighbouring test tasks err alike, arcs hardly do
RANKED = (
    "mse, gate learned",
    "standardised mse, gate learned",
    "error_cm",
    "excess_cost",
)
RANKED_SIZES = (12, 24, 50)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ranks:
    """Average ranks of methods, and how far apart they have to be.

    Attributes
    ----------
    means : Series
        Average rank by method, ascending; 1 is the best.
    n_blocks : int
        Blocks in which methods were ranked.
    critical : float
        Critical difference, see `critical_difference`.
    p_value : float
        Of Friedman's test that all methods are alike, with Iman's and Davenport's
        correction.
    alike : float
        Correlation of ranks in neighbouring blocks, each method's average taken off:
        what speaks against blocks as independent draws, if it is large.
    left_out : dict from str to str
        Methods that are not ranked, and why.
    """

    means: pd.Series
    n_blocks: int
    critical: float
    p_value: float
    alike: float
    left_out: dict[str, str]

    @property
    def ties(self) -> list[tuple[int, int]]:
        """Runs of methods that are nearer than the critical difference, the longest.

        Of each the places of the first and the last among `means`; a run within
        another, or of one method alone, is none.
        """
        values = self.means.to_numpy()
        lasts = np.searchsorted(values, values + self.critical, side="right") - 1
        ties: list[tuple[int, int]] = []
        for first, last in enumerate(lasts.tolist()):
            if last > first and (not ties or last > ties[-1][1]):
                ties.append((first, last))
        return ties


def critical_difference(n_methods: int, n_blocks: int, level: float = 0.05) -> float:
    """Tell how far apart average ranks must be to differ, by Nemenyi's test.

    Parameters
    ----------
    n_methods : int
        Methods, two at least.
    n_blocks : int
        Independent blocks in which they were ranked.
    level : float, default=0.05
        Chance that any two of methods which are alike seem to differ.

    Returns
    -------
    float
        The difference, in ranks.

    Notes
    -----
    With k methods and N blocks it is q √(k (k + 1) / (6 N)), where q is the quantile of
    the studentised range of k numbers, over √2 [1]_.

    References
    ----------
    .. [1] J. Demšar, "Statistical comparisons of classifiers over multiple data sets",
       Journal of Machine Learning Research 7, 2006.

    Examples
    --------
    >>> round(critical_difference(4, 14), 2)
    1.25
    """
    check_whole("n_methods", n_methods, 2)
    check_whole("n_blocks", n_blocks, 1)
    quantile = studentized_range.ppf(1 - level, n_methods, np.inf) / np.sqrt(2)
    return float(quantile * np.sqrt(n_methods * (n_methods + 1) / (6 * n_blocks)))


def rank_blocks(errors: ArrayLike) -> Array:
    """Rank methods in each block, by their ranks in all conditions together.

    Parameters
    ----------
    errors : array_like of shape (n_conditions, n_blocks, n_methods)
        Errors; a condition is a measure and a number of training tasks, whose errors
        have nothing to do with those of another.

    Returns
    -------
    ndarray of shape (n_blocks, n_methods)
        Ranks from 1; methods that are alike share theirs.

    Examples
    --------
    >>> rank_blocks([[[0.1, 0.3, 0.2]], [[5.0, 9.0, 7.0]]])
    array([[1., 3., 2.]])
    """
    by_condition = rankdata(np.asarray(errors), axis=-1).mean(axis=0)
    return np.asarray(rankdata(by_condition.round(9), axis=-1))


def friedman(ranks: ArrayLike) -> float:
    """Test whether methods are alike: Friedman's test, with Iman's and Davenport's F.

    Parameters
    ----------
    ranks : array_like of shape (n_blocks, n_methods)
        What `rank_blocks` gives.

    Returns
    -------
    float
        The chance of ranks that are as far apart, if methods are alike.
    """
    values = np.asarray(ranks, dtype=float)
    n_blocks, n_methods = values.shape
    means = values.mean(axis=0)
    between = n_blocks * np.sum((means - means.mean()) ** 2)
    within = np.sum((values - values.mean(axis=1, keepdims=True)) ** 2)
    left = within - between  # a two-way analysis of variance of the ranks
    freedom = n_methods - 1, (n_methods - 1) * (n_blocks - 1)
    if not left > 0:
        return 0.0
    return float(f_distribution.sf(between * (n_blocks - 1) / left, *freedom))


def correlate_neighbours(circles: Sequence[Array]) -> float:
    """Correlate the ranks of blocks that follow each other round a circle.

    Parameters
    ----------
    circles : sequence of ndarray of shape (n_blocks, n_methods)
        Of each circle. The average rank of a method on a circle is taken off.

    Returns
    -------
    float
        The correlation; of independent blocks it is minus one over their number less
        one, in the mean. 0 if the ranks are the same everywhere.
    """
    apart = [ranks - ranks.mean(axis=0) for ranks in circles]
    next_to = sum(float(np.sum(one * np.roll(one, 1, axis=0))) for one in apart)
    scatter = sum(float(np.sum(one**2)) for one in apart)
    return next_to / scatter if scatter else 0.0


def rank_methods(
    trials: Mapping[str, Mapping[str, Trials]],
    names: Iterable[str],
    *,
    measures: Sequence[str] = RANKED,
    sizes: Sequence[int] = RANKED_SIZES,
    n_arcs: int = N_ARCS,
) -> Ranks:
    """Rank methods on arcs of test tasks, over worlds, measures and sizes.

    Parameters
    ----------
    trials : mapping
        By world and by method, what `msc.study.read_trials` gives.
    names : iterable of str
        Whom to rank.
    measures : sequence of str, default=RANKED
        Keys of `msc.study.MEASURES`.
    sizes : sequence of int, default=(12, 24, 50)
        Numbers of evenly spaced training tasks.
    n_arcs : int, default=8
        Arcs into which the circle of test tasks is cut.

    Returns
    -------
    Ranks
        Average ranks. Errors are means over an arc and over the training sets that all
        who are ranked have.

    Raises
    ------
    ValueError
        If fewer than two methods have results everywhere.
    """
    wanted = [
        (f"even/{n}/{MEASURES[key].raw}", f"n = {n}") for n in sizes for key in measures
    ]
    left_out, ranked = dict[str, str](), list[str]()
    for name in names:
        if why := _lacks(trials, name, wanted):
            left_out[name] = why
        else:
            ranked.append(name)
    if len(ranked) < 2:
        raise ValueError(f"{ranked} have results everywhere; wanted two methods")
    blocks = []
    for by_method in trials.values():
        conditions = []
        for key, _ in wanted:
            errors = [by_method[name].errors[key] for name in ranked]
            n_sets = min(map(len, errors))
            tasks = np.array([one[:n_sets].mean(axis=0, dtype=float) for one in errors])
            arcs = np.array_split(tasks, n_arcs, axis=1)
            conditions.append([arc.mean(axis=1) for arc in arcs])
        blocks.append(rank_blocks(conditions))
    ranks = np.concatenate(blocks)
    means = pd.Series(ranks.mean(axis=0), index=ranked)
    return Ranks(
        means.sort_values(kind="stable"),
        len(ranks),
        critical_difference(len(ranked), len(ranks)),
        friedman(ranks),
        correlate_neighbours(blocks),
        left_out,
    )


def _lacks(
    trials: Mapping[str, Mapping[str, Trials]],
    name: str,
    wanted: Sequence[tuple[str, str]],
) -> str:
    """Say what a method lacks to be ranked; nothing if it has all."""
    for world, by_method in trials.items():
        if name not in by_method:
            return f"no results in {world!r}"
        errors = by_method[name].errors
        for key, size in wanted:
            cell, _, measure = key.rpartition("/")
            if key not in errors and any(one.startswith(f"{cell}/") for one in errors):
                return f"has no {measure}"
            if key not in errors:
                return f"not tried in {world!r} at {size}"
            if np.isnan(errors[key]).any():
                return f"failed in {world!r} at {size}"
    return ""
