"""MuJoCo: the same arm and obstacles in a second engine, driven by the same torques.

The only module that imports MuJoCo, which is optional. Every arm has a state of its own
(`MjData`) of one model, so that what it does depends on no other. Links, masses,
inertias and capsules are those of `msc.robot._bullet`; contacts are frictionless there
and here, links do not meet each other, and nothing damps a joint.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc.robot._control import ControllerGains, rod_inertia, steer
from msc.robot._obstacles import LINK_RADIUS
from msc.robot._turns import World
from msc.robot._workspace import Workspace

_Array = NDArray[np.float64]

_HALF_HEIGHT = 0.1  # m; of an obstacle's middle part


class MujocoWorld(World):
    """States of a workspace's arm, moved one after another."""

    def __init__(
        self, workspace: Workspace, controller: ControllerGains, n_arms: int
    ) -> None:
        super().__init__(workspace, controller, n_arms)
        self._mujoco = load_mujoco()
        self._model = self._mujoco.MjModel.from_xml_string(describe(workspace))
        self._states = [self._mujoco.MjData(self._model) for _ in range(n_arms)]
        self._free = self._states.clear
        self.client_id = 0

    def _track(
        self, plan: _Array, homes: _Array, circles: _Array
    ) -> tuple[_Array, _Array]:
        """Follow planned joint angles, see `track`."""
        n_policies, n_rows = plan.shape[:2]
        controller = steer(
            self.workspace, self.controller, plan.transpose(1, 2, 0).copy()
        )
        states = self._states[:n_policies]
        joints = np.empty((n_policies, n_rows, 3))
        moving = np.empty((2, 3, n_policies))
        impulse = np.zeros(n_policies)
        for state, home, posts in zip(states, homes, circles, strict=True):
            self._mujoco.mj_resetData(self._model, state)
            state.qpos[:] = home
            state.mocap_pos[:, :2] = posts[:, :2]
        joints[:, 0] = homes
        n_substeps = self.workspace.physics.substeps
        for step in range(n_rows - 1):
            for number, state in enumerate(states):
                moving[0, :, number], moving[1, :, number] = state.qpos, state.qvel
            torques = controller.torques(step, moving)
            for number, state in enumerate(states):
                state.ctrl[:] = torques[:, number]
                for _ in range(n_substeps):
                    self._mujoco.mj_step(self._model, state)
                    if state.ncon:
                        impulse[number] += state.efc_force.sum()  # contacts alone
                joints[number, step + 1] = state.qpos
        return joints, impulse * self._model.opt.timestep


def load_mujoco() -> Any:
    """Import MuJoCo, or say how to come by it."""
    try:
        import mujoco  # noqa: PLC0415
    except ImportError:
        raise ValueError(
            "engine='mujoco' is not installed; wanted the extra, "
            "pip install 'msc[mujoco]'"
        ) from None
    return mujoco


def describe(workspace: Workspace) -> str:
    """Write the arm and its obstacles in MuJoCo's format.

    Obstacles are upright capsules, as in PyBullet, in bodies that may be moved.
    """
    physics = workspace.physics
    step = physics.time_step / physics.substeps
    lines = [
        f'<mujoco><option timestep="{step!r}" gravity="0 {-physics.gravity!r} 0"/>',
        "<worldbody>",
    ]
    for x, y, radius in workspace.circles:
        lines.append(
            f'<body mocap="true" pos="{x!r} {y!r} 0"><geom type="capsule" '
            f'size="{radius!r} {_HALF_HEIGHT}" condim="1" '
            'contype="2" conaffinity="1"/></body>'
        )
    offset = 0.0
    links = zip(workspace.link_lengths, workspace.link_masses, strict=True)
    for number, (length, mass) in enumerate(links):
        across, along = float(rod_inertia(length, mass)), mass * LINK_RADIUS**2 / 2
        lines.append(
            f'<body pos="{offset!r} 0 0">'
            f'<joint name="joint_{number}" type="hinge" axis="0 0 1"/>'
            f'<inertial pos="{length / 2!r} 0 0" mass="{mass!r}" '
            f'diaginertia="{along!r} {across!r} {across!r}"/>'
            f'<geom type="capsule" fromto="0 0 0 {length!r} 0 0" '
            f'size="{LINK_RADIUS}" condim="1" contype="1" conaffinity="2"/>'
        )
        offset = length
    lines.append("</body></body></body></worldbody><actuator>")
    lines += [f'<motor joint="joint_{number}"/>' for number in range(3)]
    return "\n".join([*lines, "</actuator></mujoco>"])
