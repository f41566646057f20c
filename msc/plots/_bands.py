"""How sure skills are, and what that is worth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from msc.estimates import Estimate
from msc.plots._style import SMALL, TRIO, styled

_KINDS = {
    "gaussian": (TRIO[0], "o", "Gaussian"),
    "conformal": (TRIO[1], "s", "conformal"),
}
_PLACES = {"away": "full", "beside": "none"}
_DOUBTS = {"std": "-", "gate": "--"}
_LEVEL = 0.9


@styled
def plot_bands(bands: Mapping[str, Any], level: float = _LEVEL) -> Figure:
    """Draw how often bands hold what was searched, and how good they are.

    Parameters
    ----------
    bands : dict
        Those of a family, as `msc.worlds.judge_bands` returned them.
    level : float, default=0.9
        How often they should.

    Returns
    -------
    Figure
        A row a method, in it a mark a kind of band and a place, filled away from jumps
        and hollow beside one, with intervals over worlds: left the share of weights
        held, right the interval score over the weight's spread, where less is better.
    """
    figure, axes = plt.subplots(
        1, 2, figsize=(7.4, 0.75 * len(bands) + 0.9), sharey=True
    )
    for row, of in enumerate(bands.values()):
        shifts = iter((-0.27, -0.09, 0.09, 0.27))
        for kind, (colour, marker, words) in _KINDS.items():
            for place, fill in _PLACES.items():
                told, at = of["bands"][kind][place], row + next(shifts)
                if not told:
                    continue
                look: dict[str, Any] = {"color": colour, "marker": marker}
                look |= {"fillstyle": fill, "ls": "", "ms": 5}
                label = f"{words}, {place} {'from jumps' if fill == 'full' else 'one'}"
                for axis, key in zip(axes, ("coverage", "score"), strict=True):
                    one = Estimate.read(told[key], "value")
                    axis.plot(one.bounds, (at, at), color=colour, lw=1)
                    axis.plot(one.value, at, label="" if row else label, **look)
    axes[0].axvline(level, color="0.3", lw=1, ls="--")
    axes[0].set(xlim=(0, 1.02), xlabel="share of weights in their band")
    axes[1].set(xscale="log", xlabel="interval score, over the weight's spread")
    axes[0].set_yticks(range(len(bands)), list(bands))
    axes[0].invert_yaxis()
    axes[0].legend(
        loc="lower left",
        bbox_to_anchor=(-0.6, 1),
        ncol=2,
        frameon=False,
        fontsize=SMALL,
    )
    return figure


def bands_table(bands: Mapping[str, Any], key: str = "coverage") -> pd.DataFrame:
    """List how often bands hold what was searched, or how good they are.

    Parameters
    ----------
    bands : dict
        Those of a family, as `msc.worlds.judge_bands` returned them.
    key : {"coverage", "width", "score"}, default="coverage"
        What of them.

    Returns
    -------
    DataFrame
        A row a method, kind of band and place; "value", and its interval over worlds,
        "low" and "high".
    """
    found = {
        (name, kind, place): of[key]
        for name, one in bands.items()
        for kind, places in one["bands"].items()
        for place, of in places.items()
        if of
    }
    return pd.DataFrame(found).T.rename_axis(["method", "band", "place"])


@styled
def plot_caught(bands: Mapping[str, Any]) -> Figure:
    """Draw how many failures are caught by setting the most doubtful tasks aside.

    Parameters
    ----------
    bands : dict
        Those of a family, as `msc.worlds.judge_bands` returned them.

    Returns
    -------
    Figure
        A line a method with failures: the share of them among the tasks that are set
        aside, over the share of tasks that are; dashed where the gate's doubt decides
        instead of the standard deviation, dotted what chance would catch.
    """
    figure, axis = plt.subplots(figsize=(7.4, 3.4))
    shown = {name: of for name, of in bands.items() if of["caught"]}
    for number, (name, of) in enumerate(shown.items()):
        failed, total = of["failures"]
        for by, caught in of["caught"].items():
            places = [0.0, *map(float, caught)]
            words = f"{name} ({100 * failed / total:.0f} % fail)"
            look: dict[str, Any] = {
                "color": f"C{number}",
                "ls": _DOUBTS[by],
                "marker": "osD^v"[number],
            }
            label = words if by == "std" else f"{name}: by its gate"
            axis.plot(places, [0.0, *caught.values()], ms=4, label=label, **look)
    axis.plot((0, 0.5), (0, 0.5), color="0.5", ls=":", lw=1, label="by chance")
    axis.set(xlim=(0, 0.52), ylim=(0, 1.02))
    axis.set(xlabel="share of tasks set aside", ylabel="share of failures among them")
    axis.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False, fontsize=SMALL)
    return figure
