"""Whole tasks: searched one by one, many by several workers, or predicted."""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from joblib import Parallel, delayed, parallel_config
from timing import clock, spread
from tqdm import tqdm

from msc import DMP, SMCE, ParameterizedSkill, Workspace, load_dataset, search_policy
from msc.robot import cached_arm
from msc.search import SearchOptions, SweepPlan, grid, search_tasks
from msc.study import take_evenly

SEED = 0
MANY = 1000  # tasks predicted in one call


def measure_searches(
    workspace: Workspace, n_tasks: int, n_starts: int, options: SearchOptions
) -> dict[str, Any]:
    """Search evenly spaced tasks one by one, each without a neighbour's policy."""
    warm_up(workspace)
    tasks_deg = grid(n_tasks, offset_deg=180 / n_tasks)
    seconds, evaluations = [], []
    for task in tqdm(tasks_deg, desc=f"searches, {workspace.name}", unit="task"):
        begun = time.perf_counter()
        found = search_policy(
            workspace, task, seed=SEED, n_starts=n_starts, options=options
        )
        seconds.append(time.perf_counter() - begun)
        evaluations.append(found.evaluations)
    return {
        "n_starts": n_starts,
        "tasks_deg": tasks_deg,
        "seconds": seconds,
        "evaluations": evaluations,
        "seconds_per_task": float(np.mean(seconds)),
        "evaluations_per_task": float(np.mean(evaluations)),
        "milliseconds_per_evaluation": 1000 * sum(seconds) / sum(evaluations),
    }


def measure_growth(
    workspace: Workspace, numbers: Sequence[int], n_starts: int, options: SearchOptions
) -> dict[str, Any]:
    """Search more and more tasks with two workers, and once with one.

    That one is of the middle number of tasks.
    """
    with parallel_config("loky", n_jobs=2, inner_max_num_threads=1):
        Parallel()(delayed(warm_up)(workspace) for _ in range(4))
    middle = numbers[len(numbers) // 2]
    plans = [
        SweepPlan(workspace, grid(n), SEED, n_starts, (), options) for n in numbers
    ]
    runs = [run(plan, workers=2) for plan in plans]
    runs.append(run(plans[len(plans) // 2], workers=1))
    by_workers = {one["workers"]: one for one in runs if one["n_tasks"] == middle}
    alone, together = by_workers[1]["seconds"], by_workers[2]["seconds"]
    return {
        "workspace": workspace.name,
        "n_starts": n_starts,
        "runs": runs,
        "tasks_per_second_1_worker": middle / alone,
        "tasks_per_second_2_workers": middle / together,
        "speedup_by_2_workers": alone / together,
    }


def run(plan: SweepPlan, workers: int) -> dict[str, Any]:
    """Search a whole circle of tasks, consistency pass included."""
    n_tasks = len(plan.tasks_deg)
    begun = time.perf_counter()
    table = search_tasks(plan, jobs=workers, progress=True)
    seconds = time.perf_counter() - begun
    evaluations = int(table["evaluations"].sum())
    return {
        "n_tasks": n_tasks,
        "workers": workers,
        "seconds": seconds,
        "evaluations": evaluations,
        "evaluations_per_task": evaluations / n_tasks,
        "tasks_per_second": n_tasks / seconds,
    }


def warm_up(workspace: Workspace) -> None:
    """Load everything in a process and build its world; leave others time to."""
    cached_arm(workspace, DMP()).execute(np.zeros(6), task_deg=0)
    time.sleep(0.2)


def measure_skill(
    workspace: Workspace, n_samples: int, n_charts: int, n_rounds: int
) -> dict[str, Any]:
    """Fit a skill to searched policies, and predict: one task a call, and many."""
    tasks, policies, _ = load_dataset(workspace.name)
    chosen = take_evenly(tasks, n_samples)
    charts = SMCE(n_charts, random_state=SEED)
    skill = ParameterizedSkill(charts, random_state=SEED)
    fitting = clock(lambda: skill.fit(tasks[chosen], policies[chosen]))
    rng = np.random.default_rng(SEED)
    new = rng.uniform(0, 2 * np.pi, (n_rounds, MANY, 1))
    one = [clock(lambda x=x: skill.predict(x[:1])) for x in new]
    many = [clock(lambda x=x: skill.predict(x)) / MANY for x in new]
    return {
        "n_samples": n_samples,
        "n_charts": skill.n_charts_,
        "n_predicted": MANY,
        "fit_seconds": fitting,
        "predict_one_microseconds": spread(1e6 * np.array(one)),
        "predict_many_microseconds": spread(1e6 * np.array(many)),
    }
