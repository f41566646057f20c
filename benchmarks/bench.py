"""What a rollout, a search, a fit and a prediction cost, side by side in one run.

Prints the figures and keeps them as JSON, from which the book's chapter "What it costs"
is made. To be run on a machine that does nothing else; `--quick` only shows that all
parts work.
"""

import argparse
import os
import platform
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import mujoco_arm
import processes
from learners import measure_fits, measure_skills, measure_smce
from rollouts import measure_memory, measure_rollouts
from searches import measure_circles, measure_searches, measure_skill
from threadpoolctl import threadpool_limits

from msc import Workspace
from msc.plots import benchmark_table
from msc.search import SearchOptions
from press import write_json

RESULTS = Path(__file__).parents[1] / "data" / "results" / "bench.json"
PACKAGES = (
    "numpy",
    "scipy",
    "scikit-learn",
    "cvxpy",
    "pybullet",
    "cma",
    "joblib",
    "mujoco",
    "GPy",
)


SHOWN = "rollouts", "searches", "tasks", "growth", "SMCE", "skills"


@dataclass(frozen=True)
class Effort:
    """How much to measure."""

    rounds: int = 40  # of rollouts each way
    populations: int = 300  # while memory is watched
    tasks: int = 12  # searched in each world, each way
    starts: int = 3  # of a search
    growth: tuple[int, ...] = (4, 8, 16)  # tasks searched together
    samples: int = 24  # that the skill is fitted to
    charts: int = 4
    points: int = 360  # clustered by SMCE, and one by one
    grown: tuple[int, ...] = (1000, 2500, 10_000, 50_000)  # points clustered by SMCE
    learned: int = 5  # rounds of fits
    fits: tuple[int, ...] = (360, 1000, 2000, 10_000)  # samples of skills
    most: dict[str, int] = field(
        default_factory=lambda: {"others": 1000, "across jumps": 2000}
    )
    predicted: int = 100_000  # tasks
    search: SearchOptions = field(default_factory=SearchOptions)


QUICK = Effort(
    rounds=2,
    populations=5,
    tasks=2,
    starts=1,
    growth=(2,),
    samples=8,
    charts=2,
    points=30,
    grown=(60,),
    learned=1,
    fits=(12, 361),
    most={"others": 12, "across jumps": 12},
    predicted=100,
    search=SearchOptions(max_evaluations=27, max_sweeps=0),
)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="only try all parts")
    parser.add_argument("--out", type=Path, default=RESULTS, help="the JSON file")
    options = parser.parse_args()
    with threadpool_limits(1):
        figures = measure(QUICK if options.quick else Effort())
    figures = {"quick": options.quick, "machine": machine(), **figures}
    show(figures)
    write_json(options.out, figures)
    print(f"\nWritten to {options.out}")


def measure(effort: Effort) -> dict[str, Any]:
    """Measure everything; what is compared is interleaved."""
    free, obstacles = worlds = Workspace.free(), Workspace.obstacles()
    smce = measure_smce(effort.points, effort.learned)
    return {
        "memory": measure_memory(obstacles, effort.populations),
        "rollouts": {w.name: measure_rollouts(w, effort.rounds) for w in worlds},
        "searches": {
            w.name: measure_searches(w, effort.tasks, effort.starts, effort.search)
            for w in worlds
        },
        "growth": measure_circles(free, effort.growth, effort.starts, effort.search),
        "skill": {
            w.name: measure_skill(w, effort.samples, effort.charts, effort.rounds)
            for w in worlds
        },
        "learners": {
            "smce": smce,
            "fits": measure_fits(smce, effort.grown),
            "skills": measure_skills(
                effort.fits, effort.most, effort.learned, effort.predicted
            ),
        },
    }


def machine() -> dict[str, Any]:
    """Say on what and with what was measured."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text("utf-8").splitlines() if cpuinfo.is_file() else []
    models = [line.partition(": ")[2] for line in lines if "model name" in line]
    versions = {name: version(name) for name in PACKAGES}
    return {
        "cores": os.cpu_count(),
        "cpu": models[0] if models else platform.processor(),
        "python": platform.python_version(),
        **versions,
    }


def version(package: str) -> str | None:
    """Return the version of a package, or None if it is not installed."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def show(figures: dict[str, Any]) -> None:
    """Print the tables of the chapter, and what they do not compare."""
    facts = ", ".join(f"{name} {value}" for name, value in figures["machine"].items())
    print(f"\n{facts}\n")
    for what in SHOWN:
        print(benchmark_table(figures, what).to_string(), end="\n\n")
    memory = figures["memory"]
    print(
        f"memory: {memory['growth_mb']:.1f} MB more after {memory['rollouts']} "
        f"rollouts, of {memory['before_mb']:.0f} MB"
    )
    if processes.GPy is None:
        print("GPy is left out; pip install 'msc[gpy]' adds it.")
    if mujoco_arm.rollout is None:
        print("MuJoCo is left out; pip install 'msc[mujoco]' adds it.")
    else:
        print(
            "MuJoCo's rollout is C throughout and follows the torques of our rollouts: "
            "no path, no inverse kinematics, no controller, nothing read in between."
        )


if __name__ == "__main__":
    main()
