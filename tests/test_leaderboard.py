"""The table of all methods, and the picture of where predictions mean to stop."""

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
)
from msc.plots._leaderboard import _GROUPS, LISTED, SIZES
from msc.study import METHODS, Experiment

MEANS = {"charts": 2.0, "CrKr": 0.5, "random forest": 8.0, "mean policy": None}


def imagine(world="free"):
    """Return a study of four methods, one of which failed."""

    def summary(mean):
        names = "low", "mean", "high"
        scaled = (None,) * 3 if mean is None else (mean / 2, mean, 2 * mean)
        return dict(zip(names, scaled, strict=True))

    ratios = [
        {"measure": key, "method": "charts", "baseline": name}
        | {"ratio": 2 / mean, "low": low / mean, "high": 3 / mean}
        for key in LISTED
        for name, mean, low in (("CrKr", 0.5, 1.0), ("random forest", 8.0, 1.0))
    ]
    measures = {key: {name: summary(m) for name, m in MEANS.items()} for key in LISTED}
    cells = [
        {"design": "even", "n_samples": n, "measures": measures, "ratios": ratios}
        for n in SIZES
    ]
    return {"workspace": world, "cells": cells}


def test_the_least_is_on_top_and_what_failed_at_the_bottom():
    rows = list_methods(imagine(), "error_cm", 24)
    assert [row["name"] for row in rows] == [
        "CrKr", "charts", "random forest", "mean policy",
    ]  # fmt: skip
    assert [row["told"] for row in rows] == [
        "0.5 [0.25, 1]", "2 [1, 4]", "8 [4, 16]", "failed",
    ]  # fmt: skip
    assert [row["against"] for row in rows] == ["✕ 4 ×", "", "● 0.25 ×", ""]
    assert {row["group"] for row in rows} <= set(_GROUPS.values())


def test_every_group_of_methods_has_a_name():
    listed = {method.group for method in METHODS.values()} - {"number of charts"}
    assert listed == set(_GROUPS)


def test_the_page_has_all_numbers_and_needs_no_other_file():
    figure = plt.figure()
    board = Leaderboard([imagine(), imagine("obstacles")], figure)
    shown = board._repr_mimebundle_()
    page = shown["text/html"]
    data = json.loads(
        re.search(r"currentScript\.previousElementSibling,(.*)\);", page)[1]
    )
    assert len(data) == 2 * len(LISTED) * len(SIZES)
    assert data["obstacles/error_cm/24"] == list_methods(imagine(), "error_cm", 24)
    assert 'src="http' not in page
    assert page == board._repr_mimebundle_()["text/html"]
    assert page.count("</script>") == 1
    assert shown["image/png"] in page


def test_the_picture_leaves_out_what_failed():
    figure = plot_leaderboard(imagine())
    labels = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert labels == ["CrKr", "charts", "random forest"]


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
