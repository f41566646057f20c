"""How firmly each reading of the elbow picks: it is read again on parts of the data.

From this follows the default reading, by a criterion that looks at no regression.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from msc._parallel import call_in_order
from msc.learn._elbows import READINGS, check_data, read_elbows

FROM_POLICIES = tuple(name for name in READINGS if name != "cross_validation")
"""The readings that need nothing but the policies."""


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
    """Read the elbow in every way, and again on many parts of the data.

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
        `READINGS`, ``"curve"`` and ``"picked"`` of all tasks and ``"resampled"``, on
        how many parts each number was picked.

    Raises
    ------
    ValueError
        If the data are not finite or too few, or a number is out of range.
    """
    X, y = check_data(tasks, policies, max_charts=max_charts, n_resamples=n_resamples)
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
            name: {**whole[name], "resampled": _count(resampled, name)}
            for name in READINGS
        },
    }


def choose_reading(*measured: Mapping[str, Any]) -> str:
    """Choose the default reading by a criterion that looks at no regression.

    The reading must need nothing but the policies, be defined for any number of them,
    and pick the same number most often over the parts of the data, on the average over
    the workspaces. The last number considered is no elbow and does not count. One chart
    does: all readings can answer it, and a knee that always says so is firm. Ties go to
    the reading nearest the paper's words.

    Parameters
    ----------
    *measured : dict
        What `measure_elbows` returned, one a workspace.

    Returns
    -------
    str
        A name of `READINGS`.
    """
    means = {
        name: np.mean([most_picked(one, name)[1] for one in measured])
        for name in FROM_POLICIES
    }
    return max(means, key=lambda name: means[name])  # the first of equals


def most_picked(measured: Mapping[str, Any], name: str) -> tuple[int, float]:
    """Tell which number of charts a reading picked most often.

    Parameters
    ----------
    measured : dict
        What `measure_elbows` returned.
    name : str
        A name of `READINGS`.

    Returns
    -------
    charts : int
        The number, the last one considered excepted; 0 if there is no other.
    share : float
        On what share of the parts it was picked; never NaN, there is a part at least.

    Examples
    --------
    >>> reading = {"curve": [3, 2, 1], "resampled": {"2": 2, "3": 4}}
    >>> most_picked({"readings": {"eigengap": reading}}, "eigengap")
    (2, 0.3333333333333333)
    """
    reading = measured["readings"][name]
    times = {int(count): number for count, number in reading["resampled"].items()}
    inside = {k: v for k, v in times.items() if k < len(reading["curve"])} or {0: 0}
    best = max(inside, key=lambda count: inside[count])
    return best, inside[best] / sum(times.values())


def _count(resampled: list[dict[str, Any]], name: str) -> dict[str, int]:
    """Count how often each number was picked, the smallest number first."""
    picked = Counter(readings[name]["picked"] for readings in resampled)
    return {str(count): picked[count] for count in sorted(picked)}
