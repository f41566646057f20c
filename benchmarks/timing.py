"""Stopwatches: calls in turn, so that whatever else the machine does hits all alike."""

import contextlib
import re
import resource
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from tqdm import tqdm


def interleave(
    calls: Mapping[str, Callable[[], object]], n_rounds: int, title: str
) -> dict[str, np.ndarray]:
    """Run all calls once unmeasured, then in turn; return their seconds by round."""
    for call in calls.values():
        call()
    seconds = {name: np.empty(n_rounds) for name in calls}
    for number in tqdm(range(n_rounds), desc=title, unit="round"):
        for name, call in calls.items():
            seconds[name][number] = clock(call)
    return seconds


def clock(call: Callable[[], object]) -> float:
    """Return the seconds that a call takes."""
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


def spread(values: np.ndarray) -> dict[str, float]:
    """Return the median over the rounds, and where the middle four fifths lie."""
    low, median, high = np.percentile(values, [10, 50, 90])
    return {"median": float(median), "low": float(low), "high": float(high)}


def peak_mb() -> float:
    """Return the largest memory that the process has had so far (MB).

    Linux hands `ru_maxrss` down from the parent, so its own record is read there.
    """
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = re.findall(r"VmHWM:\s+(\d+) kB", status.read_text("utf-8"))
        return int(line) * 1024 / 1e6
    unit = 1 if sys.platform == "darwin" else 1024  # of bytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


class Spy(SimpleNamespace):
    """PyBullet's functions, but the time in physics is kept, and all torques are.

    Its own wrappers cost some 3 % of a rollout, so what is timed runs without it.
    """

    def __init__(self, bullet: Any) -> None:
        super().__init__(**vars(bullet))
        self.seconds, self.torques = 0.0, []
        step, push = bullet.stepSimulation, bullet.setJointMotorControlArray

        def timed_step(**world: int) -> None:
            begun = time.perf_counter()
            step(**world)
            self.seconds += time.perf_counter() - begun

        def kept_push(*command: Any, forces: list[float], **world: int) -> None:
            self.torques.append(forces)
            push(*command, forces=forces, **world)

        self.stepSimulation, self.setJointMotorControlArray = timed_step, kept_push

    @contextlib.contextmanager
    def watch(self, world: Any) -> Iterator[None]:
        """Stand in for the module in a world, for a while."""
        world._bullet, module = self, world._bullet
        try:
            yield
        finally:
            world._bullet = module
