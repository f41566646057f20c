"""The goal that opens the book: what is drawn and told is where the arm ended."""

import base64
import json
import re

import numpy as np
import pytest

from msc import Arm
from msc.plots import drag_goal
from msc.plots._reach_page import aim, find_apart
from msc.study import Experiment

NAMES = "charts", "single regression", "linear interpolation"
GOALS = 10  # every 12th test task


@pytest.fixture(scope="module")
def experiment():
    return Experiment("obstacles", n_samples=24, names=NAMES)


@pytest.fixture(scope="module")
def reach(experiment):
    return drag_goal(experiment, shown=NAMES[:2], every=12)


@pytest.fixture(scope="module")
def page(reach):
    return reach.to_html()


@pytest.fixture(scope="module")
def data(page):
    found = re.search(r"previousElementSibling,(.*)\);</script>$", page, re.DOTALL)
    return json.loads(found[1])


def ends_of(data):
    """Place the arm's end (cm) as the script does: method, goal, (x, y)."""
    raw = np.frombuffer(base64.b64decode(data["joints"]), dtype="<i2")
    shape = len(data["names"]), len(data["goals"]), -1, 3
    heading = np.cumsum(data["tick"] * raw.reshape(shape)[:, :, -1], axis=-1)
    return np.sum(data["links"] * np.exp(1j * heading), axis=-1)


def test_the_page_is_told_where_each_arm_ends(data, experiment):
    tasks = experiment.test_tasks[::12]
    angles = experiment.test_table["task_deg"][::12].tolist()
    assert data["degrees"] == angles
    assert data["names"] == ["searched", *NAMES[::-1]]
    ends = ends_of(data)
    with Arm(experiment.workspace) as arm:
        for name, found in zip(data["names"][1:], ends[1:], strict=True):
            rollouts = arm.execute_many(experiment.predict(name, tasks), angles)
            wanted = [100 * complex(*one.path[-1]) for one in rollouts]
            np.testing.assert_allclose(found, wanted, atol=0.03)  # cm


def test_what_is_left_is_the_distance_from_end_to_goal(data):
    goals = np.array(data["goals"]) @ [1, 1j]
    np.testing.assert_allclose(abs(ends_of(data) - goals), data["left"], atol=0.05)


def test_it_begins_where_a_quarter_of_the_goals_has_the_ends_farther_apart(data):
    shown = [data["names"].index(name) for name in NAMES[:2]]
    one, other = ends_of(data)[shown]
    apart = abs(one - other)
    assert np.sum(apart > apart[data["first"]]) == round(GOALS / 4 + 0.5)


def test_of_many_methods_the_two_farthest_apart_count():
    ends = np.zeros((3, 5, 2))
    ends[:, 2] = [[0, 0], [3, 4], [0, 1]]
    ends[:, 4] = [[0, 0], [0, 0], [9, 0]]
    assert find_apart(ends) == 2


def test_the_picture_without_a_script_shows_what_is_on(page, reach):
    ways = re.findall(r'<g class="msc-way"([^>]*)>', page)
    assert len(ways) == 2 * 4  # from above, and on the board
    assert sum("display" not in way for way in ways) == 2 * 2
    assert page.count(" checked") == 2
    for name in NAMES:
        assert f"<b>{reach.error_cm[name][reach.first]:.2f} cm</b>" in page
    assert "slider" not in page.partition("<script>")[0], "nothing is one yet"


def test_lines_and_marks_tell_methods_apart_in_grey(page):
    looks = re.findall(
        r'<label.*?dasharray="([^"]*)".*? d="([^"]*)"/></g></svg>', page, re.DOTALL
    )
    assert len(looks) == len(set(looks)) == 4


def test_the_page_needs_no_other_file(page):
    assert not re.search(r"https?:|src=|<link|<use", page)


def test_a_kernel_has_a_picture_too(reach):
    shown = reach._repr_mimebundle_()
    assert base64.b64decode(shown["image/png"]).startswith(b"\x89PNG")
    assert "charts" in shown["text/plain"]


def test_a_method_that_is_not_there_is_refused(experiment):
    with pytest.raises(ValueError, match=r"shown=\['chart'\]: not trained; wanted"):
        drag_goal(experiment, shown=["chart"])


@pytest.mark.parametrize(
    ("distance", "radius"),
    [(0.0, 0), (0.001, 0), (0.1, 10), (1, 20), (10, 30), (80, 35)],
)
def test_rings_of_the_board_are_powers_of_ten(distance, radius):
    x, y = aim(0.6 * distance, -0.8 * distance)
    assert np.hypot(x, y) == pytest.approx(radius)
    if radius:
        assert (x, y) == pytest.approx((0.6 * radius, -0.8 * radius))
