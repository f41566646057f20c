"""Tasks and policies -> charts -> a skill; knows no robot."""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.learn._copies import find_copies
    from msc.learn._crkr import CrKR
    from msc.learn._elbow_parts import (
        choose_reading,
        measure_elbows,
        most_picked,
    )
    from msc.learn._elbows import READINGS, read_elbows
    from msc.learn._gates import (
        average_gates,
        compare_gates,
    )
    from msc.learn._gaussian import gaussian_process
    from msc.learn._pieces import compare_clusterers
    from msc.learn._reconstruction import reconstruct
    from msc.learn._skill import ParameterizedSkill
    from msc.learn._smce import SMCE
    from msc.learn._spectral import elbow
    from msc.learn._validation import (
        validate_cost,
        validate_pairs,
        validate_points,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
