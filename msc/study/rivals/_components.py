"""Parameterized skills on ISOMAP's charts: the components of a neighbour graph."""

from __future__ import annotations

from numbers import Integral
from typing import Any, ClassVar, Self

import numpy as np
from scipy.sparse.csgraph import connected_components
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.compose import TransformedTargetRegressor
from sklearn.neighbors import NearestNeighbors
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC, SVR
from sklearn.utils._param_validation import Interval

from msc._checks import RandomState, validate_points
from msc.learn import ParameterizedSkill
from msc.study.rivals._tuning import N_FOLDS, tune


class NeighbourComponents(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Cluster points into the connected components of their neighbour graph.

    Parameters
    ----------
    n_neighbors : int or None, default=None
        Nearest other points that each is joined to, clipped to all. None: the smallest
        number with which no component is smaller than `min_size`.
    min_size : int, default=5
        Points a component must have if `n_neighbors` is None, clipped to all: as many
        as the folds of its regression's cross-validation.

    Attributes
    ----------
    labels_ : ndarray of shape (n_samples,)
        Component of each point, from 0 on.
    n_components_ : int
        Number of components.
    n_neighbors_ : int
        The number in use.
    n_features_in_ : int
        Number of features.

    Notes
    -----
    Two points are joined if either is among the nearest of the other, as in K-Isomap
    [1]_, step 1. With more neighbours components only merge, in the end into one, so
    that the smallest number always exists and gives the most charts that can be
    regressed on. Where samples are uneven, it also parts what belongs together: of two
    swiss rolls of 400 points it makes eight components, eight neighbours two.

    References
    ----------
    .. [1] J. B. Tenenbaum, V. de Silva and J. C. Langford, "A global geometric
       framework for nonlinear dimensionality reduction", Science 290, 2000, table 1.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import NeighbourComponents
    >>> points = np.r_[0:6, 20:27][:, np.newaxis]
    >>> NeighbourComponents().fit_predict(points)
    array([0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1], dtype=int32)
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "n_neighbors": [Interval(Integral, 1, None, closed="left"), None],
        "min_size": [Interval(Integral, 1, None, closed="left")],
    }

    def __init__(self, n_neighbors: int | None = None, *, min_size: int = N_FOLDS):
        self.n_neighbors = n_neighbors
        self.min_size = min_size

    def fit(self, X: Any, y: Any = None) -> Self:
        """Find the components.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Points: a skill's policies.
        y : Ignored
            For the sake of scikit-learn's conventions.

        Returns
        -------
        NeighbourComponents
            The fitted clusterer.
        """
        del y
        self._validate_params()
        X = validate_points(self, X)
        most = len(X) - 1
        tried = range(1, most + 1)
        if self.n_neighbors is not None:
            tried = range(min(self.n_neighbors, most), most + 1)
        self.labels_, self.n_neighbors_ = np.zeros(len(X), dtype=np.int32), most
        nearest = NearestNeighbors().fit(X)
        for number in tried if most else ():
            graph = nearest.kneighbors_graph(n_neighbors=number)  # others only
            self.labels_, self.n_neighbors_ = connected_components(graph)[1], number
            sizes = np.bincount(self.labels_)
            if self.n_neighbors is not None or sizes.min() >= min(
                self.min_size, len(X)
            ):
                break
        self.n_components_ = int(self.labels_.max()) + 1
        return self


def isomap_skill(random_state: RandomState = None) -> ParameterizedSkill:
    """Build the parameterized skill of da Silva, Konidaris and Barto.

    Parameters
    ----------
    random_state : int, RandomState instance, Generator or None, default=None
        Draws the settings that cross-validation tries.

    Returns
    -------
    ParameterizedSkill
        Unfitted.

    Notes
    -----
    As in [1]_: the policies of solved tasks lie on a manifold in pieces, ISOMAP tells
    how many, a classifier tells from a task to which of them its policy belongs, and
    on each piece every policy parameter has a nonlinear regression of its own from the
    task. Here the classifier is a support vector machine, the regressions are support
    vector regressions, both with Gaussian kernels. It assumes that pieces lie farther
    apart than neighbours on one piece do.

    Adapted: the number of neighbours of ISOMAP's graph is chosen as
    `NeighbourComponents` does, kernels and slacks by cross-validation on the training
    tasks, see `tune`, and policies are standardised within a chart. Left out: ISOMAP's
    embedding, which is for looking at; the policies it starts from are the searched
    ones here, not those of policy search by PoWER.

    References
    ----------
    .. [1] B. C. da Silva, G. Konidaris and A. G. Barto, "Learning parameterized
       skills", Proceedings of the 29th International Conference on Machine Learning,
       2012.

    Examples
    --------
    >>> import numpy as np
    >>> from msc.study.rivals import isomap_skill
    >>> X = np.linspace(0, 6, 30)[:, np.newaxis]
    >>> skill = isomap_skill(0).fit(X, np.hstack([np.sin(X), X + 9 * (X > 3)]))
    >>> skill.n_charts_, skill.predict([[1.5]]).round(1)
    (2, array([[1. , 1.5]]))
    """
    regressor = TransformedTargetRegressor(SVR(), transformer=StandardScaler())
    return ParameterizedSkill(
        NeighbourComponents(),
        gate=tune(SVC(), "chart gate", is_classifier=True),
        regressor=tune(regressor, "support vector regression", prefix="regressor__"),
        random_state=random_state,
        verbose=False,
    )
