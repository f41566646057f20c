"""The learners: SMCE against cvxpy point by point and against itself, skill against GP.

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
from sklearn.neighbors import NearestNeighbors
from threadpoolctl import threadpool_limits
from timing import clock, interleave, peak_mb, spread
from tqdm import tqdm

from msc import SMCE, ParameterizedSkill, Workspace, load_dataset
from msc.study import take_evenly

SEED = 0
PIECES, DIMENSIONS, NOISE = 4, 6, 1e-3
REGULARIZATION, NEIGHBORS = 10.0, 20  # SMCE's defaults


def sample_curves(n_points: int) -> np.ndarray:
    """Draw points of four smooth curves in R^6, with a little noise."""
    rng = np.random.default_rng(SEED)
    piece = np.arange(n_points) * PIECES // n_points
    along = np.arange(n_points) * PIECES / n_points - piece
    speed, phase = rng.uniform(2, 12, (2, PIECES, DIMENSIONS))
    curves = np.sin(speed[piece] * along[:, None] + phase[piece])
    place = rng.normal(size=(PIECES, DIMENSIONS))[piece]
    return curves + place + NOISE * rng.normal(size=curves.shape)


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


def measure_fits(numbers: Sequence[int]) -> list[dict[str, Any]]:
    """Fit SMCE to more and more points, each in a process of its own, on one core."""
    fits = []
    for n_points in tqdm(numbers, desc="SMCE, more points", unit="fit"):
        command = [sys.executable, __file__, f"{n_points}"]
        ran = subprocess.run(command, capture_output=True, text=True, check=True)
        fits.append(json.loads(ran.stdout))
    return fits


def fit_once(n_points: int) -> dict[str, Any]:
    """Fit SMCE once; tell the time, and the largest memory of this process."""
    X = sample_curves(n_points)
    SMCE(random_state=SEED).fit(X[:30])  # load everything first
    before = peak_mb()
    with threadpool_limits(1):
        seconds = clock(lambda: SMCE(random_state=SEED).fit(X))
    peak = peak_mb()
    return {
        "n_points": n_points,
        "seconds": seconds,
        "before_mb": before,
        "peak_mb": peak,
    }


def measure_skills(
    workspace: Workspace, n_samples: int, n_charts: int, n_rounds: int
) -> dict[str, Any]:
    """Fit and ask the skill with charts and the single Gaussian process, in turn."""
    tasks, policies, _ = load_dataset(workspace.name)
    chosen = take_evenly(tasks, n_samples)
    X, y = tasks[chosen], policies[chosen]
    new = np.random.default_rng(SEED).uniform(0, 2 * np.pi, (1000, 1))
    skills = {
        "charts": ParameterizedSkill(SMCE(n_charts), random_state=SEED),
        "single": ParameterizedSkill(None, random_state=SEED),
    }
    for skill in skills.values():
        skill.fit(X, y)
    calls = {
        f"fit {name}": lambda s=skill: s.fit(X, y) for name, skill in skills.items()
    }
    calls |= {
        f"predict {name}": lambda s=skill: s.predict(new)
        for name, skill in skills.items()
    }
    seconds = interleave(calls, n_rounds, f"skill, {workspace.name}")
    return {
        "n_samples": n_samples,
        "n_charts": n_charts,
        "n_predicted": len(new),
        **{
            f"{step}_{name}_milliseconds": spread(1000 * seconds[f"{step} {name}"])
            for step in ("fit", "predict")
            for name in skills
        },
        **{
            f"{step}_charts_over_single": spread(
                seconds[f"{step} charts"] / seconds[f"{step} single"]
            )
            for step in ("fit", "predict")
        },
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Fit SMCE once, in this process.")
    parser.add_argument("n_points", type=int)
    print(json.dumps(fit_once(parser.parse_args().n_points)))
