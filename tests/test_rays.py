import numpy as np
import pytest
from scipy.ndimage import label

from msc.plots._film import TABLE_RADIUS, Canvas

BLUE, RED = (0.0, 0.2, 0.9), (0.9, 0.0, 0.0)
SIZE = 120


def pixels(canvas):
    return np.asarray(canvas.develop(), dtype=int)


def coloured(canvas):
    """Return the mask of the pixels that are more blue, or more red, than grey."""
    picture = pixels(canvas)
    return np.abs(picture[..., 0] - picture[..., 2]) > 40


def overlap(one, other):
    return np.sum(one & other) / np.sum(one | other)


def extent(mask):
    places = np.argwhere(mask)
    return places.min(axis=0), places.max(axis=0)


@pytest.fixture
def canvas():
    return Canvas(SIZE)


def test_the_empty_table_is_a_closed_disc_on_white(canvas):
    picture = pixels(canvas)
    assert picture.shape == (SIZE, SIZE, 3)
    table = picture[..., 0] < 250
    assert label(table)[1] == label(~table)[1] == 1
    assert (picture[[0, 0, -1, -1], [0, -1, 0, -1]] == 255).all()
    rows, columns = np.nonzero(table)
    assert columns.max() - columns.min() > 0.9 * SIZE
    assert 0.7 < np.ptp(rows) / np.ptp(columns) < 0.95  # seen at a slant


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.5, 0.3), (-0.6, -0.4)])
def test_paint_and_bodies_are_seen_at_the_same_place(canvas, place):
    painted, solid = canvas.copy(), canvas.copy()
    painted.line([place, np.add(place, (1e-6, 0))], 0.2, RED)
    solid.cylinder(place, 0.1, (0.0, 0.001), BLUE)
    assert overlap(coloured(painted), coloured(solid)) > 0.9


@pytest.mark.parametrize("end", [(0.5, 0.1), (-0.4, 0.3), (0.0, -0.6), (0.4, 0.0)])
def test_a_rod_lies_where_a_line_of_its_width_is_painted(canvas, end):
    painted, solid = canvas.copy(), canvas.copy()
    painted.line([(0.0, 0.0), end], 0.06, RED)
    solid.rod((0.0, 0.0), end, 0.03, 0.0, BLUE)
    one, other = coloured(painted), coloured(solid)
    assert overlap(one, other) > 0.5
    np.testing.assert_allclose(extent(one), extent(other), atol=2)
    back = canvas.copy()
    back.rod(end, (0.0, 0.0), 0.03, 0.0, BLUE)
    assert abs(pixels(back) - pixels(solid)).max() < 8


def test_a_cylinder_stands_up(canvas):
    canvas.cylinder((0.0, 0.0), 0.1, (0.0, 0.3), RED)
    rows, columns = np.nonzero(coloured(canvas))
    assert np.ptp(rows) > 1.2 * np.ptp(columns)
    top, side = pixels(canvas)[[rows.min() + 4, rows.max() - 4], SIZE // 2]
    assert top[0] > 1.1 * side[0]  # light comes from above


def test_what_is_in_front_hides_what_is_behind_in_any_order(canvas):
    near, far = ((0.0, -0.2), 0.12, (0.0, 0.2), RED), ((0, 0.2), 0.1, (0, 0.2), BLUE)
    rod = (-0.5, 0.0), (0.5, 0.0), 0.03, 0.1, BLUE  # between the two
    one, other, lone = canvas.copy(), canvas.copy(), canvas.copy()
    one.cylinder(*near)
    one.cylinder(*far)
    one.rod(*rod)
    other.rod(*rod)
    other.cylinder(*far)
    other.cylinder(*near)
    assert (pixels(one) == pixels(other)).all()
    lone.cylinder(*near)
    shown = pixels(lone)[..., 0] - pixels(lone)[..., 2] > 60
    assert (pixels(one)[shown] == pixels(lone)[shown]).mean() > 0.95


def test_a_line_is_whole_and_smooth(canvas):
    angles = np.linspace(0, 2 * np.pi, 61)
    ring = 0.5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    before = pixels(canvas)
    canvas.line(ring, 0.02, RED)
    redness = pixels(canvas)[..., 0] - pixels(canvas)[..., 2]
    assert label(redness > 40, np.ones((3, 3)))[1] == 1
    assert label(redness < 10)[1] == 2  # what it encloses, and the rest
    partly = (redness > 20) & (redness < 0.8 * redness.max())
    assert partly.sum() > 0.2 * (redness > 20).sum()
    assert (pixels(canvas) == before)[redness < 2].all()


def test_no_line_is_painted_beside_the_table(canvas):
    before = pixels(canvas)
    outside = 1.05 * TABLE_RADIUS
    canvas.line([(-outside, -0.2), (-outside, 0.2)], 0.02, RED)
    assert (pixels(canvas) == before).all()


def test_a_shadow_falls_to_one_side_and_is_soft(canvas):
    before = pixels(canvas)[..., 0]
    canvas.shadow((0.0, 0.0), (0.0, 0.0), 0.1, (0.0, 0.3))
    lost = before - pixels(canvas)[..., 0]
    rows, columns = np.nonzero(lost > 0)
    weights = lost[rows, columns]
    assert np.average(columns, weights=weights) > SIZE / 2 + 2  # light from the left
    assert lost.min() == 0
    assert 0.3 < lost.max() / before[SIZE // 2, SIZE // 2] < 0.6
    assert len(np.unique(weights)) > 20


def test_a_copy_is_drawn_on_alone(canvas):
    before = pixels(canvas)
    other = canvas.copy()
    other.cylinder((0.0, 0.0), 0.1, (0.0, 0.1), RED)
    other.line([(0.0, -0.5), (0.5, -0.5)], 0.05, BLUE)
    assert (pixels(canvas) == before).all()
    assert (pixels(other) != before).any()
