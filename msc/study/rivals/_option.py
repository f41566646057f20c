"""A stored movement as an option, stopped elsewhere than where it was learned to."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_is_fitted

from msc._checks import check_kind, validate_pairs, validate_points
from msc.robot import (
    DMP,
    TIME_STEP,
    Workspace,
    forward_kinematics,
    inverse_kinematics,
)

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_N_MOVING, _N_STEPS = 60, 66  # steps of an arm's rollout: moving, and with settling


class StoppedMovement(BaseEstimator):  # type: ignore[misc]
    """Reuse the stored movement that passes nearest to a goal, and stop it there.

    After Soni and Singh: one level of options, their terminations adapted. It plans
    movements; it predicts no policy.

    Parameters
    ----------
    workspace : Workspace, optional
        Where the goals of tasks are; by default ``Workspace.free()``.
    dmp : DMP, optional
        What a policy means; by default ``DMP()``.

    Attributes
    ----------
    movements_ : ndarray of shape (n_tasks, n_moving + 1, 2)
        The stored movements: paths of the training policies to their own goals (m).
    n_features_in_ : int
        Number of task parameters: one, the angle.

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
    where an arm was seen to be. Left out: everything that makes a hierarchy, as salient
    events, intrinsic rewards, values over options; a reach has no parts.

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
        X : array-like of shape (n_tasks, 1)
            Task angles (rad).
        y : array-like of shape (n_tasks, n_params)
            Policies.

        Returns
        -------
        StoppedMovement
            The fitted planner.

        Raises
        ------
        ValueError
            If a task is more than an angle, or policies are not as wide as the DMP's.
        """
        X, y = validate_pairs(self, X, y)
        self._world = Workspace.free() if self.workspace is None else self.workspace
        dmp = DMP() if self.dmp is None else self.dmp
        check_kind("workspace", self._world, Workspace)
        check_kind("dmp", dmp, DMP)
        if X.shape[1] != 1 or y.shape[1:] != (dmp.n_params,):
            raise ValueError(
                f"X has shape {X.shape} and y {y.shape}; wanted (n_tasks, 1) and "
                f"(n_tasks, {dmp.n_params})"
            )
        world, times = self._world, TIME_STEP * np.arange(_N_MOVING + 1)
        start = forward_kinematics(world.home, world.link_lengths)[-1]
        self.movements_ = dmp.path(y, start, self._goals(X), times)
        return self

    def _goals(self, X: Array) -> Array:
        return self._world.target(np.rad2deg(X[:, 0]))

    def choose(self, X: ArrayLike) -> tuple[Indices, Indices]:
        """Choose the movement for each task, and when to stop it.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Task angles (rad).

        Returns
        -------
        movement : ndarray of shape (n_tasks,)
            Which of the stored movements; of equally near ones the first.
        step : ndarray of shape (n_tasks,)
            At which step it stops, 0 to n_moving.
        """
        check_is_fitted(self)
        goals = self._goals(validate_points(self, X, reset=False))
        gaps = np.linalg.norm(self.movements_ - goals[:, None, None], axis=-1)
        nearest = gaps.reshape(len(goals), -1).argmin(axis=1)
        movement, step = np.unravel_index(nearest, gaps.shape[1:])
        return movement, step

    def path(self, X: ArrayLike) -> Array:
        """Trace the stopped movements.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Task angles (rad).

        Returns
        -------
        ndarray of shape (n_tasks, n_moving + 1, 2)
            Positions (m): the movement, and after it the place where it stops.
        """
        movement, step = self.choose(X)
        steps = np.minimum(np.arange(_N_MOVING + 1), step[:, None])
        return np.asarray(self.movements_[movement[:, None], steps])

    def plan(self, X: ArrayLike) -> Array:
        """Turn the stopped movements into joint angles, as `Arm.plan` does policies.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Task angles (rad).

        Returns
        -------
        ndarray of shape (n_tasks, n_steps + 1, 3)
            Joint angles (rad); after the movement the last ones are held.
        """
        path, world = self.path(X), self._world
        moving = inverse_kinematics(path, world.home, world.link_lengths)
        held = moving[:, -1:].repeat(_N_STEPS - _N_MOVING, axis=1)
        return np.concatenate([moving, held], axis=1)
