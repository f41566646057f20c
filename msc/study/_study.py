"""Every method, at many sample sizes, drawn in three ways, many times over.

A study of one workspace is a dictionary, written to `data/results/study_<world>.json`.
Its layout, which claims and figures read::

    {"workspace": "free", "profile": "full", "seed": 0, "n_charts": 4,
     "provenance": {
         "command": "msc evaluate --profile full --seed 0",
         "data": {"free.csv": "sha256:…", "free_test.csv": "sha256:…"},
         "versions": {"numpy": "…", "scikit-learn": "…", "cvxpy": "…",
                      "pybullet": "…"}},
     "cells": [
         {"design": "even" | "uniform" | "nonuniform", "n_samples": 24,
          "repetitions": 15,
          "measures": {MEASURE: {METHOD: SUMMARY}},
          "ratios": [{"measure": MEASURE, "method": "charts", "baseline": METHOD,
                      "ratio": 0.5, "low": 0.4, "high": 0.7}, …]}, …],
     "sweep": [
         {"n_charts": 1, "n_samples": 24, "repetitions": 10,
          "measures": {MEASURE: {"charts": SUMMARY}}}, …]}

``SUMMARY`` is ``{"mean", "std", "median", "p95", "low", "high", "n_tasks",
"per_repetition"}``.
``MEASURE`` is one of "mse, gate learned", "mse, chart known", "mse, away from jumps",
"mse, beside jumps", "standardised mse, gate learned", "error_cm", "excess_cost",
"under_1_cm", "touched" (shares) and "error_cm spread" (standard deviation over the test
tasks). A measure that no test task belongs to is left out, as beside jumps where there
are none; shares have no ratios, nor has what fewer than ten test tasks measure, nor
what is divided by nothing. ``METHOD`` is a name of `msc.study._methods`: "charts",
"single regression", "CrKr", "nearest neighbour", "linear interpolation", "mean policy",
"zero policy" and, in the even design only, "charts, SVM gate", "charts, k-means",
"charts, Matérn", "single, Matérn" and "single, periodic". Ratios are those of "charts"
over all others, and of "charts, Matérn" over "single, Matérn". ``low`` and ``high``
bound 95 % bootstrap intervals, see `msc.study._comparison`.

Evenly spaced sets are all there are, one for each first task, up to thirty; uniform and
nonuniform ones fifteen. In the nonuniform design test tasks count by the same density,
as in Eq. 1.
"""

from __future__ import annotations

import json
import re
from functools import partial
from importlib import metadata
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from msc._parallel import call_in_order
from msc.data import describe_origin, find_data, load_dataset
from msc.learn import SMCE
from msc.study._methods import N_CHARTS
from msc.study._profiles import PROFILES, Profile, list_groups
from msc.study._sampling import draw_samples, task_density
from msc.study._selection import average_gates, compare_gates, measure_elbows
from msc.study._summaries import Errors, measure_errors, summarise_trials
from msc.study._trial import Trial

_PACKAGES = ("numpy", "scikit-learn", "cvxpy", "pybullet")


def run_study(
    name: str,
    *,
    profile: str = "quick",
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Fit all methods to many training sets of a workspace, and test them.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    profile : {"quick", "full"}, default="quick"
        How much to do, see `msc.study._profiles`.
    seed : int, default=0
        Seed of the training sets, the clustering and the resampling.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Laid out as the head of this module says.

    Raises
    ------
    ValueError
        If the workspace or the profile is another, or its data are unusable.
    """
    plan = _plan(profile)
    tasks = load_dataset(name)[0]
    test_tasks, _, test_table = load_dataset(f"{name}_test")
    weights = pd.Series(task_density(test_tasks[:, 0]), index=test_table["task_deg"])
    groups = list_groups(plan, tasks, seed)
    calls = [
        (name, chosen, group.n_charts, group.names, seed)
        for group in groups
        for chosen in group.sets
    ]
    found = iter(
        call_in_order(_try, calls, jobs=jobs, label=f"study, {name}", progress=progress)
    )
    cells: list[dict[str, Any]] = []
    sweep: list[dict[str, Any]] = []
    for group in groups:
        summary = summarise_trials(
            [next(found) for _ in group.sets],
            weights if group.design == "nonuniform" else None,
            n_resamples=plan.n_resamples,
            seed=seed,
        )
        size = {"n_samples": len(group.sets[0]), "repetitions": len(group.sets)}
        if group.is_sweep:
            measures = {"measures": summary["measures"]}
            sweep.append({"n_charts": group.n_charts, **size, **measures})
        else:
            cells.append({"design": group.design, **size, **summary})
    head = _head(name, profile, seed, n_charts=N_CHARTS)
    return {**head, "cells": cells, "sweep": sweep}


def run_elbows(
    name: str,
    *,
    profile: str = "quick",
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Count the charts that each elbow picks, and tell how well each gate finds them.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    profile : {"quick", "full"}, default="quick"
        How much to do, see `msc.study._profiles`.
    seed : int, default=0
        Seed of the resamplings.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        What `msc.study.measure_elbows` found, what it rests on, and under
        ``"gates"`` what `msc.study.average_gates` gave, on the evenly spaced sets of
        the sweep.

    Raises
    ------
    ValueError
        If the workspace or the profile is another, or its data are unusable.
    """
    plan = _plan(profile)
    tasks, policies, _ = load_dataset(name)
    found = measure_elbows(
        tasks,
        policies,
        n_resamples=plan.n_elbows,
        seed=seed,
        jobs=jobs,
        progress=progress,
    )
    n_draws = plan.sweep_repetitions
    sets = [
        chosen
        for size in plan.sweep_sizes
        for chosen in draw_samples("even", tasks, size, n_draws=n_draws, seed=seed)
    ]
    gates = call_in_order(
        partial(compare_gates, charts=SMCE(N_CHARTS), seed=seed),
        [(tasks[chosen], policies[chosen]) for chosen in sets],
        jobs=jobs,
        label=f"gates, {name}",
        progress=progress,
    )
    return {**_head(name, profile, seed), **found, "gates": average_gates(gates)}


def format_study(found: dict[str, Any]) -> str:
    """Write a study as JSON, a summary or a ratio a line.

    Parameters
    ----------
    found : dict
        The study.

    Returns
    -------
    str
        The text.

    Examples
    --------
    >>> print(format_study({"seed": 0, "cells": [{"mean": 1.5, "per": [1, 2]}]}))
    {
      "seed": 0,
      "cells": [
        {"mean": 1.5, "per": [1, 2]}
      ]
    }
    <BLANKLINE>
    """
    text = json.dumps(found, indent=2, ensure_ascii=False, allow_nan=False)
    for innermost in (r"\[[^][{}]*\]", r"\{[^{}]*\}"):
        text = re.sub(innermost, _join_lines, text)
    return text + "\n"


def _join_lines(found: re.Match[str]) -> str:
    """Put brackets, and all that is between them, on one line."""
    line = " ".join(found[0].split())
    return f"{line[0]}{line[1:-1].strip()}{line[-1]}"


def _plan(profile: str) -> Profile:
    """Look up how much to do."""
    if profile not in PROFILES:
        raise ValueError(f"profile={profile!r}; wanted one of {tuple(PROFILES)}")
    return PROFILES[profile]


def _try(
    name: str,
    chosen: NDArray[np.intp],
    n_charts: int,
    names: tuple[str, ...],
    seed: int,
) -> Errors:
    """Fit and test on one training set, in a worker."""
    return measure_errors(
        Trial(name, chosen, n_charts=n_charts, names=names, seed=seed)
    )


def _head(name: str, profile: str, seed: int, **more: Any) -> dict[str, Any]:
    """Say what was measured, by which command, of which data."""
    tables = (find_data() / f"{table}.csv" for table in (name, f"{name}_test"))
    command = f"msc evaluate --profile {profile} --seed {seed}"
    versions = {package: metadata.version(package) for package in _PACKAGES}
    rests_on = {**describe_origin(command, *tables), "versions": versions}
    head = {"workspace": name, "profile": profile, "seed": seed, **more}
    return {**head, "provenance": rests_on}
