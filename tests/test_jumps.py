import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msc import find_jumps

tasks = np.linspace(0, 2 * np.pi, 72, endpoint=False)
smooth = np.c_[np.sin(tasks), np.cos(tasks), np.sin(2 * tasks)]


def leap_after(*places, size=3.0):
    """Lift the smooth curve after each place."""
    return smooth + size * np.searchsorted(places, np.arange(72))[:, None]


def test_a_smooth_curve_has_none():
    assert find_jumps(tasks, smooth).size == 0
    assert find_jumps(tasks, smooth, closed=True).size == 0


@settings(deadline=None)
@given(st.sets(st.integers(0, 70), max_size=6).map(sorted))
def test_every_leap_is_found_and_nothing_else(places):
    assert find_jumps(tasks, leap_after(*places)).tolist() == places


def test_only_the_closed_circle_jumps_at_the_cut():
    spiral = smooth + tasks[:, None]
    assert find_jumps(tasks, spiral).size == 0
    assert find_jumps(tasks, spiral, closed=True).tolist() == [71]


@settings(deadline=None)
@given(st.floats(1e-3, 1e3), st.floats(-100, 100), st.permutations(range(3)))
def test_units_origin_and_order_of_the_weights_do_not_matter(scale, origin, order):
    policies = leap_after(10, 40)
    found = find_jumps(tasks, scale * policies[:, order] + origin)
    assert found.tolist() == [10, 40]


def test_tasks_may_be_a_column():
    np.testing.assert_array_equal(
        find_jumps(tasks[:, None], leap_after(5)), find_jumps(tasks, leap_after(5))
    )


@pytest.mark.parametrize(("step", "found"), [(4.9, []), (5.1, [19])])
def test_a_jump_exceeds_five_median_steps(step, found):
    zigzag = np.arange(40) % 2
    values = np.where(np.arange(40) < 20, zigzag, zigzag + 1 + step)  # 1 up, step, 1 up
    assert find_jumps(np.arange(40), values[:, None]).tolist() == found


@pytest.mark.parametrize(("step", "found"), [(8.0, []), (10.5, [499])])
def test_a_jump_is_large_against_the_spread(step, found):
    values = np.linspace(0, 100, 1000) + step * (np.arange(1000) >= 500)
    assert 8.0 < 0.3 * values.std() < 10.5
    assert find_jumps(np.arange(1000), values[:, None]).tolist() == found


@pytest.mark.parametrize(
    ("tasks", "policies"),
    [
        ([0, 1, 2], np.zeros((2, 6))),
        ([0], np.zeros((1, 6))),
        ([], np.zeros((0, 6))),
        ([0, 1], np.zeros(2)),
    ],
)
def test_other_lengths_are_refused(tasks, policies):
    with pytest.raises(ValueError, match=r"policies has shape .* one row a task"):
        find_jumps(tasks, policies)


@pytest.mark.parametrize(
    "tasks", [[0, 2, 1], [0, 0, 1], [0, np.nan, 1], [0, 1, np.inf]]
)
def test_tasks_that_do_not_ascend_are_refused(tasks):
    with pytest.raises(ValueError, match="tasks do not ascend"):
        find_jumps(tasks, np.zeros((3, 6)))


def test_policies_with_nan_are_refused():
    with pytest.raises(ValueError, match="policies has NaN"):
        find_jumps([0, 1, 2], [[0.0], [np.nan], [1.0]])


def test_tasks_of_two_numbers_are_refused():
    with pytest.raises(
        ValueError, match=r"tasks has shape \(3, 2\); wanted one number"
    ):
        find_jumps(np.eye(3, 2), np.zeros((3, 6)))
