"""Cost-regularized kernel regression: trust a training policy less, the more it cost.

One regression over all tasks, the baseline that charts are compared with.
"""

from __future__ import annotations

from functools import partial
from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils._param_validation import Interval
from sklearn.utils.validation import check_is_fitted

from msc._checks import (
    LENGTH_SCALE_BOUNDS,
    LENGTH_SCALES,
    MAGNITUDES,
    validate_cost,
    validate_pairs,
    validate_points,
    warn_of_scale,
)
from msc._parallel import tell
from msc.learn import validate_weights

Array = NDArray[np.float64]

_NOISES = (1e-6, 1e-3, 1e-1)  # ridge times mean cost; starts, as `LENGTH_SCALES`
_BOUNDS = (LENGTH_SCALE_BOUNDS, (1e-8, 1e3))  # of length scale and noise


class CrKR(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Kernel ridge regression whose ridge grows with each training sample's cost.

    Parameters
    ----------
    length_scale : float, default=1.0
        Width, > 0, of the kernel exp(-d^2 / (2 length_scale^2)); in radians for tasks
        in radians.
    ridge : float, default=0.5
        Weight, > 0, of the cost.
    tune : bool, default=False
        Whether to choose both by the data instead; see Notes.
    verbose : bool or None, default=None
        Whether tuning for more than about two seconds shows a progress bar on standard
        error: None where that is a terminal, True in a notebook too.

    Attributes
    ----------
    length_scale_, ridge_ : float
        The values in use: as given, or tuned.
    dual_coef_ : ndarray of shape (n_tasks, n_params) or (n_tasks,)
        Weights of the kernel at the training tasks.
    X_fit_ : ndarray of shape (n_tasks, n_task_params)
        The training tasks.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    With the kernel k, its matrix K over the training tasks, the policies Y as rows and
    C the diagonal matrix of costs ([1]_, Table I)::

        mean(x)     = k(x)' (K + ridge C)^-1 Y
        variance(x) = k(x, x) + ridge - k(x)' (K + ridge C)^-1 k(x)

    Far from all tasks the mean returns to zero; nothing is centred. The variance is in
    units of the kernel's, the same for all policy dimensions, and for a cost of one.

    Equal costs make this kernel ridge regression. The mean is that of a Gaussian
    process with noise variance ridge * cost. `tune` maximises its marginal likelihood,
    summed over the policy dimensions, each with the signal variance that suits it best
    (which cancels from the mean). L-BFGS-B starts where the
    search of the skill's own Gaussian processes does, at length scales 0.2, 0.7 and
    2.5, with the likeliest ridge * mean(cost) of 1e-6, 1e-3 and 0.1; the two are
    bounded by 0.01 and 100, and by 1e-8 and 1e3.

    References
    ----------
    .. [1] J. Kober, A. Wilhelm, E. Oztop and J. Peters, "Reinforcement learning to
       adjust parametrized motor primitives to new situations", Autonomous Robots 33,
       2012.

    Examples
    --------
    >>> import numpy as np
    >>> from msc import CrKR
    >>> tasks = np.linspace(0, 6, 30)[:, np.newaxis]
    >>> model = CrKR(tune=True).fit(tasks, np.sin(tasks[:, 0]))
    >>> bool(abs(model.predict([[1.5]]) - np.sin(1.5)) < 1e-3)
    True
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "length_scale": [Interval(Real, 0, None, closed="neither")],
        "ridge": [Interval(Real, 0, None, closed="neither")],
        "tune": ["boolean"],
        "verbose": ["boolean", None],
    }

    def __init__(
        self,
        length_scale: float = 1.0,
        ridge: float = 0.5,
        *,
        tune: bool = False,
        verbose: bool | None = None,
    ) -> None:
        self.length_scale = length_scale
        self.ridge = ridge
        self.tune = tune
        self.verbose = verbose

    def fit(self, X: Any, y: Any, cost: Any = None, sample_weight: Any = None) -> Self:
        """Fit the regression.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.
        cost : array-like of shape (n_tasks,), default=None
            Positive cost of each policy: the diagonal of C. None: one for all.
        sample_weight : array-like of shape (n_tasks,), default=None
            How often each task counts: its cost is divided by it, which makes the mean
            that of so many copies. Tasks of weight zero are left out.

        Returns
        -------
        CrKR
            The fitted regressor.

        Raises
        ------
        ValueError
            If a parameter is out of range, a cost is not positive or a weight negative.
        LinAlgError
            If the ridge is lost in rounding, so that no inverse exists.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        costs = np.ones(len(X)) if cost is None else validate_cost(cost, len(X))
        if sample_weight is not None:
            weights = validate_weights(sample_weight, len(X))
            counts = weights > 0
            X, y, costs = X[counts], y[counts], costs[counts] / weights[counts]
        self.X_fit_ = X.copy()
        self.length_scale_, self.ridge_ = float(self.length_scale), float(self.ridge)
        if self.tune:
            warn_of_scale(X)
            self.length_scale_, self.ridge_ = _tune(
                cdist(X, X, "sqeuclidean"), y.reshape(len(X), -1), costs, self.verbose
            )
        gram = self._kernel(X) + self.ridge_ * np.diag(costs)  # K + ridge C
        try:
            self._factor = cho_factor(gram, lower=True)
        except LinAlgError as error:
            error.args = (f"ridge={self.ridge_:g} is too small: increase it.",)
            raise
        self.dual_coef_ = cho_solve(self._factor, y)
        return self

    def predict(self, X: Any, return_std: bool = False) -> Array | tuple[Array, Array]:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        return_std : bool, default=False
            Whether to return standard deviations too.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Predicted policies.
        std : ndarray of shape (n_tasks,)
            Root of the variance, shared by all policy dimensions and in units of the
            kernel, whose value at equal tasks is 1, not of the policies; only if
            `return_std`.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        kernel = self._kernel(X)
        mean = np.asarray(kernel @ self.dual_coef_)
        if not return_std:
            return mean
        explained = (kernel * cho_solve(self._factor, kernel.T).T).sum(axis=1)
        return mean, np.sqrt(np.maximum(1.0 - explained, 0.0) + self.ridge_)

    def _kernel(self, X: Array) -> Array:
        squares = cdist(X, self.X_fit_, "sqeuclidean")
        return np.asarray(np.exp(-squares / (2 * self.length_scale_**2)))


def _tune(
    squares: Array, policies: Array, cost: Array, verbose: bool | None
) -> tuple[float, float]:
    """Return the length scale and ridge of greatest marginal likelihood."""
    relative_cost = cost / cost.mean()
    targets = policies[:, policies.any(axis=0)]  # zero everywhere: fits any kernel
    largest = np.abs(targets).max(axis=0)  # of no influence, but for their squares
    is_safe = (MAGNITUDES[0] <= largest) & (largest <= MAGNITUDES[1])
    targets = targets / np.where(is_safe, 1.0, largest)

    def objective(start: Array) -> tuple[float, Array]:
        return _negative_log_likelihood(start, squares, targets, relative_cost)

    def search(length_scale: float) -> Any:
        starts = (np.log([length_scale, noise]) for noise in _NOISES)
        start = min(starts, key=lambda one: objective(one)[0])
        bounds = np.log(_BOUNDS)
        return minimize(objective, start, jac=True, bounds=bounds, method="L-BFGS-B")

    searches = [partial(search, length_scale) for length_scale in LENGTH_SCALES]
    told = tell(searches, "starts of the search", n_tasks=len(targets), verbose=verbose)
    found = min(told, key=lambda optimum: optimum.fun)
    length_scale, noise = np.exp(found.x)
    return float(length_scale), float(noise / cost.mean())


def _negative_log_likelihood(
    log_parameters: Array, squares: Array, targets: Array, cost: Array
) -> tuple[float, Array]:
    """Return -log p(targets), signal variances at their best, and its gradient."""
    # Rasmussen and Williams, "Gaussian Processes for Machine Learning", 2006:
    length_scale, noise = np.exp(log_parameters)
    kernel = np.exp(-squares / (2 * length_scale**2))
    try:
        factor = cho_factor(kernel + noise * np.diag(cost), lower=True)
    except LinAlgError:  # too little noise for the doubles: as unlikely as can be
        return np.inf, np.zeros(2)
    weights = cho_solve(factor, targets)
    signal = (targets * weights).sum(axis=0) / len(targets)  # variance, closed form
    n_targets = targets.shape[1]
    value = 0.5 * len(targets) * np.log(signal).sum()
    value += n_targets * np.log(np.diag(factor[0])).sum()  # Eq. 5.8, but for constants
    # Eq. 5.9: d value / d gram, contracted with d gram / d log_parameters
    by_gram = n_targets * cho_solve(factor, np.eye(len(targets)))
    by_gram -= (weights / signal) @ weights.T
    by_length_scale = (by_gram * kernel * squares).sum() / length_scale**2
    by_noise = noise * (np.diag(by_gram) * cost).sum()
    return float(value), 0.5 * np.array([by_length_scale, by_noise])
