"""Tasks and policies -> charts -> a skill; knows no robot."""

from typing import TYPE_CHECKING

from press._lazy import face

if TYPE_CHECKING:
    from msc.learn._copies import find_copies
    from msc.learn._crkr import CrKR
    from msc.learn._elbows import SELECTION_CRITERIA, read_elbows
    from msc.learn._gaussian import gaussian_process
    from msc.learn._reconstruction import reconstruct
    from msc.learn._skill import GATES, ParameterizedSkill, seeded_clone
    from msc.learn._smce import SMCE
    from msc.learn._spectral import elbow

__all__, __getattr__, __dir__ = face(__name__, __file__)
