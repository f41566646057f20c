"""How far off a policy may be, and which tasks are doubtful, whatever learned them.

Where the nearest known tasks have policies far apart, as beside a break, a prediction
is likely to be off. What that is worth is measured on tasks that were left out.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import hypergeom
from sklearn.base import BaseEstimator, clone
from sklearn.neighbors import NearestNeighbors

from msc._parallel import Runner
from msc.estimates import six_digits
from msc.skills._blocks import N_FOLDS, Blocks
from msc.skills._choose import average

Array = NDArray[np.float64]
Data = tuple[Array, Array, Array | None]
LeftOut = tuple[Array, Array, Array]
"""Of each row, by policy column: what was missed, its deviation, how far apart."""

LEVEL = 0.9
"""Of bands: the share of policies that each should hold."""

DOUBTED = 0.1
"""Of tasks left out alone, the share that would have been flagged."""

WORST = 0.1
"""Of blocks left out, those of the largest errors, which flags should find."""

_NEAR = 5  # tasks asked
_FLOOR = 0.2  # of a spread: that a few known tasks agree is no proof
_SURE = 0.025  # chance of a flag's finding so many, below which it is no chance


class Doubt(BaseEstimator):  # type: ignore[misc]
    """Tell how far apart the policies of a task's neighbours are, and what that means.

    Attributes
    ----------
    near_ : NearestNeighbors
        Finds the five nearest different tasks.
    policies_ : ndarray of shape (n_tasks, n_params)
        Their policies, of unit spread; those of equal tasks averaged.
    halves_ : ndarray of shape (n_params,)
        Half the width of a band where neighbours are one spread apart; NaN if too few
        errors are known.
    limit_ : float
        How far apart they are, on average over columns, where a task is doubtful.
    """

    def fit(self, points: Array, policies: Array) -> Doubt:
        """Remember known tasks."""
        different, place = np.unique(points, axis=0, return_inverse=True)
        sums = np.zeros((len(different), policies.shape[1]))
        np.add.at(sums, place, policies)
        self.policies_ = sums / np.bincount(place)[:, None]
        n_near = min(_NEAR, len(different))
        self.near_ = NearestNeighbors(n_neighbors=n_near).fit(different)
        self.halves_, self.limit_ = np.full(policies.shape[1], np.nan), np.nan
        return self

    def measure(self, points: Array) -> Array:
        """Return the standard deviation of the neighbours' policies, by column."""
        near = self.near_.kneighbors(points, return_distance=False)
        return np.asarray(self.policies_[near].std(axis=1) + _FLOOR)

    def calibrate(self, missed: Array, apart: Array) -> Doubt:
        """Learn from errors, one a task, what neighbours apart mean.

        Errors are divided by how far apart neighbours are; the band ends at the
        quantile of that (H. Papadopoulos, V. Vovk and A. Gammerman, "Regression
        conformal prediction with nearest neighbours", JAIR 40, 2011).
        """
        if np.isfinite(missed).all():
            self.halves_ = find_halves(missed, apart)
            self.limit_ = float(np.quantile(apart.mean(axis=1), 1 - DOUBTED))
        return self


def find_halves(missed: Array, scales: Array) -> Array:
    """Return by column where conformal bands of unit scale end; NaN: too few errors."""
    conformal, ends = load_crepes(), []
    for errors, sigmas in zip(missed.T, scales.T, strict=True):
        model = conformal().fit(errors, sigmas=sigmas)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of too few, told by an infinite band
            (band,) = model.predict_int(
                np.zeros(1), sigmas=np.ones(1), confidence=LEVEL
            )
        ends.append(band[1])
    return np.where(np.isfinite(ends), ends, np.nan)


def load_crepes() -> Any:
    """Return the class that makes conformal bands, which an extra brings.

    Returns
    -------
    type
        `crepes.ConformalRegressor`.

    Raises
    ------
    ValueError
        If the extra is not installed.
    """
    try:
        from crepes import ConformalRegressor  # noqa: PLC0415
    except ImportError:
        raise ValueError(
            "conformal bands need crepes; wanted the extra, pip install 'msc[skills]'"
        ) from None
    return ConformalRegressor


def part_alone(copies: NDArray[np.intp], seed: int) -> Blocks:
    """Deal different tasks into folds at random, each alone, its copies with it."""
    n_different = int(copies.max()) + 1
    return Blocks(
        copies, np.random.default_rng(seed).permutation(n_different) % N_FOLDS
    )


def leave_out(
    skill: Any, data: Data, blocks: Blocks, run: Runner, done: Callable[[], Any]
) -> LeftOut:
    """Predict each fold from the others; NaN where that cannot be fitted."""
    found = np.full((3, *data[1].shape), np.nan)
    calls = [(clone(skill), data, blocks, fold) for fold in range(blocks.n_folds)]
    for fold, told in run(_predict_fold, calls):
        found[:, blocks.in_folds(fold)] = told
        done()
    missed, stds, apart = found
    return missed, stds, apart


def _predict_fold(skill: Any, data: Data, blocks: Blocks, fold: int) -> Array | float:
    """Predict a fold from the others."""
    X, y, cost = data
    test = blocks.in_folds(fold)
    paid = None if cost is None else cost[~test]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # those of the fit to all are told
            skill.fit(X[~test], y[~test], paid)
            means, stds = skill.predict(X[test], return_std=True)
    except ValueError:
        return np.nan
    known, new = (skill.scale_.transform(X[one]) for one in (~test, test))
    return np.stack([means - y[test], stds, Doubt().fit(known, y[~test]).measure(new)])


def judge_doubt(doubt: Doubt, left_out: LeftOut, blocks: Blocks) -> dict[str, Any]:
    """Say what bands and flags are worth in blocks left out.

    Returns
    -------
    dict
        Fit for JSON. ``"conformal"``: the share of policies, over columns and tasks,
        that bands held, with its interval, or None. ``"flag"``: how many blocks are
        doubtful, how many there are; how many are those of the largest errors, and how
        many of them are doubtful; whether chance would hardly catch as many.
    """
    missed, _, apart = left_out
    if not np.isfinite(doubt.halves_).all():
        return {"conformal": None, "flag": None}
    held = (np.abs(missed) <= doubt.halves_ * apart).mean(axis=1)
    told = average(blocks.average(held), blocks.sizes)
    low, high = np.clip(told.bounds, 0, 1)
    band = {"level": LEVEL, "held": told.value, "low": float(low), "high": float(high)}
    flags = blocks.average(apart.mean(axis=1)) > doubt.limit_
    errors = blocks.average((missed**2).mean(axis=1))
    n_blocks, n_flagged = len(flags), int(flags.sum())
    n_worst = max(round(WORST * n_blocks), 1)
    caught = int(flags[np.argsort(-errors, kind="stable")[:n_worst]].sum())
    chance = hypergeom.sf(caught - 1, n_blocks, n_flagged, n_worst)
    flag = {
        "n_blocks": n_blocks,
        "n_flagged": n_flagged,
        "n_worst": n_worst,
        "n_caught": caught,
        "is_sure": bool(chance < _SURE),
    }
    return {
        "conformal": {key: six_digits(one) for key, one in band.items()},
        "flag": flag,
    }
