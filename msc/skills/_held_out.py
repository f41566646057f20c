"""What the chosen method's bands hold, and its error if single rows are left out."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from sklearn.base import clone

from msc._parallel import Runner
from msc.estimates import six_digits
from msc.skills._blocks import N_FOLDS, Blocks
from msc.skills._choose import average, measure_left_out
from msc.skills._skill import TableSkill

Array = NDArray[np.float64]
Data = tuple[Array, Array, Array | None]

LEVELS = (0.5, 0.68, 0.8, 0.9, 0.95, 0.99)
"""Of bands: which share of policies each should hold."""


def judge_chosen(
    skill: TableSkill,
    data: Data,
    blocks: Blocks,
    *,
    seed: int,
    run: Runner,
    done: Callable[..., Any],
) -> dict[str, Any]:
    """Measure bands by the blocks, and the error if single rows were left out.

    Returns
    -------
    dict
        Fit for JSON. ``"bands"``: by level, the share of policies, over columns and
        tasks, that the band of a normal distribution held in blocks left out; none if
        the method has no deviations. ``"single_rows_error"``: as the errors of blocks,
        but with rows dealt alone into folds; None if it cannot be fitted so.
    """
    folds = np.random.default_rng(seed).permutation(len(data[0])) % N_FOLDS
    rows = Blocks(np.arange(len(folds)), folds)
    alone: dict[int, Any] = {}
    calls: list[Any] = [(clone(skill), data, rows, (fold,)) for fold in range(N_FOLDS)]
    for fold, errors in run(measure_left_out, calls):
        alone[fold] = errors
        done()
    error = None
    if not any(isinstance(errors, str) for errors in alone.values()):
        error = six_digits(
            float(np.nansum([alone[fold] for fold in range(N_FOLDS)]) / len(folds))
        )
    bands: list[dict[str, float]] = []
    told = {"bands": bands, "single_rows_error": error}
    if not skill.has_std:
        done(blocks.n_folds)
        return told
    held = np.empty((len(LEVELS), len(blocks.folds)))
    calls = [(clone(skill), data, blocks, fold) for fold in range(blocks.n_folds)]
    for fold, shares in run(_hold, calls):
        held[:, blocks.folds == fold] = shares
        done()
    for level, of_blocks in zip(LEVELS, held, strict=True):
        share = average(of_blocks, blocks.sizes)
        low, high = np.clip(share.bounds, 0, 1)
        found = {"held": share.value, "low": float(low), "high": float(high)}
        bands.append(
            {"level": level, **{key: six_digits(one) for key, one in found.items()}}
        )
    return told


def _hold(skill: TableSkill, data: Data, blocks: Blocks, fold: int) -> Array:
    """Return by level the share of policies held in each block of a fold."""
    X, y, cost = data
    test, here = blocks.in_folds(fold), blocks.folds == fold
    paid = None if cost is None else cost[~test]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of the fit to all are told
        means, stds = skill.fit(X[~test], y[~test], paid).predict(X[test], True)
    within = norm.ppf(0.5 + np.array(LEVELS) / 2)[:, None, None] * stds
    shares = np.zeros((len(LEVELS), len(X)))
    shares[:, test] = (np.abs(means - y[test]) <= within).mean(axis=2)
    return np.array([blocks.average(one)[here] for one in shares])
