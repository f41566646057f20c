"""How much a study does: which training sets, how many, and who is fitted to them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from msc.study._methods import COMMON, METHODS, N_CHARTS
from msc.study._sampling import draw_samples

AT_RANDOM = 15  # training sets of each size at most, where they are drawn at random


@dataclass(frozen=True)
class Profile:
    """How much a study does.

    Attributes
    ----------
    repetitions : int
        Training sets of each size and design, at most.
    sizes : dict from str to tuple of int
        Sample sizes of each design.
    sweep_charts, sweep_sizes : tuple of int
        Numbers of charts tried at each of these sample sizes, evenly spaced.
    sweep_repetitions : int
        Training sets of each, at most.
    n_resamples : int
        Bootstrap resamples.
    n_elbows : int
        Resamplings of the policies in which an elbow is looked for.
    """

    repetitions: int
    sizes: dict[str, tuple[int, ...]]
    sweep_charts: tuple[int, ...]
    sweep_sizes: tuple[int, ...]
    sweep_repetitions: int
    n_resamples: int
    n_elbows: int


_SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)
PROFILES = {
    "quick": Profile(3, {"even": (8, 24, 72)}, (1, 4, 8), (24,), 3, 1_000, 5),
    "full": Profile(
        30,
        {"even": _SIZES, "uniform": _SIZES, "nonuniform": (16, 24, 50, 100)},
        tuple(range(1, 9)),
        (24, 100, 360),
        10,
        5_000,
        50,
    ),
}


@dataclass(frozen=True)
class Group:
    """Training sets whose trials are summarised together.

    Attributes
    ----------
    design : {"even", "uniform", "nonuniform"}
        How they were drawn.
    sets : list of ndarray
        Indices of the tasks, one array a set.
    n_charts : int
        Charts that SMCE is asked for.
    names : tuple of str
        Methods fitted.
    is_sweep : bool
        Whether it is the number of charts that is tried.
    """

    design: str
    sets: list[NDArray[np.intp]]
    n_charts: int = N_CHARTS
    names: tuple[str, ...] = METHODS
    is_sweep: bool = False


def list_groups(plan: Profile, tasks: NDArray[np.float64], seed: int) -> list[Group]:
    """Draw all training sets of a study.

    Parameters
    ----------
    plan : Profile
        How much it does.
    tasks : ndarray of shape (n_tasks, 1)
        The grid that is drawn from (rad).
    seed : int
        Seed of the draws.

    Returns
    -------
    list of Group
        By design and size, and then those of the sweep over the number of charts.
    """
    return [*_list_cells(plan, tasks, seed), *_list_sweep(plan, tasks, seed)]


def _list_cells(
    plan: Profile, tasks: NDArray[np.float64], seed: int
) -> Iterator[Group]:
    """Draw the training sets of all methods, by design and size."""
    for design, sizes in plan.sizes.items():
        is_even = design == "even"
        names = METHODS if is_even else COMMON
        for n_samples in sizes:
            n_draws = plan.repetitions if is_even else min(plan.repetitions, AT_RANDOM)
            sets = draw_samples(design, tasks, n_samples, n_draws=n_draws, seed=seed)
            yield Group(design, sets, names=names)


def _list_sweep(
    plan: Profile, tasks: NDArray[np.float64], seed: int
) -> Iterator[Group]:
    """Draw the training sets of charts alone, by their number and the sample size."""
    for n_charts, n_samples in product(plan.sweep_charts, plan.sweep_sizes):
        n_draws = plan.sweep_repetitions
        sets = draw_samples("even", tasks, n_samples, n_draws=n_draws, seed=seed)
        yield Group("even", sets, n_charts, ("charts",), is_sweep=True)
