import numpy as np
import pandas as pd
import pytest

import msc.survey
from msc.search import SearchResult
from msc.survey import choose_layout, locate_cut
from msc.tables import WEIGHTS
from msc.workspace import random_circles


@pytest.mark.parametrize(("tie", "cut"), [(70.2, 70.5), (70.5, 70.5), (70.6, 71.0)])
def test_the_cut_is_where_both_sides_cost_the_same(tie, cut, monkeypatch):
    def search(world, angle, *, seed, n_starts=4, start_policies=()):
        assert world.cut_deg == 0
        side = start_policies[0] if start_policies else np.sign(angle - 45)
        cost = 10 - side * (angle - tie) / 100
        return SearchResult(side, cost, 0.0, 0.0, 0.0, ())

    monkeypatch.setattr(msc.survey, "search_policy", search)
    found = locate_cut()
    assert found["tie_deg"] == pytest.approx(tie)
    assert found["cut_deg"] == cut
    angles = np.array(found["world_angle_deg"])
    np.testing.assert_allclose(found["cost_from_below"], 10 + (angles - tie) / 100)
    np.testing.assert_allclose(found["cost_from_above"], 10 - (angles - tie) / 100)


def test_the_layout_is_the_first_that_can_be_reached_and_jumps(monkeypatch, tmp_path):
    n_jumps, farthest = [5, 2, 3, 9], [0.02, 0.001, 0.009, 0.001]
    plans = []

    def search(plan, *, jobs, journal, progress):
        layout = len(plans)
        plans.append(plan)
        assert journal == tmp_path / f"layout_{layout}.partial"
        n_tasks = len(plan.tasks_deg)
        angles = np.deg2rad(plan.tasks_deg)
        lifts = 5 * np.searchsorted(np.arange(1, n_jumps[layout] + 1) * 7, range(72))
        table = pd.DataFrame({"task_deg": plan.tasks_deg, "distance_m": 0.0})
        table.loc[n_tasks // 2, "distance_m"] = farthest[layout]
        return table.assign(**{name: np.sin(angles) + lifts for name in WEIGHTS})

    monkeypatch.setattr(msc.survey, "search_tasks", search)
    found = choose_layout(seed=4, journals=tmp_path)
    assert [one["chosen"] for one in found["layouts"]] == [False, False, True]
    assert [one["layout"] for one in found["layouts"]] == [0, 1, 2]
    assert [len(one["jumps_after_deg"]) for one in found["layouts"]] == n_jumps[:3]
    assert [one["largest_distance_m"] for one in found["layouts"]] == farthest[:3]
    for layout, plan in enumerate(plans):
        assert plan.workspace.circles == random_circles(layout)
        assert (plan.seed, len(plan.tasks_deg)) == (4, 72)
