from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import msc.dmp
from msc.dmp import DMP

GOLDEN = Path(__file__).parent / "golden"
CASES = ("zero", "rand1", "gx_equals_x0x")
START, GOAL = np.array([-0.6, -0.6]), np.array([0.2, 0.4])

times = np.linspace(0, 1, 61)
weights = st.lists(st.floats(-50, 50), min_size=6, max_size=6).map(np.array)
properties = settings(max_examples=25, deadline=None)


def path(policy, times=times, **constants):
    return DMP(**constants).path(policy, START, GOAL, times)


# Against solutions of Eqs. 5-8 found elsewhere


@properties
@given(st.floats(1, 200), st.floats(0.5, 2))
def test_without_weights_it_is_a_critically_damped_spring(spring, time_scale):
    phase = np.sqrt(spring) * times[:, None] / time_scale
    left = (1 + phase) * np.exp(-phase)
    np.testing.assert_allclose(
        path(np.zeros(6), spring=spring, time_scale=time_scale),
        GOAL - (GOAL - START) * left,
        atol=1e-9,
    )


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("gated", "key"), [(False, "x_nos_gx0"), (True, "x_s_gx0")])
def test_reference_cases(case, gated, key):
    known = np.load(GOLDEN / f"dmp_{case}.npz")
    constants = {"spring": "K", "damping": "Q", "time_scale": "kappa", "alpha": "alpha"}
    dmp = DMP(gated=gated, **{name: float(known[k]) for name, k in constants.items()})
    np.testing.assert_allclose(
        dmp.path(known["w"], known["x0"], known["g"], known["t"]), known[key], atol=1e-6
    )


@properties
@given(st.floats(-30, 30))
def test_equal_weights_move_the_goal(weight):
    further = START + (GOAL - START) * (1 + weight / 16)
    np.testing.assert_allclose(
        path(np.full(6, weight)),
        DMP().path(np.zeros(6), START, further, times),
        atol=1e-8,
    )


# Properties


@properties
@given(weights, weights, st.floats(-2, 2))
def test_paths_are_linear_in_the_weights(one, other, factor):
    spring = path(np.zeros(6))
    np.testing.assert_allclose(
        path(one + factor * other) - spring,
        path(one) - spring + factor * (path(other) - spring),
        atol=1e-10,
    )


@properties
@given(weights, st.floats(0.2, 5))
def test_time_scale_stretches_time(policy, time_scale):
    np.testing.assert_allclose(
        path(policy, time_scale * times, time_scale=time_scale),
        path(policy),
        atol=1e-8,
    )


@properties
@given(weights)
def test_weights_of_one_dimension_leave_the_other_alone(policy):
    x_only = np.where(np.arange(6) < 3, policy, 0)
    np.testing.assert_array_equal(path(x_only)[:, 0], path(policy)[:, 0])
    np.testing.assert_array_equal(path(x_only)[:, 1], path(np.zeros(6))[:, 1])


@properties
@given(weights)
def test_a_movement_starts_at_rest_at_the_start(policy):
    np.testing.assert_array_equal(path(policy)[0], START)
    first = path(policy, [0.0, 1e-4])[1]
    np.testing.assert_allclose(first, START, atol=1e-6)


def test_only_the_gated_form_forgets_the_weights_in_the_end():
    policy, late = np.full(6, 8.0), [0.0, 9.0]
    np.testing.assert_allclose(path(policy, late, gated=True)[-1], GOAL, atol=1e-6)
    moved = GOAL + (GOAL - START) * 8 / 16
    np.testing.assert_allclose(path(policy, late)[-1], moved, atol=1e-6)


def test_a_dimension_that_need_not_move_does_not():
    found = DMP().path(np.full(6, 9.0), [0.5, 0.0], [0.5, 0.8], times)
    assert (found[:, 0] == 0.5).all()


def test_the_basis_sums_to_one():
    basis = DMP(n_basis=5).forcing_basis(np.linspace(0.01, 1, 40))
    assert basis.shape == (40, 5)
    np.testing.assert_allclose(basis.sum(axis=1), 1)


def test_a_population_is_one_path_after_another():
    policies = 20 * np.random.default_rng(0).normal(size=(9, 6))
    goals = np.random.default_rng(1).normal(size=(9, 2))
    together = DMP().path(policies, START, goals, times)
    for policy, goal, found in zip(policies, goals, together, strict=True):
        np.testing.assert_array_equal(found, DMP().path(policy, START, goal, times))


# Bad input


@pytest.mark.parametrize("shape", [(), (5,), (2, 3), (6, 5), (1, 2, 6), (0,)])
def test_a_policy_of_another_shape_is_refused(shape):
    with pytest.raises(ValueError, match=r"policy has shape .* wanted \(6,\)"):
        path(np.zeros(shape))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_policy_that_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="policy has NaN or infinite weights"):
        path([0, 0, 0, 0, 0, value])


@pytest.mark.parametrize(
    "bad", [[], [0.5, 0.2], [0.0, 0.0], [-0.1, 0.0], [0.0, np.nan], [0.0, np.inf]]
)
def test_times_that_do_not_ascend_are_refused(bad, monkeypatch):
    monkeypatch.setattr(msc.dmp, "solve_ivp", None)  # which would never end
    with pytest.raises(ValueError, match="times: wanted ascending times"):
        path(np.zeros(6), bad)


@pytest.mark.parametrize("name", ["spring", "damping", "time_scale", "alpha"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_a_constant_that_is_not_positive_is_refused(name, value):
    with pytest.raises(ValueError, match=f"{name}=.*; wanted a positive number"):
        DMP(**{name: value})


def test_a_single_basis_function_is_refused():
    with pytest.raises(ValueError, match=r"n_basis=1; wanted at least 2"):
        DMP(n_basis=1)


def test_times_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"times has shape \(\); wanted \(n_times,\)"):
        path(np.zeros(6), 1.0)


@pytest.mark.parametrize("bad", [[0.0, np.nan], 1.0, [1.0, 2.0, 3.0]])
@pytest.mark.parametrize("name", ["start", "goal"])
def test_places_that_are_no_points_are_refused(name, bad):
    places = {"start": [0, 0], "goal": [1, 1]} | {name: bad}
    with pytest.raises(ValueError, match=f"{name}=.*; wanted finite x and y"):
        DMP().path(np.zeros(6), **places, times=[0, 1])


def test_constants_without_a_movement_are_refused():
    with pytest.raises(ValueError, match="all basis functions are zero"):
        DMP(alpha=0.01).path(np.zeros(6), [0, 0], [1, 1], [0.0, 20.0])
