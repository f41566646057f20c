"""Methods against each other, on many training sets."""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.study._evaluation import Experiment
    from msc.study._execution import execute_policies
    from msc.study._methods import fit_methods, methods
    from msc.study._sampling import (
        draw_samples,
        nearest_task,
        take_evenly,
        task_density,
    )
    from msc.study._selection import (
        average_gates,
        choose_criterion,
        compare_clusterers,
        compare_gates,
        measure_elbows,
        most_picked,
    )
    from msc.study._study import (
        format_study,
        run_elbows,
        run_study,
    )
    from msc.study._summaries import find_cell
    from msc.study._trial import MEASURES, TEST_SUBSETS

__all__, __getattr__, __dir__ = face(__name__, __file__)
