"""One task -> its policy; many tasks -> a table."""

from typing import TYPE_CHECKING

from press._lazy import face

if TYPE_CHECKING:
    from msc.search._audit import LOWER, audit_table
    from msc.search._constants import (
        choose_layout,
        locate_cut,
    )
    from msc.search._generations import (
        SearchTrace,
        record_search,
    )
    from msc.search._policy import (
        ENERGY_WEIGHT,
        ERROR_WEIGHT,
        SearchResult,
        cost,
        initial_covariance,
        search_policy,
    )
    from msc.search._sweep import (
        SweepPlan,
        grid,
        search_tasks,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
