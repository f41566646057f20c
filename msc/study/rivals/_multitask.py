"""One policy for all tasks, searched on what it costs on their average."""

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
from msc.search import SearchOptions, minimize
from msc.study.rivals._trials import Execute, Span, Trials, cosines

Array = NDArray[np.float64]


class MultiTaskSearch(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Search one function from tasks to policies, on its mean cost over tasks.

    After Deisenroth, Englert, Peters and Fox: without a model.

    Parameters
    ----------
    workspace : Workspace, optional
        Where to execute; by default ``Workspace.free()``.
    execute : callable, optional
        Executes in its place: policies of shape (n, n_params) and tasks of shape (n,
        n_task_params) give n costs.
    n_features : int, default=8
        Features of a task's first number; each further one has one more.
    from_policies : bool, default=True
        Whether to begin at the least-squares fit to the training policies, with a small
        first step, instead of at zero with a wide one.
    step : float, default=None
        Standard deviation, > 0, of the first policies, over all tasks and around the
        first function. None: as in searches of one task.
    n_rollouts : int, default=20000
        Trials, at most: what searches of some twenty tasks from scratch take.
    span : tuple of (float, float), default=(0, 2 pi)
        Bounds of tasks, between which features are orthonormal (rad); where tasks have
        several numbers, two rows of bounds.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    random_state : int, RandomState instance, Generator or None, default=None
        Draws of the search.

    Attributes
    ----------
    coef_ : ndarray of shape (n_params, n_all_features)
        The function: the cheapest that was executed.
    mean_cost_ : float
        Its cost, mean over the training tasks.
    n_rollouts_ : int
        Rollouts spent, not counting searches of the training set.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    As in [1]_ there is one policy, a function of the task as well, and its parameters
    are what is searched, on the mean over the training tasks of what an episode costs::

        policy(x) = coef_ f(x),  min over coef_ of mean_i cost(coef_ f(x_i), x_i)

    by CMA-ES, with its surrogate, as a policy of one task is. Here a trial is a whole
    function and takes as many rollouts as there are training tasks. Nothing tells which
    task a trial failed at, and 48 numbers are searched together.

    The features are cosines over the circle that is cut open, f_0 = 1 and
    f_k = sqrt(2) cos(k x / 2). They are orthonormal over tasks, so that the mean cost
    is as well conditioned in `coef_` as one task's cost in its policy, which radial
    basis functions, that overlap, would not have it; they have no width to tune; and
    they are not periodic: at the cut policies jump. Of further numbers of a task there
    is the first cosine each, which adds to those of the angle.

    Adapted: the original's function is of the state as well, with radial basis
    functions, where a DMP has the state in it; the search may begin at the searched
    policies, which the original does not have. Left out: its model, Gaussian processes
    of the dynamics learned from few rollouts, on which costs and gradients of them are
    computed. It would spend rollouts by the tens, not thousands, where a contact with
    an obstacle can be modelled so.

    References
    ----------
    .. [1] M. P. Deisenroth, P. Englert, J. Peters and D. Fox, "Multi-task policy search
       for robotics", IEEE International Conference on Robotics and Automation, 2014.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import MultiTaskSearch
    >>> def execute(policies, X):
    ...     return (policies[:, 0] - 3 * np.cos(X[:, 0])) ** 2
    >>> X = np.linspace(0.5, 5.5, 6)[:, np.newaxis]
    >>> search = MultiTaskSearch(
    ...     execute=execute, n_features=3, from_policies=False, step=1, random_state=0
    ... )
    >>> search.fit(X, np.zeros((6, 1))).predict([[0.0], [np.pi / 2]]).round(2) + 0
    array([[3.], [0.]])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "n_features": [Interval(Integral, 1, None, closed="left")],
        "from_policies": ["boolean"],
        "step": [Interval(Real, 0, None, closed="neither"), None],
        "n_rollouts": [Interval(Integral, 1, None, closed="left")],
        "random_state": RANDOM_STATE,
    }

    def __init__(
        self,
        workspace: Workspace | None = None,
        *,
        execute: Execute | None = None,
        n_features: int = 8,
        from_policies: bool = True,
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
        """Search the function.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params)
            Policies; only their number of weights counts unless `from_policies`.

        Returns
        -------
        MultiTaskSearch
            The fitted function.

        Raises
        ------
        ValueError
            If tasks have not as many numbers as the span bounds, or the budget is less
            than what a generation of the search may take.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        if y.ndim == 1:
            raise ValueError(f"y has shape {y.shape}; wanted (n_tasks, n_params)")
        seen, n_params = cosines(X, self.n_features, self.span), y.shape[1]
        trials = Trials(self.workspace, self.execute, self.dmp)
        start = np.zeros((n_params, seen.shape[1]))
        if self.from_policies:
            start = np.linalg.lstsq(seen, y, rcond=None)[0].T
        population = 4 + int(3 * np.log(start.size))  # CMA-ES's own rule
        most = self.n_rollouts // len(X) - population
        if most < 1:
            raise ValueError(
                f"n_rollouts={self.n_rollouts}; wanted at least "
                f"{(population + 1) * len(X)}, a generation on {len(X)} tasks"
            )

        def costs(functions: Array) -> list[float]:
            coefs = functions.reshape(len(functions), n_params, -1)
            policies = np.einsum("cpf,tf->ctp", coefs, seen).reshape(-1, n_params)
            paid = trials(policies, np.tile(X, (len(functions), 1)))
            return paid.reshape(len(functions), -1).mean(axis=1).tolist()  # type: ignore[no-any-return]

        root = np.kron(trials.spread(X, n_params), np.eye(seen.shape[1]))
        options = SearchOptions(
            max_evaluations=most,
            population=population,
            stalled=most,  # it is the budget that ends it
        )
        step = self.step or trials.first_step(self.from_policies)
        found = minimize(
            costs,
            start.ravel(),
            step / np.sqrt(seen.shape[1]),  # features' squares sum to n_features
            np.random.default_rng(seed_of(self.random_state)),
            np.asarray(root, dtype=np.float64),
            options=options,
        )
        self.coef_ = found.policy.reshape(n_params, -1)
        self.mean_cost_, self.n_rollouts_ = found.cost, trials.n_rollouts
        return self

    def predict(self, X: Any) -> Array:
        """Evaluate the function.

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
