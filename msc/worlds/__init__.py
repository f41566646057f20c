"""Many worlds: which there are, how they are drawn, searched and looked after.

A *world* is a `Workspace` in a file of its own, `data/worlds/NAME.toml`; beside it lie
its table of training tasks, `NAME.csv`, and of test tasks, `NAME_test.csv`. Worlds come
in *families*: all of one are drawn by one rule, and kept whatever comes out.

- `FAMILIES`, `Family`, `draw_worlds`, `make_worlds`: the rules, and the worlds they
  make
- `list_worlds`, `list_tasks`, `search_worlds`: their tasks, and the tables of them
- `locate_jumps` and, of one world, `bisect_world`: where policies leap
- `study_worlds` and, of one world, `study_world`: methods against each other
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.worlds._draw import FAMILIES, Family, draw_worlds, family_of, make_worlds
    from msc.worlds._jumps import bisect_world, locate_jumps
    from msc.worlds._search import list_tasks, list_worlds, search_worlds
    from msc.worlds._study import list_tried, study_world, study_worlds

__all__, __getattr__, __dir__ = face(__name__, __file__)
