"""Points that are given more than once, and points that are not."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.metrics import adjusted_rand_score
from sklearn.neighbors import NearestNeighbors

import msc.learn._smce
from msc import SMCE, load_dataset
from msc.learn import find_copies
from msc.learn._spectral import within_cluster_ss

pytestmark = pytest.mark.filterwarnings("ignore:The graph has")

WORKSPACES = ("free", "obstacles")


def pieces(n_points):
    """Return points of four smooth pieces in six dimensions."""
    rng = np.random.default_rng(1)
    t, piece = (
        np.arange(n_points) / n_points * 4 % 1,
        np.arange(n_points) * 4 // n_points,
    )
    turn = rng.normal(size=(4, 2, 6))
    curve = np.stack([np.cos(3 * t), np.sin(3 * t)], axis=1)
    return (
        np.einsum("ij,ijk->ik", curve, turn[piece]) + 3 * rng.normal(size=(4, 6))[piece]
    )


def spacing(X):
    """Return every point's distance to the next one."""
    return NearestNeighbors(n_neighbors=1).fit(X).kneighbors()[0][:, 0]


def noisy(X, noise, n_copies, rng):
    """Repeat every point, each time moved by a share of the distance to the next."""
    steps = rng.normal(size=(n_copies * len(X), X.shape[1]))
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    reach = noise * spacing(X).repeat(n_copies)[:, None]
    return X.repeat(n_copies, axis=0) + reach * steps


def at_random(u, v, w):
    """Return points at random on shapes of one, two and three dimensions."""
    yield u[:, None]
    yield (u**3)[:, None]
    yield np.tan(np.pi * (u - 0.5))[:, None]
    yield np.c_[np.cos(6 * u), np.sin(6 * u), u, np.cos(11 * u)]
    yield np.c_[np.cos(6 * u), np.sin(6 * u)] + 1e-3 * np.c_[v, w]
    yield np.c_[np.where(w < 0.5, u, 0), np.where(w < 0.5, 0, v)]  # a cross
    yield np.c_[u, 1e3 * (w > 0.5)]
    yield np.c_[u, v]
    yield np.c_[u, v, w]


def grids(n_points):
    """Return evenly spaced points: a line, a ring, pieces far from each other."""
    line = np.arange(float(n_points))
    yield line[:, None]
    yield np.c_[
        np.cos(2 * np.pi * line / n_points), np.sin(2 * np.pi * line / n_points)
    ]
    for size in (3, 7, 8, 12, 25):  # pieces, few or many; two points may be copies
        yield np.c_[line % size, 1e3 * (line // size)]
    if n_points < 8:
        yield np.c_[line % 2, 1e3 * (line // 2)]


# Points without copies


@pytest.mark.parametrize("n_points", [2, 3, 9, 24, 60, 360, 2500])
def test_points_at_random_have_no_copies(n_points):
    for seed in range(8 if n_points < 300 else 1):
        uniform = np.random.default_rng([n_points, seed]).uniform(size=(3, n_points))
        for X in at_random(*uniform):
            np.testing.assert_array_equal(find_copies(X), np.arange(n_points))


def test_twenty_thousand_points_of_a_curve_have_no_copies():
    uniform = np.random.default_rng(0).uniform(size=(3, 20_000))
    *_, curve, _, _, _, _, _ = at_random(*uniform)
    np.testing.assert_array_equal(find_copies(curve), np.arange(20_000))


@pytest.mark.parametrize("n_points", [2, 5, 24, 48, 360])
def test_points_of_grids_and_of_few_far_pieces_have_no_copies(n_points):
    for X in grids(n_points):
        np.testing.assert_array_equal(find_copies(X), np.arange(n_points))


@pytest.mark.parametrize("name", ["free", "obstacles", "free_test", "obstacles_test"])
def test_searched_policies_have_no_copies(name):
    policies, rng = load_dataset(name)[1], np.random.default_rng(0)
    subsets = [np.arange(0, len(policies), step) for step in (1, 2, 3, 5, 8, 15, 30)]
    subsets += [rng.choice(len(policies), size, False) for size in (12, 24, 50) * 7]
    for subset in subsets:
        np.testing.assert_array_equal(
            find_copies(policies[subset]), np.arange(len(subset))
        )


def test_one_near_pair_may_be_chance():
    X = np.r_[np.arange(30.0), 7.001][:, None]
    np.testing.assert_array_equal(find_copies(X), np.arange(31))


# Points with copies


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 9), min_size=1, max_size=40), st.sampled_from([1, 5]))
def test_equal_rows_are_copies_of_the_first(picked, n_features):
    X = np.random.default_rng(0).normal(size=(10, n_features))[picked]
    np.testing.assert_array_equal(
        find_copies(X), [picked.index(each) for each in picked]
    )


def test_zeros_of_either_sign_are_equal():
    np.testing.assert_array_equal(
        find_copies(np.array([[0.0], [1.0], [-0.0]])), [0, 1, 0]
    )


@pytest.mark.parametrize("noise", [1e-13, 1e-4, 0.05])
@pytest.mark.parametrize("n_copies", [2, 3, 12])
@pytest.mark.parametrize("name", [*WORKSPACES, "pieces", "a random curve"])
def test_copies_up_to_a_twentieth_of_the_way_to_the_next_point(name, n_copies, noise):
    rng = np.random.default_rng(0)
    if name in WORKSPACES:
        X = load_dataset(name)[1][::5]
    elif name == "pieces":
        X = pieces(48)
    else:
        *_, X, _, _, _, _, _ = at_random(
            *np.random.default_rng(3).uniform(size=(3, 100))
        )
    order = rng.permutation(n_copies * len(X))
    found = find_copies(noisy(X, noise, n_copies, rng)[order])
    same = order[found] // n_copies == order // n_copies
    # Points that chance put near each other may be joined; far from all others, those
    # may be missed whose noise, a share of that distance, is as large as other steps.
    at_least = {"a random curve": 0.9, "obstacles": 0.98}.get(name, 1.0)
    assert same.mean() >= at_least
    assert len(set(found)) <= 1.06 * len(X)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("noise", [1e-8, 1e-4, 1e-3])
def test_some_of_the_points_with_a_copy(share, noise):
    X, rng = load_dataset("free")[1][::2], np.random.default_rng(0)
    twice = np.flatnonzero(rng.uniform(size=len(X)) < share)
    found = find_copies(np.r_[X, noisy(X, noise, 1, rng)[twice]])
    np.testing.assert_array_equal(found, np.r_[np.arange(len(X)), twice])


def test_scale_and_place_do_not_matter():
    X = noisy(pieces(48), 0.02, 3, np.random.default_rng(0))
    expected = find_copies(X)
    for scale, place in ((1e-50, 0), (1e50, 0), (1, 1e3), (-1, 0)):
        np.testing.assert_array_equal(find_copies(scale * X + place), expected)


# Charts of points with copies


def charts(X, n_neighbors, **fit):
    return SMCE(4, n_neighbors=n_neighbors, random_state=0, **fit).fit(X)


@pytest.mark.parametrize("form", ["normalized", "raw"])
@pytest.mark.parametrize("n_copies", [2, 8])
def test_equal_points_change_no_chart(n_copies, form):
    X = load_dataset("obstacles")[1][::6]
    one = charts(X, 12, form=form)
    for copied in (X.repeat(n_copies, axis=0), np.tile(X, (n_copies, 1))):
        many = charts(copied, 12, form=form)
        kept, first = many.copy_of_, np.unique(many.copy_of_)
        np.testing.assert_array_equal(many.labels_[first], one.labels_)
        np.testing.assert_array_equal(many.labels_, many.labels_[kept])
        np.testing.assert_array_equal(many.eigenvalues_, one.eigenvalues_)
        np.testing.assert_array_equal(many.objective_[first], one.objective_)
        np.testing.assert_array_equal(many.elbow_curve_, one.elbow_curve_)
        np.testing.assert_array_equal(
            many.coef_.toarray()[np.ix_(first, first)], one.coef_.toarray()
        )
        np.testing.assert_allclose(many.coef_.sum(axis=1), 1)
        assert not many.affinity_matrix_.diagonal().any()
        assert abs(many.affinity_matrix_ - many.affinity_matrix_.T).max() == 0


@pytest.mark.parametrize(
    ("n_neighbors", "n_copies", "noise"), [(6, 8, 0.05), (20, 2, 0.05), (20, 8, 1e-4)]
)
def test_near_copies_change_hardly_a_chart(n_copies, n_neighbors, noise):
    for X in (load_dataset("free")[1][::4], pieces(60)):
        one = charts(X, n_neighbors).labels_.repeat(n_copies)
        copied = noisy(X, noise, n_copies, np.random.default_rng(0))
        many = charts(copied, n_neighbors)
        assert adjusted_rand_score(one, many.labels_) >= 0.95


def test_equal_points_change_no_number_of_charts():
    X = load_dataset("free")[1][::7]
    one = SMCE(random_state=0).fit(X)
    for again in (X[:10], X[20:30]):  # a point counts once, however often it is given
        many = SMCE(random_state=0).fit(np.r_[X, again.repeat(7, axis=0)])
        np.testing.assert_array_equal(many.elbow_curve_, one.elbow_curve_)
        assert many.n_clusters_ == one.n_clusters_


def test_near_copies_change_no_number_of_charts():
    X = pieces(60)
    one = SMCE(n_neighbors=12, random_state=0).fit(X)
    for noise in (0.0, 1e-4, 0.02):
        many = SMCE(n_neighbors=12, random_state=0)
        many.fit(noisy(X, noise, 3, np.random.default_rng(0)))
        assert many.n_clusters_ == one.n_clusters_ > 1


def test_points_without_copies_are_clustered_as_they_are(monkeypatch):
    X = load_dataset("free")[1]  # columns one after the other: sums differ by row
    one = charts(X, 20)
    assert one.elbow_curve_[3] == within_cluster_ss(X, one.labels_)
    monkeypatch.setattr(msc.learn._smce, "find_copies", lambda X: np.arange(len(X)))
    other = charts(X, 20)
    for name in ("labels_", "objective_", "eigenvalues_", "elbow_curve_", "embedding_"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("coef_", "affinity_matrix_"):
        mine, theirs = getattr(one, name), getattr(other, name)
        for part in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(mine, part), getattr(theirs, part))


@pytest.mark.parametrize("n_distinct", [1, 2, 5])
def test_fewer_distinct_points_than_charts_are_told(n_distinct):
    X = np.arange(n_distinct).repeat(6)[:, None]
    model = SMCE(6, random_state=0)
    with pytest.warns(
        UserWarning, match=f"{n_distinct} distinct points, so n_clusters=6"
    ):
        model.fit(X)
    assert model.n_clusters_ == n_distinct
    np.testing.assert_array_equal(model.labels_, X[:, 0])


# Components of the graph


def far_pieces(n_pieces):
    t = np.arange(30.0 * n_pieces)
    return np.c_[t % 30, 1e3 * (t // 30)]


@pytest.mark.parametrize(
    ("n_clusters", "told"),
    [
        (2, "n_clusters_ is 2: the 1 largest are charts, 5 share one"),
        (4, "n_clusters_ is 4: the 3 largest are charts, 3 share one"),
        (None, "n_clusters_ is "),
    ],
)
def test_more_components_than_charts_are_told_with_counts(n_clusters, told):
    model = SMCE(n_clusters, n_neighbors=6, max_clusters=5, random_state=0)
    sentence = f"6 components, of 30 to 30 points, but {told}"
    with pytest.warns(UserWarning, match=sentence):
        model.fit(far_pieces(6))


@pytest.mark.filterwarnings("error")
def test_one_chart_was_asked_for():
    SMCE(1, n_neighbors=6).fit(far_pieces(6))


@pytest.mark.filterwarnings("error")
def test_as_many_components_as_charts_are_no_news():
    model = SMCE(4, n_neighbors=6, random_state=0).fit(far_pieces(4))
    np.testing.assert_array_equal(model.labels_, np.repeat(range(4), 30))
