"""Gaussian processes as the learners use them: kernels, bounds, and their search."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.linalg import eigh, solve_triangular, svd
from scipy.linalg.lapack import dpstrf
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessClassifier, GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    RBF,
    ConstantKernel,
    ExpSineSquared,
    Kernel,
    Matern,
    Product,
    Sum,
    WhiteKernel,
)
from sklearn.utils import gen_batches
from sklearn.utils.validation import validate_data

from msc._checks import LENGTH_SCALE_BOUNDS, LENGTH_SCALES

Array = NDArray[np.float64]

_CLOSE = 1e-4  # of log length scales: as good as equal
_FLAT = 1e-6  # differences of a log likelihood that says nothing
_ROUNDS = 30  # of the search, at most
_HOPELESS = 100.0  # log likelihoods: not looked for beyond, if it gets worse
_NEAR = 2.0  # log likelihoods: a second best optimum may turn out the best
_CELL = 0.16  # of log length scales: how close one looks where it is likely
_END = 0.05  # how far from an end of the search a least within is sought
_RATIOS = 43  # of noise to amplitude that are tried first: three a decade
_CONSTANT = 10 * np.finfo(float).eps  # of a mean: a spread that rounding makes
_SAMPLE = 512  # tasks among which nodes of a kernel are sought first
_ROUNDING = 1e-15  # of a kernel whose value at equal tasks is 1
_FAR = 1e-10  # of a task's variance: known nodes say all but so little
_BATCH = 4096  # tasks that are predicted at once


def gaussian_process(kernel: str = "squared exponential") -> GaussianProcess:
    """Build the regression each chart and policy dimension gets by default.

    Parameters
    ----------
    kernel : {"squared exponential", "matern", "periodic"}
        How alike two tasks' policies are, with their distance d and a length scale l:
        exp(-d²/2l²), infinitely smooth; the Matérn kernel of order 3/2,
        (1 + √3 d/l) exp(-√3 d/l), smooth once; or exp(-2 sin²(d/2)/l²), whose period
        of 2π closes the circle of the task angle, the first number: of others it is
        the squared exponential, by which that is multiplied.

    Returns
    -------
    GaussianProcess
        Unfitted; a scikit-learn GaussianProcessRegressor of amplitude times kernel plus
        white noise, on standardised targets.

    Raises
    ------
    ValueError
        If the kernel is another.

    Notes
    -----
    Bounds, for tasks in radians and targets of unit variance:

    - length scale 0.01 to 100: from half a degree, finer than any grid worth
      searching, to sixteen turns, over which everything is a straight line;
    - amplitude (a variance) 1e-3 to 1e3: a long length scale needs a large one to show
      any slope;
    - noise 1e-8 to 1: from a policy search's own precision to nothing but noise.

    Hyper-parameters maximise the marginal likelihood. With one decomposition of the
    kernel's matrix, the best amplitude and noise of a length scale cost next to
    nothing, so that only the length scale is sought: on a grid from 0.2 over 0.7 to
    2.5, outwards until the likelihood changes no more or is hopeless, then nearer and
    nearer to where curves through these are highest. Nothing is random. Each kernel
    falls off over about one length scale, so that bounds and starts serve all three.

    The matrix of a smooth kernel on few task dimensions has few eigenvalues that are
    not lost in rounding (on a turn some 13 over the length scale), however many tasks
    there are: 10,000 take seconds. Those of the Matérn kernel, and of very short length
    scales, all count: time grows with the cube of the number, about 2 s for 1000.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.learn import gaussian_process
    >>> tasks = np.linspace(0, 6, 30)[:, np.newaxis]
    >>> model = gaussian_process().fit(tasks, np.sin(tasks[:, 0]))
    >>> bool(abs(model.predict([[1.5]]) - np.sin(1.5)) < 1e-3)
    True
    """
    if kernel not in _KERNELS:
        raise ValueError(f"kernel={kernel!r}; wanted one of {tuple(_KERNELS)}")
    amplitude = ConstantKernel(1.0, (1e-3, 1e3))
    return GaussianProcess(
        amplitude * _KERNELS[kernel]() + WhiteKernel(1e-3, (1e-8, 1.0)),
        normalize_y=True,
        optimizer=_refine,
    )


def gaussian_classifier() -> GaussianProcessClassifier:
    """Build the gate called "gp": squared exponential, bounds as for the regression."""
    return _BoundedClassifier(
        ConstantKernel(1.0, (1e-3, 1e3)) * RBF(1.0, LENGTH_SCALE_BOUNDS),
        optimizer=_refine,
    )


class Periodic(ExpSineSquared):  # type: ignore[misc]
    """scikit-learn's periodic kernel of the first number of a turn, times others'.

    Points (cos, sin) of a circle of radius one lie 2 sin(d/2) apart, so that of the
    first number alone it is a squared exponential of these. With others beside them it
    is positive definite as well, which that of a distance in all numbers is not.
    """

    def __call__(self, X: Any, Y: Any = None, eval_gradient: bool = False) -> Any:
        """Return the kernel's matrix, and its gradient."""
        X = np.atleast_2d(X)
        if X.shape[1] == 1:
            return super().__call__(X, Y, eval_gradient)
        others = None if Y is None else _roll(Y)
        rolled = RBF(self.length_scale, self.length_scale_bounds)
        return rolled(_roll(X), others, eval_gradient)


def _roll(X: Any) -> Array:
    """Replace an angle, the first number, by its point on a circle."""
    angles, others = np.split(np.asarray(X, dtype=np.float64), [1], axis=1)
    return np.hstack([np.cos(angles), np.sin(angles), others])


_KERNELS: dict[str, Callable[[], Kernel]] = {
    "squared exponential": lambda: RBF(1.0, LENGTH_SCALE_BOUNDS),
    "matern": lambda: Matern(1.0, LENGTH_SCALE_BOUNDS, nu=1.5),
    "periodic": lambda: Periodic(1.0, 2 * np.pi, LENGTH_SCALE_BOUNDS, "fixed"),
}


class _AtBounds:
    """Let hyper-parameters rest on their bounds without a warning: they are answers."""

    # Data without noise push the noise to its floor, a constant policy the amplitude,
    # a straight chart the length scale to its ceiling.

    def fit(self, X: Any, y: Any) -> Self:
        with warnings.catch_warnings():
            message = ".*is close to the specified"
            warnings.filterwarnings("ignore", message, ConvergenceWarning)
            super().fit(X, y)  # type: ignore[misc]
        return self


class _BoundedClassifier(_AtBounds, GaussianProcessClassifier):  # type: ignore[misc]
    pass


class GaussianProcess(_AtBounds, GaussianProcessRegressor):  # type: ignore[misc]
    """scikit-learn's regression, and the faster for the kernels of `gaussian_process`.

    It has no `L_` and no `alpha_` then: there is no factor of the whole matrix. With
    another kernel, another optimizer, or several targets at once, it is scikit-learn's
    own.
    """

    _eigen: Any = None  # an _Eigen, if fitted here

    def fit(self, X: Any, y: Any) -> Self:
        """Fit as scikit-learn's does."""
        if np.ndim(y) > 1 or not self.is_quick():
            self._eigen = None
            return super().fit(X, y)
        X, y = validate_data(self, X, y, y_numeric=True, dtype=np.float64)
        X = np.copy(X) if self.copy_X_train else X
        return fit_together([self], X, y[:, None])[0]

    def predict(
        self, X: Any, return_std: bool = False, return_cov: bool = False
    ) -> Any:
        """Predict as scikit-learn's does."""
        if self._eigen is None or (return_std and return_cov):  # both: an error
            return super().predict(X, return_std, return_cov)
        X = validate_data(self, X, reset=False, dtype=np.float64)
        ((means, stds),) = predict_together([self], X, return_std)
        if return_cov:
            amplitude, _, noise = np.exp(self.kernel_.theta)
            inside, outside = self._split(X)
            explained = (inside / self._damped) @ inside.T
            explained += outside @ outside.T / self._ratio
            cov = amplitude * (self.kernel_.k1.k2(X) - explained)
            cov[np.diag_indices_from(cov)] += noise
            return means, self._y_train_std**2 * cov
        return (means, stds) if return_std else means

    def _rows(self, X: Array) -> Array:
        """Return rows of which each times `_Eigen.turn` is k(x)'U."""
        rows = self.kernel_.k1.k2(X, self._eigen.nodes)
        if self._eigen.root is None:
            return np.asarray(rows)
        return np.asarray(solve_triangular(self._eigen.root, rows.T, lower=True).T)

    def _standardised(
        self, X: Array, rows: Array, squares: Array | None
    ) -> tuple[Array, Array]:
        """Return means of standardised targets, and variances over the amplitude."""
        _, vectors, _, root, turn = self._eigen
        means = variances = rows @ (turn @ self._weights)
        if squares is not None:
            variances = 1.0 - squares @ (1 / self._damped)
        far = (rows**2).sum(axis=1) < 1.0 - _FAR
        if root is not None and far.any():  # from all nodes: rounding would be felt
            inside, outside = self._split(X[far])
            rest = self.y_train_ - vectors @ (self._damped * self._weights)
            means[far] = inside @ self._weights + outside @ rest / self._ratio
            if squares is not None:
                explained = inside**2 @ (1 / self._damped)
                explained += (outside**2).sum(axis=1) / self._ratio
                variances[far] = 1.0 - explained
        return means, variances

    def _split(self, X: Array) -> tuple[Array, Array]:
        """Return k(x)'U, and what of k(x)' the vectors U do not reach."""
        rows = self.kernel_.k1.k2(X, self.X_train_)
        inside = rows @ self._eigen.vectors
        return inside, rows - inside @ self._eigen.vectors.T

    @property
    def is_decomposed(self) -> bool:
        """Whether it was fitted by `fit_together`, not by scikit-learn."""
        return self._eigen is not None

    def is_quick(self) -> bool:
        """Whether the kernel is amplitude times one length scale's, plus noise.

        And whether nothing else is asked for that only scikit-learn does.
        """
        if self.optimizer not in (None, _refine) or self.n_restarts_optimizer:
            return False
        if self.n_targets not in (None, 1):
            return False
        match self.kernel:
            case Sum(
                k1=Product(k1=ConstantKernel() as a, k2=RBF() | ExpSineSquared() as b),
                k2=WhiteKernel() as c,
            ):
                free = [part.n_dims for part in (a, b, c)] == [1, 1, 1]
                return free and bool(self.normalize_y) and np.ndim(self.alpha) == 0
        return False


def fit_together(
    processes: list[GaussianProcess], X: Array, Y: Array, *, shared: bool = False
) -> list[GaussianProcess]:
    """Fit processes of the same parameters to a column of Y each, as if all alone.

    Or let them share length scale and ratio of noise to amplitude: those under which
    all columns together are the likeliest, but for constant ones, whatever predicts
    these.
    """
    first = processes[0]
    first._validate_params()
    bounds = first.kernel.bounds
    if first.optimizer is None:
        bounds = np.column_stack([first.kernel.theta] * 2)
    box = np.exp(bounds)[[0, 2]] + [[0.0], [first.alpha]]  # alpha adds to the noise

    # Target by target, each a row: sums and products round as shapes have it.
    targets = np.ascontiguousarray(Y.T)
    mean, spread = targets.mean(axis=1), targets.std(axis=1)
    varies = spread > _CONSTANT * np.abs(mean)
    spread[~varies] = 1.0
    targets = (targets - mean[:, None]) / spread[:, None]
    some_vary = varies.any() and not varies.all()
    together = (varies if some_vary else slice(None)) if shared else None

    @cache
    def look(at: float) -> tuple[_Eigen, Array, Array, Array, Array]:
        eigen = _decompose(first.kernel.k1.k2.clone_with_theta([at]), X)
        z = np.array([eigen.vectors.T @ y for y in targets])
        apart = [y - eigen.vectors @ one for y, one in zip(targets, z, strict=True)]
        rest = (np.array(apart) ** 2).sum(axis=1)
        found = _profile(eigen.values, z.T**2, rest, len(X), box, together=together)
        return eigen, z, *found

    def unlikely_at(at: float, some: Any) -> float:
        return float(look(at)[2][some].sum())

    for k, process in enumerate(processes):
        if k == 0 or not shared:
            some = together if shared else slice(k, k + 1)
            at = _search(partial(unlikely_at, some=some), *bounds[1])
        eigen, z, unlikely, amplitude, ratio = look(at)
        noise = max(ratio[k] * amplitude[k] - first.alpha, np.finfo(float).tiny)
        theta = [np.log(amplitude[k]), at, np.log(noise)]
        process.kernel_ = first.kernel.clone_with_theta(np.clip(theta, *bounds.T))
        process.log_marginal_likelihood_value_ = -float(unlikely[k])
        process.X_train_, process.y_train_ = X, targets[k]
        process._y_train_mean, process._y_train_std = mean[k], spread[k]
        process._eigen, process._ratio = eigen, ratio[k]
        process._damped = eigen.values + ratio[k]
        process._weights = z[k] / process._damped
        for name in ("L_", "alpha_"):  # of an earlier fit by scikit-learn
            process.__dict__.pop(name, None)
        process.n_features_in_ = X.shape[1]
    return processes


def predict_together(
    processes: list[GaussianProcess], X: Array, return_std: bool
) -> list[tuple[Array, Array]]:
    """Return means and deviations by each, as if all alone; the latter if asked for.

    What several processes of one length scale need of it is computed once.
    """
    found = [(np.empty(len(X)), np.empty(len(X))) for _ in processes]
    for some in gen_batches(len(X), _BATCH):
        known: dict[int, tuple[Array, Array | None]] = {}
        for one, (means, stds) in zip(processes, found, strict=True):
            shared = id(one._eigen)
            if shared not in known:
                rows = one._rows(X[some])
                squares = (rows @ one._eigen.turn) ** 2 if return_std else None
                known[shared] = rows, squares
            mean, variance = one._standardised(X[some], *known[shared])
            means[some] = one._y_train_mean + one._y_train_std * mean
            if return_std:
                amplitude, _, noise = np.exp(one.kernel_.theta)
                spread = np.sqrt(amplitude * np.maximum(variance, 0.0) + noise)
                stds[some] = one._y_train_std * spread
    return found


class _Eigen(NamedTuple):
    """A kernel's matrix, decomposed: K = U diag(values) U'."""

    values: Array  # (rank,)
    vectors: Array  # (n_tasks, rank): U
    nodes: Array  # (n_nodes, n_task_params): tasks whose kernels span all others'
    root: Array | None  # (n_nodes, n_nodes): Cholesky factor of the nodes' matrix
    turn: Array  # (n_nodes, rank): k(x)'U is k(x, nodes) root'^-1 turn


def _decompose(kernel: Kernel, X: Array) -> _Eigen:
    """Decompose the kernel's matrix of tasks, by few nodes if these will do."""
    n_tasks, size = len(X), _SAMPLE
    order, missed = np.lexsort(X.T), np.zeros(len(X), dtype=bool)
    while True:
        every = order[np.linspace(0, n_tasks - 1, min(size, n_tasks)).astype(int)]
        seen = np.union1d(every, np.flatnonzero(missed))
        # Cholesky with pivots: K = F F', F = k(X, nodes) root'^-1, but for rounding
        factor, pivots, rank, _ = dpstrf(kernel(X[seen]), tol=_ROUNDING, lower=1)
        if 2 * rank > n_tasks:
            values, vectors = eigh(kernel(X), driver="evd", check_finite=False)
            return _Eigen(values, vectors, X, None, vectors)
        nodes, root = X[seen[pivots[:rank] - 1]], np.tril(factor[:rank, :rank])
        columns = solve_triangular(root, kernel(nodes, X), lower=True).T
        missed = 1.0 - (columns**2).sum(axis=1) > 10 * _ROUNDING  # the diagonal's rest
        if len(seen) == n_tasks or not missed.any():
            break
        size *= 2
    # F = U diag(s) V'
    vectors, roots, right = svd(columns, full_matrices=False, check_finite=False)
    return _Eigen(roots**2, vectors, nodes, root, right.T * roots)


def _profile(
    values: Array,
    squares: Array,
    rest: Array,
    n_tasks: int,
    box: Array,
    *,
    together: Any,
) -> tuple[Array, Array, Array]:
    """Return -log p of targets at its least, and there amplitudes and ratio of noise.

    If all are to have one ratio, `together` says which of them, by an index, choose it.

    Notes
    -----
    With the kernel's matrix K = U diag(d) U', of rank r, z = U'y and the ratio q of
    noise to amplitude a, the marginal likelihood p of a target y is (Rasmussen and
    Williams, 2006, Eq. 5.8)::

        -2 log p = n log(2 pi a) + sum_i log(d_i + q) + (n - r) log q + S / a
               S = sum_i z_i^2 / (d_i + q) + (y'y - z'z) / q

    For given K and q the best a is S / n or, since -log p has one minimum in a, the
    bound that is nearest. Bounds of the noise q a are bounds of a.
    """
    (least, most), (quiet, loud) = box
    low, high = np.log(quiet / most), np.log(loud / least)
    step = (high - low) / (_RATIOS - 1)
    tried = np.linspace(low, high, _RATIOS)[:, None]
    columns = np.arange(squares.shape[1])
    for _ in range(6):  # with ratios around the best one, each time closer
        ratio = np.exp(tried)  # a row each, a column a target, or one for all
        damped = values[:, None, None] + ratio
        with np.errstate(invalid="ignore"):  # indefinite: as unlikely as can be
            log_det = np.log(damped).sum(axis=0) + (n_tasks - len(values)) * tried
        total = (squares[:, None] / damped).sum(axis=0) + rest / ratio  # S
        bounds = np.maximum(least, quiet / ratio), np.minimum(most, loud / ratio)
        amplitude = np.clip(total / n_tasks, *bounds)
        unlikely = n_tasks * np.log(2 * np.pi * amplitude) + total / amplitude
        unlikely = (unlikely + log_det) / 2
        unlikely[np.isnan(unlikely)] = np.inf
        ranked = unlikely
        if together is not None:
            ranked = unlikely[:, together].sum(axis=1, keepdims=True)
        at = ranked.argmin(axis=0), columns
        best = unlikely[at], amplitude[at], np.broadcast_to(ratio, unlikely.shape)[at]
        nearer = step * np.linspace(-1, 1, 17)[:, None]
        tried = np.clip(np.log(best[2][: ranked.shape[1]]) + nearer, low, high)
        step /= 8
    return best


def _search(look: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function of the log length scale is least."""
    known: dict[float, float] = {}

    def value(at: float) -> float:
        if at not in known:
            known[at] = look(at)
        return known[at]

    first, last = np.clip(np.log([LENGTH_SCALES[0], LENGTH_SCALES[-1]]), low, high)
    if first == last:  # other bounds, or none
        first, last = low, high
    grid = np.linspace(first, last, 9)
    for at in grid:
        value(at)
    for path in ([*grid[1::-1]], [*grid[-2:]]):  # outwards, until nothing changes
        while True:
            before, here = map(value, path[-2:])
            hopeless = max(before, min(known.values()) + _HOPELESS) < here
            at_end = not low < path[-1] < high
            if hopeless or at_end or abs(here - before) <= _FLAT:
                break
            path.append(np.clip(2 * path[-1] - path[-2], low, high))
    for _ in range(_ROUNDS):
        x = np.sort([*known])
        y = np.array([value(at) for at in x])
        good = y < y.min() + _NEAR
        valleys = [at for height, at in _valleys(x, y) if height < y.min() + _NEAR]
        wanted = [at for at in valleys if np.abs(x - at).min() > _CLOSE][:1]
        wide = good[1:] & good[:-1] & (np.diff(x) > _CELL)  # where one may be hidden
        wanted += [*(x[1:] + x[:-1])[wide] / 2]
        if not wanted:
            break
        for at in wanted:
            value(at)
    return min(known, key=value)


def _valleys(x: Array, y: Array) -> list[tuple[float, float]]:
    """Return how low a function may go, and where, by curves through what is known."""
    x, y = x[y < np.inf], y[y < np.inf]
    padded = np.concatenate([[np.inf], y, [np.inf]])
    found = []
    for i in map(int, np.flatnonzero((y < padded[:-2]) & (y <= padded[2:]))):
        below, above = x[max(i - 1, 0)], x[min(i + 1, len(x) - 1)]
        for width in (2, 1):  # of neighbours on either side
            near = slice(max(i - width, 0), i + width + 1)
            curve, _ = Polynomial.fit(x[near], y[near], len(x[near]) - 1, full=True)
            flat = curve.deriv().roots()
            flat = flat[np.abs(flat.imag) < _CLOSE].real
            flat = flat[(below < flat) & (flat < above)]
            at = float(min([x[i], *flat], key=curve))
            if abs(at - x[i]) > _CLOSE:
                break
        if at == x[i]:  # an end: the least may still be within
            inwards = min(_END, (above - below) / 2)
            at = float(np.clip(at, below + inwards, above - inwards))
        found.append((float(curve(at)), at))
    return sorted(found)


def _refine(
    objective: Callable[..., Any], initial: Array, bounds: Array
) -> tuple[Array, float]:
    found = minimize(objective, initial, jac=True, bounds=bounds, method="L-BFGS-B")
    return found.x, found.fun
