"""Many worlds: which there are, how they are drawn, searched and looked after.

A *world* is a `Workspace` in a file of its own, `data/worlds/NAME.toml`; beside it lie
its table of training tasks, `NAME.csv`, and of test tasks, `NAME_test.csv`. Worlds come
in *families*: all of one are drawn by one rule, and kept whatever comes out.

- `FAMILIES`, `Family`, `draw_worlds`, `make_worlds`: the rules, and the worlds they
  make
- `list_worlds`, `list_tasks`, `search_worlds`: their tasks, and the tables of them
- `locate_jumps` and, of one world, `bisect_world`: where policies leap
- `VARIANTS`, `draw_variants`: choices of ours, changed one at a time
- `compare_engines` and, of one world, `execute_elsewhere`, `refine_steps`: the other
  engine
- `load_questions`, `load_choices`, `Question`, `judge_worlds`, `ANSWERS`,
  `count_answers`, `resample`: what is asked of worlds, and what they answer
- `study_worlds` and, of one world, `study_world`: methods against each other
- `locate_bands` and, of one world, `measure_bands`, `judge_bands`: how sure skills are
- `locate_moves` and, of one world, `move_world`, `unpack_joints`: what arms do
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.worlds._bands import judge_bands, locate_bands, measure_bands
    from msc.worlds._draw import FAMILIES, Family, draw_worlds, family_of, make_worlds
    from msc.worlds._engines import compare_engines, execute_elsewhere, refine_steps
    from msc.worlds._jumps import bisect_world, locate_jumps
    from msc.worlds._moves import locate_moves, move_world, unpack_joints
    from msc.worlds._questions import Question, load_choices, load_questions
    from msc.worlds._search import list_tasks, list_worlds, search_worlds
    from msc.worlds._study import study_world, study_worlds
    from msc.worlds._variants import VARIANTS, draw_variants
    from msc.worlds._verdicts import ANSWERS, count_answers, judge_worlds, resample

__all__, __getattr__, __dir__ = face(__name__, __file__)
