import numpy as np
import pytest
from PIL import Image

from msc.arm import Rollout
from msc.camera import Camera, film, render, save_film
from msc.workspace import Workspace, chain, random_circles

obstacles = Workspace(name="layout 0", circles=random_circles(0))
target = obstacles.target(200)


def pose(turn=0.0):
    first, second, third = obstacles.home
    return first + turn, second, third


def turning(n_steps=60):
    joints = np.array([pose(turn) for turn in np.linspace(0, 1, n_steps)])
    path = chain(joints, obstacles.link_lengths)[:, -1]
    return Rollout(joints, path, error=0.0, energy=0.0, contact_impulse=0.0)


def shares(picture):
    """Measure what part of a picture is red, blue and black."""
    red, green, blue = np.moveaxis(np.asarray(picture, dtype=int), -1, 0)
    return {
        "red": np.mean(red - blue > 80),
        "blue": np.mean(blue - red > 80),
        "black": np.mean(red + green + blue < 150),
    }


@pytest.fixture
def camera():
    camera = Camera(obstacles, target, size=180)
    yield camera
    camera.close()


def test_a_picture_shows_target_hand_and_obstacles(camera):
    picture = camera.shoot(pose())
    assert (picture.size, picture.mode) == ((180, 180), "RGB")
    seen = shares(picture)
    assert all(0.0003 < share < 0.1 for share in seen.values())
    plain = Camera(Workspace.free(), target, size=180)
    assert shares(plain.shoot(pose()))["black"] < 0.1 * seen["black"]
    plain.close()


def test_the_hand_is_seen_on_the_side_where_it_is(camera):
    for turn, wanted in ((0.0, -1), (np.pi, 1)):  # home is left of the base, and below
        picture = np.asarray(camera.shoot(pose(turn)), dtype=int)
        red, _, blue = np.moveaxis(picture, -1, 0)
        rows, columns = np.nonzero(blue - red > 80)
        assert np.sign(columns.mean() - 90) == wanted
        assert np.sign(90 - rows.mean()) == wanted


def test_a_pose_looks_the_same_whatever_was_seen_before(camera):
    first = camera.shoot(pose()).tobytes()
    assert camera.shoot(pose(1.0)).tobytes() != first
    assert camera.shoot(pose()).tobytes() == first


def test_the_trace_stays(camera):
    before = shares(camera.shoot(pose()))["blue"]
    camera.leave_trace(turning().path[::4])
    assert shares(camera.shoot(pose()))["blue"] > 1.5 * before


def test_a_film_goes_from_the_first_pose_to_the_last():
    rollout = turning()
    frames = film(obstacles, rollout, target, n_frames=3)
    assert len(frames) == 3
    camera = Camera(obstacles, target)
    assert camera.shoot(rollout.joints[0]).tobytes() == frames[0].tobytes()
    camera.close()
    blue = [shares(frame)["blue"] for frame in frames]
    assert blue[0] < blue[1] < blue[2]


def pictures(n_frames):
    return [Image.new("RGB", (20, 10), (40 * k, 0, 0)) for k in range(n_frames)]


def test_a_gif_lasts_as_long_as_it_should(tmp_path):
    path = tmp_path / "new" / "arm.gif"
    save_film(pictures(5), path, seconds=2.0)
    with Image.open(path) as gif:
        pauses = []
        for number in range(gif.n_frames):
            gif.seek(number)
            pauses.append(gif.info["duration"])
        assert gif.info["loop"] == 0
    assert pauses == [400, 400, 400, 400, 1000]
    assert [one.name for one in path.parent.iterdir()] == ["arm.gif"]


def test_a_png_shows_all_side_by_side(tmp_path):
    path = tmp_path / "arm.png"
    save_film(pictures(3), path, seconds=2.0)
    with Image.open(path) as strip:
        assert strip.size == (60, 10)
        assert [strip.getpixel((x, 5))[0] for x in (5, 25, 45)] == [0, 40, 80]


def test_a_rollout_is_drawn_as_a_strip_of_six(tmp_path):
    render(obstacles, turning(), target, tmp_path / "arm.png")
    with Image.open(tmp_path / "arm.png") as strip:
        assert strip.width == 6 * strip.height


@pytest.mark.parametrize("name", ["arm.mp4", "arm", "arm.gif.txt"])
def test_another_ending_is_refused(name, tmp_path):
    with pytest.raises(ValueError, match=r"out='arm.*'; wanted .*\.gif or \.png"):
        save_film(pictures(2), tmp_path / name, seconds=1.0)
    assert not list(tmp_path.iterdir())
