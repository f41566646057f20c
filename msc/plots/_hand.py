"""A movement in the reader's hand: six weights and a task, and what they plan.

A path is linear in its weights (Eq. 5), so a page can work it out by itself, and follow
it with the arm's joints as `msc.robot.inverse_kinematics` does. It cannot tell of
contact, nor of what motors do.
"""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from msc.plots._slider import poster
from msc.plots._style import TRIO, WEIGHT_NAMES, encode_png
from msc.plots._world import draw_arm, draw_world
from msc.robot import (
    DAMPING,
    MAX_JOINT_STEP,
    Workspace,
    check_policies,
    forward_kinematics,
    inverse_kinematics,
)

N_DIGITS = 7  # of the responses that a page is given
_SCRIPT = Path(__file__).with_name("hand.js")


def slide_path(
    world: Workspace, policy: ArrayLike, task_deg: float, reach: float
) -> PathInHand:
    """Let the reader set a task and all weights, and see the path that they plan.

    Parameters
    ----------
    world : Workspace
        Whose arm; its obstacles are left out.
    policy : array_like of shape (n_params,)
        Where the weights are at first.
    task_deg : float
        Where the task is at first (degrees).
    reach : float
        How far a weight may be moved to either side of zero.

    Returns
    -------
    PathInHand
        Shows itself as HTML, or as its `poster` where there is no script.

    Raises
    ------
    ValueError
        If the policy has another number of weights.
    """
    weights = check_policies(policy, world.dmp.n_params, single=True)
    return PathInHand(world, tuple(weights.round(1).tolist()), task_deg, reach)


@dataclass(frozen=True)
class PathInHand:
    """A drawing over sliders for a task and all weights."""

    world: Workspace
    policy: tuple[float, ...]
    task_deg: float
    reach: float

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or a picture where there is none."""
        png = encode_png(self.poster)
        return {
            "text/html": self.to_html(png),
            "image/png": png,
            "text/plain": self._alt,
        }

    @property
    def poster(self) -> Figure:
        """What is shown where there is no script: the first movement."""
        return _draw_plan(self.world, self.task_deg, self._joints())

    @property
    def _alt(self) -> str:
        """What the picture shows."""
        return (
            f"The arm, its home pose pale, and the path that it plans to the goal at "
            f"{self.task_deg:g}°."
        )

    def _joints(self) -> Any:
        """Plan the joints' angles, as an arm does."""
        world, times = self.world, self._times()
        start, goal = self._start(), world.target(self.task_deg)
        path = world.dmp.path(self.policy, start, goal, times)
        return inverse_kinematics(path, world.home, world.link_lengths)

    def _times(self) -> Any:
        physics = self.world.physics
        return physics.time_step * np.arange(physics.n_moving + 1)

    def _start(self) -> Any:
        return forward_kinematics(self.world.home, self.world.link_lengths)[-1]

    def _data(self) -> dict[str, Any]:
        """Return what the script reads."""
        world, dmp, times = self.world, self.world.dmp, self._times()
        unit = np.zeros(2), np.ones(2)
        n_basis = dmp.n_basis
        pull = dmp.path(np.zeros(2 * n_basis), *unit, times)[:, 0]
        pushed = dmp.path(np.eye(2 * n_basis)[:n_basis], *unit, times)[..., 0]
        return {
            "pull": np.round(pull, N_DIGITS).tolist(),
            "pushes": np.round(pushed - pull, N_DIGITS).tolist(),
            "home": list(map(float, world.home)),
            "links": list(map(float, world.link_lengths)),
            "radius": world.goal_radius,
            "cut": world.cut_deg,
            "step": self.world.physics.time_step,
            "damping": DAMPING,
            "limit": MAX_JOINT_STEP,
            "policy": self.policy,
        }

    def to_html(self, png: str | None = None) -> str:
        """Write a piece of HTML that needs no other file; the picture in base 64."""
        image = png or encode_png(self.poster)
        task = (
            '<label>task <input name="task" type="range" min="0" max="359" '
            f'value="{round(self.task_deg) % 360}" autocomplete="off"><b></b></label>'
        )
        weights = "".join(
            f"<label>{html.escape(name)} "
            f'<input name="weight" type="range" min="{-self.reach:g}" '
            f'max="{self.reach:g}" step="0.1" value="{weight:g}" '
            'autocomplete="off"><b></b></label>'
            for name, weight in zip(WEIGHT_NAMES, self.policy, strict=True)
        )
        data = json.dumps(self._data(), separators=(",", ":")).replace("<", r"\u003c")
        return (
            '<div class="msc-hand">'
            f'<img class="msc-poster" alt="{html.escape(self._alt)}" '
            f'src="data:image/png;base64,{image}">'
            '<div class="msc-told"><svg viewBox="-0.85 -0.8 1.7 1.6" role="img" '
            'aria-label="The arm and the path that the sliders plan."></svg>'
            f"<fieldset><legend>Drag any of them</legend>{task}{weights}"
            '<button type="button" name="searched">As searched</button> '
            '<button type="button" name="zero">All weights zero</button>'
            "</fieldset><output></output></div></div>"
            f"<script>({_SCRIPT.read_text(encoding='utf-8').strip()})"
            f"(document.currentScript.previousElementSibling,{data});</script>"
        )


@poster
def _draw_plan(axis: Axes, world: Workspace, task_deg: float, joints: Any) -> None:
    """Draw a planned movement: its path, the arm before it and after it."""
    draw_world(axis, world, task_deg, view="sketch")
    draw_arm(axis, world, joints[0], lw=3, color="0.75")
    draw_arm(axis, world, joints[-1], lw=3)
    path = forward_kinematics(joints, world.link_lengths)[:, -1]
    axis.plot(*path.T, color=TRIO[0], lw=2)
