"""Arrays -> figures, sliders, tables and films.

Everything here only draws what the floors below have found:

    ===================  ==========================================================
    ``plot_*``           a Matplotlib figure, in the one style of all
    ``slide_*``          a slider: a drawing in a page that follows the reader's hand,
                         without a kernel; on paper a picture
    ``*_table``          a DataFrame as a chapter shows it
    ``film``, ``render`` the moving arm at a slant, by casting rays
    ===================  ==========================================================

Inside, ``draw_*`` draw into a panel of a figure and ``mark_*`` make marks of a slider;
a world and its arm (`_world`), and the regressions of a skill (`_skill`), are described
once for both. Colours have their names in `_style` alone. Places are in metres from
above, tasks in degrees.

- `plot_workspaces`, `plot_poses`, `plot_weights`, `plot_followed`, `slide_weight`,
  `slide_path`, `film`, `render`, `side_by_side`, `check_suffix`: a world, an arm, a
  movement
- `plot_generations`, `slide_generations`, `plot_quality`, `plot_curves`, `plot_tasks`,
  `plot_breaks`, `Movements`, `quality_table`, `jump_table`, `confirmed_jumps`: searches
- `plot_pieces`, `plot_clusterings`, `plot_reconstruction`, `plot_affinity`,
  `slide_regularization`, `slide_charts`, `plot_elbows`, `elbow_table`, `gate_table`:
  charts, and how many
- `Switch`: a figure drawn in more ways than one
- `plot_manifold`, `plot_execution`, `plot_composition`, `plot_rivals`,
  `slide_execution`, `slide_experiments`, `slide_predictions`, `drag_goal`,
  `WEIGHT_NAMES`: skills, and what they predict
- `plot_sample_sizes`, `plot_sweep`, `plot_ratios`, `find_ratios`,
  `find_kernel_ratios`, `write_ratios`, `plot_comparisons`, `comparison_table`,
  `ratio_table`, `kernel_table`, `sets_table`, `ahead_table`, `gate_shares`,
  `METHOD_STYLES`: methods compared
- `SECTION_V`, `plot_section_v`, `section_v_table`: the paper's related work
- `Leaderboard`, `list_methods`, `plot_leaderboard`, `standings_table`, `plot_ranks`:
  all of them
- `load_times`, `plot_times`, `times_table`, `load_benchmark`, `plot_benchmark`,
  `plot_fits`, `benchmark_table`, `ROLLOUT_LIMIT`: time, memory
- `plot_savings`, `savings_table`: what predicting saves of searching
- `plot_stops`, `planned_stops`, `plot_kernels`, `plot_ladder`, `rung`,
  `plot_projection`, `projected_methods`, `means_by_size`, `count_wins`: what kernels,
  charts, gates and ends decide
- `WorldSheets`, `plot_sheet`, `plot_contact_sheet`, `world_address`, `look_up`,
  `tell_pieces`: many worlds
- `plot_coverage`, `plot_other_coverage`, `coverage_table`, `GOOD_COVERAGE`: how sure
  intervals are
- `world_matrix`, `assumption_matrix`, `count_table`, `plot_families`,
  `plot_standings`, `plot_payoff`, `plot_maps`: what many worlds answer
- `plot_engines`, `plot_searched`, `plot_finer_steps`: the two engines
- `plot_bands`, `plot_caught`, `bands_table`: how sure skills are
- `plot_column`, `plot_plane`, `plot_elbow`, `plot_errors`, `plot_held`,
  `plot_learning`, `plot_graph`, `slide_policies`, `Walk`: a table of anybody's
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.plots._arm import plot_followed, plot_poses, plot_weights, slide_weight
    from msc.plots._bands import bands_table, plot_bands, plot_caught
    from msc.plots._controls import (
        count_wins,
        means_by_size,
        plot_kernels,
        plot_ladder,
        plot_projection,
        projected_methods,
        rung,
    )
    from msc.plots._coverage import (
        GOOD_COVERAGE,
        coverage_table,
        plot_coverage,
        plot_other_coverage,
    )
    from msc.plots._drag import slide_experiments
    from msc.plots._engines import plot_engines, plot_finer_steps, plot_searched
    from msc.plots._film import check_suffix, film, render, side_by_side
    from msc.plots._graph import (
        plot_affinity,
        plot_clusterings,
        plot_graph,
        plot_reconstruction,
        slide_charts,
        slide_regularization,
    )
    from msc.plots._hand import slide_path
    from msc.plots._leaderboard import (
        Leaderboard,
        list_methods,
        plot_leaderboard,
        standings_table,
    )
    from msc.plots._manifold import plot_execution, plot_manifold, slide_execution
    from msc.plots._pieces import plot_pieces
    from msc.plots._ranks import plot_ranks
    from msc.plots._ratios import plot_comparisons, plot_ratios
    from msc.plots._reach import drag_goal
    from msc.plots._report import (
        Walk,
        plot_column,
        plot_elbow,
        plot_errors,
        plot_held,
        plot_learning,
        plot_plane,
        slide_policies,
    )
    from msc.plots._rivals import SECTION_V, plot_section_v, section_v_table
    from msc.plots._savings import plot_savings, savings_table
    from msc.plots._search import (
        Movements,
        plot_breaks,
        plot_generations,
        plot_rollouts_spent,
        plot_tasks,
        slide_generations,
    )
    from msc.plots._sheets import (
        WorldSheets,
        look_up,
        plot_contact_sheet,
        plot_sheet,
        tell_pieces,
        world_address,
    )
    from msc.plots._skill import plot_composition, plot_rivals, slide_predictions
    from msc.plots._stops import planned_stops, plot_stops
    from msc.plots._study import (
        plot_curves,
        plot_elbows,
        plot_quality,
        plot_sample_sizes,
        plot_sweep,
    )
    from msc.plots._style import METHOD_STYLES, WEIGHT_NAMES
    from msc.plots._switch import Switch
    from msc.plots._tables import (
        ahead_table,
        comparison_table,
        confirmed_jumps,
        elbow_table,
        find_kernel_ratios,
        find_ratios,
        gate_shares,
        gate_table,
        jump_table,
        kernel_table,
        quality_table,
        ratio_table,
        sets_table,
        write_ratios,
    )
    from msc.plots._times import load_times, plot_times, times_table
    from msc.plots._timings import (
        ROLLOUT_LIMIT,
        benchmark_table,
        load_benchmark,
        plot_benchmark,
        plot_fits,
    )
    from msc.plots._world import plot_workspaces
    from msc.plots._worlds import (
        assumption_matrix,
        count_table,
        plot_families,
        plot_maps,
        plot_payoff,
        plot_standings,
        world_matrix,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
