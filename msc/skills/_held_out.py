"""What the chosen method's bands hold, and its error if single rows are left out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm
from sklearn.base import clone

from msc._parallel import Runner
from msc.estimates import six_digits
from msc.skills._bands import Data, LeftOut, leave_out
from msc.skills._blocks import N_FOLDS, Blocks
from msc.skills._choose import average, measure_left_out
from msc.skills._skill import TableSkill

Array = NDArray[np.float64]

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
) -> tuple[dict[str, Any], LeftOut]:
    """Measure bands by the blocks, and the error if single rows were left out.

    Returns
    -------
    told : dict
        Fit for JSON. ``"bands"``: by level, the share of policies, over columns and
        tasks, that the band of a normal distribution held in blocks left out; none if
        the method has no deviations. ``"single_rows_error"``: as the errors of blocks,
        but with rows dealt alone into folds; None if it cannot be fitted so.
    left_out : tuple of ndarray
        What became of each block left out.
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
    left_out = leave_out(skill, data, blocks, run, done)
    missed, stds, _ = left_out
    bands = []
    if np.isfinite(stds).all():
        for level in LEVELS:
            held = np.abs(missed) <= norm.ppf(0.5 + level / 2) * stds
            told = average(blocks.average(held.mean(axis=1)), blocks.sizes)
            low, high = np.clip(told.bounds, 0, 1)
            found = {"held": told.value, "low": float(low), "high": float(high)}
            bands.append(
                {"level": level, **{key: six_digits(one) for key, one in found.items()}}
            )
    return {"bands": bands, "single_rows_error": error}, left_out
