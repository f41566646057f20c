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

_LEAST = 1e-12  # squared spreads: errors of a millionth of a spread are none

Averages = Mapping[str, Average]


@dataclass(frozen=True)
class Comparison:
    """What was measured of the methods.

    Attributes
    ----------
    errors : dict of str to Average
        By method, the simplest first, its error: the squared error of policies, each
        column of unit spread, averaged over columns and over tasks in the blocks that
        took no part in its fit.
    failed : dict of str to str
        Why methods could not be fitted.
    chosen : str
        The simplest of those as good as the best, see `choose`.
    nested : Average
        The error of choosing: in each fold, that of what was chosen by the others.
    picks : tuple of str
        What was chosen so, fold by fold.
    curve : dict of str to dict of int to float
        By method, its error by how many tasks it learned from.
    """

    errors: dict[str, Average]
    failed: dict[str, str]
    chosen: str
    nested: Average
    picks: tuple[str, ...]
    curve: dict[str, dict[int, float]]

    def over_mean(self, error: Average) -> Estimate:
        """Divide an error by that of the mean policy."""
        return error.over(self.errors[next(iter(self.errors))])


def choose(errors: Averages) -> str:
    """Choose the simplest method that nothing says is worse than the best.

    Parameters
    ----------
    errors : mapping of str to Average
        By method, the simplest first.

    Returns
    -------
    str
        The first whose error, over the least one, has an interval that reaches one.
    """
    best = min(errors.values(), key=lambda error: error.value)
    return next(
        name for name, error in errors.items() if error.over(best).verdict != "higher"
    )


def plan_fits(
    skills: Mapping[str, TableSkill], blocks: Blocks, sizes: Sequence[int]
) -> list[tuple[str, tuple[int, ...], int]]:
    """List what is fitted: which method, without which folds, to at most how many.

    Without each fold, for the errors; without each pair, for the choices from which a
    fold was kept; and without each fold to fewer tasks, for the curve.
    """
    n_folds = int(blocks.folds.max()) + 1
    single = [(fold,) for fold in range(n_folds)]
    pairs = list(combinations(range(n_folds), 2))
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
    X, y, cost = data
    plan = plan_fits(skills, blocks, sizes)
    calls = [
        (skills[name], size, X, y, cost, blocks, left_out)
        for name, left_out, size in plan
    ]
    found: dict[tuple[str, tuple[int, ...], int], Any] = {}
    for number, result in run(_left_out, calls):
        found[plan[number]] = result
        done()
    failed = {
        name: found[name, left_out, size]
        for name, left_out, size in reversed(plan)
        if isinstance(found[name, left_out, size], str)
    }
    sound = {name: one.max_tasks for name, one in skills.items() if name not in failed}
    n_folds = int(blocks.folds.max()) + 1

    def gather(name: str, size: int, outer: int | None = None) -> Array:
        """Put together a method's errors, one a block; without what an outer had."""
        errors = np.full(len(blocks.folds), np.nan)
        for fold in range(n_folds):
            if fold != outer:
                left_out = tuple(sorted({fold, fold if outer is None else outer}))
                here = blocks.folds == fold
                errors[here] = found[name, left_out, size][here]
        return errors

    def average(errors: Array) -> Average:
        known = ~np.isnan(errors)
        return Average(np.maximum(errors[known], _LEAST), blocks.sizes[known])

    errors = {name: gather(name, size) for name, size in sound.items()}
    averages = {name: average(one) for name, one in errors.items()}
    nested, picks = np.empty(len(blocks.folds)), []
    for outer in range(n_folds):
        inner = {n: average(gather(n, size, outer)) for n, size in sound.items()}
        picks.append(choose(inner))
        here = blocks.folds == outer
        nested[here] = errors[picks[-1]][here]
    curve = {
        name: {
            **{size: average(gather(name, size)).value for size in sizes},
            largest: averages[name].value,
        }
        for name, largest in sound.items()
        if sizes and not METHODS[name].takes_all
    }
    chosen = choose(averages)
    return Comparison(averages, failed, chosen, average(nested), tuple(picks), curve)


def _left_out(
    skill: TableSkill,
    max_tasks: int,
    X: Array,
    y: Array,
    cost: Array | None,
    blocks: Blocks,
    left_out: tuple[int, ...],
) -> Array | str:
    """Return the error of each block left out, NaN of others; or why there is none."""
    test = blocks.in_folds(*left_out)
    paid = None if cost is None else cost[~test]
    model = clone(skill).set_params(max_tasks=max_tasks)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # those of the fit to all are told
            missed = model.fit(X[~test], y[~test], paid).predict(X[test]) - y[test]
    except ValueError as error:
        return " ".join(str(error).split())
    squares = np.zeros(len(X))
    squares[test] = (missed**2).mean(axis=1)
    errors = blocks.average(squares)
    errors[~np.isin(blocks.folds, left_out)] = np.nan
    return errors
