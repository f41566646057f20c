"""The number of charts: file, table and figure of the readings of the elbow.

`msc evaluate` writes the files, one a workspace; see `msc.elbows`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from msc.elbows import READINGS, most_picked
from msc.looks import SMALL, STYLE, TRIO
from msc.tables import find_data

PAPER = 4  # charts, in either workspace

_Elbows = Mapping[str, Mapping[str, Any]]


def load_elbows(folder: str | Path | None = None) -> dict[str, dict[str, Any]]:
    """Load what `measure_elbows` found in both workspaces.

    Parameters
    ----------
    folder : str or Path, optional
        Where ``elbow_free.json`` and ``elbow_obstacles.json`` are; by default
        ``data/results``.

    Returns
    -------
    dict
        The measurements by the workspace's name.

    Raises
    ------
    ValueError
        If a file is missing or holds something else.
    """
    where = Path(folder or find_data() / "results")
    found = {}
    for world in ("free", "obstacles"):
        file = where / f"elbow_{world}.json"
        if not file.is_file():
            raise ValueError(f"{file} is not there; `msc evaluate` writes it")
        found[world] = dict(json.loads(file.read_text(encoding="utf-8")))
        missing = set(READINGS) - set(found[world].get("readings", ()))
        if missing:
            names = ", ".join(sorted(missing))
            raise ValueError(f"{file} lacks {names}; `msc evaluate` renews it")
    return found


def elbow_table(elbows: _Elbows, count: int = PAPER) -> pd.DataFrame:
    """List which number of charts every reading picks, and how firmly.

    Parameters
    ----------
    elbows : mapping
        What `load_elbows` gives.
    count : int, default=4
        The number whose share is told.

    Returns
    -------
    DataFrame
        One row a reading; for each workspace the number picked on all tasks, the share
        of the parts on which it picks `count`, and the number it picks most often with
        the share of that, the last number considered excepted.
    """
    columns: dict[tuple[str, str], list[str]] = {}
    for world, measured in elbows.items():
        readings, n_parts = measured["readings"], measured["n_resamples"]
        most = [most_picked(measured, name) for name in READINGS]
        times = [readings[name]["resampled"].get(f"{count}", 0) for name in READINGS]
        columns[world, "picks"] = [f"{readings[name]['picked']}" for name in READINGS]
        columns[world, f"picks {count}"] = [f"{n / n_parts:.0%}" for n in times]
        columns[world, "most often"] = [f"{n} ({share:.0%})" for n, share in most]
    return pd.DataFrame(columns, index=list(READINGS.values()))


def plot_elbows(elbows: _Elbows) -> Figure:
    """Draw the curves that an elbow may be read from, and what is picked.

    Parameters
    ----------
    elbows : mapping
        What `load_elbows` gives.

    Returns
    -------
    Figure
        One row a reading, one column a workspace: the curve over the number of charts,
        scaled to its range; the number picked as a diamond; as bars, the share of the
        parts of the data on which each number is picked; dotted, the paper's number.
    """
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            len(READINGS),
            len(elbows),
            figsize=(7.4, 1.45 * len(READINGS) + 0.4),
            sharex="col",
            sharey=True,
            squeeze=False,
        )
        for column, (world, measured) in zip(axes.T, elbows.items(), strict=True):
            for axis, (name, label) in zip(column, READINGS.items(), strict=True):
                _draw_reading(axis, measured["readings"][name])
                axis.set_title(label, loc="left", fontsize=SMALL)
            column[0].set_title(world, loc="right", fontweight="bold")
            column[-1].set_xlabel("charts")
        axes[0, -1].legend(loc="upper right", bbox_to_anchor=(1, 0.95))
        figure.supylabel("share of the parts; curve, scaled", fontsize=9)
    plt.close(figure)
    return figure


def _draw_reading(axis: Axes, reading: Mapping[str, Any]) -> None:
    """Draw one curve, its pick, and the picks on parts of the data."""
    curve, picked = np.array(reading["curve"]), reading["picked"]
    counts = np.arange(1, len(curve) + 1)
    height = (curve - curve.min()) / (np.ptp(curve) or 1.0)
    times = np.array([reading["resampled"].get(f"{count}", 0) for count in counts])
    axis.bar(counts, times / max(times.sum(), 1), color="0.78", label="parts")
    axis.axvline(PAPER, color="0.3", ls=":", lw=1, label="the paper's number")
    axis.plot(counts, height, "o-", ms=3, color=TRIO[0], label="curve")
    axis.plot(
        picked,
        height[picked - 1],
        "D",
        ms=7,
        color=TRIO[1],
        mec="black",
        label="picked",
    )
    axis.yaxis.set_major_formatter(PercentFormatter(1))
    axis.set_axisbelow(True)
    axis.set(ylim=(-0.08, 1.08), yticks=(0, 0.5, 1), xticks=counts)
