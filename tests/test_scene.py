import numpy as np
import pytest
from scipy.ndimage import label

from msc import Workspace
from msc.plots._film import Scene
from msc.robot import forward_kinematics, random_circles

SIZE = 180
free = Workspace.free()
obstacles = Workspace(name="layout 0", circles=random_circles(0))


def pose(turn=0.0):
    first, second, third = obstacles.home
    return first + turn, second, third


def channels(picture):
    return np.moveaxis(np.asarray(picture, dtype=int), -1, 0)


def where(picture, colour):
    """Return the mask of the pixels of a colour."""
    red, green, blue = channels(picture)
    return {
        "red": red - blue > 60,
        "blue": blue - red > 60,
        "black": red + green + blue < 200,
    }[colour]


@pytest.fixture(scope="module")
def scene():
    return Scene(obstacles, obstacles.target(200), size=SIZE)


def test_a_picture_shows_target_hand_and_obstacles(scene):
    picture = scene.shoot(pose())
    assert (picture.size, picture.mode) == ((SIZE, SIZE), "RGB")
    for colour in ("red", "blue", "black"):
        assert 0.001 < where(picture, colour).mean() < 0.1, colour
    plain = Scene(free, size=SIZE).shoot(pose())
    assert where(plain, "black").sum() < 0.1 * where(picture, "black").sum()


def test_each_obstacle_stands_by_itself(scene):
    blobs, n_blobs = label(where(scene.shoot(pose()), "black"))
    large = np.sum(np.bincount(blobs.ravel())[1:] > 15)
    assert large == len(obstacles.circles) <= n_blobs


@pytest.mark.parametrize("angle", [0, 45, 90, 135, 180, 225, 270, 315])
def test_the_goal_is_seen_on_the_side_where_it_is(angle):
    heading = np.deg2rad(angle)
    goal = 0.7 * np.array([np.cos(heading), np.sin(heading)])
    stretched = 1.2, 0.0, 0.0
    without = where(Scene(free, size=SIZE).shoot(stretched), "red")
    rows, columns = np.nonzero(
        where(Scene(free, goal, size=SIZE).shoot(stretched), "red") & ~without
    )
    assert len(rows) > 20
    centre = np.array([columns.mean() - SIZE / 2, SIZE / 2 - rows.mean() - 8])
    assert np.abs(centre / np.linalg.norm(centre) - goal / 0.7).max() < 0.25


def test_the_goal_circle_is_a_closed_ring():
    outside = free.home  # only the first link crosses the ring, above it
    red = where(Scene(free, size=SIZE).shoot(outside), "red")
    rows, columns = np.nonzero(red)
    turns = np.arctan2(rows - rows.mean(), columns - columns.mean())
    seen = np.histogram(turns, bins=60, range=(-np.pi, np.pi))[0] > 0
    assert seen.sum() >= 57
    assert label(red, np.ones((3, 3)))[1] == 1  # interrupted once at most


def test_the_hand_is_seen_on_the_side_where_it_is(scene):
    for turn, wanted in ((0.0, -1), (np.pi, 1)):  # home is left of the base, and below
        rows, columns = np.nonzero(where(scene.shoot(pose(turn)), "blue"))
        assert np.sign(columns.mean() - SIZE / 2) == wanted
        assert np.sign(SIZE / 2 - rows.mean()) == wanted


def test_a_pose_looks_the_same_whatever_was_seen_before(scene):
    first = scene.shoot(pose()).tobytes()
    assert scene.shoot(pose(1.0)).tobytes() != first
    assert scene.shoot(pose()).tobytes() == first


def test_the_way_is_one_line_up_to_the_hand(scene):
    joints = np.array([pose(turn) for turn in np.linspace(0, 1, 61)])
    path = forward_kinematics(joints, obstacles.link_lengths)[:, -1]
    without = where(scene.shoot(joints[-1]), "blue").sum()
    blue = where(scene.shoot(joints[-1], path), "blue")
    assert blue.sum() > 2 * without
    assert label(blue, np.ones((3, 3)))[1] == 1


def test_one_point_is_no_way(scene):
    path = forward_kinematics(pose(), obstacles.link_lengths)[-1:]
    assert scene.shoot(pose(), path).tobytes() == scene.shoot(pose()).tobytes()
