"""All methods, by world, measure and number of training tasks, sorted and filtered.

A `Leaderboard` shows itself as HTML with a table, `leaderboard.js` and its numbers
inline, and as a picture where there is no script.
"""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from msc.estimates import Estimate, rounded
from msc.plots._ratios import draw_ratio
from msc.plots._style import COLOURS, SMALL, encode_png, styled
from msc.plots._tables import SIGNS, WORLD_TITLES, Stored
from msc.study import MEASURES, METHODS, find_cell

_SCRIPT = Path(__file__).with_name("leaderboard.js")
LISTED = (
    "mse, gate learned",
    "standardised mse, gate learned",
    "error_cm",
    "excess_cost",
)
SIZES = (12, 24, 50)
GROUPS = {  # as in `METHODS`, and what a page says
    "paper": "the paper's",
    "no learning": "no learning",
    "variants": "one part exchanged",
    "one kernel": "one kernel for all weights",
    "section V": "the paper's related work",
    "today": "what one would pick today",
    "rollouts": "with rollouts of their own",
    "projected": "projected onto the goal",
    "ladder": "charts known in part",
    "choices": "another choice for the charts",
}
# Of the groups: what knows more than a rival may, and what is nearly the charts again.
APART = ("projected", "ladder", "choices")
_UNKNOWN = "of another version"
_HEADS = (  # what a column is sorted by, if by anything; what is above it
    ("name", "method", "kind"),
    ("", "training sets, and their mean", ""),
    ("mean", "mean", "range (sets)"),
    ("ratio", "charts over it", "95 % interval"),
)


def list_methods(study: Stored, measure: str, n_samples: int) -> list[dict[str, Any]]:
    """List methods with their means, the least first, those without one last.

    Parameters
    ----------
    study : dict
        Results of a study.
    measure : str
        A key of `msc.study.MEASURES`.
    n_samples : int
        Evenly spaced training tasks.

    Returns
    -------
    list of dict
        For every method, tried or not: its "name" and "group" (its kind, in words);
        "mean" and, in words, "told", or why there is none; "sets", the means of single
        training sets, and in words their "range"; "ratio", the charts' mean over its
        own on the sets that both have, and "against", the same with a sign and the
        interval in words. What is not there is None or empty.
    """
    cell = find_cell(study, "even", n_samples)
    means = cell["measures"].get(measure, {})
    ratios = {
        one["baseline"]: Estimate.read(one, "ratio")
        for one in cell["ratios"]
        if (one["measure"], one["method"]) == (measure, "charts")
    }
    wanted = (name for name, method in METHODS.items() if method.group in GROUPS)
    rows = []
    for name in dict.fromkeys([*wanted, *means]):
        found = means.get(name, {})
        row: dict[str, Any] = {"name": name, "group": _kind(name)}
        row |= {"mean": found.get("mean"), "sets": [], "range": ""}
        if row["mean"] is None:
            row["told"] = _tell_why(study, name, n_samples)
        else:
            row |= {"told": _two(row["mean"]), "sets": _short(found)}
            ends = dict.fromkeys(map(_two, (min(row["sets"]), max(row["sets"]))))
            row["range"] = f"{'–'.join(ends)} ({len(row['sets'])})"
        row |= {"ratio": None, "against": "", "interval": ""}
        if name in ratios:
            one = ratios[name]
            row |= one.stored("ratio")
            row["against"] = f"{SIGNS[one.verdict]} {_two(one.value)} ×"
            row["interval"] = f"[{', '.join(map(_two, one.bounds))}]"
        rows.append(row)
    return sorted(rows, key=lambda row: np.inf if row["mean"] is None else row["mean"])


def _kind(name: str) -> str:
    """Return a method's group as a page says it."""
    return GROUPS[METHODS[name].group] if name in METHODS else _UNKNOWN


def _short(found: dict[str, Any]) -> list[float]:
    """Return the means of single training sets, to as many digits as a screen shows."""
    return [float(f"{value:.3g}") for value in found["per_repetition"]]


def _two(number: float) -> str:
    """Write two digits, of a number beside one more, without an exponent if it can be.

    >>> _two(832.1), _two(0.9968)
    ('830', '0.997')
    """
    return f"{float(rounded(number, 2)):g}"


def _tell_why(study: Stored, name: str, n_samples: int) -> str:
    """Say why a method has no mean."""
    start = f"even/{n_samples}/"
    reasons = study.get("failed", {}).get(name, {})
    if failed := sum(key.startswith(start) for key in reasons):
        return f"failed on {failed} {'set' if failed == 1 else 'sets'}"
    tried = {
        cell["n_samples"]
        for cell in study["cells"]
        if any(name in by_method for by_method in cell["measures"].values())
    }
    if n_samples in tried:
        return "failed"
    return "not tried at this n" if tried else "no results yet"


@styled
def plot_leaderboard(
    study: Stored,
    *,
    measure: str = "error_cm",
    n_samples: int = 24,
    apart: Sequence[str] = APART,
) -> Figure:
    """Draw all methods' means, the least on top, and the charts over them.

    Parameters
    ----------
    study : dict
        Results of a study.
    measure : str, default="error_cm"
        A key of `msc.study.MEASURES`.
    n_samples : int, default=24
        Evenly spaced training tasks.
    apart : sequence of str, default=("projected", "ladder", "choices")
        Groups of methods that are left out.

    Returns
    -------
    Figure
        A row a method. Left a tick a training set and a dot for their mean, or why
        there is none; right the charts' mean over its own, with the interval, the
        mark as in `ratio_table`.
    """
    out = {GROUPS[group] for group in apart}
    rows = [r for r in list_methods(study, measure, n_samples) if r["group"] not in out]
    height = 1.1 + 0.19 * len(rows)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(7.4, height), sharey=True, width_ratios=(5, 4)
    )
    for place, row in enumerate(rows):
        ours = row["group"] == GROUPS["paper"]
        _draw_row(left, -place, row, COLOURS["charts"] if ours else "0.35")
        if row["ratio"] is not None:
            draw_ratio(right, -place, Estimate.read(row, "ratio"))
    left.set_yticks(-np.arange(len(rows)), [r["name"] for r in rows], fontsize=SMALL)
    left.set(xscale="log", ylim=(0.6 - len(rows), 0.6))
    left.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=9))
    left.xaxis.set_major_formatter("{x:g}")
    left.xaxis.set_minor_locator(NullLocator())
    left.set_xlabel(MEASURES[measure].label)
    left.set_title("in this world", loc="left")
    right.axvline(1, color="0.3", lw=1, ls="--")
    right.set(xscale="log", xlim=(1 / 300, 300), xlabel="charts' mean over its own")
    right.xaxis.set_major_formatter("{x:g}")
    right.set_title("against the charts, 95 % interval", loc="left")
    title = f"{WORLD_TITLES[study['workspace']]}, {n_samples} training tasks"
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def _draw_row(axis: Axes, place: float, row: dict[str, Any], colour: str) -> None:
    """Draw a method's training sets and their mean, or write why there is none."""
    if row["mean"] is None:
        more: Any = {"va": "center", "fontsize": SMALL, "color": "0.4"}
        more |= {"transform": axis.get_yaxis_transform()}
        axis.text(0.01, place, row["told"], **more)
        return
    ticks: Any = {"ls": "", "marker": "|", "ms": 6, "mew": 0.8, "alpha": 0.7}
    axis.plot(row["sets"], [place] * len(row["sets"]), color=colour, **ticks)
    axis.plot(row["mean"], place, color=colour, marker="o", ms=4)


def standings_table(
    *studies: Stored, method: str = "charts", apart: Sequence[str] = APART
) -> pd.DataFrame:
    """Show who is first in each cell, and where the charts are.

    Parameters
    ----------
    *studies : dict
        Results of studies.
    method : str, default="charts"
        Whose place is told.
    apart : sequence of str, default=("projected", "ladder", "choices")
        Groups of methods that are left out.

    Returns
    -------
    DataFrame
        One row a world, measure and number of training tasks: the method that errs
        less than most others, the place of `method`, of how many that have a mean, and
        to how many others the charts' ratio is lower (●), undecided (○) and higher (✕).
        Two methods are compared by their means over the training sets that both have.
    """
    out, rows = {GROUPS[group] for group in apart}, {}
    for study, measure, n in product(studies, LISTED, SIZES):
        cell = WORLD_TITLES[study["workspace"]], MEASURES[measure].label, n
        listed = [
            row
            for row in list_methods(study, measure, n)
            if row["mean"] is not None and row["group"] not in out
        ]
        names = [row["name"] for row in listed]
        found = find_cell(study, "even", n)["measures"][measure]
        ahead = _count_ahead({name: found[name]["per_repetition"] for name in names})
        places = {"first": ahead.idxmin(), "place": int(ahead[method]) + 1}
        signs = [row["against"][:1] for row in listed]
        counts = {sign: signs.count(sign) for sign in SIGNS.values()}
        rows[cell] = places | {"of": len(names)} | counts
    table = pd.DataFrame.from_dict(rows, orient="index")
    table.index = pd.MultiIndex.from_tuples(rows, names=["world", "measure", "n"])
    return table


def _count_ahead(per_set: Mapping[str, Sequence[float]]) -> pd.Series[int]:
    """Count the methods that err less than each, on the first sets, which both have."""

    def errs_less(one: Sequence[float], other: Sequence[float]) -> bool:
        n_sets = min(len(one), len(other))
        return float(np.mean(one[:n_sets])) < float(np.mean(other[:n_sets]))

    return pd.Series(
        {
            name: sum(errs_less(other, own) for other in per_set.values())
            for name, own in per_set.items()
        }
    )


@dataclass(frozen=True)
class Leaderboard:
    """A table of all methods that a page sorts and filters.

    Parameters
    ----------
    studies : sequence of dict
        Results of studies.
    poster : Figure
        The picture in place of it.
    """

    studies: Sequence[Stored]
    poster: Figure

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        """Show the page's HTML, or the poster where there is none."""
        image = encode_png(self.poster)
        return {
            "text/html": self.to_html(image),
            "image/png": image,
            "text/plain": "all methods, sorted by their means",
        }

    def to_html(self, image: str) -> str:
        """Write a piece of HTML that needs no other file.

        Parameters
        ----------
        image : str
            The poster (PNG, base 64).

        Returns
        -------
        str
            The piece.
        """
        worlds = {
            one["workspace"]: WORLD_TITLES[one["workspace"]] for one in self.studies
        }
        measures = {key: MEASURES[key].label for key in LISTED}
        options = (
            _select("world", worlds, [*worlds][-1]),
            _select("measure", measures, "error_cm"),
            _select("training tasks", {f"{n}": f"{n}" for n in SIZES}, "24"),
        )
        data = self._data()
        there = {row["group"] for rows in data.values() for row in rows}
        kinds = {name: name in APART for name in GROUPS}
        boxes = "".join(
            _box(GROUPS.get(name, name), not off)
            for name, off in (kinds | {_UNKNOWN: False}).items()
            if GROUPS.get(name, name) in there
        )
        heads = "".join(
            f'<th scope="col"><button type="button" value="{key}">{text}</button>'
            f"<small>{more}</small></th>"
            if key
            else f'<th scope="col">{text}<div class="msc-axis"></div></th>'
            for key, text, more in _HEADS
        )
        text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
        return (
            '<div class="msc-leaderboard">'
            '<img class="msc-poster" alt="All methods, sorted by their means" '
            f'src="data:image/png;base64,{image}">'
            f'<div class="msc-controls">{"".join(options)}</div>'
            f'<fieldset class="msc-controls msc-groups"><legend>kinds</legend>{boxes}'
            '</fieldset><p class="msc-told" role="status"></p><table><thead><tr>'
            '<td></td><th scope="colgroup" colspan="2">in this world</th>'
            '<th scope="colgroup">against the charts</th></tr>'
            f"<tr>{heads}</tr></thead><tbody></tbody></table></div>"
            f"<script>({_SCRIPT.read_text(encoding='utf-8').strip()})"
            "(document.currentScript.previousElementSibling,"
            f"{text.replace('<', chr(92) + 'u003c')});</script>"
        )

    def _data(self) -> dict[str, list[dict[str, Any]]]:
        """Return the rows by world, measure and number of training tasks."""
        return {
            f"{study['workspace']}/{measure}/{n}": list_methods(study, measure, n)
            for study in self.studies
            for measure in LISTED
            for n in SIZES
        }


def _select(label: str, options: dict[str, str], chosen: str) -> str:
    """Write a list to choose from."""
    inner = "".join(
        f'<option value="{html.escape(key)}"{" selected" * (key == chosen)}>'
        f"{html.escape(text)}</option>"
        for key, text in options.items()
    )
    return f'<label>{label} <select autocomplete="off">{inner}</select></label>'


def _box(name: str, is_on: bool) -> str:
    """Write a box to tick."""
    text = html.escape(name)
    return (
        f'<label><input type="checkbox" value="{text}" autocomplete="off"'
        f"{' checked' * is_on}> {text}</label>"
    )
