"""Methods against each other, on many training sets.

A *training set* is n of the 360 searched tasks of a world, drawn by a *design* ("even",
"uniform" or "nonuniform"). All *methods* are fitted to it; an *experiment* predicts the
policies of the 120 test tasks with each, executes them, and takes *measures*: errors,
one a test task and method, on a *test subset*. A *study* summarises them by design and
n, and divides the charts' means by the other methods'; a *profile* says how much it
does.

- `draw_samples`, `take_evenly`, `nearest_task`, `task_density`, `pick_typical_set`:
  which tasks
- `METHODS`, `build_method`, `fit_methods`: who is compared
- `Experiment`, `execute_policies`, `TEST_SUBSETS`: one training set
- `run_study`, `Study`, `MEASURES`, `find_cell`, `count_ahead`,
  `format_study`: many of them
- `read_trials` and, above it, `rank_methods`, `Ranks`, `critical_difference`: average
  ranks over all of it
- `run_elbows` and, below it, `read_elbows`, `measure_elbows`, `most_picked`,
  `choose_criterion`, `compare_gates`, `average_gates`, `compare_clusterers`,
  `find_clusters`: the
  choices inside a skill
- `measure_savings` and, above it, `time_searches`, `summarise_savings`,
  `break_even`: what predicting saves of searching
- `measure_method`, `measure_plans`, `summarise_cell`: one fitted method; many
- `audit_table`: evidence on a table of policies
- `locate_cut`, `choose_layout`: what fixed the world's two free constants
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.study._audit import COST_TOLERANCE, audit_table
    from msc.study._calibration import choose_layout, locate_cut
    from msc.study._choices import (
        choose_criterion,
        compare_clusterers,
        find_clusters,
        measure_elbows,
        most_picked,
    )
    from msc.study._elbows import read_elbows
    from msc.study._gates import average_gates, compare_gates
    from msc.study._measure import execute_policies, measure_method
    from msc.study._methods import METHODS, build_method, fit_methods
    from msc.study._plans import measure_plans
    from msc.study._ranks import Ranks, critical_difference, rank_methods
    from msc.study._sampling import (
        TEST_SUBSETS,
        draw_samples,
        nearest_task,
        take_evenly,
        task_density,
    )
    from msc.study._savings import (
        ONCE,
        SCRATCH,
        break_even,
        measure_savings,
        run_savings,
        summarise_savings,
        time_searches,
    )
    from msc.study._study import read_trials, run_elbows, run_study
    from msc.study._summaries import (
        MEASURES,
        Study,
        count_ahead,
        find_cell,
        format_study,
        summarise_cell,
    )
    from msc.study._trial import Experiment
    from msc.study._typical import pick_typical_set

__all__, __getattr__, __dir__ = face(__name__, __file__)
