"""Parameterized skills by manifold clustering: the companion to one paper.

What `from msc import …` offers is loaded on first use, so that a script that only
clusters needs no simulator.
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.data import find_jumps, load_dataset
    from msc.learn import SMCE, ParameterizedSkill
    from msc.robot import DMP, Arm, Rollout, Workspace
    from msc.search import SearchResult, search_policy
    from msc.skills import fit_table, load_skill, read_table
    from msc.study.rivals import CrKR

__all__, __getattr__, __dir__ = face(__name__, __file__)
