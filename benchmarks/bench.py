"""Speed of a rollout in the search, beside raw physics and a naive loop in one run."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from msc.arm import N_STEPS, Arm
from msc.bullet import load_pybullet
from msc.kinematics import follow_path
from msc.workspace import Workspace

ROUNDS = 7  # the quickest counts: the others waited for something else


def quickest(call: Callable[[], object]) -> float:
    """Return the seconds of the quickest of several calls."""
    seconds = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


def measure(workspace: Workspace) -> dict[str, float]:
    """Time rollouts as the search runs them, one by one, and the physics alone."""
    policies = np.random.default_rng(0).normal(0, 8, (9, 6))
    bullet = load_pybullet()
    many, one = Arm(workspace), Arm(workspace, n_parallel=1)
    one.execute(policies[0], 120)
    path = np.zeros((N_STEPS, 2)) + workspace.target(120)

    def physics() -> None:
        for _ in range(N_STEPS):
            bullet.stepSimulation(physicsClientId=one.client_id)

    def search() -> None:
        many.execute_many(policies, 120)

    def alone() -> None:
        one.execute(policies[0], 120)

    def kinematics() -> None:
        follow_path(path, workspace.home, workspace.link_lengths)

    raw, in_search = quickest(physics), quickest(search) / len(policies)
    naive = quickest(alone) + quickest(kinematics)
    return {
        "rollouts_per_second": 1 / in_search,
        "rollout_over_raw_steps": in_search / raw,
        "naive_loop_over_raw_steps": naive / raw,
    }


def main() -> None:
    """Measure both workspaces, print the figures and keep them as JSON."""
    worlds = (Workspace.free(), Workspace.obstacles())
    figures = {world.name: measure(world) for world in worlds}
    for name, values in figures.items():
        for key, value in values.items():
            print(f"{name:10} {key.replace('_', ' '):28} {value:8.2f}")
    file = Path(__file__).with_name("results.json")
    file.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
