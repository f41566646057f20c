"""Figures on the study of many training sets: errors over the number of samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from msc.plots._style import COLOURS, COUNT_STYLES, METHOD_STYLES, SMALL, styled
from msc.plots._tables import PLAIN, SIGNS, WORLD_TITLES, compare_cells

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Study = dict[str, Any]

PAPER_METHODS = ("charts", "CrKr", "single regression")  # of Figure 8


@styled
def plot_sample_sizes(
    *studies: Study,
    measures: Sequence[str] = ("mse, gate learned",),
    methods: Sequence[str] = PAPER_METHODS,
    design: str = "even",
    verdicts: bool = True,
) -> Figure:
    """Draw errors over the number of training tasks, as the paper's Figure 8.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`, one column of panels each.
    measures : sequence of str, default=("mse, gate learned",)
        One row of panels each; all panels of a row have the same scale.
    methods : sequence of str, default=PAPER_METHODS
        The lines.
    design : {"even", "uniform", "nonuniform"}, default="even"
        How training tasks were drawn.
    verdicts : bool, default=True
        Whether to write, below each panel, whether the charts' error is lower (●),
        higher (✕) or undecided (○) against each other method at each size.

    Returns
    -------
    Figure
        The drawing; bands are 95 % intervals.
    """
    figure, axes = _panels(studies, measures, 3.0 * len(measures) + 0.6)
    for column, study in zip(axes.T, studies, strict=True):
        cells = [cell for cell in study["cells"] if cell["design"] == design]
        for axis, measure in zip(column, measures, strict=True):
            for method in methods:
                _draw_line(axis, cells, measure, method)
            axis.set(xscale="log", yscale="log")
            if verdicts:
                _draw_verdicts(axis, study, design, measure, methods[1:])
        _name_sizes(column[-1], [cell["n_samples"] for cell in cells])
    axes[0, -1].legend()
    return figure


def name_measure(measure: str) -> str:
    """Say in plain words what an axis shows, with the unit if there is one.

    Parameters
    ----------
    measure : str
        As studies name it, see `msc.study._study`.

    Returns
    -------
    str
        Its name; policy weights have no unit.

    Examples
    --------
    >>> name_measure("error_cm")
    'distance at the end (cm)'
    >>> print(name_measure("mse, chart known"))
    mean squared error
    of policies, chart known
    """
    kind, comma, reading = measure.partition("mse, ")
    if not comma:
        return PLAIN.get(measure, measure)
    of = "standardised policies" if kind else "policies"
    return f"mean squared error\nof {of}, {reading}"


def _panels(
    studies: Sequence[Study], measures: Sequence[str], height: float
) -> tuple[Figure, NDArray[Any]]:
    """Lay out one row of panels a measure, on one scale, and one column a study."""
    figure, axes = plt.subplots(
        len(measures),
        len(studies),
        figsize=(3.7 * len(studies), height),
        sharex=True,
        sharey="row",
        squeeze=False,
    )
    for axis, study in zip(axes[0], studies, strict=True):
        axis.set_title(WORLD_TITLES[study["workspace"]])
    for axis, measure in zip(axes[:, 0], measures, strict=True):
        axis.set_ylabel(name_measure(measure))
    return figure, axes


def _draw_line(axis: Axes, cells: list[Any], measure: str, method: str) -> None:
    """Draw one method's means over the sizes, with their intervals."""
    here = [cell for cell in cells if method in cell["measures"].get(measure, {})]
    found = pd.DataFrame([cell["measures"][measure][method] for cell in here])
    if found.empty:
        return
    sizes = [cell["n_samples"] for cell in here]
    _draw_band(axis, sizes, found, method, METHOD_STYLES[method])


def _draw_verdicts(
    axis: Axes, study: Study, design: str, measure: str, baselines: Sequence[str]
) -> None:
    """Write, below a panel, the verdict on the charts at each size."""
    below = axis.get_xaxis_transform()
    found = compare_cells(study, design)
    found = found[found["measure"] == measure]
    for row, baseline in enumerate(baselines):
        height = -0.07 * (row + 1)
        look: Any = {"color": COLOURS[baseline], "fontsize": SMALL, "va": "center"}
        here = found[found["baseline"] == baseline]
        for place, one in zip(here["n_samples"], here["comparison"], strict=True):
            sign = SIGNS[one.verdict]
            axis.text(place, height, sign, transform=below, ha="center", **look)
        place_in_grid: Any = axis.get_subplotspec()
        if place_in_grid.is_first_col():
            beside, text = axis.transAxes, f"vs {baseline} "
            dark = look | {"color": "0.2"}  # a name has to be read
            axis.text(-0.02, height, text, transform=beside, ha="right", **dark)
    axis.tick_params(axis="x", pad=4 + 15 * len(baselines))


def _name_sizes(axis: Axes, sizes: Sequence[int]) -> None:
    """Write every number of training tasks on a logarithmic axis."""
    axis.set_xlabel("training tasks")
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xticks(sizes, [str(size) for size in sizes], fontsize=SMALL)


@styled
def plot_sweep(*studies: Study, measures: Sequence[str]) -> Figure:
    """Draw the charts' errors over the number of charts.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`, one column of panels each.
    measures : sequence of str
        One row of panels each.

    Returns
    -------
    Figure
        The drawing; one line a number of training tasks, bands are 95 % intervals.
    """
    figure, axes = _panels(
        studies, [name_measure(one) for one in measures], 2.6 * len(measures)
    )
    for column, study in zip(axes.T, studies, strict=True):
        sweep = pd.DataFrame(study["sweep"])
        for axis, measure in zip(column, measures, strict=True):
            for (n_samples, cells), look in zip(
                sweep.groupby("n_samples"), COUNT_STYLES, strict=False
            ):
                found = pd.DataFrame(
                    [cell[measure]["charts"] for cell in cells["measures"]]
                )
                _draw_band(axis, cells["n_charts"], found, str(n_samples), look)
            axis.set_yscale("log")
        column[-1].set(xlabel="charts", xticks=sweep["n_charts"].unique())
    axes[0, -1].legend(title="training tasks")
    return figure


def _draw_band(
    axis: Axes, places: Any, found: pd.DataFrame, label: str, look: dict[str, Any]
) -> None:
    """Draw means as a line, their intervals as a band."""
    axis.plot(places, found["mean"], label=label, ms=4, **look)
    colour = look["color"]
    axis.fill_between(
        places, found["low"], found["high"], color=colour, alpha=0.15, lw=0
    )
