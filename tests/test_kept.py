"""What is committed of each method: it rests on what is here, and is found again.

Made anew by `msc evaluate --profile full`, which does again what is stale.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from msc.data import load_dataset
from msc.study import METHODS, format_study, run_elbows, run_study
from msc.study._store import Trials, method_path
from msc.study._study import PROFILES, _fit_and_test, list_sets, sets_of

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "data" / "results"
WORLDS = "free", "obstacles"
TIERS = {  # of each, a method that is quick
    "all": "charts",
    "even": "charts, one kernel",
    "some": "change points",
    "sweep": "4 charts",
}


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


@pytest.mark.parametrize("world", WORLDS)
def test_studies_are_summaries_of_what_is_kept_of_all_methods(world):
    # It refuses what rests on other tables, another protocol, other code or versions.
    study = run_study(world, KEPT, names=[], profile="full")
    committed = (KEPT / f"study_{world}.json").read_text("utf-8")
    assert json.loads(format_study(study)) == json.loads(committed)
    missing = [name for name in METHODS if not method_path(KEPT, world, name).is_file()]
    assert missing == []


@pytest.mark.parametrize("world", WORLDS)
def test_elbows_are_not_stale(world, monkeypatch):
    monkeypatch.setattr("msc.study._study.measure_elbows", None)  # it is not asked
    committed = json.loads((KEPT / f"elbow_{world}.json").read_text("utf-8"))
    assert run_elbows(world, known=committed, profile="full") == committed


def test_every_tier_is_tried():
    assert {METHODS[name].sets for name in TIERS.values()} == {*TIERS}
    assert {method.sets for method in METHODS.values()} == {*TIERS}


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("tier", TIERS)
def test_one_training_set_of_each_tier_is_fitted_and_tested_again(world, tier):
    name, effort = TIERS[tier], PROFILES["full"]
    datasets = load_dataset(world), load_dataset(f"{world}_test")
    own = sets_of(name, effort, list_sets(effort, datasets[0].tasks, seed=0))
    (design, n_samples), chosen = next(
        (key, sets[0]) for key, sets in own.items() if key[1] >= 24
    )
    found = _fit_and_test(world, name, chosen, datasets=datasets, seed=0)
    kept = Trials.read(method_path(KEPT, world, name))
    for measure, errors in found.items():
        before = kept.errors[f"{design}/{n_samples}/{measure}"][0]
        # Contact magnifies rounding, which another processor does otherwise.
        same = np.isclose(errors, before, rtol=1e-3, atol=1e-6)
        assert same.mean() > 0.95, measure
