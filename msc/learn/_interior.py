"""Many small programs at once, by an interior point method over arrays.

A solver that is called for each program spends most of its time on being called. Here
one step is a handful of array operations for all programs that are not finished yet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_GAP = 1e-11  # between a program's value and its bound, relative to the value
_STEPS = 40  # far more than the usual ten
_FLOOR = 1e-15  # of the matrices' size: keeps them invertible


def solve_qps(columns: Array, penalty: Array) -> Array:
    """Minimise penalty @ |c| + |columns @ c|^2 / 2 with sum(c) = 1, many times.

    Parameters
    ----------
    columns : ndarray of shape (n_programs, n_rows, n_columns)
        One matrix a program, with values of about one.
    penalty : ndarray of shape (n_programs, n_columns)
        Positive weights, of about one too.

    Returns
    -------
    ndarray of shape (n_programs, n_columns)
        The minimisers, exact zeros included; NaN in the row of a program that no value
        within 1e-11 of its lower bound was found for.

    Notes
    -----
    The positive and negative parts x of c are kept positive, as are their slopes s,
    which vanish where the other does not [1]_. Mehrotra's predictor tells how far to
    aim for x * s = 0, a corrector makes up for its curvature. The sum of x * s is the
    distance to the dual program's value, a lower bound.

    References
    ----------
    .. [1] J. Nocedal and S. Wright, "Numerical Optimization", 2nd edition, 2006,
       algorithm 16.4.

    Examples
    --------
    The middle of two points is their mean.

    >>> solve_qps(np.array([[[1.0, -1.0]]]), np.array([[0.5, 0.5]])).round(9)
    array([[0.5, 0.5]])
    """
    n_programs, n_columns = penalty.shape
    found = np.full(penalty.shape, np.nan)
    left = np.arange(n_programs)
    gram = columns.transpose(0, 2, 1) @ columns
    floor = _FLOOR * (1 + np.trace(gram, axis1=1, axis2=2)[:, None])
    x = np.full((n_programs, 2 * n_columns), 0.1)
    x[:, :n_columns] += 1 / n_columns
    s, multiplier = np.ones(x.shape), np.zeros((n_programs, 1))
    with np.errstate(all="ignore"):  # what overflows is not finished
        for _ in range(_STEPS):
            c = x[:, :n_columns] - x[:, n_columns:]
            slope = np.einsum("ijk,ik->ij", gram, c)
            dual_residual = (
                np.hstack([penalty + slope - multiplier, penalty - slope + multiplier])
                - s
            )
            primal_residual = 1 - c.sum(axis=1, keepdims=True)
            gap = _dot(x, s)
            value = _dot(penalty, abs(c)) + _dot(c, slope) / 2
            off = gap + _dot(x, abs(dual_residual)) + abs(multiplier * primal_residual)
            done = (off <= _GAP * value)[:, 0]
            kept = np.where(x > s, x, 0.0)[done]
            found[left[done]] = kept[:, :n_columns] - kept[:, n_columns:]
            go = ~done & np.isfinite(off[:, 0])
            if not go.any():
                break
            if not go.all():
                left, gram, penalty, floor = (
                    each[go] for each in (left, gram, penalty, floor)
                )
                x, s, multiplier, dual_residual, primal_residual, gap = (
                    each[go]
                    for each in (x, s, multiplier, dual_residual, primal_residual, gap)
                )
            newton = _Newton.at(x, s, dual_residual, primal_residual, gram, floor)
            ahead_x, ahead_s, _ = newton.step(-x * s)
            ahead = _dot(
                x + _longest(x, ahead_x) * ahead_x, s + _longest(s, ahead_s) * ahead_s
            )
            aim = (ahead / gap) ** 3 * gap / x.shape[1]
            step_x, step_s, step_multiplier = newton.step(
                aim - x * s - ahead_x * ahead_s
            )
            length = 0.995 * np.minimum(_longest(x, step_x), _longest(s, step_s))
            x, s = x + length * step_x, s + length * step_s
            multiplier = multiplier + length * step_multiplier
    return found


class _Newton(NamedTuple):
    """Newton's equations, with everything but c and multiplier eliminated."""

    x: Array
    s: Array
    dual_residual: Array
    primal_residual: Array
    ratio: Array
    both: Array
    inverse: Array

    @classmethod
    def at(
        cls,
        x: Array,
        s: Array,
        dual_residual: Array,
        primal_residual: Array,
        *matrices: Array,
    ) -> _Newton:
        """Invert the equations' matrices, given those of the programs and a floor."""
        gram, floor = matrices
        n_columns = gram.shape[1]
        ratio = x / s
        both = ratio[:, :n_columns] + ratio[:, n_columns:]
        diagonal = np.arange(n_columns)
        matrix = gram.copy()
        matrix[:, diagonal, diagonal] += 1 / both + floor
        inverse = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
        return cls(x, s, dual_residual, primal_residual, ratio, both, inverse)

    def step(self, target: Array) -> tuple[Array, Array, Array]:
        """Return the step of x, s and multiplier by which x * s grows by the target."""
        n_columns = self.both.shape[1]
        push = target / self.x - self.dual_residual
        pushed = self.ratio * push
        free = pushed[:, :n_columns] - pushed[:, n_columns:]
        bare = np.einsum("ijk,ik->ij", self.inverse, free / self.both)
        by_multiplier = self.inverse.sum(axis=2)
        missing = self.primal_residual - bare.sum(axis=1, keepdims=True)
        multiplier = missing / by_multiplier.sum(axis=1, keepdims=True)
        rise = (free - bare - by_multiplier * multiplier) / self.both
        step_x = self.ratio * (push - np.hstack([rise, -rise]))
        return step_x, (target - self.s * step_x) / self.x, multiplier


def _longest(values: Array, step: Array) -> Array:
    """Return how much of a step, at most all of it, leaves the values positive."""
    reach = np.where(step < 0, -values / step, np.inf).min(axis=1, keepdims=True)
    return np.asarray(np.minimum(reach, 1.0))


def _dot(one: Array, other: Array) -> Array:
    """Multiply row by row, as a column."""
    return np.asarray(np.einsum("ij,ij->i", one, other)[:, None])
