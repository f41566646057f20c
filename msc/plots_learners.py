"""What learning costs, in tables: the benchmark's figures of SMCE and of the skill."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from msc.plots_search import _digits, _text


def smce_table(figures: Mapping[str, Any]) -> pd.DataFrame:
    """List what a fit of SMCE costs, over the number of points.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a number of points, each fitted in a process of its own on one core.
    """
    fits = pd.DataFrame(figures["learners"]["fits"])
    shown = pd.DataFrame(
        {
            "seconds": fits["seconds"],
            "ms a point": 1000 * fits["seconds"] / fits["n_points"],
            "MB, at most": fits["peak_mb"],
            "MB before": fits["before_mb"],
        }
    )
    return shown.map(_digits).set_index(fits["n_points"].rename("points"))


def learner_table(figures: Mapping[str, Any]) -> pd.DataFrame:
    """List what the skill costs beside a single regression, and SMCE beside cvxpy.

    Parameters
    ----------
    figures : mapping
        What `load_costs` gives.

    Returns
    -------
    DataFrame
        One row a figure: the median over the rounds, and in brackets where the middle
        four fifths of them lie.
    """
    smce = figures["learners"]["smce"]
    rows = {
        f"SMCE, {smce['n_points']} points: seconds to fit": smce["fit_seconds"],
        "one cvxpy problem a point: seconds": smce["one_by_one_seconds"],
        "cvxpy / SMCE": smce["one_by_one_over_fit"],
    }
    for world, skill in figures["learners"]["skill"].items():
        head = f"{world}, {skill['n_samples']} samples"
        for step, asked in (("fit", ""), ("predict", f" {skill['n_predicted']}")):
            what = f"{head}: ms to {step}{asked}"
            rows[f"{what}, {skill['n_charts']} charts"] = skill[
                f"{step}_charts_milliseconds"
            ]
            rows[f"{what}, single"] = skill[f"{step}_single_milliseconds"]
            rows[f"{head}: {step}, charts / single"] = skill[
                f"{step}_charts_over_single"
            ]
    return pd.DataFrame({"": {name: _text(value) for name, value in rows.items()}})
