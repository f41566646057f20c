"""One rollout: in the search, in plain loops, in MuJoCo, and its physics alone."""

from collections.abc import Callable

import numpy as np
from mujoco_arm import MujocoArm, rollout
from naive import ArrayFollower, FloatFollower, PlainArm
from timing import Spy, interleave, peak_mb, spread
from tqdm import tqdm

from msc import Arm, Workspace, load_dataset
from msc.robot import Physics
from msc.search import cost

POPULATION = 9  # policies that CMA-ES asks for at a time


def measure_rollouts(workspace: Workspace, n_rounds: int) -> dict[str, object]:
    """Compare what one rollout takes, each way in turn, round after round.

    Returns the milliseconds of a rollout each way, and ratios within a round.
    """
    contest = Contest(workspace)
    seconds = interleave(contest.ways, n_rounds, f"rollouts, {workspace.name}")
    del seconds["watched"]
    seconds["own_steps"] = np.array(contest.own_steps[-n_rounds:])
    ours = seconds["search"]
    raw, own, naive, floats = (
        seconds[way] for way in ("raw_steps", "own_steps", "naive", "floats")
    )
    mujoco = seconds.get("mujoco")
    milliseconds = {
        way: spread(1000 * values / POPULATION) for way, values in seconds.items()
    }
    return {
        "rollouts_per_second": spread(POPULATION / ours),
        "rollout_over_raw_steps": spread(ours / raw),
        "rollout_over_own_steps": spread(ours / own),
        "speedup_over_naive": spread(naive / ours),
        "speedup_over_floats": spread(floats / ours),
        "rollout_over_mujoco": None if mujoco is None else spread(ours / mujoco),
        "milliseconds": {"mujoco": None} | milliseconds,
        "apart_mm": contest.apart_mm(),
    }


class Contest:
    """Nine tasks round the circle and their searched policies, executed in all ways.

    Attributes
    ----------
    ways : dict from str to callable
        What to time; each call is as good as nine rollouts.
    own_steps : list of float
        Seconds within `stepSimulation`, of each call of ``ways["watched"]``.
    """

    def __init__(self, workspace: Workspace) -> None:
        data = load_dataset(workspace.name)
        n_tasks = len(data.tasks)
        chosen = np.linspace(0, n_tasks, POPULATION, endpoint=False).astype(int)
        self.tasks_deg = data.task_deg[chosen].tolist()
        self.policies = data.policies[chosen]
        self.arm, self.plain, self.still = (
            Arm(workspace),
            PlainArm(workspace),
            PlainArm(workspace),
        )
        self.spy = Spy(self.arm._world._bullet)
        self.own_steps: list[float] = []
        self.ways: dict[str, Callable[[], object]] = {
            "search": self.search,
            "watched": self.watched,
            "raw_steps": lambda: [self.still.step_only() for _ in self.policies],
            "naive": lambda: self.loop(ArrayFollower),
            "floats": lambda: self.loop(FloatFollower),
        }
        if rollout is not None:
            torques, arm = self.torques(), MujocoArm(workspace)
            self.mujoco_ends = arm.ends(torques)
            self.ways["mujoco"] = lambda: arm.execute(torques)

    def search(self) -> list[float]:
        """Do what CMA-ES asks for: path, joints, PID loop, costs, nine at a time."""
        rollouts = self.arm.execute_many(self.policies, self.tasks_deg)
        return [cost(one) for one in rollouts]

    def watched(self) -> None:
        """Do the same under the spy's eyes, which take a thirtieth of the time."""
        self.spy.seconds = 0.0
        self.spy.torques.clear()
        with self.spy.watch(self.arm._world):
            self.search()
        self.own_steps.append(self.spy.seconds)

    def loop(self, follower: type) -> list[tuple[float, np.ndarray]]:
        """Do the same one by one."""
        work = zip(self.policies, self.tasks_deg, strict=True)
        return [self.plain.execute(*one, follower) for one in work]

    def torques(self) -> np.ndarray:
        """Return the torques of the search's rollouts (n_rollouts, n_steps, 3)."""
        self.watched()
        return np.reshape(
            self.spy.torques, (Physics().n_steps, POPULATION, 3)
        ).swapaxes(0, 1)

    def apart_mm(self) -> dict[str, float | None]:
        """Return how far from ours the other ways end: that all do the same job.

        Medians over the policies that met no obstacle: after a contact, given torques
        lead elsewhere.
        """
        rollouts = self.arm.execute_many(self.policies, self.tasks_deg)
        free = [not one.touched for one in rollouts]
        ours = np.array([one.path[-1] for one in rollouts])
        others = {"naive": np.array([end for _, end in self.loop(ArrayFollower)])}
        if rollout is not None:
            others["mujoco"] = self.mujoco_ends
        return {"mujoco": None} | {
            way: float(1000 * np.median(np.linalg.norm((ends - ours)[free], axis=1)))
            for way, ends in others.items()
        }


def measure_memory(workspace: Workspace, n_populations: int) -> dict[str, float]:
    """Watch the process's largest memory while populations are executed."""
    policies = np.random.default_rng(0).normal(0, 8, (POPULATION, 6))
    with Arm(workspace) as arm:
        for _ in range(max(5, n_populations // 10)):  # all caches filled
            arm.execute_many(policies, 120)
        before = peak_mb()
        for _ in tqdm(range(n_populations), desc="memory", unit="population"):
            arm.execute_many(policies, 120)
        after = peak_mb()
    return {
        "populations": n_populations,
        "rollouts": n_populations * POPULATION,
        "before_mb": before,
        "after_mb": after,
        "growth_mb": after - before,
    }
