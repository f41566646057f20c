"""What was stored, as tables and figures of the chapters."""

from dataclasses import replace

import numpy as np
import pytest

from msc import load_dataset
from msc.data import load_results
from msc.estimates import Estimate
from msc.learn import SELECTION_CRITERIA
from msc.plots import (
    ahead_table,
    comparison_table,
    elbow_table,
    gate_shares,
    gate_table,
    kernel_table,
    plot_elbows,
    plot_sample_sizes,
    plot_sweep,
    ratio_table,
    sets_table,
)
from msc.plots._tables import comparisons, lay_out
from msc.study import (
    MEASURES,
    Experiment,
    draw_samples,
    find_cell,
    pick_typical_set,
)

BASELINES = {"single regression": 2.0, "CrKr": 1.0, "nearest neighbour": 0.5}


def summary(mean):
    sets = {"per_repetition": [0.8 * mean, 1.2 * mean]}
    return {"mean": mean, "low": 0.9 * mean, "high": 1.2 * mean} | sets


def cell(n_samples, design="even"):
    """Make a cell: the charts' error is 1/n, the others' that times a factor."""
    measures = {
        measure: {
            "charts": summary(factor / n_samples),
            **{name: summary(f / n_samples) for name, f in BASELINES.items()},
        }
        for measure, factor in (("mse, gate learned", 1), ("mse, chart known", 0.25))
    }
    ratios = [
        {
            "measure": "mse, gate learned",
            "method": "charts",
            "baseline": name,
            "ratio": 1 / factor,
            "low": 0.9 / factor,
            "high": 1.2 / factor,
        }
        for name, factor in BASELINES.items()
    ]
    parts = {"measures": measures, "ratios": ratios, "repetitions": 1}
    return {"design": design, "n_samples": n_samples, **parts}


def study(workspace):
    cells = [cell(n) for n in (8, 24, 72)] + [cell(8, "uniform")]
    sweep = [{**cell(n), "n_charts": s} for n in (24, 72) for s in (1, 2, 3)]
    return {"workspace": workspace, "cells": cells, "sweep": sweep}


free, obstacles = study("free"), study("obstacles")


def test_a_table_says_which_method_wins_at_each_size():
    table = ratio_table(free, obstacles, measures=["mse, gate learned"])
    assert table.index.tolist() == [8, 24, 72]
    assert table["without obstacles"].columns.tolist() == list(BASELINES)
    row = table.loc[24, "with obstacles"].tolist()
    assert row == [
        "●\N{NBSP}0.5 [0.45,\N{NBSP}0.6]",
        "○\N{NBSP}1 [0.9,\N{NBSP}1.2]",
        "✕\N{NBSP}2 [1.8,\N{NBSP}2.4]",
    ]


def test_bounds_that_say_nothing_are_not_written_out():
    wide = {"ratio": 3.0, "low": 4e-7, "high": 6e5}
    ratio = {"measure": "mse, gate learned", "method": "charts", "baseline": "CrKr"}
    found = {**free, "cells": [{**cell(24), "ratios": [ratio | wide]}]}
    table = ratio_table(found, measures=["mse, gate learned"], baselines=["CrKr"])
    assert table.loc[24].item() == "○\N{NBSP}3 [<0.001,\N{NBSP}>1000]"


def test_how_often_charts_are_ahead_is_counted():
    found = {**free, "cells": [cell(24)]}
    means = found["cells"][0]["measures"]["mse, gate learned"]
    means["charts"]["per_repetition"] = [0.001, 99.0]
    table = ahead_table(found, 24, measures=["mse, gate learned"], baselines=["CrKr"])
    assert table.loc["MSE, gate learned", "CrKr"] == "1 of 2"


def test_charts_with_another_kernel_have_ratios_of_their_own():
    rough = {"measure": "mse, gate learned", "method": "charts, Matérn"}
    ratio = rough | {"baseline": "CrKr", "ratio": 3.0, "low": 2.0, "high": 4.0}
    cells = [{**cell(24), "ratios": [*cell(24)["ratios"], ratio]}]
    what = {"measures": ["mse, gate learned"], "baselines": ["CrKr"]}
    found = {**free, "cells": cells}
    assert ratio_table(found, **what).loc[24, "CrKr"] == "○\N{NBSP}1 [0.9,\N{NBSP}1.2]"
    table = ratio_table(found, **what, method="charts, Matérn")
    assert table.loc[24, "CrKr"] == "✕\N{NBSP}3 [2,\N{NBSP}4]"


def test_kernels_are_compared_like_with_like_and_across():
    pairs = {"single regression": "charts", "single, Matérn": "charts, Matérn"}
    ratios = [
        {"measure": "error_cm", "method": method, "baseline": baseline}
        | {"ratio": ratio, "low": ratio, "high": ratio}
        for ratio, (baseline, method) in zip((2.0, 3.0), pairs.items(), strict=True)
    ]
    across = ratios[1] | {"method": "charts", "ratio": 0.5, "low": 0.5, "high": 0.5}
    found = {**free, "cells": [{**cell(24), "ratios": [*ratios, across]}]}
    row = kernel_table(found, measure="error_cm").loc[24].tolist()
    assert row == [
        "✕\N{NBSP}2 [2,\N{NBSP}2]",
        "✕\N{NBSP}3 [3,\N{NBSP}3]",
        "●\N{NBSP}0.5 [0.5,\N{NBSP}0.5]",
    ]
    assert kernel_table(found, obstacles).columns.nlevels == 2


def test_comparisons_stand_below_one_another():
    one = Estimate(0.5, 0.4, 0.7, "MSE", "CrKr")
    table = comparison_table(one, replace(one, label="error", high=1.5))
    assert table.index.tolist() == ["MSE", "error"]
    assert table.iloc[:, -1].tolist() == [
        "●\N{NBSP}0.5 [0.4,\N{NBSP}0.7]",
        "○\N{NBSP}0.5 [0.4,\N{NBSP}1.5]",
    ]


def test_what_is_the_same_in_all_columns_is_left_out():
    table = ratio_table(free, measures=["mse, gate learned"], baselines=["CrKr"])
    assert list(table.columns) == ["CrKr"]


def sets_of(**errors):
    """Return a study of all sets of 24 tasks, and these by their first task."""
    tasks = load_dataset("free")[0]
    sets = draw_samples("even", tasks, 24, n_draws=15, seed=5)
    by_method = {
        name: {"per_repetition": [float(error(one[0])) for one in sets]}
        for name, error in errors.items()
    }
    few = {"design": "even", "n_samples": 24, "repetitions": 15}
    cells = [cell(24, "uniform"), {**few, "measures": {"error_cm": by_method}}]
    found = {"workspace": "free", "seed": 5, "cells": cells}
    return found, {one[0]: one for one in sets}


def test_the_set_drawn_is_ranked_among_all():
    found, sets = sets_of(charts=lambda k: 7 + k, single=lambda _: 2)
    asked = {"measures": ["error_cm"], "methods": ["charts", "single"]}
    table = sets_table(found, sets[0], **asked).loc["distance at the end (cm)"]
    assert table.loc["charts"].tolist() == ["7", "1 of 15", "7", "14", "21"]
    assert table.loc["their ratio"].tolist() == ["3.5", "1 of 15", "3.5", "7", "10.5"]
    assert sets_table(found, sets[14], **asked).iloc[0, 1] == "15 of 15"
    with pytest.raises(
        ValueError, match=r"chosen=\[0, 1\b.*; wanted one of .* 15 sets"
    ):
        sets_table(found, range(24), **asked)


def test_the_typical_set_is_that_of_the_median_ratio():
    methods = {"charts": lambda k: (k - 3) ** 2 + 1, "single": lambda k: k + 1}
    found, sets = sets_of(**methods)
    pair = {"method": "charts", "baseline": "single"}
    chosen = pick_typical_set(found, 24, "error_cm", **pair)
    ratios = {k: ((k - 3) ** 2 + 1) / (k + 1) for k in range(15)}
    middle = sorted(ratios, key=ratios.get)[7]
    assert chosen.tolist() == sets[middle].tolist()
    without = pick_typical_set(found, 12, "error_cm", **pair)
    assert without.tolist() == list(range(0, 360, 30))


@pytest.mark.parametrize("world", ["free", "obstacles"])
def test_what_is_trained_on_the_typical_set_errs_as_the_study_says(world):
    (found,) = load_results(f"study_{world}")
    chosen = pick_typical_set(found, 24, "mse, gate learned")
    names = ("charts", "single regression")
    errors = Experiment(world, chosen=chosen, names=names).squared_errors().mean()
    kept = find_cell(found, "even", 24)["measures"]["mse, gate learned"]
    ratios = np.divide(*(kept[name]["per_repetition"] for name in names))
    drawn = errors[names[0]] / errors[names[1]]
    assert drawn == pytest.approx(np.median(ratios), rel=1e-4)  # as kept


def test_designs_are_kept_apart():
    assert list(comparisons(free, "mse, gate learned", "CrKr", design="uniform")) == [8]


def test_a_size_without_a_result_is_a_dash():
    few = {**obstacles, "cells": [cell(24)]}
    table = ratio_table(free, few, measures=["mse, gate learned"], baselines=["CrKr"])
    assert table["with obstacles", "CrKr"].str[0].tolist() == ["–", "○", "–"]


def test_numbers_keep_three_digits_and_whole_ones_all():
    numbers = {"whole": 12_345, "small": 7, "large": 1234.5, "share": 0.5, "none": None}
    numbers |= {"timed": {"median": 9.0, "low": 0.012345, "high": 99.96}}
    table = lay_out({"one": numbers, "other": dict.fromkeys(numbers, "as it is")})
    assert table["one"].tolist() == [
        *("12,345", "7", "1,234", "0.500", "left out"),
        "9.00 (0.0123–100)",
    ]
    assert set(table["other"]) == {"as it is"}
    mixed = lay_out({"mixed": {"whole": 7, "share": 0.5}})
    assert mixed["mixed"].tolist() == ["7", "0.500"]


def test_measures_have_names_in_words():
    assert MEASURES["mse, beside jumps"].axis == (
        "mean squared error\nof policies, beside jumps"
    )
    assert MEASURES["standardised mse, gate learned"].axis == (
        "mean squared error\nof standardised policies, gate learned"
    )
    assert MEASURES["excess_cost"].axis == "excess cost"
    assert MEASURES["error_cm"].axis == "distance at the end (cm)"


def test_what_a_known_chart_does_not_explain_is_the_gate_s():
    shares = gate_shares(free, obstacles)["with obstacles"]
    assert shares["the gate's share (%)"].tolist() == pytest.approx([75, 75, 75])
    assert shares.iloc[0, 0] == pytest.approx(0.25 / 8)


def signs(axis):
    return [text.get_text() for text in axis.texts if text.get_text() in "●○✕"]


def test_the_figure_has_a_panel_a_world_on_one_scale():
    figure = plot_sample_sizes(free, obstacles)
    left, right = figure.axes
    assert left.get_ylim() == right.get_ylim()
    assert left.get_xscale() == left.get_yscale() == "log"
    assert [line.get_label() for line in left.get_lines()] == [
        "charts",
        "CrKr",
        "single regression",
    ]
    heights = left.get_lines()[2].get_ydata()
    assert list(heights) == pytest.approx([2 / 8, 2 / 24, 2 / 72])
    assert signs(right) == ["○"] * 3 + ["●"] * 3


def test_bands_reach_from_the_best_training_set_to_the_worst():
    [axis] = plot_sample_sizes(free, methods=["charts"]).axes
    [band] = axis.collections
    heights = band.get_paths()[0].vertices[:, 1]
    assert heights.min() == pytest.approx(0.8 / 72)
    assert heights.max() == pytest.approx(1.2 / 8)


def test_a_method_without_results_is_left_out():
    figure = plot_sample_sizes(free, methods=["charts", "zero policy"])
    assert [line.get_label() for line in figure.axes[0].get_lines()] == ["charts"]


def test_a_sweep_has_a_line_a_number_of_training_tasks():
    figure = plot_sweep(free, obstacles, measures=["mse, gate learned"])
    lines = figure.axes[1].get_lines()
    assert [line.get_label() for line in lines] == ["24", "72"]
    assert list(lines[0].get_xdata()) == [1, 2, 3]


# The number of charts


def measured(world, picked, resampled, n_counts=6):
    """Return measurements in which all readings agree."""
    curve = (1.0 / np.arange(1, n_counts + 1)).tolist()
    reading = {"curve": curve, "picked": picked, "resampled": resampled}
    readings = dict.fromkeys(SELECTION_CRITERIA, reading)
    return {"workspace": world, "n_resamples": 10, "readings": readings}


@pytest.fixture
def elbows():
    return [
        measured("free", 3, {"3": 7, "4": 3}),
        measured("obstacles", 5, {"5": 4, "6": 6}),
    ]


def test_table_tells_picks_and_shares(elbows):
    table = elbow_table(*elbows)
    assert list(table.index) == list(SELECTION_CRITERIA.values())
    assert table["free"].iloc[0].tolist() == ["3", "30%", "3 (70%)"]
    assert table["obstacles"].iloc[-1].tolist() == ["5", "0%", "5 (40%)"]
    assert elbow_table(*elbows, count=5)["obstacles", "picks 5"].iloc[0] == "40%"


def test_figure_marks_every_pick_and_draws_every_share(elbows):
    axes = np.reshape(plot_elbows(*elbows).axes, (len(SELECTION_CRITERIA), 2))
    for column, picked, shares in (
        (axes[:, 0], 3, [0, 0, 0.7, 0.3, 0, 0]),
        (axes[:, 1], 5, [0, 0, 0, 0, 0.4, 0.6]),
    ):
        for axis in column:
            (diamond,) = [line for line in axis.lines if line.get_marker() == "D"]
            assert diamond.get_xdata().tolist() == [picked]
            heights = [bar.get_height() for bar in axis.patches]
            np.testing.assert_allclose(heights, shares)


def test_a_flat_curve_can_be_drawn(elbows):
    flat = {"curve": [0.0], "picked": 1, "resampled": {"1": 10}}
    elbows[0]["readings"] = dict.fromkeys(SELECTION_CRITERIA, flat)
    assert plot_elbows(*elbows)


def test_gates_are_told_by_world_and_size():
    found = {
        "n_samples": 24,
        "repetitions": 9,
        "accuracy": {"nearest": 0.75, "svm": 0.5},
        "best": {"nearest": 8, "svm": 1},
    }
    table = gate_table({"workspace": "free", "gates": [found]})
    assert table.loc["free", 24].to_dict() == {
        "training sets": 9,
        "nearest": "0.75 (8)",
        "svm": "0.50 (1)",
    }
