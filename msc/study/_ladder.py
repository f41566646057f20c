"""The oracle ladder: what charts cost, what the gate costs, what regression costs.

Charts by SMCE, by another clusterer, and the true pieces between jumps; each with the
nearest task's chart, the best gate of several, one that abstains, and the true chart.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.base import (
    BaseEstimator,
    ClassifierMixin,
    ClusterMixin,
    MultiOutputMixin,
    RegressorMixin,
    clone,
)
from sklearn.cluster import AgglomerativeClustering
from sklearn.neighbors import KNeighborsClassifier, KNeighborsRegressor
from sklearn.utils.validation import check_is_fitted

from msc._checks import validate_pairs, validate_points
from msc.data import load_results
from msc.learn import GATES, SMCE, ParameterizedSkill, seeded_clone
from msc.robot import Workspace
from msc.study._gates import gate_accuracy
from msc.study._setting import N_CHARTS, Setting

Array = NDArray[np.float64]

N_FOLDS = 5  # by which the best gate is chosen


def build_ladder(to: Setting) -> Any:
    """Build "SMCE", "linkage" or "pieces", and after a comma its gate.

    Without a gate, and with "true gate", it is the nearest task's; who asks for the
    true one tells each task's chart.
    """
    charts, *gate = to.name.removeprefix("ladder: ").split(", ")
    clusterers: dict[str, Any] = {
        "SMCE": SMCE(to.n_charts, random_state=to.seed),
        "linkage": AgglomerativeClustering(to.n_charts or N_CHARTS, linkage="single"),
        "pieces": None,  # they are told by the tasks
    }
    skill = ParameterizedSkill(
        clusterers[charts],
        gate=BestGate(to.seed) if gate == ["best gate"] else "nearest",
        kernel_per="chart",
        random_state=to.seed,
        verbose=False,
    )
    if charts == "pieces":
        skill = PiecewiseSkill(skill, jumps=true_jumps(to.workspace))
    return AbstainingSkill(skill) if gate == ["abstaining"] else skill


def true_jumps(workspace: Workspace) -> tuple[float, ...]:
    """Return where bisection found jumps (rad), that at the cut not counted."""
    is_headline = workspace.name in ("free", "obstacles")
    name = "audit_" if is_headline else "worlds/jumps_"
    (audit,) = load_results(f"{name}{workspace.name}")
    between = [jump["between_deg"] for jump in audit["jumps"] if jump["is_jump"]]
    return tuple(np.radians(np.mean(one)) for one in between if one[1] < 360)


class PiecewiseSkill(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A skill whose charts are told: the pieces between jumps.

    Parameters
    ----------
    skill : ParameterizedSkill
        Whose charts are exchanged.
    jumps : tuple of float
        Where one piece ends and the next begins (rad), ascending.

    Attributes
    ----------
    skill_ : ParameterizedSkill
        The fitted skill.
    charts_ : ndarray of shape (n_tasks,)
        Its charts.

    Examples
    --------
    >>> X = np.linspace(0, 6, 20)[:, np.newaxis]
    >>> model = PiecewiseSkill(ParameterizedSkill(), jumps=(3.0,)).fit(X, X > 3)
    >>> model.predict([[2.9], [3.1]]).round(6)
    array([[0.],
           [1.]])
    """

    def __init__(self, skill: ParameterizedSkill, jumps: tuple[float, ...]) -> None:
        self.skill = skill
        self.jumps = jumps

    def fit(self, X: Any, y: Any) -> Self:
        """Divide the training set, of one number a task, and fit."""
        X, y = validate_pairs(self, X, y)
        if X.shape[1] > 1:
            raise ValueError(f"X has {X.shape[1]} features; wanted one, of the jumps")
        pieces = np.searchsorted(self.jumps, X[:, 0])
        self.skill_ = clone(self.skill).set_params(charts=Told(pieces)).fit(X, y)
        self.charts_ = self.skill_.charts_
        return self

    def predict(self, X: Any, chart: Any = None) -> Array:
        """Predict, by the piece that tasks lie in, or in the chart that is told."""
        check_is_fitted(self)
        return np.asarray(self.skill_.predict(X, chart=chart))


class Told(ClusterMixin, BaseEstimator):  # type: ignore[misc]
    """Clusters that are known."""

    def __init__(self, labels: Any) -> None:
        self.labels = labels

    def fit(self, X: Any, y: Any = None) -> Self:
        """Take the labels."""
        del X, y
        self.labels_ = np.asarray(self.labels)
        return self


class BestGate(ClassifierMixin, BaseEstimator):  # type: ignore[misc]
    """The gate that tells most charts right in cross-validation on the training set.

    Parameters
    ----------
    random_state : int, default=0
        Seed of folds and gates.

    Attributes
    ----------
    name_ : str
        Which of `msc.learn.GATES`; of equally good ones the first, the simplest.
    """

    def __init__(self, random_state: int = 0) -> None:
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> Self:
        """Choose a gate and fit it to all."""
        seed = self.random_state
        shares = gate_accuracy(X, y, n_splits=N_FOLDS, seed=seed)
        self.name_ = max(shares, key=lambda name: shares[name])
        self.gate_ = seeded_clone(GATES[self.name_](), seed).fit(X, y)
        self.classes_ = self.gate_.classes_
        return self

    def predict(self, X: Any) -> NDArray[Any]:
        """Ask the chosen gate."""
        return np.asarray(self.gate_.predict(X))


class AbstainingSkill(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A skill that does not choose between charts: there it plays the nearest policy.

    Parameters
    ----------
    skill : ParameterizedSkill or PiecewiseSkill
        What predicts where the nearest training tasks are of one chart: two, where a
        task is one number, and one more a further number, as a triangle has corners.

    Attributes
    ----------
    skill_ : estimator
        The fitted skill.
    charts_ : ndarray of shape (n_tasks,)
        Its charts.
    """

    def __init__(self, skill: Any) -> None:
        self.skill = skill

    def fit(self, X: Any, y: Any) -> Self:
        """Fit the skill, and keep what is nearest."""
        X, y = validate_pairs(self, X, y)
        self.skill_ = clone(self.skill).fit(X, y)
        self.charts_ = self.skill_.charts_
        n_corners = min(1 + X.shape[1], len(X))
        self._near = KNeighborsClassifier(n_corners).fit(X, self.charts_)
        self._stored = KNeighborsRegressor(1).fit(X, y)
        return self

    def predict(self, X: Any) -> Array:
        """Predict; between training tasks of several charts the nearest policy."""
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        found = np.asarray(self.skill_.predict(X))
        torn = self._near.predict_proba(X).max(axis=1) < 1
        if torn.any():
            found[torn] = self._stored.predict(X[torn])
        return found
