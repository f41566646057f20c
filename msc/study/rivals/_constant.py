"""A policy that does not look at the task: how much there is to learn at all."""

import numpy as np
from sklearn.compose import TransformedTargetRegressor
from sklearn.dummy import DummyRegressor


def zero_policy() -> TransformedTargetRegressor:
    """Build what predicts zero, as wide as the policies are.

    Returns
    -------
    TransformedTargetRegressor
        Unfitted.

    Examples
    --------
    >>> zero_policy().fit([[0.0], [1.0]], [[3.0, 1.0], [5.0, 2.0]]).predict([[0.5]])
    array([[0., 0.]])
    """
    return TransformedTargetRegressor(
        DummyRegressor(),
        func=np.zeros_like,
        inverse_func=np.asarray,
        check_inverse=False,
    )
