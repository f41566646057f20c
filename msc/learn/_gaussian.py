"""Gaussian processes as the learners use them: kernels, bounds, and their search."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial import KDTree
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessClassifier, GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    RBF,
    ConstantKernel,
    ExpSineSquared,
    Kernel,
    Matern,
    WhiteKernel,
)

Array = NDArray[np.float64]
Optimum = tuple[Array, float]

LENGTH_SCALE_BOUNDS = (1e-2, 1e2)  # rad; bounds of the length scale
LENGTH_SCALES = (0.2, 0.7, 2.5)  # rad; starts of the likelihood's search
_NOISES = (1e-6, 1e-3, 1e-1)  # of the policies' variance; likewise


def gaussian_process(kernel: str = "squared exponential") -> GaussianProcessRegressor:
    """Build the regression each chart and policy dimension gets by default.

    Parameters
    ----------
    kernel : {"squared exponential", "matern", "periodic"}
        How alike two tasks' policies are, with their distance d and a length scale l:
        exp(-d²/2l²), infinitely smooth; the Matérn kernel of order 3/2,
        (1 + √3 d/l) exp(-√3 d/l), smooth once; or exp(-2 sin²(d/2)/l²), whose period
        of 2π closes the circle of a single task angle.

    Returns
    -------
    GaussianProcessRegressor
        Unfitted; the kernel plus white noise on standardised targets.

    Raises
    ------
    ValueError
        If the kernel is another.

    Notes
    -----
    Bounds, for tasks in radians and targets of unit variance:

    - length scale 0.01 to 100: from half a degree, finer than any grid worth
      searching, to sixteen turns, over which everything is a straight line;
    - amplitude (a variance) 1e-3 to 1e3: a long length scale needs a large one to show
      any slope;
    - noise 1e-8 to 1: from a policy search's own precision to nothing but noise.

    Hyper-parameters maximise the marginal likelihood, by L-BFGS-B from three fixed
    starts: length scales 0.2, 0.7 and 2.5, each with the likeliest noise of 1e-6, 1e-3
    and 0.1. On targets with jumps two random restarts often end in a worse optimum,
    these seldom; and nothing is random. Each kernel falls off over about one length
    scale, so that bounds and starts serve all three alike.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.learn import gaussian_process
    >>> tasks = np.linspace(0, 6, 30)[:, np.newaxis]
    >>> model = gaussian_process().fit(tasks, np.sin(tasks[:, 0]))
    >>> bool(abs(model.predict([[1.5]]) - np.sin(1.5)) < 1e-3)
    True
    """
    if kernel not in _KERNELS:
        raise ValueError(f"kernel={kernel!r}; wanted one of {tuple(_KERNELS)}")
    amplitude = ConstantKernel(1.0, (1e-3, 1e3))
    return _BoundedRegressor(
        amplitude * _KERNELS[kernel]() + WhiteKernel(1e-3, (1e-8, 1.0)),
        normalize_y=True,
        optimizer=_refine_starts,
    )


def gaussian_classifier() -> GaussianProcessClassifier:
    """Build the gate called "gp": squared exponential, bounds as for the regression."""
    return _BoundedClassifier(
        ConstantKernel(1.0, (1e-3, 1e3)) * RBF(1.0, LENGTH_SCALE_BOUNDS),
        optimizer=_refine,
    )


def is_tuned(regressor: Any) -> bool:
    """Tell whether a regression seeks its length scale within our bounds."""
    return regressor is None or isinstance(regressor, _BoundedRegressor)


def warn_of_scale(tasks: Array) -> None:
    """Warn of tasks at a scale on which no length scale would be found.

    Notes
    -----
    Tasks are counted once, however often they are given; tasks nearer than a tenth of
    the distance to the 16th nearest count as copies, and so does a group of any size
    within a fifth of the distance to the next. A column's neighbours are those among
    all columns scaled to the same span, twice as many as columns, as on a grid.
    On functions that change over a quarter of either column, of one that spans 6.3 and
    one whose neighbours lie 7.5 apart, 0.3 to 0.7 of the standard deviation was missed
    (16 to 64 tasks, on grids and at random), against 0.14 or less at best.

    Examples
    --------
    >>> warn_of_scale(np.linspace(0, 6.28, 24)[:, None])
    """
    spans = np.ptp(tasks, axis=0)
    varies = spans > 1e-9 * np.abs(tasks).max(axis=0)  # more than rounding
    distinct = _distinct(tasks[:, varies] / spans[varies])
    if len(distinct) < 3:
        return
    (columns,), spans = np.nonzero(varies), spans[varies]
    gap, steps = _nearest(distinct * spans), _steps(distinct) * spans
    is_other = (spans > 3 * spans.min()) & (steps > spans.min())
    has_neighbours = len(distinct) > 2 * len(spans)  # on all sides
    is_wide = (steps > 3 * LENGTH_SCALES[-1]) & is_other & has_neighbours
    if gap > 4 * LENGTH_SCALES[-1]:
        is_wide |= (steps > 4 * LENGTH_SCALES[-1]) | (spans == spans.max())
    widest = spans[~is_wide].max(initial=0.0)
    is_narrow = ~is_wide & ((spans < LENGTH_SCALE_BOUNDS[0]) | (spans < widest / 100))
    found = [
        f"span {spans[k]:.3g} and lie {steps[k]:.3g} apart in column {columns[k]} "
        f"(divide it by {spans[k] / 6:.2g}, say)"
        for k in np.flatnonzero(is_wide | is_narrow)
    ]
    if found:
        least, most = LENGTH_SCALE_BOUNDS
        warnings.warn(
            f"tasks {'; '.join(found)}, but kernels are tuned to length scales from "
            f"{least:g} to {most:g}, one for all columns: bring tasks to a scale on "
            "which policies change over about one unit in each column",
            UserWarning,
            stacklevel=3,
        )


def _distinct(points: Array) -> Array:
    """Return points, those left out that are copies of others, or nearly so."""
    if points.shape[1] == 0:
        return points[:1]
    points = np.unique(points, axis=0)
    distinct = thinned = _thin(points, 0.0, 0.1)
    radius = 1e-9
    while radius < 0.5:  # of many copies some stay
        radius *= 2
        thinner = _thin(thinned, radius)
        if len(thinner) < len(thinned):
            thinned = thinner
            off = np.quantile(KDTree(thinned).query(points)[0], 0.9)
            if len(thinned) > 2 and off < 0.2 * _nearest(thinned):
                distinct = _thin(thinned, 0.0, 0.1)
    return distinct


def _thin(points: Array, radius: float, share: float = 0.0) -> Array:
    """Drop points nearer to earlier ones than a radius, or a share of the 16th's."""
    n_points = len(points)
    distances, nearest = KDTree(points).query(points, k=range(1, min(17, n_points) + 1))
    is_copy = distances < np.maximum(radius, share * distances[:, -1:])
    is_later = nearest < np.arange(n_points)[:, None]
    return np.asarray(points[~(is_copy & is_later).any(axis=1)])


def _nearest(points: Array) -> float:
    """Return the median distance of a point to the nearest other one."""
    return float(np.median(KDTree(points).query(points, k=2)[0][:, 1]))


def _steps(points: Array) -> Array:
    """Return how far neighbours lie apart in each column, on a grid: its spacing."""
    n_points, n_columns = points.shape
    n_nearest = min(2 * n_columns + 1, n_points)
    nearest = KDTree(points).query(points, k=n_nearest)[1][:, 1:]
    apart = np.abs(points[nearest] - points[:, None]).mean(axis=1)
    return np.asarray(np.minimum(n_columns * np.median(apart, axis=0), 1.0))


_KERNELS: dict[str, Callable[[], Kernel]] = {
    "squared exponential": lambda: RBF(1.0, LENGTH_SCALE_BOUNDS),
    "matern": lambda: Matern(1.0, LENGTH_SCALE_BOUNDS, nu=1.5),
    "periodic": lambda: ExpSineSquared(
        1.0,
        2 * np.pi,
        length_scale_bounds=LENGTH_SCALE_BOUNDS,
        periodicity_bounds="fixed",
    ),
}


class _AtBounds:
    """Let hyper-parameters rest on their bounds without a warning: they are answers."""

    # Data without noise push the noise to its floor, a constant policy the amplitude,
    # a straight chart the length scale to its ceiling.

    def fit(self, X: Any, y: Any) -> Self:
        with warnings.catch_warnings():
            message = ".*is close to the specified"
            warnings.filterwarnings("ignore", message, ConvergenceWarning)
            super().fit(X, y)  # type: ignore[misc]
        return self


class _BoundedRegressor(_AtBounds, GaussianProcessRegressor):  # type: ignore[misc]
    pass


class _BoundedClassifier(_AtBounds, GaussianProcessClassifier):  # type: ignore[misc]
    pass


def _refine_starts(
    objective: Callable[..., Any],
    initial: Array,
    bounds: Array,
) -> Optimum:
    """Minimise from each length scale, at the noise that suits it; return the best."""
    if len(initial) != 3:  # another kernel, which starts from its own values
        return _refine(objective, initial, bounds)
    starts = [
        min(
            (np.log([1.0, length_scale, noise]) for noise in _NOISES),
            key=lambda start: objective(start, eval_gradient=False),
        )
        for length_scale in LENGTH_SCALES
    ]
    found = [_refine(objective, start, bounds) for start in starts]
    return min(found, key=lambda optimum: optimum[1])


def _refine(objective: Callable[..., Any], initial: Array, bounds: Array) -> Optimum:
    found = minimize(objective, initial, jac=True, bounds=bounds, method="L-BFGS-B")
    return found.x, found.fun
