"""The moving arm at a slant: a view of a workspace, and films of what happens in it."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np
from imageio_ffmpeg import get_ffmpeg_exe
from numpy.typing import ArrayLike
from PIL import Image

from msc.plots._rays import Canvas
from msc.robot import (
    LINK_RADIUS,
    TIME_STEP,
    Rollout,
    Workspace,
    forward_kinematics,
)

STEEL, BLUE = (0.55, 0.58, 0.63), (0.0, 0.40, 0.72)
RED, BLACK = (0.85, 0.06, 0.06), (0.08, 0.08, 0.09)
OBSTACLE_HEIGHT, ARM_HEIGHT, JOINT_HEIGHT = 0.11, 0.045, 0.073  # m, above the table
SLOWER = 2  # times; how much films slow a movement down
FRAME_RATES = {".gif": 20, ".mp4": 30}  # 1/s; an MP4 shows every time step
STRIP = 6  # pictures in a PNG


class Scene:
    """A tilted view of one workspace, in perspective.

    Parameters
    ----------
    workspace : Workspace
        What to look at.
    target : array_like of shape (2,), optional
        The goal, a red bull's-eye on the table (m); by default there is none.
    size : int, default=480
        Width and height of a picture (pixels).

    Examples
    --------
    >>> world = Workspace.obstacles()
    >>> scene = Scene(world, world.target(60), size=48)
    >>> scene.shoot(world.home).size
    (48, 48)
    """

    def __init__(
        self, workspace: Workspace, target: ArrayLike | None = None, *, size: int = 480
    ) -> None:
        self.workspace = workspace
        self._empty = canvas = Canvas(size)
        canvas.line(_ring((0.0, 0.0), workspace.goal_radius), 0.011, RED)
        if target is not None:
            canvas.line(_ring(target, 0.008), 0.018, RED)
            canvas.line(_ring(target, 0.045), 0.016, RED)
        bodies = [((x, y), r, OBSTACLE_HEIGHT, BLACK) for x, y, r in workspace.circles]
        bodies.append(((0.0, 0.0), 0.055, 0.03, STEEL))  # the base
        for place, radius, height, _ in bodies:
            canvas.shadow(place, place, radius, (0.0, height))
        for place, radius, height, colour in bodies:
            canvas.cylinder(place, radius, (0.0, height), colour)

    def shoot(self, joints: ArrayLike, path: ArrayLike | None = None) -> Image.Image:
        """Take a picture of a pose (rad), and of a way of the end effector (m)."""
        canvas = self._empty.copy()
        if path is not None:
            canvas.line(path, 0.013, BLUE)
        points = forward_kinematics(joints, self.workspace.link_lengths)
        for start, end in pairwise(points):
            canvas.shadow(start, end, LINK_RADIUS, (ARM_HEIGHT, ARM_HEIGHT))
        for start, end in pairwise(points):
            canvas.rod(start, end, LINK_RADIUS, ARM_HEIGHT, STEEL)
        heights = ARM_HEIGHT - LINK_RADIUS, JOINT_HEIGHT
        for joint in points[:-1]:
            canvas.cylinder(joint, 0.028, heights, STEEL)
        canvas.cylinder(points[-1], 0.031, heights, BLUE)
        return canvas.develop()


def film(
    workspace: Workspace, rollout: Rollout, target: ArrayLike, *, n_frames: int = 45
) -> list[Image.Image]:
    """Take pictures of a movement, evenly spaced in time.

    Parameters
    ----------
    workspace : Workspace
        Where it happened.
    rollout : Rollout
        What happened.
    target : array_like of shape (2,)
        The goal (m).
    n_frames : int, default=45
        How many pictures, the first and the last pose included.

    Returns
    -------
    list of Image
        The pictures; each shows the way so far.
    """
    scene = Scene(workspace, target)
    steps = np.linspace(0, len(rollout.joints) - 1, n_frames).round().astype(int)
    return [scene.shoot(rollout.joints[k], rollout.path[: k + 1]) for k in steps]


def side_by_side(frames: Sequence[Image.Image]) -> Image.Image:
    """Put pictures of one size into a strip.

    Parameters
    ----------
    frames : sequence of Image
        The pictures.

    Returns
    -------
    Image
        The strip.

    Examples
    --------
    >>> side_by_side([Image.new("RGB", (4, 3))] * 5).size
    (20, 3)
    """
    strip = Image.new("RGB", (sum(frame.width for frame in frames), frames[0].height))
    for number, frame in enumerate(frames):
        strip.paste(frame, (number * frame.width, 0))
    return strip


def check_suffix(path: Path) -> None:
    """Refuse the name of a file that cannot be written.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    ValueError
        If the suffix is not `.png`, `.gif` or `.mp4`, in whatever case.
    """
    if path.suffix.lower() not in (".png", *FRAME_RATES):
        raise ValueError(
            f"out={path.name!r}; wanted a name ending in .png, .gif or .mp4"
        )


def save_film(frames: Sequence[Image.Image], path: Path) -> None:
    """Write pictures side by side as a PNG, or one after the other as a GIF or MP4.

    The suffix decides. The file is there whole or not at all.
    """
    check_suffix(path)
    with _draft(path) as draft:
        if path.suffix.lower() == ".gif":
            _write_gif(frames, draft)
        elif path.suffix.lower() == ".mp4":
            _write_mp4(frames, draft)
        else:
            side_by_side(frames).save(draft, "PNG", optimize=True)


def render(
    workspace: Workspace, rollout: Rollout, target: ArrayLike, path: Path
) -> None:
    """Draw a rollout: a strip of six pictures, or a film at half the speed.

    A film rests on its last picture for a second.

    Parameters
    ----------
    workspace : Workspace
        Where it happened.
    rollout : Rollout
        What happened.
    target : array_like of shape (2,)
        The goal (m).
    path : Path
        Where to; the suffix decides, `.png`, `.gif` or `.mp4`.

    Raises
    ------
    ValueError
        If the suffix is another.
    OSError
        If the file cannot be written.
    """
    check_suffix(path)
    rate = FRAME_RATES.get(path.suffix.lower(), 0)
    seconds = SLOWER * TIME_STEP * (len(rollout.joints) - 1)
    n_frames = 1 + round(rate * seconds) if rate else STRIP
    frames = film(workspace, rollout, target, n_frames=n_frames)
    save_film(frames + frames[-1:] * rate, path)


@contextmanager
def _draft(path: Path) -> Iterator[Path]:
    """Give a name to write to, and the file its own name once it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}")
    try:
        yield draft
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


def _write_gif(frames: Sequence[Image.Image], path: Path) -> None:
    """Write a GIF that repeats; equal pictures in a row become one that stays."""
    width, height = frames[0].size
    strip = side_by_side(frames).quantize(128)  # so that all have the same colours
    edges = range(0, strip.width, width)
    first, *others = (strip.crop((x, 0, x + width, height)) for x in edges)
    pause = 1000 // FRAME_RATES[".gif"]
    first.save(path, "GIF", save_all=True, append_images=others, duration=pause, loop=0)


def _write_mp4(frames: Sequence[Image.Image], path: Path) -> None:
    """Write H.264 in the pixel format every player knows, which wants even sizes."""
    width, height = frames[0].size
    look = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
    rate = ["-r", str(FRAME_RATES[".mp4"])]
    even = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"]
    coded = ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-threads", "1"]
    file = ["-movflags", "+faststart", "-f", "mp4", "-y", str(path)]
    program = [get_ffmpeg_exe(), "-v", "error"]
    run = subprocess.run(
        [*program, *look, *rate, "-i", "-", *even, *coded, *file],
        input=b"".join(frame.tobytes() for frame in frames),
        capture_output=True,
        check=False,
    )
    if run.returncode:
        words = run.stderr.decode(errors="replace").strip().splitlines()
        raise OSError(f"{path.name}: no film was written: {' '.join(words[-1:])}")


def _ring(centre: ArrayLike, radius: float) -> ArrayLike:
    """Return the points of a circle, closed."""
    angles = np.linspace(0, 2 * np.pi, 181)
    return np.asarray(centre) + radius * np.stack([np.cos(angles), np.sin(angles)], 1)
