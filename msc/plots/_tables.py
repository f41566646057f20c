"""Tables of what a study found, as the chapters show them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from msc.data import load_dataset
from msc.estimates import Estimate, rounded
from msc.study import draw_samples, find_cell

WORLD_TITLES = {"free": "without obstacles", "obstacles": "with obstacles"}
SIGNS = {"lower": "●", "undecided": "○", "higher": "✕"}  # of the charts' error
PLAIN = {  # measures, where they are shown
    "error_cm": "distance at the end (cm)",
    "error_cm spread": "spread of distances at the end (cm)",
    "excess_cost": "excess cost",
}
BASELINES = ("single regression", "CrKr", "nearest neighbour")


def compare_cells(
    study: dict[str, Any], design: str = "even", *, method: str = "charts"
) -> pd.DataFrame:
    """List every comparison of the charts with another method.

    Parameters
    ----------
    study : dict
        Results of a study.
    design : {"even", "uniform", "nonuniform"}, default="even"
        How training tasks were drawn.
    method : {"charts", "charts, Matérn"}, default="charts"
        Which charts.

    Returns
    -------
    DataFrame
        Columns `n_samples`, `measure`, `baseline` and `comparison`, the last of
        `msc.estimates.Estimate`.
    """
    rows = [
        (
            cell["n_samples"],
            ratio["measure"],
            ratio["baseline"],
            Estimate.read(ratio, "ratio"),
        )
        for cell in study["cells"]
        if cell["design"] == design
        for ratio in cell["ratios"]
        if ratio["method"] == method
    ]
    names = ["n_samples", "measure", "baseline", "comparison"]
    return pd.DataFrame(rows, columns=names)


def comparison_table(*found: Estimate) -> pd.DataFrame:
    """Show comparisons one below the other.

    Parameters
    ----------
    *found : Estimate
        The charts with other methods, on one training set.

    Returns
    -------
    DataFrame
        One row a comparison; the last column is as in `ratio_table`.
    """
    rows = [(one.label, one.baseline, _cell(one)) for one in found]
    names = ["measure", "charts over", "ratio [95 % interval]"]
    return pd.DataFrame(rows, columns=names).set_index("measure")


def ratio_table(
    *studies: dict[str, Any],
    measures: Sequence[str],
    baselines: Sequence[str] = BASELINES,
    design: str = "even",
    method: str = "charts",
) -> pd.DataFrame:
    """Show the charts' errors over other methods', size by size, with intervals.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    measures : sequence of str
        Which errors.
    baselines : sequence of str, default=BASELINES
        The other methods.
    design : {"even", "uniform", "nonuniform"}, default="even"
        How training tasks were drawn.
    method : {"charts", "charts, Matérn"}, default="charts"
        Which charts.

    Returns
    -------
    DataFrame
        One row a number of training tasks; one column a world, measure and baseline,
        as "ratio [low, high]" and a sign: ● lower, ✕ higher, ○ undecided.
    """
    columns = {}
    for study in studies:
        cells = compare_cells(study, design, method=method)
        for measure in measures:
            for baseline in baselines:
                chosen = (cells["measure"] == measure) & (cells["baseline"] == baseline)
                here = cells[chosen].set_index("n_samples")["comparison"]
                shown = PLAIN.get(measure, measure.replace("mse", "MSE"))
                place = WORLD_TITLES[study["workspace"]], shown, baseline
                columns[place] = here.map(_cell)
    table = pd.DataFrame(columns).rename_axis("training tasks").fillna("–")
    table.columns = table.columns.set_names(["", "", f"{method} over"])
    many = [len({place[level] for place in columns}) > 1 for level in range(3)]
    single: list[Any] = [level for level in (0, 1) if not many[level]]
    return table.droplevel(single, axis=1)


def kernel_table(
    *studies: dict[str, Any], measure: str = "mse, gate learned"
) -> pd.DataFrame:
    """Show the charts' errors over the single regression's, by their kernels.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    measure : str, default="mse, gate learned"
        Which error.

    Returns
    -------
    DataFrame
        One row a number of training tasks, evenly spaced; for each world both with a
        squared exponential kernel, both with a Matérn kernel, and the former charts
        over the latter regression; cells as in `ratio_table`.
    """
    pairs = {
        "both smooth": ("charts", "single regression"),
        "both rough": ("charts, Matérn", "single, Matérn"),
        "charts smooth, single rough": ("charts", "single, Matérn"),
    }
    tables = {
        (WORLD_TITLES[study["workspace"]], kernels): ratio_table(
            study, measures=[measure], baselines=[baseline], method=method
        )[baseline]
        for study in studies
        for kernels, (method, baseline) in pairs.items()
    }
    table = pd.DataFrame(tables).rename_axis("training tasks")
    return table.droplevel(0, axis=1) if len(studies) == 1 else table


def sets_table(
    study: dict[str, Any],
    n_samples: int,
    *,
    measures: Sequence[str],
    methods: Sequence[str] = ("charts", "single regression"),
) -> pd.DataFrame:
    """Show where the evenly spaced set that begins at 0° stands among all others.

    Parameters
    ----------
    study : dict
        Results of a study.
    n_samples : int
        Number of training tasks.
    measures : sequence of str
        Which errors.
    methods : sequence of str, default=("charts", "single regression")
        Whose.

    Returns
    -------
    DataFrame
        One row a measure and method: its mean error on the set that the figures draw,
        its rank among the sets of this size, the lowest first, and the lowest, median
        and highest error of any.
    """
    cell = find_cell(study, "even", n_samples)
    tasks, n_draws = load_dataset(study["workspace"])[0], cell["repetitions"]
    sets = draw_samples("even", tasks, n_samples, n_draws=n_draws, seed=study["seed"])
    drawn = [chosen[0] for chosen in sets].index(0)
    rows = {}
    for measure in measures:
        for method in methods:
            errors = pd.Series(cell["measures"][measure][method]["per_repetition"])
            rank = f"{errors.rank(method='min')[drawn]:.0f} of {n_draws}"
            first, *bounds = map(
                "{:.3g}".format, [errors[drawn], *errors.quantile([0, 0.5, 1])]
            )
            rows[PLAIN.get(measure, measure), method] = [first, rank, *bounds]
    names = ["set drawn", "its rank", "lowest", "median", "highest"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=names)
    table.index = pd.MultiIndex.from_tuples(table.index, names=["", "of all sets"])
    return table


def gate_shares(*studies: dict[str, Any]) -> pd.DataFrame:
    """Split the charts' squared error into the regression's part and the gate's.

    Parameters
    ----------
    *studies : dict
        Results of studies.

    Returns
    -------
    DataFrame
        One row a number of training tasks, evenly spaced. For each world the mean
        squared error with the chart known, and what the learned gate adds to it, in
        percent of the whole.
    """
    columns = {}
    for study in studies:
        cells = [cell for cell in study["cells"] if cell["design"] == "even"]
        sizes = [cell["n_samples"] for cell in cells]
        known, learned = (
            pd.Series(
                [cell["measures"][f"mse, {way}"]["charts"]["mean"] for cell in cells],
                sizes,
            )
            for way in ("chart known", "gate learned")
        )
        world = WORLD_TITLES[study["workspace"]]
        columns[world, "regression (MSE, chart known)"] = known
        columns[world, "the gate's share (%)"] = 100 * (1 - known / learned)
    return pd.DataFrame(columns).rename_axis("training tasks")


def _cell(found: Estimate) -> str:
    """Write a comparison into a cell, which breaks before the interval, if at all."""
    ratio, low, high = (rounded(one, 2) for one in (found.value, *found.bounds))
    return f"{SIGNS[found.verdict]}\N{NBSP}{ratio} [{low},\N{NBSP}{high}]"
