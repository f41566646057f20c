"""Parameterized skills by manifold clustering: the companion to one paper.

What `from msc import …` offers is loaded on first use, so that a script that only
clusters needs no simulator.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from msc.arm import Arm, Rollout
    from msc.crkr import CrKR
    from msc.dmp import DMP
    from msc.jumps import find_jumps
    from msc.search import SearchResult, search_policy
    from msc.skill import ParameterizedSkill
    from msc.smce import SMCE
    from msc.tables import load_dataset
    from msc.workspace import Workspace

__all__ = [
    "DMP",
    "SMCE",
    "Arm",
    "CrKR",
    "ParameterizedSkill",
    "Rollout",
    "SearchResult",
    "Workspace",
    "find_jumps",
    "load_dataset",
    "search_policy",
]

_MODULES = {
    "Arm": "arm",
    "CrKR": "crkr",
    "DMP": "dmp",
    "ParameterizedSkill": "skill",
    "Rollout": "arm",
    "SMCE": "smce",
    "SearchResult": "search",
    "Workspace": "workspace",
    "find_jumps": "jumps",
    "load_dataset": "tables",
    "search_policy": "search",
}


def __getattr__(name: str) -> Any:
    """Load a public name from the module it lives in."""
    if name in _MODULES:
        return getattr(import_module(f"msc.{_MODULES[name]}"), name)
    raise AttributeError(f"module 'msc' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public names."""
    return __all__
