import warnings
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import msc.robot._dmp
from msc import DMP

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
    monkeypatch.setattr("scipy.integrate.solve_ivp", None)  # which would never end
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


# Bounds


SLOWEST = (1e4, 0.01, 100.0, 100.0, 100)  # of all corners


def draw(seed):
    """Draw constants within their bounds, evenly in their logarithms."""
    rng = np.random.default_rng(seed)
    drawn = [
        np.exp(rng.uniform(*np.log(pair))) for pair in msc.robot._dmp._BOUNDS.values()
    ]
    return *(float(value) for value in drawn), int(rng.integers(2, 101))


@pytest.mark.parametrize("constants", [SLOWEST, *map(draw, (0, 2, 3))])
def test_constants_within_their_bounds_make_a_movement_within_seconds(constants):
    dmp, begun = DMP(*constants), process_time()
    last = np.linspace(0, 9 * dmp.time_scale, 5)
    try:
        found = dmp.path(np.ones(dmp.n_params), START, GOAL, last)
    except ValueError as error:
        if "all basis functions are zero" not in str(error):
            raise
        assert dmp.alpha < dmp.n_basis  # a phase far from all of many narrow functions
        found = np.zeros(1)
    assert np.isfinite(found).all()
    assert process_time() - begun < 10


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("spring", 1e10),
        ("spring", 1e-9),
        ("spring", 1e308),
        ("damping", 1e-9),
        ("damping", 1e6),
        ("time_scale", 1e-6),
        ("time_scale", 1e9),
        ("alpha", 1e-12),
        ("alpha", 1e3),
        ("spring", "16"),
        ("spring", None),
        ("alpha", 4 + 0j),
        ("time_scale", [1.0]),
        ("damping", 10**400),
        ("spring", True),
    ],
)
def test_constants_beyond_sense_are_refused(name, value):
    with pytest.raises(ValueError, match=rf"{name}=.*; wanted a positive number from"):
        DMP(**{name: value})


@pytest.mark.parametrize("n_basis", [10**6, 101, 2.5, "3", None, True])
def test_a_number_of_basis_functions_beyond_sense_is_refused(n_basis):
    with pytest.raises(ValueError, match=r"n_basis=.*; wanted at least 2, .* most 100"):
        DMP(n_basis=n_basis)


@pytest.mark.parametrize("last", [20.1, 1e6, 1e308])
def test_times_long_after_the_movement_are_refused(last, monkeypatch):
    monkeypatch.setattr("scipy.integrate.solve_ivp", None)
    with pytest.raises(ValueError, match=r"times: the last is .*; wanted at most 20 "):
        path(np.zeros(6), [0.0, last])


@pytest.mark.parametrize("value", [1.1e9, -1e12, 1e308, np.longdouble("1e400")])
def test_a_policy_beyond_sense_is_refused(value):
    with pytest.raises(ValueError, match=r"policy has (a weight of|NaN or infinite)"):
        path([0, 0, 0, 0, 0, value])
    assert np.isfinite(path([0, 0, 0, 0, 0, 1e9])).all()


@pytest.mark.parametrize("name", ["policy", "start", "goal", "times"])
@pytest.mark.parametrize("kind", [np.array, list, lambda x: np.array(x, dtype=object)])
def test_complex_numbers_are_refused_by_name(name, kind):
    good = {"policy": [0] * 6, "start": [0, 0], "goal": [1, 1], "times": [0, 1]}
    bad = kind([np.complex128(value) for value in good[name]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=f"Complex data not supported: {name} "):
            DMP().path(**good | {name: bad})
    with pytest.raises(
        ValueError, match=f"{name} must hold numbers: could not convert"
    ):
        DMP().path(**good | {name: ["1j"] * len(good[name])})


@pytest.mark.parametrize("gated", ["no", None, 1, [True]])
def test_a_switch_is_true_or_false(gated):
    with pytest.raises(ValueError, match=r"gated=.*; wanted True or False"):
        DMP(gated=gated)


@pytest.mark.parametrize("phase", [[np.nan], [1e308], [0.5, -np.inf], 0.5, [[0.5]]])
def test_a_phase_beyond_sense_is_refused(phase):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(
            ValueError, match=r"phase=.*; wanted finite numbers of shap"
        ):
            DMP().forcing_basis(phase)
        with pytest.raises(ValueError, match="at some phase all basis functions are"):
            DMP().forcing_basis([1e9])


@pytest.mark.parametrize(("n_policies", "n_goals"), [(3, 2), (1, 3), (4, 3)])
@pytest.mark.parametrize("name", ["start", "goal"])
def test_places_are_one_or_as_many_as_policies(name, n_policies, n_goals):
    policies = np.zeros((n_policies, 6) if n_policies else 6)
    places = {"start": [0, 0], "goal": [1, 1]} | {name: np.zeros((n_goals, 2))}
    with pytest.raises(ValueError, match=rf"{name} has shape \({n_goals}, 2\); wanted"):
        DMP().path(policies, **places, times=[0, 1])
