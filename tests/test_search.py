import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kendalltau

import msc.search._policy
from msc import DMP, Arm, Rollout, SearchResult, Workspace, search_policy
from msc.robot import CostWeights, forward_kinematics
from msc.search import SearchOptions, cost, initial_covariance, record_search
from msc.search._cmaes import CmaRun, _kendall, minimize
from msc.search._lockstep import run_in_lockstep
from msc.search._policy import random_start, search_steps

free = Workspace.free()
rough = np.array([3.0, -2.0, 1.0, 0.5, 2.0, -1.0])
brief = SearchOptions(max_evaluations=44, agreement=2.0)  # five times nine
once = SearchOptions(max_evaluations=8, agreement=2.0)
thrice = replace(brief, max_evaluations=26)  # generations of nine
search = partial(search_policy, options=thrice)


def bits(result):
    runs = [
        (one.name, one.policy.tobytes(), one.cost, one.evaluations, one.merged_into)
        for one in result.runs
    ]
    measured = result.cost, result.error, result.energy, result.contact_impulse
    return runs, result.policy.tobytes(), measured


# The cost


def test_the_cost_weighs_squared_distance_and_energy():
    still = np.zeros((2, 3))
    rollout = Rollout(still, still[:, :2], error=0.02, energy=4.0, contact_impulse=9.0)
    assert cost(rollout) == pytest.approx(100 * 0.02**2 + 0.005 * 4.0)


def test_a_world_may_pay_for_contact_and_for_length():
    joints = np.array([[0.0, 0.0, 0.0], [0.5, -1.0, 0.0], [0.25, -1.0, 2.0]])
    rollout = Rollout(joints, joints[:, :2], 0.02, energy=4.0, contact_impulse=9.0)
    assert rollout.length == 0.5 + 1.0 + 0.25 + 2.0
    usual = cost(rollout)
    assert cost(rollout, CostWeights()) == usual
    assert cost(rollout, CostWeights(contact=0.3)) == pytest.approx(usual + 0.3 * 9.0)
    assert cost(rollout, CostWeights(length=0.2)) == pytest.approx(usual + 0.2 * 3.75)
    only = CostWeights(error=2.0, energy=0.0, contact=1.0, length=1.0)
    assert cost(rollout, only) == pytest.approx(2 * 0.02**2 + 9.0 + 3.75)


@pytest.mark.parametrize("pays", [CostWeights(energy=0.02), CostWeights(length=0.1)])
def test_a_search_minimizes_what_its_world_pays_for(pays):
    world = replace(Workspace.obstacles(), cost=pays)
    found = search(world, 200, seed=0, n_starts=1, options=once)
    with Arm(world) as arm:
        rollout = arm.execute(found.policy, 200)
    assert found.cost == cost(rollout, pays) == min(one.cost for one in found.runs)
    assert found.cost > cost(rollout)


@pytest.mark.parametrize("name", ["free", "obstacles"])
def test_a_result_costs_what_its_policy_does(name):
    world = Workspace.named(name)
    found = search(world, 200, seed=0, n_starts=2, start_policies=[rough])
    with Arm(world) as arm:
        rollout = arm.execute(found.policy, 200)
    assert found.cost == cost(rollout) == min(one.cost for one in found.runs)
    assert (found.error, found.energy) == (rollout.error, rollout.energy)
    assert found.contact_impulse == rollout.contact_impulse


# Determinism


def test_a_search_is_a_function_of_task_and_seed():
    first = search(free, 200, seed=3, n_starts=2)
    assert bits(search(free, 200, seed=4, n_starts=2)) != bits(first)
    assert bits(search(free, 201, seed=3, n_starts=2)) != bits(first)
    assert bits(search(free, 200, seed=3, n_starts=2)) == bits(first)
    assert bits(search(free, 560, seed=3, n_starts=2)) == bits(first)


def test_the_global_generator_is_neither_used_nor_moved():
    np.random.random(5)  # noqa: NPY002
    before = np.random.get_state()  # noqa: NPY002
    first = search(free, 200, seed=3, n_starts=1)
    after = np.random.get_state()  # noqa: NPY002
    assert (before[1] == after[1]).all()
    assert before[2:] == after[2:]
    np.random.random(7)  # noqa: NPY002
    assert bits(search(free, 200, seed=3, n_starts=1)) == bits(first)


def test_more_starts_go_on_from_fewer():
    one = search(free, 90, seed=0, n_starts=1)
    two = search(free, 90, seed=0, n_starts=2)
    assert bits(two)[0][:1] == bits(one)[0]
    assert two.cost <= one.cost
    again = search(free, 90, seed=0, n_starts=1, incumbent=one)
    assert bits(again) == bits(two)


def test_every_run_draws_numbers_of_its_own(monkeypatch):
    drawn = []

    def draw(x0, sigma0, rng, sqrt_cov, costs_of, *, name, **_):
        drawn.append(rng.standard_normal())
        yield x0[np.newaxis]
        return CmaRun(name, x0, 1.0, 9)

    monkeypatch.setattr(msc.search._policy, "minimize_steps", draw)
    for seed in (0, 1):
        for task in (0, 0.125, 90, 359.875):
            starts = {"n_starts": 3, "start_policies": [rough, rough]}
            search_policy(free, task, seed=seed, **starts)
    assert len(set(drawn)) == len(drawn) == 2 * 4 * 5


# Starts


def test_the_first_start_is_the_zero_policy_and_the_others_are_anywhere():
    dmp, rng = DMP(), np.random.default_rng(0)
    assert not random_start(0, 8.0, dmp, rng).any()
    drawn = np.array([random_start(number, 8.0, dmp, rng) for number in range(1, 200)])
    assert drawn.mean() == pytest.approx(0, abs=1)
    assert drawn.std() == pytest.approx(8.0, rel=0.1)


def test_every_start_is_kept():
    found = search(free, 90, seed=0, n_starts=3)
    assert [one.name for one in found.runs] == ["start 0", "start 1", "start 2"]
    assert found.evaluations == sum(one.evaluations for one in found.runs)
    assert len({one.policy.tobytes() for one in found.runs}) == 3


def test_given_policies_come_first_and_are_searched_around():
    given = [rough, -rough]
    found = search(free, 90, seed=0, n_starts=2, start_policies=given, options=once)
    names = ["given 0", "given 1", "start 0", "start 1"]
    assert [one.name for one in found.runs] == names
    for start, policy in zip(found.runs, given, strict=False):
        assert 0 < np.linalg.norm(start.policy - policy) < 5
    only = search(free, 90, seed=0, n_starts=0, start_policies=[rough], options=once)
    assert only.winner == "given 0"


def test_independent_starts_are_numbered_on_from_those_before():
    found = search(free, 90, seed=0, n_starts=2, start_policies=[rough])
    again = search(
        free, 90, seed=0, n_starts=1, start_policies=[-rough], incumbent=found
    )
    assert [one.name for one in again.runs[3:]] == ["given 0", "start 2"]
    assert bits(again)[0][:3] == bits(found)[0]


def test_what_is_found_never_gets_worse():
    found = search(free, 30, seed=0, n_starts=1)
    for seed, start in enumerate([np.full(6, 40.0), found.policy, -rough]):
        better = search(
            free, 30, seed=seed, n_starts=0, start_policies=[start], incumbent=found
        )
        assert better.cost <= found.cost
        assert bits(better)[0][:-1] == bits(found)[0]
        found = better
    assert len(found.runs) == 4


def test_an_incumbent_of_another_task_is_refused():
    found = result((1, 1.0))
    with pytest.raises(ValueError, match=r"incumbent is of task 30°; wanted one of 10"):
        search(free, 10, seed=0, incumbent=found)


def test_a_hopeless_start_leaves_the_incumbent():
    found = search(free, 30, seed=0, n_starts=1)
    again = search(
        free, 30, seed=0, n_starts=0, start_policies=[np.full(6, 90.0)], incumbent=found
    )
    assert again.winner == "start 0"
    assert bits(again)[1:] == bits(found)[1:]


# Runs that come upon a known policy


def flat(policies):
    """Cost next to nothing more anywhere: CMA-ES stays where it is."""
    return [1 + 1e-3 * one @ one / (rough @ rough) for one in policies]


narrow = 0.003 * np.eye(6)


def run(x0, known, *, sqrt_cov=narrow, seed=0, options=brief):
    """Run CMA-ES from a policy."""
    rng = np.random.default_rng(seed)
    return minimize(flat, x0, 1.0, rng, sqrt_cov, known=known, options=options)


def test_a_run_merges_into_the_one_whose_policy_it_comes_upon():
    known = CmaRun("a", -rough, 0.0, 9), CmaRun("b", rough, 0.0, 9)
    assert run(rough, known).merged_into == 1
    assert run(rough, known).evaluations == 9
    assert run(-rough, known).merged_into == 0
    assert run(9 * rough, known).merged_into == -1
    assert run(9 * rough, known).evaluations == 45
    assert run(rough, ()).merged_into == -1


def test_a_run_that_comes_upon_a_merged_one_merges_into_the_first():
    known = [CmaRun("a", rough, 0.0, 9)]
    for factor in (1.04, 1.08, 1.12):
        known.append(run(factor * rough, known))
    assert [one.merged_into for one in known] == [-1, 0, 0, 0]
    assert run(1.12 * rough, known[:1]).merged_into == -1


@pytest.mark.parametrize(("share", "merged_into"), [(0.048, 0), (0.052, -1)])
def test_near_is_a_twentieth_of_the_known_policy_s_norm(share, merged_into):
    found = run((1 + share) * rough, [CmaRun("a", rough, 0.0, 9)], options=once)
    assert found.merged_into == merged_into


def test_a_near_but_cheaper_run_is_not_stopped():
    found = run(rough, [CmaRun("a", rough, 1.01, 9)])
    assert (found.merged_into, found.evaluations) == (-1, 45)


@pytest.mark.parametrize(("share", "merged_into"), [(0.045, 0), (0.065, -1)])
def test_a_run_that_looks_farther_in_one_direction_is_not_near(share, merged_into):
    widths = share * np.linalg.norm(rough) * np.array([1, 0, 0, 0, 0, 0])
    wide = np.diag(widths) + 1e-3 * np.eye(6)
    known = [CmaRun("a", rough, 0.0, 9)]  # seed 4: its mean moves little
    found = run(rough, known, sqrt_cov=wide, seed=4, options=once)
    assert found.merged_into == merged_into


@pytest.mark.parametrize(("paid", "evaluations"), [(39.0, 99), (41.0, 126)])
def test_a_run_that_would_not_catch_up_at_its_pace_is_given_up(paid, evaluations):
    best = iter(range(100, 0, -1))  # one less each generation: 90 after the eleventh

    def costs(policies):
        return next(best) + np.arange(len(policies)) / 100

    known = CmaRun("a", 9 * rough, paid, 9), CmaRun("b", -9 * rough, 99.0, 9)
    options = SearchOptions(
        agreement=2.0, max_evaluations=120, stalled=10, patience=5.0
    )
    rng = np.random.default_rng(0)
    found = minimize(costs, rough, 1.0, rng, np.eye(6), known=known, options=options)
    assert (found.merged_into, found.evaluations) == (-1, evaluations)


def test_a_search_lets_runs_merge_into_those_before():
    far = 10 * rough
    starts = CmaRun("start 0", far, 0.0, 9), CmaRun("given 0", 2 * far, 1.0, 9, 0)
    known = SearchResult(30, far, 0.0, 0.0, 0.0, 0.0, starts)
    again = search(
        free,
        30,
        seed=0,
        n_starts=0,
        start_policies=[far, 2.02 * far, -far, -far],
        incumbent=known,
    )
    assert [one.merged_into for one in again.runs] == [-1, 0, 0, 0, -1, -1]
    assert again.n_agreeing == 4
    assert again.runs[2].evaluations < again.runs[4].evaluations


# Flat beginnings


def test_a_start_on_a_plateau_has_failed_and_counts_for_none():
    plateau = CmaRun("start 0", rough, 0.5, 9, failed=True)
    assert minimize(
        lambda policies: np.ones(len(policies)),
        rough,
        1.0,
        np.random.default_rng(0),
        narrow,
        options=SearchOptions(),
    ).failed
    assert not run(rough, ()).failed
    assert run(rough, [plateau]).merged_into == -1
    ends = plateau, CmaRun("start 1", rough, 1.0, 200)
    found = SearchResult(30, rough, 1.0, 0.0, 0.0, 0.0, ends)
    assert (found.winner, found.n_agreeing) == ("start 1", 1)
    assert math.isnan(found.margin)


def test_a_task_whose_cost_is_flat_is_named(monkeypatch):
    monkeypatch.setattr(msc.search._policy, "cost", lambda *_: 1.0)
    with pytest.raises(RuntimeError, match="task 30°: all 2 starts ended"):
        search_policy(free, 30, seed=0, n_starts=2)


# The surrogate


@pytest.mark.parametrize("seed", range(5))
def test_the_surrogate_finds_what_plain_cma_es_finds_in_a_third_of_the_rollouts(seed):
    """On a quadratic, tilted and 1000 times longer than wide."""
    turned = np.linalg.qr(np.random.default_rng(seed).standard_normal((6, 6)))[0]
    bent = turned @ np.diag(np.logspace(0, 3, 6)) @ turned.T

    def costs(policies):
        return 1 + np.einsum("ki,ij,kj->k", policies - 1, bent, policies - 1)

    def found(agreement):
        options = SearchOptions(agreement=agreement)
        rng = np.random.default_rng(seed)
        return minimize(costs, np.zeros(6), 1.0, rng, np.eye(6), options=options)

    guided, plain = found(0.85), found(2.0)
    np.testing.assert_allclose(guided.policy, 1, atol=1e-3)
    assert guided.cost <= plain.cost + 1e-6
    assert guided.evaluations < plain.evaluations / 3


def test_what_is_counted_and_found_was_executed():
    asked = []

    def costs(policies):
        asked.extend(policies.copy())
        return np.sum(np.abs(policies - 2) ** 1.5, axis=1)

    options, rng = SearchOptions(max_evaluations=200), np.random.default_rng(0)
    found = minimize(costs, rough, 1.0, rng, np.eye(6), options=options)
    assert found.evaluations == len(asked)
    values = [costs(policy[None])[0] for policy in asked.copy()]
    assert found.cost == min(values)
    np.testing.assert_array_equal(found.policy, asked[np.argmin(values)])


rankings = st.lists(st.integers(0, 5), min_size=3, max_size=15)


@given(st.data(), rankings)
def test_agreement_is_kendall_s_tau_without_ties(data, one):
    other = data.draw(st.permutations(range(len(one))))
    one = np.argsort(np.argsort(one, kind="stable"))
    expected = kendalltau(one, other).statistic
    assert _kendall(one, np.array(other)) == pytest.approx(expected)


# In lock-step


def test_searches_in_lock_step_find_what_each_finds_alone():
    tasks = [20.0, 60.0, 100.0, 140.0, 180.0, 220.0]
    world, told = Workspace.obstacles(), {"seed": 1, "n_starts": 1}
    options = SearchOptions(max_evaluations=9)
    steps = [
        (task, search_steps(world, task, options=options, **told)) for task in tasks
    ]
    together = dict(run_in_lockstep(world, steps))
    for number, task in enumerate(tasks):
        alone = search_policy(world, task, options=options, **told)
        assert bits(together[number]) == bits(alone)


# What the starts say together


def result(*ends):
    """Make a result of starts, each from (multiple of `rough`, cost, merged_into)."""
    starts = tuple(
        CmaRun(f"start {number}", factor * rough, cost, 9, *merged_into)
        for number, (factor, cost, *merged_into) in enumerate(ends)
    )
    best = min(starts, key=lambda start: start.cost)
    return SearchResult(30, best.policy, best.cost, 0.0, 0.0, 0.0, starts)


def test_agreement_is_merging_or_ending_within_a_percent():
    found = result((1.0, 1.0), (1.005, 2.0), (1.02, 3.5), (1.08, 4.0, 0), (-1, 3.0, 2))
    assert found.winner == "start 0"
    assert found.n_agreeing == 3
    assert found.evaluations == 45
    assert found.margin == 2.0


def test_the_margin_is_to_the_best_run_that_ended_elsewhere():
    assert result((1, 1.5), (-1, 1.25), (2, 4.0)).margin == 0.25
    assert result((-1, 2.0), (1, 1.0), (1, 3.0, 0), (1.001, 1.5)).margin == 1.0


def test_without_a_run_that_ended_elsewhere_there_is_no_margin():
    for found in (result((1, 1.0)), result((1, 1.0), (1.009, 1.1), (3, 9.0, 1))):
        assert math.isnan(found.margin)
        assert found.n_agreeing == len(found.runs)


ends = st.tuples(st.sampled_from([1, 1.009, 1.02, -1]), st.floats(1, 2))


@settings(deadline=None)
@given(st.lists(ends, min_size=1, max_size=6))
def test_no_run_is_better_and_one_agrees_at_least(ends):
    found = result(*ends)
    elsewhere = len(ends) - found.n_agreeing
    assert 0 <= elsewhere < len(ends)
    assert found.margin >= 0 if elsewhere else math.isnan(found.margin)


# The first covariance


def bend(dmp, task, world=free):
    """Find by differences how the cost that `initial_covariance` describes bends."""
    times = np.linspace(0, 1, 1001)
    start = forward_kinematics(world.home, world.link_lengths)[-1]
    target = world.target(task)

    def described(policy):
        path = dmp.path(policy, start, target, times)
        speed = np.diff(path, axis=0) / times[1] / world.link_lengths[0]
        return 100 * np.sum((path[-1] - target) ** 2) + 5e-3 * times[1] * np.sum(
            speed**2
        )

    unit = np.eye(dmp.n_params)
    return np.array(
        [
            [
                described(a + b) - described(a) - described(b) + described(0 * a)
                for a in unit
            ]
            for b in unit
        ]
    )


@pytest.mark.parametrize("task", [0, 100, 222])
@pytest.mark.parametrize(
    "dmp", [DMP(), DMP(gated=True), DMP(n_basis=4), DMP(n_basis=4, gated=True)]
)
def test_in_the_covariance_s_coordinates_the_described_cost_is_round(dmp, task):
    root, bent = initial_covariance(free, task, dmp), bend(dmp, task)
    assert np.linalg.det(root) == pytest.approx(1)
    assert np.linalg.cond(bent) > 1e4
    assert np.linalg.cond(root.T @ bent @ root) < 1.1


def test_where_weights_do_nothing_there_is_a_covariance_all_the_same():
    world = replace(free, home=(math.pi / 2, 0.0, 0.0))
    task = 90 - world.cut_deg  # straight below the end effector
    root = initial_covariance(world, task, DMP())
    assert np.linalg.cond(bend(DMP(), task, world)) > 1e15
    assert np.isfinite(root).all()
    assert np.linalg.det(root) == pytest.approx(1)


# Bad input


def test_no_start_at_all_is_refused():
    with pytest.raises(ValueError, match=r"n_starts=0 .* at least one start"):
        search(free, 0, seed=0, n_starts=0)


def test_a_negative_number_of_starts_is_refused():
    with pytest.raises(ValueError, match=r"n_starts=-1"):
        search(free, 0, seed=0, n_starts=-1, start_policies=[rough])


@pytest.mark.parametrize("task", [np.nan, np.inf])
def test_a_task_that_is_no_angle_is_refused(task):
    with pytest.raises(ValueError, match=f"task_deg={task}; wanted a finite angle"):
        search(free, task, seed=0)


@pytest.mark.parametrize("given", [np.zeros(5), np.full(6, np.nan)])
def test_a_malformed_start_is_refused(given):
    with pytest.raises(ValueError, match=r"policy has"):
        search(free, 0, seed=0, start_policies=[given])


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match="seed=-1"):
        search(free, 0, seed=-1)


# Options


def test_each_option_is_heeded():
    """A search told otherwise runs otherwise, in the respect that the option names."""
    started = {"seed": 0, "n_starts": 2, "start_policies": [rough]}
    usual = search_policy(free, 90, **started, options=thrice)

    def told(**changed):
        how = replace(thrice, **changed)
        return search_policy(free, 90, **started, options=how).runs

    given, zero, drawn = usual.runs
    assert told(population=11)[0].evaluations == 33
    assert told(max_evaluations=9)[0].evaluations == 18
    narrow = told(small_step=0.1)
    assert narrow[0].cost != given.cost
    assert narrow[1].cost == zero.cost
    wide = told(first_step=1.0)
    assert wide[0].cost == given.cost
    assert wide[1].cost != zero.cost
    assert wide[2].cost != drawn.cost
    with pytest.raises(RuntimeError, match="ended with their first generation"):
        told(tolerance=1e9)
    assert told(stalled=1, gain=0.9)[0].evaluations == 18
    assert told(near=1e9)[1].merged_into == 0
    assert told(agreement=0.5)[0].cost != given.cost
    assert usual.n_agreeing == 1
    assert replace(usual, same=99.0).n_agreeing == 3
    agreeing = search(free, 90, seed=0, n_starts=2, options=replace(thrice, same=99.0))
    assert agreeing.n_agreeing == 2


@pytest.mark.parametrize(
    ("name", "value", "wanted"),
    [
        ("max_evaluations", 0, "a whole number, at least 1"),
        ("max_evaluations", 9.5, "a whole number, at least 1"),
        ("max_sweeps", -1, "a whole number, at least 0"),
        ("population", 1, "a whole number, at least 2"),
        ("near", 0.0, "a finite number above 0"),
        ("near", math.nan, "a finite number above 0"),
        ("first_step", math.inf, "a finite number above 0"),
        ("gain", "1e-5", "a finite number above 0"),
    ],
)
def test_an_option_that_is_no_such_number_is_refused(name, value, wanted):
    with pytest.raises(ValueError, match=f"{name}={value!r}; wanted {wanted}"):
        SearchOptions(**{name: value})


@given(
    st.builds(
        SearchOptions,
        first_step=st.floats(1e-300, 1e300),
        max_evaluations=st.integers(1, 10**9),
        coarse_deg=st.integers(1, 360),
    )
)
def test_options_that_are_told_are_read_again(options):
    again = SearchOptions.parse(options.changed)
    assert again == options
    assert repr(again) == repr(options)


def test_the_defaults_need_no_telling():
    assert SearchOptions().changed == ()
    told = SearchOptions(max_evaluations=np.int64(45), near=1).changed
    assert told == ("max_evaluations=45", "near=1.0")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("max_evals=9", "'max_evals=9' sets nothing known; wanted NAME=VALUE with a "),
        ("near", "near=''; wanted a number"),
        ("near=much", "near='much'; wanted a number"),
        ("max_sweeps=1.5", "max_sweeps=1.5; wanted a whole number"),
    ],
)
def test_a_text_that_sets_nothing_is_refused(text, said):
    with pytest.raises(ValueError, match=said):
        SearchOptions.parse([text])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("agreement", [0.85, 2])
def test_costs_that_rank_no_policies_are_refused(bad, agreement):
    options = SearchOptions(agreement=agreement)
    for costs in (lambda p: [bad] + [1.0] * (len(p) - 1), lambda _: [1.0]):
        with pytest.raises(ValueError, match=r"costs gave .* wanted a finite number"):
            minimize(
                costs,
                np.zeros(6),
                1.0,
                np.random.default_rng(0),
                np.eye(6),
                options=options,
            )


@pytest.mark.parametrize("search", [search_policy, record_search])
@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("seed", 1.5),
        ("seed", None),
        ("seed", -1),
        ("n_starts", 1.5),
        ("task_deg", np.nan),
        ("task_deg", "north"),
    ],
)
def test_what_is_no_number_as_wanted_is_named(search, argument, value):
    asked = {"task_deg": 200.0, "seed": 1, "n_starts": 1, argument: value}
    with pytest.raises(ValueError, match=argument):
        search(free, asked.pop("task_deg"), **asked)
