"""Eigenvectors of affinity graphs, on both roads, where nothing is left to rounding."""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import ArpackNoConvergence

import msc.learn._spectral
from msc import SMCE
from msc.learn._spectral import cluster_rows, laplacian_eigen, unit_rows


def lines(*sizes):
    """Return points of straight lines far from each other, in the order of sizes."""
    return np.concatenate(
        [
            np.c_[np.arange(size), np.full(size, 100.0 * i)]
            for i, size in enumerate(sizes)
        ]
    )


def graph(*sizes):
    """Return the affinity of chains that are not connected."""
    chains = [sp.diags_array([np.ones(n - 1)] * 2, offsets=(-1, 1)) for n in sizes]
    return sp.csr_array(sp.block_diag(chains))


@pytest.fixture(params=["dense", "sparse"])
def road(request, monkeypatch):
    if request.param == "sparse":
        monkeypatch.setattr(msc.learn._spectral, "_LARGEST_DENSE", 0)


@pytest.mark.parametrize("sizes", [(40,), (9, 30), (5, 8, 6, 7), (3,) * 30])
def test_both_roads_give_eigenvectors(road, sizes):
    affinity, k = graph(*sizes), 6
    values, vectors = laplacian_eigen(affinity, k, seed=0)
    scale = np.diag(1 / np.sqrt(affinity.sum(axis=1)))
    laplacian = np.eye(len(scale)) - scale @ affinity.toarray() @ scale
    np.testing.assert_allclose(
        values[:k], np.linalg.eigvalsh(laplacian)[:k], atol=1e-10
    )
    np.testing.assert_allclose(laplacian @ vectors, vectors * values[:k], atol=1e-9)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(k), atol=1e-9)
    assert (values[:k] < 1e-10).sum() == min(len(sizes), k)


@pytest.mark.parametrize("n_points", [100, 500, 501, 2500, 20_000])
def test_eigenvalues_of_a_long_chain_and_of_a_long_ring(n_points):
    """Both are known in closed form; those of a ring come in pairs."""
    chain, k = graph(n_points), np.arange(1, 8)
    values, _ = laplacian_eigen(chain, 8, seed=0)
    expected = 2 * np.sin(np.pi * k / (n_points - 1) / 2) ** 2
    np.testing.assert_allclose(values[1:8], expected, rtol=1e-10)
    values, vectors = laplacian_eigen(ring(n_points), 8, seed=0)
    expected = 2 * np.sin(np.pi * ((k + 1) // 2) / n_points) ** 2
    np.testing.assert_allclose(values[1:8], expected, rtol=1e-10)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(8), atol=1e-9)
    assert values[0] < 1e-14


def ring(n_points, weight=1.0):
    """Return the affinity of points round a circle."""
    places = np.arange(n_points)
    ends = (places, (places + 1) % n_points)
    half = sp.csr_array((np.full(n_points, weight), ends), (n_points, n_points))
    return (half + half.T).tocsr()


def product(one, other):
    """Return the affinity of a graph whose eigenvalues, times degrees, are sums."""
    left, right = sp.eye_array(one.shape[0]), sp.eye_array(other.shape[0])
    return (sp.kron(one, right) + sp.kron(left, other)).tocsr()


@pytest.mark.parametrize(
    ("n_rings", "n_points", "weight"),
    [
        *((3, 20, weight) for weight in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15)),
        *((4, 600, weight) for weight in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15)),
        *((300, 20, weight) for weight in (1e-3, 1e-6, 1e-9)),
    ],
)
def test_eigenvalues_of_rings_that_hardly_hold_together(n_rings, n_points, weight):
    """However small, they have digits: sums of both rings' over the degree."""
    k = min(n_rings, 9)
    values, _ = laplacian_eigen(product(ring(n_rings, weight), ring(n_points)), k, 0)
    across = 4 * weight * np.sin(np.pi * np.arange(n_rings) / n_rings) ** 2
    within = 4 * np.sin(np.pi * np.arange(n_points) / n_points) ** 2
    expected = np.sort((across[:, None] + within).ravel()) / (2 + 2 * weight)
    np.testing.assert_allclose(values[1:k], expected[1:k], rtol=1e-9)
    assert values[0] < 1e-14


@pytest.mark.parametrize("n_vectors", [5, 9, 12])
@pytest.mark.parametrize("seed", range(3))
def test_no_vector_of_a_multiple_eigenvalue_is_missed(n_vectors, seed):
    """A cube in ten dimensions has the eigenvalue 0.2 ten times."""
    edge = sp.csr_array(np.array([[0.0, 1.0], [1.0, 0.0]]))
    cube = edge
    for _ in range(9):
        cube = product(cube, edge)
    values, vectors = laplacian_eigen(cube, n_vectors, seed)
    expected = np.repeat([0, 0.2, 0.4], [1, 10, 45])[:n_vectors]
    np.testing.assert_allclose(values, expected, atol=1e-12)
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(n_vectors), atol=1e-9)


def crowd(n_points, n_neighbors=4):
    """Return the affinity of points each joined to others at random."""
    rows = np.repeat(np.arange(n_points), n_neighbors)
    columns = np.random.default_rng(0).integers(0, n_points, len(rows))
    half = sp.csr_array((np.ones(len(rows)), (rows, columns)), (n_points, n_points))
    return (half + half.T).tocsr()


def test_where_all_is_near_no_inverse_is_needed(monkeypatch):
    """It would be full."""
    monkeypatch.setattr(msc.learn._spectral, "splu", None)
    affinity = crowd(5000)
    values, vectors = laplacian_eigen(affinity, 4, seed=0)
    scale = sp.diags_array(1 / np.sqrt(affinity.sum(axis=1)))
    laplacian = sp.eye_array(len(vectors)) - scale @ affinity @ scale
    np.testing.assert_allclose(laplacian @ vectors, vectors * values, atol=1e-9)
    assert values[1] > 0.1


def test_without_an_inverse_or_with_one_it_is_the_same(monkeypatch):
    found = []
    for depth in (0, 99):
        monkeypatch.setattr(msc.learn._spectral, "_DEEP", depth)
        found.append(laplacian_eigen(crowd(1000), 4, seed=0)[0])
    np.testing.assert_allclose(*found, rtol=1e-10, atol=1e-14)


def test_where_the_iteration_fails_it_goes_on_with_an_inverse(monkeypatch):
    expected = laplacian_eigen(ring(600), 4, seed=0)[0]
    monkeypatch.setattr(msc.learn._spectral, "_RESTARTS", 4)
    monkeypatch.setattr(msc.learn._spectral, "_DEEP", 600)
    np.testing.assert_array_equal(laplacian_eigen(ring(600), 4, seed=0)[0], expected)


def test_the_same_seed_gives_the_same_bytes():
    """Also where the iteration has to start again, as it ends at once."""
    complete = sp.csr_array(np.ones((512, 512)) - np.eye(512))
    one, other = (laplacian_eigen(complete, 10, seed=3)[1] for _ in range(2))
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("solver", "error", "told"),
    [
        ("eigsh", ArpackNoConvergence("%s converged", [], []), "converged"),
        ("splu", RuntimeError("Factor is exactly singular"), "exactly singular"),
        ("splu", MemoryError("no room"), "no room"),
    ],
)
def test_a_failing_solver_is_told_of_with_a_remedy(monkeypatch, solver, error, told):
    def fail(*arguments, **options):
        raise error

    monkeypatch.setattr(msc.learn._spectral, solver, fail)
    u = np.linspace(0, 1, 600)
    sentence = f"graph of 1200 points, in 2 components.*{told}.*Try fewer max_clusters"
    with pytest.raises(np.linalg.LinAlgError, match=sentence):
        SMCE(2, n_neighbors=6).fit(np.c_[np.r_[u, u], np.repeat([0, 9], 600)])


@pytest.mark.parametrize("weight", [1e-6, 1e-10, 1e-14])
def test_pieces_that_hardly_hold_together(weight):
    chain = graph(1100, 1100, 1100)
    joint = sp.coo_array(([weight] * 2, ([1099, 1100], [1100, 1099])), chain.shape)
    values, vectors = laplacian_eigen((chain + joint).tocsr(), 4, seed=0)
    first, second, third = np.split(unit_rows(vectors[:, :3]), 3)
    assert (values[:3] < 1e-6).all()
    assert values[3] > 1e-6
    for rows in (first, second, third):  # a point for each piece, apart from the others
        np.testing.assert_allclose(rows, rows[[0]].repeat(1100, axis=0), atol=0.05)
    for one, other in ((first, second), (first, third), (second, third)):
        assert abs(one[0] @ other[0]) < 0.1


SHAPES = {
    "a curve": lambda u, v: np.c_[np.cos(6 * u), np.sin(6 * u), u, np.cos(11 * u)],
    "a line": lambda u, v: u[:, None],
    "a ring": lambda u, v: np.c_[np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)],
    "a sheet": lambda u, v: np.c_[u, v, u * v],
    "far lines": lambda u, v: np.c_[u, 1e3 * (v > 0.5)],
    "hundreds": lambda u, v: np.c_[u, 1e3 * (300 * v).astype(int)],
}


@pytest.mark.filterwarnings("ignore:The graph has")
@pytest.mark.parametrize("shape", SHAPES)
def test_a_thousand_points_at_random(shape):
    """Charts hold together: no point's chart differs from most of its neighbours'."""
    u, v = np.random.default_rng(0).uniform(size=(2, 1001))
    model = SMCE(4, n_neighbors=12, random_state=0).fit(SHAPES[shape](u, v))
    assert set(model.labels_) == {0, 1, 2, 3}
    links = model.affinity_matrix_.tocoo()
    same = model.labels_[links.row] == model.labels_[links.col]
    assert links.data[same].sum() > 0.95 * links.data.sum()


def test_every_shape_is_a_chart():
    u, v = np.random.default_rng(0).uniform(size=(2, 2000))
    shapes = [SHAPES[name](u, v) for name in ("a ring", "a sheet", "a curve")]
    wide = [np.pad(X, ((0, 0), (0, 4 - X.shape[1]))) for X in shapes]
    X = np.concatenate([9 * i + 0.02 * np.floor(50 * x) for i, x in enumerate(wide)])
    model = SMCE(3, n_neighbors=12, random_state=0).fit(X)
    np.testing.assert_array_equal(model.labels_, np.repeat([0, 1, 2], 2000))


def test_first_vectors_single_out_the_largest_components(road):
    component = np.repeat([0, 1, 2], [5, 9, 7])
    _, vectors = laplacian_eigen(graph(5, 9, 7), 3, seed=0)
    for count, expected in ((1, [0, 0, 0]), (2, [0, 1, 0]), (3, [0, 1, 2])):
        rows = unit_rows(vectors[:, :count])
        same = np.array(expected)[component][:, None] == np.array(expected)[component]
        np.testing.assert_allclose(rows @ rows.T, same, atol=1e-9)


@pytest.mark.parametrize("order", [(9, 20, 5, 14), (20, 14, 9, 5), (5, 20, 14, 9)])
def test_with_more_components_than_charts_the_smallest_share_one(road, order):
    model = SMCE(3, n_neighbors=4, random_state=0)
    with pytest.warns(UserWarning, match="4 components, of 5 to 20 .*the 2 largest"):
        model.fit(lines(*order))
    expected = [{20: 0, 14: 1, 9: 2, 5: 2}[size] for size in order for _ in range(size)]
    pairs = set(zip(model.labels_.tolist(), expected, strict=True))
    assert len(pairs) == 3


@pytest.mark.filterwarnings("ignore:The graph has")
def test_elbow_curve_of_components_does_not_hang_on_rounding(road):
    X = lines(12, 10, 8, 6)
    one = SMCE(n_neighbors=4, random_state=0).fit(X)
    other = SMCE(n_neighbors=4, random_state=0).fit(X * (1 + 1e-13))
    np.testing.assert_allclose(one.elbow_curve_[:4], other.elbow_curve_[:4])


def test_thousands_of_points_of_four_pieces():
    rng = np.random.default_rng(0)
    t, piece = np.arange(2200) % 550 / 550, np.repeat(range(4), 550)
    turn = rng.normal(size=(4, 2, 6))
    curve = np.stack([np.cos(3 * t), np.sin(3 * t)], axis=1)
    X = np.einsum("ij,ijk->ik", curve, turn[piece]) + 3 * rng.normal(size=(4, 6))[piece]
    X += 1e-4 * rng.normal(size=X.shape)
    model = SMCE(4, n_neighbors=12, max_clusters=4, random_state=0).fit(X)
    np.testing.assert_array_equal(model.labels_, piece)
    assert model.eigenvalues_.shape == (4,)


@pytest.mark.parametrize("size", [2, 3])
def test_rounding_decides_nothing_for_a_component_without_a_start(size):
    _, vectors = laplacian_eigen(graph(120, size), 4, seed=0)
    rows, rng = unit_rows(vectors), np.random.default_rng(0)
    expected = [cluster_rows(rows, seed) for seed in range(5)]
    for _ in range(5):
        shaken = rows + 1e-12 * rng.standard_normal(rows.shape)
        for seed, labels in enumerate(expected):
            np.testing.assert_array_equal(cluster_rows(shaken, seed), labels)
