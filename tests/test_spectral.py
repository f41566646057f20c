"""Eigenvectors of affinity graphs, on both roads, where nothing is left to rounding."""

import numpy as np
import pytest
import scipy.sparse as sp

import msc.spectral
from msc.smce import SMCE
from msc.spectral import cluster_rows, laplacian_eigen, unit_rows


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
        monkeypatch.setattr(msc.spectral, "_LARGEST_DENSE", 0)


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


def test_first_vectors_single_out_the_largest_components(road):
    component = np.repeat([0, 1, 2], [5, 9, 7])
    _, vectors = laplacian_eigen(graph(5, 9, 7), 3, seed=0)
    for count, expected in ((1, [0, 0, 0]), (2, [0, 1, 0]), (3, [0, 1, 2])):
        rows = unit_rows(vectors[:, :count])
        same = np.array(expected)[component][:, None] == np.array(expected)[component]
        np.testing.assert_allclose(rows @ rows.T, same, atol=1e-9)


@pytest.mark.parametrize("order", [(9, 20, 5, 14), (20, 14, 9, 5), (5, 20, 14, 9)])
def test_with_more_components_than_charts_the_smallest_share_one(road, order):
    model = SMCE(3, n_neighbors=4, random_state=0).fit(lines(*order))
    expected = [{20: 0, 14: 1, 9: 2, 5: 2}[size] for size in order for _ in range(size)]
    pairs = set(zip(model.labels_.tolist(), expected, strict=True))
    assert len(pairs) == 3


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
