"""A table of solved tasks, anybody's -> a skill in its own units, and what it is worth.

A *table* has a row a solved task: columns of the task, in whatever unit, columns of the
policy that solved it. `TableSkill` brings both to unit spread, closes circles, and has
one of `METHODS` learn; `fit_table` compares these by blocks of neighbouring tasks that
were left out, and fits the one that it can recommend, and the paper's. A *card* is what
was read, found and measured, fit for JSON.

    ===================  ==========================================================
    `TableSkill`         tasks in the table's units -> policies, and how sure that is
    `METHODS`            what is compared, the simplest first
    `read_table`         columns of a file, or one sentence that says what is amiss
    `fit_table`          all of it; `save_fit` writes it, `Fit` is what it returns
    `load_skill`         a skill from its file; `save_skill` writes one
    `predict_table`      a file of new tasks -> a file of policies
    `load_crepes`        what makes conformal bands, if the extra is there
    ===================  ==========================================================
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.skills._bands import load_crepes
    from msc.skills._fit import Fit, check_folder, fit_table, save_fit
    from msc.skills._methods import METHODS
    from msc.skills._predict import predict_table
    from msc.skills._saved import load_skill, save_skill
    from msc.skills._skill import TableSkill
    from msc.skills._table import UNITS, Table, read_pairs, read_table
    from msc.skills._words import list_breaks, tell_fit, tell_table

__all__, __getattr__, __dir__ = face(__name__, __file__)
