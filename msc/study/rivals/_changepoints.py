"""A Gaussian process with change points: before and after one, values are unrelated."""

from __future__ import annotations

from itertools import pairwise, product
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Kernel, WhiteKernel
from sklearn.preprocessing import StandardScaler
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points
from msc.study.rivals._tuning import RANGES

Array = NDArray[np.float64]


class ChangePointProcess(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Regress on both sides of breaks that the likelihood finds.

    Attributes
    ----------
    change_points_ : ndarray of shape (n_change_points,)
        Tasks at which values change, ascending: half-way between training tasks.
    log_evidence_ : float
        Log probability of standardised policies, change points and hyper-parameters.
    regressors_ : list of 1 + n_change_points regressors
        A Gaussian process for each piece, its `kernel_` shared by all weights.
    n_features_in_ : int
        Number of task parameters: one.

    Notes
    -----
    The drastic change point of [1]_: within a piece the kernel is squared exponential,
    with hyper-parameters of the piece's own, and zero across a change point. It assumes
    that breaks are points, so that a task is one number, and that policy weights differ
    from one another independently.

    The probability of n tasks is then a product over pieces, and that of a piece comes
    from the Cholesky factor of any longer one with the same beginning. So the likeliest
    of all 2^(n - 1) divisions, with the likeliest setting of `RANGES` for each piece,
    is found exactly, by dynamic programming over where the last piece begins [2]_. In
    every gap a change is as likely as one in all of them, and every setting is as
    likely as another: a piece costs a factor of (n - 1) n_settings. Time grows as n^4:
    0.1 s for 100 tasks, 2.5 s for 360.

    Adapted: [1]_ weighs all hyper-parameters and places by their probability, for a
    series in time; here the likeliest count. Left out: its gradual changes and faults.

    References
    ----------
    .. [1] R. Garnett, M. A. Osborne, S. Reece, A. Rogers and S. J. Roberts, "Sequential
       Bayesian prediction in the presence of changepoints and faults", The Computer
       Journal 53, 2010.
    .. [2] P. Fearnhead, "Exact and efficient Bayesian inference for multiple
       changepoint problems", Statistics and Computing 16, 2006.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import ChangePointProcess
    >>> X = np.linspace(0, 6, 13)[:, np.newaxis]
    >>> model = ChangePointProcess().fit(X, np.sin(X[:, 0]) + 5 * (X[:, 0] > 4.2))
    >>> model.change_points_
    array([4.25])
    >>> model.predict([[4.2], [4.3]]).round(1)
    array([-0.9,  4.1])
    """

    def fit(self, X: Any, y: Any) -> Self:
        """Find change points and hyper-parameters.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Tasks (rad).
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.

        Returns
        -------
        ChangePointProcess
            The fitted process.

        Raises
        ------
        ValueError
            If a task has several parameters.
        """
        X, y = validate_pairs(self, X, y)
        if X.shape[1] > 1:
            raise ValueError(f"X has {X.shape[1]} features; wanted one to break along")
        order = np.argsort(X[:, 0], kind="stable")
        X = X[order]
        self._is_single_output = y.ndim == 1
        self._scaler = StandardScaler()
        targets = self._scaler.fit_transform(y.reshape(len(X), -1)[order])
        ranges = RANGES["change points"]
        settings, found = [], []
        for length_scale, noise in product(ranges["length_scale"], ranges["noise"]):
            given = X, targets, length_scale, noise, ranges["amplitude"]
            found += piece_evidence(*given)
            settings += [(length_scale, noise, one) for one in ranges["amplitude"]]
        best = np.argmax(found, axis=0)  # setting of each piece
        evidence = np.max(found, axis=0) - np.log(len(settings))
        self.log_evidence_, starts = best_division(evidence, np.diff(X[:, 0]))
        self.change_points_ = np.array(
            [(X[i - 1, 0] + X[i, 0]) / 2 for i in starts[1:]]
        )
        self.regressors_ = []
        for first, end in pairwise([*starts, len(X)]):
            kernel = to_kernel(*settings[best[first, end - 1]])
            model = GaussianProcessRegressor(kernel, optimizer=None)
            self.regressors_ += [model.fit(X[first:end], targets[first:end])]
        return self

    def predict(self, X: Any, return_std: bool = False) -> Array | tuple[Array, Array]:
        """Predict the policies of tasks.

        Parameters
        ----------
        X : array-like of shape (n_tasks, 1)
            Tasks (rad).
        return_std : bool, default=False
            Whether to return standard deviations too, noise included, as if it were
            sure where the change points are.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Predicted policies.
        std : ndarray of the same shape
            Their standard deviations; only if `return_std`.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        n_params = len(self._scaler.scale_)
        means, stds = np.empty((2, len(X), n_params))
        pieces = np.searchsorted(self.change_points_, X[:, 0])
        for piece in np.unique(pieces):
            here, model = pieces == piece, self.regressors_[piece]
            mean, std = model.predict(X[here], return_std=True)
            means[here] = mean.reshape(-1, n_params)
            stds[here] = std.reshape(-1, n_params)
        means, stds = self._scaler.inverse_transform(means), stds * self._scaler.scale_
        if self._is_single_output:
            means, stds = means[:, 0], stds[:, 0]
        return (means, stds) if return_std else means


def to_kernel(length_scale: float, noise: float, amplitude: float) -> Kernel:
    """Build the kernel of a piece."""
    white = WhiteKernel(amplitude * noise)
    return ConstantKernel(amplitude) * RBF(length_scale) + white


def piece_evidence(
    X: Array,
    targets: Array,
    length_scale: float,
    noise: float,
    amplitudes: list[float],
) -> list[Array]:
    """Return, for each amplitude, the log evidence of tasks i to j at [i, j]."""
    n_tasks, n_params = targets.shape
    gram = np.exp(-cdist(X, X, "sqeuclidean") / (2 * length_scale**2))
    gram += noise * np.eye(n_tasks)
    squares, log_dets = np.full((2, n_tasks, n_tasks), np.inf)
    for i in range(n_tasks):  # leading blocks of a factor are factors of the blocks
        factor = cholesky(gram[i:, i:], lower=True, check_finite=False)
        white = solve_triangular(factor, targets[i:], lower=True, check_finite=False)
        squares[i, i:] = (white**2).sum(axis=1).cumsum()
        log_dets[i, i:] = 2 * np.log(np.diag(factor)).cumsum()
    sizes = 1 + np.arange(n_tasks) - np.arange(n_tasks)[:, None]
    return [
        -0.5 * squares / amplitude
        - 0.5 * n_params * (log_dets + sizes * np.log(2 * np.pi * amplitude))
        for amplitude in amplitudes
    ]


def best_division(evidence: Array, gaps: Array) -> tuple[float, list[int]]:
    """Return the greatest log evidence of all divisions, and where its pieces begin."""
    n_tasks = len(evidence)
    cost = np.where(gaps > 0, np.log(max(n_tasks - 1, 1)), np.inf)
    before = np.zeros(n_tasks)  # of the best division of what lies before each task
    start = np.zeros(n_tasks, dtype=int)  # of the last piece, if it ends at each task
    value = 0.0
    for j in range(n_tasks):
        values = before[: j + 1] + evidence[: j + 1, j]
        start[j] = values.argmax()
        value = float(values[start[j]])
        if j + 1 < n_tasks:
            before[j + 1] = value - cost[j]
    starts = [int(start[-1])]
    while starts[0]:
        starts.insert(0, int(start[starts[0] - 1]))
    return value, starts
