"""Trials of policies: what each costs, and how many there have been."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from sklearn.neighbors import KNeighborsRegressor

from msc._checks import check_kind, to_floats
from msc.robot import DMP, Workspace, cached_arm
from msc.search import SearchOptions, cost, initial_covariance

Array = NDArray[np.float64]

Execute: TypeAlias = Callable[[Array, Array], Any]
"""Gives the costs of policies (n, n_params) on tasks (n, n_task_params), row by row."""

N_TOGETHER = 9  # trials that are executed before any is learned from: arms of a world


class Trials:
    """Execute policies in a world, or by a function in its place, and count them.

    Of a world the task is the angle (rad), and the cost that of a search.
    """

    def __init__(
        self, workspace: Workspace | None, execute: Execute | None, dmp: DMP | None
    ) -> None:
        self.n_rollouts = 0
        self._execute = execute
        self._world = Workspace.free() if workspace is None else workspace
        self._dmp = DMP() if dmp is None else dmp
        check_kind("workspace", self._world, Workspace)
        check_kind("dmp", self._dmp, DMP)
        if execute is not None and not callable(execute):
            raise TypeError(f"execute={execute!r}; wanted a function of policies, X")

    def __call__(self, policies: Array, X: Array) -> Array:
        """Return what policies cost, each on its task."""
        if self._execute:
            paid = to_floats("execute's costs", self._execute(policies, X))
        else:
            if X.shape[1] != 1:
                raise ValueError(f"X has {X.shape[1]} features; wanted one angle")
            arm = cached_arm(self._world, self._dmp, n_parallel=N_TOGETHER)
            rollouts = arm.execute_many(policies, np.rad2deg(X[:, 0]).tolist())
            paid = np.array([cost(rollout) for rollout in rollouts])
        if paid.shape != (len(X),) or not np.isfinite(paid).all():
            bad = paid[~np.isfinite(paid)] if paid.shape == (len(X),) else [paid.shape]
            raise ValueError(
                f"execute gave {bad[0]}; wanted {len(X)} finite costs, one a policy"
            )
        self.n_rollouts += len(X)
        return paid

    def spread(self, X: Array, n_params: int) -> Array:
        """Return a root of the first covariance of a search over tasks together.

        Quadratic forms of tasks, of which a search takes the inverse, are averaged;
        without a world, where there are none, it is the identity.
        """
        if self._execute:
            return np.eye(n_params)
        world, dmp = self._world, self._dmp
        roots = [initial_covariance(world, angle, dmp) for angle in np.rad2deg(X[:, 0])]
        inverse = np.mean([np.linalg.inv(root @ root.T) for root in roots], axis=0)
        root = np.linalg.cholesky(np.linalg.inv(inverse))
        return np.asarray(root / np.exp(np.log(np.diag(root)).mean()))

    def first_step(self, is_near: bool) -> float:
        """Return the first step of a search: small if it begins near its end."""
        options = SearchOptions()
        share = options.small_step if is_near else options.first_step
        return share * self._dmp.spring


def draw_tasks(
    rng: np.random.Generator,
    n_tasks: int,
    X: Array,
    span: tuple[float, float] | None,
) -> Array:
    """Draw tasks uniformly between bounds, by default those of the given ones."""
    if span is None:
        low, high = X.min(axis=0), X.max(axis=0)
    else:
        low, high = to_floats("span", span)
        if not low < high:
            raise ValueError(f"span={span!r}; wanted its lower bound before its upper")
    return rng.uniform(low, high, (n_tasks, X.shape[1]))


def cosines(X: Array, n_features: int, span: tuple[float, float]) -> Array:
    """Return features (n_tasks, n_features) of one angle: orthonormal over the span.

    Of mean square one, and mutually uncorrelated, over tasks that are uniform there::

        f_0 = 1,  f_k = sqrt(2) cos(k pi (x - low) / (high - low))
    """
    if X.shape[1] != 1:
        raise ValueError(f"X has {X.shape[1]} features; wanted one angle")
    low, high = to_floats("span", span)
    turns = np.pi * (X - low) / (high - low) * np.arange(n_features)
    return np.asarray(np.cos(turns) * np.sqrt(np.where(np.arange(n_features), 2, 1)))


def usual_costs(X: Array, costs: Array, new: Array) -> Array:
    """Interpolate what searched policies cost, between the two nearest of their tasks.

    >>> usual_costs(np.array([[0.0], [3.0]]), np.array([1.0, 4.0]), np.array([[2.0]]))
    array([3.])
    """
    nearest = KNeighborsRegressor(min(2, len(X)), weights="distance")
    return np.asarray(nearest.fit(X, costs).predict(new))
