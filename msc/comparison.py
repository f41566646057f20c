"""Whether one method's errors are lower than another's, with an interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import bootstrap


@dataclass(frozen=True)
class Comparison:
    """The mean of one method's errors over that of another's, on the same tasks.

    The interval is a paired bootstrap over the test tasks, at 95 %. It covers which
    tasks are tested, not which were trained on, nor another world.
    """

    measure: str
    method: str
    baseline: str
    ratio: float
    low: float
    high: float

    @property
    def verdict(self) -> str:
        """Whether the interval lies below one, above one or includes it."""
        if self.high < 1:
            return "lower"
        return "higher" if self.low > 1 else "undecided"

    def __str__(self) -> str:
        """Say it in a sentence."""
        return (
            f"{self.measure}: {self.ratio:.2f} × {self.baseline} "
            f"[{self.low:.2f}, {self.high:.2f}]: {self.verdict}"
        )

    __repr__ = __str__


def compare(
    measure: str,
    errors: pd.DataFrame,
    method: str,
    baseline: str,
    *,
    n_resamples: int = 1_000,
    seed: int = 0,
) -> Comparison:
    """Compare the mean errors of two methods.

    Parameters
    ----------
    measure : str
        What the errors are, for the sentence.
    errors : DataFrame
        One column a method, one row a test task.
    method, baseline : str
        The columns whose means are divided, the first by the second.
    n_resamples : int, default=1000
        Bootstrap resamples.
    seed : int, default=0
        Seed of the resampling.

    Returns
    -------
    Comparison
        The ratio and its interval.

    Examples
    --------
    >>> errors = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [2.0, 4.0, 6.0]})
    >>> compare("error", errors, "a", "b").ratio
    0.5
    """
    pairs = errors[[method, baseline]].to_numpy().T

    def ratio(top: Any, bottom: Any, axis: int) -> Any:
        return top.mean(axis=axis) / bottom.mean(axis=axis)

    interval = bootstrap(
        tuple(pairs),
        ratio,
        paired=True,
        n_resamples=n_resamples,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    value = float(np.mean(pairs[0]) / np.mean(pairs[1]))
    return Comparison(
        measure, method, baseline, value, float(interval.low), float(interval.high)
    )
