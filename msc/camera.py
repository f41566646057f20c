"""Pictures of the moving arm, drawn without a screen by PyBullet's TinyRenderer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from msc.arm import Rollout
from msc.bullet import load_pybullet
from msc.control import TIME_STEP
from msc.workspace import LINK_RADIUS, Workspace, chain

WHITE, GREY, BLUE, RED, BLACK = (
    (1.0, 1.0, 1.0, 1.0),
    (0.55, 0.55, 0.6, 1.0),
    (0.0, 0.45, 0.7, 1.0),
    (0.85, 0.1, 0.1, 1.0),
    (0.08, 0.08, 0.08, 1.0),
)
_VIEW = ([0, -1.3, 2.3], [0, -0.05, 0], [0, 1, 0])  # from, at, up


class Camera:
    """A view from above, slightly tilted, of one workspace.

    Parameters
    ----------
    workspace : Workspace
        What to look at.
    target : array_like of shape (2,)
        The goal, drawn as a red ball (m).
    size : int, default=360
        Width and height of a picture (pixels).
    """

    def __init__(
        self, workspace: Workspace, target: ArrayLike, *, size: int = 360
    ) -> None:
        self.workspace, self.size = workspace, size
        self._bullet = load_pybullet()
        self._client: int = self._bullet.connect(self._bullet.DIRECT)
        self._add("box", (0, 0, -0.13), WHITE, halfExtents=[4, 4, 0.01])
        for angle in np.arange(0, 360, 4):
            x, y = workspace.target(angle)
            self._add("sphere", (x, y, -0.1), RED, radius=0.006)
        x, y = np.asarray(target, dtype=float)
        self._add("sphere", (x, y, 0.0), RED, radius=0.03)
        for circle in workspace.circles:
            place = (circle.x, circle.y, 0.0)
            self._add("cylinder", place, BLACK, radius=circle.radius, length=0.2)
        self._add("cylinder", (0, 0, -0.06), GREY, radius=0.05, length=0.12)
        self._links = [
            self._add("capsule", (0, 0, 0), GREY, radius=LINK_RADIUS, length=length)
            for length in workspace.link_lengths
        ]
        self._hand = self._add("sphere", (0, 0, 0), BLUE, radius=0.03)

    def close(self) -> None:
        """Free the scene."""
        self._bullet.disconnect(self._client)

    def shoot(self, joints: ArrayLike) -> Image.Image:
        """Take a picture of a pose.

        Parameters
        ----------
        joints : array_like of shape (3,)
            Joint angles (rad).

        Returns
        -------
        Image
            The picture.
        """
        bullet = self._bullet
        points = chain(joints, self.workspace.link_lengths)
        for link, start, end in zip(self._links, points, points[1:], strict=False):
            heading = float(np.arctan2(*(end - start)[::-1]))
            turn = bullet.getQuaternionFromEuler([0, np.pi / 2, heading])
            self._move(link, (start + end) / 2, turn)
        self._move(self._hand, points[-1], [0, 0, 0, 1])
        _, _, pixels, _, _ = bullet.getCameraImage(
            2 * self.size,
            2 * self.size,
            viewMatrix=bullet.computeViewMatrix(*_VIEW),
            projectionMatrix=bullet.computeProjectionMatrixFOV(42, 1.0, 0.1, 10),
            lightDirection=[0.3, -0.6, 2.0],
            lightAmbientCoeff=0.7,
            lightDiffuseCoeff=0.4,
            shadow=0,
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        array = np.reshape(
            np.asarray(pixels, dtype=np.uint8), (*[2 * self.size] * 2, 4)
        )
        picture = Image.fromarray(array[..., :3])
        return picture.resize((self.size, self.size), Image.Resampling.LANCZOS)

    def leave_trace(self, path: NDArray[np.float64]) -> None:
        """Leave blue dots along the way of the end effector.

        Parameters
        ----------
        path : ndarray of shape (n_points, 2)
            Where to (m).
        """
        for x, y in path:
            self._add("sphere", (x, y, -0.05), BLUE, radius=0.007)

    def _move(self, body: int, place: ArrayLike, turn: Sequence[float]) -> None:
        x, y = np.asarray(place)
        self._bullet.resetBasePositionAndOrientation(
            body, [x, y, 0.0], turn, physicsClientId=self._client
        )

    def _add(
        self,
        shape: str,
        place: Sequence[float],
        colour: Sequence[float],
        **size: object,
    ) -> int:
        """Add something to look at."""
        visual = self._bullet.createVisualShape(
            getattr(self._bullet, f"GEOM_{shape.upper()}"),
            rgbaColor=colour,
            physicsClientId=self._client,
            **size,
        )
        body: int = self._bullet.createMultiBody(
            0.0, -1, visual, basePosition=place, physicsClientId=self._client
        )
        return body


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
        How many pictures.

    Returns
    -------
    list of Image
        The pictures; each shows the way so far.
    """
    camera = Camera(workspace, target)
    steps = np.linspace(0, len(rollout.joints) - 1, n_frames).round().astype(int)
    frames, before = [], 0
    for step in steps:
        camera.leave_trace(rollout.path[before:step:4])
        before = step
        frames.append(camera.shoot(rollout.joints[step]))
    camera.close()
    return frames


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
    """Refuse a file name that is neither a GIF's nor a PNG's.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    ValueError
        If the suffix is another.
    """
    if path.suffix not in (".gif", ".png"):
        raise ValueError(f"out={path.name!r}; wanted a name ending in .gif or .png")


def save_film(frames: Sequence[Image.Image], path: Path, *, seconds: float) -> None:
    """Write pictures as a GIF, or side by side as a PNG.

    Parameters
    ----------
    frames : sequence of Image
        The pictures.
    path : Path
        Where to; the suffix decides, `.gif` or `.png`.
    seconds : float
        How long the movement lasts, for the GIF.

    Raises
    ------
    ValueError
        If the suffix is another.
    """
    check_suffix(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}")
    if path.suffix == ".gif":
        palette = [frame.quantize(64, dither=Image.Dither.NONE) for frame in frames]
        step = round(1000 * seconds / len(frames))
        pauses = [step] * (len(frames) - 1) + [1000]
        palette[0].save(
            draft,
            "GIF",
            save_all=True,
            append_images=palette[1:],
            duration=pauses,
            loop=0,
        )
    else:
        side_by_side(frames).save(draft, "PNG")
    draft.replace(path)


def render(
    workspace: Workspace, rollout: Rollout, target: ArrayLike, path: Path
) -> None:
    """Draw a rollout: a GIF twice as slow as it was, or a strip of six pictures.

    Parameters
    ----------
    workspace : Workspace
        Where it happened.
    rollout : Rollout
        What happened.
    target : array_like of shape (2,)
        The goal (m).
    path : Path
        Where to; the suffix decides, `.gif` or `.png`.

    Raises
    ------
    ValueError
        If the suffix is another.
    """
    n_frames = 45 if path.suffix == ".gif" else 6
    seconds = 2 * TIME_STEP * (len(rollout.joints) - 1)
    frames = film(workspace, rollout, target, n_frames=n_frames)
    save_film(frames, path, seconds=seconds)
