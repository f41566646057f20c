"""Layouts of obstacles to choose among, and in each a goal that the reader drags.

The strip of small worlds is SVG, as the picture below it is; `layouts.js` has a choice
change that. The part of the address behind # chooses, too.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msc.plots._reach_page import (
    REACH_SCRIPT,
    Reach,
    draw_first,
    draw_jumps,
    draw_round,
    find_apart,
    write,
)
from msc.plots._sheets import (
    DRAG,
    Found,
    describe_world,
    find_places,
    look_up,
    tell_jumps,
)
from msc.plots._style import encode_png
from msc.plots._world import bounds_of, outlines
from msc.robot import forward_kinematics
from msc.worlds import unpack_joints

_SCRIPT = Path(__file__).with_name("layouts.js").read_text("utf-8").strip()


@dataclass(frozen=True)
class Layouts:
    """Movements of several methods in several worlds, to every goal on a circle."""

    reaches: Mapping[str, Reach]  # by the world's name
    told: Mapping[str, str]  # what is particular about a world

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or a picture of the first world where there is none."""
        first = next(iter(self.reaches.values()))
        return {
            "text/html": self.to_html(),
            "image/png": encode_png(draw_first(first)),
            "text/plain": f"{len(self.reaches)} worlds, first {first.told}",
        }

    @property
    def error_cm(self) -> pd.DataFrame:
        """What is left to the goals (cm): a column a method, a row a world and task.

        The index has the world, the task (degrees), and its place: "beside a jump", not
        farther from one than training tasks lie apart, or "away".
        """
        tables = []
        for name, one in self.reaches.items():
            turns = one.degrees[:, None] - np.array(one.jumps) + 180
            beside = (np.abs(turns % 360 - 180) <= 360 / len(one.trained)).any(axis=1)
            places = np.where(beside, "beside a jump", "away")
            index = {"layout": name, "task_deg": one.degrees, "place": places}
            tables.append(pd.DataFrame({**one.error_cm, **index}).set_index([*index]))
        return pd.concat(tables)

    def to_html(self) -> str:
        """Write a piece of HTML that needs no other file."""
        name, first = next(iter(self.reaches.items()))
        strip = "".join(map(self._small, self.reaches))
        worlds = [
            {"name": name, "told": self.told[name], **one.data}
            for name, one in self.reaches.items()
        ]
        told, link = map(html.escape, (f"{name}: {self.told[name]}", name))
        return (
            '<div class="msc-layouts"><fieldset><legend>Choose a layout</legend>'
            f"{strip}</fieldset><p><span>{told}</span> · "
            f'<a href="#{link}">more of it</a></p>{first.draw()}</div>'
            f"<script>({_SCRIPT})(document.currentScript.previousElementSibling,"
            f"{write(worlds)},{REACH_SCRIPT});</script>"
        )

    def _small(self, name: str) -> str:
        """Draw a small world with a button to choose it."""
        one, label = self.reaches[name], html.escape(name)
        words = html.escape(f"{name}: {self.told[name]}")
        still = draw_round(one.world) + draw_jumps(one.world, one.jumps, (0.75, 1.25))
        first = " checked" if name == next(iter(self.reaches)) else ""
        return (
            f'<label id="{DRAG}{label}" title="{words}">'
            f'<input type="radio" name="msc-layout" aria-label="{label}"{first} '
            f'autocomplete="off"><svg viewBox="{one.box}" aria-hidden="true">'
            f'<g>{"".join(still)}<text dy=".35em">{label[-2:]}</text></g></svg></label>'
        )


def load_layouts(
    names: Sequence[str],
    shown: Sequence[str],
    every: int = 1,
    folder: Path | None = None,
    results: Path | None = None,
) -> Layouts:
    """Load what arms do in layouts, to choose one among them; see `drag_goal`."""
    reaches, told = {}, {}
    for name in names:
        found = look_up(name, folder, results)
        if found.moves is None:
            raise ValueError(f"{name}: wanted its movements; msc worlds moves {name}")
        reaches[name] = _read(found, found.moves, shown, every)
        words = ", ".join(describe_world(found.world)), tell_jumps(found.jumps)
        told[name] = "; ".join(words)
    frame = _find_frame([*reaches.values()])
    return Layouts({n: replace(one, frame=frame) for n, one in reaches.items()}, told)


def _read(
    found: Found, moves: Mapping[str, Any], shown: Sequence[str], every: int
) -> Reach:
    """Make a picture of what `move_world` tells."""
    world, methods = found.world, moves["methods"]
    if unknown := [name for name in shown if name not in methods]:
        raise ValueError(f"shown={unknown}: not trained; wanted some of {[*methods]}")
    first, *names = methods  # searched; in the picture the last one is in front
    order, n_tasks = (first, *names[::-1]), len(moves["task_deg"])
    some = slice(None, None, every)
    joints = {
        name: unpack_joints(methods[name]["joints"], world, n_tasks)[some]
        for name in order
    }
    ends = {
        name: forward_kinematics(joints[name][:, -1], world.link_lengths)[:, -1]
        for name in shown
    }
    return Reach(
        world,
        np.array(moves["task_deg"][some]),
        np.array(moves["trained_deg"]),
        joints,
        {name: np.array(methods[name]["error_cm"][some]) for name in order},
        {name: np.array(methods[name]["touched"][some], bool) for name in order},
        tuple(shown),
        find_apart([*ends.values()]),
        find_places(found.jumps),
        np.array(moves["chart"][some]),
    )


def _find_frame(reaches: Sequence[Reach]) -> tuple[float, float, float]:
    """Find one frame for all pictures: left, top and width (m)."""
    circles = [circle for one in reaches for _, circle in outlines(one.world)]
    places = [one.places(np.stack([*one.joints.values()])) for one in reaches]
    low, high = bounds_of(
        circles, np.concatenate([one.reshape(-1, 2) for one in places])
    )
    half = 0.51 * float((high - low).max())
    x, y = ((low + high) / 2).tolist()
    return x - half, -y - half, 2 * half
