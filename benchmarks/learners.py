"""The learners: SMCE beside cvxpy point by point, skills beside other libraries' GPs.

Run as a program it measures one fit of SMCE in a process of its own, whose largest
memory is then that of the fit.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

import cvxpy as cp
import numpy as np
from processes import GivenCharts, GPy, GPyProcess, sklearn_process
from sklearn.neighbors import NearestNeighbors
from threadpoolctl import threadpool_limits
from timing import clock, interleave, peak_mb, spread
from tqdm import tqdm

from msc import SMCE, ParameterizedSkill, load_dataset
from msc.study import take_evenly

SEED = 0
PIECES, DIMENSIONS, NOISE = 4, 6, 1e-3
REGULARIZATION, NEIGHBORS = 10.0, 20  # SMCE's defaults
AT_A_TIME = 5000  # tasks that are asked for: others keep a row of them all in memory


def sample_curves(n_points: int, n_pieces: int = PIECES) -> np.ndarray:
    """Draw points of smooth curves in R^6, one after the other, with a little noise."""
    rng = np.random.default_rng(SEED)
    piece = np.arange(n_points) * n_pieces // n_points
    along = np.arange(n_points) * n_pieces / n_points - piece
    speed, phase = rng.uniform(2, 12, (2, n_pieces, DIMENSIONS))
    curves = np.sin(speed[piece] * along[:, None] + phase[piece])
    place = rng.normal(size=(n_pieces, DIMENSIONS))[piece]
    return curves + place + NOISE * rng.normal(size=curves.shape)


def sample_shape(shape: str, n_points: int) -> np.ndarray:
    """Draw points of a curve, a ring or a sheet in R^6, with a little noise."""
    rng = np.random.default_rng(SEED)
    u, v = rng.uniform(size=(2, n_points))
    places = {
        "curve": [u],
        "ring": [np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)],
        "sheet": [u, v],
    }[shape]
    bends = rng.uniform(1, 3, (len(places), DIMENSIONS))
    points = np.sin(np.transpose(places) @ bends + rng.uniform(0, 6, DIMENSIONS))
    return points + NOISE * rng.normal(size=points.shape)


def solve_one_by_one(X: np.ndarray) -> np.ndarray:
    """Solve the normalised program of each point by a cvxpy problem of its own."""
    search = NearestNeighbors(n_neighbors=min(NEIGHBORS, len(X) - 1)).fit(X)
    distances, neighbors = search.kneighbors()
    objectives = []
    for x, others, lengths in zip(X, neighbors, distances, strict=True):
        columns = (X[others] - x).T / lengths
        c = cp.Variable(len(others))
        near = cp.norm1(cp.multiply(REGULARIZATION * lengths / lengths.sum(), c))
        cost = near + cp.sum_squares(columns @ c) / 2
        problem = cp.Problem(cp.Minimize(cost), [cp.sum(c) == 1])
        objectives.append(problem.solve(cp.CLARABEL))
    return np.array(objectives)


def measure_smce(n_points: int, n_rounds: int) -> dict[str, Any]:
    """Time a whole fit beside one cvxpy problem a point, on the same points."""
    X = sample_curves(n_points)
    seconds = interleave(
        {
            "fit": lambda: SMCE(random_state=SEED).fit(X),
            "one_by_one": lambda: solve_one_by_one(X),
        },
        n_rounds,
        f"SMCE, {n_points} points",
    )
    fitted, expected = SMCE(random_state=SEED).fit(X).objective_, solve_one_by_one(X)
    return {
        "n_points": n_points,
        "fit_seconds": spread(seconds["fit"]),
        "one_by_one_seconds": spread(seconds["one_by_one"]),
        "one_by_one_over_fit": spread(seconds["one_by_one"] / seconds["fit"]),
        "objectives_apart": float(np.max(np.abs(fitted / expected - 1))),
    }


def measure_fits(smce: dict[str, Any], numbers: Sequence[int]) -> list[dict[str, Any]]:
    """Fit SMCE to more and more points, each in a process of its own, on one core.

    The first rows are those of `measure_smce`.
    """
    fits = [
        describe(of, smce["n_points"], smce[f"{key}_seconds"]["median"])
        for of, key in (("four curves", "fit"), ("the same, by cvxpy", "one_by_one"))
    ]
    work = [(shape, f"{n}") for n in numbers for shape in ("curve", "ring", "sheet")]
    for some in tqdm(work, desc="SMCE, more points", unit="fit"):
        command = [sys.executable, __file__, *some]
        ran = subprocess.run(command, capture_output=True, text=True, check=True)
        fits.append(json.loads(ran.stdout))
    return fits


def fit_once(shape: str, n_points: int) -> dict[str, Any]:
    """Fit SMCE once; tell the time, and the largest memory of this process."""
    X = sample_shape(shape, n_points)
    SMCE(random_state=SEED).fit(X[:30])  # load everything first
    before = peak_mb()
    with threadpool_limits(1):
        seconds = clock(lambda: SMCE(random_state=SEED).fit(X))
    return describe(shape, n_points, seconds) | {
        "MB before": before,
        "MB, at most": peak_mb(),
    }


def describe(of: str, n_points: int, seconds: float) -> dict[str, Any]:
    """Return a row of the table of fits, but for its memory."""
    each = 1000 * seconds / n_points
    return {"points": n_points, "of": of, "seconds": seconds, "ms a point": each}


def measure_skills(
    numbers: Sequence[int], most: dict[str, int], n_rounds: int, n_predicted: int
) -> list[dict[str, Any]]:
    """Fit and ask skills with our Gaussian processes and with others', in turn.

    `most` tells up to how many samples the others are fitted, and a single regression
    across jumps, whose length scales are so short that its time grows with the cube.
    """
    new = np.random.default_rng(SEED).uniform(0, 2 * np.pi, (n_predicted, 1))
    parts = np.split(new, range(AT_A_TIME, n_predicted, AT_A_TIME))
    rows = []
    for n_samples in numbers:
        rounds = max(1, n_rounds * numbers[0] // n_samples)
        skills = build_skills(n_samples, most)
        seconds: dict[Any, list[float]] = {key: [] for key in skills}
        for _ in tqdm(range(rounds), desc=f"skills, {n_samples} samples", unit="round"):
            for key, (skill, *samples) in skills.items():
                fitting = clock(lambda s=skill, xy=samples: s.fit(*xy))
                asking = clock(lambda s=skill: [s.predict(part) for part in parts])
                seconds[key].append((fitting, asking))
        for (learner, by), (skill, *_) in skills.items():
            models = [model for chart in skill.regressors_ for model in chart]
            fit, predict = np.median(seconds[learner, by], axis=0)
            rows.append(
                {
                    "samples": n_samples,
                    "learner": learner,
                    "by": by,
                    "fit (s)": fit,
                    "predict (s)": predict,
                    "ln p": sum(
                        model.log_marginal_likelihood_value_ for model in models
                    ),
                }
            )
    return rows


def build_skills(n_samples: int, most: dict[str, int]) -> dict[tuple[str, str], Any]:
    """Pair unfitted skills with samples, by learner and whose processes they have."""
    tables = load_dataset("free"), load_dataset("obstacles")
    if n_samples <= len(tables[0].tasks):
        smooth, jumping = (
            [part[take_evenly(table.tasks, n_samples)] for part in table[:2]]
            for table in tables
        )
        labels = SMCE(PIECES, random_state=SEED).fit_predict(jumping[1])
    else:
        tasks = np.linspace(0, 2 * np.pi, n_samples, endpoint=False)[:, None]
        smooth = [tasks, sample_curves(n_samples, 1)]
        jumping = [tasks, sample_curves(n_samples)]
        labels = np.arange(n_samples) * PIECES // n_samples
    learners = {
        "one smooth curve": (None, smooth),
        "four charts, known": (GivenCharts(labels), jumping),
        "four charts, by SMCE": (SMCE(PIECES), jumping),
        "one regression across jumps": (None, jumping),
    }
    if n_samples > most["across jumps"]:
        del learners["one regression across jumps"]
    processes = {"msc": None}
    if n_samples <= most["others"]:
        processes["scikit-learn"] = sklearn_process()
        processes |= {"GPy": GPyProcess()} if GPy else {}
    return {
        (learner, by): (
            ParameterizedSkill(charts, regressor=process, random_state=SEED),
            *samples,
        )
        for learner, (charts, samples) in learners.items()
        for by, process in processes.items()
        if by == "msc" or learner != "four charts, by SMCE"
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Fit SMCE once, in this process.")
    parser.add_argument("shape")
    parser.add_argument("n_points", type=int)
    print(json.dumps(fit_once(**vars(parser.parse_args()))))
