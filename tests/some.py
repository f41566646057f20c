"""Some of what is looked at one by one; with EVERY=1 all of it."""

import os
from pathlib import Path

from press._edition import find_edition
from press._release import pick_some

ROOT = Path(__file__).parents[1]


def some(names, every):
    """Pick every so manieth, the first by the commit."""
    if "EVERY" in os.environ:
        return [*names]
    return pick_some([*names], find_edition(ROOT).commit, every)
