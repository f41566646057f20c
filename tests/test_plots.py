"""The paper's figures show errors as they are, and what sums them up."""

import numpy as np
import pytest
from figures import experiment

from msc.plots import plot_execution, plot_manifold, slide_execution
from msc.plots._manifold import COMPARED, find_median
from msc.plots._style import COLOURS


@pytest.fixture(scope="module")
def found():
    return experiment()


def heights(lines):
    return np.concatenate([line.get_ydata() for line in lines])


def test_every_executed_task_is_a_mark_and_a_line_of_the_rug(found):
    axes = plot_execution(found).axes
    for (axis, rug), method in zip(np.reshape(axes, (2, 2)), COMPARED, strict=True):
        errors = found.executed_by_method("error_cm")[method]
        marks = [line for line in axis.lines if line.get_color() == COLOURS[method]]
        np.testing.assert_array_equal(np.sort(heights(marks)), np.sort(errors))
        ends = np.array(rug.collections[0].get_segments())[:, 0, 1]
        np.testing.assert_array_equal(np.sort(ends), np.sort(errors))
        lines = {line.get_label(): line.get_ydata()[0] for line in axis.lines}
        assert lines["median"] == pytest.approx(np.median(errors))
        assert lines["mean"] == pytest.approx(errors.mean())
        assert axis.get_yscale() == "log"
        low, high = axis.get_ylim()
        assert low < errors.min() <= errors.max() < high


def test_the_legend_of_both_methods_has_the_colour_of_neither(found):
    (legend,) = plot_execution(found).legends
    assert {line.get_color() for line in legend.get_lines()} == {"0.3"}


def test_residuals_stand_below_a_dimension_that_is_alone(found):
    *_, single, charts = plot_manifold(found, [2]).axes
    for axis, method in ((single, "single regression"), (charts, "charts")):
        predicted = found.predict(method, found.tasks)[:, 2]
        (line,) = (one for one in axis.lines if one.get_marker() == ".")
        np.testing.assert_array_equal(
            line.get_ydata(), predicted - found.policies[:, 2]
        )
    assert len(plot_manifold(found, [0, 2]).axes) == 4


def test_the_slider_opens_at_the_median_task(found):
    slider = slide_execution(found, every=10)
    errors = found.executed_by_method("error_cm")["single regression"].to_numpy()[::10]
    below = (errors < errors[slider.first]).sum()
    assert below == (len(errors) - 1) // 2


@pytest.mark.parametrize("n_tasks", [1, 2, 7, 8])
def test_half_the_errors_are_no_larger_than_the_median_one(n_tasks):
    errors = np.random.default_rng(n_tasks).random(n_tasks)
    middle = errors[find_median(errors)]
    assert (errors < middle).sum() <= n_tasks / 2 >= (errors > middle).sum()
