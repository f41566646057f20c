"""Gaussian processes as the learners use them: kernels, bounds, and their search."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
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

from msc._checks import LENGTH_SCALE_BOUNDS, LENGTH_SCALES

Array = NDArray[np.float64]
Optimum = tuple[Array, float]

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
