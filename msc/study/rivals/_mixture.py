"""A mixture of movement primitives whose gate has not practised yet."""

from __future__ import annotations

from numbers import Real
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import softmax
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils._param_validation import Interval
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points

Array = NDArray[np.float64]


class MovementMixture(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Mix stored movements, the more of each the nearer its task.

    After Mülling, Kober, Kroemer and Peters: without practice.

    Parameters
    ----------
    width : float, default=0.3
        Width, > 0, of the gate, in the unit of tasks (rad). Chosen by
        ``tune(MovementMixture(), "movement mixture")``.

    Attributes
    ----------
    primitives_ : ndarray of shape (n_tasks, n_params) or (n_tasks,)
        The stored movements: the training policies.
    gate_weights_ : ndarray of shape (n_tasks, 1 + n_task_params)
        Weights of the gating network, a row a movement.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    As in [1]_ a movement is the mean of the stored ones, weighted by a gating network
    that sees the task x; here it is::

        policy(x) = sum_i g_i(x) policy_i / sum_i g_i(x)
        g_i(x) = exp(v_i' f(x))

    The original mixes what the primitives say at every moment. Eq. 5 is linear in the
    weights, so that the same movement comes of mixing policies. It assumes that what
    lies between two movements is one too, which is false across a break.

    Adapted: stored movements come from search, not from a teacher's hand; and before
    practice ``f(x) = (1, x)`` and ``v_i = (-|x_i|^2 / 2, x_i) / width^2``, which gives
    movement i the share of a Gaussian of that width about its own task x_i. Left out:
    practice, by which the original refines the gate with rewards: `PractisedMixture`.

    References
    ----------
    .. [1] K. Mülling, J. Kober, O. Kroemer and J. Peters, "Learning to select and
       generalize striking movements in robot table tennis", The International Journal
       of Robotics Research 32, 2013.

    Examples
    --------
    >>> from msc.study.rivals import MovementMixture
    >>> mixture = MovementMixture(0.5).fit([[0.0], [1.0]], [[0.0, 4.0], [2.0, 0.0]])
    >>> mixture.gate([[0.0], [0.5]]).round(2)
    array([[0.88, 0.12],
           [0.5 , 0.5 ]])
    >>> mixture.predict([[0.5]])
    array([[1., 2.]])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "width": [Interval(Real, 0, None, closed="neither")],
    }

    def __init__(self, width: float = 0.3) -> None:
        self.width = width

    def fit(self, X: Any, y: Any) -> Self:
        """Store the movements.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            Policies.

        Returns
        -------
        MovementMixture
            The fitted mixture.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        self.primitives_ = y.copy()
        self._centre = X.mean(axis=0)  # which changes no share, but what is rounded
        own = X - self._centre
        threshold = -0.5 * (own**2).sum(axis=1)
        self.gate_weights_ = np.column_stack([threshold, own]) / self.width**2
        return self

    def gate(self, X: Any) -> Array:
        """Tell how much of each stored movement a task is given.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_primitives)
            Shares, from 0 to 1, that sum to 1.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        seen = np.column_stack([np.ones(len(X)), X - self._centre])
        return np.asarray(softmax(seen @ self.gate_weights_.T, axis=1))

    def predict(self, X: Any) -> Array:
        """Mix a policy for each task.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks.

        Returns
        -------
        ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Policies.
        """
        return np.asarray(self.gate(X) @ self.primitives_)
