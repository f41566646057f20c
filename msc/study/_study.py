"""Every method, at many sample sizes, drawn in three ways, many times over.

Evenly spaced sets are all there are, one for each first task, up to thirty; uniform and
nonuniform ones fifteen. In the nonuniform design test tasks count by the same density,
as in Eq. 1. Every training set is fitted and tested in a worker, on the same datasets.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from importlib import metadata
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from msc._parallel import call_in_order
from msc.data import describe_origin, find_data, load_dataset
from msc.learn import SMCE
from msc.study._choices import measure_elbows
from msc.study._gates import average_gates, compare_gates
from msc.study._methods import COMMON, METHODS, N_CHARTS
from msc.study._sampling import Indices, draw_samples, task_density
from msc.study._summaries import (
    Errors,
    Study,
    measure_errors,
    summarise_trials,
)
from msc.study._trial import Experiment

_PACKAGES = ("numpy", "scikit-learn", "cvxpy", "pybullet")
AT_RANDOM = 15  # training sets of each size at most, where they are drawn at random


@dataclass(frozen=True)
class Profile:
    """How much a study does."""

    repetitions: int  # training sets of each size and design, at most
    sizes: dict[str, tuple[int, ...]]  # of samples, by design
    sweep_charts: tuple[int, ...]  # numbers of charts tried, evenly spaced,
    sweep_sizes: tuple[int, ...]  # at each of these sample sizes,
    sweep_repetitions: int  # on so many training sets, at most
    n_elbows: int  # resamplings of the policies in which an elbow is looked for
    methods: tuple[str, ...] = METHODS  # who is compared, where others than all are


_SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)
PROFILES = {
    "quick": Profile(3, {"even": (8, 24, 72)}, (1, 4, 8), (24,), 3, 5),
    "full": Profile(
        30,
        {"even": _SIZES, "uniform": _SIZES, "nonuniform": (16, 24, 50, 100)},
        tuple(range(1, 9)),
        (24, 100, 360),
        10,
        50,
    ),
}


@dataclass(frozen=True)
class Group:
    """Training sets whose trials are summarised together."""

    design: str
    sets: list[Indices]  # of the tasks
    n_charts: int = N_CHARTS
    names: tuple[str, ...] = METHODS
    is_sweep: bool = False  # whether it is the number of charts that is tried


def list_groups(profile: Profile, tasks: NDArray[np.float64], seed: int) -> list[Group]:
    """Draw all training sets: of all methods by design and size, then of the sweep."""

    def draw(design: str, n_samples: int, n_draws: int) -> list[Indices]:
        return draw_samples(design, tasks, n_samples, n_draws=n_draws, seed=seed)

    groups = []
    for design, sizes in profile.sizes.items():
        is_even = design == "even"
        known = METHODS if is_even else COMMON
        names = tuple(name for name in known if name in profile.methods)
        most = profile.repetitions
        n_draws = most if is_even else min(most, AT_RANDOM)
        groups += [
            Group(design, draw(design, n_samples, n_draws), names=names)
            for n_samples in sizes
        ]
    for n_charts, n_samples in product(profile.sweep_charts, profile.sweep_sizes):
        sets = draw("even", n_samples, profile.sweep_repetitions)
        groups.append(Group("even", sets, n_charts, ("charts",), is_sweep=True))
    return groups


def run_study(
    name: str,
    *,
    profile: str = "quick",
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> Study:
    """Fit all methods to many training sets of a workspace, and test them.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    profile : {"quick", "full"}, default="quick"
        How much to do, see `PROFILES`.
    seed : int, default=0
        Seed of the training sets and the clustering.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Laid out as `msc.study.Study` says.

    Raises
    ------
    ValueError
        If the workspace or the profile is another, or its data are unusable.
    """
    effort = _effort(profile)
    datasets = grid, test = load_dataset(name), load_dataset(f"{name}_test")
    weights = pd.Series(task_density(test.tasks[:, 0]), index=test.task_deg)
    groups = list_groups(effort, grid.tasks, seed)
    calls = [
        (group.n_charts, group.names, chosen)
        for group in groups
        for chosen in group.sets
    ]
    fit_and_test = partial(_fit_and_test, name, datasets=datasets, seed=seed)
    label = f"study, {name}"
    found = iter(
        call_in_order(fit_and_test, calls, jobs=jobs, label=label, progress=progress)
    )
    cells: list[Any] = []
    sweep: list[Any] = []
    for group in groups:
        summary = summarise_trials(
            [next(found) for _ in group.sets],
            weights if group.design == "nonuniform" else None,
        )
        measured = {
            "n_samples": len(group.sets[0]),
            "repetitions": len(group.sets),
            "measures": summary["measures"],
        }
        if group.is_sweep:
            sweep.append({"n_charts": group.n_charts, **measured})
        else:
            cells.append(
                {"design": group.design, **measured, "ratios": summary["ratios"]}
            )
    return {
        "workspace": name,
        "profile": profile,
        "seed": seed,
        "n_charts": N_CHARTS,
        "provenance": _provenance(name, profile, seed),
        "cells": cells,
        "sweep": sweep,
    }


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
    name, profile : str
        As for `run_study`.
    seed, jobs : int
        As there.
    progress : bool, default=False
        As there.

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
    effort = _effort(profile)
    tasks, policies, _ = load_dataset(name)
    found = measure_elbows(
        tasks,
        policies,
        n_resamples=effort.n_elbows,
        seed=seed,
        jobs=jobs,
        progress=progress,
    )
    n_draws = effort.sweep_repetitions
    sets = [
        chosen
        for size in effort.sweep_sizes
        for chosen in draw_samples("even", tasks, size, n_draws=n_draws, seed=seed)
    ]
    gates = call_in_order(
        partial(compare_gates, charts=SMCE(N_CHARTS), seed=seed),
        [(tasks[chosen], policies[chosen]) for chosen in sets],
        jobs=jobs,
        label=f"gates, {name}",
        progress=progress,
    )
    return {
        "workspace": name,
        "profile": profile,
        "seed": seed,
        "provenance": _provenance(name, profile, seed),
        **found,
        "gates": average_gates(gates),
    }


def _effort(profile: str) -> Profile:
    """Look up how much to do."""
    if profile not in PROFILES:
        raise ValueError(f"profile={profile!r}; wanted one of {tuple(PROFILES)}")
    return PROFILES[profile]


def _fit_and_test(
    name: str,
    n_charts: int,
    names: tuple[str, ...],
    chosen: NDArray[np.intp],
    **what: Any,
) -> Errors:
    """Fit and test on one training set, in a worker."""
    return measure_errors(
        Experiment(name, chosen=chosen, n_charts=n_charts, names=names, **what)
    )


def _provenance(name: str, profile: str, seed: int) -> Any:
    """Say by which command, of which data, with which packages."""
    tables = (find_data() / f"{table}.csv" for table in (name, f"{name}_test"))
    command = f"msc evaluate --profile {profile} --seed {seed}"
    versions = {package: metadata.version(package) for package in _PACKAGES}
    return {**describe_origin(command, *tables), "versions": versions}
