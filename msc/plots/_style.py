"""What figures look like: one style, and one look for each thing that returns.

A method has the same colour, marker and dashes on every page. The colours keep apart in
grey and to the colour-blind, at least where nothing but colour tells two things apart;
`tests/test_style.py` simulates both. No figure names a colour of its own but greys, and
red for goals; the view at a slant has its own, in `_film`.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, SupportsIndex

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

Array = NDArray[np.float64]
_P = ParamSpec("_P")

SMALL = 8  # points; the smallest text
STYLE: Any = {
    "figure.dpi": 150,
    "figure.constrained_layout.use": True,
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.grid": True,
    "grid.color": "0.92",
    "legend.fontsize": SMALL,
    "legend.title_fontsize": SMALL,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
}

METHOD_STYLES: dict[str, dict[str, Any]] = {
    "charts": {"color": "#00467F", "marker": "o", "ls": "-"},
    "single regression": {"color": "#C44E00", "marker": "s", "ls": "--"},
    "CrKr": {"color": "#3E9FD8", "marker": "^", "ls": "-."},
    "nearest neighbour": {"color": "#009E73", "marker": "D", "ls": ":"},
    "linear interpolation": {"color": "#CC79A7", "marker": "v", "ls": ":"},
    "single, Matérn": {"color": "#B8860B", "marker": "P", "ls": "--"},
    "single, periodic": {"color": "#8C8C8C", "marker": "X", "ls": "--"},
    "mean policy": {"color": "#595959", "marker": "", "ls": (0, (1, 1))},
    "zero policy": {"color": "#B3B3B3", "marker": "", "ls": (0, (3, 1, 1, 1, 1, 1))},
    "searched": {"color": "#9E9E9E", "marker": ".", "ls": "-"},
}
COLOURS: dict[str, str] = {name: look["color"] for name, look in METHOD_STYLES.items()}

# Charts by number, never in the colour of a method; and their markers.
CHART_COLOURS = ("#6A0F49", "#0F7A5A", "#B07AE0", "#E0A800", "#7A5C3E", "#38C0C8")
CHART_MARKERS = "os^DvP"

# Two or three things that are neither: sides of a break, worlds, basis functions.
TRIO = ("#2A6FDB", "#DB8C00", "#8A2A6B")
WORLD_STYLES: dict[str, dict[str, Any]] = {
    "free": {"color": TRIO[0], "marker": "o"},
    "obstacles": {"color": TRIO[1], "marker": "s"},
}
# Few, some, many: what is counted grows darker.
COUNT_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#E3A33C", "marker": "D", "ls": ":"},
    {"color": "#B2456E", "marker": "^", "ls": "--"},
    {"color": "#46185F", "marker": "o", "ls": "-"},
)
GOAL = "#D62728"

# The policy's dimensions: in figures, and where there is no LaTeX.
WEIGHT_LABELS = ("$w_1^x$", "$w_2^x$", "$w_3^x$", "$w_1^y$", "$w_2^y$", "$w_3^y$")
WEIGHT_NAMES = ("w₁ˣ", "w₂ˣ", "w₃ˣ", "w₁ʸ", "w₂ʸ", "w₃ʸ")


def chart_colour(chart: SupportsIndex) -> str:
    """Choose a chart's colour; after the last they come again."""
    return CHART_COLOURS[int(chart) % len(CHART_COLOURS)]


def chart_marker(chart: SupportsIndex) -> str:
    """Choose a chart's marker; after the last they come again."""
    return CHART_MARKERS[int(chart) % len(CHART_MARKERS)]


def widen(values: Array, share: float) -> tuple[float, float]:
    """Return bounds of values with a share of their range added at either end."""
    margin = share * np.ptp(values)
    return float(values.min() - margin), float(values.max() + margin)


def encode_png(figure: Figure, **look: Any) -> str:
    """Draw a figure as PNG (base 64), the same bytes each time."""
    file = io.BytesIO()
    look = {"dpi": 110, "metadata": {"Software": None}, **look}
    figure.savefig(file, format="png", **look)
    return base64.b64encode(file.getvalue()).decode()


def styled(draw: Callable[_P, Figure]) -> Callable[_P, Figure]:
    """Have a function draw in the style of all figures; pyplot forgets what it drew."""

    @wraps(draw)
    def drawn(*args: _P.args, **options: _P.kwargs) -> Figure:
        with plt.rc_context(STYLE):
            figure = draw(*args, **options)
        plt.close(figure)
        return figure

    return drawn
