"""Tables of policies and results on disk, and the jumps in them.

A *table* has a row a task and the columns of `COLUMNS`: the task's angle (degrees, from
the cut), the policy's six weights, what its movement measured and cost. `save_table`
writes one, `load_dataset` reads it as a `Dataset`: tasks in radians, as the learners
want them, policies, and the table. The final distance of end effector and target has
one name a place: `error` (m) in code, `distance_m` in tables, and centimetres,
`error_cm`, only where a person looks. `load_results` reads what commands found, and
refuses what rests on other tables. `find_jumps` tells where neighbouring tasks have
policies far apart; `make_two_arcs` has two pieces few enough to be looked at.
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.data._graph import (
        find_jump_edges,
        find_neighbors,
        find_pieces,
        task_edges,
    )
    from msc.data._jumps import find_jumps, make_two_arcs, step_sizes
    from msc.data._tables import (
        COLUMNS,
        WEIGHTS,
        WORLDS,
        Dataset,
        describe_origin,
        find_data,
        find_table,
        find_world,
        load_dataset,
        load_results,
        name_weights,
        read_package,
        read_result,
        save_table,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
