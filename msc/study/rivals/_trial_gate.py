"""A gate that asks the arm: two charts' policies are tried, and the cheaper is kept."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin, clone
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points
from msc.robot import Workspace
from msc.study.rivals._trials import Execute, Trials

Array = NDArray[np.float64]


class TriedSkill(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A skill that tries the policies of two charts, and keeps the cheaper.

    Parameters
    ----------
    skill : estimator
        What predicts: one with `charts_`, and a `predict` that takes a `chart` for each
        task, as `ParameterizedSkill` is.
    workspace : Workspace, optional
        Where to execute; by default ``Workspace.free()``.
    execute : callable, optional
        Executes in its place: policies of shape (n, n_params) and tasks of shape
        (n, n_task_params) give n costs.

    Attributes
    ----------
    skill_ : estimator
        The fitted skill.
    charts_ : ndarray of shape (n_tasks,)
        Its charts.
    n_rollouts_ : int
        Policies executed so far: two a predicted task, one of which would be executed
        in any case; none, where there is one chart.

    Notes
    -----
    The two charts are that of the nearest training task, which the gate "nearest" would
    choose, and that of the nearest one of another chart. What a policy costs is what a
    search would pay: the robot can tell without a searched policy to compare with.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.cluster import KMeans
    >>> from msc import ParameterizedSkill
    >>> from msc.study.rivals import TriedSkill
    >>> X = np.linspace(0, 6, 20)[:, np.newaxis]
    >>> def execute(policies, tasks):
    ...     return ((policies - (tasks > 3.1)) ** 2).sum(axis=1)
    >>> model = TriedSkill(ParameterizedSkill(KMeans(2)), execute=execute)
    >>> model.fit(X, X > 3).predict([[3.05], [3.15]]).round(6)
    array([[0.],
           [1.]])
    >>> model.n_rollouts_
    4
    """

    def __init__(
        self,
        skill: Any,
        workspace: Workspace | None = None,
        *,
        execute: Execute | None = None,
    ) -> None:
        self.skill = skill
        self.workspace = workspace
        self.execute = execute

    def fit(self, X: Any, y: Any) -> Self:
        """Fit the skill; nothing is executed.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks; of a workspace the angle (rad), and all else that tasks have.
        y : array-like of shape (n_tasks, n_params)
            Policies.

        Returns
        -------
        TriedSkill
            The fitted skill.
        """
        X, y = validate_pairs(self, X, y)
        self._trials = Trials(self.workspace, self.execute, None)
        self.skill_ = clone(self.skill).fit(X, y)
        self.charts_, self._tasks = self.skill_.charts_, X
        self.n_rollouts_ = 0
        return self

    def predict(self, X: Any) -> Array:
        """Predict by the two charts whose training tasks are nearest, and try both.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params)
            Of each task's two policies the cheaper; of equally cheap ones that of the
            nearest task's chart.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        charts = np.unique(self.charts_)
        if len(charts) == 1:
            return np.asarray(self.skill_.predict(X))
        apart = np.linalg.norm(X[:, np.newaxis] - self._tasks, axis=2)
        nearest = [apart[:, self.charts_ == chart].min(axis=1) for chart in charts]
        pairs = charts[np.argsort(nearest, axis=0, kind="stable")[:2]]
        found = np.stack([self.skill_.predict(X, chart=chart) for chart in pairs])
        paid = self._trials(np.concatenate(found), np.tile(X, (2, 1))).reshape(2, -1)
        self.n_rollouts_ = self._trials.n_rollouts
        return np.asarray(found[paid.argmin(axis=0), np.arange(len(X))])
