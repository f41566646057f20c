"""Two curves that nearly touch, and what is drawn of graphs and charts."""

import numpy as np
import pytest
from sklearn.neighbors import NearestNeighbors

from msc import SMCE
from msc.data import make_two_arcs
from msc.plots import (
    plot_affinity,
    plot_clusterings,
    plot_reconstruction,
    slide_charts,
    slide_regularization,
)
from msc.plots._graph import MAX_CHARTS, edges, plot_graph

points, curves = make_two_arcs()


@pytest.fixture(scope="module")
def smce():
    return SMCE(2, random_state=0).fit(points)


def test_the_curves_come_nearer_than_their_points_are():
    nearest = NearestNeighbors(n_neighbors=1).fit(points).kneighbors()[1][:, 0]
    assert (curves[nearest] != curves).any()
    upper, lower = points[curves == 0], points[curves == 1]
    apart = np.linalg.norm(upper[:, None] - lower, axis=2).min()
    assert 0.045 <= apart < np.linalg.norm(np.diff(upper, axis=0), axis=1).min()


@pytest.mark.parametrize(("n_points", "gap"), [(2, 0.1), (9, 0.0)])
def test_too_few_points_or_no_gap_are_refused(n_points, gap):
    with pytest.raises(ValueError, match=rf"n_points={n_points}, gap={gap}; wanted"):
        make_two_arcs(n_points, gap)


def test_edges_are_the_pairs_of_the_affinity(smce):
    pairs = edges(smce)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert 2 * len(pairs) == smce.affinity_matrix_.nnz
    assert all(smce.affinity_matrix_[i, j] > 0 for i, j in pairs[:10])


def test_a_panel_a_way_and_a_colour_a_label():
    figure = plot_clusterings(points, {"one": 0 * curves, "two": curves})
    one, two = figure.axes
    assert (len(one.lines), len(two.lines)) == (1, 2)
    np.testing.assert_array_equal(two.lines[1].get_xydata(), points[curves == 1])


def test_a_point_is_joined_to_those_it_is_made_of(smce):
    plane, bars = plot_reconstruction(points, smce, 29).axes
    made_of = smce.coef_[[29]].indices
    [lines] = plane.collections
    ends = {tuple(segment[1]) for segment in lines.get_segments()}
    assert ends == {tuple(points[j]) for j in made_of}
    [shares] = bars.lines
    assert shares.get_ydata().sum() == pytest.approx(np.abs(smce.coef_[[29]]).sum())
    heights = [bar.get_height() for bar in bars.patches]
    assert sum(heights) == pytest.approx(1)
    assert len(heights) == smce.n_neighbors
    assert heights[0] > 0  # the point itself is none of its neighbours
    assert heights == sorted(heights)


def test_every_affinity_is_a_dot(smce):
    matrix, spectrum = plot_affinity(smce).axes
    assert sum(len(line.get_xdata()) for line in matrix.lines) == (
        smce.affinity_matrix_.nnz
    )
    np.testing.assert_array_equal(spectrum.lines[0].get_ydata(), smce.eigenvalues_[:12])


def test_the_graph_has_a_line_an_edge(smce):
    [axis] = plot_graph(points, smce, "a graph").axes
    assert len(axis.collections[0].get_segments()) == len(edges(smce))


def test_the_slider_over_regularisation_tells_what_each_graph_is(smce):
    slider = slide_regularization(points, curves, [0, 10, 1000], first=1)
    nothing, usual, most = slider.captions
    assert "in one piece. Charts and curves differ" in nothing
    assert f"λ = 10: {len(edges(smce))} edges" in usual
    assert usual.endswith("The charts are the curves.")
    assert "in 4 pieces" in most
    within, between = (mark.points for mark in slider.panels[0].marks[:2])
    pairs = edges(smce)
    across = curves[pairs[:, 0]] != curves[pairs[:, 1]]
    assert (len(within[1]), len(between[1])) == (2 * (~across).sum(), 2 * across.sum())


@pytest.fixture(scope="module")
def slider():
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    policies = np.c_[np.cos(angle), np.sin(angle), angle // np.pi]
    return slide_charts(angle[:, None], policies, 2)


def test_the_slider_over_charts_cuts_into_as_many(slider):
    plane, weight, _ = slider.panels
    for panel, n_still in ((plane, 1), (weight, 0)):
        dots = panel.marks[n_still:]
        for step in range(MAX_CHARTS):
            sizes = [len(mark.points[step]) for mark in dots]
            assert sum(sizes) == 60
            assert np.count_nonzero(sizes) == step + 1
    assert slider.first == 3
    assert slider.captions[1].startswith("2 charts, of 30, 30 policies.")


def test_one_elbow_is_told(slider):
    told = [caption for caption in slider.captions if caption.endswith("elbow is.")]
    assert len(told) == 1
    assert len(slider.to_html()) < 300_000
