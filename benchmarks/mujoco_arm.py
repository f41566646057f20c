"""The same arm and obstacles in MuJoCo, driven by given torques.

Links, masses, inertias, capsules, obstacles and time step are those of
`msc.robot`. Only `mujoco.rollout` is used: C code that goes through all rollouts,
open-loop. MuJoCo is optional; without it, `rollout` is None.
"""

import numpy as np

from msc import Workspace
from msc.robot import LINK_RADIUS, TIME_STEP, forward_kinematics
from msc.robot._arm import N_STEPS
from msc.robot._bullet import SUBSTEPS
from msc.robot._control import rod_inertia

try:
    import mujoco
    from mujoco import rollout
except ImportError:
    mujoco = rollout = None


class MujocoArm:
    """The arm of a workspace, for one thread."""

    def __init__(self, workspace: Workspace) -> None:
        self.workspace = workspace
        self.model = mujoco.MjModel.from_xml_string(describe(workspace))
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = workspace.home
        full = mujoco.mjtState.mjSTATE_FULLPHYSICS
        self.start = np.empty(mujoco.mj_stateSize(self.model, full))
        mujoco.mj_getState(self.model, self.data, self.start, full)
        self.threads = rollout.Rollout(nthread=0)  # none beside the calling one

    def execute(self, torques: np.ndarray) -> np.ndarray:
        """Apply torques (n_rollouts, n_steps, 3); return joint angles, as many rows.

        Torques are those of the controller's time steps; each holds over the sub-steps.
        """
        control = torques.repeat(SUBSTEPS, axis=1)
        states, _ = self.threads.rollout(
            self.model, self.data, self.start, control, nstep=SUBSTEPS * N_STEPS
        )
        return states[:, SUBSTEPS - 1 :: SUBSTEPS, 1:4]  # behind the time

    def ends(self, torques: np.ndarray) -> np.ndarray:
        """Return where the end effectors come to rest (n_rollouts, 2)."""
        last = self.execute(torques)[:, -1]
        return forward_kinematics(last, self.workspace.link_lengths)[:, -1]


def describe(workspace: Workspace) -> str:
    """Write the arm and its obstacles in MuJoCo's format.

    Obstacles are upright capsules, to an arm in their middle plane the same as
    cylinders, but of MuJoCo's quickest pair of shapes. Contacts are frictionless; links
    do not meet each other.
    """
    step = TIME_STEP / SUBSTEPS
    lines = [f'<mujoco><option timestep="{step}" gravity="0 0 0"/><worldbody>']
    for x, y, radius in workspace.circles:
        lines.append(
            f'<geom type="capsule" pos="{x} {y} 0" size="{radius} 0.1" condim="1" '
            'contype="2" conaffinity="1"/>'
        )
    offset = 0.0
    links = zip(workspace.link_lengths, workspace.link_masses, strict=True)
    for number, (length, mass) in enumerate(links):
        across, along = rod_inertia(length, mass), mass * LINK_RADIUS**2 / 2
        lines.append(
            f'<body pos="{offset} 0 0">'
            f'<joint name="joint_{number}" type="hinge" axis="0 0 1"/>'
            f'<inertial pos="{length / 2} 0 0" mass="{mass}" '
            f'diaginertia="{along} {across} {across}"/>'
            f'<geom type="capsule" fromto="0 0 0 {length} 0 0" size="{LINK_RADIUS}" '
            'condim="1" contype="1" conaffinity="2"/>'
        )
        offset = length
    lines.append("</body></body></body></worldbody><actuator>")
    lines += [f'<motor joint="joint_{number}"/>' for number in range(3)]
    return "\n".join([*lines, "</actuator></mujoco>"])
