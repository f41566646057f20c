"""Arrays -> figures, sliders, tables and films.

What is drawn stands behind the other floors; here it only gets its looks. A ``plot_…``
returns a Matplotlib figure, a ``slide_…`` a `Slider`, which is a page's panels that
move, and a ``…_table`` a table whose numbers are text. Methods, charts and worlds look
the same everywhere: `METHOD_STYLES`; tasks are shown in degrees, distances in
centimetres where a person looks, and axes name their units.

- `plot_workspaces`, `plot_poses`, `plot_weights`, `plot_followed`, `slide_weight`,
  `film`, `render`, `side_by_side`, `check_suffix`: a world, an arm, a movement
- `plot_generations`, `slide_generations`, `plot_quality`, `plot_curves`, `plot_tasks`,
  `plot_breaks`, `Movements`, `quality_table`, `jump_table`, `confirmed_jumps`: searches
- `plot_clusterings`, `plot_reconstruction`, `plot_affinity`, `slide_regularization`,
  `slide_charts`, `plot_elbows`, `elbow_table`, `gate_table`: charts, and how many
- `plot_manifold`, `plot_execution`, `plot_composition`, `plot_rivals`,
  `slide_execution`, `slide_predictions`, `WEIGHT_NAMES`: skills, and what they predict
- `plot_sample_sizes`, `plot_sweep`, `comparison_table`, `ratio_table`, `kernel_table`,
  `sets_table`, `gate_shares`: methods against each other
- `load_costs`, `plot_costs`, `cost_table`, `ROLLOUT_LIMIT`: time and memory
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.plots._arm import (
        plot_followed,
        plot_poses,
        plot_weights,
        slide_weight,
    )
    from msc.plots._costs import (
        ROLLOUT_LIMIT,
        cost_table,
        load_costs,
        plot_costs,
    )
    from msc.plots._film import (
        check_suffix,
        film,
        render,
        side_by_side,
    )
    from msc.plots._graph import (
        plot_affinity,
        plot_clusterings,
        plot_reconstruction,
        slide_charts,
        slide_regularization,
    )
    from msc.plots._manifold import (
        plot_execution,
        plot_manifold,
    )
    from msc.plots._movements import (
        Movements,
        plot_breaks,
        plot_tasks,
    )
    from msc.plots._search import (
        plot_generations,
        slide_generations,
    )
    from msc.plots._skill import (
        plot_composition,
        plot_rivals,
    )
    from msc.plots._study import (
        plot_curves,
        plot_elbows,
        plot_quality,
        plot_sample_sizes,
        plot_sweep,
    )
    from msc.plots._style import (
        METHOD_STYLES,
        WEIGHT_NAMES,
    )
    from msc.plots._tables import (
        comparison_table,
        confirmed_jumps,
        elbow_table,
        gate_shares,
        gate_table,
        jump_table,
        kernel_table,
        quality_table,
        ratio_table,
        sets_table,
    )
    from msc.plots._task_sliders import (
        slide_execution,
        slide_predictions,
    )
    from msc.plots._world import (
        plot_workspaces,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
