"""What each method takes to fit and to predict, beside the charts of the same round.

`python benchmarks/methods.py` fits every method of `msc.study.METHODS` to the first
evenly spaced training sets of the world with obstacles, its tuning included, and
predicts the 120 test tasks: one process, one thread, seconds of the processor, so that
what else the machine does hardly counts. The result goes to `data/results/times.json`.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from bench import machine
from threadpoolctl import threadpool_limits
from timing import spread
from tqdm import tqdm

from msc import Workspace, load_dataset
from msc.data import describe_origin, find_data
from msc.estimates import six_digits
from msc.study import METHODS, draw_samples, fit_methods, format_study
from msc.study._study import PROFILES
from press import replace_file

RESULTS = Path(__file__).parents[1] / "data" / "results" / "times.json"
WORLD = "obstacles"
SIZES = (12, 24, 50)
ROUNDS = 3
LIKE = "charts"
LONG = 1.0  # seconds; what takes less is done again, warm,
SHORT = 0.2  # for so many
GRID, TEST = load_dataset(WORLD), load_dataset(f"{WORLD}_test")


def main() -> None:
    """Measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few methods, one round")
    parser.add_argument("--methods", nargs="+", help="these alone; the others are kept")
    parser.add_argument("--out", type=Path, default=RESULTS, help="the JSON file")
    options = parser.parse_args()
    names = [name for name, method in METHODS.items() if method.sets != "sweep"]
    sizes, rounds = SIZES, ROUNDS
    if options.quick:
        names, sizes, rounds = [LIKE, "nearest neighbour", "CrKr"], (12,), 1
    tables = (find_data() / f"{name}.csv" for name in (WORLD, f"{WORLD}_test"))
    found = {
        "quick": options.quick,
        "world": WORLD,
        "machine": machine(),
        "provenance": describe_origin("python benchmarks/methods.py", *tables),
        "rounds": rounds,
        "n_predicted": len(TEST.tasks),
        "methods": {},
    }
    if options.methods:
        names = options.methods
        found["methods"] = known_before(options.out, found)
    with threadpool_limits(1):
        found["methods"] |= measure(names, sizes, rounds)
    replace_file(options.out, format_study(found).encode())


def known_before(path: Path, like: dict[str, Any]) -> dict[str, Any]:
    """Return what was measured before, if under the same conditions."""
    before = json.loads(path.read_text("utf-8"))
    differ = [key for key in like if key != "methods" and before[key] != like[key]]
    if differ:
        raise SystemExit(f"{path} has another {', '.join(differ)}: measure all anew")
    return dict(before["methods"])


def measure(names: list[str], sizes: tuple[int, ...], rounds: int) -> dict[str, Any]:
    """Time all methods in turn, round after round, each with a training set more."""
    names = [LIKE, *(name for name in names if name != LIKE)]
    fits: dict[tuple[str, int], list[float]] = {}
    predictions: dict[tuple[str, int], list[float]] = {}
    timed = {name: sizes_of(name, sizes) for name in names}
    turns = [
        (k, n, name)
        for k in range(rounds)
        for n in sizes
        for name in names
        if n in timed[name]
    ]
    for number, n_samples, name in tqdm(turns, unit="fit"):
        known = training_set(n_samples, number)
        fit, predict = time_method(name, known)
        fits.setdefault((name, n_samples), []).append(fit)
        predictions.setdefault((name, n_samples), []).append(predict)
    return {
        name: {
            what: {
                f"{n}": summarise(taken[name, n], taken[LIKE, n]) for n in timed[name]
            }
            for what, taken in (("fit", fits), ("predict", predictions))
        }
        for name in names
    }


def sizes_of(name: str, sizes: tuple[int, ...]) -> tuple[int, ...]:
    """Return the numbers of training tasks that a method is tried on, of those."""
    few = METHODS[name].sets == "few"
    return tuple(n for n in sizes if not few or n in PROFILES["full"].few_sizes)


def training_set(n_samples: int, number: int) -> tuple[Any, ...]:
    """Return the tasks, policies and costs of an evenly spaced training set."""
    drawn = draw_samples("even", GRID.tasks, n_samples, n_draws=ROUNDS)[number]
    return GRID.tasks[drawn], GRID.policies[drawn], GRID.table["cost"].to_numpy()[drawn]


def time_method(name: str, known: tuple[Any, ...]) -> tuple[float, float]:
    """Return the seconds of a fit, and of the prediction of all test tasks."""
    fitted: dict[str, Any] = {}

    def fit() -> None:
        how: Any = {"names": [name], "seed": 0, "workspace": Workspace.named(WORLD)}
        fitted.update(fit_methods(*known, **how))

    def predict() -> None:
        one = fitted[name]  # whoever stops stored movements predicts no policies
        (one.predict if hasattr(one, "predict") else one.plan)(TEST.tasks)

    return seconds(fit), seconds(predict)


def seconds(call: Callable[[], object]) -> float:
    """Return the seconds that a call takes, warmed up if it is short."""
    taken, times = clock(call), 1
    if taken < LONG:
        taken, times = 0.0, 0
        while taken < SHORT:
            taken, times = taken + clock(call), times + 1
    return taken / times


def clock(call: Callable[[], object]) -> float:
    """Return the seconds of the processor that a call takes."""
    begun = time.process_time()
    call()
    return time.process_time() - begun


def summarise(taken: list[float], like: list[float]) -> dict[str, Any]:
    """Summarise seconds, and ratios to what the charts took in the same round."""
    parts = {"seconds": np.array(taken), "over_charts": np.divide(taken, like)}
    return {
        name: {key: six_digits(one) for key, one in spread(values).items()}
        for name, values in parts.items()
    }


if __name__ == "__main__":
    main()
