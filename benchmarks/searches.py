"""Whole tasks: searched in several ways, many by several workers, or predicted."""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import cma
import numpy as np
from joblib import Parallel, delayed, parallel_config
from timing import clock, spread
from tqdm import tqdm

from msc import DMP, SMCE, ParameterizedSkill, Workspace, load_dataset, search_policy
from msc.robot import cached_arm
from msc.search import (
    SearchOptions,
    SearchResult,
    SweepPlan,
    cost,
    grid,
    search_policies,
    search_tasks,
)
from msc.study import take_evenly

SEED = 0
MANY = 1000  # tasks predicted in one call


# The search as it was before it had a surrogate; but that gave up a run that was twice
# as dear as another after 1200 rollouts, which few runs have. Here none is given up.
PLAIN = {"agreement": 2.0, "tolerance": 1e-7, "stalled": 40, "patience": 1e9}


def measure_searches(
    workspace: Workspace, n_tasks: int, n_starts: int, options: SearchOptions
) -> dict[str, Any]:
    """Search evenly spaced tasks, none with a neighbour's policy, in several ways.

    In lock-step all tasks together; else one by one, the ways in turn. pycma's searches
    have one start, the first of ours, and stop by its own rules.
    """
    warm_up(workspace)
    tasks_deg = grid(n_tasks, offset_deg=180 / n_tasks)
    plain = replace(options, **PLAIN)
    begun = time.perf_counter()
    together = search_policies(
        workspace, tasks_deg, seed=SEED, n_starts=n_starts, options=options
    )
    share = (time.perf_counter() - begun) / n_tasks
    found = {"lockstep": [(share, *summarise(result)) for result in together]}
    search = partial(search_policy, workspace, seed=SEED, n_starts=n_starts)
    by_pycma = partial(search_by_pycma, workspace, most=options.max_evaluations)
    ways = {
        "alone": lambda task: summarise(search(task, options=options)),
        "plain": lambda task: summarise(search(task, options=plain)),
        "lq_surr2": lambda task: by_pycma(cma.fmin_lq_surr2, task),
        "fmin2": lambda task: by_pycma(cma.fmin2, task),
    }
    found |= {way: [] for way in ways}
    for task in tqdm(tasks_deg, desc=f"searches, {workspace.name}", unit="task"):
        for way, call in ways.items():
            begun = time.perf_counter()
            numbers = call(task)
            found[way].append((time.perf_counter() - begun, *numbers))
    keys = "seconds", "evaluations", "cost", "first_evaluations", "first_cost"
    return {
        "n_starts": n_starts,
        "tasks_deg": tasks_deg,
        "ways": {
            way: dict(zip(keys, map(list, zip(*rows, strict=True)), strict=True))
            for way, rows in found.items()
        },
    }


def summarise(result: SearchResult) -> tuple[int, float, int, float]:
    """Return rollouts and cost of a search, and of its first start."""
    first = result.runs[0]
    return result.evaluations, result.cost, first.evaluations, first.cost


def search_by_pycma(
    workspace: Workspace, minimise: Callable[..., Any], task_deg: float, *, most: int
) -> tuple[int, float, int, float]:
    """Search by one of pycma's functions, as it comes, in a world with one arm."""
    arm, rng = cached_arm(workspace, n_parallel=1), np.random.default_rng(SEED)
    costs = []

    def pay(policy: np.ndarray) -> float:
        costs.append(cost(arm.execute(policy, task_deg)))
        return costs[-1]

    draws = {"seed": np.nan, "randn": lambda *size: rng.standard_normal(size)}
    quiet = {"verbose": -9, "verb_log": 0, "maxfevals": most}
    step = SearchOptions().first_step * DMP().spring
    minimise(pay, np.zeros(DMP().n_params), step, {**draws, **quiet})
    return (len(costs), min(costs)) * 2


def measure_circles(
    workspace: Workspace, numbers: Sequence[int], n_starts: int, options: SearchOptions
) -> list[dict[str, Any]]:
    """Search more and more tasks with two workers, and the middle number with one."""
    with parallel_config("loky", n_jobs=2, inner_max_num_threads=1):
        Parallel()(delayed(warm_up)(workspace) for _ in range(4))
    runs = [(1, numbers[len(numbers) // 2]), *((2, number) for number in numbers)]
    rows = []
    for workers, n_tasks in runs:
        plan = SweepPlan(workspace, grid(n_tasks), SEED, n_starts, (), options)
        begun = time.perf_counter()
        table = search_tasks(plan, jobs=workers, progress=True)
        seconds = time.perf_counter() - begun
        rows.append(
            {
                "workers": workers,
                "tasks": n_tasks,
                "seconds": seconds,
                "tasks/s": n_tasks / seconds,
                "rollouts/task": table["evaluations"].mean(),
            }
        )
    return rows


def warm_up(workspace: Workspace) -> None:
    """Load everything in a process and build its worlds; leave others time to."""
    for size in (1, 3, 9):
        cached_arm(workspace, n_parallel=size).execute(np.zeros(6), task_deg=0)
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
