"""The methods that are compared: ours, its rivals, and what needs no learning."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.cluster import KMeans
from sklearn.compose import TransformedTargetRegressor
from sklearn.dummy import DummyRegressor
from sklearn.neighbors import KNeighborsRegressor
from sklearn.utils.validation import check_is_fitted, has_fit_parameter

from msc._checks import validate_cost, validate_pairs, validate_points
from msc.learn import SMCE, ParameterizedSkill, gaussian_process
from msc.study.rivals import CrKR

N_CHARTS = 4  # as the paper has in both workspaces
COMMON = (
    "charts",
    "single regression",
    "CrKr",
    "nearest neighbour",
    "linear interpolation",
    "mean policy",
    "zero policy",
)
VARIANTS = (  # of the charts and of the single regression: one part exchanged
    "charts, SVM gate",
    "charts, k-means",
    "charts, Matérn",
    "single, Matérn",
    "single, periodic",
)
METHODS = COMMON + VARIANTS

Array = NDArray[np.float64]


def methods(n_charts: int | None = N_CHARTS, seed: int = 0) -> dict[str, Any]:
    """List the methods, unfitted.

    Parameters
    ----------
    n_charts : int or None, default=4
        Charts that SMCE is asked for; None leaves it to the elbow. k-means, which has
        none, is then asked for four.
    seed : int, default=0
        Seed of the clustering, the one part that draws.

    Returns
    -------
    dict from str to estimator
        By name, each with `fit(X, y)` and `predict(X)`, tasks in radians:

        - "charts": `ParameterizedSkill` on the charts of `SMCE`;
        - "single regression": one squared-exponential Gaussian process a dimension,
          as in the paper;
        - "CrKr": cost-regularised kernel regression, both its parameters tuned;
        - "nearest neighbour": the policy of the nearest training task;
        - "linear interpolation": between the training tasks on either side;
        - "mean policy": the training policies' mean, whatever the task;
        - "zero policy": no weights, which leaves the arm to the DMP's spring;
        - "charts, SVM gate": the charts, and a support vector machine that tells which
          of them a task belongs to;
        - "charts, k-means": charts found by k-means among the policies;
        - "charts, Matérn": the charts, and a rougher kernel for their regressions;
        - "single, Matérn" and "single, periodic": the single regression with other
          kernels, see `gaussian_process`.

    Notes
    -----
    Gaussian processes and CrKr choose their hyper-parameters by marginal likelihood,
    with L-BFGS-B from the same length scales and noises, and length scales within the
    same bounds. A process's amplitude is bounded and its noise, of standardised
    targets, at most 1; CrKr's signal variance is free, its targets are not centred and
    its noise, relative to the signal, is at most 1e3. Both floors are 1e-8.

    Examples
    --------
    >>> list(methods())[:3]
    ['charts', 'single regression', 'CrKr']
    """
    charts = SMCE(n_charts, random_state=seed)
    return {
        "charts": ParameterizedSkill(charts, random_state=seed, verbose=False),
        "single regression": _single("squared exponential", seed),
        "CrKr": CrKR(tune=True, verbose=False),
        "nearest neighbour": KNeighborsRegressor(1),
        "linear interpolation": LinearInterpolation(),
        "mean policy": DummyRegressor(),
        "zero policy": TransformedTargetRegressor(
            DummyRegressor(),
            func=np.zeros_like,
            inverse_func=np.asarray,
            check_inverse=False,
        ),
        "charts, SVM gate": ParameterizedSkill(
            charts, gate="svm", random_state=seed, verbose=False
        ),
        "charts, k-means": ParameterizedSkill(
            KMeans(n_charts or N_CHARTS, n_init=10), random_state=seed, verbose=False
        ),
        "charts, Matérn": ParameterizedSkill(
            charts,
            regressor=gaussian_process("matern"),
            random_state=seed,
            verbose=False,
        ),
        "single, Matérn": _single("matern", seed),
        "single, periodic": _single("periodic", seed),
    }


def fit_methods(
    X: ArrayLike,
    y: ArrayLike,
    cost: ArrayLike,
    *,
    n_charts: int | None = N_CHARTS,
    seed: int = 0,
    names: Iterable[str] = METHODS,
) -> dict[str, Any]:
    """Fit methods to the same training set.

    Parameters
    ----------
    X : array_like of shape (n_tasks, 1)
        Tasks (rad).
    y : array_like of shape (n_tasks, n_params)
        Their policies.
    cost : array_like of shape (n_tasks,)
        What the search paid for each, positive. A method that trusts costly samples
        less is given cost / mean(cost), which is one on average.
    n_charts, seed : int
        See `methods`.
    names : iterable of str, default=METHODS
        Which methods.

    Returns
    -------
    dict from str to estimator
        The fitted methods, in the order of `names`.

    Raises
    ------
    ValueError
        If a method is unknown, or the costs are not positive, one a task.

    Examples
    --------
    >>> X, y = np.array([[0.0], [2.0], [4.0]]), np.array([[0.0], [1.0], [5.0]])
    >>> fitted = fit_methods(X, y, np.ones(3), names=["linear interpolation"])
    >>> fitted["linear interpolation"].predict([[3.0]])
    array([[3.]])
    """
    known, wanted = methods(n_charts, seed), tuple(names)
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise ValueError(f"names={unknown} are no methods; wanted some of {METHODS}")
    costs = validate_cost(cost, len(np.asarray(X)))
    fitted = {}
    for name in wanted:
        takes_cost = has_fit_parameter(known[name], "cost")
        given = {"cost": costs / costs.mean()} if takes_cost else {}
        fitted[name] = known[name].fit(np.asarray(X), np.asarray(y), **given)
    return fitted


class LinearInterpolation(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Interpolate between the training tasks on either side.

    Before the first training task its policy holds, after the last one the last's. Of
    equal tasks the mean policy counts.

    Attributes
    ----------
    tasks_ : ndarray of shape (n_tasks,)
        The different training tasks, ascending.
    policies_ : ndarray of shape (n_tasks, n_params) or (n_tasks,)
        Their policies.
    n_features_in_ : int
        Number of task parameters: one.

    Examples
    --------
    >>> model = LinearInterpolation().fit([[0.0], [2.0]], [[0.0, 1.0], [4.0, 1.0]])
    >>> model.predict([[-1.0], [0.5], [3.0]])
    array([[0., 1.],
           [1., 1.],
           [4., 1.]])
    """

    def fit(self, X: Any, y: Any) -> Self:
        """Keep the training set."""
        X, y = validate_pairs(self, X, y)
        if X.shape[1] > 1:
            raise ValueError(f"X has {X.shape[1]} features; wanted one to walk along")
        self.tasks_, place = np.unique(X[:, 0], return_inverse=True)
        times = np.bincount(place).reshape(-1, *(1,) * (y.ndim - 1))
        sums = np.zeros((len(self.tasks_), *y.shape[1:]))
        np.add.at(sums, place, y)
        self.policies_ = sums / times
        return self

    def predict(self, X: Any) -> Array:
        """Predict the policies of tasks, in the shape that `fit` was given."""
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        columns = self.policies_.reshape(len(self.tasks_), -1).T
        found = [np.interp(X[:, 0], self.tasks_, column) for column in columns]
        return np.stack(found, axis=-1).reshape(len(X), *self.policies_.shape[1:])


def _single(kernel: str, seed: int) -> ParameterizedSkill:
    """Build one Gaussian process a policy dimension, over all tasks."""
    return ParameterizedSkill(
        None, regressor=gaussian_process(kernel), random_state=seed, verbose=False
    )
