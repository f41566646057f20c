"""The layouts to choose from: what is drawn of each is what was found in it."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from msc import Workspace
from msc.plots import drag_goal
from msc.robot import Circle, read_world

FOLDER = Path(__file__).parents[1] / "data" / "worlds"
KEPT = FOLDER.parent / "results" / "worlds"
NAMES = ["layout01", "layout07", "layout14"]


@pytest.fixture(scope="module")
def layouts():
    return drag_goal(NAMES)


@pytest.fixture(scope="module")
def page(layouts):
    return layouts.to_html()


@pytest.fixture(scope="module")
def worlds(page):
    start = page.index('[{"name":')
    return json.JSONDecoder().raw_decode(page[start:])[0]


def found(stem):
    return json.loads((KEPT / f"{stem}.json").read_text("utf-8"))


def test_each_layout_is_a_button_and_a_place_to_link_to(page):
    strip = page.partition("</fieldset>")[0]
    assert re.findall(r'<label id="drag-(\w+)"', strip) == NAMES
    assert strip.count('type="radio"') == len(NAMES)
    assert strip.count(" checked") == 1
    assert f'aria-label="{NAMES[0]}" checked' in strip


def test_a_small_world_has_its_obstacles_where_they_are(page):
    strip = page.partition("</fieldset>")[0]
    labels = strip.split("<label")[1:]
    for name, label in zip(NAMES, labels, strict=True):
        drawn = re.findall(r'<circle cx="(.*?)" cy="(.*?)" r="(.*?)"/>', label)
        numbers = np.array(drawn, float) / [100, -100, 100]
        own = [Circle(*one) for one in numbers.tolist()]
        wanted = read_world(FOLDER / f"{name}.toml").circles
        np.testing.assert_allclose(own, wanted, atol=1e-6)


def test_strokes_are_the_jumps_that_bisection_kept(worlds):
    for name, world in zip(NAMES, worlds, strict=True):
        kept = [one for one in found(f"jumps_{name}")["jumps"] if one["is_jump"]]
        strokes = re.findall(r'msc-jump" d="M(\S+) (\S+)L', world["still"])
        assert len(strokes) == len(kept)
        for (x, y), one in zip(strokes, kept, strict=True):
            wanted = 86 * Workspace.free().target(np.mean(one["located_deg"]))
            assert (float(x), -float(y)) == pytest.approx(wanted, abs=0.06)


def test_arcs_are_numbered_by_the_chart_that_goals_are_given_to(worlds):
    for name, world in zip(NAMES, worlds, strict=True):
        charts = 1 + np.array(found(f"moves_{name}")["chart"])
        assert world["charts"] == charts.tolist()
        runs = charts[np.r_[True, np.diff(charts) != 0]]
        numbers = re.findall(r">(\d)</text>", world["still"])
        assert [*map(int, numbers)] == runs.tolist()


def test_all_worlds_are_told_in_one_frame_and_with_the_same_methods(layouts, worlds):
    assert len({one.box for one in layouts.reaches.values()}) == 1
    assert len({json.dumps([one["names"], one["degrees"]]) for one in worlds}) == 1
    left, top, width = next(iter(layouts.reaches.values())).frame
    for one in layouts.reaches.values():
        for places in map(one.places, one.joints.values()):
            x, y = places.reshape(-1, 2).T
            assert left <= x.min() <= x.max() <= left + width
            assert top <= -y.max() <= -y.min() <= top + width


def test_what_is_told_of_a_movement_is_what_was_found(worlds):
    for name, world in zip(NAMES, worlds, strict=True):
        kept = found(f"moves_{name}")["methods"]
        for method, *told in zip(
            world["names"], world["left"], world["touched"], strict=True
        ):
            errors, touched = kept[method]["error_cm"], kept[method]["touched"]
            assert told == [np.round(errors, 2).tolist(), touched]
        step, charts = world["first"], kept["charts"]
        words = f"charts {charts['error_cm'][step]:.2f} cm"
        assert words + ", touched" * charts["touched"][step] in world["words"]


def test_beside_a_jump_is_within_what_training_tasks_lie_apart(layouts):
    table = layouts.error_cm
    kept = found("jumps_layout07")["jumps"]  # one, at 4.88°
    assert [one["is_jump"] for one in kept] == [True, False]
    own = table.xs("layout07").xs("beside a jump", level="place")
    assert own.index.tolist() == [0.5, 6.5, 12.5, 18.5, 354.5]
    assert len(table) == 60 * len(NAMES)
    errors = found("moves_layout07")["methods"]["CrKr"]["error_cm"]
    assert table.xs("layout07")["CrKr"].tolist() == errors


def test_it_needs_no_other_file_and_little_room(page):
    assert not re.search(r"https?:|src=|<link|<use", page)
    assert len(page) / len(NAMES) * 24 < 1_500_000


def test_a_kernel_has_a_picture_too(layouts):
    shown = layouts._repr_mimebundle_()
    assert base64.b64decode(shown["image/png"]).startswith(b"\x89PNG")
    assert shown["text/plain"].startswith("3 worlds, first The arm from above")


def test_what_cannot_be_shown_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"shown=\['chart'\]: not trained; wanted"):
        drag_goal(["layout01"], shown=["chart"])
    with pytest.raises(ValueError, match=r"layout01: .*msc worlds moves layout01"):
        drag_goal(["layout01"], results=tmp_path)
