"""All methods, by world, measure and number of training tasks, sorted and filtered.

A `Leaderboard` shows itself as HTML with a table, `leaderboard.js` and its numbers
inline, and as a picture where there is no script.
"""

from __future__ import annotations

import base64
import html
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from msc.estimates import Estimate, rounded
from msc.plots._style import SMALL, styled
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
_GROUPS = {  # as in `METHODS`, and what a page says
    "paper": "the paper's",
    "no learning": "no learning",
    "variants": "one part exchanged",
    "one kernel": "one kernel for all weights",
    "projected": "projected onto the goal",
    "section V": "the paper's related work",
    "today": "what one would pick today",
    "rollouts": "with rollouts of their own",
    "ladder": "charts known in part",
}


def list_methods(study: Stored, measure: str, n_samples: int) -> list[dict[str, Any]]:
    """List methods with their means, the least first, failed ones last.

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
        Name, group, mean with its interval, both in words ("told"), and a sign and the
        charts' mean as a multiple of it ("against").
    """
    cell = find_cell(study, "even", n_samples)
    ratios = {
        one["baseline"]: Estimate.read(one, "ratio")
        for one in cell["ratios"]
        if (one["measure"], one["method"]) == (measure, "charts")
    }
    rows = []
    for name, found in cell["measures"][measure].items():
        mean = found["mean"]
        row = {"name": name, "group": _GROUPS[METHODS[name].group]}
        row |= {key: found[key] for key in ("mean", "low", "high")}
        told = "failed" if mean is None else f"{Estimate.read(found, 'mean')}"
        against = ""
        if name in ratios:
            ratio = ratios[name]
            against = f"{SIGNS[ratio.verdict]} {rounded(ratio.value, 2)} ×"
        rows.append(row | {"told": told, "against": against})
    return sorted(rows, key=lambda row: np.inf if row["mean"] is None else row["mean"])


@styled
def plot_leaderboard(
    study: Stored, *, measure: str = "error_cm", n_samples: int = 24
) -> Figure:
    """Draw all methods' means with their intervals, the least on top.

    Parameters
    ----------
    study : dict
        Results of a study.
    measure : str, default="error_cm"
        A key of `msc.study.MEASURES`.
    n_samples : int, default=24
        Evenly spaced training tasks.

    Returns
    -------
    Figure
        A row a method.
    """
    rows = [row for row in list_methods(study, measure, n_samples) if row["mean"]]
    means = np.array([row["mean"] for row in rows])
    spans = np.abs([[row["low"], row["high"]] for row in rows] - means[:, None]).T
    places = -np.arange(len(rows))
    figure, axis = plt.subplots(figsize=(7.4, 1 + 0.19 * len(rows)))
    ours = np.array([METHODS[row["name"]].group == "paper" for row in rows])
    for chosen, colour in ((ours, "#00467F"), (~ours, "0.45")):
        look: Any = {"color": colour, "ls": "", "marker": "o", "ms": 4}
        axis.errorbar(means[chosen], places[chosen], xerr=spans[:, chosen], **look)
    axis.set_yticks(places, [row["name"] for row in rows], fontsize=SMALL)
    axis.set(xscale="log", xlim=(means.min() / 3, means.max() * 3))
    axis.set_xlabel(MEASURES[measure].label)
    title = f"{WORLD_TITLES[study['workspace']]}, {n_samples} training tasks"
    axis.set_title(title, loc="left")
    return figure


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
        file = io.BytesIO()
        self.poster.savefig(file, format="png", dpi=110, metadata={"Software": None})
        image = base64.b64encode(file.getvalue()).decode()
        return {
            "text/html": self.to_html(image),
            "image/png": image,
            "text/plain": "all methods, sorted by their means",
        }

    def to_html(self, image: str) -> str:
        """Write a piece of HTML that needs no other file, with the poster."""
        worlds = {
            one["workspace"]: WORLD_TITLES[one["workspace"]] for one in self.studies
        }
        options = (
            _select("world", worlds),
            _select(
                "measure", {key: MEASURES[key].label for key in LISTED}, "error_cm"
            ),
            _select("training tasks", {f"{n}": f"{n}" for n in SIZES}, "24"),
        )
        boxes = "".join(
            f'<label><input type="checkbox" value="{html.escape(name)}" checked> '
            f"{html.escape(name)}</label>"
            for name in _GROUPS.values()
        )
        heads = "".join(
            f'<th scope="col"><button type="button" value="{key}">{text}</button></th>'
            if key
            else f'<th scope="col">{text}</th>'
            for key, text in (
                ("name", "method"),
                ("group", "kind"),
                ("", "mean and 95 % interval, logarithmic"),
                ("mean", "mean"),
                ("", "charts over it"),
            )
        )
        text = json.dumps(self._data(), separators=(",", ":"), ensure_ascii=False)
        return (
            '<div class="msc-leaderboard">'
            f'<img class="msc-poster" alt="All methods, sorted by their means" '
            f'src="data:image/png;base64,{image}">'
            f'<div class="msc-controls">{"".join(options)}</div>'
            f'<div class="msc-controls msc-groups">{boxes}</div>'
            f"<table><thead><tr>{heads}</tr></thead><tbody></tbody></table></div>"
            f"<script>({_SCRIPT.read_text(encoding='utf-8').strip()})"
            "(document.currentScript.previousElementSibling,"
            f"{text.replace('<', chr(92) + 'u003c')});</script>"
        )

    def _data(self) -> dict[str, Any]:
        """Return the rows by world, measure and number of training tasks."""
        return {
            f"{study['workspace']}/{measure}/{n}": list_methods(study, measure, n)
            for study in self.studies
            for measure in LISTED
            for n in SIZES
        }


def _select(label: str, options: dict[str, str], chosen: str = "") -> str:
    """Write a list to choose from."""
    inner = "".join(
        f'<option value="{html.escape(key)}"{" selected" * (key == chosen)}>'
        f"{html.escape(text)}</option>"
        for key, text in options.items()
    )
    return f"<label>{label} <select>{inner}</select></label>"
