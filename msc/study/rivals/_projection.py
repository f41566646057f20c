"""A prediction moved onto the policies that end at the goal, whatever predicted it."""

from __future__ import annotations

import inspect
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin, clone
from sklearn.utils.validation import check_is_fitted, has_fit_parameter

from msc._checks import (
    check_kind,
    check_number,
    to_floats,
    validate_cost,
    validate_pairs,
    validate_points,
)
from msc.robot import DMP

Array = NDArray[np.float64]


class GoalProjected(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Have any method's movements end at their goals.

    Parameters
    ----------
    estimator : regressor
        The method: `fit(X, y)` and `predict(X)`, policies as wide as the DMP's.
    dmp : DMP, optional
        What a policy means; by default ``DMP()``.
    end_time : float, default=1.0
        When the movement is to be at the goal (s): as the arm stops to follow it.
    metric : array-like of shape (n_params, n_params), default=None
        Symmetric positive definite M: the change d is least in d'Md. None: the
        identity, weights as they are.

    Attributes
    ----------
    estimator_ : regressor
        The fitted method.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    Eq. 5 of [1]_ is linear in the weights w of each coordinate,
    x(t) = x0 + (g - x0) (a(t) + B(t) w), so that x(T) = g is one condition on them::

        B(T) w = 1 - a(T)

    The same for all goals: the way there cancels, and where a coordinate of the goal
    equals the start's, any weights will do. With the conditions A w = c of both
    coordinates the nearest policy that meets them is::

        w + M^-1 A' (A M^-1 A')^-1 (c - A w)

    Conditioning a Gaussian of covariance M^-1 and mean w on A w = c gives the same,
    which is how probabilistic movement primitives reach an end point [2]_.

    It assumes that the arm follows the path. A path that leaves its reach, or meets an
    obstacle, ends elsewhere.

    References
    ----------
    .. [1] "Task-Based Behavior Generalization via Manifold Clustering", section IV.
    .. [2] A. Paraschos, C. Daniel, J. Peters and G. Neumann, "Probabilistic movement
       primitives", Advances in Neural Information Processing Systems 26, 2013.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.dummy import DummyRegressor
    >>> from msc import DMP
    >>> from msc.study.rivals import GoalProjected
    >>> X, y = np.zeros((3, 1)), np.arange(18.0).reshape(3, 6)
    >>> policy = GoalProjected(DummyRegressor()).fit(X, y).predict([[0.5]])
    >>> DMP().path(policy, start=[0, 0], goal=[1, 2], times=[1.0]).round(9)
    array([[[1., 2.]]])
    """

    def __init__(
        self,
        estimator: Any,
        dmp: DMP | None = None,
        *,
        end_time: float = 1.0,
        metric: ArrayLike | None = None,
    ) -> None:
        self.estimator = estimator
        self.dmp = dmp
        self.end_time = end_time
        self.metric = metric

    def fit(self, X: Any, y: Any, cost: Any = None) -> Self:
        """Fit the method, and find the conditions.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params)
            Policies.
        cost : array-like of shape (n_tasks,), default=None
            Positive cost of each policy; handed on to a method that takes it.

        Returns
        -------
        GoalProjected
            The fitted wrapper.

        Raises
        ------
        ValueError
            If policies are not as wide as the DMP's, or the metric is none.
        """
        X, y = validate_pairs(self, X, y)
        dmp = DMP() if self.dmp is None else self.dmp
        check_kind("dmp", dmp, DMP)
        check_number("end_time", self.end_time, 1e-3, 100.0)
        n_params = dmp.n_params
        if y.shape[1:] != (n_params,):
            raise ValueError(f"y has shape {y.shape}; wanted (n_tasks, {n_params})")
        ways = np.vstack([np.zeros(n_params), np.eye(n_params)])
        ends = dmp.path(ways, [0, 0], [1, 1], [self.end_time])[:, 0]
        self._ends = (ends[1:] - ends[0]).T  # A
        self._wanted = 1 - ends[0]  # c
        spread = _inverse(self.metric, n_params) @ self._ends.T  # M^-1 A'
        self._gain = spread @ np.linalg.inv(self._ends @ spread)
        given = {}
        if cost is not None and has_fit_parameter(self.estimator, "cost"):
            given = {"cost": validate_cost(cost, len(X))}
        self.estimator_ = clone(self.estimator).fit(X, y, **given)
        return self

    def project(self, policies: ArrayLike) -> Array:
        """Move policies onto the conditions.

        Parameters
        ----------
        policies : array-like of shape (n_policies, n_params)
            Whatever they do.

        Returns
        -------
        ndarray of shape (n_policies, n_params)
            The nearest ones that end at their goals.
        """
        check_is_fitted(self)
        given = to_floats("policies", policies)
        return np.asarray(given + (self._wanted - given @ self._ends.T) @ self._gain.T)

    def predict(self, X: Any, return_std: bool = False) -> Array | tuple[Array, Array]:
        """Predict policies that end at their goals.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        return_std : bool, default=False
            Whether to return standard deviations too.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params)
            Predicted policies, projected.
        std : ndarray of shape (n_tasks, n_params)
            Standard deviations after the projection, if the method's errors are
            independent from weight to weight; only if `return_std`.

        Raises
        ------
        ValueError
            If the method has no standard deviation for each weight.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        if not return_std:
            return self.project(self.estimator_.predict(X))
        if "return_std" not in inspect.signature(self.estimator_.predict).parameters:
            raise ValueError(
                "return_std=True needs a method whose predict can return it. "
                f"Got {self.estimator!r}."
            )
        policies, std = self.estimator_.predict(X, return_std=True)
        if std.shape != policies.shape:
            raise ValueError(
                "return_std=True needs a standard deviation for each weight, of shape "
                f"{policies.shape}. Got {std.shape} from {self.estimator!r}."
            )
        kept = np.eye(len(self._gain)) - self._gain @ self._ends
        return self.project(policies), np.sqrt(std**2 @ (kept**2).T)


def _inverse(metric: ArrayLike | None, n_params: int) -> Array:
    """Invert a metric, or say what is wrong with it."""
    if metric is None:
        return np.eye(n_params)
    given = to_floats("metric", metric)
    problem = ""
    if given.shape != (n_params, n_params):
        problem = f"shape {given.shape}"
    elif not np.allclose(given, given.T):
        problem = "one that is not symmetric"
    else:
        try:
            return np.asarray(cho_solve(cho_factor(given), np.eye(n_params)))
        except (LinAlgError, ValueError) as error:
            problem = f"another ({error})"
    raise ValueError(
        f"metric must be a positive definite matrix of shape ({n_params}, {n_params}). "
        f"Got {problem}."
    )
