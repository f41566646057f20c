"""A task and a policy -> what the arm does."""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.robot._arm import Arm, Rollout, cached_arm
    from msc.robot._control import TIME_STEP
    from msc.robot._dmp import DMP, check_policies
    from msc.robot._dynamics import joint_torques
    from msc.robot._geometry import (
        LINK_RADIUS,
        Circle,
        clearance,
        forward_kinematics,
    )
    from msc.robot._kinematics import inverse_kinematics
    from msc.robot._workspace import (
        Workspace,
        random_circles,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
