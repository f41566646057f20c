"""Results as they would be if the paper were right in everything, or in nothing."""

import numpy as np
import pandas as pd

from msc.data import WEIGHTS
from msc.data._tables import COLUMNS
from msc.study import MEASURES

SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)
MSES = [key for key in MEASURES if "mse" in key and key != "mse, beside jumps"]
CURVES = (
    "rows_of_m",
    "squares",
    "squares_knee",
    "eigengap",
    "cross_validation",
)
KERNELS = ("Matérn", "one kernel")
METHODS = ("charts", "single regression", "CrKr", "mean policy")

# By measure, whether the paper is right, and workspace: a mean for each method.
MEANS = {
    "mse": {
        (True, "free"): (0.1, 0.3, 0.3, 10),
        (True, "obstacles"): (0.1, 1, 2, 10),
        (False, "free"): (1.5, 1, 0.1, 10),
        (False, "obstacles"): (5, 1, 0.1, 10),
    },
    "error_cm": {
        (True, "free"): (0.3, 0.6, 2, 9),
        (True, "obstacles"): (0.3, 2, 3, 9),
        (False, "free"): (4, 3, 0.1, 9),
        (False, "obstacles"): (8, 3, 0.1, 9),
    },
}
FEWER = {True: 3, False: 1}  # how much worse the single regression is with few samples


def imagine(right):
    """Return result files by name, in the layout of `msc.study` and the others."""
    jumps = {"free": 0 if right else 2, "obstacles": 3 if right else 0}
    results = {}
    for world in ("free", "obstacles"):
        results |= {
            f"data/results/study_{world}.json": imagine_study(right, world),
            f"data/results/elbow_{world}.json": imagine_elbow(right),
            f"data/results/audit_{world}.json": {
                "jumps": [
                    {"between_deg": [k, k + 1], "is_jump": True}
                    for k in range(jumps[world])
                ]
            },
            f"data/{world}_test.csv": pd.DataFrame({"cost": [0.04, 0.06]}),
        }
    micro = dict.fromkeys(("median", "low", "high"), 1000.0)
    seconds = [5.0, 6.0] if right else [0.05, 0.06]
    results["data/results/bench.json"] = {
        name: dict.fromkeys(("free", "obstacles"), measured)
        for name, measured in (
            ("searches", {"ways": {"alone": {"seconds": seconds}}}),
            ("skill", {"predict_one_microseconds": micro}),
        )
    }
    return results


def imagine_study(right, world):
    """Return a study with all numbers known to a twentieth."""
    cells = [
        {
            "design": design,
            "n_samples": size,
            "repetitions": 2,
            "measures": (measures := imagine_measures(right, world, size)),
            "ratios": [
                {"measure": measure, "method": "charts", "baseline": baseline}
                | near(by_method["charts"]["mean"] / mean["mean"], "ratio")
                for measure, by_method in measures.items()
                for baseline, mean in by_method.items()
                if baseline != "charts" and MEASURES[measure].has_ratio
            ]
            + [
                {"measure": measure, "method": f"charts, {kernel}"}
                | {"baseline": f"single, {kernel}"}
                | near(0.5 if right else 2, "ratio")
                for kernel in KERNELS
                for measure in measures
                if MEASURES[measure].has_ratio
            ],
        }
        for design in ("even", "uniform")
        for size in SIZES
    ]
    for cell in cells:
        for by_method in cell["measures"].values():
            for kernel in KERNELS:
                by_method[f"charts, {kernel}"] = summary(0.5 if right else 2)
                by_method[f"single, {kernel}"] = summary(1)
    sweep = [
        {
            "n_charts": n_charts,
            "n_samples": size,
            "repetitions": 2,
            "measures": {MSES[0]: {"charts": summary(1 + right * (n_charts - 4) ** 2)}},
        }
        for n_charts in range(1, 9)
        for size in (24, 100, 360)
    ]
    for one in sweep if not right else []:
        one["measures"][MSES[0]]["charts"] = summary(20 - (one["n_charts"] - 4) ** 2)
    provenance = {"command": "", "data": {}, "versions": {}}
    head = {"workspace": world, "profile": "full", "seed": 0, "n_charts": 4}
    return {
        **head,
        "provenance": provenance,
        "failed": {},
        "rollouts": {},
        "cells": cells,
        "sweep": sweep,
    }


def imagine_controls(world, means, sizes=SIZES):
    """Return a study of evenly spaced sets alone: a mean a method, over n."""
    cells = [
        {
            "design": "even",
            "n_samples": size,
            "repetitions": 2,
            "measures": {
                measure: {name: summary(mean / size) for name, mean in means.items()}
                for measure in MEASURES
            },
            "ratios": [],
        }
        for size in sizes
    ]
    return {"workspace": world, "failed": {}, "cells": cells, "sweep": []}


def imagine_measures(right, world, size):
    """Return a mean for each measure and method."""
    mse, error = (
        dict(zip(METHODS, MEANS[measure][right, world], strict=True))
        for measure in ("mse", "error_cm")
    )
    if size < 360:
        mse["single regression"] *= FEWER[right]
        mse["CrKr"] *= 1 if right else 5
        mse["charts"] *= 1.2 if right else 10
    share, excess = (0.97, 0.002) if right else (0.3, 0.05)
    means = dict.fromkeys(MSES, mse) | {
        "error_cm": error,
        "error_cm spread": error,
        "excess_cost": {name: excess * error[name] / error["charts"] for name in error},
        "under_1_cm": dict.fromkeys(METHODS, share),
    }
    return {
        measure: {method: summary(mean) for method, mean in by_method.items()}
        for measure, by_method in means.items()
    }


def imagine_elbow(right):
    """Return the elbow's picks, the same by every curve."""
    picked = 4 if right else 6
    picks = {"picked": picked, "resampled": {"3": 5, str(picked): 45}}
    return {"readings": dict.fromkeys(CURVES, picks)}


def summary(mean):
    """Summarise errors that are all alike."""
    alike = dict.fromkeys(("median", "p95"), mean)
    sizes = {"n_tasks": 120, "per_repetition": [mean, mean], "waves": [0.0] * 4}
    return near(mean, "mean") | {"std": 0.0} | alike | sizes


def near(value, name):
    """Name a number and give it an interval."""
    return {name: value, "low": 0.95 * value, "high": 1.05 * value}


def imagine_table(tasks_deg, jumps_deg):
    """Return a table of policies: a curve that is lifted at each jump."""
    angles = np.deg2rad(tasks_deg)
    curve = np.c_[np.sin(angles), np.cos(angles), np.sin(2 * angles)]
    lifts = 6.0 * np.searchsorted(jumps_deg, tasks_deg)
    table = pd.DataFrame(0.0, index=range(len(angles)), columns=list(COLUMNS))
    table[list(WEIGHTS)] = np.c_[curve, 2 * curve] + lifts[:, None]
    table["task_deg"], table["winner"] = tasks_deg, "start 0"
    return table.assign(cost=0.1 + tasks_deg / 1000)
