"""Cost-regularized kernel regression that goes on by trial: draw, execute, learn."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.preprocessing import StandardScaler
from sklearn.utils._param_validation import Interval
from sklearn.utils.validation import check_is_fitted

from msc._checks import (
    RANDOM_STATE,
    RandomState,
    seed_of,
    validate_cost,
    validate_pairs,
    validate_points,
)
from msc.robot import DMP, Workspace
from msc.study.rivals._crkr import CrKR
from msc.study.rivals._trials import (
    N_TOGETHER,
    Execute,
    Span,
    Trials,
    draw_tasks,
    usual_costs,
)

Array = NDArray[np.float64]

_FLOOR = 0.01  # of the training tasks' mean cost: what beyond counts as none


class PractisedCrKR(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Practise what `CrKR` predicts: explore where it is unsure, trust what was cheap.

    Parameters
    ----------
    workspace : Workspace, optional
        Where to execute; by default ``Workspace.free()``.
    execute : callable, optional
        Executes in its place: policies of shape (n, n_params) and tasks of shape (n,
        n_task_params) give n positive costs.
    length_scale, ridge, tune : float, float, bool
        As of `CrKR`, for standardised policies; tuned once, before practice.
    beyond : bool, default=True
        Whether a sample counts with what it cost beyond the searched policies, as they
        are between the training tasks, instead of its whole cost.
    n_rollouts : int, default=500
        Trials.
    n_together : int, default=9
        Trials that are drawn and executed before they are learned from: arms of a
        world. The original learns from every one: 1.
    span : tuple of (float, float), default=None
        Bounds of the tasks that are practised, drawn uniformly (rad), or two rows of
        them, a column each. None: from the least training task to the greatest.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    random_state : int, RandomState instance, Generator or None, default=None
        Draws tasks and policies.

    Attributes
    ----------
    regressor_ : CrKR
        The regression on all samples, of policies standardised by the training set.
    tasks_, policies_, costs_ : ndarray
        The samples, training set first and then trials in order, of shapes
        (n_samples, n_task_params), (n_samples, n_params) and (n_samples,).
    n_rollouts_ : int
        Rollouts spent on practice, not counting searches of the training set.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    The algorithm of [1]_, Table I. A task x comes; with the kernel k, its matrix K over
    all samples, C the diagonal matrix of their costs and Y their policies, a policy is
    drawn from a normal distribution, alike for all weights, with::

        mean(x)     = k(x)' (K + ridge C)^-1 Y
        variance(x) = k(x, x) + ridge - k(x)' (K + ridge C)^-1 k(x)

    It is executed, and joins the samples with what it cost. So exploration fades where
    samples are dense and cheap, down to the ridge; and cost is a noise variance: of two
    policies of a task the mean keeps to the cheaper, in proportion. It assumes that
    what lies between good policies is good. `predict` gives the mean.

    Adapted: where a task is solved a cost here does not fall to zero, as the original's
    does, and a poor trial would weigh nearly what a searched policy does. So C holds
    what is `beyond` the costs of the two nearest training tasks, averaged by nearness,
    and a hundredth of the training tasks' mean cost.
    Policies are standardised over the training set, without which a variance of about
    one would explore nothing of weights of some twenty, and the mean far from all
    samples would be the zero policy. The start is a set of searched policies, not one
    demonstration; trials are executed nine at a time.

    References
    ----------
    .. [1] J. Kober, A. Wilhelm, E. Oztop and J. Peters, "Reinforcement learning to
       adjust parametrized motor primitives to new situations", Autonomous Robots 33,
       2012.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import PractisedCrKR
    >>> def execute(policies, X):
    ...     return 0.01 + (policies[:, 0] - np.sin(X[:, 0])) ** 2
    >>> X, y = np.array([[0.0], [3.0], [6.0]]), np.array([[0.5], [0.5], [-0.5]])
    >>> model = PractisedCrKR(
    ...     execute=execute, beyond=False, n_rollouts=90, random_state=0
    ... )
    >>> policies = model.fit(X, y, cost=execute(y, X)).predict([[1.5]])
    >>> bool(abs(policies[0, 0] - np.sin(1.5)) < 0.2), model.n_rollouts_
    (True, 90)
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "length_scale": [Interval(Real, 0, None, closed="neither")],
        "ridge": [Interval(Real, 0, None, closed="neither")],
        "tune": ["boolean"],
        "beyond": ["boolean"],
        "n_rollouts": [Interval(Integral, 0, None, closed="left")],
        "n_together": [Interval(Integral, 1, None, closed="left")],
        "random_state": RANDOM_STATE,
    }

    def __init__(
        self,
        workspace: Workspace | None = None,
        *,
        execute: Execute | None = None,
        length_scale: float = 1.0,
        ridge: float = 0.5,
        tune: bool = False,
        beyond: bool = True,
        n_rollouts: int = 500,
        n_together: int = N_TOGETHER,
        span: Span | None = None,
        dmp: DMP | None = None,
        random_state: RandomState = None,
    ) -> None:
        self.workspace = workspace
        self.execute = execute
        self.length_scale = length_scale
        self.ridge = ridge
        self.tune = tune
        self.beyond = beyond
        self.n_rollouts = n_rollouts
        self.n_together = n_together
        self.span = span
        self.dmp = dmp
        self.random_state = random_state

    def fit(self, X: Any, y: Any, cost: Any = None) -> Self:
        """Fit the regression, and practise.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.
        cost : array-like of shape (n_tasks,), default=None
            Positive cost of each policy; None: one for all.

        Returns
        -------
        PractisedCrKR
            The fitted regressor.

        Raises
        ------
        ValueError
            If a parameter is out of range, or a cost is not positive.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        costs = np.ones(len(X)) if cost is None else validate_cost(cost, len(X))
        trials = Trials(self.workspace, self.execute, self.dmp)
        rng = np.random.default_rng(seed_of(self.random_state))
        self._is_single_output = y.ndim == 1
        self._scaler = StandardScaler()
        targets = self._scaler.fit_transform(y.reshape(len(X), -1))
        start, tasks = X, X
        known = costs

        def weigh(tasks: Array, costs: Array) -> Array:
            if not self.beyond:
                return costs
            more = costs - usual_costs(start, known, tasks)
            return np.asarray(np.maximum(more, 0.0) + _FLOOR * known.mean())

        model = CrKR(self.length_scale, self.ridge, tune=self.tune, verbose=False)
        model.fit(tasks, targets, weigh(tasks, costs))
        given = model.length_scale_, model.ridge_
        while left := self.n_rollouts - trials.n_rollouts:
            new = draw_tasks(rng, min(left, self.n_together), start, self.span)
            mean, std = model.predict(new, return_std=True)
            drawn = mean + std[:, None] * rng.standard_normal(mean.shape)
            paid = trials(self._scaler.inverse_transform(drawn), new)
            tasks, targets = np.vstack([tasks, new]), np.vstack([targets, drawn])
            costs = np.append(costs, paid)
            model = CrKR(*given).fit(tasks, targets, weigh(tasks, costs))
        self.regressor_, self.n_rollouts_ = model, trials.n_rollouts
        self.tasks_, self.costs_ = tasks, costs
        self.policies_ = self._scaler.inverse_transform(targets)
        return self

    def predict(self, X: Any) -> Array:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Policies.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        found = self._scaler.inverse_transform(self.regressor_.predict(X))
        return np.asarray(found[:, 0] if self._is_single_output else found)
