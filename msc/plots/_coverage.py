"""How often intervals hold the truth: the file of `benchmarks/coverage.py`, shown."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from msc.plots._style import COUNT_STYLES, TRIO, styled

GOOD_COVERAGE = 0.92, 0.98  # of an interval that is to hold the truth in 95 %

_WANTED = 0.95
_MANY = 15  # training sets, of which length and power are shown

Simulated = Mapping[str, Any]  # the benchmark's file


@styled
def plot_coverage(found: Simulated) -> Figure:
    """Draw how often each kind of interval holds the truth, and how long it is.

    Parameters
    ----------
    found : mapping
        What `load_results` gives for "coverage".

    Returns
    -------
    Figure
        One row a kind of interval. Left, each condition is a mark: as the interval is,
        and stretched; the band is `GOOD_COVERAGE`. Right, the median length of the
        stretched interval, by how much two methods' errors have in common.
    """
    rows = pd.DataFrame(found["main"])
    kinds = [*rows["interval"].unique()][::-1]
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.6), sharey=True)
    for wider, some in rows.groupby("wider"):
        look: Any = {"color": "0.55", "marker": "o", "label": "as it is"}
        if wider != 1:
            label = f"stretched, {wider:g} ×"
            look = {"color": TRIO[0], "marker": "s", "label": label}
        _mark(left, some["coverage"], some["interval"].map(kinds.index), **look)
    _show_good(left)
    left.set_yticks(range(len(kinds)), kinds)
    left.set_ylim(-0.5, len(kinds) - 0.5)
    lengths = rows[(rows["wider"] != 1) & (rows["sets"] == _MANY)]
    by = lengths.groupby("correlation")
    for (correlation, some), style in zip(by, COUNT_STYLES, strict=True):
        look = {**style, "ls": "", "label": f"correlation {correlation:g}"}
        medians = some.groupby("interval")["length"].median()
        right.plot(medians, medians.index.map(kinds.index), ms=5, **look)
    right.set(xscale="log", xlabel="length, stretched (upper / lower end)")
    right.set_title("how long?", loc="left")
    for axis in (left, right):
        _legend_below(axis)
    return figure


@styled
def plot_other_coverage(found: Simulated) -> Figure:
    """Draw how often intervals hold the truth where errors are not as measured.

    Parameters
    ----------
    found : mapping
        What `load_results` gives for "coverage".

    Returns
    -------
    Figure
        One row a condition: the interval of this book, and the bootstrap it replaced.
    """
    rows = pd.DataFrame(found["others"])
    names = [*rows["condition"].unique()][::-1]
    chosen = rows[(rows["interval"] == found["chosen"]) & (rows["wider"] != 1)]
    before = rows[(rows["interval"] == found["before"]) & (rows["wider"] == 1)]
    figure, axis = plt.subplots(figsize=(6.4, 4.2))
    for some, look in (
        (before, {"color": TRIO[1], "marker": "^", "label": "before"}),
        (chosen, {"color": TRIO[0], "marker": "s", "label": "now"}),
    ):
        _mark(axis, some["coverage"], some["condition"].map(names.index), **look)
    _show_good(axis)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(-0.5, len(names) - 0.5)
    _legend_below(axis)
    return figure


def _mark(axis: Axes, shares: pd.Series, places: pd.Series, **look: Any) -> None:
    """Draw marks, those of a row a little apart."""
    turn = shares.groupby(places).cumcount() / places.value_counts().max()
    axis.plot(shares, places + 0.5 * (0.5 - turn), ls="", ms=3.5, **look)


def _show_good(axis: Axes) -> None:
    """Show what an interval should do."""
    axis.axvspan(*GOOD_COVERAGE, color="0.9", zorder=0)
    axis.axvline(_WANTED, color="0.3", lw=1, ls="--", zorder=0.5)
    axis.set(xlim=(0, 1), xlabel="studies whose interval holds the truth")
    axis.xaxis.set_major_formatter(PercentFormatter(1))
    axis.set_title("how often?", loc="left")


def _legend_below(axis: Axes) -> None:
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)


def coverage_table(found: Simulated) -> pd.DataFrame:
    """List how often intervals hold the truth, how long they are, what they decide.

    Parameters
    ----------
    found : mapping
        What `load_results` gives for "coverage".

    Returns
    -------
    DataFrame
        As text, one row a kind of interval, as it is and stretched: the lowest and the
        highest coverage of all main conditions; of fifteen training sets, for each
        correlation of the methods in turn, the length (upper over lower end) and the
        share of intervals that exclude 1, by the true ratio.
    """
    rows = pd.DataFrame(found["main"]).sort_values("correlation", kind="stable")
    columns: dict[Any, dict[str, str]] = {}
    for kind, wider in product(rows["interval"].unique(), rows["wider"].unique()):
        some = rows[(rows["interval"] == kind) & (rows["wider"] == wider)]
        least, most = some["coverage"].min(), some["coverage"].max()
        usual = some[some["sets"] == _MANY]
        same = usual[usual["ratio"] == 1]
        columns[kind, f"{wider:g} ×"] = {
            "coverage": f"{least:.1%} to {most:.1%}",
            "length": " / ".join(f"{one:,.3g}" for one in same["length"]),
            **{
                f"decides at {ratio:g}": " / ".join(f"{one:.0%}" for one in by["power"])
                for ratio, by in usual.groupby("ratio", sort=False)
            },
        }
    return pd.DataFrame(columns).T.rename_axis(["interval", "as long"])
