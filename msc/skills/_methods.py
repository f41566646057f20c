"""What learns from a table, the simplest first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from sklearn.dummy import DummyRegressor
from sklearn.ensemble import HistGradientBoostingRegressor, RandomForestRegressor
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neighbors import KNeighborsRegressor

MOST_NUMBERS = 4
"""Of a task that is interpolated: beyond, triangles take hours."""

_ROWS_A_TREE = 10_000  # that a tree of the forest draws, at most


@dataclass(frozen=True)
class Learner:
    """A method of the comparison.

    Attributes
    ----------
    build : callable
        Takes the number of rows and a seed; gives an unfitted estimator.
    takes_all : bool, default=False
        Whether it is given all rows, however many.
    is_flat : bool, default=False
        Whether it is given circles unrolled.
    wants_cost : bool, default=False
        Whether it is given costs, and tried only where there are some.
    takes_weights : bool, default=False
        Whether tasks may count more or less.
    has_std : bool, default=False
        Whether it knows how sure it is of a policy, in the policy's unit.
    """

    build: Callable[[int, int], Any]
    takes_all: bool = False
    is_flat: bool = False
    wants_cost: bool = False
    takes_weights: bool = False
    has_std: bool = False


def _compared(name: str) -> Learner:
    """Take a method of `msc.study`, charts by the elbow."""
    return Learner(lambda _, seed: _build(name, seed), has_std=True)


def _build(name: str, seed: int) -> Any:
    # The study loads robots, which takes seconds: who only predicts does without.
    from msc.study import build_method  # noqa: PLC0415

    return build_method(name, n_charts=None, seed=seed)


def _forest(n_rows: int, seed: int) -> RandomForestRegressor:
    """Have each tree draw some of many rows; all of them draw all."""
    most = _ROWS_A_TREE if n_rows > _ROWS_A_TREE else None
    return RandomForestRegressor(50, max_samples=most, random_state=seed)


METHODS = {
    "mean policy": Learner(
        lambda *_: DummyRegressor(), takes_all=True, takes_weights=True
    ),
    "nearest neighbour": Learner(lambda *_: KNeighborsRegressor(1), takes_all=True),
    "four neighbours": Learner(
        lambda n_rows, _: KNeighborsRegressor(min(4, n_rows), weights="distance"),
        takes_all=True,
    ),
    "linear interpolation": Learner(
        lambda _, seed: _build("linear interpolation", seed), is_flat=True
    ),
    "single, one kernel": _compared("single, one kernel"),
    "single regression": _compared("single regression"),
    "CrKr": Learner(
        lambda _, seed: _build("CrKr", seed), wants_cost=True, takes_weights=True
    ),
    "charts, one kernel": _compared("charts, one kernel"),
    "charts": _compared("charts"),
    "charts, k-means": _compared("charts, k-means"),
    "random forest": Learner(_forest, takes_all=True, takes_weights=True),
    "boosted trees": Learner(
        lambda _, seed: MultiOutputRegressor(
            HistGradientBoostingRegressor(random_state=seed)
        ),
        takes_all=True,
        takes_weights=True,
    ),
}
"""All that are compared, by name; of those as good as each other the first is chosen.

In order: what does not look at the task, what looks tasks up, what draws lines between
them; one smooth function, with one length scale, then one a policy column; several, on
charts, with a gate beside them; hundreds of trees.
"""

PAPER = "charts"
"""The paper's own."""
