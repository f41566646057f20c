"""The rungs between charts that are found and charts that are known."""

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.cluster import KMeans

from msc import ParameterizedSkill, Workspace, load_dataset
from msc.data import load_results
from msc.study import build_method, compare_gates, execute_policies
from msc.study._gates import gate_accuracy
from msc.study._ladder import (
    AbstainingSkill,
    BestGate,
    PiecewiseSkill,
    true_jumps,
)
from msc.study._measure import known_charts, measure_method
from msc.study._methods import METHODS
from msc.study.rivals import TriedSkill

tasks = np.linspace(0.1, 6.1, 31)[:, None]
policies = np.hstack([np.sin(tasks), np.cos(tasks)]) + 5 * (tasks > 3.05)
smooth = {"random_state": 0, "verbose": False}


def test_the_true_jumps_are_those_that_survived_bisection():
    (audit,) = load_results("audit_obstacles")
    found = np.degrees(true_jumps(Workspace.obstacles()))
    assert found.tolist() == sorted(found)
    inside = [one for one in audit["jumps"] if one["between_deg"][1] < 360]
    assert len(found) == sum(one["is_jump"] for one in inside)
    for jump in found:
        assert any(
            low < jump < high for low, high in (j["between_deg"] for j in inside)
        )
    assert true_jumps(Workspace.free()) == ()


def test_pieces_do_not_reach_across_a_jump():
    skill = ParameterizedSkill(kernel_per="chart", **smooth)
    model = PiecewiseSkill(skill, jumps=(3.05,)).fit(tasks, policies)
    np.testing.assert_array_equal(model.charts_, tasks[:, 0] > 3.05)
    for side, offset in ((slice(None, 15), 0), (slice(15, None), 5)):
        here = tasks[side, 0]
        new = np.linspace(here.min(), here.max(), 50)[:, None]
        expected = np.hstack([np.sin(new), np.cos(new)]) + offset
        np.testing.assert_allclose(model.predict(new), expected, atol=1e-3)
    other = model.predict([[1.0]], chart=[1])  # who is told, obeys
    assert not np.allclose(other, model.predict([[1.0]]), atol=1)
    assert repr(clone(model)) == repr(PiecewiseSkill(skill, jumps=(3.05,)))


def test_between_two_charts_the_nearest_policy_is_played():
    skill = ParameterizedSkill(KMeans(2, random_state=0), **smooth)
    model = AbstainingSkill(skill).fit(tasks, policies)
    plain = skill.fit(tasks, policies)
    last, first = tasks[14, 0], tasks[15, 0]
    torn = np.array([[0.6 * last + 0.4 * first], [0.4 * last + 0.6 * first]])
    np.testing.assert_array_equal(model.predict(torn), policies[[14, 15]])
    sure = np.array([[1.03], [5.11]])
    np.testing.assert_array_equal(model.predict(sure), plain.predict(sure))


def test_the_best_gate_is_the_one_that_cross_validation_prefers():
    rng = np.random.default_rng(0)
    charts = (np.sin(3 * tasks[:, 0]) > 0).astype(int)
    charts[rng.permutation(31)[:3]] ^= 1
    gate = BestGate().fit(tasks, charts)
    shares = gate_accuracy(tasks, charts, n_splits=5, seed=0)
    assert shares[gate.name_] == max(shares.values()) > min(shares.values())
    compared = compare_gates(tasks, policies, charts=KMeans(2), n_splits=5)
    skill = ParameterizedSkill(KMeans(2), gate=BestGate(), **smooth)
    assert skill.fit(tasks, policies).gate_.name_ == compared["best"]


def test_all_in_one_chart_needs_no_gate():
    gate = BestGate().fit(tasks, np.zeros(31, dtype=int))
    assert (gate.predict(tasks) == 0).all()


def test_a_true_gate_is_told_by_the_test_tasks_own_policies():
    datasets = grid, test = load_dataset("obstacles"), load_dataset("obstacles_test")
    chosen, where = np.arange(0, 360, 15), Workspace.obstacles()
    name = "ladder: linkage, true gate"
    method = build_method(name, workspace=where).fit(
        grid.tasks[chosen], grid.policies[chosen]
    )
    charts = known_charts(method, grid.policies[chosen], test.policies)
    expected = method.predict(test.tasks, chart=charts)
    found = measure_method(name, method, where, datasets, chosen)["mse"]
    errors = np.mean((expected - test.policies) ** 2, axis=1)
    np.testing.assert_allclose(found, errors, rtol=1e-6, atol=1e-9)
    learned = measure_method("ladder: linkage", method, where, datasets, chosen)
    assert learned["mse"].mean() > found.mean()


@pytest.mark.parametrize("name", [one for one in METHODS if one.startswith("ladder")])
def test_every_rung_has_one_kernel_a_chart(name):
    method = build_method(name, workspace=Workspace.obstacles())
    params = method.get_params()
    found = [value for key, value in params.items() if key.endswith("kernel_per")]
    assert found == ["chart"]


# A gate that tries


def paid_beside(jump):
    """Return what executes, for a curve that is lifted where tasks pass a jump."""

    def execute(found, X):
        wanted = np.hstack([np.sin(X), np.cos(X)]) + 5 * (jump < X)
        return ((found - wanted) ** 2).sum(axis=1)

    return execute


def tried(execute):
    skill = ParameterizedSkill(KMeans(2, random_state=0), **smooth)
    return TriedSkill(skill, execute=execute).fit(tasks, policies)


@pytest.mark.parametrize("share", [0.1, 0.4, 0.6, 0.9])
def test_who_tries_two_charts_is_right_wherever_the_jump_is(share):
    last, first = tasks[14, 0], tasks[15, 0]
    jump = last + share * (first - last)
    gap = np.linspace(last, first, 20)[1:-1, None]
    model = tried(paid_beside(jump))
    assert (model.predict(gap)[:, 0] > 2.5).tolist() == (gap[:, 0] > jump).tolist()
    nearest = model.skill_.predict(gap)[:, 0] > 2.5
    assert (nearest != (gap[:, 0] > jump)).any()


def test_the_first_that_is_tried_is_the_nearest_task_s_chart():
    new = np.linspace(0, 6.2, 50)[:, None]
    model = tried(lambda found, _: np.ones(len(found)))  # whose ties go to the first
    np.testing.assert_array_equal(model.predict(new), model.skill_.predict(new))


def test_two_rollouts_a_task_are_counted_and_none_where_there_is_one_chart():
    model = tried(paid_beside(3.05))
    model.predict(tasks[:4]), model.predict(tasks[:3])
    assert model.n_rollouts_ == 2 * (4 + 3)
    one = TriedSkill(ParameterizedSkill(None, **smooth), execute=paid_beside(3.05))
    one.fit(tasks, policies).predict(tasks)
    assert one.n_rollouts_ == 0


def test_on_the_arm_a_trial_keeps_what_costs_less():
    grid, test = load_dataset("obstacles"), load_dataset("obstacles_test")
    chosen, where = np.arange(0, 360, 15), Workspace.obstacles()
    known = grid.tasks[chosen], grid.policies[chosen]
    method = build_method("ladder: pieces, by trial", workspace=where).fit(*known)
    some = slice(None, None, 4)
    found = method.predict(test.tasks[some])
    table = test.table[some]
    costs = [
        execute_policies(where, policy, table)["excess_cost"]
        for policy in (found, method.skill_.predict(test.tasks[some]))
    ]
    assert (costs[0] <= costs[1] + 1e-9).all()
    assert (costs[0] < costs[1] - 1e-3).any()
