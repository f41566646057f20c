"""Gaussian processes to measure ours by: scikit-learn's, and GPy's if it is there.

Same kernel, same bounds, and of each the best of three starts.
"""

import warnings

import numpy as np
from scipy.optimize import minimize
from sklearn.base import BaseEstimator, ClusterMixin, RegressorMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor

from msc.learn import gaussian_process

try:
    import GPy
except ImportError:
    GPy = None

STARTS = (0.2, 0.7, 2.5)  # length scales
NOISES = (1e-6, 1e-3, 1e-1)  # of which a start takes the likeliest
AMPLITUDE_BOUNDS, LENGTH_SCALE_BOUNDS, NOISE_BOUNDS = np.exp(
    gaussian_process().kernel.bounds
)


class SklearnProcess(GaussianProcessRegressor):
    """scikit-learn's own, by L-BFGS-B from three starts: what `msc` had before."""

    def fit(self, X, y):
        """Fit; hyper-parameters may rest on their bounds."""
        with warnings.catch_warnings():
            message = ".*is close to the specified"
            warnings.filterwarnings("ignore", message, ConvergenceWarning)
            return super().fit(X, y)


def sklearn_process() -> SklearnProcess:
    """Build scikit-learn's regression with the kernel and the bounds of ours."""
    return SklearnProcess(
        gaussian_process().kernel, normalize_y=True, optimizer=refine_starts
    )


def refine_starts(objective, _, bounds):
    """Minimise from each length scale, at the noise that suits it."""
    found = []
    for length_scale in STARTS:
        starts = [np.log([1.0, length_scale, noise]) for noise in NOISES]
        start = min(starts, key=lambda one: objective(one, eval_gradient=False))
        options = {"jac": True, "bounds": bounds, "method": "L-BFGS-B"}
        found.append(minimize(objective, start, **options))
    best = min(found, key=lambda one: one.fun)
    return best.x, best.fun


class GPyProcess(RegressorMixin, BaseEstimator):
    """GPy's regression on standardised targets, by its own L-BFGS-B."""

    def fit(self, X, y):
        """Fit from three length scales; keep the likeliest."""
        self._mean, self._scale = y.mean(), y.std() or 1.0
        targets = ((y - self._mean) / self._scale)[:, None]
        self._model = max(
            (self._refine(X, targets, start) for start in STARTS),
            key=lambda model: model.log_likelihood(),
        )
        self.log_marginal_likelihood_value_ = float(self._model.log_likelihood())
        return self

    def _refine(self, X, targets, length_scale):
        kernel = GPy.kern.RBF(X.shape[1], lengthscale=length_scale)
        model = GPy.models.GPRegression(X, targets, kernel, noise_var=NOISES[1])
        kernel.variance.constrain_bounded(*AMPLITUDE_BOUNDS, warning=False)
        kernel.lengthscale.constrain_bounded(*LENGTH_SCALE_BOUNDS, warning=False)
        model.likelihood.variance.constrain_bounded(*NOISE_BOUNDS, warning=False)
        model.optimize()
        return model

    def predict(self, X):
        """Return means; GPy's own `predict` does not go without variances."""
        weights = self._model.posterior.woodbury_vector
        rows = self._model.kern.K(X, self._model.X)
        return self._mean + self._scale * (rows @ weights)[:, 0]


class GivenCharts(ClusterMixin, BaseEstimator):
    """Charts that are known, so that nothing is clustered."""

    def __init__(self, labels=()):
        self.labels = labels

    def fit_predict(self, X, y=None):  # noqa: ARG002
        """Return them."""
        return np.asarray(self.labels)
