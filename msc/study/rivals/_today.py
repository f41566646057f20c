"""What one would pick today, without having read of charts: libraries, tuned."""

from __future__ import annotations

import warnings
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.compose import TransformedTargetRegressor
from sklearn.ensemble import GradientBoostingRegressor, RandomForestRegressor
from sklearn.exceptions import ConvergenceWarning
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import FunctionTransformer, StandardScaler

from msc.study.rivals._changepoints import ChangePointProcess
from msc.study.rivals._interpolation import Interpolation, RadialBasis
from msc.study.rivals._local import FewNeighbours, LocalLinear
from msc.study.rivals._tuning import tune


def todays_methods(*, closed: bool = False, random_state: int = 0) -> dict[str, Any]:
    """List what one would pick today, unfitted.

    Parameters
    ----------
    closed : bool, default=False
        Whether the task is one angle and its circle is not cut open. Linear
        interpolation and change points then know the period, the latter by one at the
        cut; to all others the angle comes as (cos, sin).
    random_state : int, default=0
        Seed of what draws, and of the settings that are tried.

    Returns
    -------
    dict from str to estimator
        By name, each with `fit(X, y)` and `predict(X)`, tasks in radians:

        - "nearest neighbours": the mean policy of some, or weighted by nearness;
        - "local linear regression": `LocalLinear`;
        - "interpolation": `Interpolation`, linear;
        - "radial basis functions": `RadialBasis`;
        - "random forest": 100 trees for all weights together;
        - "gradient boosting": trees for each weight by itself;
        - "neural network": one or two small layers, full-batch (L-BFGS), on
          standardised tasks and policies;
        - "change points": `ChangePointProcess`.

    Notes
    -----
    All but interpolation choose their hyper-parameters by `tune`, change points by
    marginal likelihood. What is scale-free in the weights (all but networks) is given
    them as they are. Conditioned movement primitives need a world to know the goals
    in: `ConditionedProMP`. Contextual policy search is none of these: it learns by
    rollouts.

    Examples
    --------
    >>> from msc.study.rivals import todays_methods
    >>> list(todays_methods())[:3]
    ['nearest neighbours', 'local linear regression', 'interpolation']
    """
    network = TransformedTargetRegressor(
        make_pipeline(StandardScaler(), QuietNetwork(solver="lbfgs", max_iter=500)),
        transformer=StandardScaler(),
    )
    boosting = MultiOutputRegressor(GradientBoostingRegressor())
    tuned = {
        "nearest neighbours": (FewNeighbours(), ""),
        "local linear regression": (LocalLinear(), ""),
        "radial basis functions": (RadialBasis(), ""),
        "random forest": (RandomForestRegressor(100), ""),
        "gradient boosting": (boosting, "estimator__"),
        "neural network": (network, "regressor__quietnetwork__"),
    }
    found: dict[str, Any] = {
        "interpolation": Interpolation(2 * np.pi if closed else None),
        "change points": ChangePointProcess(),
    }
    for name, (estimator, prefix) in tuned.items():
        seeds = {
            key: random_state
            for key in estimator.get_params()
            if key.rpartition("__")[2] == "random_state"
        }
        search = tune(
            estimator.set_params(**seeds),
            name,
            prefix=prefix,
            random_state=random_state,
        )
        on_circle = FunctionTransformer(to_circle, validate=True)
        found[name] = make_pipeline(on_circle, search) if closed else search
    return {name: found[name] for name in NAMES}


NAMES = (
    "nearest neighbours",
    "local linear regression",
    "interpolation",
    "radial basis functions",
    "random forest",
    "gradient boosting",
    "neural network",
    "change points",
)


def to_circle(X: Any) -> NDArray[np.float64]:
    """Return (cos, sin) of one angle a task."""
    if X.shape[1] != 1:
        raise ValueError(f"X has {X.shape[1]} features; wanted the angle of a circle")
    return np.hstack([np.cos(X), np.sin(X)])


class QuietNetwork(MLPRegressor):  # type: ignore[misc]
    """scikit-learn's network; iterations that run out are what they are."""

    def fit(self, X: Any, y: Any) -> Self:
        """Fit without a warning of iterations."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            return super().fit(X, y)  # type: ignore[no-any-return]


def todays_method(to: Any) -> Any:
    """Build the one of `todays_methods` that has this name and seed.

    Parameters
    ----------
    to : Setting
        Its name and seed.

    Returns
    -------
    estimator
        Unfitted.
    """
    return todays_methods(random_state=to.seed)[to.name]
