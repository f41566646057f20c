"""Regression by what lies near: scikit-learn's neighbours, and locally weighted."""

from __future__ import annotations

from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from scipy.special import softmax
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.neighbors import KNeighborsRegressor
from sklearn.utils._param_validation import Interval
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points

Array = NDArray[np.float64]

_POSITIVE = Interval(Real, 0, None, closed="neither")


class FewNeighbours(KNeighborsRegressor):  # type: ignore[misc]
    """scikit-learn's neighbours, clipped to as many as there are."""

    def kneighbors(
        self,
        X: Any = None,
        n_neighbors: int | None = None,
        return_distance: bool = True,
    ) -> Any:
        """Find neighbours; of all tasks, if there are fewer than asked for."""
        check_is_fitted(self)
        most = self.n_samples_fit_ - (X is None)
        wanted = min(n_neighbors or self.n_neighbors, most)
        return super().kneighbors(X, wanted, return_distance)


class LocalLinear(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Fit a line or plane to each task's neighbourhood.

    Parameters
    ----------
    width : float, default=0.3
        Width, > 0, of the Gaussian by which training tasks count, in their unit (rad).
    ridge : float, default=1e-6
        Penalty, > 0, of slopes, relative to the weights' sum.

    Attributes
    ----------
    X_fit_, y_fit_ : ndarray
        The training set.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    Locally weighted regression [1]_: for each new task x the least of
    ``sum_i k_i |y_i - a - b'(x_i - x)|^2 + ridge |b|^2``, where the k are shares of a
    Gaussian about x and sum to one; a is predicted. It assumes that policies are smooth
    over about a width.

    References
    ----------
    .. [1] C. G. Atkeson, A. W. Moore and S. Schaal, "Locally weighted learning",
       Artificial Intelligence Review 11, 1997.

    Examples
    --------
    >>> from msc.study.rivals._local import LocalLinear
    >>> model = LocalLinear().fit([[0.0], [1.0], [2.0]], [[0.0], [2.0], [4.0]])
    >>> model.predict([[0.6], [1.7]]).round(3)
    array([[1.2],
           [3.4]])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "width": [_POSITIVE],
        "ridge": [_POSITIVE],
    }

    def __init__(self, width: float = 0.3, ridge: float = 1e-6) -> None:
        self.width = width
        self.ridge = ridge

    def fit(self, X: Any, y: Any) -> Self:
        """Keep the training set."""
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        self.X_fit_, self.y_fit_ = X.copy(), y.copy()
        return self

    def predict(self, X: Any) -> Array:
        """Predict the policies of tasks, in the shape that `fit` was given."""
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        near = cdist(X, self.X_fit_, "sqeuclidean") / (2 * self.width**2)
        shares = softmax(-near, axis=1)
        away = self.X_fit_ - X[:, None]  # (n_tasks, n_training, n_task_params)
        lines = np.concatenate([np.ones((*away.shape[:2], 1)), away], axis=2)
        weighted = lines.transpose(0, 2, 1) * shares[:, None]
        penalty = self.ridge * np.diag(np.r_[0.0, np.ones(X.shape[1])])
        targets = self.y_fit_.reshape(len(self.y_fit_), -1)
        found = np.linalg.solve(weighted @ lines + penalty, weighted @ targets)[:, 0]
        return np.asarray(found.reshape(len(X), *self.y_fit_.shape[1:]))
