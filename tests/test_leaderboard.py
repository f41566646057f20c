"""The table of all methods, and the picture of where predictions mean to stop."""

import html
import json
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

from msc.plots import (
    Leaderboard,
    list_methods,
    planned_stops,
    plot_leaderboard,
    plot_stops,
    standings_table,
)
from msc.plots._leaderboard import APART, GROUPS, LISTED, SIZES
from msc.study import METHODS, Experiment

MEANS = {"charts": 2.0, "CrKr": 0.5, "random forest": 8.0, "mean policy": None}


def imagine(world="free", means=MEANS):
    """Return a study of a few methods, one of which failed with 24 tasks."""

    def summary(mean):
        if mean is None:
            return {**dict.fromkeys(("low", "mean", "high")), "per_repetition": []}
        sets = {"per_repetition": [mean / 2, 3 * mean / 2]}
        return {"low": mean / 9, "mean": mean, "high": 9 * mean} | sets

    ratios = [
        {"measure": key, "method": "charts", "baseline": name}
        | {"ratio": 2 / mean, "low": low / mean, "high": 3 / mean}
        for key in LISTED
        for name, mean, low in (("CrKr", 0.5, 1.0), ("random forest", 8.0, 1.0))
    ]
    measures = {key: {name: summary(m) for name, m in means.items()} for key in LISTED}
    cells = [
        {"design": "even", "n_samples": n, "measures": measures, "ratios": ratios}
        for n in SIZES
    ]
    failed = {"mean policy": {"even/24/0": "why", "even/24/1": "why", "even/50/0": ""}}
    return {"workspace": world, "cells": cells, "failed": failed}


def test_the_least_is_on_top():
    rows = [row for row in list_methods(imagine(), "error_cm", 24) if row["mean"]]
    assert [row["name"] for row in rows] == ["CrKr", "charts", "random forest"]
    assert [row["told"] for row in rows] == ["0.5", "2", "8"]
    assert [row["range"] for row in rows] == ["0.25–0.75 (2)", "1–3 (2)", "4–12 (2)"]
    assert [row["sets"] for row in rows] == [[0.25, 0.75], [1.0, 3.0], [4.0, 12.0]]
    assert [row["against"] for row in rows] == ["✕ 4 ×", "", "● 0.25 ×"]
    assert [row["interval"] for row in rows] == ["[2, 6]", "", "[0.12, 0.38]"]


def test_whoever_has_no_result_is_there_and_says_why():
    study = imagine()
    del study["cells"][0]["measures"]["error_cm"]["random forest"]
    by_name = {row["name"]: row for row in list_methods(study, "error_cm", 12)}
    assert by_name["mean policy"]["told"] == "failed"
    assert by_name["CrKr, projected"]["told"] == "no results yet"
    rows = list_methods(study, "error_cm", 24)
    assert {row["name"]: row["told"] for row in rows}[
        "mean policy"
    ] == "failed on 2 sets"
    without = [row["mean"] is None for row in rows]
    assert without == sorted(without)
    wanted = {name for name, one in METHODS.items() if one.group in GROUPS}
    assert {row["name"] for row in rows} == wanted


def test_what_was_tried_at_another_size_only_says_so():
    study = imagine()
    measures = {key: dict(one) for key, one in study["cells"][0]["measures"].items()}
    for by_method in measures.values():
        del by_method["random forest"]
    study["cells"][0] = study["cells"][0] | {"measures": measures}
    told = {row["name"]: row["told"] for row in list_methods(study, "error_cm", 12)}
    assert told["random forest"] == "not tried at this n"


def test_a_method_of_another_version_is_shown():
    rows = list_methods(imagine(means=MEANS | {"<b>": 1.0}), "error_cm", 24)
    (row,) = [row for row in rows if row["name"] == "<b>"]
    assert (row["group"], row["told"]) == ("of another version", "1")


def test_every_group_of_methods_has_a_name():
    listed = {method.group for method in METHODS.values()} - {"number of charts"}
    assert listed == set(GROUPS)
    assert set(APART) < set(GROUPS)


def page_of(*studies):
    return Leaderboard(studies, plt.figure())._repr_mimebundle_()


def test_the_page_has_all_numbers_and_needs_no_other_file():
    shown = page_of(imagine(), imagine("obstacles"))
    page = shown["text/html"]
    data = json.loads(
        re.search(r"currentScript\.previousElementSibling,(.*)\);", page)[1]
    )
    assert len(data) == 2 * len(LISTED) * len(SIZES)
    assert data["obstacles/error_cm/24"] == list_methods(imagine(), "error_cm", 24)
    assert 'src="http' not in page
    assert page == page_of(imagine(), imagine("obstacles"))["text/html"]
    assert shown["image/png"] in page


def test_a_name_is_text_wherever_it_is_shown():
    page = page_of(imagine(means=MEANS | {"</script><b>": 1.0}))["text/html"]
    assert page.count("</script>") == 1
    assert "<b>" not in page
    assert ".innerHTML" not in page


def test_what_knows_more_than_a_rival_may_is_left_out_until_ticked():
    page = html.unescape(page_of(imagine())["text/html"])
    boxes = re.findall(r'value="([^"]*)" autocomplete="off"( checked)?>', page)
    off = {name for name, checked in boxes if not checked}
    assert off == {GROUPS[name] for name in APART}
    assert {name for name, _ in boxes} == set(GROUPS.values())


def test_the_picture_shows_ticks_ratios_and_why_there_are_none():
    figure = plot_leaderboard(imagine())
    left, right = figure.axes
    labels = [label.get_text() for label in left.get_yticklabels()]
    assert labels[:3] == ["CrKr", "charts", "random forest"]
    assert not any("projected" in label or "ladder" in label for label in labels)
    ticks = [line.get_xdata() for line in left.lines if line.get_marker() == "|"]
    np.testing.assert_array_equal(ticks[0], [0.25, 0.75])
    assert {text.get_text() for text in left.texts} == {
        "failed on 2 sets",
        "no results yet",
    }
    marks = [line for line in right.lines if line.get_marker() in ("X", "o")]
    assert [(mark.get_marker(), mark.get_xdata()[0]) for mark in marks] == [
        ("X", 4.0),
        ("o", 0.25),
    ]


def test_standings_count_places_and_signs():
    table = standings_table(imagine(), imagine("obstacles"))
    assert len(table) == 2 * len(LISTED) * len(SIZES)
    assert set(map(tuple, table.to_numpy())) == {("CrKr", 2, 3, 1, 0, 1)}
    assert list(table.columns) == ["first", "place", "of", "●", "○", "✕"]


def test_places_are_those_on_the_sets_that_both_have():
    study = imagine()
    for by_method in study["cells"][0]["measures"].values():
        # On one set, an easy one, on which both others err less still.
        by_method["random forest"] = {"mean": 0.3, "per_repetition": [1.1]} | {
            "low": 0.1,
            "high": 0.9,
        }
    table = standings_table(study).xs(12, level="n")
    assert set(table["first"]) == {"CrKr"}
    assert set(table["place"]) == {2}


@pytest.fixture(scope="module")
def experiment():
    names = ["zero policy, projected", "zero policy", "mean policy"]
    return Experiment("free", n_samples=12, names=names)


def missed(experiment, name):
    goals, stops = planned_stops(experiment, name)
    np.testing.assert_allclose(np.hypot(*goals.T), experiment.workspace.goal_radius)
    return np.hypot(*(stops - goals).T)


def test_projected_policies_mean_to_stop_at_their_goals(experiment):
    assert missed(experiment, "zero policy, projected").max() < 1e-9
    assert missed(experiment, "zero policy").max() > 0.1


def test_a_mean_of_policies_stops_as_near_as_they_do(experiment):
    # the condition that a path ends at its goal is linear in the weights
    assert missed(experiment, "mean policy").max() < 0.003


def test_the_picture_tells_how_far_beside_the_goals(experiment):
    names = ["zero policy", "mean policy"]
    figure = plot_stops(experiment, names)
    for axis, name in zip(figure.axes, names, strict=True):
        mean = 100 * missed(experiment, name).mean()
        assert axis.get_xlabel() == f"{mean:.2g} cm beside the goal"
