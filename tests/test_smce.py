import pickle
import warnings
from pathlib import Path

import cvxpy as cp
import numpy as np
import pandas as pd
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components
from sklearn.base import clone
from sklearn.metrics import adjusted_rand_score
from sklearn.utils.estimator_checks import (
    check_dataframe_column_names_consistency,
    parametrize_with_checks,
)

import msc.learn._spectral
from msc import SMCE, load_dataset
from msc.learn import elbow

# Of few points at random the graph often falls apart; that it is told is tested below.
pytestmark = pytest.mark.filterwarnings("ignore:The graph has")

GOLDEN = Path(__file__).parent / "golden"
FORMS = ("normalized", "raw")

line = np.load(GOLDEN / "smce_analytic_line.npz")
curve4 = np.load(GOLDEN / "smce_curve4_n48.npz")
curve4_points = curve4["X"].T
curve4_pieces = curve4["gtruth"] - 1


def random_points(seed, n_points=30, n_features=3):
    return np.random.default_rng(seed).normal(size=(n_points, n_features))


def programs(model, X):
    """Yield each point's program: neighbours, weights q, columns of Y, coefficients."""
    coef = model.coef_.toarray()
    n_neighbors = min(model.n_neighbors, len(X) - 1)
    for i in range(len(X)):
        others = np.delete(np.arange(len(X)), i)
        distances = np.linalg.norm(X[others] - X[i], axis=1)
        nearest = np.argsort(distances)[:n_neighbors]
        others, distances = others[nearest], distances[nearest]
        columns = (X[others] - X[i]).T
        if model.form == "normalized":
            columns = columns / distances
        assert set(np.flatnonzero(coef[i])) <= set(others)
        yield others, distances / distances.sum(), columns, coef[i, others]


def duality_gap(penalty, columns, c):
    """Bound how far c is from the optimum, relative to its objective.

    By duality, nu - |r|^2 / 2 is a lower bound for every r and nu with
    |columns' r - nu| <= penalty. Shrinking r = columns c a little makes it feasible.
    """
    error = columns @ c
    objective = penalty @ abs(c) + error @ error / 2
    bounds = []
    for shrunk in 1 - np.r_[0, np.logspace(-16, 0, 200)]:
        slopes = shrunk * columns.T @ error
        nu = (slopes + penalty).min()
        if nu >= (slopes - penalty).max():
            bounds.append(nu - shrunk**2 * error @ error / 2)
    return 1 - max(bounds) / objective


# The program of each point


def test_closed_form_on_a_line():
    X = line["X"].T
    for form, key in zip(FORMS, ("c_normalised", "c_raw_eq3"), strict=True):
        for regularization, c in zip(line["lams"], line[key], strict=True):
            model = SMCE(1, regularization=regularization, form=form).fit(X)
            # The optimum is flat where a coefficient just reaches zero: 1e-6, not 1e-9.
            np.testing.assert_allclose(model.coef_.toarray()[0], [0, *c], atol=1e-6)


@pytest.mark.parametrize(
    ("form", "key"), [("normalized", "obj_cvx_normalised"), ("raw", "obj_cvx_raw_eq3")]
)
def test_objectives_of_the_reference(form, key):
    model = SMCE(4, n_neighbors=7, form=form).fit(curve4_points)
    np.testing.assert_allclose(model.objective_, curve4[key], rtol=1e-8)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    ("n_features", "regularization"), [(1, 10.0), (3, 1.0), (12, 1000.0)]
)
def test_duality_certifies_the_optimum(form, n_features, regularization):
    X = random_points(n_features, n_features=n_features)
    model = SMCE(1, form=form, regularization=regularization, n_neighbors=12)
    model.set_params(max_clusters=1).fit(X)
    for _, q, columns, c in programs(model, X):
        assert duality_gap(regularization * q, columns, c) < 1e-7


@pytest.mark.parametrize("form", FORMS)
def test_objective_is_that_of_the_coefficients(form):
    X = random_points(0)
    model = SMCE(1, form=form).fit(X)
    recomputed = [
        10 * q @ abs(c) + np.sum((columns @ c) ** 2) / 2
        for _, q, columns, c in programs(model, X)
    ]
    np.testing.assert_allclose(model.objective_, recomputed, rtol=1e-12)


def test_raw_form_is_the_equation_as_printed():
    X = random_points(1, n_points=10)
    model = SMCE(1, form="raw", n_neighbors=6).fit(X)
    for i, (neighbors, q, _, _) in enumerate(programs(model, X)):
        c = cp.Variable(6)
        error = X[neighbors].T @ c - X[i]
        printed = 10 * cp.norm1(cp.multiply(q, c)) + cp.sum_squares(error) / 2
        optimum = cp.Problem(cp.Minimize(printed), [cp.sum(c) == 1]).solve(cp.CLARABEL)
        np.testing.assert_allclose(model.objective_[i], optimum, rtol=1e-6)


def test_without_penalty_a_point_between_others_is_reconstructed_exactly():
    X = np.r_[[[0.0, 0.0]], np.eye(2), -np.eye(2)]
    assert SMCE(1, regularization=0).fit(X).objective_[0] < 1e-20


def test_copies_are_reconstructed_as_their_point_is():
    X = random_points(3)
    copied = np.r_[X[[4, 4, 4]], X]
    for form in FORMS:
        one, many = (SMCE(1, form=form).fit(Z) for Z in (X[np.r_[4, :4, 5:30]], copied))
        rows = many.coef_.toarray()
        np.testing.assert_array_equal(rows[[0, 1, 2, 7]], rows[[0]].repeat(4, axis=0))
        first = np.r_[0, 3:7, 8:33]
        np.testing.assert_array_equal(rows[np.ix_(first, first)], one.coef_.toarray())
        np.testing.assert_array_equal(many.objective_[first], one.objective_)
        beside = np.flatnonzero(many.affinity_matrix_.toarray()[1])
        np.testing.assert_array_equal(beside, [0])  # a copy's affinity is to its point


@pytest.mark.parametrize("far", [1e6, 1e12, 1e60])
def test_beside_a_far_point_only_copies_are_copies(far):
    near = random_points(2, n_points=8)
    X = np.r_[near, near[[0, 0]], [[far, 0, 0]]]
    model = SMCE(1, max_clusters=1).fit(X)
    shares = model.coef_.toarray()
    np.testing.assert_array_equal(shares[[8, 9]], shares[[0, 0]])
    assert not shares[:, [8, 9]].any()
    assert (np.ptp(shares[:8, :10], axis=1) > 0.1).all()
    assert (model.objective_ > 0).all()


@pytest.mark.parametrize("form", FORMS)
def test_points_that_rounding_parts_are_copies_at_zero_too(form):
    t = np.linspace(0, 2 * np.pi, 61)
    eight = np.c_[np.sin(t), np.sin(2 * t)]  # thrice at zero, but for 5e-16
    for X in (eight, eight + 3):
        shares = SMCE(1, form=form, max_clusters=1).fit(X).coef_.toarray()
        assert set(np.flatnonzero(shares[0])) <= {1, 29, 31, 59}
        np.testing.assert_array_equal(shares[[30, 60]], shares[[0, 0]])


def test_a_program_beyond_the_solver_is_reported():
    X = np.r_[random_points(2, n_points=8), [[1e12, 0, 0]]]
    with pytest.raises(ValueError, match="use form='normalized'"):
        SMCE(1, form="raw").fit(X)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("exponent", [-330, 330])
def test_scale_is_exact_up_to_the_largest_magnitudes(form, exponent):
    X = random_points(0)
    one = SMCE(3, form=form, random_state=0)
    other = clone(one).fit(np.ldexp(X, exponent))
    if form == "raw":  # squares no longer count, or count alone
        assert np.isfinite(other.objective_).all()
        return
    one.fit(X)
    np.testing.assert_array_equal(other.labels_, one.labels_)
    np.testing.assert_array_equal(other.coef_.data, one.coef_.data)


# Properties

seeds = st.integers(0, 2**31)
few = settings(max_examples=8, deadline=None)


@few
@given(seeds, st.sampled_from(FORMS), st.integers(2, 25), st.integers(1, 5))
def test_shapes_signs_and_sums(seed, form, n_points, n_features):
    X = random_points(seed, n_points, n_features)
    model = SMCE(form=form, n_neighbors=8, random_state=0).fit(X)
    coef, affinity = model.coef_, model.affinity_matrix_
    assert coef.format == affinity.format == "csr"
    assert coef.shape == affinity.shape == (n_points, n_points)
    assert affinity.indices.dtype == np.int32  # what scikit-learn takes
    np.testing.assert_allclose(coef.sum(axis=1), 1, rtol=1e-14)
    assert not coef.diagonal().any()
    assert not affinity.diagonal().any()
    assert (np.diff(coef.indptr) <= 8).all()
    assert (affinity.data > 0).all()
    assert abs(affinity - affinity.T).max() == 0
    assert set(model.labels_) == set(range(model.n_clusters_))


@few
@given(seeds, st.sampled_from(FORMS))
def test_order_of_the_points_does_not_matter(seed, form):
    X = random_points(seed)
    order = np.random.default_rng(seed).permutation(len(X))
    one, other = (SMCE(1, form=form, max_clusters=1).fit(Z) for Z in (X, X[order]))
    np.testing.assert_allclose(one.objective_[order], other.objective_, rtol=1e-8)
    shuffled = one.coef_.toarray()[np.ix_(order, order)]
    np.testing.assert_allclose(shuffled, other.coef_.toarray(), atol=1e-4)


@few
@given(seeds, st.floats(-8, 8), st.floats(-5, 5))
def test_normalized_form_ignores_scale_and_place(seed, log_scale, shift):
    X = random_points(seed)
    one = SMCE(1, max_clusters=1).fit(X)
    other = clone(one).fit(10**log_scale * (X + shift))
    np.testing.assert_allclose(one.objective_, other.objective_, rtol=1e-7)


def test_raw_form_depends_on_scale():
    one, other = (SMCE(2, form="raw").fit(k * random_points(0)) for k in (1, 100))
    assert (other.objective_ > 1.5 * one.objective_).any()


@pytest.mark.parametrize("form", FORMS)
def test_constant_columns_change_nothing(form):
    X = random_points(4)
    one, other = (SMCE(2, form=form).fit(Z) for Z in (X, np.c_[X, np.full(30, 7.0)]))
    np.testing.assert_allclose(one.objective_, other.objective_, rtol=1e-9)


# From coefficients to charts


def test_affinity_of_the_reference():
    rows = curve4["W_cvx_normalised"].T
    model = SMCE(4, n_neighbors=7, prune=1.0).fit(curve4_points)
    expected = np.maximum(rows, rows.T)
    np.testing.assert_allclose(model.affinity_matrix_.toarray(), expected, atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("prune", [0.3, 0.8, 0.95])
def test_affinity_keeps_the_largest_entries_up_to_the_share(form, prune):
    X = random_points(5)
    model = SMCE(1, form=form, prune=prune).fit(X)
    kept = np.zeros((len(X), len(X)))
    for i, c in enumerate(model.coef_.toarray()):
        distances = np.linalg.norm(X - X[i], axis=1)
        weights = abs(c) / (np.where(c, distances, 1) if form == "normalized" else 1)
        weights /= weights.sum()
        mass = 0.0
        for j in np.argsort(-weights):
            kept[i, j] = weights[j]
            mass += weights[j]
            if mass >= prune:
                break
    expected = np.maximum(kept, kept.T)
    np.testing.assert_allclose(model.affinity_matrix_.toarray(), expected, atol=1e-12)


def test_eigenvalues_are_those_of_the_normalised_laplacian():
    model = SMCE(4, n_neighbors=7).fit(curve4_points)
    weights = model.affinity_matrix_.toarray()
    random_walk = weights / weights.sum(axis=1, keepdims=True)
    expected = np.sort(1 - np.linalg.eigvals(random_walk).real)
    np.testing.assert_allclose(model.eigenvalues_, expected, atol=1e-10)
    assert (model.eigenvalues_ < 1e-10).sum() == model.n_components_ == 4
    np.testing.assert_allclose(np.linalg.norm(model.embedding_, axis=1), 1)
    assert model.embedding_.shape == (48, 4)


@few
@given(seeds, st.integers(2, 60), st.integers(1, 3), st.sampled_from(FORMS))
def test_components_are_those_of_the_graph(seed, n_points, n_neighbors, form):
    """Of far clusters, copies and single points; by scipy, and by walking the edges."""
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(n_points, 2)) + 10.0 ** rng.integers(-3, 6, (n_points, 1))
    X = X[rng.integers(0, n_points, n_points)]
    model = SMCE(1, n_neighbors=n_neighbors, form=form, random_state=0).fit(X)
    affinity = model.affinity_matrix_.toarray()
    assert model.n_components_ == connected_components(affinity)[0]
    left, n_components = set(range(n_points)), 0
    while left:
        new, n_components = {left.pop()}, n_components + 1
        while new:
            new = set(np.flatnonzero(affinity[list(new)].any(axis=0)).tolist()) & left
            left -= new
    assert model.n_components_ == n_components


def test_there_may_be_more_components_than_eigenvalues():
    X = np.c_[np.tile(np.arange(6.0), 100), np.repeat(100.0 * np.arange(100), 6)]
    model = SMCE(2, n_neighbors=4, random_state=0).fit(X)
    assert model.n_components_ == 100 > len(model.eigenvalues_)


@pytest.mark.parametrize("regularization", [10, 100])
@pytest.mark.parametrize("n_clusters", [4, None])
@pytest.mark.parametrize("form", FORMS)
def test_four_pieces_are_found(form, n_clusters, regularization):
    model = SMCE(n_clusters, n_neighbors=7, form=form, random_state=0)
    model.set_params(regularization=regularization)
    np.testing.assert_array_equal(model.fit_predict(curve4_points), curve4_pieces)
    assert model.n_clusters_ == 4


@pytest.mark.parametrize("regularization", [10, 100])
def test_interleaved_trefoil_knots_in_100_dimensions(regularization):
    rng = np.random.default_rng(0)
    t = np.linspace(0, 2 * np.pi, 75, endpoint=False)
    x, y = np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t)
    cos, sin = np.cos(np.pi / 3), np.sin(np.pi / 3)
    knot = np.c_[x, y, -np.sin(3 * t)]
    turned = np.c_[cos * x - sin * y, sin * x + cos * y, -np.sin(3 * t)]
    plane, _ = np.linalg.qr(rng.normal(size=(100, 3)))
    X = np.r_[knot, turned] @ plane.T
    model = SMCE(2, regularization=regularization, n_neighbors=49, random_state=0)
    np.testing.assert_array_equal(model.fit_predict(X), np.repeat([0, 1], 75))


@pytest.mark.parametrize(("workspace", "least"), [("free", 0.95), ("obstacles", 0.75)])
def test_seeds_agree_on_the_policies(workspace, least):
    policies = load_dataset(workspace)[1]
    ours, *others = (
        SMCE(4, random_state=seed).fit_predict(policies) for seed in range(3)
    )
    assert min(adjusted_rand_score(ours, other) for other in others) >= least


def test_labels_are_numbered_as_they_appear():
    order = np.random.default_rng(0).permutation(48)
    labels = SMCE(4, n_neighbors=7, random_state=0).fit_predict(curve4_points[order])
    _, first = np.unique(labels, return_index=True)
    assert (np.diff(first) > 0).all()


def test_elbow_curve_is_the_spread_within_charts():
    fit = {"n_neighbors": 7, "random_state": 0}
    curve = SMCE(None, max_clusters=6, **fit).fit(curve4_points).elbow_curve_
    for n_clusters in range(1, 7):
        labels = SMCE(n_clusters, **fit).fit_predict(curve4_points)
        charts = [curve4_points[labels == c] for c in range(n_clusters)]
        spread = sum(((chart - chart.mean(axis=0)) ** 2).sum() for chart in charts)
        np.testing.assert_allclose(curve[n_clusters - 1], spread)


@few
@given(st.lists(st.floats(0, 100), min_size=3, max_size=12))
def test_elbow_lies_furthest_below_the_chord(curve):
    curve = np.sort(curve)[::-1]
    if np.ptp(curve) < 1e-3:
        return
    x, y = np.linspace(0, 1, len(curve)), (curve - curve[-1]) / np.ptp(curve)
    below = (1 - x - y) / np.sqrt(2)  # distance of (x, y) from the line x + y = 1
    assert np.isclose(below[elbow(curve) - 1], below.max(), atol=1e-9)


@pytest.mark.parametrize("max_clusters", [1, 2])
def test_a_curve_without_an_elbow_is_one_chart(max_clusters):
    assert SMCE(max_clusters=max_clusters).fit(random_points(0)).n_clusters_ == 1


def test_large_data_take_the_sparse_road_to_the_same_charts(monkeypatch):
    dense = SMCE(3, n_neighbors=7, random_state=0).fit(random_points(7, 60, 2))
    monkeypatch.setattr(msc.learn._spectral, "_LARGEST_DENSE", 0)
    sparse = clone(dense).fit(random_points(7, 60, 2))
    np.testing.assert_allclose(sparse.eigenvalues_, dense.eigenvalues_[:10], atol=1e-9)
    np.testing.assert_array_equal(sparse.labels_, dense.labels_)


# Awkward data


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(
    "X",
    [
        np.ones((2, 1)),
        np.ones((30, 3)),
        np.full((30, 3), 1 / 3),
        np.arange(3.0)[:, None],
        np.repeat(random_points(0, 8), 5, axis=0),
        np.repeat(random_points(0, 8), 30, axis=0),
        np.repeat(random_points(0, 20), 2, axis=0) + 1e-13 * random_points(1, 40),
        random_points(0) * [1e-6, 1, 1e3],
        random_points(0) + 1e6,
    ],
)
@pytest.mark.filterwarnings("error")
def test_awkward_data_are_clustered_without_a_warning(form, X):
    model = SMCE(form=form, random_state=0).fit(X)
    np.testing.assert_allclose(model.coef_.sum(axis=1), 1)
    assert not model.coef_.diagonal().any()
    assert np.isfinite(model.elbow_curve_).all()
    assert len(model.elbow_curve_) == min(10, len(X))
    assert 1 <= model.n_clusters_ <= len(X)


@pytest.mark.parametrize("value", [1.0, 0.1, 1 / 3])
def test_equal_points_are_one_chart(value):
    assert SMCE(random_state=0).fit(np.full((30, 3), value)).n_clusters_ == 1


@few
@given(seeds, st.integers(2, 12), st.integers(1, 12), st.data())
def test_as_many_charts_as_asked_for_or_as_there_are_points(seed, n_points, size, data):
    n_clusters = data.draw(st.integers(1, n_points))
    picked = np.random.default_rng(seed).integers(0, size, n_points)
    model = SMCE(n_clusters, max_clusters=2, n_neighbors=3, random_state=0)
    n_distinct = len(set(picked.tolist()))
    with warnings.catch_warnings():
        if n_clusters > n_distinct:
            warnings.simplefilter("ignore", UserWarning)
        model.fit(random_points(seed, size, 2)[picked])
    found = len(set(model.labels_))
    assert model.n_clusters_ == found == min(n_clusters, n_distinct)
    assert len({*zip(picked, model.labels_, strict=True)}) == n_distinct


def test_neighbours_are_clipped():
    X = random_points(0, n_points=6)
    one, other = SMCE(2, n_neighbors=5).fit(X), SMCE(2, n_neighbors=500).fit(X)
    np.testing.assert_array_equal(one.objective_, other.objective_)


def test_more_charts_than_the_elbow_curve_considers():
    model = SMCE(5, max_clusters=2, n_neighbors=4, random_state=0)
    model.fit(random_points(0))
    assert model.n_clusters_ == 5
    assert model.elbow_curve_.shape == (2,)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"form": "cooked"}, "'form' parameter of SMCE.*'cooked'"),
        ({"n_clusters": 0}, "'n_clusters' parameter of SMCE.*Got 0"),
        ({"n_clusters": 2.5}, "'n_clusters' parameter of SMCE.*Got 2.5"),
        ({"n_clusters": 31}, "n_clusters=31 must be at most n_samples=30"),
        ({"n_neighbors": 0}, "'n_neighbors' parameter of SMCE.*Got 0"),
        ({"max_clusters": 0}, "'max_clusters' parameter of SMCE.*Got 0"),
        ({"prune": 0}, "'prune' parameter of SMCE.*Got 0"),
        ({"prune": 1.1}, "'prune' parameter of SMCE.*Got 1.1"),
        ({"regularization": -1}, "'regularization' parameter of SMCE.*Got -1"),
        ({"regularization": np.nan}, "'regularization' parameter of SMCE.*Got nan"),
        ({"regularization": np.inf}, "'regularization' parameter of SMCE.*Got inf"),
        ({"random_state": "x"}, "'random_state' parameter of SMCE.*'x'"),
        ({"solver": "osqp"}, "'solver' parameter of SMCE.*'osqp'"),
    ],
)
def test_parameters_out_of_range(parameters, message):
    with pytest.raises(ValueError, match=message):
        SMCE(**parameters).fit(random_points(0))


@pytest.mark.parametrize(
    ("X", "message"),
    [
        ([[1.0], [np.nan], [2.0]], "Input X contains NaN"),
        ([[1.0], [np.inf], [2.0]], "Input X contains infinity"),
        ([[1.0], [-np.inf], [2.0]], "Input X contains infinity"),
        ([[1.0, 2.0]], "minimum of 2 is required by SMCE"),
        ([1.0, 2.0], "Expected 2D array"),
        (np.empty((5, 0)), r"0 feature\(s\).*minimum of 1 is required by SMCE"),
        ([["a", 1.0], ["b", 2.0]], "X must hold numbers: could not convert.*'a'"),
        (
            pd.DataFrame({"weight": [1.0, 2.0], "winner": ["start 1", "start 2"]}),
            "X must hold numbers: could not convert.*'start 1'",
        ),
        (random_points(0) + 1j, "Complex data not supported"),
        ([[1], [10**400]], "X must hold floats: int too large"),
        (1e150 * line["X"].T, r"X must have its largest .* 1e\+100.*Got -?\de\+1"),
        (1e-200 * random_points(0), r"X must have its largest .* 1e-100.*Got .*e-200"),
    ],
)
def test_points_out_of_range(X, message):
    with pytest.raises(ValueError, match=message):
        SMCE().fit(X)


def test_a_failing_solver_is_reported(monkeypatch):
    def fail(program, **_):
        program._status = cp.UNBOUNDED

    monkeypatch.setattr(cp.Problem, "solve", fail)
    with pytest.raises(ValueError, match=r"'unbounded'.*Rescale X"):
        SMCE().fit(random_points(0))


# Manners


def test_randomness_is_local_and_repeatable():
    before = pickle.dumps(np.random.get_state())  # noqa: NPY002
    X = random_points(0)
    for seed in (None, 3, np.random.RandomState(3), np.random.default_rng(3)):
        SMCE(3, random_state=seed).fit(X)
    assert pickle.dumps(np.random.get_state()) == before  # noqa: NPY002
    one, other = SMCE(3, random_state=3).fit(X), SMCE(3, random_state=3).fit(X)
    np.testing.assert_array_equal(one.labels_, other.labels_)


def test_pickle_and_clone():
    model = SMCE(2, form="raw", n_neighbors=5, random_state=0).fit(random_points(0))
    copy = pickle.loads(pickle.dumps(model))
    np.testing.assert_array_equal(copy.labels_, model.labels_)
    assert sp.issparse(copy.coef_)
    assert clone(model).get_params() == model.get_params()
    assert not hasattr(clone(model), "labels_")


@parametrize_with_checks([SMCE(max_clusters=3)])  # few points by CVXPY, many batched
def test_scikit_learn(estimator, check):
    check(estimator)


def test_names_of_columns_are_kept_and_compared():
    check_dataframe_column_names_consistency("SMCE", SMCE())
