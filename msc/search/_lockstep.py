"""Searches in lock-step: each asks for a few rollouts, a physics world runs nine.

A world with nine arms steps in little more time than one with a single arm, and an arm
does bit for bit what it would do alone. So searches of several tasks go on together,
each of them as if alone: what one finds does not depend on the others.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from msc.robot import DMP, Rollout, Workspace, cached_arm

T = TypeVar("T")
# Yields policies, rows of an array, is sent their rollouts, and returns what it found.
Search = Generator[NDArray[np.float64], Sequence[Rollout], T]

N_PARALLEL = 9  # searches that go on together
_SIZES = (1, 3, N_PARALLEL)  # arms of the worlds kept; the smallest that holds all


def run_in_lockstep(
    workspace: Workspace,
    searches: Iterable[tuple[float | Sequence[float], Search[T]]],
    dmp: DMP | None = None,
) -> Iterator[tuple[int, T]]:
    """Carry out searches, task (degrees) and steps of each, nine at a time.

    They are taken as there is room; yields their numbers and what they found, as they
    end.
    """
    waiting = iter(enumerate(searches))
    going: dict[int, tuple[float | Sequence[float], Search[T]]] = {}
    answers: dict[int, list[Rollout]] = {}
    while True:
        while len(going) < N_PARALLEL and (new := next(waiting, None)):
            going[new[0]] = new[1]
        if not going:
            return
        asked: dict[int, NDArray[np.float64]] = {}
        for number, (_, search) in list(going.items()):
            try:
                asked[number] = search.send(answers.get(number))  # type: ignore[arg-type]
            except StopIteration as end:
                del going[number]
                yield number, end.value
        angles = [going[number][0] for number, rows in asked.items() for _ in rows]
        policies = [policy for rows in asked.values() for policy in rows]
        rollouts = iter(_execute(workspace, dmp, policies, angles))
        answers = {n: [next(rollouts) for _ in rows] for n, rows in asked.items()}


def _execute(
    workspace: Workspace,
    dmp: DMP | None,
    policies: list[NDArray[np.float64]],
    angles: list[Any],
) -> list[Rollout]:
    """Execute policies in worlds of as many arms as they need."""
    rollouts: list[Rollout] = []
    for first in range(0, len(policies), N_PARALLEL):
        batch = slice(first, first + N_PARALLEL)
        size = next(size for size in _SIZES if size >= len(policies[batch]))
        arm = cached_arm(workspace, dmp, n_parallel=size)
        rollouts += arm.execute_many(policies[batch], angles[batch])
    return rollouts
