"""What differs between machines: the same work under other numeric instructions.

`python benchmarks/determinism.py` does a search, fits a skill and executes all stored
policies of both workspaces in processes of their own: with one and with two BLAS
threads, and as a processor without AVX2 and AVX-512 would. The differences from the
first go to `data/results/determinism.json`.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from msc import Arm, ParameterizedSkill, Workspace, load_dataset, search_policy

VARIANTS = {
    "same": {},
    "two_threads": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"},
    "older_processor": {
        "OPENBLAS_CORETYPE": "Sandybridge",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
    },
}


def work() -> dict[str, list[float]]:
    """Do what the variants are compared by."""
    distances = {}
    for workspace in (Workspace.obstacles(), Workspace.free()):
        tasks, policies, _ = data = load_dataset(workspace.name)
        with Arm(workspace) as arm:
            rollouts = arm.execute_many(policies, data.task_deg.tolist())
        distances[f"distance_{workspace.name}_m"] = [one.error for one in rollouts]
    found = search_policy(Workspace.free(), 200, seed=3, n_starts=1)
    skill = ParameterizedSkill(random_state=0).fit(tasks[::15], policies[::15])
    return {
        **distances,
        "searched_policy": found.policy.tolist(),
        "predicted_policies": skill.predict(tasks).ravel().tolist(),
    }


def work_under(variant: dict[str, str]) -> dict[str, NDArray[np.float64]]:
    """Do it in a process of its own, with other settings."""
    alone = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    ran = subprocess.run(
        [sys.executable, __file__, "work"],
        env={**os.environ, **alone, **variant},
        capture_output=True,
        text=True,
        check=True,
    )
    return {key: np.array(value) for key, value in json.loads(ran.stdout).items()}


def main() -> None:
    """Compare the variants with a plain run."""
    plain = work_under({})
    differences = {
        name: {
            key: float(np.abs(value - plain[key]).max())
            for key, value in work_under(variant).items()
        }
        for name, variant in VARIANTS.items()
    }
    scale = float(np.linalg.norm(plain["searched_policy"]))
    found = {**differences, "policy_norm": scale}
    folder = Path(__file__).parents[1] / "data" / "results"
    text = json.dumps(found, indent=2) + "\n"
    (folder / "determinism.json").write_text(text, "utf-8")
    print(text, end="")


if __name__ == "__main__":
    if sys.argv[1:] == ["work"]:
        json.dump(work(), sys.stdout)
    else:
        main()
