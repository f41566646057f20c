"""A stored movement as an option, stopped elsewhere than where it was learned to."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted

from msc._checks import check_kind, to_floats, validate_pairs, validate_points
from msc.robot import DMP, Workspace, inverse_kinematics
from msc.study.rivals._ends import check_fit, find_ends, find_homes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class StoppedMovement(BaseEstimator):  # type: ignore[misc]
    """Reuse the stored movement that passes nearest to a goal, and stop it there.

    After Soni and Singh: one level of options, their terminations adapted. It plans
    movements; it predicts no policy.

    Parameters
    ----------
    workspace : Workspace, optional
        Where the goals of tasks are; by default ``Workspace.free()``.
    dmp : DMP, optional
        What a policy means; by default the workspace's.

    Attributes
    ----------
    movements_ : ndarray of shape (n_tasks, n_moving + 1, 2)
        The stored movements: paths of the training policies to their own goals (m), as
        seen from a base that is turned along with the home pose.
    n_features_in_ : int
        Number of task parameters: as many as the workspace's tasks have.

    Notes
    -----
    An option [1]_ is a policy with a condition on which it ends. A goal that was not
    learned gets a learned option, ended where it comes nearest to that goal. It assumes
    that some stored movement comes near: of goals on a circle, those on the arm's side
    of it are passed on the way to others.

    That is no policy. A stored movement itself could be one for another goal, to the
    last bit: basis functions sum to one (Eq. 7), so that the spring's pull is a force
    like theirs. But the weights of a DMP do not let it stand still half-way. So this
    class has `plan` in place of `predict`: joint angles, for `Arm.follow`. Errors of
    policy weights it has none.

    Adapted: movements are those of searched policies, and pass where the DMP says, not
    where an arm was seen to be. Where tasks begin in different home poses, turned about
    the base, a movement is turned along: joints move alike. Left out: everything that
    makes a hierarchy, as salient events, intrinsic rewards, values over options; a
    reach has no parts.

    References
    ----------
    .. [1] V. Soni and S. Singh, "Reinforcement learning of hierarchical skills on the
       Sony Aibo robot", Proceedings of the Fifth International Conference on
       Development and Learning, 2006.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import StoppedMovement
    >>> option = StoppedMovement().fit([[0.0], [2.0]], np.zeros((2, 6)))
    >>> option.choose([[1.9]])
    (array([1]), array([60]))
    >>> option.plan([[1.9]]).shape
    (1, 67, 3)
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
        StoppedMovement
            The fitted planner.

        Raises
        ------
        ValueError
            If tasks are not as wide as the workspace's, or policies as the DMP's.
        """
        X, y = validate_pairs(self, X, y)
        self._world = Workspace.free() if self.workspace is None else self.workspace
        check_kind("workspace", self._world, Workspace)
        dmp = self._world.dmp if self.dmp is None else self.dmp
        check_kind("dmp", dmp, DMP)
        check_fit(self._world, dmp, X, y)
        physics, (starts, goals) = self._world.physics, find_ends(self._world, X)
        times = physics.time_step * np.arange(physics.n_moving + 1)
        paths = dmp.path(y, starts, goals, times)
        self.movements_ = _turn(paths, -self._turns(X))
        return self

    def _turns(self, X: Array) -> Array:
        """Return how far the base joint is turned at home, beyond the world's (rad)."""
        return np.asarray(find_homes(self._world, X)[:, 0] - self._world.home[0])

    def choose(self, X: ArrayLike) -> tuple[Indices, Indices]:
        """Choose the movement for each task, and when to stop it.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.

        Returns
        -------
        movement : ndarray of shape (n_tasks,)
            Which of the stored movements; of equally near ones the first.
        step : ndarray of shape (n_tasks,)
            At which step it stops, 0 to n_moving.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        goals = _turn(find_ends(self._world, X)[1][:, None], -self._turns(X))
        gaps = np.linalg.norm(self.movements_ - goals[:, None], axis=-1)
        nearest = gaps.reshape(len(goals), -1).argmin(axis=1)
        movement, step = np.unravel_index(nearest, gaps.shape[1:])
        return movement, step

    def path(self, X: ArrayLike) -> Array:
        """Trace the stopped movements.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.

        Returns
        -------
        ndarray of shape (n_tasks, n_moving + 1, 2)
            Positions (m): the movement, and after it the place where it stops.
        """
        movement, step = self.choose(X)
        steps = np.minimum(np.arange(self.movements_.shape[1]), step[:, None])
        paths = self.movements_[movement[:, None], steps]
        return _turn(paths, self._turns(to_floats("X", X)))

    def plan(self, X: ArrayLike) -> Array:
        """Turn the stopped movements into joint angles, as `Arm.plan` does policies.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks: angles (rad), and what else they have in units that weigh alike.

        Returns
        -------
        ndarray of shape (n_tasks, n_steps + 1, 3)
            Joint angles (rad); after the movement the last ones are held.
        """
        path, world, physics = self.path(X), self._world, self._world.physics
        homes = find_homes(world, to_floats("X", X))
        moving = inverse_kinematics(path, homes, world.link_lengths)
        held = moving[:, -1:].repeat(physics.n_steps - physics.n_moving, axis=1)
        return np.concatenate([moving, held], axis=1)


def _turn(paths: Array, angles: Array) -> Array:
    """Turn paths (n, n_times, 2) about the base, each by its angle (rad)."""
    (x, y), (cos, sin) = np.moveaxis(paths, -1, 0), (np.cos(angles), np.sin(angles))
    cos, sin = cos[:, None], sin[:, None]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
