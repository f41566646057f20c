"""Trials of policies: what each costs, and how many there have been."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from sklearn.neighbors import KNeighborsRegressor

from msc._checks import check_kind, to_floats
from msc.robot import DMP, Workspace, cached_arm
from msc.search import SearchOptions, cost, initial_covariance, tasks_at

Array = NDArray[np.float64]

Execute: TypeAlias = Callable[[Array, Array], Any]
"""Gives the costs of policies (n, n_params) on tasks (n, n_task_params), row by row."""

Span: TypeAlias = tuple[Any, Any]
"""Bounds of tasks, the lower ones first: of one number, or rows of as many as X has."""

N_TOGETHER = 9  # trials that are executed before any is learned from: arms of a world


class Trials:
    """Execute policies in a world, or by a function in its place, and count them.

    Of a world tasks are points of `coordinates`, and the cost is that of a search.
    """

    def __init__(
        self, workspace: Workspace | None, execute: Execute | None, dmp: DMP | None
    ) -> None:
        self.n_rollouts = 0
        self._execute = execute
        self._world = Workspace.free() if workspace is None else workspace
        check_kind("workspace", self._world, Workspace)
        self._dmp = self._world.dmp if dmp is None else dmp
        check_kind("dmp", self._dmp, DMP)
        if execute is not None and not callable(execute):
            raise TypeError(f"execute={execute!r}; wanted a function of policies, X")

    def __call__(self, policies: Array, X: Array) -> Array:
        """Return what policies cost, each on its task."""
        if self._execute:
            paid = to_floats("execute's costs", self._execute(policies, X))
        else:
            tasks = tasks_at(self._world, X)
            arm = cached_arm(self._world, self._dmp, n_parallel=N_TOGETHER)
            rollouts = arm.execute_many(policies, tasks.tolist())
            weights = self._world.cost
            paid = np.array([cost(rollout, weights) for rollout in rollouts])
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
        tasks = tasks_at(world, X)
        roots = [initial_covariance(world, task, dmp) for task in tasks]
        inverse = np.mean([np.linalg.inv(root @ root.T) for root in roots], axis=0)
        root = np.linalg.cholesky(np.linalg.inv(inverse))
        return np.asarray(root / np.exp(np.log(np.diag(root)).mean()))

    def first_step(self, is_near: bool) -> float:
        """Return the first step of a search: small if it begins near its end."""
        options = SearchOptions()
        share = options.small_step if is_near else options.first_step
        return share * self._dmp.spring


def draw_tasks(
    rng: np.random.Generator, n_tasks: int, X: Array, span: Span | None
) -> Array:
    """Draw tasks uniformly between bounds, by default those of the given ones."""
    if span is None:
        low, high = X.min(axis=0), X.max(axis=0)
    else:
        low, high = _bounds(span)
        if low.size not in (1, X.shape[1]):
            raise ValueError(_too_few(X, span))
    return rng.uniform(low, high, (n_tasks, X.shape[1]))


def cosines(X: Array, n_features: int, span: Span) -> Array:
    """Return features of tasks: orthonormal over the span.

    Of mean square one, and mutually uncorrelated, over tasks that are uniform there::

        f_0 = 1,  f_k = sqrt(2) cos(k pi (x - low) / (high - low))

    of the first number, k below `n_features`; before them, f_1 of each further one.
    """
    low, high = (np.atleast_1d(bound) for bound in _bounds(span))
    if len(low) != X.shape[1]:
        raise ValueError(_too_few(X, span))
    halves = np.pi * (X - low) / (high - low)
    turns = halves[:, :1] * np.arange(n_features)
    first = np.cos(turns) * np.sqrt(np.where(np.arange(n_features), 2, 1))
    return np.hstack([np.sqrt(2) * np.cos(halves[:, 1:]), first])


def _bounds(span: Span) -> Array:
    """Return a span's lower and upper bounds, or say what is wrong with them."""
    bounds = to_floats("span", span)
    if len(bounds) != 2 or not np.all(bounds[0] < bounds[1]):
        raise ValueError(f"span={span!r}; wanted its lower bound before its upper")
    return bounds


def _too_few(X: Array, span: Span) -> str:
    """Say that a span bounds not as many numbers as tasks have."""
    return f"span={span!r} bounds {np.size(span) // 2} numbers; wanted {X.shape[1]}"


def usual_costs(X: Array, costs: Array, new: Array) -> Array:
    """Interpolate what searched policies cost, between the two nearest of their tasks.

    >>> usual_costs(np.array([[0.0], [3.0]]), np.array([1.0, 4.0]), np.array([[2.0]]))
    array([3.])
    """
    nearest = KNeighborsRegressor(min(2, len(X)), weights="distance")
    return np.asarray(nearest.fit(X, costs).predict(new))
