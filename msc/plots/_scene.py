"""The smooth view of a workspace: goal, goal circle, obstacles, the arm and its way."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from msc.plots._rays import Canvas
from msc.robot import LINK_RADIUS, Workspace, forward_kinematics

STEEL, BLUE = (0.55, 0.58, 0.63), (0.0, 0.40, 0.72)
RED, BLACK = (0.85, 0.06, 0.06), (0.08, 0.08, 0.09)
OBSTACLE_HEIGHT, ARM_HEIGHT, JOINT_HEIGHT = 0.11, 0.045, 0.073  # m, above the table


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
        """Take a picture of a pose.

        Parameters
        ----------
        joints : array_like of shape (3,)
            Joint angles (rad).
        path : array_like of shape (n_points, 2), optional
            A way of the end effector, drawn as a blue line on the table (m).

        Returns
        -------
        Image
            The picture.
        """
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
