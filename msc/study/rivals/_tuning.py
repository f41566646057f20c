"""One rule for the hyper-parameters of every rival, and the one table of their ranges.

The ranges were written down before any of these methods was compared on test tasks;
test tasks choose nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.model_selection import KFold, RandomizedSearchCV, StratifiedKFold

N_TRIALS = 20
"""Settings of a method that are tried, drawn from its ranges without repetition."""

N_FOLDS = 5
"""Folds of the training tasks on which each is judged, shuffled always alike."""

# Tasks in radians; targets of regressions that depend on their scale are standardised.
RANGES: dict[str, dict[str, list[Any]]] = {
    "chart gate": {
        "C": [1.0, 10.0, 100.0, 1e3, 1e4],
        "gamma": [0.1, 0.3, 1.0, 3.0, 10.0],  # 1 / rad²
    },
    "support vector regression": {
        "C": [1.0, 10.0, 100.0, 1e3],
        "gamma": [0.1, 0.3, 1.0, 3.0, 10.0],
        "epsilon": [1e-3, 1e-2, 1e-1],
    },
    "movement mixture": {
        "width": [0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.9, 1.5, 3.0],
    },
    "nearest neighbours": {
        "n_neighbors": [1, 2, 3, 4, 6, 9, 13],
        "weights": ["uniform", "distance"],
    },
    "local linear regression": {
        "width": [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6],
        "ridge": [1e-6, 1e-3, 1e-1],
    },
    "radial basis functions": {
        "kernel": ["linear", "thin_plate_spline", "cubic", "gaussian", "multiquadric"],
        "epsilon": [0.5, 1.0, 2.0, 5.0],
        "smoothing": [0.0, 1e-4, 1e-2],
    },
    "random forest": {
        "min_samples_leaf": [1, 2, 3, 5],
        "bootstrap": [True, False],
    },
    "gradient boosting": {
        "n_estimators": [30, 60, 120],
        "learning_rate": [0.05, 0.1, 0.3],
        "max_depth": [1, 2, 3],
    },
    "neural network": {
        "hidden_layer_sizes": [(8,), (16,), (32,), (16, 16)],
        "alpha": [1e-4, 1e-2, 1.0],
        "activation": ["tanh", "relu"],
    },
    "change points": {  # all of them, by marginal likelihood
        "length_scale": [0.1, 0.2, 0.4, 0.8, 1.6, 3.2],
        "noise": [1e-6, 1e-4, 1e-2],  # relative to the amplitude
        "amplitude": [0.1, 1.0, 10.0],
    },
}


def tune(
    estimator: Any,
    name: str,
    *,
    prefix: str = "",
    is_classifier: bool = False,
    random_state: Any = None,
) -> RandomizedSearchCV:
    """Wrap an estimator so that cross-validation on its training set chooses for it.

    Parameters
    ----------
    estimator : estimator
        Whose parameters are chosen.
    name : str
        Row of the table of ranges, `RANGES`.
    prefix : str, default=""
        What its parameters' names begin with, as ``regressor__``.
    is_classifier : bool, default=False
        Whether accuracy counts, with as many of each class in every fold, instead of
        the squared error of all policy dimensions.
    random_state : int, RandomState instance or None, default=None
        Draws the settings where there are more than trials.

    Returns
    -------
    RandomizedSearchCV
        Unfitted. Of equally good settings the first counts.

    Examples
    --------
    >>> from sklearn.svm import SVR
    >>> X = np.linspace(0, 6, 20)[:, np.newaxis]
    >>> model = tune(SVR(), "support vector regression", random_state=0)
    >>> bool(abs(model.fit(X, np.sin(X[:, 0])).predict([[1.5]]) - np.sin(1.5)) < 0.1)
    True
    """
    ranges = {f"{prefix}{key}": values for key, values in RANGES[name].items()}
    return RandomizedSearchCV(
        estimator,
        ranges,
        n_iter=min(N_TRIALS, prod(map(len, ranges.values()))),
        scoring="accuracy" if is_classifier else "neg_mean_squared_error",
        cv=Folds(is_classifier),
        random_state=random_state,
    )


@dataclass(frozen=True)
class Folds:
    """Shuffled folds of any number of samples: fewer folds if there are too few."""

    is_stratified: bool = False

    def get_n_splits(self, X: Any = None, y: Any = None, groups: Any = None) -> int:
        """Count the folds of samples."""
        del groups
        smallest = len(X)
        if self.is_stratified:
            smallest = np.unique(y, return_counts=True)[1].min()
        return max(1, min(N_FOLDS, smallest))

    def split(
        self, X: Any, y: Any = None, groups: Any = None
    ) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """Divide samples into pairs of those to train on and those to judge by."""
        n_splits = self.get_n_splits(X, y, groups)
        if n_splits == 1:  # nothing to judge by
            return iter([(np.arange(len(X)), np.arange(len(X)))])
        kind = StratifiedKFold if self.is_stratified else KFold
        return kind(n_splits, shuffle=True, random_state=0).split(X, y)  # type: ignore[no-any-return]
