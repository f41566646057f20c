"""A drawing that follows a slider, in a page without a kernel.

A `Slider` is panels of marks; some marks stand still, others have a shape for every
step of the slider, or for every step and moment of a film. It shows itself as HTML with
a canvas, `slider.js` and its numbers inline, and as a picture where there is no
script: on paper, or with JavaScript off.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from msc.plots._style import encode_png, styled

SCALE = 1000  # of coordinates, relative to a panel's width: as fine as a screen
DEPTHS = {"never": 0, "step": 1, "time": 2}  # of lists of points
WALK_SECONDS = {False: 2.2, True: 6.0}  # that a film takes, and a walk
FLAT = 0.6  # height over width of the panels beside the arm
TASK_AXIS: dict[str, Any] = {
    "x_label": "task angle (degrees)",
    "x_ticks": (0, 90, 180, 270, 360),
}
_P = ParamSpec("_P")
_SCRIPT = Path(__file__).with_name("slider.js")


@dataclass(frozen=True)
class Mark:
    """Something drawn, in the panel's units; looks are in pixels."""

    kind: str  # line, segments (pairs of points), dots, disc, ring or upright (a line)
    points: Any  # of shape (n_points, 2); one such a step; or one a step and moment,
    varies: str = "never"  # as this is "never", "step" or "time"
    colour: str = "ink"  # of CSS; "ink" is the page's own, light or dark
    width: float = 1.5  # of lines, or the radius of dots
    radius: float = 0.0  # of discs and rings, in the panel's units
    opacity: float = 1.0
    dash: tuple[float, ...] = ()  # lengths of dashes and gaps
    trail: dict[str, Any] | None = None  # looks of the way the last point went in time


@dataclass(frozen=True)
class Panel:
    """A canvas with its axes and marks."""

    alt: str  # what it shows, for those who do not see it
    x: tuple[float, float]  # where the axes begin and end
    y: tuple[float, float]
    marks: Sequence[Mark]  # from back to front
    aspect: float = 1.0  # height over width
    x_label: str = ""  # without it no axes are drawn
    y_label: str = ""
    x_ticks: tuple[float, ...] = ()
    y_ticks: tuple[float, ...] = ()
    y_names: tuple[str, ...] = ()  # as on a logarithmic axis; by default the numbers


@dataclass(frozen=True)
class Slider:
    """Panels beside one another over a slider."""

    name: str  # what the slider sets, as "task angle"
    labels: Sequence[str]  # its value at each step, with the unit
    captions: Sequence[str]  # what is said below the panels, step by step
    panels: Sequence[Panel]
    poster: Figure  # the picture in place of it
    poster_alt: str  # what that shows
    first: int = 0  # where the slider is at first
    walks: bool = False  # **Play** walks through the steps, not through a step's film
    legend: dict[str, str] = field(default_factory=dict)  # colours by name

    def __post_init__(self) -> None:
        """Refuse what would fail in the page only."""
        n_steps = len(self.labels)
        if len(self.captions) != n_steps:
            raise ValueError(
                f"captions: {len(self.captions)} of them; wanted one a label, {n_steps}"
            )
        for panel in self.panels:
            for mark in panel.marks:
                if mark.varies != "never" and len(mark.points) != n_steps:
                    raise ValueError(
                        f"a mark that varies by {mark.varies} has {len(mark.points)} "
                        f"shapes; wanted one a label, {n_steps}"
                    )

    @property
    def n_times(self) -> int:
        """Moments of a film: of the marks that vary with time."""
        marks = (mark for panel in self.panels for mark in panel.marks)
        return max((len(m.points[0]) for m in marks if m.varies == "time"), default=1)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or the poster where there is none."""
        png = encode_png(self.poster)
        return {
            "text/html": self.to_html(png),
            "image/png": png,
            "text/plain": f"a slider over {self.name}: {self.poster_alt}",
        }

    def to_html(self, png: str | None = None) -> str:
        """Write a piece of HTML that needs no other file, with the poster (base 64)."""
        image = png or encode_png(self.poster)
        canvases = "".join(
            f'<canvas role="img" aria-label="{html.escape(panel.alt)}"></canvas>'
            for panel in self.panels
        )
        legend = "".join(
            f'<span><i data-colour="{colour}" style="background:{colour}"></i>'
            f"{name}</span>"
            for name, colour in (map(html.escape, one) for one in self.legend.items())
        )
        plays = self.walks or self.n_times > 1
        play = '<button type="button">Play</button>' if plays else ""
        data = json.dumps(self._data(), separators=(",", ":")).replace("<", r"\u003c")
        return (
            '<div class="msc-slider">'
            f'<img class="msc-poster" alt="{html.escape(self.poster_alt)}" '
            f'src="data:image/png;base64,{image}">'
            f'<div class="msc-panels msc-of-{len(self.panels)}">{canvases}</div>'
            f'<p class="msc-legend">{legend}</p>'
            f'<div class="msc-controls">{play}<label>{html.escape(self.name)} '
            f'<input name="step" type="range" min="0" max="{len(self.labels) - 1}" '
            f'value="{self.first}" autocomplete="off"></label></div>'
            "<output></output></div>"
            f"<script>({_SCRIPT.read_text(encoding='utf-8').strip()})"
            "(document.currentScript.previousElementSibling,"
            f"{data});</script>"
        )

    def _data(self) -> dict[str, Any]:
        """Return what the script reads."""
        return {
            "n_times": self.n_times,
            "seconds": WALK_SECONDS[self.walks],
            "walks": self.walks,
            "labels": self.labels,
            "captions": self.captions,
            "panels": [_describe(panel) for panel in self.panels],
        }


def choose_ticks(low: float, high: float) -> tuple[float, ...]:
    """Choose a handful of round numbers for an axis.

    >>> choose_ticks(-4.2, 21)
    (0.0, 5.0, 10.0, 15.0, 20.0)
    """
    places = MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    return tuple(float(f"{place:.6g}") for place in places if low <= place <= high)


def poster(draw: Callable[Concatenate[Axes, _P], None]) -> Callable[_P, Figure]:
    """Have what draws into a panel draw a slider's poster."""

    @styled
    @wraps(draw)
    def drawn(*args: _P.args, **options: _P.kwargs) -> Figure:
        figure, axis = plt.subplots(figsize=(4.2, 4.2))
        draw(axis, *args, **options)
        return figure

    return drawn


def _describe(panel: Panel) -> dict[str, Any]:
    """Turn a panel into numbers and names."""
    scale = SCALE / min(np.ptp(panel.x), np.ptp(panel.y))
    return vars(panel) | {
        "scale": scale,
        "y_names": panel.y_names or [f"{y:g}" for y in panel.y_ticks],
        "marks": [
            vars(mark) | {"points": _whole(mark.points, scale, DEPTHS[mark.varies])}
            for mark in panel.marks
        ],
    }


def _whole(points: Any, scale: float, depth: int) -> list[Any]:
    """Turn coordinates into whole numbers, below lists by step and by moment."""
    if depth:
        return [_whole(one, scale, depth - 1) for one in points]
    values = np.asarray(points, dtype=float).reshape(-1)
    rounded: list[Any] = np.round(scale * values).astype(int).tolist()
    return rounded
