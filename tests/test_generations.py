"""Recorded searches are the searches, and what is drawn of them is what was tried."""

import numpy as np
import pytest

from msc import Arm, Workspace, search_policy
from msc.plots import plot_generations, plot_rollouts_spent, slide_generations
from msc.plots._search import N_SHOWN
from msc.plots._world import square_around
from msc.robot import forward_kinematics
from msc.search import SearchOptions, cost, record_search, search_curves

world = Workspace.obstacles()
TASK = 120
brief = SearchOptions(max_evaluations=80)
plain = SearchOptions(max_evaluations=80, agreement=2.0)  # nine times nine


def test_without_a_surrogate_all_is_executed():
    [run] = record_search(world, TASK, seed=3, n_starts=1, options=plain)
    assert np.isfinite(run.costs).all()
    assert run.evaluations.tolist() == list(range(9, 82, 9))


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
        executed = np.isfinite(run.costs)
        assert executed.any(axis=1).all()
        assert not executed.all()
        assert run.evaluations[-1] == run.run.evaluations == executed.sum()
        assert (np.diff(run.best_costs) <= 0).all()
        assert run.best_costs[-1] == run.run.cost == np.nanmin(run.costs)
        best = np.unravel_index(np.nanargmin(run.costs), run.costs.shape)
        np.testing.assert_array_equal(run.policies[best], run.run.policy)
        np.testing.assert_array_equal(np.isfinite(run.joints).all((2, 3)), executed)
        one = 2, executed[2].argmax()
        with Arm(world) as arm:
            rollout = arm.execute(run.policies[one], TASK)
        assert run.costs[one] == cost(rollout)
        np.testing.assert_array_equal(run.joints[one], rollout.joints)


def test_no_start_is_refused():
    with pytest.raises(ValueError, match="n_starts=0; wanted at least one"):
        record_search(world, TASK, seed=0, n_starts=0)


def test_the_picture_has_a_line_a_start_and_a_panel_a_generation(recordings):
    figure = plot_generations(world, TASK, recordings, shown=(1, 5, 999))
    costs, *panels = figure.axes
    titles = [panel.get_title() for panel in panels]
    assert titles[:3] == [
        "generation 1",
        "generation 5",
        f"generation {len(recordings[0].costs)}",
    ]
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
    assert cheapest[1] == np.log10(np.nanmin(run.costs[7]))
    assert cheapest[0] == run.evaluations[7]
    shown = weights.marks[-1].points[7][0]
    assert set(shown) <= set(run.policies[7, np.nanargmin(run.costs[7])])


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
    best = np.nanargmin(run.costs[3])
    arm = forward_kinematics(run.joints[3, best, -1], world.link_lengths)
    shown = [mark.points[3] for mark in slider.panels[0].marks if mark.varies == "step"]
    np.testing.assert_array_equal(shown[0], arm)
    assert len(shown) == 1 + 9


def test_the_picture_of_what_is_saved_counts_what_was_executed(recordings):
    at = {"seed": 3, "n_starts": 2, "options": plain}
    [curve] = search_curves(world, [TASK], **at)
    figure = plot_rollouts_spent(recordings, curve)
    costs, counts = figure.axes
    runs = [*recordings, *record_search(world, TASK, **at)]
    for line, run in zip(costs.lines[::2], runs, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), run.evaluations)
        np.testing.assert_array_equal(line.get_ydata(), run.best_costs)
    heights = [bar.get_height() for bar in counts.patches]
    assert heights == np.isfinite(recordings[0].costs).sum(axis=1).tolist()
