"""A parameterized skill: from a task straight to the policy that solves it.

One regression over all tasks averages across a jump of the policy manifold and serves
neither side. Here every chart of the manifold has regressions of its own, and a
classifier, the *gate*, tells which chart a new task belongs to.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin, clone
from sklearn.dummy import DummyClassifier
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import WhiteKernel
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.svm import SVC
from sklearn.utils import get_tags
from sklearn.utils._param_validation import HasMethods, StrOptions
from sklearn.utils.validation import check_is_fitted, has_fit_parameter

from msc._checks import (
    RANDOM_STATE,
    REAL,
    RandomState,
    check_magnitude,
    check_real,
    seed_of,
    validate_pairs,
    validate_points,
    warn_of_scale,
)
from msc._parallel import tell
from msc.learn._copies import find_copies
from msc.learn._gaussian import (
    GaussianProcess,
    fit_together,
    gaussian_classifier,
    gaussian_process,
    predict_together,
)
from msc.learn._smce import SMCE
from msc.learn._weights import validate_weights

__all__ = ["ParameterizedSkill"]

Array = NDArray[np.float64]
Charts = NDArray[np.intp]


class ParameterizedSkill(MultiOutputMixin, RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Predict the policy of a task by one regression per chart of the manifold.

    Parameters
    ----------
    charts : "smce", clusterer or None, default="smce"
        Finds the charts among the training policies: `SMCE` with its defaults, any
        clusterer with `fit_predict`, or None for a single chart. Points a clusterer
        calls noise (label -1) form a chart of their own.
    gate : {"nearest", "svm", "gp"} or classifier, default="nearest"
        Tells a task's chart; trained on tasks and chart labels. "nearest" takes the
        nearest training task's chart, "svm" is a support vector machine on
        standardised tasks, "gp" a Gaussian process classifier.
    regressor : regressor or None, default=None
        Cloned for every chart and policy dimension; None is `gaussian_process()`, to
        which a policy that repeats another of its task, exactly or nearly
        (`find_copies`), is given once.
    kernel_per : {"param", "chart"}, default="param"
        Whether every policy dimension has a kernel of its own, as in the paper, or all
        of a chart share length scale and ratio of noise to amplitude, in which those
        that are constant have no say; see Notes. A given regressor that is not
        `gaussian_process` is fitted once a chart then, to all dimensions.
    random_state : int, RandomState instance, Generator or None, default=None
        Given to every part whose own `random_state` is None. None draws fresh
        entropy; NumPy's global generator is left alone.
    verbose : bool or None, default=None
        Whether a fit of more than about two seconds shows a progress bar on standard
        error: None where that is a terminal, True in a notebook too.

    Attributes
    ----------
    charts_ : ndarray of shape (n_tasks,)
        Chart, 0 to n_charts - 1, of each training task.
    n_charts_ : int
        Number of charts.
    clusterer_ : clusterer or None
        What found the charts, fitted.
    gate_ : classifier
        Fitted on tasks and charts; constant if there is one chart.
    regressors_ : list of n_charts lists of n_params regressors
        Fitted regressions, by chart and policy dimension; a single one a chart where
        `kernel_per` has it fitted to all dimensions.
    n_features_in_ : int
        Number of task parameters.

    Notes
    -----
    The mapping is Eq. 2 of [1]_, built as in its section III: one Gaussian process per
    chart and per policy attribute. Which chart a *new* task belongs to is not said
    there; the gate is our answer. Tasks are expected in radians.

    A chart of one task predicts that task's policy everywhere, with the spread of all
    training policies as its standard deviation. Two points cannot tell a length scale
    from noise, so on a chart of two a Gaussian process keeps its initial
    hyper-parameters (by default 1 rad, noise 1e-3).

    Dimensions that act together, as the weights of a movement that has to end at its
    goal, may each be nearly right and yet not fit each other. With
    ``kernel_per="chart"`` a prediction is a weighted sum of the chart's policies, with
    the same weights in all dimensions, so that it nearly meets what linear conditions
    all of these meet. From 24 tasks with obstacles the arm misses its goal by 0.3 to
    0.5 cm then, and by 1.2 to 9.6 cm with a kernel for each dimension (one chart; 0.2
    to 0.3 and 1.3 to 1.7 cm with four).

    References
    ----------
    .. [1] "Task-Based Behavior Generalization via Manifold Clustering", sections II
       and III.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.cluster import KMeans
    >>> from msc import ParameterizedSkill
    >>> tasks = np.linspace(0, 6, 40)[:, np.newaxis]
    >>> policies = np.c_[np.sin(tasks), np.cos(tasks)] + 5 * (tasks > 3)
    >>> skill = ParameterizedSkill(KMeans(2), random_state=0).fit(tasks, policies)
    >>> skill.predict([[1.5], [4.5]]).round(2)
    array([[1.  , 0.07],
           [4.02, 4.79]])
    """

    _parameter_constraints: ClassVar[dict[str, list[Any]]] = {
        "charts": [StrOptions({"smce"}), HasMethods(["fit_predict"]), None],
        "gate": [StrOptions({"nearest", "svm", "gp"}), HasMethods(["fit", "predict"])],
        "regressor": [HasMethods(["fit", "predict"]), None],
        "kernel_per": [StrOptions({"param", "chart"})],
        "random_state": RANDOM_STATE,
        "verbose": ["boolean", None],
    }

    def __init__(
        self,
        charts: Any = "smce",
        *,
        gate: Any = "nearest",
        regressor: Any = None,
        kernel_per: str = "param",
        random_state: RandomState = None,
        verbose: bool | None = None,
    ) -> None:
        self.charts = charts
        self.gate = gate
        self.regressor = regressor
        self.kernel_per = kernel_per
        self.random_state = random_state
        self.verbose = verbose

    def set_params(self, **params: Any) -> Self:
        """Set parameters of the skill, or of its parts.

        Parameters
        ----------
        **params : dict
            By the names of `get_params`; ``charts__n_clusters`` if `charts` is
            ``SMCE()``.

        Returns
        -------
        ParameterizedSkill
            The skill itself.

        Raises
        ------
        ValueError
            If a parameter is unknown, or belongs to a part that is not an estimator yet
            but a string or None.
        """
        for name in params:
            part, is_nested, _ = name.partition("__")
            given = params.get(part, getattr(self, part, self))
            if is_nested and part in _INSTEAD and isinstance(given, str | None):
                raise ValueError(
                    f"{name} cannot be set while {part}={given!r}: pass "
                    f"{part}={_INSTEAD[part]}, whose parameters have names."
                )
        super().set_params(**params)
        return self

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> Self:
        """Find the charts of the policies; fit the gate and every chart's regressions.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks, in radians, or at a scale on which policies change over about one
            unit; if it is far off, a warning says so.
        y : array-like of shape (n_tasks, n_params) or (n_tasks,)
            The policy that solves each task.
        sample_weight : array-like of shape (n_tasks,), default=None
            How much each task counts in the regressions, if these take weights; charts
            and gate are found by all alike.

        Returns
        -------
        ParameterizedSkill
            The fitted skill.

        Raises
        ------
        ValueError
            If a parameter is unknown, there are fewer tasks than charts, `y` is not
            finite, too large or too small, the clusterer does not return a label for
            each policy, or there are weights for a regressor that takes none, as
            Gaussian processes do.
        """
        self._validate_params()
        X, y = validate_pairs(self, X, y)
        check_magnitude("y", y)
        weights = None
        if sample_weight is not None:
            _check_takes_weights(self.regressor)
            weights = validate_weights(sample_weight, len(X))
        if self.regressor is None or isinstance(self.regressor, GaussianProcess):
            warn_of_scale(X)
        self._is_single_output = y.ndim == 1
        policies = y.reshape(len(X), -1)
        self._n_params = policies.shape[1]
        if self.kernel_per == "chart" and self._n_params > 1:
            _check_outputs(self.regressor)
        seed = seed_of(self.random_state)
        self.clusterer_, labels = None, np.zeros(len(X), dtype=np.intp)
        if self.charts is not None:
            clusterer = SMCE() if isinstance(self.charts, str) else self.charts
            self.clusterer_ = seeded_clone(clusterer, seed)
            labels = _check_labels(self.clusterer_, policies)
        names, self.charts_ = np.unique(labels, return_inverse=True)
        self.n_charts_ = len(names)
        gate = GATES[self.gate]() if isinstance(self.gate, str) else self.gate
        gate = gate if self.n_charts_ > 1 else DummyClassifier()
        self.gate_ = seeded_clone(gate, seed)
        spreads = policies.std(axis=0)
        copies = find_copies(policies) if self.regressor is None else np.arange(len(X))
        charts = [self.charts_ == c for c in range(self.n_charts_)]
        known = [_once(X[here], policies[here], copies[here]) for here in charts]
        told = [
            {} if weights is None else {"sample_weight": weights[c]} for c in charts
        ]
        plans = [
            self._plan(*given, spreads, seed, more)
            for given, more in zip(known, told, strict=True)
        ]
        self.regressors_ = [models for models, _ in plans]
        fits, what = [fit for _, fits in plans for fit in fits], "regressions"
        if self.n_charts_ > 1:
            fits, what = [partial(self.gate_.fit, X, self.charts_), *fits], "fits"
        else:
            self.gate_.fit(X, self.charts_)
        n_tasks = len(X) if self.n_charts_ > 1 else len(known[0][0])
        list(tell(fits, what, n_tasks=n_tasks, verbose=self.verbose))  # fits them all
        return self

    def _plan(
        self,
        tasks: Array,
        policies: Array,
        spreads: Array,
        seed: int,
        told: dict[str, Array],
    ) -> tuple[list[Any], list[Callable[[], Any]]]:
        """Return the regressions of a chart, and what fits them, step by step."""
        given = gaussian_process() if self.regressor is None else self.regressor
        is_quick = isinstance(given, GaussianProcess) and given.is_quick()
        is_shared = self.kernel_per == "chart"
        n_models = 1 if is_shared and not is_quick else policies.shape[1]
        models = [seeded_clone(given, seed) for _ in range(n_models)]
        if len(tasks) == 1:  # white noise about the one value: constant, never certain
            kernels = [WhiteKernel(spread**2, "fixed") for spread in spreads]
            options = {"optimizer": None, "normalize_y": True}
            models = [GaussianProcessRegressor(kernel, **options) for kernel in kernels]
            told = {}
        elif len(tasks) == 2 and isinstance(given, GaussianProcessRegressor):
            for model in models:
                model.set_params(optimizer=None)
        if is_quick and len(tasks) > 1:
            fit = partial(fit_together, models, tasks, policies, shared=is_shared)
            return models, [fit]
        targets = policies.T if len(models) == policies.shape[1] else [policies]
        pairs = zip(models, targets, strict=True)
        return models, [
            partial(one.fit, tasks, target, **told) for one, target in pairs
        ]

    def predict_chart(self, X: Any) -> Charts:
        """Tell which chart each task belongs to.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks, in radians.

        Returns
        -------
        ndarray of shape (n_tasks,)
            Charts, 0 to n_charts - 1.
        """
        check_is_fitted(self)
        return self._ask_gate(validate_points(self, X, reset=False))

    def predict(
        self, X: Any, return_std: bool = False, chart: ArrayLike | None = None
    ) -> Array | tuple[Array, Array]:
        """Predict the policy that solves each task.

        Parameters
        ----------
        X : array-like of shape (n_tasks, n_task_params)
            Tasks, in radians.
        return_std : bool, default=False
            Whether to return standard deviations too, the policies' noise included.
        chart : array-like of int of shape (n_tasks,), default=None
            Chart of each task where it is known; None asks the gate.

        Returns
        -------
        policies : ndarray of shape (n_tasks, n_params), or (n_tasks,) as in `fit`
            Predicted policies.
        std : ndarray of the same shape
            Their standard deviations; only if `return_std`.

        Raises
        ------
        ValueError
            If `chart` does not name a chart for every task, or the regressor has no
            standard deviation to return.
        """
        check_is_fitted(self)
        X = validate_points(self, X, reset=False)
        charts = self._ask_gate(X) if chart is None else self._check(chart, len(X))
        means, stds = np.empty((2, len(X), self._n_params))
        for c in np.unique(charts):
            here, models = charts == c, self.regressors_[c]
            if all(map(_is_decomposed, models)):
                pairs = predict_together(models, X[here], return_std)
                means[here], stds[here] = map(np.column_stack, zip(*pairs, strict=True))
            elif not return_std:
                found = [model.predict(X[here]) for model in models]
                means[here] = np.column_stack(found)
            elif all(map(_returns_std, models)):
                pairs = [model.predict(X[here], return_std=True) for model in models]
                means[here], stds[here] = map(np.column_stack, zip(*pairs, strict=True))
            else:
                raise ValueError(
                    "return_std=True needs a regressor whose predict can return "
                    f"it. Got {self.regressor!r}."
                )
        if self._is_single_output:
            means, stds = means[:, 0], stds[:, 0]
        return (means, stds) if return_std else means

    def _ask_gate(self, X: Array) -> Charts:
        return np.asarray(self.gate_.predict(X), dtype=np.intp)

    def _check(self, chart: ArrayLike, n_tasks: int) -> Charts:
        check_real("chart", chart)
        charts = np.asarray(chart)
        if charts.shape != (n_tasks,):
            raise ValueError(
                f"chart must have shape ({n_tasks},), one entry per task. "
                f"Got shape {charts.shape}."
            )
        unknown = np.setdiff1d(charts, np.arange(self.n_charts_))
        if unknown.size:
            raise ValueError(
                f"chart must hold integers from 0 to {self.n_charts_ - 1}. "
                f"Got {unknown.tolist()}."
            )
        return charts.astype(np.intp)


def _once(tasks: Array, policies: Array, copies: Charts) -> tuple[Array, Array]:
    """Average repetitions of a task's policy; other policies of a task are kept."""
    # To the likelihood, targets that repeat to the last bit have no noise, so that it
    # trades the length scale for hitting them all.
    rows = np.column_stack([tasks, copies])
    _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    if len(first) == len(rows):
        return tasks, policies
    means = np.zeros((len(first), policies.shape[1]))
    np.add.at(means, place.ravel(), policies)
    means /= np.bincount(place.ravel())[:, None]
    order = np.argsort(first)
    return tasks[first[order]], means[order]


def _check_outputs(regressor: Any) -> None:
    """Refuse a regressor that says it has one output."""
    has_tags = hasattr(regressor, "__sklearn_tags__")
    if has_tags and not get_tags(regressor).target_tags.multi_output:
        raise ValueError(
            "kernel_per='chart' fits a regressor to all policy dimensions at once, but "
            f"regressor={regressor!r} takes one: wrap it in MultiOutputRegressor."
        )


def _check_takes_weights(regressor: Any) -> None:
    """Refuse a regressor whose `fit` knows no weights."""
    given = gaussian_process() if regressor is None else regressor
    if not has_fit_parameter(given, "sample_weight"):
        name = "gaussian_process()" if regressor is None else repr(regressor)
        raise ValueError(
            f"regressor={name} takes no sample_weight: leave the weights out, or give "
            "a regressor that does, as KernelRidge()."
        )


def _check_labels(clusterer: Any, policies: Array) -> NDArray[Any]:
    """Ask a clusterer for charts; refuse what is no label for each policy."""
    given = clusterer.fit_predict(policies.copy())  # which it may write into
    labels: Any = np.asarray(given, dtype=object)
    problem = "masked labels" if np.ma.is_masked(given) else ""
    if labels.shape != (len(policies),):
        problem = f"labels of shape {labels.shape}"
    elif not all(isinstance(one, str) for one in labels):
        bad = [one for one in labels if not _is_number(one)]
        worst = [one for one in bad if not isinstance(one, str)] or bad
        problem = f"the label {worst[0]!r}" if bad else problem
    if problem:
        raise ValueError(
            f"charts={clusterer!r} returned {problem}; wanted one for each of the "
            f"{len(policies)} policies: a number, or all strings."
        )
    return np.array(labels.tolist())


def _is_decomposed(regressor: Any) -> bool:
    return isinstance(regressor, GaussianProcess) and regressor.is_decomposed


def _is_number(label: Any) -> bool:
    return isinstance(label, _LABELS) and bool(abs(label) < math.inf)


def _returns_std(regressor: Any) -> bool:
    """Whether `predict` takes `return_std`; a pipeline's hands on what it does not."""
    last = regressor[-1] if isinstance(regressor, Pipeline) else regressor
    return "return_std" in inspect.signature(last.predict).parameters


def seeded_clone(estimator: Any, seed: int) -> Any:
    """Clone an estimator, giving a seed to every random_state that is None.

    Parameters
    ----------
    estimator : estimator
        Whatever it is, with parts or without.
    seed : int
        For those that have none of their own.

    Returns
    -------
    estimator
        Unfitted.
    """
    copy = clone(estimator)
    unset = {
        name: seed
        for name, value in copy.get_params().items()
        if value is None and name.rpartition("__")[2] == "random_state"
    }
    return copy.set_params(**unset)


_LABELS: Any = (*REAL, np.bool_)
_INSTEAD = {
    "charts": "SMCE()",
    "gate": "SVC(), or another classifier",
    "regressor": "gaussian_process()",
}
GATES: dict[str, Callable[[], Any]] = {
    "nearest": lambda: KNeighborsClassifier(n_neighbors=1),
    # Chart labels carry no noise, hence little slack: even small charts are learned.
    "svm": lambda: make_pipeline(StandardScaler(), SVC(C=1e4)),
    "gp": gaussian_classifier,
}
