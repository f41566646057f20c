"""Policies that do not look at the task: how much there is to learn at all."""

from typing import Any

import numpy as np
from sklearn.compose import TransformedTargetRegressor
from sklearn.dummy import DummyRegressor


def build(name: str, **_how: Any) -> Any:
    """Build the "mean policy" of the training tasks, or the "zero policy"."""
    if name == "mean policy":
        return DummyRegressor()
    return TransformedTargetRegressor(
        DummyRegressor(),
        func=np.zeros_like,
        inverse_func=np.asarray,
        check_inverse=False,
    )
