"""Which training set a figure draws: not a lucky one, by a rule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.data import load_dataset
from msc.study._sampling import draw_samples, take_evenly
from msc.study._summaries import find_cell


def pick_typical_set(
    study: Mapping[str, Any],
    n_samples: int,
    measure: str,
    *,
    method: str = "charts",
    baseline: str = "single regression",
) -> NDArray[np.intp]:
    """Pick the evenly spaced training set on which two methods compare as usual.

    On each set of this size that the study kept one mean error is divided by the other;
    the set is the one whose ratio is the median. Of two in the middle it is the lower.
    (By the median error of *one* method the set could be the other's luckiest.)

    Parameters
    ----------
    study : mapping
        Results of a study.
    n_samples : int
        Training tasks.
    measure : str
        A key of `MEASURES`.
    method, baseline : str, default="charts", "single regression"
        The two; their errors on a set are divided.

    Returns
    -------
    ndarray of shape (n_samples,)
        Indices of the tasks, ascending: of the set that begins at 0°, if the study kept
        none of this size.

    Examples
    --------
    >>> from msc.data import load_results
    >>> (study,) = load_results("study_obstacles")
    >>> pick_typical_set(study, 24, "error_cm")[:3]
    array([ 6, 21, 36])
    """
    tasks = load_dataset(study["workspace"])[0]
    try:
        cell = find_cell(study, "even", n_samples)
    except StopIteration:
        return take_evenly(tasks, n_samples)
    means = cell["measures"][measure]
    ours, theirs = (np.array(means[n]["per_repetition"]) for n in (method, baseline))
    middle = np.argsort(ours / theirs, kind="stable")[(len(ours) - 1) // 2]
    drawn: Any = {"n_draws": cell["repetitions"], "seed": study["seed"]}
    return draw_samples("even", tasks, n_samples, **drawn)[int(middle)]
