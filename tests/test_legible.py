"""The figures of the book can be read where they are shown and where they are printed.

The rule: a figure keeps its size, but wherever it goes it is no wider than 7 inches:
that is the page's column at a window of 1280 pixels (96 to the inch), and a paper's two
columns of 3.4 inches with the gap between them. There no text is smaller than 7 points
(subscripts excepted, which matplotlib sets at 0.7 of the text's size), and none is cut
off.
"""

import importlib
import inspect
from pathlib import Path

import pytest
from figures import FIGURES
from matplotlib.text import Text
from some import some

PLOTS = Path(__file__).parents[1] / "msc" / "plots"
WIDEST, SMALLEST = 7.0, 7.0  # inches, points


def test_every_figure_of_the_package_is_here():
    found = set()
    for path in PLOTS.glob("_[a-z]*.py"):
        module = importlib.import_module(f"msc.plots.{path.stem}")
        found |= {
            function
            for name, function in inspect.getmembers(module, inspect.isfunction)
            if name.startswith(("plot_", "slide_"))
        }
    assert found == set(FIGURES), "give the new figure an example in tests/figures.py"


def texts(figure):
    """Return all that is written in a figure, with where it is (inches)."""
    figure.draw_without_rendering()
    found = [text for text in figure.findobj(Text) if text.get_text().strip()]
    hidden = set().union(*(hidden_labels(axes) for axes in figure.axes))
    return [
        (text, text.get_window_extent().extents / figure.dpi)
        for text in found
        if text.get_visible() and text not in hidden
    ]


def hidden_labels(axes):
    """Return what belongs to ticks that are not drawn: in store, or out of view."""
    hidden = set()
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        in_use = {*axis.get_major_ticks(), *axis.get_minor_ticks()}
        for tick in {*axis.majorTicks, *axis.minorTicks}:
            if not (axes.axison and tick in in_use and low <= tick.get_loc() <= high):
                hidden |= {tick.label1, tick.label2}
    return hidden


@pytest.mark.parametrize("plot", some(FIGURES, every=2), ids=lambda plot: plot.__name__)
def test_a_figure_fits_its_text_is_large_enough_and_whole(plot):
    figure = FIGURES[plot]()
    width, height = figure.get_size_inches()
    assert width <= 7.5
    shrunk = min(1.0, WIDEST / width)
    written = texts(figure)
    small = {
        text.get_text(): round(text.get_fontsize() * shrunk, 2)
        for text, _ in written
        if text.get_fontsize() * shrunk < SMALLEST
    }
    assert not small
    outside = [
        text.get_text()
        for text, (x0, y0, x1, y1) in written
        if min(x0, y0) < -0.05 or x1 > width + 0.05 or y1 > height + 0.05
    ]
    assert not outside
