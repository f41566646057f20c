"""The figures of the controls show what studies hold: all of it, and in its place."""

import numpy as np
import pytest
from figures import controls
from imagined import imagine_controls

from msc.plots import (
    count_wins,
    means_by_size,
    plot_kernels,
    plot_ladder,
    plot_projection,
    projected_methods,
    rung,
)
from msc.plots._controls import _CHARTS, _GATES, _KERNELS, BOTH, NO_CHARTS
from msc.plots._tables import WORLD_TITLES
from msc.study import METHODS

SIZES = (12, 24, 50)
SIX_KERNELS = ("charts", "single regression", "charts, Matérn", "single, Matérn")


def study(means, world="obstacles"):
    return imagine_controls(world, means, SIZES)


def lines(axis):
    """Return lines with a name by it."""
    return {line.get_label(): line for line in axis.lines if line.get_label()[0] != "_"}


def test_all_rungs_are_methods_and_all_of_the_ladder_are_rungs():
    rungs = {rung(charts, gate) for charts in _CHARTS for gate in _GATES}
    listed = {name for name, method in METHODS.items() if method.group == "ladder"}
    assert rungs == listed | {"charts, one kernel"}
    assert NO_CHARTS in METHODS


def test_kernels_are_those_of_methods_that_differ_in_nothing_else():
    for names in _KERNELS.values():
        assert set(names) < set(METHODS)
        six, one = names[:2], names[2:]
        assert set(six) < set(SIX_KERNELS)
        for plain, shared in zip(six, one, strict=True):
            assert shared == f"{plain.replace(' regression', '')}, one kernel"


def test_a_line_joins_medians_of_the_sets_and_every_set_is_a_dot():
    found = study({"charts": 6.0})
    for cell, sets in zip(found["cells"], ([1, 2, 9], [3, 5], [4]), strict=True):
        for by_method in cell["measures"].values():
            by_method["charts"]["per_repetition"] = sets
    axis = plot_kernels(found, measures=["error_cm"]).axes[0]
    assert lines(axis)["charts, six kernels"].get_ydata().tolist() == [2, 4, 4]
    dots = [line.get_ydata().tolist() for line in axis.lines if line.get_ls() == "None"]
    assert dots == [[1, 2, 9], [3, 5], [4]]


def test_the_ladder_draws_means_of_each_rung_in_the_panel_of_its_charts():
    names = [rung(charts, gate) for charts in _CHARTS for gate in _GATES]
    means = {name: 10.0 + place for place, name in enumerate([*names, NO_CHARTS])}
    axes = plot_ladder(study(means), measures=["error_cm"]).axes
    for axis, charts in zip(axes, _CHARTS, strict=True):
        drawn = lines(axis)
        for gate in _GATES:
            mean = means[rung(charts, gate)]
            found = drawn[gate or "nearest task"].get_ydata()
            np.testing.assert_allclose(found, mean / np.array(SIZES))
        np.testing.assert_allclose(
            drawn["no charts"].get_ydata(), means[NO_CHARTS] / np.array(SIZES)
        )
    first = lines(axes[0])["nearest task"].get_ydata()
    for axis in axes[1:]:
        np.testing.assert_array_equal(lines(axis)["SMCE, nearest"].get_ydata(), first)


@pytest.mark.parametrize("plot", [plot_kernels, plot_ladder])
def test_a_row_is_a_measure_and_a_world(plot):
    axes = [axis for axis in plot(*controls()).axes if axis.get_ylabel()]
    heads = [axis.get_ylabel().splitlines()[0] for axis in axes]
    assert heads == [WORLD_TITLES[world] for world in ("free", "obstacles")] * len(BOTH)


@pytest.mark.parametrize("plot", [plot_kernels, plot_ladder])
def test_what_failed_leaves_a_gap(plot):
    found = study({"charts, one kernel": 6.0})
    for by_method in found["cells"][1]["measures"].values():
        by_method["charts, one kernel"] |= {"mean": None, "per_repetition": []}
    axis = plot(found, measures=["error_cm"]).axes[0]
    name = "charts, one kernel" if plot is plot_kernels else "nearest task"
    assert np.isnan(lines(axis)[name].get_ydata()).tolist() == [False, True, False]


def test_means_are_those_of_evenly_spaced_sets():
    found = study({"charts": 6.0, "CrKr": 3.0})
    found["cells"][2]["measures"]["error_cm"]["CrKr"]["mean"] = None
    found["cells"].append({**found["cells"][0], "design": "uniform", "n_samples": 8})
    table = means_by_size(found, "error_cm")
    assert table.columns.tolist() == [*SIZES]
    np.testing.assert_allclose(table.loc["charts"], 6 / np.array(SIZES))
    assert table.loc["CrKr"].isna().tolist() == [False, False, True]


def test_means_of_the_first_sets_are_compared_where_some_have_fewer():
    found = study({"charts": 4.0, "charts, projected": 1.0})
    for cell in found["cells"]:
        for by_method in cell["measures"].values():
            by_method["charts"] |= {"mean": 4.0, "per_repetition": [1.0, 2.0, 9.0]}
            by_method["charts, projected"] |= {"mean": 1, "per_repetition": [0.5, 1.5]}
    assert means_by_size(found, "error_cm").loc["charts", 12] == 4
    few = means_by_size(found, "error_cm", n_sets=2)
    assert few[12].tolist() == [1.5, 1]
    [line] = plot_projection(found).axes[0].collections[0].get_segments()
    assert line[:, 0].tolist() == [1.5, 1]


def test_a_set_is_won_by_who_errs_less_and_a_tie_by_nobody():
    found = study({"charts": 6.0, "CrKr": 3.0})
    for cell in found["cells"][:2]:
        cell["measures"]["error_cm"]["charts"]["per_repetition"] = [1, 2, 3, 4]
        cell["measures"]["error_cm"]["CrKr"]["per_repetition"] = [2, 2, 4, 3]
    del found["cells"][2]["measures"]["error_cm"]["CrKr"]
    table = count_wins(found, "error_cm", "charts", "CrKr")
    assert table.index.tolist() == [12, 24]
    assert table.iloc[0].tolist() == [2, 4, 2]


# Projection


def test_each_method_goes_from_its_plain_mean_to_the_projected_one():
    means = {"charts": 4.0, "charts, projected": 1.0, "CrKr": 2.0, "mean policy": 3.0}
    means |= {"CrKr, projected": 3.0}  # worse than the plain one
    found = study(means)
    assert projected_methods(found) == ["CrKr", "charts"]
    axis = plot_projection(found).axes[0]
    for size, marks in zip(SIZES, axis.collections, strict=True):
        ends = [segment[:, 0] * size for segment in marks.get_segments()]
        np.testing.assert_allclose(ends, [[2, 3], [4, 1]])
    hollow, full = axis.lines[:2]
    assert hollow.get_markerfacecolor() == "white" != full.get_markerfacecolor()
    np.testing.assert_allclose(12 * hollow.get_xdata(), [2, 4])
    np.testing.assert_allclose(12 * full.get_xdata(), [3, 1])
    assert [tick.get_text() for tick in axis.get_yticklabels()] == ["CrKr", "charts"]


def test_every_projected_method_is_shown():
    projected = {n for n, method in METHODS.items() if method.group == "projected"}
    shown = {f"{name}, projected" for name in projected_methods(controls()[0])}
    assert shown == projected


def test_the_legend_is_where_nothing_can_be_touched():
    figure = plot_projection(*controls())
    empty = [axis for axis in figure.axes if not axis.axison]
    assert len(empty) == 1
    labels = [text.get_text() for text in empty[0].get_legend().get_texts()]
    assert labels == ["plain", "projected", "12 tasks", "24 tasks", "50 tasks"]
    below = plot_projection(controls()[1])
    (legend,) = below.legends
    assert [text.get_text() for text in legend.get_texts()] == labels


def test_a_projection_that_failed_is_named_and_not_drawn():
    found = study({"charts": 4.0, "charts, projected": 1.0})
    for cell in found["cells"]:
        cell["measures"]["error_cm"]["charts, projected"]["mean"] = None
    axis = plot_projection(found).axes[2]
    assert np.isnan(axis.lines[1].get_xdata()).all()
