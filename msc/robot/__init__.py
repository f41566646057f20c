"""A task and a policy -> what the arm does.

A `Workspace` says where the arm, the goals and the obstacles are; a `DMP` turns a
policy into a path of the end effector, inverse kinematics turn the path into a plan of
joint angles, and the controller follows it with torques in PyBullet or in MuJoCo, as
the world's `Physics` say. An `Arm` does all of it; a `Rollout` is what came about.
`read_world` and `format_world` keep a world in a file.

    ================  ======================================================  =========
    ``task_deg``      task angle, counted from the cut; or a row of numbers   degrees
    ``radius_m``      further number of a task: distance of the goal          m
    ``height_m``      … : how far the first obstacle has moved along y        m
    ``turn_deg``      … : how far the home pose is turned                     degrees
    ``homes``         joint angles at the start: (n_policies, 3)              rad
    ``circles``       x, y and radius of obstacles: (n_policies, n, 3)        m
    ``policy``        weights of Eq. 7, those of x before those of y: (6,)
    ``path``          places of the end effector: (n_steps + 1, 2)            m
    ``plan``          joint angles to follow: (n_steps + 1, 3)                rad
    ``joints``        joint angles that came about: (n_steps + 1, 3)          rad
    ``error``         distance from the target at the end of settling         m
    ``energy``        squared joint velocity, summed and integrated           rad²/s
    ================  ======================================================  =========

Many policies stand in front, ``(n_policies, …)``; where arms are moved in lock-step,
``n_arms`` stands last.
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.robot._arm import Arm, Rollout, cached_arm
    from msc.robot._control import (
        TIME_STEP,
        ControllerGains,
        coupled_inertias,
        joint_torques,
    )
    from msc.robot._dmp import DMP, check_policies
    from msc.robot._kinematics import (
        DAMPING,
        MAX_JOINT_STEP,
        forward_kinematics,
        inverse_kinematics,
    )
    from msc.robot._obstacles import LINK_RADIUS, Circle, clearance
    from msc.robot._physics import ENGINES, Physics
    from msc.robot._tasks import TASK_NUMBERS, CostWeights, TaskRange
    from msc.robot._workspace import Workspace, home_pose, random_circles
    from msc.robot._world_file import format_world, read_world

__all__, __getattr__, __dir__ = face(__name__, __file__)
