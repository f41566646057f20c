"""One parameter swept, and what came of it inverted."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.isotonic import IsotonicRegression
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points

Array = NDArray[np.float64]


class InvertedSweep(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Vary one parameter of one movement, and invert which task it solves.

    After Hausknecht and Stone: a sweep of what is stored, not of the robot.

    Attributes
    ----------
    base_ : ndarray of shape (n_params,)
        The movement that is varied: the mean of the training policies.
    direction_ : ndarray of shape (n_params,)
        What of it is varied: a unit vector, or zero if policies tell nothing of tasks.
    outcomes_, settings_ : ndarray of shape (n_settings,)
        Tasks, ascending, and the setting of the parameter that solves each.
    n_features_in_ : int
        Number of task parameters: one.

    Notes
    -----
    In [1]_ a kick is optimised first; then one number of it is chosen by hand, its
    values are tried, and the model of what came of each is inverted, so that a wanted
    distance gives the value. Here a policy is ``base + setting * direction``::

        direction ~ sum_i (task_i - mean task) (policy_i - mean policy)
        setting_i = direction' (policy_i - base)

    and the model says which task a setting solves: the monotone function of least
    squares through the stored pairs, which can be inverted; where it is flat, the mean
    setting counts. Beyond the sweep its ends hold. It assumes that the outcome is one
    number, that one parameter governs it, and that more of the one is more of the
    other.

    Adapted: the parameter is no hand's choice but the direction in which policies
    covary with the task, the first of partial least squares, and the base is their
    mean. Left out: values tried on the robot; those of the searched policies stand in,
    whatever else about them differs.

    References
    ----------
    .. [1] M. Hausknecht and P. Stone, "Learning powerful kicks on the Aibo ERS-7: the
       quest for a striker", RoboCup 2010: Robot Soccer World Cup XIV, 2011.

    Examples
    --------
    >>> from msc.study.rivals import InvertedSweep
    >>> X, y = [[0.0], [1.0], [2.0]], [[0.0, 1.0], [3.0, 1.0], [4.0, 1.0]]
    >>> InvertedSweep().fit(X, y).predict([[0.5], [9.0]])
    array([[1.5, 1. ],
           [4. , 1. ]])
    """

    def fit(self, X: Any, y: Any) -> Self:
        """Find the parameter, and what its settings do.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.

        Returns
        -------
        InvertedSweep
            The fitted model.

        Raises
        ------
        ValueError
            If a task has several parameters.
        """
        X, y = validate_pairs(self, X, y)
        if X.shape[1] > 1:
            raise ValueError(f"X has {X.shape[1]} features; wanted one outcome")
        self._is_single_output, y = y.ndim == 1, y.reshape(len(X), -1)
        self.base_ = y.mean(axis=0)
        way = (X[:, 0] - X.mean()) @ (y - self.base_)
        length = np.linalg.norm(way)
        self.direction_ = way / length if length else way
        swept = (y - self.base_) @ self.direction_
        # Settings and tasks covary positively: the direction is chosen so.
        tasks = IsotonicRegression().fit_transform(swept, X[:, 0])
        self.outcomes_, place = np.unique(tasks, return_inverse=True)
        sums = np.bincount(place, weights=swept)
        self.settings_ = sums / np.bincount(place)
        return self

    def predict(self, X: Any) -> Array:
        """Look up the setting that solves each task.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Policies.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        setting = np.interp(X[:, 0], self.outcomes_, self.settings_)
        found = self.base_ + setting[:, None] * self.direction_
        return np.asarray(found[:, 0] if self._is_single_output else found)
