"""Columns of any units -> points on which learners see each column alike."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator

Array = NDArray[np.float64]

DECIMALS = 9
"""Of what learners see: how units round stays hidden from trees, which break ties."""

_CONSTANT = 1e-12  # of the largest magnitude: a spread that rounding makes
_GAP = 0.25  # of a period: a wider gap between tasks is outside of their range


class TaskScale(BaseEstimator):  # type: ignore[misc]
    """Bring task columns to unit spread, periodic ones onto circles.

    Parameters
    ----------
    periods : tuple of float or None
        Of each column, after which it comes round again; None: never.

    Attributes
    ----------
    centers_, spreads_ : ndarray of shape (n_columns,)
        What is subtracted, and what it is divided by; see Notes.
    lows_, highs_ : ndarray of shape (n_columns,)
        Between which the tasks lie; of a periodic column an arc, which may end beyond a
        period.

    Notes
    -----
    The spread of a column is its standard deviation. That of one on a circle would
    depend on where the circle is cut; there it is the angular deviation
    sqrt(2 (1 - R)), with R the length of the mean of (cos, sin), which is nearly the
    same for tasks that lie close together. Along the circle, too, a length of one is
    one spread.
    """

    def __init__(self, periods: tuple[float | None, ...]) -> None:
        self.periods = periods

    def fit(self, X: Array) -> TaskScale:
        """Measure the columns."""
        n_columns = X.shape[1]
        self.centers_, self.spreads_ = np.zeros(n_columns), np.ones(n_columns)
        self.lows_, self.highs_ = X.min(axis=0), X.max(axis=0)
        for k, (period, column) in enumerate(zip(self.periods, X.T, strict=True)):
            if period is None:
                self.centers_[k], spread = column.mean(), column.std()
            else:
                turns = 2 * np.pi * column / period
                length = np.hypot(np.cos(turns).mean(), np.sin(turns).mean())
                spread = np.sqrt(2 * max(1 - length, 0.0)) * period / (2 * np.pi)
                self.lows_[k], self.highs_[k] = _arc(column, period)
            if spread > _CONSTANT * max(np.abs(column).max(), period or 0.0):
                self.spreads_[k] = spread
        return self

    def transform(self, X: Array) -> Array:
        """Return points whose distances count: two columns for a periodic one."""
        columns = []
        for k, period in enumerate(self.periods):
            if period is None:
                columns.append((X[:, k] - self.centers_[k]) / self.spreads_[k])
                continue
            turns = 2 * np.pi * X[:, k] / period
            radius = period / (2 * np.pi * self.spreads_[k])
            columns += [radius * np.cos(turns), radius * np.sin(turns)]
        return np.column_stack(columns).round(DECIMALS)

    def flatten(self, X: Array) -> Array:
        """Return a column each, circles cut at zero and unrolled."""
        columns = [
            (X[:, k] - self.centers_[k]) / self.spreads_[k]
            if period is None
            else np.mod(X[:, k], period) / self.spreads_[k]
            for k, period in enumerate(self.periods)
        ]
        return np.column_stack(columns).round(DECIMALS)

    def unroll(self, X: Array) -> tuple[Array, NDArray[np.intp]]:
        """Return flat tasks and, beside each circle's ends, copies; and whose each is.

        A task has neighbours on both sides then, wherever the circle was cut.
        """
        flat, rows = self.flatten(X), np.arange(len(X))
        for k, period in enumerate(self.periods):
            if period is None:
                continue
            length = period / self.spreads_[k]
            copies = flat.copy()
            copies[:, k] += np.where(copies[:, k] < length / 2, length, -length)
            flat, rows = np.concatenate([flat, copies]), np.concatenate([rows, rows])
        return flat, rows

    def find_outside(self, X: Array) -> NDArray[np.bool_]:
        """Tell which numbers of which tasks lie outside the range: as X is shaped."""
        outside = np.empty(X.shape, dtype=bool)
        for k, period in enumerate(self.periods):
            low, high, column = self.lows_[k], self.highs_[k], X[:, k]
            if period is None:
                slack = 1e-9 * max(abs(low), abs(high))
            else:
                slack = 1e-9 * period
                column = low + np.mod(column - low + slack, period) - slack
            outside[:, k] = (column < low - slack) | (column > high + slack)
        return outside


def _arc(column: Array, period: float) -> tuple[float, float]:
    """Return the ends of the arc on which tasks lie: all round, but for a wide gap."""
    places = np.unique(np.mod(column, period))
    ends = [*places, places[0] + period]
    gaps = [after - before for before, after in pairwise(ends)]
    k = int(np.argmax(gaps))
    if gaps[k] <= _GAP * period:
        return 0.0, float(period)
    low = ends[k + 1] % period
    return float(low), float(low + period - gaps[k])
