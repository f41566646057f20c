"""Who is compared: a line a method, and what builds it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from sklearn.dummy import DummyRegressor
from sklearn.neighbors import KNeighborsRegressor
from sklearn.utils.validation import has_fit_parameter

from msc._checks import validate_cost
from msc.study._ladder import build_ladder
from msc.study._ours import build_skill
from msc.study._setting import Setting
from msc.study.rivals import (
    ChosenByTrial,
    ConditionedProMP,
    CrKR,
    GoalProjected,
    Interpolation,
    InvertedSweep,
    MappedMovement,
    MovementMixture,
    StoppedMovement,
    TriedSkill,
    isomap_skill,
    practising_method,
    todays_method,
    tune,
    zero_policy,
)


@dataclass(frozen=True)
class Method:
    """A method that is compared.

    Attributes
    ----------
    build : callable
        Takes a `Setting` and gives an unfitted estimator with `fit(X, y)` and
        `predict(X)`, tasks as `coordinates` has them; or with `plan(X)`, joint angles
        to follow.
    group : str
        Under what it is listed.
    sets : {"all", "even", "some", "few", "sweep"}
        On which training sets: all; the evenly spaced ones; of these ten at each of
        three sizes; three at one size; those of the sweep over the number of charts.
    n_numbers : int or None, default=None
        Of how many numbers a task has to be: 1 if it needs an order of tasks. None:
        of any.
    """

    build: Callable[[Setting], Any]
    group: str
    sets: str = "some"
    n_numbers: int | None = None


def _projected(to: Setting) -> Any:
    """Wrap the method that the name begins with."""
    base = to.name.removesuffix(", projected")
    dmp, end_time = to.workspace.dmp, to.workspace.physics.duration
    method = METHODS[base].build(replace(to, name=base))
    return GoalProjected(method, dmp, end_time=end_time)


def _practising(name: str) -> Callable[[Setting], Any]:
    """Build a method with rollouts of its own."""
    return lambda to: practising_method(name, to.workspace, to.seed)


def _tried(to: Setting) -> Any:
    """Have a rung of the ladder try two charts."""
    base = to.name.removesuffix(BY_TRIAL)
    return TriedSkill(build_ladder(replace(to, name=base)), to.workspace)


BY_TRIAL = ", by trial"
LADDER = {"SMCE": None, "linkage": None, "pieces": 1}  # charts: numbers of a task

METHODS = {
    "charts": Method(build_skill, "paper", "all"),
    "single regression": Method(build_skill, "paper", "all"),
    "CrKr": Method(lambda _: CrKR(tune=True, verbose=False), "paper", "all"),
    "nearest neighbour": Method(lambda _: KNeighborsRegressor(1), "no learning", "all"),
    "linear interpolation": Method(lambda _: Interpolation(), "no learning", "all"),
    "mean policy": Method(lambda _: DummyRegressor(), "no learning", "all"),
    "zero policy": Method(lambda _: zero_policy(), "no learning", "all"),
    "charts, SVM gate": Method(build_skill, "variants", "even"),
    "charts, k-means": Method(build_skill, "variants", "even"),
    "charts, GP gate": Method(build_skill, "choices"),
    "charts, λ 1": Method(build_skill, "choices"),
    "charts, λ 100": Method(build_skill, "choices"),
    "charts, 10 neighbours": Method(build_skill, "choices"),
    "charts, raw form": Method(build_skill, "choices"),
    "charts, Matérn": Method(build_skill, "variants", "even"),
    "single, Matérn": Method(build_skill, "variants", "even"),
    "single, periodic": Method(build_skill, "variants", "even"),
    "charts, one kernel": Method(build_skill, "one kernel", "even"),
    "single, one kernel": Method(build_skill, "one kernel", "even"),
    "charts, Matérn, one kernel": Method(build_skill, "one kernel", "even"),
    "single, Matérn, one kernel": Method(build_skill, "one kernel", "even"),
    "charts, projected": Method(_projected, "projected"),
    "single regression, projected": Method(_projected, "projected"),
    "charts, one kernel, projected": Method(_projected, "projected"),
    "single, one kernel, projected": Method(_projected, "projected"),
    "CrKr, projected": Method(_projected, "projected"),
    "nearest neighbour, projected": Method(_projected, "projected"),
    "linear interpolation, projected": Method(_projected, "projected"),
    "mean policy, projected": Method(_projected, "projected"),
    "zero policy, projected": Method(_projected, "projected"),
    "da Silva's skill": Method(lambda to: isomap_skill(to.seed), "section V"),
    "after Mülling: no practice": Method(
        lambda to: tune(MovementMixture(), "movement mixture", random_state=to.seed),
        "section V",
    ),
    "after Liu: mapped": Method(lambda to: MappedMovement(to.workspace), "section V"),
    "after Hausknecht: no sweep": Method(
        lambda _: InvertedSweep(), "section V", n_numbers=1
    ),
    "after Soni: stopped": Method(
        lambda to: StoppedMovement(to.workspace), "section V"
    ),
    "Kober's practice": Method(
        _practising("cost-regularized practice"), "rollouts", "few"
    ),
    "Mülling's practice": Method(_practising("mixture practice"), "rollouts", "few"),
    "after Deisenroth: model-free": Method(
        _practising("multi-task search"), "rollouts", "few"
    ),
    "contextual search": Method(_practising("contextual search"), "rollouts", "few"),
    "nearest neighbours": Method(todays_method, "today"),
    "local linear regression": Method(todays_method, "today"),
    "radial basis functions": Method(todays_method, "today"),
    "random forest": Method(todays_method, "today"),
    "gradient boosting": Method(todays_method, "today"),
    "neural network": Method(todays_method, "today"),
    "change points": Method(todays_method, "today", n_numbers=1),
    "conditioned ProMP": Method(lambda to: ConditionedProMP(to.workspace), "today"),
    **{
        f"ladder: {charts}{gate}": Method(build_ladder, "ladder", "even", n_numbers)
        for charts, n_numbers in LADDER.items()
        for gate in ("", ", best gate", ", abstaining", ", true gate")
        if charts + gate != "SMCE"  # it is "charts, one kernel"
    },
    **{
        f"ladder: {charts}{BY_TRIAL}": Method(_tried, "ladder", "even", n_numbers)
        for charts, n_numbers in LADDER.items()
    },
    **{
        f"{count} {'chart' if count == 1 else 'charts'}": Method(
            build_skill, "number of charts", "sweep"
        )
        for count in range(1, 9)
    },
}
"""All that are compared, by name."""

COMMON = tuple(name for name, method in METHODS.items() if method.sets == "all")


def build_method(name: str, **how: Any) -> Any:
    """Build a method, unfitted.

    Parameters
    ----------
    name : str
        A name of `METHODS`:

        - "charts": `ParameterizedSkill` on the charts of `SMCE`;
        - "single regression": one squared-exponential Gaussian process a dimension,
          as in the paper;
        - "CrKr": cost-regularised kernel regression, both its parameters tuned;
        - "nearest neighbour": the policy of the nearest training task;
        - "linear interpolation": between the training tasks on either side, or at the
          corners of a triangle, see `Interpolation`;
        - "mean policy": the training policies' mean, whatever the task;
        - "zero policy": no weights, which leaves the arm to the DMP's spring;
        - "…, SVM gate", "…, GP gate": a support vector machine, or a Gaussian process
          classifier, tells which chart a task belongs to;
        - "…, k-means": charts found by k-means among the policies;
        - "…, λ 1", "…, 10 neighbours", "…, raw form": another regularization, number of
          neighbours, or form of `SMCE`;
        - "…, Matérn", "…, periodic": regressions with another kernel, see
          `gaussian_process`;
        - "…, one kernel": one kernel for all weights of a chart;
        - "…, projected": moved onto the policies that end at the goal, see
          `GoalProjected`;
        - "3 charts": `ParameterizedSkill` on so many charts of `SMCE`;
        - "ladder: …": with one kernel, on charts by SMCE or single linkage, or the true
          pieces between jumps; with the best gate of several, one that abstains, or
          the true chart; or with a gate that executes two charts' policies and keeps
          the cheaper, see `TriedSkill`;
        - "…'s practice", "after Deisenroth: model-free", "contextual search": with
          rollouts of their own, which they count, see `practising_method`;
        - all others: see `msc.study.rivals`.
    **how : dict
        `n_charts`, `seed` and `workspace`, see `Setting`.

    Returns
    -------
    estimator
        With `fit(X, y)` and `predict(X)`, tasks as `msc.search.coordinates` has them:
        the angle (rad) and what else they have; "after Soni: stopped" has `plan(X)`
        instead, joint angles for `Arm.follow`.

    Raises
    ------
    ValueError
        If there is no such method, or it needs tasks of one number and the workspace's
        have several.

    Notes
    -----
    Gaussian processes and CrKr choose their hyper-parameters by marginal likelihood, in
    searches that begin at the same length scales and end at the same bounds. A
    process's amplitude is bounded and its noise, of standardised targets, at most 1;
    CrKr's signal variance is free, its targets are not centred and its noise, relative
    to the signal, is at most 1e3. Both floors are 1e-8.

    Examples
    --------
    >>> build_method("nearest neighbour")
    KNeighborsRegressor(n_neighbors=1)
    """
    if name not in METHODS:
        raise ValueError(f"name={name!r} is no method; wanted one of {tuple(METHODS)}")
    to, method = Setting(name, **how), METHODS[name]
    numbers = to.workspace.task_names
    if method.n_numbers not in (None, len(numbers)):
        raise ValueError(
            f"name={name!r} takes tasks of {method.n_numbers} number; wanted another "
            f"method for those of {', '.join(numbers)}"
        )
    return method.build(to)


def fit_methods(
    X: ArrayLike,
    y: ArrayLike,
    cost: ArrayLike,
    *,
    names: Iterable[str] = COMMON,
    **how: Any,
) -> dict[str, Any]:
    """Fit methods to the same training set.

    Parameters
    ----------
    X : array_like of shape (n_tasks, n_numbers)
        Tasks: the angle (rad), and all else in units that weigh alike.
    y : array_like of shape (n_tasks, n_params)
        Their policies.
    cost : array_like of shape (n_tasks,)
        What the search paid for each, positive. A method that trusts costly samples
        less is given cost / mean(cost), which is one on average; if it has rollouts of
        its own, in whose unit it is, the cost itself.
    names : iterable of str, default=COMMON
        Which methods.
    **how : dict
        `n_charts`, `seed` and `workspace`, see `build_method`.

    Returns
    -------
    dict from str to estimator
        The fitted methods, in the order of `names`.

    Raises
    ------
    ValueError
        If a method is unknown or takes no such tasks, or the costs are not positive,
        one a task.

    Examples
    --------
    >>> X, y = np.array([[0.0], [2.0], [4.0]]), np.array([[0.0], [1.0], [5.0]])
    >>> fitted = fit_methods(X, y, np.ones(3), names=["linear interpolation"])
    >>> fitted["linear interpolation"].predict([[3.0]])
    array([[3.]])
    """
    built = {name: build_method(name, **how) for name in names}
    costs = validate_cost(cost, len(np.asarray(X)))
    for method in built.values():
        unit = 1.0 if isinstance(method, ChosenByTrial) else costs.mean()
        takes_cost = has_fit_parameter(method, "cost")
        given = {"cost": costs / unit} if takes_cost else {}
        method.fit(np.asarray(X), np.asarray(y), **given)
    return built
