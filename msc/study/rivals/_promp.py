"""Probabilistic movement primitives, conditioned on where the movement has to end."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.covariance import LedoitWolf
from sklearn.utils.validation import check_is_fitted

from msc._checks import check_kind, check_number, validate_pairs, validate_points
from msc.robot import DMP, Workspace
from msc.study.rivals._ends import check_fit, find_ways

Array = NDArray[np.float64]


class ConditionedProMP(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Condition the distribution of known movements on the goal.

    Parameters
    ----------
    workspace : Workspace, optional
        Where the goals of tasks are; by default ``Workspace.free()``.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    end_time : float, default=1.0
        When the movement is to be at the goal (s).

    Attributes
    ----------
    mean_ : ndarray of shape (2 + n_params,)
        Mean of the movements' weights.
    covariance_ : ndarray of shape (2 + n_params, 2 + n_params)
        Their covariance.
    n_features_in_ : int
        Number of task parameters: as many as the workspace's tasks have.

    Notes
    -----
    In [1]_ a movement is a sum of basis functions of time, its weights u are Gaussian,
    and what has to be, H u = h, is met by conditioning::

        mean + S H' (H S H')^-1 (h - H mean),  S - S H' (H S H')^-1 H S

    Here the basis is what a DMP answers with: by Eq. 5 each coordinate moves by
    x(t) - x0 = (g - x0) (a(t) + B(t) w), so that a(t) and B(t) have the weights
    u = (g - x0) (1, w), in metres. Two things have to be in each coordinate: the first
    weight is g - x0, so that there is a policy of this goal, and x(T) = g. The policy
    is w = u / (g - x0) without its first. It assumes one bell of movements, so that two
    ways round an obstacle are mixed, and a way to the goal in both coordinates.

    Adapted: the basis, as told; movements to learn from are those of searched policies;
    their covariance is shrunk after Ledoit and Wolf [2]_, as a few movements leave it
    singular. That leaves nothing to tune. Left out: via points, blending, phase and the
    stochastic controller.

    References
    ----------
    .. [1] A. Paraschos, C. Daniel, J. Peters and G. Neumann, "Probabilistic movement
       primitives", Advances in Neural Information Processing Systems 26, 2013.
    .. [2] O. Ledoit and M. Wolf, "A well-conditioned estimator for large-dimensional
       covariance matrices", Journal of Multivariate Analysis 88, 2004.

    Examples
    --------
    >>> import numpy as np
    >>> from msc import DMP, Workspace
    >>> from msc.study.rivals import ConditionedProMP
    >>> X, y = np.array([[1.0], [2.0], [4.0]]), np.arange(18.0).reshape(3, 6)
    >>> policy = ConditionedProMP().fit(X, y).predict([[3.0]])
    >>> goal = Workspace.free().target(np.rad2deg(3.0))
    >>> DMP().path(policy, start=[0, 0], goal=goal, times=[1.0])[0, -1] - goal < 1e-9
    array([ True,  True])
    """

    def __init__(
        self,
        workspace: Workspace | None = None,
        dmp: DMP | None = None,
        *,
        end_time: float = 1.0,
    ) -> None:
        self.workspace = workspace
        self.dmp = dmp
        self.end_time = end_time

    def fit(self, X: Any, y: Any) -> Self:
        """Find mean and covariance of the movements.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike; at
            least two.
        y : array-like of shape (n_tasks, n_params)
            Policies.

        Returns
        -------
        ConditionedProMP
            The fitted distribution.

        Raises
        ------
        ValueError
            If tasks are not as wide as the workspace's or policies as the DMP's, or
            there are fewer than two.
        """
        X, y = validate_pairs(self, X, y)
        self._world = Workspace.free() if self.workspace is None else self.workspace
        check_kind("workspace", self._world, Workspace)
        dmp = self._world.dmp if self.dmp is None else self.dmp
        check_kind("dmp", dmp, DMP)
        check_number("end_time", self.end_time, 1e-3, 100.0)
        check_fit(self._world, dmp, X, y)
        if len(y) < 2:
            raise ValueError(f"X has shape {X.shape}; wanted at least two tasks")
        whole = np.insert(y.reshape(len(y), 2, dmp.n_basis), 0, 1.0, axis=2)
        weights = (find_ways(self._world, X)[:, :, None] * whole).reshape(len(y), -1)
        model = LedoitWolf().fit(weights)
        self.mean_, self.covariance_ = model.location_, model.covariance_
        alone = np.vstack([np.zeros(dmp.n_params), np.eye(dmp.n_params)])
        ends = dmp.path(alone, [0, 0], [1, 1], [self.end_time])[:, 0, 0]
        n_basis = dmp.n_basis  # ends of the spring's response, and of those of x
        last = np.append(ends[0], ends[1 : n_basis + 1] - ends[0])
        first = np.eye(1, n_basis + 1)[0]
        self._conditions = np.kron(np.eye(2), [first, last])  # H
        return self

    def predict(self, X: Any, return_std: bool = False) -> Array | tuple[Array, Array]:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.
        return_std : bool, default=False
            Whether to return standard deviations too.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params)
            Most likely policies.
        std : ndarray of shape (n_tasks, n_params)
            Their standard deviations; only if `return_std`.
        """
        check_is_fitted(self)
        ways = find_ways(self._world, validate_points(self, X, reset=False))
        spread = self.covariance_ @ self._conditions.T  # S H'
        gain = spread @ np.linalg.inv(self._conditions @ spread)
        wanted = ways.repeat(2, axis=1)  # h: both conditions of x, then those of y
        found = self.mean_ + (wanted - self._conditions @ self.mean_) @ gain.T
        variances = np.diag(self.covariance_ - gain @ spread.T)
        policies = self._without_first(found) / ways[:, :, None]
        if not return_std:
            return policies.reshape(len(ways), -1)
        std = np.sqrt(np.maximum(self._without_first(variances[None]), 0.0))
        std = std / np.abs(ways)[:, :, None]
        return policies.reshape(len(ways), -1), std.reshape(len(ways), -1)

    def _without_first(self, weights: Array) -> Array:
        return weights.reshape(len(weights), 2, -1)[:, :, 1:]
