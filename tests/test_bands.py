"""How sure a skill is, and whether that can be trusted."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from imagined_worlds import FOLDER
from scipy.stats import norm
from sklearn.cluster import KMeans

import msc.worlds._bands
from msc import ParameterizedSkill
from msc.plots import bands_table
from msc.worlds import judge_bands, measure_bands, resample
from msc.worlds._bands import LEVEL, _catch, conformal_halves
from msc.worlds._study import load_world


class Constant:
    """Predicts nothing, and is as sure of it everywhere."""

    def predict(self, tasks, return_std):
        assert return_std
        return np.zeros((len(tasks), 1)), np.full((len(tasks), 1), 2.0)


def test_conformal_bands_are_a_quantile_of_errors_held_out():
    errors = np.random.default_rng(0).permutation(np.arange(1.0, 25))
    grid = SimpleNamespace(tasks=np.zeros((24, 1)), policies=errors[:, None])
    stds = np.array([[2.0], [4.0]])
    halves = conformal_halves(lambda _: Constant(), grid, np.arange(24), stds)
    np.testing.assert_allclose(halves, [[23.0], [46.0]])  # 0.9 of 25, rounded up


def test_each_task_is_held_out_once_and_never_known():
    asked = []

    class Asked(Constant):
        def __init__(self, own):
            self.own = set(own)

        def predict(self, tasks, return_std):
            asked.extend(tasks[:, 0].astype(int))
            assert not self.own & set(tasks[:, 0].astype(int))
            return super().predict(tasks, return_std)

    grid = SimpleNamespace(tasks=np.arange(40)[:, None], policies=np.ones((40, 1)))
    chosen = np.arange(3, 40, 2)
    conformal_halves(Asked, grid, chosen, np.ones((1, 1)))
    assert sorted(asked) == list(chosen)


def break_at_half(X, rng):
    return np.sin(6 * X) + 3 * (X > 0.5) + 0.1 * rng.normal(size=X.shape)


def test_bands_hold_nine_in_ten_away_from_a_break_of_a_known_curve():
    held = {"gaussian": [], "conformal": []}
    near = {"gaussian": [], "conformal": []}
    for seed in range(3):
        rng = np.random.default_rng(seed)
        X = rng.uniform(size=(400, 1))
        grid = SimpleNamespace(tasks=X, policies=break_at_half(X, rng))

        def fit(own, grid=grid):
            skill = ParameterizedSkill(KMeans(2, random_state=0), random_state=0)
            return skill.fit(grid.tasks[own], grid.policies[own])

        chosen, new = np.arange(80), np.arange(80, 400)
        means, stds = fit(chosen).predict(X[new], return_std=True)
        halves = {
            "gaussian": norm.ppf((1 + LEVEL) / 2) * stds,
            "conformal": conformal_halves(fit, grid, chosen, stds),
        }
        beside = (np.abs(X[new] - 0.5) < 1 / 80)[:, 0]
        for kind, half in halves.items():
            inside = np.abs(grid.policies[new] - means) <= half
            held[kind].append(inside[~beside].mean())
            near[kind].append(inside[beside].mean())
    for kind, shares in held.items():
        assert 0.85 < np.mean(shares) < 0.95, kind
        assert np.mean(near[kind]) < np.mean(shares), kind


def test_the_most_doubted_are_set_aside_first():
    doubt = np.linspace(1, 0, 100).reshape(4, 25)
    failed = np.zeros((4, 25), bool)
    failed[0, :5] = failed[3, -1] = True
    caught = _catch(doubt, failed)
    assert caught == {"0.05": 5, "0.1": 5, "0.2": 5, "0.3": 5, "0.5": 5}
    assert set(_catch(-doubt, failed).values()) == {1}


@pytest.fixture
def brief(monkeypatch):
    monkeypatch.setattr(msc.worlds._bands, "BANDED", ("single, one kernel",))
    monkeypatch.setattr(msc.worlds._bands, "N_SETS", 1)


def test_a_world_s_bands_are_counted_over_weights_and_tasks(brief):
    call, told = load_world(FOLDER, "layout07", "msc worlds bands layout07")
    assert "layout07_test.csv" in str(told["data"])
    found = measure_bands(*call)
    [method] = found["methods"].values()
    assert found["tasks"][1] == method["failures"][1] == len(call[2].tasks)
    away, beside = method["bands"]["gaussian"].values()
    for one, n in ((away, found["tasks"][0]), (beside, 60 - found["tasks"][0])):
        assert round(one["coverage"] * 6 * n, 2) == round(one["coverage"] * 6 * n)
        assert one["score"] >= one["width"]
    assert found == measure_bands(*call)


def test_bands_are_averaged_over_worlds(tmp_path, brief):
    def write(name, coverage, width, failures, caught):
        one = {"coverage": coverage, "width": width, "score": width}
        bands = {"gaussian": {"away": one, "beside": None}}
        told = {"bands": bands, "failures": failures, "caught": {"std": caught}}
        told = {"methods": {"single, one kernel": told}}
        (tmp_path / f"bands_{name}.json").write_text(json.dumps(told), "utf-8")

    write("layout01", 0.8, 1.0, [4, 60], {"0.1": 1})
    write("layout02", 0.9, 4.0, [1, 60], {"0.1": 1})
    write("arm1", 0.5, 1.0, [0, 60], {"0.1": 0})
    found = judge_bands(tmp_path)
    layouts = found["layout"]["single, one kernel"]
    away = layouts["bands"]["gaussian"]["away"]
    assert (away["coverage"]["value"], away["width"]["value"]) == (0.85, 2.0)
    bounds = away["coverage"]["low"], away["coverage"]["high"]
    assert bounds == resample(np.array([0.8, 0.9]))
    assert layouts["bands"]["gaussian"]["beside"] == {}
    assert layouts["failures"] == [5, 120]
    assert layouts["caught"] == {"std": {"0.1": 0.4}}
    assert found["arm"]["single, one kernel"]["caught"] == {}


def test_a_table_of_bands_has_a_row_for_each_that_there_is(tmp_path):
    of = {"coverage": {"value": 0.8, "low": 0.7, "high": 0.9}}
    bands = {"charts": {"bands": {"gaussian": {"away": of, "beside": {}}}}}
    told = bands_table(bands)
    assert told.index.tolist() == [("charts", "gaussian", "away")]
    assert told.loc[("charts", "gaussian", "away")].tolist() == [0.8, 0.7, 0.9]
