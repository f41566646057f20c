"""The few numbers that the book's first page has its verdict in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msc.estimates import rounded
from msc.study import count_ahead, find_cell

STUDIES = "free", "obstacles"
N_SAMPLES = 24  # training tasks, if a row does not say otherwise
_MSE, _CM = "mse, gate learned", "error_cm"
_KNOWN, _AWAY = "mse, chart known", "mse, away from jumps"

# How far executed movements end from their goals in the mean (cm), with obstacles.
_MEANS = {
    "cm_charts": "charts",
    "cm_single": "single regression",
    "cm_line": "linear interpolation",
    "cm_nearest": "nearest neighbour",
    "cm_mean": "mean policy",
    "cm_charts_one": "charts, one kernel",
    "cm_single_one": "single, one kernel",
}
# A method's mean as a multiple of another's.
_RATIOS = {
    "free_all": ("free", _MSE, 360, "charts", "single regression"),
    "free_some": ("free", _MSE, N_SAMPLES, "charts", "single regression"),
    "free_rough": ("free", _MSE, 360, "charts, Matérn", "single, Matérn"),
    "broken": ("obstacles", _MSE, N_SAMPLES, "charts", "single regression"),
    "broken_known": ("obstacles", _KNOWN, N_SAMPLES, "charts", "single regression"),
    "broken_away": ("obstacles", _AWAY, N_SAMPLES, "charts", "single regression"),
}
# On how many training sets charts err less than the single regression.
_AHEAD = {
    "ahead_free_cm": ("free", _CM),
    "ahead_cm": ("obstacles", _CM),
    "ahead_mse": ("obstacles", _MSE),
}


def headline_values(studies: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return the numbers that the first page quotes, to two digits.

    Parameters
    ----------
    studies : mapping
        Results of the studies by world: of `STUDIES`.

    Returns
    -------
    dict of str to str
        By name: means ``cm_…`` (cm), ratios, each with its interval ``…_interval``, and
        counts ``ahead_…`` of training sets, out of ``n_sets``.
    """
    values = {}
    there = find_cell(studies["obstacles"], "even", N_SAMPLES)
    for name, method in _MEANS.items():
        values[name] = _two(there["measures"][_CM][method]["mean"])
    for name, (world, measure, n_samples, *pair) in _RATIOS.items():
        (found,) = (
            one
            for one in find_cell(studies[world], "even", n_samples)["ratios"]
            if [one["measure"], one["method"], one["baseline"]] == [measure, *pair]
        )
        values[name] = _two(found["ratio"])
        values[f"{name}_interval"] = f"[{_two(found['low'])}, {_two(found['high'])}]"
    for name, (world, measure) in _AHEAD.items():
        cell = find_cell(studies[world], "even", N_SAMPLES)
        ahead, n_sets = count_ahead(cell, measure, "charts", "single regression")
        values |= {name: str(ahead), "n_sets": str(n_sets)}
    values["behind_free_cm"] = str(n_sets - int(values["ahead_free_cm"]))
    return {f"first_{name}": value for name, value in values.items()}


def _two(number: float) -> str:
    """Write two digits, without an exponent.

    >>> _two(0.2055), _two(5.585)
    ('0.21', '5.6')
    """
    return f"{float(rounded(number, 2)):g}"
