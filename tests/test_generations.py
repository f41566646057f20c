"""Recorded searches are the searches, and what is drawn of them is what was tried."""

import numpy as np
import pytest

from msc import Arm, Workspace, search_policy
from msc.plots import plot_generations, slide_generations
from msc.plots._search import N_SHOWN
from msc.plots._world import square_around
from msc.robot import forward_kinematics
from msc.search import SearchOptions, cost, record_search

world = Workspace.obstacles()
TASK = 120
brief = SearchOptions(max_evaluations=170)  # 19 times nine


@pytest.fixture(scope="module")
def recordings():
    return record_search(world, TASK, seed=3, n_starts=2, options=brief)


def bits(start):
    found = start.policy.tobytes(), start.cost
    return start.name, *found, start.evaluations, start.merged_into


def test_the_recorded_search_is_the_search(recordings):
    found = search_policy(world, TASK, seed=3, n_starts=2, options=brief)
    assert [bits(run.run) for run in recordings] == [bits(s) for s in found.runs]


def test_all_that_was_tried_is_kept_with_what_it_did(recordings):
    for run in recordings:
        n_generations = len(run.costs)
        assert run.policies.shape == (n_generations, 9, 6)
        assert run.evaluations[-1] == run.run.evaluations == 9 * n_generations
        assert (np.diff(run.best_costs) <= 0).all()
        assert run.best_costs[-1] == run.run.cost == run.costs.min()
        best = np.unravel_index(run.costs.argmin(), run.costs.shape)
        np.testing.assert_array_equal(run.policies[best], run.run.policy)
        with Arm(world) as arm:
            rollout = arm.execute(run.policies[2, 4], TASK)
        assert run.costs[2, 4] == cost(rollout)
        np.testing.assert_array_equal(run.joints[2, 4], rollout.joints)


def test_no_start_is_refused():
    with pytest.raises(ValueError, match="n_starts=0; wanted at least one"):
        record_search(world, TASK, seed=0, n_starts=0)


def test_the_picture_has_a_line_a_start_and_a_panel_a_generation(recordings):
    figure = plot_generations(world, TASK, recordings, shown=(1, 5, 999))
    costs, *panels = figure.axes
    titles = [panel.get_title() for panel in panels]
    assert titles[:3] == ["generation 1", "generation 5", "generation 19"]
    lines = {line.get_label(): line.get_ydata() for line in costs.lines}
    for run in recordings:
        np.testing.assert_array_equal(lines[run.run.name], run.best_costs)


def test_the_slider_goes_from_the_first_generation_to_the_last(recordings):
    run = recordings[0]
    slider = slide_generations(world, TASK, run)
    assert slider.labels[0] == "generation 1"
    assert slider.labels[-1] == f"generation {len(run.costs)}"
    assert len(slider.labels) <= N_SHOWN + 12
    assert len(slider.to_html()) < 300_000


def test_the_slider_marks_the_cheapest_of_a_generation(recordings):
    run = recordings[0]
    slider = slide_generations(world, TASK, run)
    _, costs, weights = slider.panels
    cheapest = costs.marks[-1].points[7][0]
    assert cheapest[1] == np.log10(run.costs[7].min())
    assert cheapest[0] == run.evaluations[7] / 1000
    shown = weights.marks[-1].points[7][0]
    assert set(shown) <= set(run.policies[7, run.costs[7].argmin()])


def test_the_square_holds_goals_obstacles_and_arm():
    arms = np.array([[-0.9, 0.1], [0.2, 0.3]])
    (left, right), (bottom, top) = square_around(world, arms)
    assert right - left == pytest.approx(top - bottom)
    assert left < -0.9
    assert right > world.goal_radius
    for x, y, radius in world.circles:
        assert left < x - radius < x + radius < right
        assert bottom < y - radius < y + radius < top


def test_movements_are_drawn_where_the_arm_was(recordings):
    run = recordings[0]
    slider = slide_generations(world, TASK, run)
    best = run.costs[3].argmin()
    arm = forward_kinematics(run.joints[3, best, -1], world.link_lengths)
    shown = [mark.points[3] for mark in slider.panels[0].marks if mark.varies == "step"]
    np.testing.assert_array_equal(shown[0], arm)
    assert len(shown) == 1 + 9
