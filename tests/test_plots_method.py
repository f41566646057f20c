"""The pictures of the method's chapters show what they say."""

import json
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msc import DMP, Arm, ParameterizedSkill, Workspace
from msc.plots import (
    plot_composition,
    plot_followed,
    plot_rivals,
    plot_weights,
    plot_workspaces,
    slide_path,
    slide_predictions,
    slide_weight,
)
from msc.plots._arm import poses_at
from msc.plots._style import CHART_COLOURS, COLOURS, GOAL, TRIO
from msc.plots._world import mark_world
from msc.robot import forward_kinematics
from msc.search import cost

TASK = 60.0
CHANGES = [-20.0, 0.0, 20.0]
RESPONSES = slide_path(Workspace.free(), np.zeros(6), TASK, reach=60.0)._data()


class Halves:
    """A clusterer that knows the charts: the first half, the second half."""

    def fit_predict(self, X):
        return (np.arange(len(X)) >= len(X) // 2).astype(int)

    def get_params(self, deep=True):
        return {}

    def set_params(self, **_):
        return self


@pytest.fixture(scope="module")
def arm():
    with Arm(Workspace.free()) as arm:
        yield arm


@pytest.fixture(scope="module")
def trained():
    """Return tasks, policies with a step half-way, and a skill of two charts."""
    tasks = np.deg2rad(np.arange(0.0, 360.0, 30.0))[:, None]
    policies = np.c_[tasks, np.sin(tasks), tasks, tasks, tasks, tasks]
    policies[:, 1] += 9 * (tasks[:, 0] > 3)
    return tasks, policies, ParameterizedSkill(Halves()).fit(tasks, policies)


def data_of(slider):
    """Read the numbers that the page's script is given."""
    html = slider.to_html(b"")
    found = re.search(r"previousElementSibling,(.*)\);</script>$", html, re.DOTALL)
    return json.loads(found[1])


def drawn(axis, colour):
    return [line for line in axis.lines if line.get_color() == colour]


@pytest.mark.parametrize("place", [(0.3, 0.4), (-0.9, 0.1), (0.0, -0.25)])
def test_every_pose_reaches_the_place_and_no_two_are_alike(place):
    world = Workspace.free()
    joints = poses_at(world, place, 12)
    ends = forward_kinematics(joints, world.link_lengths)[:, -1]
    np.testing.assert_allclose(ends, np.tile(place, (len(joints), 1)), atol=1e-12)
    poses = (
        forward_kinematics(joints, world.link_lengths).round(6).reshape(len(joints), -1)
    )
    assert len(np.unique(poses, axis=0)) == len(joints) >= 2


def test_out_of_reach_there_is_no_pose():
    assert poses_at(Workspace.free(), (1.01, 0.0), 12).shape == (0, 3)


def test_a_world_is_the_same_in_figures_and_in_sliders():
    world = Workspace.obstacles()
    above, _ = plot_workspaces(world).axes
    there = {(0.0, 0.0, world.goal_radius), *map(tuple, world.circles)}
    assert {(*disc.center, disc.radius) for disc in above.patches} == there
    assert {(*mark.points[0], mark.radius) for mark in mark_world(world)} == there


def test_each_weight_bends_the_path_to_either_side():
    world, dmp = Workspace.free(), DMP()
    top, low, plane = plot_weights(world, TASK, 10.0).axes
    shares = np.array([line.get_ydata() for line in top.lines])
    np.testing.assert_allclose(shares.sum(axis=0), 1)
    ends = forward_kinematics(world.home, world.link_lengths)[-1], world.target(TASK)
    times = np.linspace(0, 1, 101)
    for k, colour in enumerate(TRIO):
        weights = 10 * np.eye(6)[k]
        pair = [line.get_xydata() for line in drawn(plane, colour)]
        np.testing.assert_allclose(pair[0], dmp.path(weights, *ends, times))
        np.testing.assert_allclose(pair[1], dmp.path(-weights, *ends, times))
        [added] = [line.get_ydata() for line in drawn(low, colour)]
        straight = dmp.path(np.zeros(6), *ends, times)
        way = (pair[0] - straight)[:, 0] / (ends[1] - ends[0])[0]
        np.testing.assert_allclose(100 * way / 10, added, atol=1e-9)


def test_planned_and_executed_ways_lie_beneath_each_other(arm):
    rollout = arm.execute(np.zeros(6), TASK)
    plan = rollout.path + 0.01
    figure = plot_followed(arm.workspace, TASK, {"one": plan}, {"one": rollout})
    plane, left = figure.axes
    np.testing.assert_array_equal(drawn(plane, "0.8")[0].get_xydata(), plan)
    np.testing.assert_array_equal(drawn(plane, TRIO[0])[0].get_xydata(), rollout.path)
    assert left.lines[0].get_ydata()[-1] == pytest.approx(100 * rollout.error)


def test_the_slider_changes_one_weight_alone(arm):
    base = np.arange(6.0)
    slider = slide_weight(arm, base, TASK, 4, CHANGES)
    for change, caption in zip(CHANGES, slider.captions, strict=True):
        rollout = arm.execute(base + change * np.eye(6)[4], TASK)
        assert caption == (
            f"w₂ʸ = {4 + change:.1f} ({change:+.3g}): ends {100 * rollout.error:.1f} "
            f"cm from the goal, cost {cost(rollout):.3f}."
        )
    assert slider.name == "change of w₂ʸ"
    data = data_of(slider)
    plane, force, costs = data["panels"]
    assert len(data["labels"]) == 3
    film = next(mark for mark in plane["marks"] if mark["varies"] == "time")
    assert len(film["points"][0]) == data["n_times"] == 23
    assert force["y_label"] == "push f of y"
    assert costs["x_ticks"] == [-20, 0, 20]


@pytest.mark.parametrize("weight", [-1, 6])
def test_a_weight_that_is_not_there_is_refused(arm, weight):
    with pytest.raises(ValueError, match=rf"weight={weight}; wanted one from 0 to 5"):
        slide_weight(arm, np.zeros(6), TASK, weight, CHANGES)


@given(
    st.lists(st.floats(-60, 60), min_size=6, max_size=6), st.floats(0, 360), st.data()
)
def test_responses_in_hand_add_up_to_the_path(weights, task, data):
    world, told = Workspace.free(), RESPONSES
    axis = data.draw(st.sampled_from([0, 1]))
    start = forward_kinematics(world.home, world.link_lengths)[-1]
    goal = world.target(task)
    times = told["step"] * np.arange(len(told["pull"]))
    path = world.dmp.path(weights, start, goal, times)[:, axis]
    own = np.array(weights).reshape(2, 3)[axis]
    share = told["pull"] + own @ np.array(told["pushes"])
    added = start[axis] + (goal - start)[axis] * share
    np.testing.assert_allclose(added, path, atol=2e-5)


def test_a_path_in_hand_needs_all_weights_and_no_network():
    with pytest.raises(ValueError, match=r"policy has shape \(5,\); wanted \(6,\)"):
        slide_path(Workspace.free(), np.zeros(5), 60.0, 60.0).to_html()
    page = slide_path(Workspace.free(), np.arange(6.0), 60.0, 60.0).to_html()
    assert page.count('name="weight"') == 6
    assert "http" not in page


def test_the_composition_marks_the_task_in_every_panel(arm, trained):
    tasks, policies, skill = trained
    rollout = arm.execute(np.zeros(6), 100.0)
    figure = plot_composition(
        skill,
        tasks,
        policies,
        world=arm.workspace,
        task_deg=100.0,
        rollout=rollout,
        weight=1,
    )
    task, gate, curve, bars, movement = figure.axes
    goal = arm.workspace.target(100.0)
    predicted = skill.predict(np.deg2rad([[100.0]]))[0]
    for axis, place in ((task, goal), (curve, (100, predicted[1])), (movement, goal)):
        star = next(line for line in axis.lines if line.get_marker() == "*")
        np.testing.assert_allclose(star.get_xydata()[0], place)
    assert gate.get_title(loc="left") == "2  the gate: chart 1"
    assert gate.lines[0].get_xdata() == [100, 100]
    heights = [bar.get_height() for bar in bars.patches]
    np.testing.assert_allclose(heights, predicted)
    title = movement.get_title(loc="left")
    assert title == f"5  it ends {100 * rollout.error:.1f} cm off"


def test_rivals_stand_beside_one_another(trained):
    tasks, policies, skill = trained
    single = ParameterizedSkill(None).fit(tasks, policies)
    learners = {"charts": skill, "single regression": single}
    chosen = np.arange(len(tasks))
    figure = plot_rivals(learners, tasks, policies, chosen=chosen, weight=1)
    left, right = figure.axes
    assert [axis.get_title() for axis in (left, right)] == list(learners)
    for chart in (0, 1):  # a curve, and the tasks trained on
        curve, dots = drawn(left, CHART_COLOURS[chart])
        here = skill.charts_ == chart
        where = np.c_[np.rad2deg(tasks[here, 0]), policies[here, 1]]
        np.testing.assert_array_equal(dots.get_xydata(), where)
        assert len(curve.get_xdata()) > 300
    assert len(drawn(right, COLOURS["single regression"])) == 2


def test_dragging_a_task_shows_its_chart_and_what_is_left(arm, trained):
    tasks, policies, skill = trained
    single = ParameterizedSkill(None).fit(tasks, policies)
    learners = {"charts": skill, "single regression": single}
    slider = slide_predictions(
        learners,
        tasks,
        policies,
        arm=arm,
        degrees=[100.0, 250.0],
        weight=1,
        first_deg=260.0,
    )
    assert slider.first == 1
    for angle, chart, caption in zip((100, 250), (1, 2), slider.captions, strict=True):
        left = {
            name: 100 * arm.execute(one.predict([[np.deg2rad(angle)]])[0], angle).error
            for name, one in learners.items()
        }
        assert caption == f"Task {angle}°: chart {chart}. Ends from the goal: " + (
            ", ".join(f"{name} {cm:.2f} cm" for name, cm in left.items())
        )
    assert slider.legend == {name: COLOURS[name] for name in learners}
    plane, weight, missed = data_of(slider)["panels"]
    assert any(mark["colour"] == GOAL for mark in plane["marks"])
    for panel in (weight, missed):
        dots = [m for m in panel["marks"] if m["varies"] == "step"][1:]
        assert {m["colour"] for m in dots} == set(slider.legend.values())
