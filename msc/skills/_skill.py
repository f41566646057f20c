"""A skill that takes tasks, and gives policies, in the units of a table."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from numbers import Integral
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from sklearn import config_context
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.exceptions import DataConversionWarning
from sklearn.neighbors import NearestNeighbors
from sklearn.utils import gen_batches
from sklearn.utils._param_validation import Interval, StrOptions
from sklearn.utils.validation import check_is_fitted, has_fit_parameter

from msc._checks import (
    RANDOM_STATE,
    RandomState,
    check_magnitude,
    seed_of,
    validate_cost,
    validate_pairs,
    validate_points,
)
from msc.learn import ParameterizedSkill, validate_weights
from msc.skills._methods import METHODS, PAPER
from msc.skills._scale import DECIMALS, TaskScale
from msc.skills._subsample import spread_out
from msc.skills._trees import quicken

Array = NDArray[np.float64]
Charts = NDArray[np.intp]

N_VOTES = 5
"""Nearest training tasks that tell how sure a chart is."""

_BATCH = 4096  # tasks that are predicted at once


class TableSkill(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Learn policies of tasks whose columns have any units.

    Parameters
    ----------
    method : str, default="charts"
        What learns, a name of `METHODS`; by default the paper's.
    periods : mapping from str or int to float, optional
        After which a task column comes round again, by its name, or its number where
        columns have none; in its own unit, as ``{"angle": 360}``.
    units : mapping from str to str, optional
        What the units of columns are called; only kept, for those who use the skill.
    max_tasks : int, default=500
        Of more training tasks, methods other than neighbours and trees learn so many,
        spread over all and drawn by the seed.
    random_state : int, RandomState instance, Generator or None, default=None
        Seed of all that is drawn. None draws fresh entropy; NumPy's global generator is
        left alone.

    Attributes
    ----------
    scale_ : estimator
        How task columns become points: of unit spread, periodic ones on circles.
    centers_, spreads_ : ndarray of shape (n_params,)
        Mean and standard deviation of each policy column. The method learns policies
        of mean zero and unit spread, so that it does not depend on their units either.
    model_ : estimator
        The method, fitted.
    voters_ : NearestNeighbors or None
        Finds the training tasks that tell how sure a chart is, if there are charts.
    doubt_ : estimator or None
        Knows how far apart neighbours' policies are, and what that means; `fit_table`
        makes it, from tasks left out.
    rows_ : ndarray of int
        Which training tasks the method has learned.
    policy_names_ : list of str or None
        Names of the policy columns, if `y` had some.
    n_features_in_ : int
        Number of task columns.

    Notes
    -----
    A column's spread is its standard deviation over the training tasks, on a circle the
    angular deviation, which does not depend on where the circle begins. With it
    distances of tasks, of which all methods but trees and the mean make use, are those
    of columns that count alike; so are distances of policies, by which charts are
    found.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.skills import TableSkill
    >>> degrees = np.arange(0.0, 360.0, 10.0)[:, np.newaxis]
    >>> policies = np.cos(np.radians(degrees))
    >>> skill = TableSkill("single regression", periods={0: 360.0}, random_state=0)
    >>> skill.fit(degrees, policies).predict([[-5.0], [355.0]]).round(3).ravel()
    array([0.996, 0.996])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "method": [StrOptions(set(METHODS))],
        "periods": [Mapping, None],
        "units": [Mapping, None],
        "max_tasks": [Interval(Integral, 10, None, closed="left")],
        "random_state": RANDOM_STATE,
    }

    def __init__(
        self,
        method: str = PAPER,
        *,
        periods: Mapping[Any, float] | None = None,
        units: Mapping[str, str] | None = None,
        max_tasks: int = 500,
        random_state: RandomState = None,
    ) -> None:
        self.method = method
        self.periods = periods
        self.units = units
        self.max_tasks = max_tasks
        self.random_state = random_state

    def fit(self, X: Any, y: Any, cost: Any = None, sample_weight: Any = None) -> Self:
        """Learn from solved tasks.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, each column in a unit of its own.
        y : array-like or DataFrame of shape (n_tasks, n_params) or (n_tasks,)
            The policy that solved each.
        cost : array-like of shape (n_tasks,), optional
            What was paid for each, positive; "CrKr" trusts costly ones less.
        sample_weight : array-like of shape (n_tasks,), optional
            How much each task counts, for the methods that take weights: the mean,
            "CrKr" and trees. Scales are those of all tasks alike.

        Returns
        -------
        TableSkill
            The fitted skill.

        Raises
        ------
        ValueError
            If a parameter is unknown, a period is not positive or of no column, the
            data are not finite or not as the method needs them, or it takes no weights.
        """
        self._validate_params()
        names = getattr(y, "columns", None)
        X, y = validate_pairs(self, X, y)
        check_magnitude("X", X)
        check_magnitude("y", y)
        self.policy_names_ = None if names is None else [str(name) for name in names]
        self._is_single_output = y.ndim == 1
        policies = y.reshape(len(X), -1)
        learner, seed = METHODS[self.method], seed_of(self.random_state)
        self.scale_ = TaskScale(self._read_periods(X.shape[1])).fit(X)
        self.centers_, self.spreads_ = policies.mean(axis=0), policies.std(axis=0)
        largest = np.abs(policies).max(axis=0)
        self.spreads_[self.spreads_ <= 1e-12 * largest] = 1.0
        self.rows_ = np.arange(len(X))
        if not learner.takes_all:
            self.rows_ = spread_out(self.scale_.transform(X), self.max_tasks, seed)
        tasks = X[self.rows_]
        if learner.is_flat:
            points, own = self.scale_.unroll(tasks)
        else:
            points, own = self.scale_.transform(tasks), np.arange(len(tasks))
        targets = (policies - self.centers_) / self.spreads_
        targets = targets.round(DECIMALS)[self.rows_][own]
        model, told = learner.build(len(points), seed), {}
        if cost is not None and has_fit_parameter(model, "cost"):
            costs = validate_cost(cost, len(X))[self.rows_][own]
            told["cost"] = costs / costs.mean()
        if sample_weight is not None:
            weights = self._read_weights(sample_weight, len(X))
            told["sample_weight"] = weights[self.rows_]
        # Weights are for the method, whatever its parts ask to be given.
        with config_context(enable_metadata_routing=False), warnings.catch_warnings():
            warnings.simplefilter("ignore", DataConversionWarning)  # a column is one
            self.model_ = model.fit(points, targets, **told)
        self.doubt_: Any = None
        self.voters_ = None
        if isinstance(model, ParameterizedSkill) and model.n_charts_ > 1:
            n_votes = min(N_VOTES, len(points))
            self.voters_ = NearestNeighbors(n_neighbors=n_votes).fit(points)
        return self

    def _read_weights(self, sample_weight: Any, n_tasks: int) -> Array:
        """Return the weights, if the method takes some."""
        if not METHODS[self.method].takes_weights:
            some = [name for name, one in METHODS.items() if one.takes_weights]
            raise ValueError(
                f"method={self.method!r} takes no sample_weight: leave weights out, "
                f"or wanted one of {some}"
            )
        return validate_weights(sample_weight, n_tasks)

    def _read_periods(self, n_columns: int) -> tuple[float | None, ...]:
        """Return the period of each column, or None."""
        known = [*getattr(self, "feature_names_in_", range(n_columns))]
        given = dict(self.periods or {})
        for name, period in given.items():
            if name not in known:
                raise ValueError(f"periods: {name!r} is no column; there are {known}")
            if not 0 < period < np.inf:
                raise ValueError(f"periods[{name!r}]={period}; wanted it positive")
        return tuple(float(given[name]) if name in given else None for name in known)

    def predict(self, X: Any, return_std: bool = False) -> Any:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.
        return_std : bool, default=False
            Whether to return standard deviations, too.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Predicted policies, in the units of `fit`.
        std : ndarray of the same shape
            Their standard deviations, the policies' noise included; NaN where the
            method has none. Only if `return_std`.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        means, stds = np.empty((2, len(X), len(self.centers_)))
        model = quicken(self.model_, len(X))
        for some, points in self._batches(X, METHODS[self.method].is_flat):
            if return_std and self.has_std:
                found, stds[some] = model.predict(points, return_std=True)
            else:
                found, stds[some] = model.predict(points), np.nan
            means[some] = np.reshape(found, (len(points), -1))
        means, stds = self.centers_ + self.spreads_ * means, self.spreads_ * stds
        if self._is_single_output:
            means, stds = means[:, 0], stds[:, 0]
        return (means, stds) if return_std else means

    @property
    def has_std(self) -> bool:
        """Whether the method knows how sure it is of a policy."""
        return METHODS[self.method].has_std

    def predict_chart(self, X: Any) -> tuple[Charts, Array]:
        """Tell which chart each task belongs to, and how sure that is.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.

        Returns
        -------
        charts : ndarray of int of shape (n_tasks,)
            From 0 on; 0 for all where there is one chart, or the method has none.
        probability : ndarray of shape (n_tasks,)
            Of the five nearest training tasks the share that is on this chart.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        charts, shares = np.zeros(len(X), dtype=np.intp), np.ones(len(X))
        if self.voters_ is not None:
            for some, points in self._batches(X):
                charts[some] = self.model_.predict_chart(points)
                near = self.voters_.kneighbors(points, return_distance=False)
                votes = self.model_.charts_[near] == charts[some, None]
                shares[some] = votes.mean(axis=1)
        return charts, shares

    def predict_band(self, X: Any) -> Array:
        """Tell how far from their predictions nine in ten policies lie, at most.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.

        Returns
        -------
        ndarray of shape (n_tasks, n_params)
            Half the width of conformal bands, in the policies' units: of each column,
            nine in ten tasks that lie among the training tasks as these do are within.
            NaN if `doubt_` is missing, or knows too few errors.
        """
        return self.predict_doubt(X)[0]

    def find_doubtful(self, X: Any) -> NDArray[np.bool_]:
        """Tell where the nearest training tasks have policies far apart.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.

        Returns
        -------
        ndarray of bool of shape (n_tasks,)
            Whether they are farther apart than those of nine in ten training tasks, on
            average over columns of unit spread; none is if `doubt_` is missing.
        """
        return self.predict_doubt(X)[1]

    def predict_doubt(self, X: Any) -> tuple[Array, NDArray[np.bool_]]:
        """Give bands and flags at once: neighbours are asked once for both.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.

        Returns
        -------
        halves : ndarray of shape (n_tasks, n_params)
            What `predict_band` returns.
        doubtful : ndarray of bool of shape (n_tasks,)
            What `find_doubtful` returns.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        halves = np.full((len(X), len(self.centers_)), np.nan)
        doubtful = np.zeros(len(X), dtype=bool)
        if self.doubt_ is not None:
            for some, points in self._batches(X):
                apart = self.doubt_.measure(points)
                halves[some] = self.doubt_.halves_ * apart * self.spreads_
                doubtful[some] = apart.mean(axis=1) > self.doubt_.limit_
        return halves, doubtful

    def find_outside(self, X: Any) -> NDArray[np.bool_]:
        """Tell which tasks lie outside the range of the training tasks.

        Parameters
        ----------
        X : array-like or DataFrame of shape (n_tasks, n_task_params)
            Tasks, in the units of `fit`.

        Returns
        -------
        ndarray of bool of shape (n_tasks, n_task_params)
            By task and column. Of a periodic column only a gap of more than a quarter
            of the period, without a training task, is outside.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        return np.asarray(self.scale_.find_outside(X))

    def _batches(self, X: Array, flat: bool = False) -> Iterator[tuple[slice, Array]]:
        """Give tasks as the method sees them, some at a time."""
        see = self.scale_.flatten if flat else self.scale_.transform
        for some in gen_batches(len(X), _BATCH):
            yield some, see(X[some])
