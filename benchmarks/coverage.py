"""How often an interval holds the truth: studies of two methods, simulated.

`python benchmarks/coverage.py` first measures how errors scatter (over training sets,
over test tasks, and what is left of both) and how alike those of neighbouring tasks
are. Then it draws studies in which errors scatter just so, round a circle of 120 test
tasks, with long tails, and of which the true ratio of the two means is known. Each kind
of interval that was thought of is made of the same studies. The one that `msc` has,
`N_WAVES` waves and stretched by `WIDER`, is `msc.estimates`' own code. The result goes
to `data/results/coverage.json`.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.special import stdtrit
from tqdm import tqdm

from msc.data import describe_origin, find_data, load_dataset
from msc.estimates import N_WAVES, WIDER, Average, _find_waves, _half_width_of
from msc.study import MEASURES, Experiment, draw_samples, format_study

Array = NDArray[np.float64]

SEED = 0
N_STUDIES = 1000  # of each condition
N_RESAMPLES = 500  # of a bootstrap
N_TASKS = 120
MEASURED = {  # what scatters, by the key of a measure
    "error_cm": "distances",
    "mse, gate learned": "squared errors",
    "excess_cost": "excess costs",
}
ALIKE = (
    0.88  # correlation of neighbours' errors, as with obstacles; see `measure_scatter`
)
WHOSE = ("charts", "single regression", "nearest neighbour")
CORRELATIONS = (0.0, 0.5, 0.9)
RATIOS = (1.0, 0.8, 0.5)


@dataclass(frozen=True)
class Scatter:
    """How errors scatter: spreads of their logarithms, and how alike neighbours are."""

    sets: float  # from one training set to another
    tasks: float  # from one test task to another, whatever the set
    rest: float  # what is left
    tasks_alike: float  # correlation of errors of tasks beside one another,
    rest_alike: float  # and of what is left


@dataclass(frozen=True)
class Condition:
    """What studies are drawn."""

    name: str
    scatter: Scatter
    n_sets: int = 15
    correlation: float = 0.5  # of the logarithms of the two methods' errors
    ratio: float = 1.0  # of their means, in truth
    counted: str = "all"  # which test tasks, see `weigh`
    of_others: bool = True  # whether a study is to tell of other training sets


# What is measured


def measure_scatter() -> dict[str, Scatter]:
    """Measure how errors scatter: 24 training tasks, medians over worlds and methods.

    Spreads are those that lognormal errors of such a variance have.
    """
    found = []
    for world in ("free", "obstacles"):
        datasets = load_dataset(world), load_dataset(f"{world}_test")
        trials = [
            Experiment(world, chosen=chosen, names=WHOSE, datasets=datasets)
            for chosen in draw_samples("even", datasets[0].tasks, 24, n_draws=15)
        ]
        for key, name in MEASURED.items():
            tables = [MEASURES[key].errors(trial) for trial in trials]
            found += [
                {"of": name, **scatter_of(np.array([table[who] for table in tables]))}
                for who in WHOSE
            ]
    table = pd.DataFrame(found)
    kinds = {str(name): some.drop(columns="of") for name, some in table.groupby("of")}
    kinds["all"] = table.drop(columns="of")
    return {name: take_medians(some) for name, some in kinds.items()}


def take_medians(table: pd.DataFrame) -> Scatter:
    """Summarise rows of `scatter_of`."""
    return Scatter(**{key: round(float(x), 2) for key, x in table.median().items()})


def scatter_of(errors: Array) -> dict[str, float]:
    """Split the variance of errors, a row a training set and a column a test task."""
    n_sets, n_tasks = errors.shape
    relative = errors / errors.mean() - 1
    of_set, of_task = relative.mean(axis=1), relative.mean(axis=0)
    left = relative - of_set[:, None] - of_task
    noise = np.sum(left**2) / ((n_sets - 1) * (n_tasks - 1))
    # The means of few hold some of what is left.
    sets = max(0.0, of_set.var(ddof=1) - noise / n_tasks)
    tasks = max(0.0, of_task.var(ddof=1) - noise / n_sets)
    whole = np.log1p(relative.var())
    return {
        "sets": np.sqrt(np.log1p(sets)),
        "tasks": np.sqrt(np.log1p(tasks)),
        "rest": np.sqrt(max(0.0, whole - np.log1p(sets) - np.log1p(tasks))),
        "tasks_alike": likeness(of_task),
        "rest_alike": likeness(left),
    }


def likeness(values: Array) -> float:
    """Return the correlation of values that stand beside one another on the circle."""
    return float(np.sum(values * np.roll(values, 1, axis=-1)) / np.sum(values**2))


# What is drawn


@dataclass(frozen=True)
class Pair:
    """A study: errors of two methods, shape (n_sets, n_tasks), and what is true."""

    errors: tuple[Array, Array]
    weights: Array
    ratio: float


def draw_pairs(
    condition: Condition, n_studies: int, rng: np.random.Generator
) -> Iterator[Pair]:
    """Draw studies of a condition."""
    scatter, n_sets = condition.scatter, condition.n_sets
    weights = weigh(condition.counted)

    def draw_two(draw: Callable[[], Array]) -> Array:
        """Draw twice, correlated."""
        mixed = np.sqrt(1 - condition.correlation**2)
        first, second = draw(), draw()
        return np.array([first, condition.correlation * first + mixed * second])

    for _ in range(n_studies):
        of_set = scatter.sets * draw_two(lambda: rng.standard_normal((n_sets, 1)))
        logs = (
            of_set
            + draw_two(lambda: draw_round(rng, scatter.tasks, scatter.tasks_alike, 1))
            + draw_two(
                lambda: draw_round(rng, scatter.rest, scatter.rest_alike, n_sets)
            )
        )
        truth = condition.ratio
        if not condition.of_others:
            truth *= float(np.exp(of_set[0] - of_set[1]).mean())
        ours, theirs = np.exp(logs)
        yield Pair((condition.ratio * ours, theirs), weights, truth)


def draw_round(
    rng: np.random.Generator, spread: float, alike: float, n_sets: int
) -> Array:
    """Draw normal numbers round the circle whose exponentials are so alike.

    Neighbours' correlation falls by the same factor from task to task [1].

    [1] exp turns a correlation r of normal numbers of spread s into
        (exp(s² r) - 1) / (exp(s²) - 1).
    """
    nearest = np.log1p(alike * np.expm1(spread**2)) / spread**2
    apart = np.minimum(np.arange(N_TASKS), N_TASKS - np.arange(N_TASKS))
    spectrum = np.maximum(np.fft.fft(nearest**apart).real, 0)
    white = np.fft.fft(rng.standard_normal((n_sets, N_TASKS)))
    return spread * np.fft.ifft(white * np.sqrt(spectrum)).real


def weigh(counted: str) -> Array:
    """Return how much each task counts."""
    place = np.arange(N_TASKS)
    return {
        "all": np.ones(N_TASKS),
        "by the density": 1 - 0.8 * np.cos(2 * np.pi * (place + 0.5) / N_TASKS),
        "60 in six arcs": (place % 20 < 10).astype(float),
        "30 in three arcs": (place % 40 < 10).astype(float),
        "30 in one arc": (place < 30).astype(float),
    }[counted]


# Intervals: how far the logarithm of the ratio may be below and above the one found


class Bootstrap:
    """Training sets and arcs of tasks drawn again, the same for both methods."""

    def __init__(self, length: int, *, moving: bool = False) -> None:
        rng = np.random.default_rng(SEED)
        n_arcs = N_TASKS // length
        starts = rng.integers(n_arcs, size=(N_RESAMPLES, n_arcs)) * length
        if moving:  # arcs may begin anywhere
            starts = rng.integers(N_TASKS, size=(N_RESAMPLES, n_arcs))
        tasks = (starts[..., None] + np.arange(length)).reshape(N_RESAMPLES, -1)
        self._tasks = np.array([times(drawn % N_TASKS, N_TASKS) for drawn in tasks])

    def __call__(self, pair: Pair) -> tuple[float, float]:
        n_sets = len(pair.errors[0])
        rng = np.random.default_rng([SEED, n_sets])
        sets = rng.multinomial(n_sets, [1 / n_sets] * n_sets, N_RESAMPLES)
        tasks = self._tasks * pair.weights
        ours, theirs = (np.sum(tasks @ one.T * sets, axis=1) for one in pair.errors)
        logs = np.log(ours / theirs) - found_in(pair)
        low, high = np.quantile(logs, [0.025, 0.975])
        return -low, high


def times(drawn: Array, n: int) -> Array:
    """Count how often each number was drawn."""
    return np.bincount(drawn, minlength=n).astype(float)


def leave_out(pair: Pair, n_arcs: int = 8) -> tuple[float, float]:
    """Leave out one arc, or one training set, after the other: the jack-knife."""
    errors = np.array(pair.errors) * pair.weights
    by_arc = errors.reshape(2, len(errors[0]), n_arcs, -1).sum(axis=(1, 3))
    variances, freedoms = [], []
    for parts in (by_arc, errors.sum(axis=2)):
        n = parts.shape[1]
        if n > 1:
            ours, theirs = parts.sum(axis=1, keepdims=True) - parts
            variances.append((n - 1) * np.log(ours / theirs).var())
            freedoms.append(n - 1)
    total = np.sum(variances)
    freedom = total**2 / np.sum(np.square(variances) / freedoms)
    half = float(stdtrit(freedom, 0.975) * np.sqrt(total))
    return half, half


class Waves:
    """The lowest frequencies round the circle, and Student's t, as `Average` has it."""

    def __init__(self, n_waves: int) -> None:
        self._n_waves = n_waves

    def __call__(self, pair: Pair) -> tuple[float, float]:
        shares = pair.weights / pair.weights.sum()
        ours, theirs = (one / np.mean(one @ shares) for one in pair.errors)
        waves = _find_waves(np.mean(ours - theirs, axis=0), shares, self._n_waves)
        n_tasks = int(np.count_nonzero(shares))
        half = _half_width_of(waves, n_tasks, [(ours - theirs) @ shares], wider=1)
        return half, half


def found_in(pair: Pair) -> float:
    """Return the logarithm of the ratio that a study finds."""
    ours, theirs = (np.sum(one @ pair.weights) for one in pair.errors)
    return float(np.log(ours / theirs))


BEFORE, CHOSEN = "tasks drawn again", f"{N_WAVES} waves"
CANDIDATES: dict[str, Callable[[Pair], tuple[float, float]]] = {
    BEFORE: Bootstrap(1),
    "arcs of 45° drawn again": Bootstrap(15),
    "arcs of 90°, from anywhere": Bootstrap(30, moving=True),
    "arcs of 45° left out": leave_out,
    "1 wave": Waves(1),
    "2 waves": Waves(2),
    "3 waves": Waves(3),
}


# What comes of it


def list_conditions(measured: dict[str, Scatter]) -> tuple[list[Condition], ...]:
    """List what intervals must stand, and what else they are tried at."""
    usual = replace(measured["all"], tasks_alike=ALIKE)
    main = [
        Condition(
            "as measured", usual, n_sets, correlation, ratio, of_others=n_sets > 1
        )
        for n_sets, correlation, ratio in product((1, 10, 15), CORRELATIONS, RATIOS)
    ]
    others = [
        *(Condition(name, measured[name]) for name in MEASURED.values()),
        Condition("lighter tails", replace(usual, tasks=0.6 * usual.tasks)),
        Condition("heavier tails", replace(usual, tasks=1.4 * usual.tasks)),
        Condition("neighbours less alike", replace(usual, tasks_alike=0.7)),
        Condition("neighbours more alike", replace(usual, tasks_alike=0.95)),
        *(
            Condition(f"tasks: {counted}", usual, counted=counted)
            for counted in (
                "by the density",
                "60 in six arcs",
                "30 in three arcs",
                "30 in one arc",
            )
        ),
        *(Condition(f"{n} training sets", usual, n) for n in (2, 3, 5, 30)),
        Condition("one training set for all", usual, 1),
    ]
    return main, [
        replace(one, correlation=correlation)
        for one, correlation in product(others, CORRELATIONS)
    ]


def measure_again(condition: Condition, n_studies: int = 300) -> Scatter:
    """Measure how the errors of a condition scatter, each study by itself."""
    pairs = draw_pairs(condition, n_studies, np.random.default_rng(SEED))
    return take_medians(pd.DataFrame([scatter_of(pair.errors[0]) for pair in pairs]))


def try_intervals(
    condition: Condition, names: list[str], n_studies: int, seed: list[int]
) -> list[dict[str, Any]]:
    """Tell of each interval how often it holds the truth, how long it is, its power."""
    pairs = draw_pairs(condition, n_studies, np.random.default_rng(seed))
    rows = np.array(
        [
            [(found_in(p), np.log(p.ratio), *CANDIDATES[name](p)) for name in names]
            for p in pairs
        ]
    )
    return [
        {
            "condition": condition.name,
            "sets": condition.n_sets,
            "correlation": condition.correlation,
            "ratio": condition.ratio,
            "interval": name,
            "wider": wider,
            **judge(rows[:, number], wider),
        }
        for (number, name), wider in product(enumerate(names), (1.0, WIDER))
    ]


def judge(rows: Array, wider: float) -> dict[str, float]:
    """Tell how good intervals are: found, true, how far below and above, in logs."""
    found, true, below, above = rows.T
    low, high = found - wider * below, found + wider * above
    return {
        "coverage": round(float(np.mean((low <= true) & (true <= high))), 4),
        "length": float(f"{np.exp(np.median(high - low)):.4g}"),  # high over low
        "power": round(float(np.mean((low > 0) | (high < 0))), 4),
    }


def simulate(
    measured: dict[str, Scatter], n_studies: int = N_STUDIES
) -> dict[str, Any]:
    """Try all intervals at the main conditions, the old and the new one at others."""
    must, others = list_conditions(measured)
    asked = {"main": (must, [*CANDIDATES]), "others": (others, [BEFORE, CHOSEN])}
    return {
        part: [
            row
            for number, condition in enumerate(tqdm(conditions, part))
            for row in try_intervals(condition, names, n_studies, [SEED, kind, number])
        ]
        for kind, (part, (conditions, names)) in enumerate(asked.items())
    }


def try_means(
    condition: Condition, n_studies: int, seed: list[int]
) -> dict[str, float]:
    """Tell how often the interval of a single mean holds the truth, and its length."""
    spreads = vars(condition.scatter)
    true = np.exp(sum(spreads[key] ** 2 for key in ("sets", "tasks", "rest")) / 2)
    pairs = draw_pairs(condition, n_studies, np.random.default_rng(seed))
    found = [Average(pair.errors[1], pair.weights).estimate for pair in pairs]
    low, high = np.array([one.bounds for one in found]).T
    return {
        "sets": condition.n_sets,
        "coverage": round(float(np.mean((low <= true) & (true <= high))), 4),
        "length": float(f"{np.median(high / low):.4g}"),
    }


def try_spreads(
    condition: Condition, n_studies: int, seed: list[int]
) -> dict[str, float]:
    """Tell how often the interval of a ratio of standard deviations holds the truth."""
    pairs = draw_pairs(condition, n_studies, np.random.default_rng(seed))
    both = ([Average(one, spread=True) for one in pair.errors] for pair in pairs)
    low, high = np.array([ours.over(theirs).bounds for ours, theirs in both]).T
    true = condition.ratio
    return {
        "correlation": condition.correlation,
        "coverage": round(float(np.mean((low <= true) & (true <= high))), 4),
        "length": float(f"{np.median(high / low):.4g}"),
    }


def main(path: Path) -> None:
    """Measure, simulate and write."""
    measured = measure_scatter()
    (*_, usual), _ = list_conditions(measured)
    drawn = {"drawn": usual.scatter, "drawn, measured again": measure_again(usual)}
    names = [f"{w}{kind}.csv" for w in ("free", "obstacles") for kind in ("", "_test")]
    found = {
        "n_studies": N_STUDIES,
        "seed": SEED,
        "n_waves": N_WAVES,
        "wider": WIDER,
        "chosen": CHOSEN,
        "before": BEFORE,
        "provenance": describe_origin(
            "python benchmarks/coverage.py", *(find_data() / name for name in names)
        ),
        "scatter": {name: vars(one) for name, one in (measured | drawn).items()},
        **simulate(measured),
        "means": [
            try_means(replace(usual, n_sets=n), N_STUDIES, [SEED, 2, n])
            for n in (10, 15)
        ],
        "spreads": [
            try_spreads(replace(usual, correlation=r, ratio=1.0), N_STUDIES, [SEED, 3])
            for r in CORRELATIONS
        ],
    }
    path.write_text(format_study(found), "utf-8")
    table = pd.DataFrame(found["main"])
    print(table.groupby(["interval", "wider"], sort=False)["coverage"].describe())


if __name__ == "__main__":
    default = Path(__file__).parents[1] / "data" / "results" / "coverage.json"
    main(Path(sys.argv[1]) if sys.argv[1:] else default)
