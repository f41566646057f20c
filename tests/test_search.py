import numpy as np
import pytest

import msc.search
from msc.arm import Arm, Rollout
from msc.dmp import DMP
from msc.search import SearchResult, Start, cost, random_start, search_policy
from msc.workspace import Workspace

free = Workspace.free()
rough = np.array([3.0, -2.0, 1.0, 0.5, 2.0, -1.0])


@pytest.fixture(autouse=True)
def few_evaluations(monkeypatch):
    monkeypatch.setattr(msc.search, "MAX_EVALUATIONS", 45)


def bits(result):
    runs = [
        (one.name, one.policy.tobytes(), one.cost, one.evaluations, one.joined)
        for one in result.starts
    ]
    measured = result.cost, result.error, result.energy, result.contact_impulse
    return runs, result.policy.tobytes(), measured


# The cost


def test_the_cost_weighs_squared_distance_and_energy():
    still = np.zeros((2, 3))
    rollout = Rollout(still, still[:, :2], error=0.02, energy=4.0, contact_impulse=9.0)
    assert cost(rollout) == pytest.approx(100 * 0.02**2 + 0.005 * 4.0)


def test_a_result_costs_what_its_policy_does():
    found = search_policy(free, 200, seed=0, n_starts=2)
    with Arm(free) as arm:
        rollout = arm.execute(found.policy, 200)
    assert found.cost == cost(rollout) == min(one.cost for one in found.starts)
    assert (found.error, found.energy) == (rollout.error, rollout.energy)
    assert found.contact_impulse == rollout.contact_impulse


# Determinism


def test_a_search_is_a_function_of_task_and_seed():
    first = search_policy(free, 200, seed=3, n_starts=2)
    assert bits(search_policy(free, 200, seed=4, n_starts=2)) != bits(first)
    assert bits(search_policy(free, 201, seed=3, n_starts=2)) != bits(first)
    assert bits(search_policy(free, 200, seed=3, n_starts=2)) == bits(first)
    assert bits(search_policy(free, 560, seed=3, n_starts=2)) == bits(first)


def test_the_global_generator_is_neither_used_nor_moved():
    np.random.random(5)  # noqa: NPY002
    before = np.random.get_state()  # noqa: NPY002
    first = search_policy(free, 200, seed=3, n_starts=1)
    after = np.random.get_state()  # noqa: NPY002
    assert (before[1] == after[1]).all()
    assert before[2:] == after[2:]
    np.random.random(7)  # noqa: NPY002
    assert bits(search_policy(free, 200, seed=3, n_starts=1)) == bits(first)


def test_more_starts_go_on_from_fewer():
    one = search_policy(free, 90, seed=0, n_starts=1)
    two = search_policy(free, 90, seed=0, n_starts=2)
    assert bits(two)[0][:1] == bits(one)[0]
    assert two.cost <= one.cost


# Starts


def test_the_first_start_is_the_zero_policy_and_the_others_are_anywhere():
    dmp, rng = DMP(), np.random.default_rng(0)
    assert not random_start(0, dmp, rng).any()
    drawn = np.array([random_start(number, dmp, rng) for number in range(1, 200)])
    assert drawn.mean() == pytest.approx(0, abs=1)
    assert drawn.std() == pytest.approx(dmp.spring / 2, rel=0.1)


def test_every_start_is_kept():
    found = search_policy(free, 90, seed=0, n_starts=3)
    assert [one.name for one in found.starts] == ["start 0", "start 1", "start 2"]
    assert found.evaluations == sum(one.evaluations for one in found.starts)
    assert len({one.policy.tobytes() for one in found.starts}) == 3


def test_a_given_policy_is_searched_around(monkeypatch):
    monkeypatch.setattr(msc.search, "MAX_EVALUATIONS", 9)
    found = search_policy(free, 90, seed=0, n_starts=1, start_policies=[rough])
    assert [one.name for one in found.starts] == ["start 0", "given 0"]
    assert np.linalg.norm(found.starts[1].policy - rough) < 5
    only = search_policy(free, 90, seed=0, n_starts=0, start_policies=[rough])
    assert only.winner == "given 0"


def test_what_is_found_never_gets_worse():
    found = search_policy(free, 30, seed=0, n_starts=1)
    for seed, start in enumerate([np.full(6, 40.0), found.policy, -rough]):
        better = search_policy(
            free, 30, seed=seed, n_starts=0, start_policies=[start], incumbent=found
        )
        assert better.cost <= found.cost
        assert bits(better)[0][:-1] == bits(found)[0]
        found = better
    assert len(found.starts) == 4


def test_a_hopeless_start_leaves_the_incumbent():
    found = search_policy(free, 30, seed=0, n_starts=1)
    again = search_policy(
        free, 30, seed=0, n_starts=0, start_policies=[np.full(6, 90.0)], incumbent=found
    )
    assert again.winner == "start 0"
    assert bits(again)[1:] == bits(found)[1:]


def test_a_start_that_comes_upon_a_known_policy_joins_it():
    far = 10 * rough
    starts = Start("start 0", far, 0.0, 9), Start("a", 2 * far, 1.0, 9, "start 0")
    known = SearchResult(far, 0.0, 0.0, 0.0, 0.0, starts)
    again = search_policy(
        free,
        30,
        seed=0,
        n_starts=0,
        start_policies=[far, 2.02 * far, -far],
        incumbent=known,
    )
    joined = [one.joined for one in again.starts[2:]]
    assert joined == ["start 0", "start 0", ""]
    assert again.n_agreeing == 4
    assert again.starts[2].evaluations < again.starts[4].evaluations


def test_agreement_is_joining_or_ending_within_a_percent():
    def start(name, factor, cost, joined=""):
        return Start(name, factor * rough, cost, 9, joined)

    starts = (
        start("start 0", 1.0, 1.0),
        start("start 1", 1.005, 2.0),
        start("start 2", 1.02, 3.0),
        start("start 3", 1.08, 4.0, joined="start 0"),
        start("start 4", -1.0, 5.0, joined="start 2"),
    )
    found = SearchResult(rough, 1.0, 0.0, 0.0, 0.0, starts)
    assert found.winner == "start 0"
    assert found.n_agreeing == 3
    assert found.evaluations == 45


# Bad input


def test_no_start_at_all_is_refused():
    with pytest.raises(ValueError, match=r"n_starts=0 .* at least one start"):
        search_policy(free, 0, seed=0, n_starts=0)


def test_a_negative_number_of_starts_is_refused():
    with pytest.raises(ValueError, match=r"n_starts=-1"):
        search_policy(free, 0, seed=0, n_starts=-1, start_policies=[rough])


@pytest.mark.parametrize("task", [np.nan, np.inf])
def test_a_task_that_is_no_angle_is_refused(task):
    with pytest.raises(ValueError, match=f"task_deg={task}; wanted a finite angle"):
        search_policy(free, task, seed=0)


@pytest.mark.parametrize("given", [np.zeros(5), np.full(6, np.nan)])
def test_a_malformed_start_is_refused(given):
    with pytest.raises(ValueError, match=r"policy has"):
        search_policy(free, 0, seed=0, start_policies=[given])


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match="seed=-1"):
        search_policy(free, 0, seed=-1)
