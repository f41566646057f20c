"""The same arm and obstacles in MuJoCo, driven by given torques.

Only `mujoco.rollout` is used: C code that goes through all rollouts, open-loop. MuJoCo
is optional; without it, `rollout` is None.
"""

import numpy as np

from msc import Workspace
from msc.robot import forward_kinematics
from msc.robot._mujoco import describe

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
        n_substeps = self.workspace.physics.substeps
        control = torques.repeat(n_substeps, axis=1)
        n_steps = control.shape[1]
        states, _ = self.threads.rollout(
            self.model, self.data, self.start, control, nstep=n_steps
        )
        return states[:, n_substeps - 1 :: n_substeps, 1:4]  # behind the time

    def ends(self, torques: np.ndarray) -> np.ndarray:
        """Return where the end effectors come to rest (n_rollouts, 2)."""
        last = self.execute(torques)[:, -1]
        return forward_kinematics(last, self.workspace.link_lengths)[:, -1]
