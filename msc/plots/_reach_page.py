"""A goal that the reader drags, on the picture, and where every method's arm ends.

A `Reach` shows itself as SVG, which is a picture as it stands: on paper, in the dark
and without a script. `reach.js` has it follow the hand. As a kernel's plain picture it
is drawn by Matplotlib.
"""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from msc.plots._report import LOOKS
from msc.plots._slider import poster
from msc.plots._style import (
    CHART_COLOURS,
    METHOD_STYLES,
    Array,
    chart_colour,
    encode_png,
)
from msc.plots._world import draw_links, draw_world, square_around
from msc.robot import Workspace, forward_kinematics

LARGEST = 32767  # a joint's angle in a page, in two bytes
REACH_SCRIPT = Path(__file__).with_name("reach.js").read_text("utf-8").strip()

_LOOKS: dict[str, dict[str, Any]] = (
    METHOD_STYLES
    | LOOKS
    | {"change points": {"color": CHART_COLOURS[0], "marker": "X", "ls": "-"}}
)
RINGS = {1: "1 mm", 2: "1 cm", 3: "10 cm"}  # of the board, a power of ten apart
_DASHES = {"-": "none", "--": "5 3", "-.": "5 2 1 2", ":": "1.5 2.5"}
# Markers of Matplotlib as paths about a unit large.
_MARKS = {
    "o": "M-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0z",
    "s": "M-.9-.9H.9V.9H-.9z",
    "D": "M0-1.3L1.3 0 0 1.3-1.3 0z",
    "^": "M0-1.2L1.2 1H-1.2z",
    "v": "M0 1.2L1.2-1H-1.2z",
    ">": "M1.2 0L-1 1.2V-1.2z",
    "<": "M-1.2 0L1 1.2V-1.2z",
    "X": "M0-.5L.8-1.3 1.3-.8.5 0 1.3.8.8 1.3 0 .5-.8 1.3-1.3.8-.5 0-1.3-.8-.8-1.3z",
    "P": "M-.4-1.2H.4V-.4H1.2V.4H.4V1.2H-.4V.4H-1.2V-.4H-.4z",
    ".": "M-.6 0a.6.6 0 1 0 1.2 0a.6.6 0 1 0-1.2 0z",
    "": "M-1.2-.25H1.2V.25H-1.2z",
}


@dataclass(frozen=True)
class Reach:
    """Movements of several methods to every goal on a circle."""

    world: Workspace
    degrees: Array  # of the goals, ascending, shape (n_goals,)
    trained: Array  # those trained on (degrees)
    joints: Mapping[str, Array]  # by method (rad): (n_goals, n_poses, 3), back to front
    error_cm: Mapping[str, Array]  # left to the goal at the end (cm): (n_goals,)
    touched: Mapping[str, NDArray[np.bool_]]  # whether obstacles were met: (n_goals,)
    shown: Sequence[str]  # methods that are shown first
    first: int  # which goal
    jumps: Sequence[float] = ()  # of the policies, where on the circle (degrees)
    charts: NDArray[np.intp] | None = None  # that goals are given to: (n_goals,)
    frame: tuple[float, float, float] | None = None  # left, top, width (m); None: tight

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or a picture where there is none."""
        return {
            "text/html": self.to_html(),
            "image/png": encode_png(draw_first(self)),
            "text/plain": self.told,
        }

    @property
    def told(self) -> str:
        """What the picture shows at first."""
        ends = [f"{name} {self._left(name)}" for name in self.shown]
        return (
            "The arm from above, its goals on a red circle, obstacles black. For the "
            f"goal at {self.degrees[self.first]:g}° movements end off it: "
            + ", ".join(ends)
        )

    def to_html(self) -> str:
        """Write a piece of HTML that needs no other file."""
        return (
            f"{self.draw()}<script>({REACH_SCRIPT})"
            f"(document.currentScript.previousElementSibling,{write(self.data)});"
            "</script>"
        )

    def draw(self) -> str:
        """Write the picture as it is at first, and what stands beside it."""
        rows = "".join(self._row(name) for name in [*self.joints][::-1])
        return (
            '<div class="msc-reach">'
            f'<div class="msc-plane">{self._plane()}</div>'
            f"<div><p><output>{self._goal}</output> "
            '<button type="button">Play</button></p>'
            f"<fieldset><legend>How far from it movements end</legend>{rows}</fieldset>"
            f"{self._board()}</div></div>"
        )

    @property
    def _goal(self) -> str:
        """Say where the goal is, and which chart it is given to."""
        told = f"Goal at {self.degrees[self.first]:g}°"
        if self.charts is None:
            return told
        return f"{told}: chart {self.charts[self.first] + 1}"

    def _left(self, name: str) -> str:
        """Say how far from the first goal a movement ends, and whether it touched."""
        touched = ", touched" * bool(self.touched[name][self.first])
        return f"{self.error_cm[name][self.first]:.2f} cm{touched}"

    def _plane(self) -> str:
        """Draw the world from above, in centimetres, as it is at first."""
        x, y = _svg(self.world.target(self.degrees[self.first]))
        handle = (
            f'<g class="msc-goal" transform="translate({x} {y})">'
            '<circle r="12"/><circle r="3.4"/></g>'
        )
        ways = "".join(self._way(name) for name in self.joints)
        words = html.escape(self.told)
        return (
            f'<svg viewBox="{self.box}" role="img" aria-label="{words}">'
            f"<g><g>{self._still()}</g>{ways}{handle}</g></svg>"
        )

    @property
    def box(self) -> str:
        """The frame of the world (cm), as SVG has it."""
        if self.frame is None:
            every = np.concatenate([*self.joints.values()])
            (left, right), (_, top) = square_around(self.world, self.places(every))
            frame = left, -top, right - left
        else:
            frame = self.frame
        return " ".join(f"{100 * side:.0f}" for side in (*frame, frame[-1]))

    def _still(self) -> str:
        """Draw what stands still: goals, obstacles, tasks trained on, jumps, charts."""
        world = self.world
        ticks = np.stack([f * world.target(self.trained) for f in (1, 1.06)], axis=1)
        known = "".join(map(_path, ticks))
        parts = ['<circle r="2"/>', *draw_round(world)]  # the first is the base
        parts += [f'<path class="msc-known" d="{known}"/>']
        parts += self._arcs()
        parts += draw_jumps(world, self.jumps, (0.86, 1.24))
        return "".join(parts)

    def _arcs(self) -> list[str]:
        """Draw arcs outside the goals, with numbers: to which chart these are given."""
        if self.charts is None:
            return []
        half, parts = 180 / len(self.degrees), []
        for chart, run in groupby(range(len(self.charts)), self.charts.__getitem__):
            own = self.degrees[[*run]]
            turn = np.linspace(own[0] - half, own[-1] + half, 2 + len(own))
            arc = _path(1.12 * self.world.target(turn))
            x, y = _svg(1.25 * self.world.target((own[0] + own[-1]) / 2))
            parts.append(
                f'<g class="msc-chart" style="--hue:{chart_colour(chart)}">'
                f'<path d="{arc}"/><text x="{x:.1f}" y="{y:.1f}" dy=".35em">'
                f"{chart + 1}</text></g>"
            )
        return parts

    def _way(self, name: str) -> str:
        """Draw how one method's arm moves to the first goal."""
        places = self.places(self.joints[name][self.first])
        return self._group(
            name,
            f'<path class="msc-trail" d="{_path(self._trail(name))}"/>'
            f'<path class="msc-arm" stroke-dasharray="{_dash(name)}" '
            f'd="{_path(places[-1])}"/>{_mark(name, _svg(places[-1, -1]))}',
        )

    def _trail(self, name: str) -> Array:
        """Place the arm's end on the way to the first goal: at poses and half-way."""
        poses = self.joints[name][self.first]
        times = np.arange(0, len(poses) - 0.5, 0.5)
        angles = [np.interp(times, range(len(poses)), joint) for joint in poses.T]
        return self.places(np.transpose(angles))[:, -1]

    def _board(self) -> str:
        """Draw where movements end, seen from the goal: rings are powers of ten."""
        rings = "".join(f'<circle r="{10 * ring}"/>' for ring in RINGS)
        words = "".join(
            f'<text y="{-10 * ring}">{name}</text>' for ring, name in RINGS.items()
        )
        goal = self.world.target(self.degrees[self.first])
        ends = {
            name: self.places(some[self.first])[-1, -1] - goal
            for name, some in self.joints.items()
        }
        marks = [self._group(n, _mark(n, aim(*_svg(end)))) for n, end in ends.items()]
        return (
            '<svg class="msc-board" viewBox="-37 -37 74 74" aria-hidden="true"><g>'
            f"{rings}{words}{''.join(marks)}</g></svg>"
        )

    def _group(self, name: str, inside: str) -> str:
        """Put what is drawn of a method into a group that can be hidden."""
        off = "" if name in self.shown else ' display="none"'
        return f'<g class="msc-way" style="{_hue(name)}"{off}>{inside}</g>'

    def places(self, joints: Array) -> Array:
        """Place the arm's joints and its end (m)."""
        return forward_kinematics(joints, self.world.link_lengths)

    def _row(self, name: str) -> str:
        """Name a method, with its look, a box to switch it, and what it leaves."""
        on = " checked" if name in self.shown else ""
        return (
            f'<label class="msc-way" style="{_hue(name)}">'
            f'<input type="checkbox"{on} autocomplete="off">'
            '<svg viewBox="-11 -4 22 8" aria-hidden="true"><g>'
            f'<path class="msc-arm" stroke-dasharray="{_dash(name)}" d="M-11 0H11"/>'
            f"{_mark(name, (0, 0))}</g></svg>"
            f"<span>{html.escape(name)}</span> "
            f"<b>{self._left(name)}</b></label>"
        )

    @property
    def data(self) -> dict[str, Any]:
        """What the script reads."""
        poses = np.array([some[:, 1:] for some in self.joints.values()])
        tick = float(np.abs(poses).max()) / LARGEST
        raw = np.round(poses / tick).astype("<i2").tobytes()
        return {
            "links": [100 * length for length in self.world.link_lengths],
            "home": [*map(float, self.world.home)],
            "degrees": self.degrees.tolist(),
            "goals": np.round(100 * self.world.target(self.degrees), 2).tolist(),
            "names": [*self.joints],
            "left": [np.round(some, 2).tolist() for some in self.error_cm.values()],
            "tick": tick,
            "joints": base64.b64encode(raw).decode(),
            "touched": [some.astype(int).tolist() for some in self.touched.values()],
            "charts": None if self.charts is None else (1 + self.charts).tolist(),
            "still": self._still(),
            "words": self.told,
            "first": self.first,
        }


def write(data: Any) -> str:
    """Write data into a script."""
    return json.dumps(data, separators=(",", ":")).replace("<", r"\u003c")


def draw_round(world: Workspace) -> list[str]:
    """Draw the circle of goals, and obstacles."""
    return [
        f'<circle r="{100 * world.goal_radius:g}" class="msc-goals"/>',
        *(
            f'<circle cx="{100 * x:g}" cy="{-100 * y:g}" r="{100 * r:g}"/>'
            for x, y, r in world.circles
        ),
    ]


def draw_jumps(
    world: Workspace, jumps: Sequence[float], reach: tuple[float, float]
) -> list[str]:
    """Draw jumps as strokes across the circle of goals."""
    ends = [np.outer(reach, world.target(place)) for place in jumps]
    return [f'<path class="msc-jump" d="{_path(pair)}"/>' for pair in ends]


def find_apart(ends: ArrayLike) -> int:
    """Find the task whose ends lie farther apart than those of three in four.

    Parameters
    ----------
    ends : array_like of shape (n_methods, n_tasks, 2)
        Where movements end.

    Returns
    -------
    int
        Its index: of tasks ordered by the greatest distance between two ends.

    Examples
    --------
    >>> find_apart([[[0, 0]] * 5, [[9, 0], [0, 1], [2, 0], [3, 4], [0, 0]]])
    3
    """
    places = np.asarray(ends, dtype=float)
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1).max(axis=(0, 1))
    return int(np.argsort(apart, kind="stable")[3 * (len(apart) - 1) // 4])


def aim(x: float, y: float) -> tuple[float, float]:
    """Place what lies beside the goal (cm) on the board, where rings are powers of ten.

    Nearer than a tenth of a millimetre is its middle; farther than 30 cm its rim.

    >>> aim(0.0, -1.0), aim(100.0, 0.0), aim(0.001, 0.0)
    ((0.0, -20.0), (35.0, 0.0), (0.0, 0.0))
    """
    distance = float(np.hypot(x, y))
    radius = 10 * float(np.clip(np.log10(max(distance, 1e-9)) + 2, 0, 3.5))
    return (radius * x / distance, radius * y / distance) if radius else (0.0, 0.0)


def _svg(point: Array) -> tuple[float, float]:
    """Turn metres from above into a picture's centimetres, y downwards."""
    x, y = 100 * point
    return float(x), float(-y)


def _path(points: Array) -> str:
    """Write a line through points (m) as a path."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in map(_svg, points))


def _mark(name: str, at: tuple[float, float]) -> str:
    """Draw a method's marker."""
    place = f"translate({at[0]:.1f} {at[1]:.1f}) scale(2.4)"
    shape = _MARKS[_LOOKS[name]["marker"]]
    return f'<path class="msc-mark" transform="{place}" d="{shape}"/>'


def _hue(name: str) -> str:
    """Write a method's colour as a variable of CSS."""
    return f"--hue:{_LOOKS[name]['color']}"


def _dash(name: str) -> str:
    """Write a method's dashes."""
    look = _LOOKS[name]["ls"]
    return _DASHES[look] if isinstance(look, str) else " ".join(map(str, look[1]))


@poster
def draw_first(axis: Axes, reach: Reach) -> None:
    """Draw the movements that are shown first, to the first goal."""
    draw_world(axis, reach.world, reach.degrees[reach.first])
    for name in filter(reach.shown.__contains__, reach.joints):
        places = reach.places(reach.joints[name][reach.first])
        look: Any = {"color": _LOOKS[name]["color"], "ls": _LOOKS[name]["ls"]}
        draw_links(axis, places[-1], {"lw": 3, "label": name, **look})
        axis.plot(*reach._trail(name).T, lw=1, **look)
    axis.legend(loc="lower right")
