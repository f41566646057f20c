"""Tasks of several numbers: who takes them, and what is found among them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import approx_fprime
from scipy.spatial import Delaunay
from scipy.stats import qmc
from sklearn.base import BaseEstimator
from sklearn.cluster import KMeans
from sklearn.gaussian_process.kernels import RBF, ExpSineSquared
from sklearn.linear_model import LinearRegression
from sklearn.metrics import adjusted_rand_score
from sklearn.model_selection import RandomizedSearchCV
from sklearn.svm import SVC

from msc import DMP, SMCE, ParameterizedSkill, Workspace
from msc.data import find_jump_edges, find_pieces, task_edges
from msc.learn import GATES, seeded_clone
from msc.learn._gaussian import Periodic
from msc.robot import CostWeights, TaskRange, cached_arm
from msc.search import coordinates, cost, draw_tasks, tasks_at
from msc.study import METHODS, build_method, fit_methods
from msc.study._ladder import AbstainingSkill, BestGate
from msc.study.rivals import (
    ConditionedProMP,
    MappedMovement,
    PractisedMixture,
    StoppedMovement,
    practising_method,
    tune,
)
from msc.study.rivals._ends import find_ends
from msc.study.rivals._trials import Trials, cosines
from msc.study.rivals._trials import draw_tasks as draw_points

few = settings(max_examples=20, deadline=None)
RIM, TURN = TaskRange("radius_m", 0.3, 0.45), TaskRange("turn_deg", -10.0, 10.0)
PLANE, SPACE = Workspace(further=(RIM,)), Workspace(further=(RIM, TURN))
WORLDS = {2: PLANE, 3: SPACE}
ORDERED = {
    "change points",
    "after Hausknecht: no sweep",
    "ladder: pieces",
    "ladder: pieces, best gate",
    "ladder: pieces, abstaining",
    "ladder: pieces, true gate",
    "ladder: pieces, by trial",
}
ALIKE = {"charts, λ 1", "charts, λ 100", "charts, 10 neighbours"}  # but for a number
ALIKE |= {name for name in METHODS if METHODS[name].group == "number of charts"}
ANY = [name for name in METHODS if name not in ORDERED | ALIKE]
BLIND = {"mean policy", "zero policy"}  # to tasks, however wide

# All methods


def smooth(X):
    """Six weights that leap once, half-way round the circle."""
    angle, rest = X[:, 0], X[:, 1:].sum(axis=1)
    waves = [np.sin(angle), np.cos(angle), rest, np.sin(angle + rest), rest**2, angle]
    return 5 * np.stack(waves, axis=1) + 20 * (angle[:, None] > np.pi)


def soften(method):
    """Let searches of settings try one, and practice be as short as can be."""
    parts = method.get_params().values() if isinstance(method, BaseEstimator) else []
    for part in (method, *parts):
        if isinstance(part, RandomizedSearchCV):
            part.set_params(n_iter=1, cv=2)
    if hasattr(method, "n_checks"):
        one = method.set_params(n_checks=2, settings=[{}]).estimator
        has_features = "n_features" in one.get_params()
        one.set_params(n_rollouts=80 if has_features else 9)
        if has_features:
            one.set_params(n_features=2)
    return method


SEES_ENDS = [name for name in ANY if METHODS[name].group in ("section V", "rollouts")]
CASES = [(name, 3) for name in ANY]
CASES += [(name, 2) for name in ("charts", "linear interpolation", *SEES_ENDS)]


@pytest.mark.parametrize(("name", "n_numbers"), CASES)
def test_a_method_takes_tasks_of_several_numbers(name, n_numbers):
    world, is_practised = WORLDS[n_numbers], METHODS[name].group == "rollouts"
    tasks = draw_tasks(world, 5 if is_practised else 24)
    X = coordinates(world, tasks)
    model = soften(build_method(name, workspace=world, n_charts=2))
    model.fit(X, smooth(X))
    new = coordinates(world, draw_tasks(world, 2, skip=40))
    ask = getattr(model, "predict", None) or model.plan
    found = ask(new)
    assert found.shape == ((2, 67, 3) if hasattr(model, "plan") else (2, 6))
    assert np.isfinite(found).all()
    if name not in BLIND:
        with pytest.raises(ValueError, match=rf"X has 1 features, but .* {n_numbers}"):
            ask(new[:, :1])


@pytest.mark.parametrize("name", sorted(ORDERED))
def test_a_method_that_needs_an_order_says_so(name):
    assert METHODS[name].n_numbers == 1
    message = f"name='{name}' takes tasks of 1 number; .* task_deg, radius_m"
    with pytest.raises(ValueError, match=message):
        build_method(name, workspace=PLANE)
    X = coordinates(PLANE, draw_tasks(PLANE, 20))
    with pytest.raises(ValueError, match="X has 2 features; wanted one"):
        fit_methods(X, smooth(X), np.ones(20), names=[name])


def test_no_other_method_asks_for_a_number_of_numbers():
    asking = {name for name, method in METHODS.items() if method.n_numbers is not None}
    assert asking == ORDERED


@few
@given(st.integers(0, 2**31), st.integers(2, 3))
def test_what_is_linear_is_met_to_the_last_digits_within_the_hull(seed, n_numbers):
    rng = np.random.default_rng(seed)
    X, slopes = rng.uniform(0, 6, (40, n_numbers)), rng.normal(size=(n_numbers, 6))
    new = rng.uniform(0, 6, (60, n_numbers))
    new = new[Delaunay(X).find_simplex(new) >= 0]
    model = build_method("linear interpolation").fit(X, X @ slopes + 7)
    assert_allclose(model.predict(new), new @ slopes + 7, atol=1e-10)


# Kernels


ISOTROPIC = (
    "single regression",
    "charts",
    "single, one kernel",
    "charts, Matérn, one kernel",
    "CrKr",
    "nearest neighbour",
    "nearest neighbours",
    "linear interpolation",
    "local linear regression",
    "radial basis functions",
    "after Mülling: no practice",
    "ladder: SMCE, abstaining",
    "ladder: linkage",
)


@pytest.mark.parametrize("name", ISOTROPIC)
def test_turning_the_plane_of_tasks_changes_nothing(name):
    rng = np.random.default_rng(0)
    X, new = rng.uniform(0, 5, (30, 2)), rng.uniform(1, 4, (20, 2))
    turn = np.array([[-0.6, -0.8], [0.8, -0.6]])
    y = smooth(X)
    found = [
        build_method(name, n_charts=2).fit(tasks, y).predict(asked)
        for tasks, asked in ((X, new), (X @ turn.T, new @ turn.T))
    ]
    assert_allclose(*found, atol=1e-3)


@pytest.mark.parametrize("gate", ["nearest", "gp"])
def test_turning_the_plane_changes_no_chart(gate):
    X, new = draw_field(60, 0), draw_field(200, 1)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    charts = pieces_of(X)
    one = GATES[gate]().fit(X, charts).predict(new)
    other = GATES[gate]().fit(X @ turn.T, charts).predict(new @ turn.T)
    assert (one == other).mean() > 0.99


@pytest.mark.parametrize("n_numbers", [1, 2, 3])
def test_the_periodic_kernel_goes_round_in_the_first_number_alone(n_numbers):
    rng = np.random.default_rng(0)
    X, Y = rng.uniform(-9, 9, (30, n_numbers)), rng.uniform(-9, 9, (7, n_numbers))
    kernel = Periodic(0.8, 2 * np.pi, periodicity_bounds="fixed")
    expected = ExpSineSquared(0.8, 2 * np.pi)(X[:, :1], Y[:, :1])
    if n_numbers > 1:
        expected *= RBF(0.8)(X[:, 1:], Y[:, 1:])
    assert_allclose(kernel(X, Y), expected, rtol=1e-10, atol=1e-300)
    assert np.linalg.eigvalsh(kernel(X)).min() > -1e-12
    round_once = X + 2 * np.pi * np.eye(n_numbers)[0]
    assert_allclose(kernel(round_once, X), kernel(X), atol=1e-12)
    _, slope = kernel(X, eval_gradient=True)

    def entry(theta):
        return kernel.clone_with_theta(theta)(X)[0, 1:].sum()

    slopes = approx_fprime(kernel.theta, entry, 1e-7)
    assert_allclose(slope[0, 1:, 0].sum(), slopes[0], rtol=1e-4)


def test_a_periodic_regression_closes_the_circle_at_every_radius():
    X = coordinates(PLANE, draw_tasks(PLANE, 40))
    model = build_method("single, periodic").fit(X, smooth(X))
    ends = [np.c_[np.full(5, end), np.linspace(0.7, 1, 5)] for end in (0, 2 * np.pi)]
    assert_allclose(*map(model.predict, ends), atol=1e-6)
    assert np.ptp(model.predict(ends[0]), axis=0).max() > 0.1


# Points and tasks


@few
@given(st.integers(0, 2**31), st.sampled_from([Workspace.free(), PLANE, SPACE]))
def test_points_are_tasks_and_tasks_are_points(seed, world):
    tasks = np.array(draw_tasks(world, 9, seed=seed))
    found = tasks_at(world, coordinates(world, tasks))
    assert found.shape == tasks.shape
    assert_allclose(found, tasks, rtol=1e-14)


def test_points_of_another_width_are_refused():
    for world, n in ((Workspace.free(), 2), (SPACE, 2)):
        names = ", ".join(world.task_names)
        with pytest.raises(ValueError, match=rf"shape \(4, {n}\); wanted .*: {names}"):
            tasks_at(world, np.zeros((4, n)))
    with pytest.raises(ValueError, match=r"points have shape \(4,\); wanted 1 columns"):
        tasks_at(Workspace.free(), np.zeros(4))


# Who knows goals: movements begin and end where the world says

X3 = coordinates(SPACE, draw_tasks(SPACE, 12))
NEW3 = coordinates(SPACE, draw_tasks(SPACE, 6, skip=12))


def paths_of(world, policies, X):
    starts, goals = find_ends(world, X)
    return DMP().path(policies, starts, goals, np.linspace(0, 1, 40))


def test_ends_are_where_the_arm_is_and_has_to_be():
    starts, goals = find_ends(SPACE, X3)
    arm = cached_arm(SPACE)
    zeros = np.zeros((len(X3), 6))
    for rollout, start, goal in zip(
        arm.execute_many(zeros, tasks_at(SPACE, X3).tolist()),
        starts,
        goals,
        strict=True,
    ):
        assert_allclose(rollout.path[0], start, atol=1e-9)
        missed = np.linalg.norm(rollout.path[-1] - goal)
        assert_allclose(missed, rollout.error, atol=1e-9)


def test_a_movement_is_carried_over_from_start_to_start_and_goal_to_goal():
    policies = np.random.default_rng(0).normal(0, 20, (1, 6))
    for old, new in zip(X3[:6, None], NEW3[:, None], strict=True):
        moved = MappedMovement(SPACE).fit(old, policies).predict(new)
        (before,), (after,) = (
            paths_of(SPACE, policies, old),
            paths_of(SPACE, moved, new),
        )
        before, after = before @ [1, 1j], after @ [1, 1j]
        ends = [find_ends(SPACE, X) for X in (old, new)]
        ways = [((goal - start) @ [1, 1j])[0] for start, goal in ends]
        expected = (before - before[0]) * ways[1] / ways[0]
        assert_allclose(after - after[0], expected, atol=1e-9)


def test_the_source_is_the_nearest_task_in_all_numbers():
    X = np.array([[0.1, 0.7, 0.0], [6.2, 1.0, 0.0], [3.0, 0.7, 0.0]])
    policies = np.random.default_rng(1).normal(0, 20, (3, 6))
    model = MappedMovement(SPACE).fit(X, policies)
    for asked, source in ([[0.0, 0.95, 0.0], 1], [[6.25, 0.72, 0.0], 0]):
        alone = MappedMovement(SPACE).fit(X[[source]], policies[[source]])
        assert_array_equal(model.predict([asked]), alone.predict([asked]))


def test_conditioned_movements_end_at_their_goals():
    model = ConditionedProMP(SPACE).fit(X3, smooth(X3))
    ends = paths_of(SPACE, model.predict(NEW3), NEW3)[:, -1]
    assert_allclose(ends, find_ends(SPACE, NEW3)[1], atol=1e-8)


def test_a_stopped_movement_turns_with_the_arm():
    """The whole task turned about the base: joints move alike, but for the first."""
    still, turn = np.array([[2.0, 0.8, 0.0]]), 0.15
    turned = still + np.array([turn, 0.0, turn])
    model = StoppedMovement(SPACE).fit(X3, smooth(X3))
    assert_array_equal(model.choose(still), model.choose(turned))
    offset = [turn, 0.0, 0.0]
    assert_allclose(model.plan(turned), model.plan(still) + offset, atol=1e-9)
    starts = find_ends(SPACE, NEW3)[0]
    assert_allclose(model.path(NEW3)[:, 0], starts, atol=1e-9)
    assert_allclose(model.plan(NEW3)[:, 0, 0] - SPACE.home[0], NEW3[:, 2], atol=1e-12)


def test_no_task_is_missed_by_more_than_its_own_movement_does():
    movements, goals = smooth(X3), find_ends(SPACE, X3)[1]
    model = StoppedMovement(SPACE).fit(X3, movements)
    missed = np.linalg.norm(model.path(X3)[:, -1] - goals, axis=1)
    own = np.linalg.norm(paths_of(SPACE, movements, X3)[:, -1] - goals, axis=1)
    assert (missed <= own + 1e-9).all()


@pytest.mark.parametrize("kind", [MappedMovement, ConditionedProMP, StoppedMovement])
def test_tasks_of_another_world_are_refused(kind):
    message = r"X has shape \(12, 2\) and y \(12, 6\); wanted \(n_tasks, 3\)"
    with pytest.raises(ValueError, match=message):
        kind(SPACE).fit(X3[:, :2], smooth(X3))


# Who executes


def test_trials_cost_what_the_world_says():
    world = Workspace(further=(RIM, TURN), cost=CostWeights(error=7.0, length=0.1))
    policies = smooth(NEW3)
    paid = Trials(world, None, None)(policies, NEW3)
    tasks = tasks_at(world, NEW3).tolist()
    rollouts = cached_arm(world).execute_many(policies, tasks)
    assert_array_equal(paid, [cost(one, world.cost) for one in rollouts])
    assert (paid != [cost(one) for one in rollouts]).all()


def test_practice_is_on_what_the_world_asks_for():
    span = practising_method("mixture practice", SPACE, 0).estimator.span
    ends = [[0.0, 0.3, -10.0], [360.0, 0.45, 10.0]]
    assert_allclose(tasks_at(SPACE, span), ends)
    asked = []

    def execute(policies, X):
        asked.append(X)
        return np.ones(len(policies))

    practice = {"n_rollouts": 300, "span": span, "random_state": 0}
    PractisedMixture(execute=execute, **practice).fit(X3, smooth(X3))
    points, (low, high) = np.vstack(asked), np.array(span)
    assert ((low <= points) & (points <= high)).all()
    covered = np.ptp(points, axis=0) / (high - low)
    assert (covered > 0.95).all()


def test_features_are_orthonormal_over_all_numbers():
    span = (0.0, 0.7, -0.2), (6.0, 1.0, 0.2)
    axes = [
        np.linspace(low, high, 41)[:-1] + (high - low) / 80
        for low, high in zip(*span, strict=True)
    ]
    X = np.stack(np.meshgrid(*axes), -1).reshape(-1, 3)
    seen = cosines(X, 5, span)
    assert seen.shape == (len(X), 7)
    assert_allclose(seen.T @ seen / len(X), np.eye(7), atol=1e-12)
    assert_allclose(cosines(X, 9, span)[:, :7], seen)  # coarser ones come first


def test_bounds_are_as_many_as_numbers():
    X, rng = np.zeros((3, 2)), np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"span=\(0\.0, 1\.0\) bounds 1 num.* 2"):
        cosines(X, 3, (0.0, 1.0))
    three = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match="bounds 3 numbers; wanted 2"):
        draw_points(rng, 4, X, three)
    crossed = (0.0, 1.0), (1.0, 1.0)
    with pytest.raises(ValueError, match="wanted its lower bound before its upper"):
        draw_points(rng, 4, X, crossed)


# What is found in a plane of tasks: three smooth pieces, and borders that bend

N_SEEDS = 3
SIZES = (30, 120, 480)


def pieces_of(X):
    angle, other = X.T
    first = angle > 2.0 + 0.5 * np.sin(other)
    return first.astype(int) + (angle > 4.2 - 0.5 * other)


def field(X):
    angle, other = X.T
    waves = [np.sin(angle), np.cos(angle), other, np.sin(angle + other)]
    waves += [np.cos(angle - 2 * other), other * np.cos(angle)]
    leaps = [[0, 0, 0, 0, 0, 0], [15, -10, 0, 20, 0, 5], [-10, 20, 10, 0, -15, 0]]
    return 10 * np.stack(waves, axis=1) + np.array(leaps)[pieces_of(X)]


def draw_field(n_tasks, seed):
    """Spread tasks over the plane; of one seed the more hold the fewer."""
    points = qmc.Halton(2, rng=np.random.default_rng(seed)).random(n_tasks)
    return points * [2 * np.pi, 2.0]


@pytest.mark.parametrize("seed", range(N_SEEDS))
def test_the_pieces_are_found(seed):
    X = draw_field(240, seed)
    policies, pieces = field(X), pieces_of(X)
    skill = ParameterizedSkill(SMCE(3), regressor=LinearRegression(), random_state=0)
    edges = task_edges(X, closed=False)
    jumps = find_jump_edges(policies, edges)
    for found in (skill.fit(X, policies).charts_, find_pieces(240, edges, jumps)):
        assert adjusted_rand_score(pieces, found) >= 0.99


def test_where_charts_are_told_right_they_are_right_and_one_regression_is_not():
    X, new = draw_field(180, 0), draw_field(400, 9)
    ours = build_method("charts", n_charts=3).fit(X, field(X))
    single = build_method("single regression").fit(X, field(X))
    names = np.array([ours.charts_[pieces_of(X) == piece][0] for piece in range(3)])
    right = ours.predict_chart(new) == names[pieces_of(new)]
    assert right.mean() > 0.9
    missed = [np.abs(m.predict(new) - field(new))[right] for m in (ours, single)]
    assert missed[0].max() < 0.05
    assert missed[1].max() > 1


def tuned_machine():
    return tune(SVC(), "chart gate", is_classifier=True).set_params(n_iter=8)


@pytest.mark.parametrize(
    "gate", [*GATES.values(), tuned_machine], ids=[*GATES, "tuned"]
)
def test_a_gate_errs_the_less_the_more_it_has_seen(gate):
    sizes = SIZES[:-1] if gate == GATES["gp"] else SIZES  # the others are quick
    shares = np.empty((N_SEEDS, len(sizes)))
    for seed in range(N_SEEDS):
        new = draw_field(1000, 100 + seed)
        for place, n_tasks in enumerate(sizes):
            X = draw_field(n_tasks, seed)
            model = seeded_clone(gate(), 0).fit(X, pieces_of(X))
            shares[seed, place] = (model.predict(new) != pieces_of(new)).mean()
    mean, sure = shares.mean(axis=0), shares.std(axis=0, ddof=1) / np.sqrt(N_SEEDS)
    assert (np.diff(mean) < sure[1:] + sure[:-1]).all(), mean
    assert mean[0] >= 3 * mean[-1] > 0, mean


def test_the_best_gate_is_as_good_as_the_nearest_in_a_plane():
    X, new = draw_field(60, 0), draw_field(2000, 100)
    shares = {}
    for name, gate in (("best", BestGate()), ("nearest", GATES["nearest"]())):
        found = gate.fit(X, pieces_of(X)).predict(new)
        shares[name] = (found != pieces_of(new)).mean()
    assert shares["best"] <= shares["nearest"]


def test_between_charts_a_triangle_s_corners_are_asked():
    """Two of the nearest are of one chart; the third, of another, counts too."""
    X = np.array([[0.0, 0.0], [0.2, 0.1], [1.0, 0.0], [1.2, 0.0], [5.0, 0.0]])
    y = np.array([[0.0], [0.1], [9.0], [9.1], [9.2]])
    skill = ParameterizedSkill(KMeans(2, random_state=0, n_init=1), verbose=False)
    model = AbstainingSkill(skill).fit(X, y)
    assert model.charts_[0] == model.charts_[1] != model.charts_[2]
    assert_array_equal(model.predict([[0.3, 0.0]]), y[[1]])
    on_a_line = AbstainingSkill(skill).fit(X[:, :1], y)  # between two of one chart
    assert_array_equal(on_a_line.predict([[0.1]]), on_a_line.skill_.predict([[0.1]]))
