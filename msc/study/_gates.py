"""Gates against each other: what tells a task's chart best, inside the training set."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.dummy import DummyClassifier, DummyRegressor
from sklearn.model_selection import KFold

from msc._checks import check_whole
from msc.learn import GATES, ParameterizedSkill, seeded_clone

Array = NDArray[np.float64]


def compare_gates(
    X: Any, y: Any, *, charts: Any = "smce", n_splits: int = 10, seed: int = 0
) -> dict[str, Any]:
    """Cross-validate every gate on the training tasks and the charts found among them.

    Parameters
    ----------
    X : array-like of shape (n_tasks, n_task_params)
        Training tasks, in radians.
    y : array-like of shape (n_tasks, n_params)
        Their policies, among which the charts are found, once.
    charts : "smce" or clusterer, default="smce"
        Finds the charts, as for `ParameterizedSkill`.
    n_splits : int, default=10
        Folds, drawn at random; clipped to the number of tasks.
    seed : int, default=0
        Seed of the clustering and of the folds.

    Returns
    -------
    dict
        Fit for JSON: ``"n_samples"``, ``"n_charts"``, and under ``"accuracy"`` by the
        gate's name the share of held-out tasks whose chart it tells. ``"best"`` names
        the most accurate; ties go to the simplest, the first.

    Raises
    ------
    ValueError
        If the data are not as wanted, or there are fewer than two folds.

    Notes
    -----
    A fold whose training part has one chart left is answered by that chart.

    Examples
    --------
    >>> from sklearn.cluster import KMeans
    >>> tasks = np.linspace(0, 6, 40)[:, np.newaxis]
    >>> policies = np.c_[np.sin(tasks), np.cos(tasks)] + 9 * (tasks > 3)
    >>> compare_gates(tasks, policies, charts=KMeans(2))["accuracy"]["nearest"]
    0.95
    """
    check_whole("n_splits", n_splits, 2)
    skill = ParameterizedSkill(charts, regressor=DummyRegressor(), random_state=seed)
    labels = skill.fit(X, y).charts_
    tasks = np.asarray(X, dtype=np.float64)
    accuracy = gate_accuracy(tasks, labels, n_splits=n_splits, seed=seed)
    return {
        "n_samples": len(tasks),
        "n_charts": skill.n_charts_,
        "accuracy": accuracy,
        "best": max(accuracy, key=lambda name: accuracy[name]),
    }


def gate_accuracy(
    tasks: Array, charts: NDArray[np.intp], *, n_splits: int, seed: int
) -> dict[str, float]:
    """Return by gate on what share of held-out tasks it tells the chart."""
    folds = KFold(min(n_splits, len(tasks)), shuffle=True, random_state=seed)
    right = {name: np.empty(len(tasks), dtype=bool) for name in GATES}
    for train, test in folds.split(tasks):
        is_trivial = len(np.unique(charts[train])) == 1
        for name, build in GATES.items():
            gate = DummyClassifier() if is_trivial else seeded_clone(build(), seed)
            found = gate.fit(tasks[train], charts[train]).predict(tasks[test])
            right[name][test] = found == charts[test]
    return {name: float(share.mean()) for name, share in right.items()}


def average_gates(compared: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Average the gates' accuracy over training sets of the same size.

    Parameters
    ----------
    compared : iterable of dict
        What `compare_gates` returned, sets of one size after one another.

    Returns
    -------
    list of dict
        One a size: ``"n_samples"``, ``"n_charts"``, ``"repetitions"``, the mean
        ``"accuracy"`` of each gate, and how often each was ``"best"``.

    Examples
    --------
    >>> found = {"n_samples": 9, "n_charts": 2, "best": "svm"}
    >>> found["accuracy"] = {"nearest": 0.5, "svm": 0.75}
    >>> average_gates([found, found])[0]["best"]
    {'nearest': 0, 'svm': 2}
    """
    averages = []
    for n_samples, group in groupby(compared, key=lambda one: one["n_samples"]):
        sets = list(group)
        names = list(sets[0]["accuracy"])
        averages.append(
            {
                "n_samples": n_samples,
                "n_charts": sets[0]["n_charts"],
                "repetitions": len(sets),
                "accuracy": {
                    name: float(np.mean([one["accuracy"][name] for one in sets]))
                    for name in names
                },
                "best": {
                    name: sum(one["best"] == name for one in sets) for name in names
                },
            }
        )
    return averages
