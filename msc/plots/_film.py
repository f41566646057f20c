"""The moving arm at a slant: films of what happens in a workspace, by casting rays.

A `Scene` draws the workspace on a `Canvas`. Two shapes suffice, upright cylinders and
lying rods, and where a ray meets one is a formula: no meshes, no graphics card, and the
same bytes every time. Each pixel averages nine rays, so edges are smooth. Lengths are
in metres; z points up from the table.
"""

from __future__ import annotations

import copy
import subprocess
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from imageio_ffmpeg import get_ffmpeg_exe
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from msc.robot import LINK_RADIUS, TIME_STEP, Rollout, Workspace, forward_kinematics

SLOWER = 2  # times; how much films slow a movement down
FRAME_RATES = {".gif": 20, ".mp4": 30}  # 1/s; an MP4 shows every time step
STRIP = 6  # pictures in a PNG
SIDE = 3  # rays per pixel, in each direction
TABLE_RADIUS, TABLE_THICKNESS = 0.90, 0.05
OBSTACLE_HEIGHT, ARM_HEIGHT, JOINT_HEIGHT = 0.11, 0.045, 0.073  # above the table
TABLE_COLOUR, EDGE_COLOUR = (0.93, 0.93, 0.92), (0.42, 0.42, 0.42)
STEEL, BLUE = (0.55, 0.58, 0.63), (0.0, 0.40, 0.72)
RED, BLACK = (0.85, 0.06, 0.06), (0.08, 0.08, 0.09)

_EYE, _AT, _SPREAD = np.array([0.0, -1.9, 3.0]), np.array([0.0, -0.10, 0.0]), 0.266
_LIGHT = np.array([-0.42, 0.34, 0.84])  # towards it; of length 1
_SLANT = -_LIGHT[:2] / _LIGHT[2]  # where a shadow falls, per height
_ROUNDING = 0.005  # of the upper edge of cylinders

Span = tuple[float, float]
Colour = tuple[float, float, float]
_Image = NDArray[np.float32]
_Mask = NDArray[np.bool_]
_Window = tuple[slice, slice]


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
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}")
    try:
        if path.suffix.lower() == ".gif":
            _write_gif(frames, draft)
        elif path.suffix.lower() == ".mp4":
            _write_mp4(frames, draft)
        else:
            side_by_side(frames).save(draft, "PNG", optimize=True)
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)


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


class Scene:
    """A tilted view of one workspace, with the goal (m), a red bull's-eye, if any."""

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


def _ring(centre: ArrayLike, radius: float) -> ArrayLike:
    """Return the points of a circle, closed."""
    angles = np.linspace(0, 2 * np.pi, 181)
    return np.asarray(centre) + radius * np.stack([np.cos(angles), np.sin(angles)], 1)


class Canvas:
    """What the rays of one tilted view see so far; at first, an empty table.

    It is so many pixels wide and high; colours are red, green and blue, from 0 to 1.

    >>> canvas = Canvas(60)
    >>> canvas.cylinder((0, 0), 0.3, (0, 0.1), colour=(0.1, 0.1, 0.8))
    >>> canvas.develop().getpixel((30, 27))
    (38, 38, 213)
    """

    def __init__(self, size: int) -> None:
        n_rays = SIDE * size
        ahead = (_AT - _EYE) / np.linalg.norm(_AT - _EYE)
        right = np.array([1.0, 0.0, 0.0])
        self._axes = np.stack([right, np.cross(right, ahead), ahead])
        across = np.arange(1 - n_rays, n_rays, 2, dtype=np.float32) * _SPREAD / n_rays
        u, v = np.meshgrid(across, -across)
        axes = self._axes.astype(np.float32)[..., None, None]
        self._rays = u * axes[0] + v * axes[1] + axes[2]
        self._rays /= np.linalg.norm(self._rays, axis=0)
        self._floor = self._places(0.0)
        self._bare = np.hypot(*self._floor) < TABLE_RADIUS
        self._depth = np.full((n_rays, n_rays), np.inf, np.float32)
        self._colour = np.ones((n_rays, n_rays, 3), np.float32)
        below = np.hypot(*self._places(-TABLE_THICKNESS)) < TABLE_RADIUS
        self._colour[below] = EDGE_COLOUR
        self._colour[self._bare] = TABLE_COLOUR

    def copy(self) -> Canvas:
        """Return a canvas to draw more on, while this one stays as it is."""
        other = copy.copy(self)
        other._colour, other._depth = self._colour.copy(), self._depth.copy()
        return other

    def develop(self) -> Image.Image:
        """Average the rays of each pixel: the picture."""
        size = len(self._depth) // SIDE
        rows = self._colour.reshape(size, SIDE, -1).sum(axis=1)
        pixels = rows.reshape(size, size, SIDE, 3).sum(axis=2) * (255 / SIDE**2)
        return Image.fromarray(pixels.clip(0, 255).round().astype(np.uint8))

    def line(self, points: ArrayLike, width: float, colour: Colour) -> None:
        """Paint a line (m) on the table, as a filter: shadows stay on it."""
        covered = np.zeros_like(self._bare)
        for start, end in pairwise(np.asarray(points, dtype=float)):
            window = self._window([start, end], (0.0,), width)
            covered[window] |= _gap(self._floor[:, *window], start, end)[0] < width / 2
        self._colour[covered & self._bare] *= np.divide(colour, TABLE_COLOUR)

    def shadow(
        self, start: ArrayLike, end: ArrayLike, radius: float, heights: Span
    ) -> None:
        """Darken the table below a body, the more softly the higher it is (m)."""
        first = np.add(start, heights[0] * _SLANT)
        last = np.add(end, heights[1] * _SLANT)
        window = self._window([first, last], (0.0,), radius + 0.05)
        gap, along = _gap(self._floor[:, *window], first, last)
        blur = 0.004 + 0.3 * (heights[0] + along * (heights[1] - heights[0]))
        inside = np.clip(0.5 - (gap - radius) / (2 * blur), 0, 1)
        light = 1 - 0.45 * inside * inside * (3 - 2 * inside)
        self._colour[window] *= np.where(self._bare[window], light, 1)[..., None]

    def cylinder(
        self, centre: ArrayLike, radius: float, heights: Span, colour: Colour
    ) -> None:
        """Draw an upright cylinder between two heights (m)."""
        x, y = np.asarray(centre, dtype=float).tolist()
        window = self._window([[x, y]], heights, radius)
        dx, dy, dz = self._rays[:, *window]
        ox, oy, oz = (_EYE - (x, y, 0.0)).tolist()
        top = (heights[1] - oz) / dz
        rim = radius - np.hypot(ox + top * dx, oy + top * dy)
        a, b = dx * dx + dy * dy, ox * dx + oy * dy
        root = b * b - a * (ox * ox + oy * oy - radius * radius)
        side = (-b - np.sqrt(root.clip(min=0))) / a
        z = oz + side * dz
        beside = (root > 0) & (heights[0] < z) & (z < heights[1])
        far = np.where(rim > 0, top, side)
        lean = np.where(rim > 0, 0.7 * (1 - rim / _ROUNDING).clip(min=0), 1) / radius
        out = lean * (ox + far * dx), lean * (oy + far * dy)
        normal = np.stack([*out, (rim > 0).astype(np.float32)])
        self._cover(window, far, (rim > 0) | beside, normal, colour)

    def rod(
        self,
        start: ArrayLike,
        end: ArrayLike,
        radius: float,
        height: float,
        colour: Colour,
    ) -> None:
        """Draw a lying rod, open at its ends: a cylinder is to hide them."""
        along = np.subtract(end, start)
        length = float(np.hypot(*along))
        cos, sin = (along / length).tolist()
        window = self._window([start, end], (height,), 2 * radius)
        dx, dy, dz = self._rays[:, *window]
        ox, oy, oz = (_EYE - (*np.asarray(start), height)).tolist()
        d, o = cos * dy - sin * dx, cos * oy - sin * ox  # across the rod
        a, b = d * d + dz * dz, d * o + dz * oz
        root = b * b - a * (o * o + oz * oz - radius * radius)
        far = (-b - np.sqrt(root.clip(min=0))) / a
        place = cos * (ox + far * dx) + sin * (oy + far * dy)
        hit = (root > 0) & (place > 0) & (place < length)
        normal = np.stack([-sin * (o + far * d), cos * (o + far * d), oz + far * dz])
        self._cover(window, far, hit, normal, colour)

    def _cover(
        self, window: _Window, far: _Image, hit: _Mask, normal: _Image, colour: Colour
    ) -> None:
        """Put a lit surface in front of what is farther away."""
        near = hit & (far < self._depth[window])
        self._depth[window][near] = far[near]
        normal = normal[:, near]
        normal /= np.linalg.norm(normal, axis=0)
        half = _LIGHT[:, None] - self._rays[:, *window][:, near]
        half /= np.linalg.norm(half, axis=0)
        facing = np.einsum("i,ij->j", _LIGHT, normal).clip(min=0)
        gloss = np.einsum("ij,ij->j", half, normal).clip(min=0) ** 30
        lit = 0.42 + 0.14 * normal[2] + 0.50 * facing
        shine = 0.16 * gloss[:, None]
        self._colour[window][near] = lit[:, None] * np.array(colour) + shine

    def _places(self, height: float) -> _Image:
        """Return where the rays pass a height, of shape (2, n_rays, n_rays)."""
        x, y, z = _EYE.tolist()
        far = (height - z) / self._rays[2]
        return np.stack([x + far * self._rays[0], y + far * self._rays[1]])

    def _window(
        self, points: Sequence[ArrayLike], heights: Sequence[float], margin: float
    ) -> _Window:
        """Return the part of the picture that holds points and what is near them."""
        corners = [(*point, h) for point in np.array(points) for h in heights]
        seen = self._axes @ (np.array(corners) - _EYE).T
        scale = len(self._depth) / 2 / _SPREAD
        places = seen[:2] / seen[2] * [[scale], [-scale]] + len(self._depth) / 2
        wide = scale * margin / (seen[2].min() - margin) + 1
        low = (places.min(axis=1) - wide).clip(min=0).astype(int)
        high = (places.max(axis=1) + wide).clip(min=0).astype(int)
        return slice(low[1], high[1]), slice(low[0], high[0])


def _gap(places: _Image, start: ArrayLike, end: ArrayLike) -> tuple[_Image, _Image]:
    """Measure how far places are from a line, and how far along it the nearest is."""
    (x0, y0), (dx, dy) = np.array([start, np.subtract(end, start)]).tolist()
    x, y = places[0] - x0, places[1] - y0
    along = ((x * dx + y * dy) / (dx * dx + dy * dy or 1.0)).clip(0, 1)
    return np.hypot(x - along * dx, y - along * dy), along
