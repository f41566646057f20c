"""A known movement, turned and stretched onto the way to another goal."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils.validation import check_is_fitted

from msc._checks import check_kind, validate_pairs, validate_points
from msc.robot import DMP, Workspace
from msc.study.rivals._ends import check_fit, find_ways

Array = NDArray[np.float64]


class MappedMovement(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Carry the nearest task's movement over, by how start and goals correspond.

    After Liu and Stone. What it predicts is where a search of the new task begins.

    Parameters
    ----------
    workspace : Workspace, optional
        Where the goals of tasks are; by default ``Workspace.free()``.
    dmp : DMP, optional
        What a policy means, not `gated`; by default the workspace's.

    Attributes
    ----------
    tasks_ : ndarray of shape (n_tasks, n_task_params)
        Source tasks: the training tasks.
    policies_ : ndarray of shape (n_tasks, n_params)
        Their policies.
    n_features_in_ : int
        Number of task parameters: as many as the workspace's tasks have.

    Notes
    -----
    In [1]_ what was learned in a source task is translated to a target task, by a map
    between what corresponds in them, and learning goes on from there. Here start and
    goal correspond; the one similarity that takes the source's start x0 and goal g to
    the target's x0' and g' turns and stretches the movement by the same as the way::

        x'(t) - x0' = R (x(t) - x0),  g' - x0' = R (g - x0)

    Basis functions sum to one (Eq. 7), so that the spring is a force K like theirs, and
    each coordinate moves by x(t) - x0 = (g - x0) B(t) (K + w). So there is a policy of
    the target that moves so to the last bit::

        w'_d = sum_e R_de (g - x0)_e (K + w_e) / (g' - x0')_d - K

    A DMP's own scaling, which stretches each coordinate by itself and is what a policy
    left as it is would do, is no similarity. It assumes that the arm and the obstacles
    do not mind being at another place; `msc.study.measure_savings` says what
    that is worth: jump-start, rollouts to a threshold, asymptote.

    Adapted: the map is given, where the original finds it by structure mapping between
    qualitative models; values of actions become weights of a movement; the source is
    the nearest training task, angles round the circle, as there are several.

    References
    ----------
    .. [1] Y. Liu and P. Stone, "Value-function-based transfer for reinforcement
       learning using structure mapping", Proceedings of the Twenty-First National
       Conference on Artificial Intelligence, 2006.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import MappedMovement
    >>> model = MappedMovement().fit([[1.0], [3.0]], np.zeros((2, 6)))
    >>> model.predict([[1.2]]).round(6) + 0  # a straight movement stays straight
    array([[0., 0., 0., 0., 0., 0.]])
    """

    def __init__(
        self, workspace: Workspace | None = None, dmp: DMP | None = None
    ) -> None:
        self.workspace = workspace
        self.dmp = dmp

    def fit(self, X: Any, y: Any) -> Self:
        """Store the movements.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.
        y : array-like of shape (n_tasks, n_params)
            Policies.

        Returns
        -------
        MappedMovement
            The fitted map.

        Raises
        ------
        ValueError
            If tasks are not as wide as the workspace's or policies as the DMP's, or the
            DMP is gated.
        """
        X, y = validate_pairs(self, X, y)
        self._world = Workspace.free() if self.workspace is None else self.workspace
        check_kind("workspace", self._world, Workspace)
        self._dmp = self._world.dmp if self.dmp is None else self.dmp
        check_kind("dmp", self._dmp, DMP)
        if self._dmp.gated:
            raise ValueError("dmp is gated: its spring is no force like the basis'")
        check_fit(self._world, self._dmp, X, y)
        self.tasks_, self.policies_ = X.copy(), y.copy()
        return self

    def predict(self, X: Any) -> Array:
        """Turn and stretch the movements of the nearest tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.

        Returns
        -------
        ndarray of shape (n_tasks, n_params)
            Policies; of equally near tasks the first counts.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        apart = X[:, None] - self.tasks_
        apart[..., 0] = (apart[..., 0] + np.pi) % (2 * np.pi) - np.pi
        source = np.linalg.norm(apart, axis=2).argmin(axis=1)
        old = find_ways(self._world, self.tasks_[source])
        new, spring = find_ways(self._world, X), self._dmp.spring
        ratio = (new @ [1, 1j]) / (old @ [1, 1j])  # a similarity is a complex factor
        force = spring + self.policies_[source].reshape(len(X), 2, -1)
        moved = ratio[:, None] * np.einsum("td,tdb,d->tb", old, force, [1, 1j])
        turned = np.stack([moved.real, moved.imag], axis=1) / new[:, :, None]
        return np.asarray((turned - spring).reshape(len(X), -1))
