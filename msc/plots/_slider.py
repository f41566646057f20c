"""A drawing that follows a slider, in a page without a kernel.

A `Slider` is panels of marks; some marks stand still, others have a shape for every
step of the slider, or for every step and moment of a film. It shows itself as HTML with
a canvas, `slider.js` and its numbers inline, and as a picture where there is no
script: on paper, or with JavaScript off.
"""

from __future__ import annotations

import base64
import html
import io
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

from msc.plots._style import styled

SCALE = 1000  # of coordinates, relative to a panel's width: as fine as a screen
DEPTHS = {"never": 0, "step": 1, "time": 2}  # of lists of points
FLAT = 0.6  # height over width of the panels beside the arm
TASK_AXIS: dict[str, Any] = {
    "x_label": "task angle (degrees)",
    "x_ticks": (0, 90, 180, 270, 360),
}
_P = ParamSpec("_P")
_SCRIPT = Path(__file__).with_name("slider.js")


@dataclass(frozen=True)
class Mark:
    """Something drawn.

    Parameters
    ----------
    kind : {"line", "segments", "dots", "disc", "ring", "upright"}
        A line through the points, lines between pairs of them, dots of a fixed size,
        circles of a radius, or vertical lines.
    points : array_like
        Of shape (n_points, 2) if `varies` is "never"; one such array a step if it is
        "step"; one a step and moment if it is "time".
    varies : {"never", "step", "time"}, default="never"
        What it follows.
    colour : str, default="ink"
        CSS colour; "ink" is the page's own, light or dark.
    width : float, default=1.5
        Of lines, or the radius of dots (pixels).
    radius : float, default=0.0
        Of discs and rings, in the panel's units.
    opacity : float, default=1.0
        From 0 to 1.
    dash : tuple of float, default=()
        Lengths of dashes and gaps (pixels).
    trail : dict or None, default=None
        Looks of the way that the last point went, of a mark that varies with time.
    """

    kind: str
    points: Any
    varies: str = "never"
    colour: str = "ink"
    width: float = 1.5
    radius: float = 0.0
    opacity: float = 1.0
    dash: tuple[float, ...] = ()
    trail: dict[str, Any] | None = None


@dataclass(frozen=True)
class Panel:
    """A canvas with its axes and marks.

    Parameters
    ----------
    alt : str
        What it shows, for those who do not see it.
    x, y : tuple of float
        Where the axes begin and end.
    marks : sequence of Mark
        What is drawn, from back to front.
    aspect : float, default=1.0
        Height over width.
    x_label, y_label : str, default=""
        Names of the axes; none are drawn without `x_label`.
    x_ticks, y_ticks : tuple of float, default=()
        Where they are marked.
    y_names : tuple of str, default=()
        What is written there, as on a logarithmic axis; by default the numbers.
    """

    alt: str
    x: tuple[float, float]
    y: tuple[float, float]
    marks: Sequence[Mark]
    aspect: float = 1.0
    x_label: str = ""
    y_label: str = ""
    x_ticks: tuple[float, ...] = ()
    y_ticks: tuple[float, ...] = ()
    y_names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Slider:
    """Panels beside one another over a slider.

    Parameters
    ----------
    name : str
        What the slider sets, as "task angle".
    labels : sequence of str
        Its value at each step, with the unit.
    captions : sequence of str
        What is said below the panels, step by step.
    panels : sequence of Panel
        What is drawn.
    poster : Figure
        The picture in place of it.
    poster_alt : str
        What that shows.
    first : int, default=0
        Where the slider is at first.
    seconds : float, default=2.2
        How long a film takes.
    walks : bool, default=False
        Whether **Play** walks through the steps, instead of the film of one step.
    legend : dict of str to str, optional
        Colours by name.

    Raises
    ------
    ValueError
        If a mark has not as many shapes as the slider has steps.
    """

    name: str
    labels: Sequence[str]
    captions: Sequence[str]
    panels: Sequence[Panel]
    poster: Figure
    poster_alt: str
    first: int = 0
    seconds: float = 2.2
    walks: bool = False
    legend: dict[str, str] = field(default_factory=dict)

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
        png = self._png()
        return {
            "text/html": self.to_html(png),
            "image/png": base64.b64encode(png).decode(),
            "text/plain": f"a slider over {self.name}: {self.poster_alt}",
        }

    def to_html(self, png: bytes | None = None) -> str:
        """Write a piece of HTML that needs no other file, with the poster (PNG)."""
        image = base64.b64encode(png or self._png()).decode()
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

    def _png(self) -> bytes:
        file = io.BytesIO()
        self.poster.savefig(file, format="png", dpi=110, metadata={"Software": None})
        return file.getvalue()

    def _data(self) -> dict[str, Any]:
        """Return what the script reads."""
        fields = "n_times", "seconds", "walks", "labels", "captions"
        data = {name: getattr(self, name) for name in fields}
        return data | {"panels": [_describe(panel) for panel in self.panels]}


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
