"""Methods compared by blocks of tasks that were left out, and one of them chosen."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.base import clone

from msc._parallel import Runner
from msc.estimates import Average, Estimate
from msc.skills._blocks import Blocks
from msc.skills._methods import METHODS
from msc.skills._skill import TableSkill

Array = NDArray[np.float64]

MOST_NESTED = 10_000
"""Rows up to which methods are fitted without pairs of folds: twice as many fits."""


@dataclass(frozen=True)
class Comparison:
    """What was measured of the methods.

    Attributes
    ----------
    errors : dict of str to ndarray of shape (n_blocks,)
        By method, the simplest first, its error in each block: the squared error of
        policies, each column of unit spread, averaged over columns and over the block's
        tasks, when it took no part in the fit.
    sizes : ndarray of shape (n_blocks,)
        How many tasks each has.
    failed : dict of str to str
        Why methods could not be fitted.
    chosen : str
        The simplest of those as good as the best, see `choose`.
    nested : ndarray of shape (n_blocks,)
        The error of choosing: in each block, that of what was chosen by other folds;
        by fits that had not seen it either, see `is_nested`.
    picks : tuple of str
        What was chosen so, fold by fold.
    curve : dict of str to dict of int to float
        By method, its error by how many tasks it learned from.
    """

    errors: dict[str, Array]
    sizes: NDArray[np.intp]
    failed: dict[str, str]
    chosen: str
    nested: Array
    picks: tuple[str, ...]
    curve: dict[str, dict[int, float]]


def average(errors: Array, sizes: NDArray[np.intp]) -> Estimate:
    """Average the errors of blocks, see `_sample`."""
    return _sample(errors, sizes).estimate


def _sample(errors: Array, sizes: NDArray[np.intp]) -> Average:
    """Take the errors of blocks for an independent sample.

    The interval of `Average` for neighbouring test tasks asks for other circles of
    tasks; here it is the same tasks, of which all blocks are a part.
    """
    return Average((errors * sizes / sizes.mean())[:, None])


def exceed(errors: Array, least: Array, sizes: NDArray[np.intp]) -> Estimate:
    """Say by how much errors exceed others in the same blocks, on average."""
    below = average(least - errors, sizes)  # of either sign: not by logarithms
    low, high = below.bounds
    return Estimate(0.0 - below.value, 0.0 - high, 0.0 - low)


def is_worse(errors: Array, least: Array, sizes: NDArray[np.intp]) -> bool:
    """Tell whether errors exceed others for certain, by their difference or ratio.

    Where errors at a jump are a hundred times others, who misses one block less would
    by the ratio seem to be as good as who misses none; and where a few blocks make up
    most of a small error, by the difference as good as one a hundred times smaller.
    """
    ratio = _sample(errors, sizes).over(_sample(least, sizes))
    return exceed(errors, least, sizes).bounds[0] > 0 or ratio.verdict == "higher"


def choose(errors: Mapping[str, Array], sizes: NDArray[np.intp]) -> str:
    """Choose the simplest method that nothing says is worse than the best.

    >>> errors = {"simple": np.tile([0.0, 3.0], 9), "other": np.tile([1.0, 1.0], 9)}
    >>> choose(errors, np.ones(18))
    'simple'
    """
    best = min(errors.values(), key=lambda error: error @ sizes)
    return next(
        name for name, error in errors.items() if not is_worse(error, best, sizes)
    )


def is_nested(blocks: Blocks) -> bool:
    """Whether rows are few enough for fits without each pair of folds."""
    return len(blocks.of_row) <= MOST_NESTED


def plan_fits(
    skills: Mapping[str, TableSkill], blocks: Blocks, sizes: Sequence[int]
) -> list[tuple[str, tuple[int, ...], int]]:
    """List what is fitted: which method, without which folds, to at most how many.

    Without each fold, for the errors; without each pair, if rows are not too many, for
    the choices from which a fold was kept; and without each fold to fewer tasks, for
    the curve.
    """
    n_folds = blocks.n_folds
    single = [(fold,) for fold in range(n_folds)]
    pairs = list(combinations(range(n_folds), 2)) if is_nested(blocks) else []
    plan = [
        (name, left_out, skill.max_tasks)
        for left_out in [*single, *pairs]
        for name, skill in skills.items()
    ]
    plan += [
        (name, left_out, size)
        for left_out in single
        for name in skills
        for size in sizes
        if not METHODS[name].takes_all
    ]
    return plan


def compare_methods(
    skills: Mapping[str, TableSkill],
    data: tuple[Array, Array, Array | None],
    blocks: Blocks,
    *,
    sizes: Sequence[int],
    run: Runner,
    done: Callable[[], Any],
) -> Comparison:
    """Measure methods on blocks left out, and choose one."""
    plan = plan_fits(skills, blocks, sizes)
    calls = [
        (clone(skills[name]).set_params(max_tasks=size), data, blocks, left_out)
        for name, left_out, size in plan
    ]
    found: dict[tuple[str, tuple[int, ...], int], Any] = {}
    for number, result in run(measure_left_out, calls):
        found[plan[number]] = result
        done()
    failed = {
        name: found[name, left_out, size]
        for name, left_out, size in reversed(plan)
        if isinstance(found[name, left_out, size], str)
    }
    sound = {name: one.max_tasks for name, one in skills.items() if name not in failed}
    n_folds = blocks.n_folds

    def gather(name: str, size: int, outer: int | None = None) -> Array:
        """Put together a method's errors, one a block; without what an outer had."""
        outer = outer if is_nested(blocks) else None
        errors = np.full(len(blocks.folds), np.nan)
        for fold in range(n_folds):
            if fold != outer:
                left_out = tuple(sorted({fold, fold if outer is None else outer}))
                here = blocks.folds == fold
                errors[here] = found[name, left_out, size][here]
        return errors

    errors = {name: gather(name, size) for name, size in sound.items()}
    nested, picks = np.empty(len(blocks.folds)), []
    for outer in range(n_folds):
        here = blocks.folds == outer
        inner = {n: gather(n, size, outer)[~here] for n, size in sound.items()}
        picks.append(choose(inner, blocks.sizes[~here]))
        nested[here] = errors[picks[-1]][here]
    curve = {
        name: {
            size: float(np.average(gather(name, size), weights=blocks.sizes))
            for size in [*sizes, largest]
        }
        for name, largest in sound.items()
        if sizes and not METHODS[name].takes_all
    }
    chosen = choose(errors, blocks.sizes)
    return Comparison(errors, blocks.sizes, failed, chosen, nested, tuple(picks), curve)


def measure_left_out(
    skill: TableSkill,
    data: tuple[Array, Array, Array | None],
    blocks: Blocks,
    left_out: tuple[int, ...],
) -> Array | str:
    """Return the error of each block left out, NaN of others; or why there is none."""
    X, y, cost = data
    test = blocks.in_folds(*left_out)
    paid = None if cost is None else cost[~test]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # those of the fit to all are told
            missed = skill.fit(X[~test], y[~test], paid).predict(X[test]) - y[test]
    except ValueError as error:
        return " ".join(str(error).split())
    squares = np.zeros(len(X))
    squares[test] = (missed**2).mean(axis=1)
    errors = blocks.average(squares)
    errors[~np.isin(blocks.folds, left_out)] = np.nan
    return errors
