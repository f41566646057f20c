"""Interpolation between training tasks, by NumPy and SciPy."""

from __future__ import annotations

from contextlib import suppress
from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator, RBFInterpolator
from scipy.spatial import QhullError
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils._param_validation import Interval, StrOptions
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points

Array = NDArray[np.float64]

_MOST = 4  # parameters: beyond them, triangles take hours
_POSITIVE = Interval(Real, 0, None, closed="neither")
_KERNELS = {"linear", "thin_plate_spline", "cubic", "gaussian", "multiquadric"}


class Interpolation(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Interpolate linearly between training tasks, of any number of parameters.

    Parameters
    ----------
    period : float or None, default=None
        Of the one task parameter, after which it comes round again. None: never.

    Attributes
    ----------
    tasks_, policies_ : ndarray
        Different training tasks, and the mean policy of each.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    One parameter: NumPy's `interp`; beyond the ends theirs hold. Several: SciPy's
    `LinearNDInterpolator` on Delaunay's triangles, and beyond them, or where tasks span
    no area, the nearest task's policy.

    Examples
    --------
    >>> from msc.study.rivals._interpolation import Interpolation
    >>> X, y = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [0.0, 4.0, 8.0]
    >>> Interpolation().fit(X, y).predict([[0.25, 0.25], [0.1, 5.0]])
    array([3., 8.])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "period": [_POSITIVE, None],
    }

    def __init__(self, period: float | None = None) -> None:
        self.period = period

    def fit(self, X: Any, y: Any) -> Self:
        """Keep the training set.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.

        Returns
        -------
        Interpolation
            Fitted.

        Raises
        ------
        ValueError
            If there are more parameters than four, or than one with a period.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        if self.period is not None and X.shape[1] > 1:
            raise ValueError(f"period={self.period}, but X has {X.shape[1]} features")
        if X.shape[1] > _MOST:
            raise ValueError(f"X has {X.shape[1]} features; wanted at most {_MOST}")
        self.tasks_, self.policies_ = average_copies(X, y)
        self._triangles = None
        if X.shape[1] > 1:
            with suppress(QhullError):  # too few tasks, or on one line
                self._triangles = LinearNDInterpolator(self.tasks_, self.policies_)
        return self

    def predict(self, X: Any) -> Array:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params) or (n_tasks,)
            Policies, in the shape that `fit` was given.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        if X.shape[1] == 1:
            columns = self.policies_.reshape(len(self.tasks_), -1).T
            place = X[:, 0], self.tasks_[:, 0]
            rows = [np.interp(*place, one, period=self.period) for one in columns]
            shape = len(X), *self.policies_.shape[1:]
            return np.asarray(np.stack(rows, axis=-1).reshape(shape))
        nearest = self.policies_[cdist(X, self.tasks_).argmin(axis=1)]
        inside = np.nan if self._triangles is None else self._triangles(X)
        return np.asarray(np.where(np.isnan(inside), nearest, inside))


class RadialBasis(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Interpolate by radial basis functions: SciPy's `RBFInterpolator`.

    Parameters
    ----------
    kernel : str, default="thin_plate_spline"
        "linear", "thin_plate_spline", "cubic", "gaussian" or "multiquadric".
    epsilon : float, default=1.0
        Shape, > 0, of the last two (1 / rad).
    smoothing : float, default=0.0
        0 goes through all policies; more, less closely.

    Attributes
    ----------
    interpolator_ : RBFInterpolator
        Of the different training tasks, and the mean policy of each.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    With no more tasks than parameters the kernel is linear: others add a plane, for
    which they are too few.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals._interpolation import RadialBasis
    >>> X = np.linspace(0, 6, 20)[:, np.newaxis]
    >>> bool(abs(RadialBasis().fit(X, np.sin(X)).predict([[2.0]]) - np.sin(2)) < 0.01)
    True
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "kernel": [StrOptions(_KERNELS)],
        "epsilon": [_POSITIVE],
        "smoothing": [Interval(Real, 0, None, closed="left")],
    }

    def __init__(
        self,
        kernel: str = "thin_plate_spline",
        epsilon: float = 1.0,
        smoothing: float = 0.0,
    ) -> None:
        self.kernel = kernel
        self.epsilon = epsilon
        self.smoothing = smoothing

    def fit(self, X: Any, y: Any) -> Self:
        """Interpolate the training set."""
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        tasks, policies = average_copies(X, y)
        kernel = self.kernel if len(tasks) > X.shape[1] else "linear"
        self.interpolator_ = RBFInterpolator(
            tasks,
            policies,
            kernel=kernel,
            epsilon=self.epsilon,
            smoothing=self.smoothing,
        )
        return self

    def predict(self, X: Any) -> Array:
        """Predict the policies of tasks, in the shape that `fit` was given."""
        check_is_fitted(self)
        return np.asarray(self.interpolator_(validate_points(self, X, reset=False)))


def average_copies(X: Array, y: Array) -> tuple[Array, Array]:
    """Return the different tasks, ascending, and the mean policy of each."""
    tasks, place = np.unique(X, axis=0, return_inverse=True)
    sums = np.zeros((len(tasks), *y.shape[1:]))
    np.add.at(sums, place.ravel(), y)
    times = np.bincount(place.ravel()).reshape(-1, *(1,) * (y.ndim - 1))
    return tasks, sums / times
