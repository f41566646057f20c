"""What is committed of each method: it rests on what is here, and is found again.

Made anew by `msc evaluate --profile full`, which does again what is stale.
"""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from msc.data import load_dataset
from msc.robot import Workspace, read_world
from msc.study import METHODS, find_cell, format_study, run_elbows, run_study
from msc.study._store import Trials, method_path
from msc.study._study import (
    PROFILES,
    _fit_and_test,
    list_sets,
    read_trials,
    sets_of,
)
from msc.worlds import judge_bands, locate_bands, locate_jumps, study_worlds
from msc.worlds._study import ALWAYS, CHOICES, _try, list_world_sets
from press import checksum

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "data" / "results"
WORLDS = "free", "obstacles"
TIERS = {  # of each, a method that is quick
    "all": "charts",
    "even": "charts, one kernel",
    "some": "change points",
    "few": "Kober's practice",
    "sweep": "4 charts",
}


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


@pytest.mark.parametrize("world", WORLDS)
def test_studies_are_summaries_of_what_is_kept(world, monkeypatch):
    """All methods are read, and a quarter is summarised again: tests/slow does all.

    It is picked by what is kept: by the checksums of the methods' files.
    """
    monkeypatch.setattr("msc.study._study.Trials.read", cache(Trials.read))
    # It refuses what rests on other tables, another protocol, other code or versions.
    assert [*read_trials(world, KEPT)] == [*METHODS]
    some = [
        name
        for name in METHODS  # all others are divided by charts
        if name == "charts" or draw(method_path(KEPT, world, name), 4) == 0
    ]
    monkeypatch.setitem(PROFILES, "full", replace(PROFILES["full"], methods=some))
    study = run_study(world, KEPT, names=[], profile="full")
    committed = json.loads((KEPT / f"study_{world}.json").read_text("utf-8"))
    assert json.loads(format_study(study)) == take(committed, {*some})


def draw(path, n):
    """Draw a number below n by what is in a file."""
    return int(checksum(path).removeprefix("sha256:"), 16) % n


def take(study, names):
    """Return what a study would be, had it no other methods than these."""
    cells = []
    for cell in study["cells"]:
        measures = {
            key: {name: one for name, one in found.items() if name in names}
            for key, found in cell["measures"].items()
        }
        ratios = [
            one for one in cell["ratios"] if {one["method"], one["baseline"]} <= names
        ]
        cells.append({**cell, "measures": measures, "ratios": ratios})
    numbers = {int(name.split()[0]) for name in names if METHODS[name].sets == "sweep"}
    return {
        **study,
        "cells": cells,
        "sweep": [one for one in study["sweep"] if one["n_charts"] in numbers],
        **{
            key: {name: one for name, one in study[key].items() if name in names}
            for key in ("rollouts", "failed")
        },
    }


@pytest.mark.parametrize("world", WORLDS)
def test_elbows_are_not_stale(world, monkeypatch):
    monkeypatch.setattr("msc.study._study.measure_elbows", None)  # it is not asked
    committed = json.loads((KEPT / f"elbow_{world}.json").read_text("utf-8"))
    assert run_elbows(world, known=committed, profile="full") == committed


def test_every_tier_is_tried():
    assert {METHODS[name].sets for name in TIERS.values()} == {*TIERS}
    assert {method.sets for method in METHODS.values()} == {*TIERS}


@pytest.mark.parametrize("world", WORLDS)
def test_a_training_set_of_a_tier_is_fitted_and_tested_again(world):
    """Of one tier, picked by what is kept; tests/slow tries all, which takes longer."""
    tiers = [tier for tier in TIERS if tier != "few"]  # which practise
    fit_again(world, tiers[draw(KEPT / f"study_{world}.json", len(tiers))])


def fit_again(world, tier):
    """Fit one training set, and compare what it does with what is kept."""
    name, effort = TIERS[tier], PROFILES["full"]
    datasets = load_dataset(world), load_dataset(f"{world}_test")
    own = sets_of(name, effort, list_sets(effort, datasets[0].tasks, seed=0))
    (design, n_samples), chosen = next(
        (key, sets[0]) for key, sets in own.items() if key[1] >= 24
    )
    where = Workspace.named(world)
    found = _fit_and_test(where, name, chosen, datasets=datasets, seed=0)
    kept = Trials.read(method_path(KEPT, world, name))
    for measure, errors in found.items():
        before = kept.errors[f"{design}/{n_samples}/{measure}"][0]
        # Contact magnifies rounding, which another processor does otherwise.
        same = np.isclose(errors, before, rtol=1e-3, atol=1e-6)
        assert same.mean() > 0.95, measure


STUDIED = sorted(
    path.stem
    for path in (KEPT / "worlds").glob("*[0-9].json")
    if not path.stem.startswith(("jumps", "bands", "moves"))
)
BANDED = sorted(path.stem for path in (KEPT / "worlds").glob("bands_*.json"))


@pytest.mark.parametrize("name", STUDIED[::12])
def test_a_training_set_of_a_world_is_fitted_and_tested_again(name):
    folder = ROOT / "data" / "worlds"
    world = read_world(folder / f"{name}.toml")
    grid, test = (load_dataset(folder / f"{name}{end}.csv") for end in ("", "_test"))
    units = world.task_units
    datasets = [one._replace(tasks=one.tasks / units) for one in (grid, test)]
    design, _, sets = next(
        one for one in list_world_sets(datasets[0].tasks, 0) if one[1] == 24
    )
    study = json.loads((KEPT / "worlds" / f"{name}.json").read_text("utf-8"))
    kept = find_cell(study, design, 24)["measures"]["mse, gate learned"]
    for method in ("charts", "single regression", "nearest neighbour"):
        found = _try(method, world, datasets, sets[0], 0)
        before = kept[method]["per_repetition"][0]
        assert np.mean(found["mse"]) == pytest.approx(before, rel=1e-3), method


@pytest.mark.parametrize("name", STUDIED)
def test_worlds_rest_on_their_tables(name):
    folder, results = ROOT / "data" / "worlds", KEPT / "worlds"
    assert locate_jumps(folder, results, [name]) == []
    assert study_worlds(folder, results, [name]) == []
    failed = json.loads((results / f"{name}.json").read_text("utf-8"))["failed"]
    assert not {one.partition("/")[0] for one in failed} & {*ALWAYS, *CHOICES}


def test_bands_rest_on_the_tables_of_their_worlds():
    folder, results = ROOT / "data" / "worlds", KEPT / "worlds"
    names = [one.removeprefix("bands_") for one in BANDED]
    assert len(names) >= 30
    assert locate_bands(folder, results, names) == []
    kept = json.loads((results / "bands.json").read_text("utf-8"))
    assert judge_bands(results) == kept
