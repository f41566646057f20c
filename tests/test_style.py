"""Things that are told apart by their looks differ: in colour, in grey, to all eyes."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from vision import VISIONS, closest, closest_in_grey, contrast, distance, lab

from msc.plots import METHOD_STYLES
from msc.plots._manifold import WAYS
from msc.plots._study import PAPER_METHODS
from msc.plots._style import (
    CHART_COLOURS,
    CHART_MARKERS,
    COLOURS,
    COUNT_STYLES,
    TRIO,
    WORLD_STYLES,
)
from msc.study._methods import COMMON

APART = 20  # CIELAB; ten times what is just noticeable: apart without comparing
APART_IN_GREY = 10  # of 100 steps from black to white
PACKAGE = Path(__file__).parents[1] / "msc"

# Sets of which some figure tells the members apart by nothing but colour.
BY_COLOUR = {
    "the paper's methods": [COLOURS[name] for name in PAPER_METHODS],
    "a slider's movements": [str(way["colour"]) for way in WAYS.values()],
    "the four charts": CHART_COLOURS[:4],
    "two of the other things": TRIO[:2],
    "counts": [look["color"] for look in COUNT_STYLES],
}


@pytest.mark.parametrize("vision", VISIONS)
@pytest.mark.parametrize("name", BY_COLOUR)
def test_colours_are_apart_to_all_eyes(name, vision):
    assert closest(BY_COLOUR[name], vision) >= APART


@pytest.mark.parametrize("name", BY_COLOUR)
def test_colours_are_apart_in_grey(name):
    assert closest_in_grey(BY_COLOUR[name]) >= APART_IN_GREY


@pytest.mark.parametrize(("one", "other"), [*combinations(METHOD_STYLES, 2)])
def test_any_two_methods_differ_by_more_than_colour_or_by_much_colour(one, other):
    looks = METHOD_STYLES[one], METHOD_STYLES[other]
    form = [(look["marker"], look["ls"]) for look in looks]
    colours = [look["color"] for look in looks]
    seen = all(closest(colours, vision) >= APART for vision in VISIONS)
    assert form[0] != form[1] or (seen and closest_in_grey(colours) >= APART_IN_GREY)
    assert colours[0] != colours[1]


def test_every_method_has_a_look():
    assert set(COMMON) < set(METHOD_STYLES)
    assert {name: look["color"] for name, look in METHOD_STYLES.items()} == COLOURS


def test_every_chart_has_a_colour_and_a_marker_of_its_own():
    assert len(set(CHART_COLOURS)) == len(set(CHART_MARKERS)) == len(CHART_COLOURS)
    assert closest(CHART_COLOURS) >= APART


@pytest.mark.parametrize("name", ["charts", "single regression", "CrKr"])
def test_a_method_looks_like_nothing_else(name):
    others = [*CHART_COLOURS, *TRIO, *(look["color"] for look in WORLD_STYLES.values())]
    for other in others:
        assert distance(COLOURS[name], other) >= APART, other


def test_lines_and_marks_stand_out_from_the_page():
    for colour in (*COLOURS.values(), *CHART_COLOURS, *TRIO):
        assert contrast(colour) >= 2, colour
    for name in PAPER_METHODS:
        assert contrast(COLOURS[name]) >= 2.8, name


def test_colours_have_their_names_in_one_module():
    for path in PACKAGE.rglob("*.py"):
        found = re.findall(r"#[0-9A-Fa-f]{6}\b", path.read_text("utf-8"))
        assert not found or path.stem == "_style", path


def test_a_method_has_its_colour_wherever_it_is_drawn():
    assert {name: way["colour"] for name, way in WAYS.items()} == {
        name: COLOURS[name] for name in WAYS
    }


# What the simulation rests on.


def test_white_and_greys_are_seen_alike_by_all():
    for vision in VISIONS:
        for grey in ("0.2", "0.6", "1.0"):
            lightness, red, yellow = lab(grey, vision)
            assert abs(red) < 0.6
            assert abs(yellow) < 0.6
            assert lightness == pytest.approx(lab(grey)[0], abs=0.3)


def test_lightness_and_distances_are_cielabs():
    np.testing.assert_allclose(lab("white"), [100, 0, 0], atol=0.02)
    np.testing.assert_allclose(lab("#FF0000"), [53.24, 80.09, 67.20], atol=0.05)
    np.testing.assert_allclose(lab("#0000FF"), [32.30, 79.19, -107.86], atol=0.05)
    assert contrast("black") == pytest.approx(21)
    assert contrast("#767676") == pytest.approx(4.54, abs=0.01)


def test_each_vision_confuses_what_it_must():
    assert distance("#C0392B", "#4E7A1E") > 60
    for vision in ("protanopia", "deuteranopia"):
        assert distance("#C0392B", "#4E7A1E", vision) < 30
    assert distance("#3C8DBC", "#2E9C8A", "tritanopia") < 10
