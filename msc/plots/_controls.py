"""Controls, drawn: kernels of weights, charts known in part, ends that are prescribed.

All read the evenly spaced training sets of a study.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator, PercentFormatter
from numpy.typing import NDArray

from msc.plots._style import COLOURS, COUNT_STYLES, TRIO, styled
from msc.plots._tables import WORLD_TITLES, Stored
from msc.study import MEASURES, count_ahead, find_cell

BOTH = ("error_cm", "mse, gate learned")  # what the arm did, and the paper's measure

# By kernel: charts and a single regression, with a kernel a weight, and with one.
_KERNELS = {
    "squared exponential": (
        "charts",
        "single regression",
        "charts, one kernel",
        "single, one kernel",
    ),
    "Matérn": (
        "charts, Matérn",
        "single, Matérn",
        "charts, Matérn, one kernel",
        "single, Matérn, one kernel",
    ),
}
_LEARNERS: tuple[dict[str, Any], ...] = tuple(
    {"color": COLOURS[name], "marker": marker, **look, "label": f"{short}, {kernels}"}
    for kernels, look in (
        ("six kernels", {"ls": ":", "mfc": "white"}),
        ("one kernel", {"ls": "-"}),
    )
    for name, marker, short in (
        ("charts", "o", "charts"),
        ("single regression", "s", "single"),
    )
)

_CHARTS = {"SMCE": "SMCE", "linkage": "single linkage", "pieces": "true pieces"}
_GATES: dict[str, dict[str, Any]] = {
    "": {"color": COLOURS["charts"], "marker": "o", "ls": "-", "mfc": "white", "ms": 6},
    "best gate": {"color": "0.55", "marker": "x", "ls": ":"},
    "abstaining": {"color": TRIO[1], "marker": "^", "ls": "--"},
    "by trial": {"color": TRIO[2], "marker": "D", "ls": "-."},
    "true gate": {"color": "black", "marker": "s", "ls": "-"},
}
NO_CHARTS = "single, one kernel"
FIRST_RUNG = "charts, one kernel"  # by SMCE, with the nearest task's chart

PROJECTED = ", projected"
_JUDGED = ("excess_cost", "touched", "error_cm")
_FEW = (12, 24, 50)  # training tasks of methods that are tried on some sets


def rung(charts: str, gate: str = "") -> str:
    """Name a rung of the ladder as the study does.

    Parameters
    ----------
    charts : {"SMCE", "linkage", "pieces"}
        Who found them.
    gate : {"", "best gate", "abstaining", "by trial", "true gate"}, default=""
        Who tells them; the nearest task, if nobody is named.

    Returns
    -------
    str
        A name of `msc.study.METHODS`.

    Examples
    --------
    >>> rung("SMCE"), rung("pieces", "true gate")
    ('charts, one kernel', 'ladder: pieces, true gate')
    """
    if (charts, gate) == ("SMCE", ""):
        return FIRST_RUNG
    return f"ladder: {charts}{', ' if gate else ''}{gate}"


@styled
def plot_kernels(*studies: Stored, measures: Sequence[str] = BOTH) -> Figure:
    """Draw charts and single regressions, with a kernel for each weight or for all.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`.
    measures : sequence of str, default=("error_cm", "mse, gate learned")
        One row of panels each, and for each study.

    Returns
    -------
    Figure
        One column a kernel. A faint dot is a training set, its mean over the test
        tasks; lines join medians over the sets.
    """
    rows = [*product(measures, studies)]
    figure, axes = _panels(rows, [*_KERNELS])
    for line, (measure, study) in zip(axes, rows, strict=True):
        cells = _even(study)
        for axis, names in zip(line, _KERNELS.values(), strict=True):
            aside = np.geomspace(0.92, 1.09, len(names))
            for name, look, shift in zip(names, _LEARNERS, aside, strict=True):
                _scatter(axis, cells, measure, name, shift=shift, **look)
    _name_below(figure, axes, 4)
    return figure


@styled
def plot_ladder(*studies: Stored, measures: Sequence[str] = BOTH) -> Figure:
    """Draw what charts cost and what the gate costs, up to charts that are known.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`.
    measures : sequence of str, default=("error_cm", "mse, gate learned")
        One row of panels each, and for each study.

    Returns
    -------
    Figure
        One column a way to charts, one line a gate: means over test tasks and training
        sets. Grey in each panel: no charts; thin: the first panel's nearest task.
    """
    rows = [*product(measures, studies)]
    figure, axes = _panels(rows, [*_CHARTS.values()])
    for line, (measure, study) in zip(axes, rows, strict=True):
        cells = _even(study)
        alone: Any = {"color": "0.8", "lw": 4, "zorder": 1, "label": "no charts"}
        first: Any = {"color": COLOURS["charts"], "lw": 0.8, "label": "SMCE, nearest"}
        for axis, charts in zip(line, _CHARTS, strict=True):
            _join(axis, cells, measure, NO_CHARTS, **alone)
            if charts != "SMCE":
                _join(axis, cells, measure, FIRST_RUNG, **first)
            for gate, look in _GATES.items():
                more = {"ms": 3.5, "lw": 1.2, "label": gate or "nearest task", **look}
                _join(axis, cells, measure, rung(charts, gate), **more)
    _name_below(figure, axes, 4)
    return figure


@styled
def plot_projection(*studies: Stored) -> Figure:
    """Draw what methods' predictions do plain, and moved onto those that end at goals.

    Parameters
    ----------
    *studies : dict
        Results of `msc.study.run_study`, a row of panels each.

    Returns
    -------
    Figure
        Excess cost, tasks that touch an obstacle, and distance at the end; one row a
        method, in it one line a number of training tasks, from the plain mean (hollow)
        to the projected one (filled). Where there are no obstacles nothing is touched:
        there the legend is.
    """
    figure, axes = plt.subplots(
        len(studies), len(_JUDGED), figsize=(7.4, 3.9 * len(studies)), squeeze=False
    )
    for line, study in zip(axes, studies, strict=True):
        for axis, measure in zip(line, _JUDGED, strict=True):
            names = projected_methods(study)
            if study["workspace"] == "free" and measure == "touched":
                axis.set_axis_off()  # nothing is there
                continue
            for size, look in zip(_FEW, COUNT_STYLES, strict=True):
                found = find_cell(study, "even", size)["measures"][measure]
                shift = 0.25 * (_FEW.index(size) - 1)
                _move(axis, found, names, shift, **look, label=f"{size} tasks")
            shown = names if axis is line[0] else [""] * len(names)
            axis.set_yticks(range(len(names)), shown)
            axis.set_ylim(len(names) - 0.5, -0.5)
            axis.set_xlabel(MEASURES[measure].label)
            axis.tick_params(axis="y", length=0)
            if measure == "touched":
                axis.set(xlabel="tasks that touch an obstacle")
                axis.xaxis.set_major_formatter(PercentFormatter(1, decimals=0))
            else:
                axis.set_xscale("log")
        line[0].set_title(WORLD_TITLES[study["workspace"]], loc="left")
    _explain(figure, axes)
    return figure


def projected_methods(study: Stored) -> list[str]:
    """List the methods of which a study has the projected beside the plain.

    Parameters
    ----------
    study : dict
        Results of `msc.study.run_study`.

    Returns
    -------
    list of str
        By the plain mean excess cost with 24 training tasks, the least first.
    """
    found = find_cell(study, "even", 24)["measures"]["excess_cost"]
    names = [name for name in found if name + PROJECTED in found]
    return sorted(names, key=lambda name: _mean(found[name]))


def means_by_size(
    study: Stored, measure: str, *, n_sets: int | None = None
) -> pd.DataFrame:
    """List the means of all methods on evenly spaced sets.

    Parameters
    ----------
    study : dict
        Results of `msc.study.run_study`.
    measure : str
        A key of `MEASURES`.
    n_sets : int, optional
        Over how many training sets at most, the first ones; by default all that a
        method was tried on, which of some are fewer than of others.

    Returns
    -------
    DataFrame
        One row a method, one column a number of training tasks; NaN where a method was
        not tried, or could not be fitted.
    """
    columns = {
        cell["n_samples"]: {
            name: _mean(one, n_sets) for name, one in cell["measures"][measure].items()
        }
        for cell in _even(study)
    }
    return pd.DataFrame(columns).rename_axis(columns="training tasks")


def count_wins(study: Stored, measure: str, method: str, baseline: str) -> pd.DataFrame:
    """Count the evenly spaced training sets on which a method errs less than another.

    Parameters
    ----------
    study : dict
        Results of `msc.study.run_study`.
    measure : str
        A key of `MEASURES`.
    method, baseline : str
        The two, tried on the same sets.

    Returns
    -------
    DataFrame
        One row a number of training tasks that both were tried on: "ratio" of the means
        over the sets that both have, number of these "sets", and of those "won".
    """
    rows = {}
    for cell in _even(study):
        found = cell["measures"][measure]
        if {method, baseline} <= found.keys():
            won, n_sets = count_ahead(cell, measure, method, baseline)
            ours, theirs = (_mean(found[name], n_sets) for name in (method, baseline))
            row = {"ratio": ours / theirs, "sets": n_sets, "won": won}
            rows[cell["n_samples"]] = row
    table = pd.DataFrame.from_dict(rows, orient="index")
    return table.rename_axis("training tasks")


def _even(study: Stored) -> list[Stored]:
    """Return what was found on evenly spaced sets, by their size."""
    cells = [cell for cell in study["cells"] if cell["design"] == "even"]
    return sorted(cells, key=lambda cell: int(cell["n_samples"]))


def _panels(
    rows: Sequence[tuple[str, Stored]], heads: Sequence[str]
) -> tuple[Figure, NDArray[Any]]:
    """Lay out panels over training tasks, a row a measure and study, on one scale."""
    size = 7.4, 1.95 * len(rows) + 0.6
    shape: Any = {"sharex": True, "sharey": "row", "squeeze": False}
    figure, axes = plt.subplots(len(rows), len(heads), figsize=size, **shape)
    for axis, head in zip(axes[0], heads, strict=True):
        axis.set_title(head)
    sizes = [cell["n_samples"] for cell in _even(rows[0][1])]
    for line, (measure, study) in zip(axes, rows, strict=True):
        what = MEASURES[measure].axis.replace(", gate learned", "")
        line[0].set_ylabel(f"{WORLD_TITLES[study['workspace']]}\n{what}")
        for axis in line:
            axis.set(xscale="log", yscale="log")
            axis.xaxis.set_minor_locator(NullLocator())
            axis.set_xticks(sizes[::3], [str(n) for n in sizes[::3]])
    for axis in axes[-1]:
        axis.set_xlabel("training tasks")
    return figure, axes


def _scatter(
    axis: Axes,
    cells: Sequence[Stored],
    measure: str,
    name: str,
    *,
    shift: float,
    **look: Any,
) -> None:
    """Draw a method's mean of each set, a little aside, and a line through medians."""
    here = [cell for cell in cells if name in cell["measures"].get(measure, {})]
    sets = [cell["measures"][measure][name]["per_repetition"] for cell in here]
    places = [shift * cell["n_samples"] for cell in here]
    for place, values in zip(places, sets, strict=True):
        faint: Any = {"color": look["color"], "alpha": 0.35, "mew": 0}
        axis.plot([place] * len(values), values, ".", ms=4.5, **faint)
    medians = [np.median(values) if values else np.nan for values in sets]
    axis.plot(places, medians, ms=4, lw=1.2, **look)


def _join(
    axis: Axes, cells: Sequence[Stored], measure: str, name: str, **look: Any
) -> None:
    """Draw a line through a method's means."""
    here = [cell for cell in cells if name in cell["measures"].get(measure, {})]
    means = [_mean(cell["measures"][measure][name]) for cell in here]
    axis.plot([cell["n_samples"] for cell in here], means, **look)


def _move(
    axis: Axes,
    found: Mapping[str, Any],
    names: Sequence[str],
    shift: float,
    *,
    color: str,
    marker: str,
    label: str,
    **_: Any,
) -> None:
    """Draw a line a method, from its plain mean to that of its projected policies.

    Both are over the training sets that both were tried on.
    """
    heights = np.arange(len(names)) + shift
    n_sets = [len(found[name + PROJECTED]["per_repetition"]) or None for name in names]
    plain = np.array(
        [_mean(found[name], n) for name, n in zip(names, n_sets, strict=True)]
    )
    moved = np.array([_mean(found[name + PROJECTED]) for name in names])
    axis.hlines(heights, plain, moved, color=color, lw=1.2)
    look: Any = {"color": color, "marker": marker, "ls": "", "ms": 4}
    axis.plot(plain, heights, mfc="white", **look)
    axis.plot(moved, heights, label=label, **look)


def _explain(figure: Figure, axes: NDArray[Any]) -> None:
    """Put the legend of projections where a panel is left out, or else below all."""
    ways = [
        Line2D([], [], color="0.3", marker="o", ls="", mfc=fill, label=label)
        for fill, label in (("white", "plain"), ("0.3", "projected"))
    ]
    handles = [*ways, *axes[0, 0].get_legend_handles_labels()[0]]
    empty = [axis for axis in axes.flat if not axis.axison]
    if empty:
        empty[0].legend(handles=handles, loc="center")
    else:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def _mean(summary: Mapping[str, Any], n_sets: int | None = None) -> float:
    """Return a mean; NaN, which is not drawn, of what could not be fitted."""
    if summary["mean"] is None:
        return np.nan
    if n_sets is None or n_sets >= len(summary["per_repetition"]):
        return float(summary["mean"])
    return float(np.mean(summary["per_repetition"][:n_sets]))


def _name_below(figure: Figure, axes: NDArray[Any], n_columns: int) -> None:
    """Name below all what the last panel of the first row has, and scale all rows."""
    for line in axes:
        low, high = line[0].get_ylim()
        steps = (1, 2, 5) if high < 40 * low else (1,)
        line[0].yaxis.set_major_locator(LogLocator(subs=steps))
        line[0].yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
        line[0].yaxis.set_minor_locator(NullLocator())
    named = axes[0, -1].get_legend_handles_labels()
    figure.legend(*named, loc="outside lower center", ncols=n_columns)
