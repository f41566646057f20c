"""How much a study does: which training sets, how many, and who is fitted to them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from msc.study._methods import COMMON, METHODS, N_CHARTS
from msc.study._sampling import Indices, draw_samples

AT_RANDOM = 15  # training sets of each size at most, where they are drawn at random


@dataclass(frozen=True)
class Profile:
    """How much a study does."""

    repetitions: int  # training sets of each size and design, at most
    sizes: dict[str, tuple[int, ...]]  # of samples, by design
    sweep_charts: tuple[int, ...]  # numbers of charts tried, evenly spaced,
    sweep_sizes: tuple[int, ...]  # at each of these sample sizes,
    sweep_repetitions: int  # on so many training sets, at most
    n_resamples: int  # of the bootstrap
    n_elbows: int  # resamplings of the policies in which an elbow is looked for
    methods: tuple[str, ...] = METHODS  # who is compared, where others than all are


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
    """Training sets whose trials are summarised together."""

    design: str
    sets: list[Indices]  # of the tasks
    n_charts: int = N_CHARTS
    names: tuple[str, ...] = METHODS
    is_sweep: bool = False  # whether it is the number of charts that is tried


def list_groups(profile: Profile, tasks: NDArray[np.float64], seed: int) -> list[Group]:
    """Draw all training sets: by design and size, then those of the sweep."""
    return [*_list_cells(profile, tasks, seed), *_list_sweep(profile, tasks, seed)]


def _list_cells(
    profile: Profile, tasks: NDArray[np.float64], seed: int
) -> Iterator[Group]:
    """Draw the training sets of all methods, by design and size."""
    for design, sizes in profile.sizes.items():
        is_even = design == "even"
        known = METHODS if is_even else COMMON
        names = tuple(name for name in known if name in profile.methods)
        for n_samples in sizes:
            n_draws = (
                profile.repetitions if is_even else min(profile.repetitions, AT_RANDOM)
            )
            sets = draw_samples(design, tasks, n_samples, n_draws=n_draws, seed=seed)
            yield Group(design, sets, names=names)


def _list_sweep(
    profile: Profile, tasks: NDArray[np.float64], seed: int
) -> Iterator[Group]:
    """Draw the training sets of charts alone, by their number and the sample size."""
    for n_charts, n_samples in product(profile.sweep_charts, profile.sweep_sizes):
        n_draws = profile.sweep_repetitions
        sets = draw_samples("even", tasks, n_samples, n_draws=n_draws, seed=seed)
        yield Group("even", sets, n_charts, ("charts",), is_sweep=True)
