from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from msc.study import draw_samples, take_evenly, task_density
from msc.study._sampling import DESIGNS

grid = np.linspace(0, 2 * np.pi, 360, endpoint=False)
sizes = st.integers(2, 360)


@given(st.sampled_from(DESIGNS), sizes, st.integers(0, 9))
def test_a_set_holds_different_tasks_in_order(design, n_samples, seed):
    for chosen in draw_samples(design, grid, n_samples, n_draws=3, seed=seed):
        assert len(chosen) == n_samples
        assert (np.diff(chosen) > 0).all()
        assert 0 <= chosen[0] <= chosen[-1] < 360


@given(st.sampled_from(DESIGNS), sizes, st.integers(0, 9))
def test_a_set_depends_on_the_seed_and_its_number_alone(design, n_samples, seed):
    few, many = (
        draw_samples(design, grid[:, None], n_samples, n_draws=n, seed=seed)
        for n in (2, 6)
    )
    for one, other in zip(few, many, strict=False):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("design", DESIGNS)
def test_another_seed_or_number_gives_another_set(design):
    sets = [
        tuple(chosen)
        for seed in (0, 1)
        for chosen in draw_samples(design, grid, 24, n_draws=3, seed=seed)
    ]
    assert len(set(sets[:3])) == 3
    assert sets[:3] != sets[3:]


# Even


@given(sizes)
def test_even_sets_are_spaced_to_within_a_step(n_samples):
    sets = draw_samples("even", grid, n_samples, n_draws=1000)
    for chosen in sets:
        gaps = np.diff(chosen)
        assert {*gaps} <= {360 // n_samples, -(-360 // n_samples)}
    firsts = sorted(chosen[0] for chosen in sets)
    assert firsts == list(range(len(sets)))
    assert max(chosen[-1] for chosen in sets) == 359


@pytest.mark.parametrize(("n_samples", "n_sets"), [(8, 45), (24, 15), (180, 2)])
def test_there_are_as_many_even_sets_as_first_tasks(n_samples, n_sets):
    assert len(draw_samples("even", grid, n_samples, n_draws=1000)) == n_sets


@pytest.mark.parametrize("design", DESIGNS)
def test_all_tasks_can_be_drawn_in_one_way(design):
    (chosen,) = draw_samples(design, grid, 360, n_draws=30)
    np.testing.assert_array_equal(chosen, np.arange(360))


# At random


def test_sets_are_no_more_than_there_are():
    assert len(draw_samples("uniform", grid[:4], 2, n_draws=30)) == comb(4, 2)


def test_uniform_draws_have_no_favourites():
    sets = draw_samples("uniform", grid[::10], 9, n_draws=4000)
    counts = np.bincount(np.concatenate(sets), minlength=36)
    np.testing.assert_allclose(counts / 4000, 9 / 36, atol=0.035)  # five deviations


def test_nonuniform_draws_follow_the_density():
    sets = draw_samples("nonuniform", grid, 2, n_draws=9000)
    counts = np.bincount(np.concatenate(sets), minlength=360)
    share = task_density(grid) / task_density(grid).sum()
    # Of two, the first is drawn by the density and the second by what is left of it.
    second = share * ((share / (1 - share)).sum() - share / (1 - share))
    expected = (share + second).reshape(12, -1).sum(axis=1)
    found = counts.reshape(12, -1).sum(axis=1) / 9000
    np.testing.assert_allclose(found, expected, atol=0.025)  # five deviations


def test_the_density_is_one():
    density = task_density(grid)
    assert density.mean() * 2 * np.pi == pytest.approx(1)
    assert (density > 0).all()
    assert density.argmax() == 180
    assert density.max() / density.min() == pytest.approx(9)


# Bad input


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("evn", grid, 24), "design='evn'; wanted one of"),
        (("even", grid, 1), "n_samples=1; wanted at least 2, whole, and at most 360"),
        (
            ("even", grid, 361),
            "n_samples=361; wanted at least 2, whole, and at most 360",
        ),
        (("uniform", grid, 2.5), r"n_samples=2\.5; wanted at least 2, whole"),
    ],
)
def test_bad_arguments_are_named(arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        draw_samples(*arguments)


def test_there_is_at_least_one_set():
    with pytest.raises(ValueError, match="n_draws=0; wanted at least 1, whole"):
        draw_samples("even", grid, 24, n_draws=0)


@pytest.mark.parametrize("n_draws", [2.5, "2", 2.0, None])
def test_a_number_of_draws_that_is_none_is_refused(n_draws):
    with pytest.raises(ValueError, match=r"n_draws=.*; wanted at least 1, whole"):
        draw_samples("uniform", grid, 24, n_draws=n_draws)


@pytest.mark.parametrize(
    ("tasks", "complaint"),
    [
        (np.arange(0, 360, 5), r"tasks hold 10; wanted radians in \[0, 2π\)"),
        (grid - 1, r"tasks hold -1; wanted radians"),
        ([0, np.nan, 1], r"tasks hold nan; wanted radians"),
        (np.zeros((4, 2)), r"tasks of shape \(4, 2\); wanted one angle a task"),
    ],
)
def test_tasks_that_are_no_angles_are_refused(tasks, complaint):
    with pytest.raises(ValueError, match=complaint):
        draw_samples("nonuniform", tasks, 2)
    with pytest.raises(ValueError, match=complaint):
        take_evenly(tasks, 2)


def test_sets_drawn_on_a_tiny_grid_may_come_twice():
    sets = draw_samples("uniform", grid[:4], 2, n_draws=6)
    assert len({tuple(chosen) for chosen in sets}) < 6


@given(st.integers(2, 72))
def test_evenly_taken_tasks_are_the_nearest_of_the_grid(n_samples):
    tasks = grid[::5]
    chosen = take_evenly(tasks, n_samples)
    assert (np.diff(chosen) > 0).all()
    wanted = 360 * np.arange(n_samples) / n_samples
    assert abs(np.rad2deg(tasks[chosen]) - wanted).max() <= 2.5 + 1e-9


@pytest.mark.parametrize("n_samples", [1, -2, 12.0, "12", None])
def test_a_number_of_samples_that_is_none_is_refused(n_samples):
    with pytest.raises(ValueError, match=r"n_samples=.*; wanted at least 2, whole"):
        take_evenly(grid[::5], n_samples)


def test_more_samples_than_tasks_are_refused():
    with pytest.raises(ValueError, match=r"n_samples=73 .* wanted at most 72"):
        take_evenly(grid[::5], 73)
