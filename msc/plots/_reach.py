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
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from msc.plots._report import LOOKS
from msc.plots._skill import execute_all
from msc.plots._slider import poster
from msc.plots._style import CHART_COLOURS, METHOD_STYLES, Array, encode_png
from msc.plots._world import draw_links, draw_world, square_around
from msc.robot import Arm, Workspace, forward_kinematics
from msc.study import Experiment

EVERY = 6  # time steps from one pose that a page is told to the next: a tenth second
LARGEST = 32767  # a joint's angle in a page, in two bytes
FIRST = "charts", "single regression", "linear interpolation"  # shown before one asks
SEARCHED = "searched"
_SCRIPT = Path(__file__).with_name("reach.js")

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
    joints: Mapping[str, Array]  # by method (rad): (n_goals, n_times, 3), back to front
    error_cm: Mapping[str, Array]  # left to the goal at the end (cm): (n_goals,)
    shown: Sequence[str]  # methods that are shown first
    first: int  # which goal

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or a picture where there is none."""
        return {
            "text/html": self.to_html(),
            "image/png": encode_png(_draw_first(self)),
            "text/plain": self.told,
        }

    @property
    def told(self) -> str:
        """What the picture shows at first."""
        ends = [
            f"{name} {self.error_cm[name][self.first]:.2f} cm" for name in self.shown
        ]
        return (
            "The arm from above, its goals on a red circle, obstacles black. For the "
            f"goal at {self.degrees[self.first]:g}° movements end off it: "
            + ", ".join(ends)
        )

    def to_html(self) -> str:
        """Write a piece of HTML that needs no other file."""
        data = json.dumps(self._data(), separators=(",", ":")).replace("<", r"\u003c")
        rows = "".join(self._row(name) for name in [*self.joints][::-1])
        return (
            '<div class="msc-reach">'
            f'<div class="msc-plane">{self._plane()}</div>'
            f"<div><p><output>Goal at {self.degrees[self.first]:g}°</output> "
            '<button type="button">Play</button></p>'
            f"<fieldset><legend>How far from it movements end</legend>{rows}</fieldset>"
            f"{self._board()}</div></div>"
            f"<script>({_SCRIPT.read_text(encoding='utf-8').strip()})"
            f"(document.currentScript.previousElementSibling,{data});</script>"
        )

    def _plane(self) -> str:
        """Draw the world from above, in centimetres, as it is at first."""
        world = self.world
        every = np.concatenate([*self.joints.values()])
        (left, right), (bottom, top) = square_around(world, self._places(every))
        frame = left, -top, right - left, top - bottom
        box = " ".join(f"{100 * side:.0f}" for side in frame)
        still = [f'<circle r="{100 * world.goal_radius:g}" class="msc-goals"/>']
        still.append('<circle r="2"/>')  # the base
        still += [
            f'<circle cx="{100 * x:g}" cy="{-100 * y:g}" r="{100 * r:g}"/>'
            for x, y, r in world.circles
        ]
        ticks = np.stack([f * world.target(self.trained) for f in (1, 1.06)], axis=1)
        known = "".join(map(_path, ticks))
        still.append(f'<path class="msc-known" d="{known}"/>')
        x, y = _svg(world.target(self.degrees[self.first]))
        handle = (
            f'<g class="msc-goal" transform="translate({x} {y})">'
            '<circle r="12"/><circle r="3.4"/></g>'
        )
        ways = "".join(self._way(name) for name in self.joints)
        words = html.escape(self.told)
        return (
            f'<svg viewBox="{box}" role="img" aria-label="{words}">'
            f"<g>{''.join(still)}{ways}{handle}</g></svg>"
        )

    def _way(self, name: str) -> str:
        """Draw how one method's arm moves to the first goal."""
        places = self._places(self.joints[name][self.first])
        return self._group(
            name,
            f'<path class="msc-trail" d="{_path(places[:, -1])}"/>'
            f'<path class="msc-arm" stroke-dasharray="{_dash(name)}" '
            f'd="{_path(places[-1])}"/>{_mark(name, _svg(places[-1, -1]))}',
        )

    def _board(self) -> str:
        """Draw where movements end, seen from the goal: rings are powers of ten."""
        rings = "".join(f'<circle r="{10 * ring}"/>' for ring in RINGS)
        words = "".join(
            f'<text y="{-10 * ring}">{name}</text>' for ring, name in RINGS.items()
        )
        goal = self.world.target(self.degrees[self.first])
        ends = {
            name: self._places(some[self.first])[-1, -1] - goal
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

    def _places(self, joints: Array) -> Array:
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
            f"<b>{self.error_cm[name][self.first]:.2f} cm</b></label>"
        )

    def _data(self) -> dict[str, Any]:
        """Return what the script reads."""
        poses = np.array([some[:, EVERY::EVERY] for some in self.joints.values()])
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
            "first": self.first,
        }


def drag_goal(
    experiment: Experiment, *, shown: Sequence[str] = FIRST, every: int = 1
) -> Reach:
    """Let the reader drag the goal, and see how every method's arm moves there.

    Parameters
    ----------
    experiment : Experiment
        What was trained on what; all its methods are drawn, and what was searched.
    shown : sequence of str, default=("charts", "single regression", \
"linear interpolation")
        The methods that are seen before the reader switches any on or off.
    every : int, default=1
        Every how many-th test task is a goal.

    Returns
    -------
    Reach
        A picture that follows the hand. At first it shows the goal at which the shown
        movements end farther apart than at three quarters of all goals.

    Raises
    ------
    ValueError
        If a method that is to be shown is none of the experiment's.
    """
    names = experiment.names
    if unknown := [name for name in shown if name not in names]:
        raise ValueError(f"shown={unknown}: not trained; wanted some of {names}")
    world, some = experiment.workspace, slice(None, None, every)
    tasks = experiment.test_tasks[some]
    degrees = experiment.test_table["task_deg"].to_numpy()[some]
    policies = {SEARCHED: experiment.test_policies[some]}
    policies |= {name: experiment.predict(name, tasks) for name in names[::-1]}
    with Arm(world) as arm:
        rollouts, error_cm = execute_all(arm, policies, degrees)
    return Reach(
        world,
        degrees,
        np.rad2deg(experiment.tasks[experiment.chosen, 0]),
        {name: np.array([one.joints for one in rollouts[name]]) for name in policies},
        error_cm,
        tuple(shown),
        find_apart([[one.path[-1] for one in rollouts[name]] for name in shown]),
    )


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
def _draw_first(axis: Axes, reach: Reach) -> None:
    """Draw the movements that are shown first, to the first goal."""
    draw_world(axis, reach.world, reach.degrees[reach.first])
    for name in filter(reach.shown.__contains__, reach.joints):
        places = reach._places(reach.joints[name][reach.first])
        look: Any = {"color": _LOOKS[name]["color"], "ls": _LOOKS[name]["ls"]}
        draw_links(axis, places[-1], {"lw": 3, "label": name, **look})
        axis.plot(*places[:, -1].T, lw=1, **look)
    axis.legend(loc="lower right")
