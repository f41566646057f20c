import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image

import msc.plots._film
from msc import Rollout, Workspace
from msc.cli import main
from msc.plots import film, render
from msc.plots._film import Scene, save_film
from msc.robot import forward_kinematics

world = Workspace.obstacles()
target = world.target(200)

# Writes a strip and a GIF of a movement.
WRITE = """
import sys
from pathlib import Path
from msc import Arm, Workspace
from msc.plots._film import save_film
from msc.plots._film import Scene

world = Workspace.obstacles()
scene = Scene(world, world.target(200), size=120)
with Arm(world) as arm:
    rollout = arm.execute([10.0, -20.0, 3.0, 5.0, 5.0, 5.0], 200)
steps = range(0, 67, 22)
frames = [scene.shoot(rollout.joints[k], rollout.path[: k + 1]) for k in steps]
for name in ("arm.png", "arm.gif"):
    save_film(frames, Path(sys.argv[1], name))
"""


# Stands for ffmpeg: writes half a film, says why it stops, and fails.
BROKEN = """#!/bin/sh
for last; do :; done
echo half > "$last"
echo no room >&2
exit 1
"""


def turning(n_steps=61):
    first, second, third = world.home
    turns = np.linspace(first, first + 1, n_steps)
    joints = np.array([(turn, second, third) for turn in turns])
    path = forward_kinematics(joints, world.link_lengths)[:, -1]
    return Rollout(joints, path, error=0.0, energy=0.0, contact_impulse=0.0)


def pictures(n_frames, size=(20, 10)):
    return [Image.new("RGB", size, (40 * k, 0, 0)) for k in range(n_frames)]


def test_a_film_goes_from_the_first_pose_to_the_last():
    rollout = turning()
    frames = film(world, rollout, target, n_frames=3)
    assert len(frames) == 3
    scene = Scene(world, target)
    for frame, step in zip(frames, (0, 30, 60), strict=True):
        shot = scene.shoot(rollout.joints[step], rollout.path[: step + 1])
        assert frame.tobytes() == shot.tobytes()
    assert frames[0].tobytes() != frames[1].tobytes()


def test_a_png_shows_all_side_by_side(tmp_path):
    path = tmp_path / "arm.png"
    save_film(pictures(3), path)
    with Image.open(path) as strip:
        assert strip.size == (60, 10)
        assert [strip.getpixel((x, 5))[0] for x in (5, 25, 45)] == [0, 40, 80]


def test_a_gif_shows_one_after_the_other(tmp_path):
    path = tmp_path / "new" / "arm.gif"
    frames = pictures(5)
    save_film(frames + frames[-1:] * 19, path)
    with Image.open(path) as gif:
        seen = []
        for number in range(gif.n_frames):
            gif.seek(number)
            red = gif.convert("RGB").getpixel((5, 5))[0]
            seen.append((red, gif.info["duration"]))
        assert gif.info["loop"] == 0
    assert seen == [(0, 50), (40, 50), (80, 50), (120, 50), (160, 1000)]
    assert [one.name for one in path.parent.iterdir()] == ["arm.gif"]


@pytest.mark.parametrize(
    ("size", "seen"), [((40, 30), (40, 30)), ((41, 31), (42, 32)), ((2, 2), (2, 2))]
)
def test_an_mp4_can_be_read_back(size, seen, tmp_path):
    path = tmp_path / "arm.mp4"
    frames = [Image.new("RGB", size, (0, 0, level)) for level in range(0, 250, 10)]
    save_film(frames, path)
    said = subprocess.run(
        [get_ffmpeg_exe(), "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    )
    facts = said.stderr.decode()
    assert "Video: h264" in facts
    assert "yuv420p" in facts
    assert " 30 fps" in facts
    levels = np.frombuffer(said.stdout, np.uint8).reshape(-1, *seen[::-1], 3)
    assert len(levels) == len(frames)
    np.testing.assert_allclose(levels[:, 0, 0, 2], np.arange(0, 250, 10), atol=8)
    assert [one.name for one in tmp_path.iterdir()] == ["arm.mp4"]


def test_a_film_lasts_twice_as_long_as_the_movement_and_rests(tmp_path, monkeypatch):
    written = {}
    monkeypatch.setattr(
        msc.plots._film, "film", lambda *_, n_frames: [*range(n_frames - 1), "last"]
    )
    monkeypatch.setattr(
        msc.plots._film,
        "save_film",
        lambda frames, path: written.update({path: frames}),
    )
    rollout = turning(67)  # 1.1 s
    for name, moving, resting in (
        ("a.png", 6, 0),
        ("a.gif", 45, 20),
        ("a.mp4", 67, 30),
    ):
        render(world, rollout, target, Path(name))
        frames = written[Path(name)]
        assert frames == [*range(moving - 1), "last", *["last"] * resting], name


def test_a_rollout_is_drawn_as_a_strip_of_six(tmp_path):
    render(world, turning(), target, tmp_path / "arm.png")
    with Image.open(tmp_path / "arm.png") as strip:
        assert strip.width == 6 * strip.height
        first, last = (
            np.asarray(strip.crop((x, 0, x + strip.height, strip.height)), dtype=int)
            for x in (0, strip.width - strip.height)
        )
    blue = [np.mean(one[..., 2] - one[..., 0] > 60) for one in (first, last)]
    assert blue[1] > 2 * blue[0] > 0.001


def test_two_processes_write_the_same_bytes(tmp_path, monkeypatch):
    package = Path(msc.plots._film.__file__).parents[1]
    here, there = tmp_path / "here", tmp_path / "there"
    monkeypatch.setattr(sys, "argv", ["-c", str(here)])
    exec(WRITE, {})
    command = [sys.executable, "-c", WRITE, there]
    subprocess.run(command, cwd=package, check=True, timeout=60)
    for name in ("arm.png", "arm.gif"):
        assert (here / name).read_bytes() == (there / name).read_bytes()
        assert (here / name).stat().st_size > 5_000


@pytest.mark.parametrize("name", ["arm.avi", "arm", "arm.gif.txt", "arm.PNGG"])
def test_another_ending_is_refused(name, tmp_path, monkeypatch):
    monkeypatch.setattr(msc.plots._film, "film", None)  # it must not come to that
    with pytest.raises(
        ValueError, match=r"out='arm.*'; wanted .*\.png, \.gif or \.mp4"
    ):
        save_film(pictures(2), tmp_path / name)
    with pytest.raises(
        ValueError, match=r"out='arm.*'; wanted .*\.png, \.gif or \.mp4"
    ):
        render(world, turning(), target, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_film_that_fails_leaves_the_earlier_one(tmp_path, monkeypatch):
    path = tmp_path / "arm.mp4"
    path.write_bytes(b"earlier")
    broken = tmp_path / "broken"
    broken.write_text(BROKEN, "utf-8")
    broken.chmod(0o755)
    monkeypatch.setattr(msc.plots._film, "get_ffmpeg_exe", lambda: str(broken))
    with pytest.raises(OSError, match="no film was written: no room"):
        save_film(pictures(2), path)
    assert path.read_bytes() == b"earlier"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["arm.mp4", "broken"]


def test_a_policy_may_be_written_with_exponents(tmp_path, monkeypatch, capsys):
    given = []
    monkeypatch.setattr(msc.plots._film, "render", lambda *_: None)
    execute = msc.robot._arm.Arm.execute

    def record(arm, policy, task):
        given.append(policy)
        return execute(arm, policy, task)

    monkeypatch.setattr(msc.robot._arm.Arm, "execute", record)
    policy = ["-1e-3", "-2E+1", "-.5e1", "-3.", "1e1", "-0"]
    arguments = ["--task", "60", "--out", str(tmp_path / "arm.png")]
    assert main(["render", "--policy", *policy, *arguments]) == 0
    assert given == [[-0.001, -20.0, -5.0, -3.0, 10.0, 0.0]]
    with pytest.raises(SystemExit, match="2"):
        main(["render", "--policy", "-x", *arguments])
    assert "--policy" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["arm.PNG", "arm.Png", "arm.GIF", "arm.MP4"])
def test_an_ending_may_be_in_capitals(name, tmp_path, monkeypatch):
    monkeypatch.setattr(msc.plots._film, "film", lambda *_, n_frames: pictures(3))
    render(world, turning(5), target, tmp_path / name.lower())
    render(world, turning(5), target, tmp_path / name)
    assert (tmp_path / name).read_bytes() == (tmp_path / name.lower()).read_bytes()
