"""What predictions save of searching."""

import json
import math
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import CensoredData, ecdf

import msc.study._savings
from msc import Workspace, load_dataset
from msc.search import SearchOptions, search_curves, search_policy
from msc.study import (
    SCRATCH,
    break_even,
    measure_savings,
    run_savings,
    summarise_savings,
    time_searches,
)

few = settings(max_examples=25, deadline=None)
brief = SearchOptions(max_evaluations=27)
world = Workspace.obstacles()
tasks, policies, table = load_dataset("obstacles_test")


def fake(seed, n_tasks=9):
    """Draw a table, and costs of searches that come near it or not."""
    rng = np.random.default_rng(seed)
    searched = rng.uniform(0.02, 0.2, n_tasks)
    costs = [one * (1 + rng.exponential(0.3, rng.integers(1, 40))) for one in searched]
    return pd.DataFrame({"task_deg": 3.0 * np.arange(n_tasks), "cost": searched}), costs


# One curve


def test_a_curve_is_the_search_and_its_rollouts_in_order():
    [curve] = search_curves(
        world, [40.5], policies[[10]], seed=3, n_starts=1, options=brief
    )
    alone = search_policy(
        world,
        40.5,
        seed=3,
        start_policies=[policies[10]],
        n_starts=1,
        options=brief,
    )
    np.testing.assert_array_equal(curve.result.policy, alone.policy)
    assert [run.name for run in curve.result.runs] == ["given 0", "start 0"]
    assert len(curve.costs) == 1 + alone.evaluations
    first, *later = curve.costs
    assert min(later) == alone.cost == min(curve.best_costs[-1], *later)
    n_given = alone.runs[0].evaluations
    assert min(later[:n_given]) == alone.runs[0].cost
    assert min(later[n_given:]) == alone.runs[1].cost
    assert first > alone.cost


def test_the_first_rollout_is_the_prediction_and_others_do_not_matter():
    brief = SearchOptions(max_evaluations=9)
    chosen = slice(0, 120, 12)
    angles, given = table["task_deg"][chosen].tolist(), policies[chosen]
    curves = search_curves(world, angles, given, seed=0, options=brief)
    first = [curve.costs[0] for curve in curves]
    np.testing.assert_allclose(first, table["cost"][chosen], rtol=1e-9)
    alone = search_curves(world, angles[:1], given[:1], seed=0, options=brief)
    np.testing.assert_array_equal(alone[0].costs, curves[0].costs)
    with pytest.raises(ValueError, match="start_policies has 2 policies; wanted 1"):
        search_curves(world, angles[:1], given[:2], seed=0)


# Timed


@few
@given(st.integers(0, 2**31))
def test_times_are_counted_rollout_by_rollout(seed):
    searched, costs = fake(seed)
    timed = time_searches(costs, searched)
    for row in timed.itertuples():
        paid = costs[int(row.task_deg / 3)]
        best, when = math.inf, None
        for number, one in enumerate(paid, 1):
            best = min(best, one)
            if best <= row.factor * row.searched and when is None:
                when = number
        assert row.is_reached == (when is not None)
        assert row.rollouts == (when or len(paid))
        assert (row.first, row.last, row.n_rollouts) == (paid[0], best, len(paid))
    assert len(timed) == 2 * len(searched)
    json.dumps(timed.to_dict("records"))  # plain


def test_a_task_is_never_dropped():
    searched, costs = fake(0)
    with pytest.raises(ValueError, match=r"costs are of 8 searches, 8 .* of 9 tasks"):
        time_searches(costs[1:], searched)
    with pytest.raises(ValueError, match="costs are of 9 searches, 8 of them with"):
        time_searches([costs[0][:0], *costs[1:]], searched)


# Summarised


def summary(own, scratch, searched, factors=(1.05,)):
    parts = {SCRATCH: scratch, "ours": own}
    timed = [
        time_searches(costs, searched, factors=factors).assign(method=name)
        for name, costs in parts.items()
    ]
    return summarise_savings(pd.concat(timed)).set_index(["method", "factor"])


@few
@given(st.integers(0, 2**31))
def test_medians_are_those_of_survival_analysis(seed):
    """A search that ended without is one that takes longer than any."""
    searched, costs = fake(seed)
    timed = time_searches(costs, searched, factors=[1.05])
    never = ~timed["is_reached"].to_numpy()
    times = np.where(never, 10**6, timed["rollouts"])
    curve = ecdf(CensoredData(times[~never], right=times[never])).sf
    found = summary(costs, costs, searched).loc[("ours", 1.05), "median_rollouts"]
    if never.sum() > len(never) / 2:
        assert found == math.inf
    else:
        crossed = curve.quantiles[curve.probabilities <= 0.5]
        assert found == crossed[0]


def test_worse_basins_and_what_they_cost_by_hand():
    searched = pd.DataFrame({"task_deg": [0.0, 3.0, 6.0], "cost": [1.0, 1.0, 1.0]})
    scratch = [np.array([5, 4, 3, 1.0]), np.array([5, 1.04]), np.array([5.0, 2.0, 2.0])]
    own = [np.array([1.04, 1.0]), np.array([3.0, 2, 2]), np.array([4.0, 1.2, 1.06])]
    found = summary(own, scratch, searched, (1.05, 1.01))
    ours = found.loc[("ours", 1.05)]
    assert ours["reached"] == pytest.approx(1 / 3)
    assert ours["worse_basin"] == pytest.approx(2 / 3)
    assert ours["median_rollouts"] == math.inf
    # the second goes on from scratch and gets there, the third pays and does not
    assert ours["mean_rollouts"] == pytest.approx((1 + (3 + 2) + (3 + 3)) / 3)
    assert ours["reached_after_all"] == pytest.approx(2 / 3)
    assert ours["mean_spent"] == pytest.approx((2 + 3 + 3) / 3)
    assert ours["jump_start"] == 3.0
    assert ours["asymptote"] == 1.06
    finer = found.loc[("ours", 1.01)]
    assert finer["mean_rollouts"] == pytest.approx((2 + (3 + 2) + (3 + 3)) / 3)
    assert finer["worse_basin"] == pytest.approx(2 / 3)  # of 1.05 all the same
    alone = found.loc[(SCRATCH, 1.05)]
    assert alone["mean_rollouts"] == pytest.approx((4 + 2 + 3) / 3)
    assert alone["worse_basin"] == pytest.approx(1 / 3)
    assert alone["reached_after_all"] == alone["reached"]


def test_searches_of_other_tasks_are_refused():
    searched, costs = fake(1)
    timed = time_searches(costs, searched)
    with pytest.raises(ValueError, match="'ours' has searches of tasks that no"):
        summarise_savings(
            pd.concat(
                [timed[4:].assign(method=SCRATCH), timed.assign(method="ours")],
            )
        )


# All together


@few
@given(st.integers(0, 10**5), st.integers(0, 500), st.integers(1, 500))
def test_break_even_is_the_first_task_at_which_it_is_cheaper(fixed, own, scratch):
    found = break_even(fixed, own, scratch)
    cheaper = [n for n in range(1, 2000) if fixed + n * own < n * scratch]
    if cheaper:
        assert found == cheaper[0]
    else:
        assert found == math.inf or found >= 2000


def test_a_perfect_prediction_is_there_with_the_first_rollout():
    few = table[::60]
    starts = {"perfect": policies[::60], "zero": np.zeros((2, 6))}
    timed = measure_savings(world, few, starts, seed=0, n_starts=1, options=brief)
    assert timed["method"].unique().tolist() == [SCRATCH, "perfect", "zero"]
    perfect = timed[timed["method"] == "perfect"]
    assert (perfect["rollouts"] == 1).all()
    assert perfect["is_reached"].all()
    found = summarise_savings(timed).set_index(["method", "factor"])
    assert found.loc[("perfect", 1.05), "jump_start"] == pytest.approx(1)
    assert found.loc[("zero", 1.05), "jump_start"] > 2
    with pytest.raises(ValueError, match="starts has 'from scratch'; wanted another"):
        measure_savings(world, few, {SCRATCH: policies[::60]}, seed=0)


def test_a_world_s_savings_are_those_of_its_searches(monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[1])
    for name, value in {
        "SAVERS": ("nearest neighbour",),
        "N_SETS": 2,
        "EVERY": 60,
    }.items():
        monkeypatch.setattr(f"msc.study._savings.{name}", value)
    measure = partial(msc.study._savings.measure_savings, options=brief)
    monkeypatch.setattr("msc.study._savings.measure_savings", measure)
    found = run_savings("free", seed=3)
    assert (found["n_tasks"], found["n_sets"], found["n_samples"]) == (2, 2, 24)
    rows = pd.DataFrame(found["summary"])
    assert rows["n_tasks"].tolist() == [2, 2, 2, 2, 4, 4]  # two factors; a set each
    once, scratch, near = rows["mean_spent"][::2]
    assert found["rollouts"] == round(2 * once + 2 * scratch + 4 * near)
    assert near < once < scratch
    [even] = found["break_even"]
    _, scratch, near = rows["mean_rollouts"][::2]
    assert even["tasks"] == break_even(24 * scratch, near, scratch)


def test_an_interrupted_run_goes_on(monkeypatch, tmp_path):
    monkeypatch.chdir(Path(__file__).parents[1])
    few = {"SAVERS": ("nearest neighbour",), "N_SETS": 1, "EVERY": 60, "_PART": 1}
    for name, value in few.items():
        monkeypatch.setattr(f"msc.study._savings.{name}", value)
    briefer = SearchOptions(max_evaluations=9)
    searched, real = [], partial(msc.study._savings.measure_savings, options=briefer)

    def measure(world, table, *given, **options):
        if len(searched) == 3:  # two of them are a task
            raise KeyboardInterrupt
        searched.append(table["task_deg"].item())
        return real(world, table, *given, **options)

    monkeypatch.setattr("msc.study._savings.measure_savings", measure)
    with pytest.raises(KeyboardInterrupt):
        run_savings("free", folder=tmp_path)
    [kept] = tmp_path.glob("free-*/*.json")
    searched.clear()
    monkeypatch.setattr(
        "msc.study._savings.measure_savings",
        lambda *given, **how: (
            searched.append(given[1]["task_deg"].item()) or real(*given, **how)
        ),
    )
    found = run_savings("free", folder=tmp_path)
    first = table["task_deg"].iloc[0]
    assert first not in searched
    assert len(searched) == 2
    assert not kept.exists()
    assert run_savings("free") == found  # all at once
