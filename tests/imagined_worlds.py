"""Worlds as they would be found if methods erred by given factors."""

import json
from pathlib import Path

import numpy as np

from msc.study import summarise_cell
from msc.worlds import judge_worlds
from msc.worlds._study import ALWAYS
from msc.worlds._study import CHOICES as CHANGED

FOLDER = Path(__file__).parents[1] / "data" / "worlds"
LAYOUTS = [f"layout{k:02}" for k in range(1, 7)]
NAMES = dict.fromkeys((*ALWAYS, *CHANGED), 1.0)


def imagine_world(folder, name, factors, *, jumps=(), n_tasks=60, seed=0):
    """Write what a world would be found like: errors of methods, by a factor each."""
    rng = np.random.default_rng(seed)
    base = np.exp(0.2 * rng.normal(size=(10, n_tasks)))
    raw = {}
    for number, (method, factor) in enumerate((NAMES | factors).items()):
        noise = np.exp(0.05 * np.random.default_rng(number).normal(size=base.shape))
        keys = "mse", "mse_known", "error_cm", "excess_cost"
        raw[method] = dict.fromkeys(keys, factor * base * noise)
        raw[method]["touched"] = np.zeros_like(base, bool)
    summary = summarise_cell(raw, np.ones(n_tasks, bool), np.ones(n_tasks))
    told = {"design": "even", "repetitions": 10, "measures": summary["measures"]}
    cells = [{**told, "n_samples": size} for size in (12, 24, 50)]
    (folder / f"{name}.json").write_text(json.dumps({"cells": cells}), "utf-8")
    found = [
        {
            "between_deg": [float(at), at + 5.0],
            "located_deg": [at, at + 0.1],
            "step_sizes": [90.0, 80.0],
            "is_jump": kept,
        }
        for at, kept in jumps
    ]
    (folder / f"jumps_{name}.json").write_text(json.dumps({"jumps": found}), "utf-8")


def imagine_layouts(folder):
    """Imagine six layouts in which charts are twice as good; return their verdicts."""
    factors = {"charts": 0.5, "charts, one kernel": 2.0, "CrKr": 0.5, "2 charts": 3.0}
    for seed, name in enumerate(LAYOUTS):
        jumps = [(10 * k, True) for k in range(1, seed + 2)] + [(355, True)]
        imagine_world(folder, name, factors, jumps=jumps, seed=seed)
    return judge_worlds(FOLDER, folder)
