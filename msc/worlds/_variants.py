"""One choice of ours changed at a time, in both headline worlds.

The paper leaves these open, or has them otherwise. Each is searched anew on few tasks:
24 to train on, and 36 to test, between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from msc.robot import DMP, ControllerGains, CostWeights, Physics, Workspace, home_pose

_PRICE = 0.01  # 1/rad; of the joints' way, in place of their energy
_BASES = "free", "obstacles"
UNCHANGED = "base"


def _cost(**changes: float) -> Callable[[Workspace], Workspace]:
    return lambda world: replace(world, cost=replace(world.cost, **changes))


def _dmp(**changes: Any) -> Callable[[Workspace], Workspace]:
    return lambda world: replace(world, dmp=DMP(**changes))


def _gains(**changes: Any) -> Callable[[Workspace], Workspace]:
    return lambda world: replace(world, controller=ControllerGains(**changes))


def _physics(**changes: Any) -> Callable[[Workspace], Workspace]:
    return lambda world: replace(world, physics=Physics(**changes))


def _lasting(seconds: float) -> Callable[[Workspace], Workspace]:
    """Let the movement take so long, and the primitive with it."""
    return lambda world: replace(
        world, dmp=DMP(time_scale=seconds), physics=Physics(duration=seconds)
    )


def _reaching(reach: float) -> Callable[[Workspace], Workspace]:
    """Start from another reach, towards where it was."""
    return lambda world: replace(
        world, home=home_pose(world.link_lengths, reach, math.radians(225))
    )


VARIANTS: dict[str, tuple[str, Callable[[Workspace], Workspace]]] = {
    UNCHANGED: ("nothing changed", lambda world: world),
    "length": (
        "the joints' way is paid for, 0.01 a radian, in place of their energy",
        _cost(energy=0.0, length=_PRICE),
    ),
    "cheap": ("energy costs a third", _cost(energy=CostWeights.energy / 3)),
    "dear": ("energy costs three times as much", _cost(energy=3 * CostWeights.energy)),
    "priced": ("contact has a price: 0.01 a newton-second", _cost(contact=0.01)),
    "gated": ("the forcing term is multiplied by the phase", _dmp(gated=True)),
    "soft": ("half the spring constant", _dmp(spring=8.0)),
    "stiff": ("twice the spring constant", _dmp(spring=32.0)),
    "two-bases": ("two basis functions a dimension", _dmp(n_basis=2)),
    "five-bases": ("five basis functions a dimension", _dmp(n_basis=5)),
    "quick": ("the movement takes 0.7 s", _lasting(0.7)),
    "slow": ("the movement takes 1.5 s", _lasting(1.5)),
    "home": ("the arm starts from a reach of 0.80 m", _reaching(0.80)),
    "cut": (
        "tasks are counted from 45 degrees further round",
        lambda world: replace(world, cut_deg=world.cut_deg + 45.0),
    ),
    "loose": ("half the controller's bandwidth", _gains(bandwidth=7.5)),
    "tight": ("twice the controller's bandwidth", _gains(bandwidth=30.0)),
    "weak": ("half the torque limits", _gains(torque_limit=(20.0, 10.0, 2.5))),
    "strong": ("no torque limits", _gains(torque_limit=(math.inf,) * 3)),
    "fine": ("physics at 480 Hz", _physics(substeps=8)),
    "swift": ("commands at 120 Hz", _physics(control_rate=120.0)),
    "gravity": ("the plane is upright, with gravity", _physics(gravity=9.81)),
    "mujoco": ("the other engine", _physics(engine="mujoco")),
}
"""Choices of ours, changed: what is changed, and how a world has it."""


def draw_variants() -> Iterator[Workspace]:
    """Change one choice at a time in both headline worlds.

    Yields
    ------
    Workspace
        Worlds named "free-base", "obstacles-base", "free-length", …

    Examples
    --------
    >>> next(draw_variants()).name
    'free-base'
    """
    for name, (_, change) in VARIANTS.items():
        bases = _BASES[1:] if name == "priced" else _BASES  # nothing to meet
        for base in bases:
            yield replace(change(Workspace.named(base)), name=f"{base}-{name}")
