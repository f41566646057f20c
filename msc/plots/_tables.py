"""Tables of what was stored, as the chapters show them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msc.data import load_dataset
from msc.estimates import Estimate, rounded
from msc.learn import SELECTION_CRITERIA
from msc.study import (
    MEASURES,
    count_ahead,
    draw_samples,
    find_cell,
    most_picked,
)

WORLD_TITLES = {"free": "without obstacles", "obstacles": "with obstacles"}
SIGNS = {"lower": "●", "undecided": "○", "higher": "✕"}  # of the charts' error
BASELINES = ("single regression", "CrKr", "nearest neighbour")
PAPER_N_CHARTS = 4  # in either workspace

Stored = dict[str, Any]  # a file of `data/results`


def lay_out(
    columns: Mapping[Any, Any] | pd.DataFrame, rows: str | None = None
) -> pd.DataFrame:
    """Write the numbers of a table, with their intervals if they have one.

    Cells are text, numbers, ratios that `compare` gives, mappings with ``"median"``,
    ``"low"`` and ``"high"``, or None for what was left out; `rows` says what rows are.
    """
    whole = {head: pd.Series(column, dtype=object) for head, column in columns.items()}
    table = pd.DataFrame(whole).map(_write)  # objects: a number may stay whole
    return table if rows is None else table.rename_axis(rows)


def _write(cell: Any) -> str:
    """Write a cell, see `lay_out`; a ratio breaks before its interval, if at all."""
    if cell is None:
        return "left out"
    if isinstance(cell, str):
        return cell
    if isinstance(cell, Estimate):
        return write_ratio(cell)
    if isinstance(cell, Mapping):
        timed = (_digits(cell[key]) for key in ("median", "low", "high"))
        return "{} ({}–{})".format(*timed)
    return "–" if np.isnan(cell) else _digits(cell)  # NaN: other rows have a result


def write_ratio(one: Estimate) -> str:
    """Write a ratio, its sign before it and its interval behind it, to two digits."""
    low, high = one.bounds
    value, least, most = (f"{float(rounded(x, 2)):g}" for x in (one.value, low, high))
    least = "<0.001" if 0 < low < 0.001 else least
    most = ">1000" if high > 1000 else most
    ratio = f"{SIGNS[one.verdict]}\N{NBSP}{value}"
    return f"{ratio} [{least},\N{NBSP}{most}]"


def _digits(number: float) -> str:
    """Write three digits, of a large number all before the point."""
    if isinstance(number, Integral) or number >= 100:
        return f"{number:,.0f}"
    return f"{number:#.3g}".rstrip(".")


def comparisons(
    study: Stored,
    measure: str,
    baseline: str,
    *,
    design: str = "even",
    method: str = "charts",
) -> dict[int, Estimate]:
    """Find the charts' error over a baseline's, by the number of training tasks."""
    return {
        cell["n_samples"]: Estimate.read(ratio, "ratio")
        for cell in study["cells"]
        if cell["design"] == design
        for ratio in cell["ratios"]
        if (ratio["measure"], ratio["baseline"]) == (measure, baseline)
        and ratio["method"] == method
    }


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
    columns = {
        "charts over": [one.baseline for one in found],
        "ratio [95 % interval]": found,
    }
    measures = pd.Index([one.label for one in found], name="measure")
    return lay_out(columns).set_index(measures)


def find_ratios(
    *studies: Stored,
    measures: Sequence[str],
    baselines: Sequence[str] = BASELINES,
    design: str = "even",
    method: str = "charts",
) -> pd.DataFrame:
    """Find the charts' errors over other methods', size by size.

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
        Estimates for `plot_ratios`: one row a number of training tasks; one column a
        world, measure and baseline, of which what all have in common is left out.
    """
    columns = {
        (WORLD_TITLES[study["workspace"]], MEASURES[measure].label, baseline): (
            comparisons(study, measure, baseline, design=design, method=method)
        )
        for study in studies
        for measure in measures
        for baseline in baselines
    }
    table = _gather(columns)
    table.columns = table.columns.set_names(["", "", f"{method} over"])
    return _without_same(table)


def ratio_table(*studies: Stored, **wanted: Any) -> pd.DataFrame:
    """Show the charts' errors over other methods', size by size, with intervals.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    **wanted
        As `find_ratios` takes them.

    Returns
    -------
    DataFrame
        The table of `find_ratios`, each ratio as "ratio [low, high]" and a sign: ●
        lower, ✕ higher, ○ undecided.
    """
    return write_ratios(find_ratios(*studies, **wanted))


def find_kernel_ratios(
    *studies: Stored, measure: str = "mse, gate learned"
) -> pd.DataFrame:
    """Find the charts' errors over the single regression's, by their kernels.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    measure : str, default="mse, gate learned"
        Which error.

    Returns
    -------
    DataFrame
        Estimates for `plot_ratios`: one row a number of training tasks, evenly spaced;
        for each world both with a squared exponential kernel, both with a Matérn
        kernel, and the former charts over the latter regression.
    """
    pairs = {
        "both smooth": ("charts", "single regression"),
        "both rough": ("charts, Matérn", "single, Matérn"),
        "charts smooth, single rough": ("charts", "single, Matérn"),
    }
    columns = {
        (WORLD_TITLES[study["workspace"]], kernels): (
            comparisons(study, measure, baseline, method=method)
        )
        for study in studies
        for kernels, (method, baseline) in pairs.items()
    }
    return _without_same(_gather(columns))


def kernel_table(*studies: Stored, **wanted: Any) -> pd.DataFrame:
    """Show the charts' errors over the single regression's, by their kernels.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    **wanted
        As `find_kernel_ratios` takes them.

    Returns
    -------
    DataFrame
        The table of `find_kernel_ratios`, cells as in `ratio_table`.
    """
    return write_ratios(find_kernel_ratios(*studies, **wanted))


def write_ratios(ratios: pd.DataFrame) -> pd.DataFrame:
    """Write ratios and their intervals in figures.

    Parameters
    ----------
    ratios : DataFrame
        Estimates, as `find_ratios` returns them.

    Returns
    -------
    DataFrame
        Cells as in `ratio_table`; "–" where there is no ratio.
    """
    return ratios.map(_write)


def _gather(columns: Mapping[Any, Mapping[int, Estimate]]) -> pd.DataFrame:
    """Put ratios by training tasks beside one another."""
    whole = {head: pd.Series(column, dtype=object) for head, column in columns.items()}
    return pd.DataFrame(whole).rename_axis("training tasks")


def _without_same(table: pd.DataFrame) -> pd.DataFrame:
    """Leave out the heads, the lowest excepted, that all columns have in common."""
    heads: Any = table.columns
    same: list[Any] = [k for k, size in enumerate(heads.levshape[:-1]) if size == 1]
    return table.droplevel(same, axis=1)


def sets_table(
    study: Stored,
    chosen: ArrayLike,
    *,
    measures: Sequence[str],
    methods: Sequence[str] = ("charts", "single regression"),
) -> pd.DataFrame:
    """Show where an evenly spaced training set stands among all others of its size.

    Parameters
    ----------
    study : dict
        Results of a study.
    chosen : array_like of int
        Indices of the set's tasks, ascending, as `msc.study.pick_typical_set` returns
        them.
    measures : sequence of str
        Which errors.
    methods : sequence of str, default=("charts", "single regression")
        Whose.

    Returns
    -------
    DataFrame
        One row a measure and method: its mean error on the set, its rank among the sets
        of this size, the lowest first, and the lowest, median and highest error of any;
        of two methods also a row with the ratio of the first's to the second's.

    Raises
    ------
    ValueError
        If the study kept no such set.
    """
    indices = np.asarray(chosen).tolist()
    cell = find_cell(study, "even", len(indices))
    tasks, n_draws = load_dataset(study["workspace"])[0], cell["repetitions"]
    more: Any = {"n_draws": n_draws, "seed": study["seed"]}
    sets = [s.tolist() for s in draw_samples("even", tasks, len(indices), **more)]
    if indices not in sets:
        raise ValueError(f"chosen={indices}; wanted one of the study's {n_draws} sets")
    drawn, rows = sets.index(indices), {}
    for measure in measures:
        found = cell["measures"][measure]
        errors = {name: pd.Series(found[name]["per_repetition"]) for name in methods}
        if len(methods) == 2:
            one, other = methods
            errors["their ratio"] = errors[one] / errors[other]
        for name, values in errors.items():
            rank = f"{values.rank(method='min')[drawn]:.0f} of {n_draws}"
            told = values[drawn], *values.quantile([0, 0.5, 1])
            first, *bounds = map("{:.3g}".format, told)
            rows[MEASURES[measure].label, name] = [first, rank, *bounds]
    names = ["set drawn", "its rank", "lowest", "median", "highest"]
    table = pd.DataFrame.from_dict(rows, orient="index", columns=names)
    table.index = pd.MultiIndex.from_tuples(rows, names=["", "of all sets"])
    return table


def ahead_table(
    study: Stored,
    n_samples: int,
    *,
    measures: Sequence[str],
    baselines: Sequence[str] = BASELINES,
) -> pd.DataFrame:
    """Count the evenly spaced training sets on which charts err less than others.

    Parameters
    ----------
    study : dict
        Results of a study.
    n_samples : int
        Number of training tasks.
    measures : sequence of str
        Which errors.
    baselines : sequence of str, default=BASELINES
        The other methods.

    Returns
    -------
    DataFrame
        One row a measure, one column a method, as "13 of 15".
    """
    cell = find_cell(study, "even", n_samples)
    rows = {
        MEASURES[measure].label: {
            name: "{} of {}".format(*count_ahead(cell, measure, "charts", name))
            for name in baselines
        }
        for measure in measures
    }
    return pd.DataFrame(rows).T.rename_axis(columns="charts below")


def gate_shares(*studies: Stored) -> pd.DataFrame:
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
        cells = {c["n_samples"]: c for c in study["cells"] if c["design"] == "even"}
        known, learned = (
            pd.Series(
                {n: c["measures"][name]["charts"]["mean"] for n, c in cells.items()}
            )
            for name in ("mse, chart known", "mse, gate learned")
        )
        world = WORLD_TITLES[study["workspace"]]
        columns[world, "regression (MSE, chart known)"] = known
        columns[world, "the gate's share (%)"] = 100 * (1 - known / learned)
    return pd.DataFrame(columns).rename_axis("training tasks")


def gate_table(*elbows: Stored) -> pd.DataFrame:
    """Show how often each gate tells a held-out task's chart.

    Parameters
    ----------
    *elbows : dict
        What `msc evaluate` wrote, one a workspace.

    Returns
    -------
    DataFrame
        One row a workspace and number of training tasks: the number of training sets,
        and for each gate its mean accuracy and on how many sets it is the best, ties
        going to the first.
    """
    rows = {}
    for measured in elbows:
        for found in measured["gates"]:
            accuracy, best = found["accuracy"], found["best"]
            rows[measured["workspace"], found["n_samples"]] = {
                "training sets": found["repetitions"],
                **{name: f"{accuracy[name]:.2f} ({best[name]})" for name in accuracy},
            }
    table = pd.DataFrame.from_dict(rows, orient="index")
    table.index = pd.MultiIndex.from_tuples(rows, names=["world", "training tasks"])
    return table


def elbow_table(*elbows: Stored, count: int = PAPER_N_CHARTS) -> pd.DataFrame:
    """List which number of charts every reading picks, and how firmly.

    Parameters
    ----------
    *elbows : dict
        What `msc evaluate` wrote, one a workspace.
    count : int, default=4
        The number whose share is told.

    Returns
    -------
    DataFrame
        One row a reading; for each workspace the number picked on all tasks, the share
        of the parts on which it picks `count`, and the number it picks most often with
        the share of that, the last number considered excepted.
    """
    worlds, heads = {}, ["picks", f"picks {count}", "most often"]
    for measured in elbows:
        rows = {}
        for name, label in SELECTION_CRITERIA.items():
            reading, (often, share) = (
                measured["readings"][name],
                most_picked(measured, name),
            )
            there = reading["resampled"].get(f"{count}", 0) / measured["n_resamples"]
            rows[label] = (
                f"{reading['picked']}",
                f"{there:.0%}",
                f"{often} ({share:.0%})",
            )
        table = pd.DataFrame.from_dict(rows, orient="index", columns=heads)
        worlds[measured["workspace"]] = table
    return pd.concat(worlds, axis=1)


def quality_table(*audits: Stored) -> pd.DataFrame:
    """Put the outcome of audits beside one another.

    Parameters
    ----------
    *audits : dict
        What `audit_table` returned.

    Returns
    -------
    DataFrame
        One column an audit.
    """
    from msc.study import COST_TOLERANCE  # noqa: PLC0415 (with it comes all that searches)

    columns = {}
    for audit in audits:
        executed, searched = audit["executed"], audit["searched"]
        changes = np.array(searched["change_of_cost"])
        found = {
            "policies": audit["n_tasks"],
            "executed again: identical distances": executed["identical"],
            "largest difference (m)": executed["largest_difference_m"],
            "searched again": len(changes),
            "cheaper by more than 0.5 %": searched["n_cheaper"],
            "largest gain (%)": round(100 * max(0.0, -changes.min()), 4),
            "not found again (dearer by more than 0.5 %)": int(
                (changes > COST_TOLERANCE).sum()
            ),
            "large steps, the cut's included": len(audit["jumps"]),
            "of these jumps": sum(jump["is_jump"] for jump in audit["jumps"]),
        }
        columns[audit["table"]] = pd.Series(found, dtype=object)
    return pd.DataFrame(columns)


def jump_table(audit: Stored) -> pd.DataFrame:
    """List the large steps that an audit bisected.

    Parameters
    ----------
    audit : dict
        What `audit_table` returned.

    Returns
    -------
    DataFrame
        One row a step: where (degrees), how large at first and at last, the verdict.
    """
    known = ["between_deg", "located_deg", "step_sizes", "is_jump"]
    jumps = pd.DataFrame(audit["jumps"], columns=known)
    between = "{0[0]:.10g} and {0[1]:.10g}"
    columns = {
        "after (degrees)": jumps["between_deg"].str[0],
        "located between (degrees)": jumps["located_deg"].map(between.format),
        "step": jumps["step_sizes"].str[0],
        "step there": jumps["step_sizes"].str[-1],
        "jump": jumps["is_jump"],
    }
    return pd.DataFrame(columns)


def confirmed_jumps(audit: Stored) -> list[int]:
    """Return where bisection confirmed a jump, that at the cut not counted.

    Parameters
    ----------
    audit : dict
        What `audit_table` returned, of a table whose tasks begin at 0°.

    Returns
    -------
    list of int
        Indices i of tasks for which the step to the next is a jump.

    Examples
    --------
    >>> steps = [([14.0, 15.0], True), ([93.0, 94.0], False), ([359.0, 360.0], True)]
    >>> jumps = [{"between_deg": at, "is_jump": found} for at, found in steps]
    >>> confirmed_jumps({"n_tasks": 360, "jumps": jumps})
    [14]
    """
    return [
        round(jump["between_deg"][0] * audit["n_tasks"] / 360)
        for jump in audit["jumps"]
        if jump["is_jump"] and jump["between_deg"][1] < 360
    ]
