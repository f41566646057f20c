import numpy as np
import pandas as pd
import pytest

import msc.plots._search
from msc.data import Dataset
from msc.plots import Movements, plot_breaks, plot_tasks
from msc.plots._search import BREAK
from msc.robot import forward_kinematics
from msc.search import cost

DEGREES = np.arange(0.0, 360.0, 15.0)


@pytest.fixture(scope="module")
def movements():
    """Return movements that change twice, after the 5th and the 11th task."""
    policies = np.zeros((len(DEGREES), 6))
    policies[:, 0] = 0.1 * np.arange(len(DEGREES))
    policies[5:11] += 30.0
    table = pd.DataFrame({"task_deg": DEGREES})
    with pytest.MonkeyPatch.context() as patch:
        found = Dataset(np.deg2rad(DEGREES)[:, None], policies, table)
        patch.setattr(msc.plots._search, "load_dataset", lambda _: found)
        return Movements("obstacles")


def test_gaps_are_the_largest_distances_of_joints_at_the_same_time(movements):
    lengths = movements.workspace.link_lengths
    for one, two in ((0, 1), (5, 6), (-1, 0)):
        largest = 0.0
        pair = movements.rollouts[one].joints, movements.rollouts[two].joints
        for joints, others in zip(*pair, strict=True):
            apart = forward_kinematics(joints, lengths) - forward_kinematics(
                others, lengths
            )
            largest = max(largest, *np.hypot(*apart.T))
        assert movements.gaps[one] == pytest.approx(largest)
    assert movements.gaps.shape == DEGREES.shape


def test_breaks_are_the_jumps_and_the_cut(movements):
    assert movements.jumps.tolist() == [4, 10]
    assert movements.breaks == [(4, 5), (10, 11), (23, 0)]
    others = np.delete(movements.gaps, [4, 10, 23])
    np.testing.assert_array_equal(movements.unbroken, others)


def test_the_table_compares_both_sides(movements):
    table = movements.compare()
    assert table.index.tolist() == ["60° | 75°", "150° | 165°", "345° | 0°"]
    rows = zip(table.to_dict("records"), movements.breaks, strict=True)
    for row, (before, after) in rows:
        one, two = movements.rollouts[before], movements.rollouts[after]
        assert row["apart (cm)"] == 100 * movements.gaps[before]
        assert (row["cost before"], row["cost after"]) == (cost(one), cost(two))
        assert row["touched before"] == one.touched
        assert row["touched after"] == two.touched
        assert row["missed by (cm)"] == 100 * max(one.error, two.error)


def test_who_touched_an_obstacle_came_close_to_one(movements):
    touched = [rollout.touched for rollout in movements.rollouts]
    assert 0 < sum(touched) < len(touched)
    found = [movements.touched(k) for k in range(len(touched))]
    assert [bool(circles) for circles in found] == touched
    assert all(set(c) <= set(movements.workspace.circles) for c in found)


def test_everything_lies_within_bounds(movements):
    low, high = movements.bounds
    assert (movements.places > low).all()
    assert (movements.places < high).all()
    for x, y, radius in movements.workspace.circles:
        assert (low < (x - radius, y - radius)).all()
        assert (high > (x + radius, y + radius)).all()
    assert (high - low < 2.1).all()  # an arm of one metre


def test_tasks_are_picked_evenly(movements):
    assert movements.evenly(4) == [0, 6, 12, 18]
    with pytest.raises(ValueError, match="n_samples=25"):
        movements.evenly(25)


def drawn(axis, colour):
    return [line for line in axis.lines if line.get_color() == colour]


def rims(axis):
    patches = axis.patches[1:]  # the first is the goal circle
    return [p.get_edgecolor() != p.get_facecolor() for p in patches]


def test_each_task_has_a_panel(movements):
    indices = movements.evenly(6)
    figure = plot_tasks(movements, indices, n_poses=4)
    panels = [axis for axis in figure.axes if axis.lines]
    assert [axis.get_title() for axis in panels] == [f"{60 * k}°" for k in range(6)]
    for axis, index in zip(panels, indices, strict=True):
        way, marks = drawn(axis, BREAK[0])
        path = movements.rollouts[index].path
        np.testing.assert_array_equal(way.get_xydata(), path)
        np.testing.assert_array_equal(marks.get_xydata(), path[[0, 22, 44, 66]])
        goal = movements.workspace.target(DEGREES[index])
        np.testing.assert_allclose(axis.lines[-1].get_xydata(), [goal])
        assert len(axis.lines) == 2 * 4 + 3
        assert sum(rims(axis)) == len(movements.touched(index))


def test_both_sides_of_a_break_are_next_to_each_other(movements):
    figure = plot_breaks(movements, movements.breaks)
    titles = [axis.get_title() for axis in figure.axes]
    assert [title.partition("\n")[0] for title in titles] == [
        *("60°", "75°"),
        *("150°", "165°"),
        *("345°", "0°"),
    ]
    for axis, index in zip(figure.axes, np.ravel(movements.breaks), strict=True):
        rollout = movements.rollouts[index]
        assert f"cost {cost(rollout):.3f}, " in axis.get_title()
        contact = "contact" if rollout.touched else "no contact"
        assert axis.get_title().endswith(f", {contact}")
    left, right = figure.axes[:2]
    for axis, own, other in ((left, 4, 5), (right, 5, 4)):
        colour, faint = BREAK if axis is left else BREAK[::-1]
        assert drawn(axis, faint)[0].get_linestyle() == ":"
        for line, index in (
            (drawn(axis, faint)[0], other),
            (drawn(axis, colour)[0], own),
        ):
            np.testing.assert_array_equal(
                line.get_xydata(), movements.rollouts[index].path
            )


def test_many_breaks_stand_two_in_a_row(movements):
    breaks = [(k, k + 1) for k in range(7)]
    figure = plot_breaks(movements, breaks)
    shown = [axis for axis in figure.axes if axis.lines]
    assert [int(axis.get_title().partition("°")[0]) for axis in shown] == [
        15 * index for pair in breaks for index in pair
    ]
    assert figure.axes[0].get_gridspec().get_geometry() == (4, 4)
    assert len(figure.axes) - len(shown) == 2
