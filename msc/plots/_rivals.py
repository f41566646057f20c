"""The systems of the paper's section V: what runs of each, what checks it, its numbers.

A method named "after X: what is left" lacks X's defining part, or stands in for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msc.estimates import Estimate
from msc.plots._style import METHOD_STYLES, SMALL, TRIO, styled
from msc.plots._tables import WORLD_TITLES, Stored
from msc.study import MEASURES, find_cell


class System(NamedTuple):
    """A system of the related work."""

    name: str
    cited: str  # in the references
    method: str  # that runs here
    part: str  # of the original, which it has
    check: str  # that does not rest on its code
    test: str  # where that is checked: file and function
    before: str = ""  # another method: itself, before it practised


SECTION_V = (
    System(
        "da Silva, Konidaris, Barto",
        "dasilva2012",
        "da Silva's skill",
        "ISOMAP's components; SVM gate; SV regression",
        "Isomap counts as many components",
        "test_components.test_components_are_as_many_as_isomap_warns_of",
    ),
    System(
        "Kober et al.",
        "kober2012",
        "Kober's practice",
        "draws what it is unsure of, pays, learns",
        "its Table I, written out by inverses",
        "test_crkr_practice.test_every_draw_is_that_of_table_1",
        "CrKr",
    ),
    System(
        "Mülling et al.",
        "mulling2013",
        "Mülling's practice",
        "a gate mixes movements, learns by reward",
        "scikit-learn's logistic regression",
        "test_mixture_practice."
        "test_the_gate_is_a_logistic_regression_weighted_by_rewards",
        "after Mülling: no practice",
    ),
    System(
        "Deisenroth et al.",
        "deisenroth2014",
        "after Deisenroth: model-free",
        "one function of the task, on its mean cost",
        "the normal equations, if costs are quadratic",
        "test_multitask.test_quadratic_costs_make_it_weighted_least_squares",
    ),
    System(
        "Hausknecht and Stone",
        "hausknecht2011",
        "after Hausknecht: no sweep",
        "one parameter varied, and inverted",
        "scikit-learn's partial least squares",
        "test_sweep_inverted.test_the_direction_is_that_of_partial_least_squares",
    ),
    System(
        "Liu and Stone",
        "liu2006",
        "after Liu: mapped",
        "carried over by what corresponds",
        "SciPy's Procrustes finds no other difference",
        "test_mapping.test_the_movement_is_turned_and_stretched",
    ),
    System(
        "Soni and Singh",
        "soni2006",
        "after Soni: stopped",
        "a movement ends when the goal says so",
        "a straight one, at the perpendicular's foot",
        "test_option.test_a_straight_movement_stops_at_the_foot_of_the_perpendicular",
    ),
)
"""In the paper's order."""

BESIDE = (
    "charts",
    "single regression",
    "CrKr",
    "nearest neighbour",
    "linear interpolation",
)
_MEASURES = "error_cm", "excess_cost", "touched"


def section_v_table(*studies: Stored, n_samples: int = 24) -> pd.DataFrame:
    """List the systems of section V, a row each: what runs, what checks it, numbers.

    Parameters
    ----------
    *studies : dict
        Results of studies, one a world.
    n_samples : int, default=24
        Evenly spaced training tasks.

    Returns
    -------
    DataFrame
        Under "here": the method, which of the original's parts it has, and by what
        that is checked. Under each world: means with their intervals over training
        sets and test tasks, the share of tasks in which an obstacle was touched, and
        the method's own rollouts for a training set.
    """
    rows = {}
    for system in SECTION_V:
        row = {
            ("here", "method"): system.method,
            ("here", "its part"): system.part,
            ("here", "checked by"): system.check,
        }
        for study in studies:
            world, found = WORLD_TITLES[study["workspace"]], _found(study, n_samples)
            for measure in _MEASURES:
                cell = found[measure].get(system.method)
                row[world, MEASURES[measure].label] = _write(cell, measure)
            spent = study["rollouts"].get(system.method, 0)
            row[world, "rollouts"] = f"{spent:,.0f}" if spent else "none"
        rows[system.name] = row
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("system")


def _found(study: Stored, n_samples: int) -> dict[str, Any]:
    """Return summaries by measure and method."""
    measures: dict[str, Any] = find_cell(study, "even", n_samples)["measures"]
    return measures


def _write(cell: Any, measure: str) -> str:
    """Write a mean, with its interval unless it is a share; or why there is none."""
    if cell is None:
        return "not run"
    if cell["mean"] is None:
        return "failed"
    share = measure == "touched"
    return f"{cell['mean']:.0%}" if share else f"{Estimate.read(cell, 'mean')}"


@styled
def plot_section_v(
    *studies: Stored,
    measures: Sequence[str] = ("error_cm", "excess_cost"),
    n_samples: int = 24,
) -> Figure:
    """Draw what the systems of section V do when executed, beside what it is set to.

    Parameters
    ----------
    *studies : dict
        Results of studies, one column of panels each.
    measures : sequence of str, default=("error_cm", "excess_cost")
        One row of panels each.
    n_samples : int, default=24
        Evenly spaced training tasks.

    Returns
    -------
    Figure
        A row a method: a faint dot a training set, and their mean.
    """
    rows = [one for s in SECTION_V for one in (s.before, s.method) if one]
    rows = [name for name in rows if name not in BESIDE] + [*BESIDE]
    figure, axes = plt.subplots(
        len(measures),
        len(studies),
        squeeze=False,
        sharey=True,
        sharex="row",
        figsize=(7.4, 0.4 + 0.2 * len(rows) * len(measures)),
    )
    for column, study in zip(axes.T, studies, strict=True):
        found = _found(study, n_samples)
        column[0].set_title(WORLD_TITLES[study["workspace"]])
        for axis, measure in zip(column, measures, strict=True):
            for place, name in enumerate(rows):
                if cell := found[measure].get(name):
                    _draw_row(axis, -place, name, cell)
            axis.axhline(0.5 - len(rows) + len(BESIDE), color="0.6", lw=0.8)
            axis.set(xscale="log", xlabel=MEASURES[measure].label)
    for axis in axes[:, 0]:
        axis.set_yticks(range(0, -len(rows), -1), rows, fontsize=SMALL)
    return figure


def _draw_row(axis: Axes, place: float, name: str, cell: dict[str, Any]) -> None:
    """Draw a method's training sets and their mean; hollow: "after" another."""
    colour = METHOD_STYLES[name]["color"] if name in BESIDE else TRIO[2]
    sets = cell["per_repetition"]
    look: Any = {"color": colour, "ls": ""}
    axis.plot(sets, [place] * len(sets), marker="o", ms=3, alpha=0.35, mew=0, **look)
    fill = "white" if name.startswith("after ") else colour
    axis.plot(cell["mean"], place, marker="D", ms=5, mfc=fill, **look)
