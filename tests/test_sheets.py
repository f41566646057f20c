"""The sections of worlds say what is known, and what is not yet."""

import base64
import io
import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from msc import Workspace
from msc.data import Dataset, load_dataset
from msc.plots import WorldSheets, plot_contact_sheet, plot_sheet, world_address
from msc.plots._sheets import (
    APART as WIDTH,
)
from msc.plots._sheets import (
    N_SHOWN,
    Found,
    describe_picture,
    look_up,
    tell_pieces,
)
from msc.plots._style import CHART_COLOURS, TRIO
from msc.robot import Arm, TaskRange
from msc.worlds import ANSWERS, list_worlds
from press._notebook import code_cells, read_notebook, source

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "data" / "worlds"
WORLD = "layout07"
MEANS = {"CrKr": 0.5, "charts": 2.0, "<i>": 3.0, "mean policy": 8.0}
APART = {"ladder: SMCE, true gate": 0.1, "8 charts": 0.2, "CrKr, projected": 0.0}


def leap(low, high, is_jump=True):
    return {
        "between_deg": [low, high],
        "located_deg": [low, (low + high) / 2],
        "step_sizes": [9.0],
        "is_jump": is_jump,
    }


JUMPS = {"jumps": [leap(40.0, 45.0), leap(80.0, 85.0, False), leap(355.0, 360.0)]}


def study(means=MEANS | APART, design="even"):
    of = {
        name: {"mean": mean, "per_repetition": [mean / 2, 3 * mean / 2]}
        | {"n_tasks": 60, "waves": [0.0] * 4}
        for name, mean in means.items()
    }
    cell = {"design": design, "n_samples": 24, "measures": {"error_cm": of}}
    reasons = {f"neural network/{design}/24/0": "why", f"CrKr/{design}/24/2": "why"}
    return {"cells": [cell], "failed": reasons | {f"change points/{design}/12/0": ""}}


def save(folder, **found):
    for name, one in found.items():
        (folder / f"{name}.json").write_text(json.dumps(one), "utf-8")
    return folder


class Page(HTMLParser):
    """Elements in order, with what they have and the text up to the next."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append([tag, dict(attrs), ""])

    def handle_data(self, data):
        self.found[-1][2] += data

    def all(self, tag):
        return [(attrs, text) for name, attrs, text in self.found if name == tag]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    answers = {str(k): {"answer": ANSWERS[k % 3]} for k in range(4)}
    verdicts = {
        "worlds": {WORLD: {"answers": answers | {"x": {"answer": "not asked"}}}}
    }
    found = {f"jumps_{WORLD}": JUMPS, WORLD: study(), "verdicts": verdicts}
    found |= {f"moves_{WORLD}": {"task_deg": [0.5]}}
    results = save(tmp_path_factory.mktemp("results"), **found)
    sheets = WorldSheets([WORLD, "arm6"], FOLDER, results)
    return repr(sheets), Page(sheets._repr_html_())


# What is in a section


def test_a_line_says_what_a_world_is_and_what_was_found(page):
    told, _ = page
    first, second = told.splitlines()
    assert first == (
        "layout07: 4 obstacles; 1 jump, and one at the cut; "
        "of 4 questions 2 hold, 1 fail, 1 cannot be told"
    )
    assert second.startswith("arm6: no obstacles, links of ")
    assert second.endswith("jumps not settled yet")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("layout08", "2 obstacles; "),
        ("priced01", "3 obstacles, contact costs 0.01 a newton-second"),
        ("mujoco01", "3 obstacles, in MuJoCo"),
        ("annulus1", "3 obstacles, goals 0.30 to 0.45 m from the base"),
        ("height1", "the first obstacle moved by −0.08 to 0.08 m"),
        ("turn1", "home turned by −10 to 10°"),
    ],
)
def test_every_family_has_its_words(name, words, tmp_path):
    assert words in repr(WorldSheets([name], FOLDER, tmp_path))


def test_of_many_steps_a_sample_tells_how_many_are_jumps(tmp_path):
    tried = [{"is_jump": True}, {"is_jump": True}, {"is_jump": False}]
    found = {"edges": 900, "large": 40, "pieces": [1], "bisected": tried}
    sheets = WorldSheets(["annulus1"], FOLDER, save(tmp_path, jumps_annulus1=found))
    assert "40 of 900 steps are large, 2 of 3 bisected ones jumps" in repr(sheets)


def test_each_world_has_a_section_of_its_name_and_a_picture_with_words(page):
    _, html = page
    assert [attrs["id"] for attrs, _ in html.all("details")] == [WORLD, "arm6"]
    images = [attrs for attrs, _ in html.all("img")]
    assert len(images) == 2
    for name, image in zip((WORLD, "arm6"), images, strict=True):
        assert image["alt"].startswith(f"{name} from above")
        kind, _, data = image["src"].partition(",")
        assert kind == "data:image/png;base64"
        with Image.open(io.BytesIO(base64.b64decode(data))) as picture:
            assert picture.width == pytest.approx(7.4 * 110, abs=1)
    assert f"data/worlds/{WORLD}_test.csv" in [text for _, text in html.all("code")]


def test_a_section_leads_to_where_its_goal_is_dragged_if_it_is(page):
    _, html = page
    assert [attrs["href"] for attrs, _ in html.all("a")] == [f"#drag-{WORLD}"]


def test_methods_are_sorted_by_what_they_miss_their_goals_by(page):
    _, html = page
    assert [text for _, text in html.all("th")] == [
        *("method", "cm [95 % interval]", "charts over it"),
        *MEANS,  # and none that knows more than a robot
    ]
    numbers = [text.strip() for _, text in html.all("td")]
    assert numbers[::2] == ["0.5", "2", "3", "8"]
    assert numbers[1::2] == ["✕ 4 ×", "", "● 0.67 ×", "● 0.25 ×"]
    (row,) = [k for k, one in enumerate(html.found) if one[1].get("class")][1:]
    assert html.found[row + 1][2] == "charts"
    assert ("p", {}, "No result: neural network") in map(tuple, html.found)


def test_a_ratio_is_of_all_sets_and_its_interval_beside_it(page):
    _, html = page
    told = [text for _, text in html.all("small")]
    assert len(told) == 2 * len(MEANS) - 1
    for one in told:
        low, high = json.loads(one)
        assert 0 < low <= high


# What is not there


def test_what_is_missing_says_what_makes_it(page, tmp_path):
    _, html = page
    commands = [text for _, text in html.all("code") if text.startswith("msc")]
    assert [one for one in commands if "arm6" in one][-2:] == [
        "msc worlds jumps arm6",
        "msc worlds study arm6",
    ]
    assert not [one for one in commands if WORLD in one]
    alone = Page(WorldSheets([WORLD], FOLDER, tmp_path)._repr_html_())
    assert not alone.all("table")


def test_a_world_that_was_not_searched_is_but_drawn(tmp_path):
    text = (FOLDER / f"{WORLD}.toml").read_text("utf-8")
    (tmp_path / f"{WORLD}.toml").write_text(text, "utf-8")
    html = Page(WorldSheets([WORLD], tmp_path, tmp_path)._repr_html_())
    commands = [f"msc worlds {step} {WORLD}" for step in ("search", "jumps", "study")]
    files = [f"data/worlds/{WORLD}.toml"]
    assert [text for _, text in html.all("code")] == commands + files
    assert html.all("img")[0][0]["alt"].endswith("with the arm at home.")


def test_a_name_is_text_wherever_it_is_shown(tmp_path):
    name = '<b>"&'
    (tmp_path / "odd.toml").write_text(f"name = '{name}'\n", "utf-8")
    text = WorldSheets(["odd"], tmp_path, tmp_path)._repr_html_()
    html = Page(text)
    assert [attrs["id"] for attrs, _ in html.all("details")] == [name]
    assert html.all("b") == [({}, f"{name}: no obstacles; jumps not settled yet")]
    assert html.all("img")[0][0]["alt"].startswith(name)
    assert not html.all("script")


def test_no_such_world_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"layout99\.toml: cannot be read"):
        repr(WorldSheets(["layout99"], tmp_path, tmp_path))


def test_results_of_another_table_are_refused(tmp_path):
    origin = {"provenance": {"data": {f"worlds/{WORLD}.csv": "sha256:0"}}}
    results = save(tmp_path, **{f"jumps_{WORLD}": JUMPS | origin})
    with pytest.raises(ValueError, match="rests on another"):
        look_up(WORLD, FOLDER, results)


# Where a section is


def test_every_world_but_variants_has_its_section_in_a_chapter():
    shown = {}
    for path in (ROOT / "book").glob("worlds_*.ipynb"):
        told = [source(cell) for cell in code_cells(read_notebook(path))]
        if "WorldSheets(names)" in told:
            made: dict = {}
            exec(told[0].rpartition("\n")[0], made)  # all but the figure
            shown |= {name: f"{path.stem}.html#{name}" for name in made["names"]}
    worlds = [name for name in list_worlds(FOLDER) if "-" not in name]
    assert shown == {name: world_address(name) for name in worlds}


def test_a_variant_has_no_section():
    with pytest.raises(ValueError, match=r"'free-loose' has no section; wanted of lay"):
        world_address("free-loose")


# Pictures


@given(st.sets(st.integers(0, 71)))
def test_neighbours_are_of_one_piece_unless_a_jump_is_between(places):
    degrees = np.arange(0.0, 360.0, 5.0)
    table = pd.DataFrame({"task_deg": degrees})
    train = Dataset(np.deg2rad(degrees)[:, None], np.zeros((72, 6)), table)
    jumps = {"jumps": [leap(5.0 * k, 5.0 * k + 5) for k in sorted(places)]}
    jumps["jumps"] += [leap(0.0, 5.0, False)]
    pieces = tell_pieces(Workspace.free(), train, jumps)
    assert len(np.unique(pieces)) == max(1, len(places))
    apart = np.flatnonzero(pieces != np.roll(pieces, -1))
    assert set(apart) == (places if len(places) > 1 else set())
    assert (np.diff(np.bincount(pieces)) <= 0).all()  # the largest comes first


def drawn(axis, colour):
    return [line for line in axis.lines if line.get_color() == colour]


def marks(axis):
    """Return the marks in colours of charts."""
    own = [np.array(one.get_xydata()) for c in CHART_COLOURS for one in drawn(axis, c)]
    return np.concatenate(own) if own else np.empty((0, 2))


def test_the_picture_shows_all_policies_jumps_and_goals():
    world, train = look_up(WORLD, FOLDER)[:2]
    above, *weights, strip = plot_sheet(world, train, JUMPS).axes
    assert len(weights) == 6
    for number, axis in enumerate(weights):
        wanted = np.c_[train.task_deg, train.policies[:, number]]
        assert sorted(marks(axis).tolist()) == wanted.tolist()
        lines = [line.get_xdata()[0] for line in drawn(axis, "0.75")]
        assert lines == [41.25, 356.25]
    goals = world.target(train.task_deg)
    assert sorted(marks(above).tolist()) == sorted(goals.tolist())
    strokes = [one.get_xydata().mean(axis=0) for one in drawn(above, "black")]
    np.testing.assert_allclose(strokes, world.target([41.25, 356.25]))
    ways = drawn(strip, TRIO[0]) + drawn(strip, TRIO[1])
    assert len(ways) == N_SHOWN


def test_movements_end_at_their_goals():
    world, train = look_up(WORLD, FOLDER)[:2]
    *_, strip = plot_sheet(world, train).axes
    ways = [one for colour in TRIO[:2] for one in drawn(strip, colour)]
    ends = sorted(one.get_xydata()[-1].tolist() for one in ways)
    goals = sorted(
        one.get_xydata()[0].tolist() for one in strip.lines if one.get_mec() == "red"
    )
    np.testing.assert_allclose(ends, goals, atol=0.02)


def test_each_movement_is_its_own_task_s():
    world, train = look_up(WORLD, FOLDER)[:2]
    *_, strip = plot_sheet(world, train).axes
    with Arm(world) as arm:
        path = arm.execute(train.policies[9], 45.0).path
    ways = [one.get_xydata() for c in TRIO[:2] for one in drawn(strip, c)]
    assert any(np.allclose(way, np.add(path, (WIDTH, 0))) for way in ways)


def test_an_obstacle_that_moves_is_where_it_is_in_the_task():
    height, (one, train) = TaskRange("height_m", -0.08, 0.08), annulus()
    circles = Workspace.obstacles().circles
    world = replace(one, circles=circles, further=(*one.further, height))
    heights = np.linspace(-0.08, 0.08, len(train.tasks))
    tasks = np.c_[train.tasks, heights]
    table = train.table.assign(height_m=heights)
    *_, strip = plot_sheet(world, Dataset(tasks, train.policies, table)).axes
    discs = [one.center[1] for one in strip.patches if one.get_fill()]
    shown = heights[:: len(heights) // N_SHOWN]
    np.testing.assert_allclose(discs[:: len(circles)], circles[0].y + shown)


def annulus():
    """Return a world of two numbers and tasks whose policies leap half-way round."""
    radii = TaskRange("radius_m", 0.3, 0.45)
    world = Workspace(name="annulus1", further=(radii,))
    degrees = np.repeat(np.arange(0.0, 360.0, 15.0), 3)
    metres = np.tile([0.3, 0.37, 0.45], 24)
    policies = np.outer(np.sin(np.deg2rad(degrees)), np.ones(6)) + metres[:, None]
    policies[degrees > 170] += 9
    table = pd.DataFrame({"task_deg": degrees, "radius_m": metres})
    return world, Dataset(np.c_[np.deg2rad(degrees), metres], policies, table)


def test_goals_of_two_numbers_are_shown_by_pieces_and_by_charts():
    world, train = annulus()
    found = {"edges": 9, "large": 6, "bisected": []}
    pieces, charts, _ = plot_sheet(world, train, found).axes
    goals = world.target(train.table.to_numpy())
    for axis in (pieces, charts):
        assert sorted(marks(axis).tolist()) == sorted(goals.tolist())
        radii = [one.radius for one in axis.patches if not one.get_fill()]
        assert radii == [0.3, 0.45]
    by_piece = [len(drawn(pieces, colour)) for colour in CHART_COLOURS]
    assert by_piece == [1, 1, 0, 0, 0, 0]
    halves = drawn(pieces, CHART_COLOURS[1])[0].get_xydata()
    assert len(halves) == (train.table["task_deg"] < 170).sum()


def test_the_words_for_two_numbers_tell_of_no_weights():
    of_two, of_one = Found(*annulus()), Found(Workspace.free(), load_dataset("free"))
    assert "weights" not in describe_picture(of_two)
    assert "weights" in describe_picture(of_one)


def test_all_worlds_are_on_one_sheet():
    names = ["layout01", "arm6", "annulus1", "turn1", "layout02", "layout03", WORLD]
    (axis,) = plot_contact_sheet(names, FOLDER).axes
    assert [text.get_text() for text in axis.texts] == names
    places = [text.get_position() for text in axis.texts]
    assert len({x for x, _ in places}) == 6
    assert len({y for _, y in places}) == 2
    (low, high), (left, right) = axis.get_ylim(), axis.get_xlim()
    width, height = axis.figure.get_size_inches()
    assert (high - low) / (right - left) == pytest.approx(height / width)
