"""Contextual policy search: one search distribution over all tasks."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils._param_validation import Interval
from sklearn.utils.validation import check_is_fitted

from msc._checks import (
    RANDOM_STATE,
    RandomState,
    seed_of,
    validate_pairs,
    validate_points,
)
from msc.robot import DMP, Workspace
from msc.study.rivals._trials import Execute, Span, Trials, cosines, draw_tasks

Array = NDArray[np.float64]

_RIDGE = 1e-6  # of regressions on features


class ContextualSearch(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Search the policies of all tasks at once, by a CMA-ES that sees the task.

    Parameters
    ----------
    workspace : Workspace, optional
        Where to execute; by default ``Workspace.free()``.
    execute : callable, optional
        Executes in its place: policies of shape (n, n_params) and tasks of shape (n,
        n_task_params) give n costs.
    n_features : int, default=8
        Features of a task's first number; each further one has one more.
    from_policies : bool, default=False
        Whether to begin at the least-squares fit to the training policies, with a small
        first step, instead of at zero with a wide one.
    step : float, default=None
        Standard deviation, > 0, of the first policies. None: as in searches of one
        task.
    n_rollouts : int, default=20000
        Trials, at most: what searches of some twenty tasks from scratch take.
    span : tuple of (float, float), default=(0, 2 pi)
        Bounds of tasks, between which they are drawn, uniformly (rad); where tasks have
        several numbers, two rows of bounds.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    random_state : int, RandomState instance, Generator or None, default=None
        Draws tasks and policies.

    Attributes
    ----------
    coef_ : ndarray of shape (n_params, n_all_features)
        The mean of the search distribution is ``coef_ @ f(x)``.
    covariance_ : ndarray of shape (n_params, n_params)
        Its covariance, the same for all tasks.
    n_rollouts_ : int
        Rollouts spent, not counting searches of the training set.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    Contextual CMA-ES [1]_. In each generation tasks x_k come, policies are drawn::

        y_k ~ N(coef_ f(x_k), sigma^2 C)

    and executed. As some tasks cost more than others, policies are ranked by what they
    cost beyond a baseline, the regression of costs on nearly twice as many features.
    The better half get the weights of CMA-ES, and the mean moves by weighted regression
    of ``y - coef_ f`` on f. Step size and covariance follow CMA-ES, with paths of
    the mean's steps at the mean features. With f = 1 it is CMA-ES. It assumes that
    the best policies are linear in the features, and that all tasks want to be explored
    alike.

    The features f are those of `MultiTaskSearch`. All but the first count as context:
    n of them make ``4 + floor(3 log(n_params + n)) (1 + 2 n)`` policies a generation,
    and the rates are those of CMA-ES in n_params + n dimensions, as BOLeRo [2]_ has
    them.

    Adapted: the baseline's features, which are quadratic in the task otherwise; ridge
    regression moves the mean from where it is, not from zero; the first
    covariance is what searches of one task begin with, averaged over the training
    tasks. Neither policies nor costs of the training set count, unless `from_policies`.

    References
    ----------
    .. [1] A. Abdolmaleki, B. Price, N. Lau, L. P. Reis and G. Neumann, "Contextual
       covariance matrix adaptation evolutionary strategies", IJCAI 2017.
    .. [2] A. Fabisch, M. Langosz and F. Kirchner, "BOLeRo: Behavior optimization and
       learning for robots", International Journal of Advanced Robotic Systems 17, 2020.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import ContextualSearch
    >>> def execute(policies, X):
    ...     return ((policies - 3 * np.cos(X)) ** 2).sum(axis=1) - np.cos(X[:, 0])
    >>> search = ContextualSearch(
    ...     execute=execute, n_features=3, step=1, n_rollouts=3000, random_state=0
    ... )
    >>> search = search.fit([[1.0], [5.0]], np.zeros((2, 2)))
    >>> search.predict([[0.0], [np.pi / 2]]).round(2) + 0
    array([[3., 3.], [0., 0.]])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "n_features": [Interval(Integral, 1, None, closed="left")],
        "from_policies": ["boolean"],
        "step": [Interval(Real, 0, None, closed="neither"), None],
        "n_rollouts": [Interval(Integral, 0, None, closed="left")],
        "random_state": RANDOM_STATE,
    }

    def __init__(
        self,
        workspace: Workspace | None = None,
        *,
        execute: Execute | None = None,
        n_features: int = 8,
        from_policies: bool = False,
        step: float | None = None,
        n_rollouts: int = 20_000,
        span: Span = (0.0, 2 * np.pi),
        dmp: DMP | None = None,
        random_state: RandomState = None,
    ) -> None:
        self.workspace = workspace
        self.execute = execute
        self.n_features = n_features
        self.from_policies = from_policies
        self.step = step
        self.n_rollouts = n_rollouts
        self.span = span
        self.dmp = dmp
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> Self:
        """Search.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params)
            Policies; only their number of weights counts unless `from_policies`.

        Returns
        -------
        ContextualSearch
            The fitted search distribution.

        Raises
        ------
        ValueError
            If tasks have not as many numbers as the span bounds.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        if y.ndim == 1:
            raise ValueError(f"y has shape {y.shape}; wanted (n_tasks, n_params)")
        seen, n_params = cosines(X, self.n_features, self.span), y.shape[1]
        trials = Trials(self.workspace, self.execute, self.dmp)
        rng = np.random.default_rng(seed_of(self.random_state))
        mean = np.zeros((seen.shape[1], n_params))
        if self.from_policies:
            mean = np.linalg.lstsq(seen, y, rcond=None)[0]
        root = trials.spread(X, n_params)
        step = self.step or trials.first_step(self.from_policies)
        strategy = Strategy(mean, step, root @ root.T)
        while trials.n_rollouts + strategy.n_policies <= self.n_rollouts:
            tasks = draw_tasks(rng, strategy.n_policies, X, self.span)
            finer = cosines(tasks, 2 * self.n_features - 1, self.span)
            seen = finer[:, : len(mean)]
            policies = strategy.draw(seen, rng)
            paid = trials(policies, tasks)
            strategy.learn(seen, policies, paid - finer @ regress(finer, paid))
        self.coef_ = strategy.mean.T
        self.covariance_ = strategy.sigma**2 * strategy.covariance
        self.n_rollouts_ = trials.n_rollouts
        return self

    def predict(self, X: Any) -> Array:
        """Return the means of the search distribution.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params)
            Policies.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        return np.asarray(cosines(X, self.n_features, self.span) @ self.coef_.T)


class Strategy:
    """A CMA-ES whose mean is linear in features.

    Equations are those of Hansen's tutorial, arXiv 1604.00772, letters too.
    """

    def __init__(self, mean: Array, sigma: float, covariance: Array) -> None:
        self.mean, self.sigma, self.covariance = mean, sigma, covariance
        n_context, n_params = len(mean) - 1, mean.shape[1]
        n = n_params + n_context
        self.n_policies = 4 + int(3 * np.log(n)) * (1 + 2 * n_context)  # Eq. 48
        half = self.n_policies // 2
        weights = np.log((self.n_policies + 1) / 2 / np.arange(1, half + 1))  # Eq. 49
        self.weights = np.append(weights / weights.sum(), np.zeros(half + 1))
        self.weights = self.weights[: self.n_policies]
        self.mu = mu = 1 / (self.weights**2).sum()  # Eq. 8
        self.c_sigma = (mu + 2) / (n + mu + 5)  # Eq. 55
        excess = max(0.0, np.sqrt((mu - 1) / (n + 1)) - 1)
        self.damping = 1 + 2 * excess + self.c_sigma + np.log(n_context + 1)
        self.c_c = (4 + mu / n) / (n + 4 + 2 * mu / n)  # Eq. 56
        self.c_1 = 2 / ((n + 1.3) ** 2 + mu)  # Eq. 57
        rank_mu = 2 * (0.25 + mu - 2 + 1 / mu) / ((n + 2) ** 2 + mu)
        self.c_mu = min(1 - self.c_1, rank_mu)  # Eq. 58
        self.norm = np.sqrt(n_params) * (
            1 - 1 / (4 * n_params) + 1 / (21 * n_params**2)
        )
        self.path_sigma, self.path_c = np.zeros((2, n_params))
        self.n_generations = 0

    def draw(self, seen: Array, rng: np.random.Generator) -> Array:
        """Draw a policy for each task (Eqs. 38-40)."""
        values, axes = np.linalg.eigh(self.covariance)
        root = axes * np.sqrt(np.maximum(values, 0.0))
        normal = rng.standard_normal((len(seen), len(root)))
        return np.asarray(seen @ self.mean + self.sigma * normal @ root.T)

    def learn(self, seen: Array, policies: Array, costs: Array) -> None:
        """Move the distribution to what was cheap (Eqs. 41-47)."""
        self.n_generations += 1
        weights = np.empty(len(seen))
        weights[np.argsort(costs, kind="stable")] = self.weights
        steps = (policies - seen @ self.mean) / self.sigma
        moved = regress(seen, steps, weights)
        self.mean = self.mean + self.sigma * moved
        move = seen.mean(axis=0) @ moved
        values, axes = np.linalg.eigh(self.covariance)
        whitened = axes @ ((axes.T @ move) / np.sqrt(np.maximum(values, 1e-300)))
        c, n = self.c_sigma, len(move)
        self.path_sigma *= 1 - c
        self.path_sigma += np.sqrt(c * (2 - c) * self.mu) * whitened  # Eq. 43
        length = np.linalg.norm(self.path_sigma)
        usual = np.sqrt(1 - (1 - c) ** (2 * self.n_generations))
        is_short = length / usual < (1.4 + 2 / (n + 1)) * self.norm
        c = self.c_c
        self.path_c *= 1 - c
        self.path_c += is_short * np.sqrt(c * (2 - c) * self.mu) * move  # Eq. 45
        lost = self.c_1 * (1 - is_short) * c * (2 - c)
        self.covariance = (
            (1 - self.c_1 - self.c_mu + lost) * self.covariance
            + self.c_1 * np.outer(self.path_c, self.path_c)
            + self.c_mu * (weights[:, None] * steps).T @ steps
        )  # Eq. 47
        faster = self.c_sigma / self.damping * (length / self.norm - 1)  # Eq. 44
        self.sigma *= np.exp(min(0.6, faster))


def regress(seen: Array, values: Array, weights: Array | None = None) -> Array:
    """Regress on features, samples weighted, with a ridge that is hardly there."""
    shares = np.ones(len(seen)) if weights is None else weights
    weighted = (shares / shares.sum())[:, None] * seen
    gram = weighted.T @ seen + _RIDGE * np.eye(seen.shape[1])
    return np.asarray(np.linalg.solve(gram, weighted.T @ values))
