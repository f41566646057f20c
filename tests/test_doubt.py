"""Bands and flags of predictions, held against truth that is known."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist
from scipy.stats import hypergeom

from msc.cli import main
from msc.skills import Table, TableSkill, fit_table, save_skill
from msc.skills._bands import _FLOOR, Doubt, judge_doubt, leave_out, part_alone
from msc.skills._blocks import Blocks

BREAK = 150.0  # degrees


def draw(n_tasks, seed):
    """Two columns in their units, a leap of three spreads, noise; the true break."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 300, n_tasks)
    turn = np.radians(angle)
    push = np.cos(turn) + 3 * (angle > BREAK) + rng.normal(0, 0.1, n_tasks)
    lift = 1000 * (np.sin(turn) + rng.normal(0, 0.1, n_tasks))
    policies = pd.DataFrame({"push": push, "lift": lift})
    return pd.DataFrame({"angle": angle}), policies, np.abs(angle - BREAK) > 12


@pytest.fixture(scope="module", params=["four neighbours", "single, one kernel"])
def fits(request):
    """Give fits to two tables; one that knows its deviations, one that does not."""
    return [
        fit_table(Table(*draw(100, seed)[:2]), methods=[request.param], seed=seed)
        for seed in range(2)
    ]


def test_bands_hold_nine_in_ten_away_from_the_break(fits, capsys):
    held, beside = [], []
    for seed, fit in enumerate(fits):
        tasks, policies, away = draw(1000, 100 + seed)
        missed = np.abs(fit.skill.predict(tasks) - policies.to_numpy())
        inside = missed <= fit.skill.predict_band(tasks)
        held.append(inside[away].mean())
        beside.append(inside[~away].mean())
    with capsys.disabled():
        told = f"{np.mean(held):.1%} away from the break, {np.mean(beside):.1%} beside"
        print(f"\n{fits[0].skill.method}: bands of 90 % held {told}")  # noqa: T201
    assert 0.85 < np.mean(held) < 0.95
    assert np.mean(beside) > 0.6, "worse, but no lottery"


def test_tasks_beside_the_break_are_doubtful(fits):
    beside, others = [], []
    for fit in fits:
        tasks, _, away = draw(2000, 7)
        flags = fit.skill.find_doubtful(tasks)
        beside.append(flags[~away].mean())
        others.append(flags[away].mean())
    assert np.mean(beside) > 5 * np.mean(others)
    assert np.mean(others) < 0.1


def test_what_flags_are_worth_is_counted_in_blocks(fits):
    """The blocks of 100 tasks in their order; neighbours by brute force."""
    fit = fits[0]
    tasks, policies, _ = draw(100, 0)
    X, y = tasks.to_numpy(), policies.to_numpy()
    y = (y - y.mean(axis=0)) / y.std(axis=0)
    of_row = np.argsort(np.argsort(X[:, 0])) * 33 // 100
    apart = np.where(of_row[:, None] % 5 == of_row % 5, np.inf, cdist(X, X))
    near = np.argsort(apart, axis=1)[:, :5]
    doubt = y[near].std(axis=1).mean(axis=1) + _FLOOR
    flags = np.bincount(of_row, doubt) / np.bincount(of_row) > fit.skill.doubt_.limit_
    flag = fit.card["held_out"]["flag"]
    assert [flag["n_blocks"], flag["n_worst"]] == [33, 3]
    assert flag["n_flagged"] == flags.sum()
    chance = hypergeom(33, flag["n_flagged"], 3).pmf(range(flag["n_caught"], 4)).sum()
    assert flag["is_sure"] == (chance < 0.025)


def test_a_band_ends_at_a_quantile_of_errors_left_out():
    rng = np.random.default_rng(0)
    scales = rng.uniform(0.5, 2, (24, 2))
    missed = rng.permutation(np.arange(1.0, 25))[:, None] * scales * [1, -3]
    doubt = Doubt().fit(rng.normal(size=(24, 1)), missed).calibrate(missed, scales)
    np.testing.assert_allclose(doubt.halves_, [23, 69])  # 0.9 of 25, rounded up
    worst_tenth = scales.mean(axis=1) > doubt.limit_
    assert worst_tenth.sum() == 3


@pytest.mark.parametrize(("n_errors", "known"), [(9, False), (10, True)])
def test_too_few_errors_make_no_band(n_errors, known):
    missed = np.ones((n_errors, 1))
    doubt = Doubt().fit(missed, missed).calibrate(missed, missed)
    assert np.isfinite(doubt.halves_).all() == known
    left_out = missed, missed, missed
    alone = Blocks(np.arange(n_errors), np.arange(n_errors) % 5)
    told = judge_doubt(doubt, left_out, alone)
    assert (told["conformal"] is not None) == known


def test_a_skill_that_cannot_be_fitted_to_some_makes_no_band():
    missed = np.array([[1.0]] * 20 + [[np.nan]])
    doubt = Doubt().fit(missed[:20], missed[:20]).calibrate(missed, missed)
    assert np.isnan(doubt.halves_).all()


def test_copies_of_a_task_are_left_out_together_and_each_once():
    rng = np.random.default_rng(0)
    copies = rng.integers(12, size=40)
    copies[:12] = range(12)
    blocks = part_alone(copies, 0)
    X = copies[:, None].astype(float)
    y = np.arange(40.0)[:, None]
    asked = []

    class Nobody(TableSkill):
        def fit(self, X, y, cost=None):
            self.known = {*X[:, 0]}
            return super().fit(X, y)

        def predict(self, X, return_std=False):
            assert not self.known & {*X[:, 0]}
            asked.extend(X[:, 0])
            return super().predict(X, return_std)

    def run(call, calls):
        for number, one in enumerate(calls):
            yield number, call(*one)

    skill = Nobody("mean policy")
    missed, stds, apart = leave_out(skill, (X, y, None), blocks, run, list)
    assert sorted(asked) == sorted(X[:, 0])
    assert np.isfinite(missed).all()
    assert np.isnan(stds).all()
    assert (apart > 0).all()


def test_neighbours_are_different_tasks():
    """Of many copies the policies are averaged: a neighbour has one voice."""
    points = np.array([[0.0]] * 9 + [[1.0], [2.0], [3.0], [4.0]])
    policies = np.array([[0.0]] * 9 + [[5.0]] * 4)
    doubt = Doubt().fit(points, policies)
    assert doubt.measure(points[:1])[0, 0] == np.std([0, 5, 5, 5, 5]) + _FLOOR


def test_the_file_has_bands_and_flags(fits, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    tasks, _, _ = draw(50, 3)
    tasks.to_csv("new.csv", index=False)
    save_skill(fits[0].skill, tmp_path / "a.skops")
    assert main(["predict", "a.skops", "new.csv", "--out", "out.csv"]) == 0
    found = pd.read_csv("out.csv")
    columns = found[["push_band90", "lift_band90"]]
    np.testing.assert_allclose(columns, fits[0].skill.predict_band(tasks), rtol=1e-8)
    flags = fits[0].skill.find_doubtful(tasks)
    assert found["doubtful"].tolist() == flags.astype(int).tolist()
    if flags.any():
        assert f"{flags.sum()} of 50 tasks lie where" in capsys.readouterr().err


def test_bands_are_in_the_units_of_policies():
    tasks, policies, _ = draw(60, 1)
    how = {"methods": ["nearest neighbour"]}
    one = fit_table(Table(tasks, policies), **how)
    other = fit_table(Table(tasks, policies * [1000.0, 0.001]), **how)
    bands = [fit.skill.predict_band(tasks) for fit in (one, other)]
    np.testing.assert_allclose(bands[0] * [1000.0, 0.001], bands[1], rtol=1e-6)
    assert one.card["held_out"] == other.card["held_out"]
