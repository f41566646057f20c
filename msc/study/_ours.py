"""The paper's method and the single regression, with one part exchanged in variants."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sklearn.cluster import KMeans

from msc.learn import SMCE, ParameterizedSkill, gaussian_process
from msc.study._setting import N_CHARTS, Setting


def build_skill(to: Setting) -> ParameterizedSkill:
    """Build "charts", "single" or a number of charts; parts exchanged after commas."""
    what, *parts = to.name.split(", ")
    kernels = {"Matérn": "matern", "periodic": "periodic"}
    kernel = next((kernels[part] for part in parts if part in kernels), None)
    count = int(what.split()[0]) if what[0].isdecimal() else to.n_charts
    charts: Any = SMCE(count, random_state=to.seed, **_smce_options(parts))
    if "k-means" in parts:
        charts = KMeans(count or N_CHARTS, n_init=10)
    if what.startswith("single"):
        charts = None
    gates = {"SVM gate": "svm", "GP gate": "gp"}
    return ParameterizedSkill(
        charts,
        gate=next((gates[part] for part in parts if part in gates), "nearest"),
        regressor=gaussian_process(kernel) if kernel else None,
        kernel_per="chart" if "one kernel" in parts else "param",
        random_state=to.seed,
        verbose=False,
    )


def _smce_options(parts: Iterable[str]) -> dict[str, Any]:
    """Read what differs of SMCE: "λ 1", "10 neighbours", "raw form"."""
    told: dict[str, Any] = {}
    for part in parts:
        if part.startswith("λ "):
            told["regularization"] = float(part[2:])
        elif part.endswith(" neighbours"):
            told["n_neighbors"] = int(part.split()[0])
        elif part == "raw form":
            told["form"] = "raw"
    return told
