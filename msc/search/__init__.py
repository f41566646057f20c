"""One task -> its policy; many tasks -> a table.

A policy is the six weights of Eq. 7; its `cost` weighs the final distance to the goal
against the energy of the movement. `search_policy` finds the cheapest policy of one
task by several runs of CMA-ES, `search_policies` those of several tasks at once, and
`record_search` keeps all that is tried, `search_curves` what each rollout cost;
`search_tasks` carries out a `SweepPlan`, a search of many tasks that neighbours help,
on processes or a cluster, and goes on where it was interrupted. `SearchOptions` has all
that a search may be told.

A *start* is where a run of CMA-ES begins, a *run*, the `CmaRun` of `minimize`, what
becomes of it. `task_deg` are degrees, counted from the cut; the final distance is
`error` (m) in a `Rollout` and a `SearchResult`, and `distance_m` in a table.
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.search._cmaes import CmaRun, minimize
    from msc.search._curves import SearchCurve, search_curves
    from msc.search._journal import identify_code
    from msc.search._lockstep import N_PARALLEL
    from msc.search._options import SearchOptions
    from msc.search._policy import (
        ENERGY_WEIGHT,
        ERROR_WEIGHT,
        SearchResult,
        SearchTrace,
        cost,
        initial_covariance,
        record_search,
        search_policies,
        search_policy,
    )
    from msc.search._sweep import (
        SweepPlan,
        coordinates,
        draw_tasks,
        grid,
        search_tasks,
        tasks_at,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
