"""The figures of the book can be read where they are shown and where they are printed.

The rule: a figure keeps its size, but wherever it goes it is no wider than 7 inches:
that is the page's column at a window of 1280 pixels (96 to the inch), and a paper's two
columns of 3.4 inches with the gap between them. There no text is smaller than 7 points
(subscripts excepted, which matplotlib sets at 0.7 of the text's size), and none is cut
off.
"""

import importlib
import inspect
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.text import Text

import msc.movements
import msc.search
from msc import SMCE, Arm, Workspace, load_dataset
from msc.cost_tables import load_costs
from msc.evaluation import Experiment
from msc.generations import record_search
from msc.looks import LOOKS
from msc.movements import Movements
from msc.plots import plot_execution, plot_manifold, plot_workspaces
from msc.plots_arm import plot_followed, plot_poses, plot_weights
from msc.plots_audit import plot_curves, plot_quality
from msc.plots_charts import plot_elbows
from msc.plots_costs import plot_costs
from msc.plots_curves import plot_rivals
from msc.plots_generations import plot_generations
from msc.plots_generations_scrubber import scrub_generations
from msc.plots_graph import (
    plot_affinity,
    plot_clusterings,
    plot_graph,
    plot_reconstruction,
)
from msc.plots_graph_scrubber import scrub_charts, scrub_regularization
from msc.plots_movements import plot_breaks, plot_tasks
from msc.plots_predicted import scrub_predictions
from msc.plots_scrubber import scrub_execution
from msc.plots_skill import plot_composition
from msc.plots_study import plot_sample_sizes, plot_sweep
from msc.plots_weights import scrub_weight
from msc.results import load_results
from msc.toys import near_curves

PACKAGE = Path(__file__).parents[1] / "msc"
WIDEST, SMALLEST = 7.0, 7.0  # inches, points
NAMES = ("without obstacles", "with obstacles")


def results(kind):
    return load_results(f"{kind}_free", f"{kind}_obstacles")


def tables():
    return [load_dataset(name)[2] for name in ("free", "obstacles")]


def experiment():
    return Experiment("obstacles", n_samples=24, names=("charts", "single regression"))


def few_movements():
    degrees = np.arange(0.0, 360.0, 45.0)
    policies = np.zeros((8, 6))
    found = np.deg2rad(degrees)[:, None], policies, pd.DataFrame({"task_deg": degrees})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.movements, "load_dataset", lambda _: found)
        return Movements("obstacles")


def followed():
    world = Workspace.free()
    with Arm(world) as arm:
        rollout = arm.execute(np.zeros(6), 60)
    return plot_followed(world, 60, {"none": rollout.path}, {"none": rollout})


def learners():
    found = experiment()
    X, y = found.tasks[found.chosen], found.policies[found.chosen]
    return found, found.methods, X, y


def composition():
    found, methods, X, y = learners()
    with Arm(found.workspace) as arm:
        rollout = arm.execute(np.zeros(6), 123.4)
    place = {"world": found.workspace, "task_deg": 123.4, "rollout": rollout}
    return plot_composition(methods["charts"], X, y, weight=1, **place)


def rivals():
    found, methods, *_ = learners()
    more = {"chosen": found.chosen, "weight": 1}
    return plot_rivals(methods, found.tasks, found.policies, **more)


def predictions():
    found, methods, X, y = learners()
    with Arm(found.workspace) as arm:
        more = {"arm": arm, "degrees": [3.4, 123.4], "weight": 1}
        return scrub_predictions(methods, X, y, **more).poster


def weights():
    with Arm(Workspace.free()) as arm:
        return scrub_weight(arm, np.zeros(6), 60, 1, [-30, 0, 30]).poster


def starts():
    world = Workspace.obstacles()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.search, "MAX_EVALUATIONS", 170)
        return world, 342, record_search(world, 342, seed=0, n_starts=3)


def generations():
    world, task_deg, found = starts()
    return scrub_generations(world, task_deg, found[0]).poster


def toy():
    points, _ = near_curves()
    return points, SMCE(2, random_state=0).fit(points)


def ways():
    points, curves = near_curves()
    return plot_clusterings(points, {"k-means": curves, "single linkage": curves})


FIGURES = {
    plot_workspaces: lambda: plot_workspaces(Workspace.free(), Workspace.obstacles()),
    plot_manifold: lambda: plot_manifold(experiment(), range(6)),
    plot_execution: lambda: plot_execution(experiment()),
    plot_poses: lambda: plot_poses(Workspace.free(), 60),
    plot_weights: lambda: plot_weights(Workspace.free(), 60, 30.0),
    plot_followed: followed,
    plot_quality: lambda: plot_quality(*tables(), names=NAMES),
    plot_curves: lambda: plot_curves(*tables(), names=NAMES),
    plot_elbows: lambda: plot_elbows(*results("elbow")),
    plot_rivals: rivals,
    plot_generations: lambda: plot_generations(*starts()),
    scrub_generations: generations,
    plot_clusterings: ways,
    plot_reconstruction: lambda: plot_reconstruction(*toy(), 29),
    plot_affinity: lambda: plot_affinity(toy()[1]),
    plot_graph: lambda: plot_graph(*toy(), "a graph"),
    scrub_regularization: lambda: scrub_regularization(*near_curves(), [10]).poster,
    scrub_charts: lambda: scrub_charts(*load_dataset("obstacles")[:2], 0).poster,
    plot_tasks: lambda: plot_tasks(few_movements(), range(8)),
    plot_breaks: lambda: plot_breaks(few_movements(), [(0, 1)] * 6),
    scrub_predictions: predictions,
    scrub_execution: lambda: scrub_execution(experiment(), every=60).poster,
    plot_costs: lambda: plot_costs(
        load_costs(), dict(zip(("free", "obstacles"), tables(), strict=True))
    ),
    plot_composition: composition,
    plot_sample_sizes: lambda: plot_sample_sizes(
        *results("study"), methods=list(LOOKS), verdicts=False
    ),
    plot_sweep: lambda: plot_sweep(*results("study"), measures=["mse, gate learned"]),
    scrub_weight: weights,
}


def test_every_figure_of_the_package_is_here():
    found = set()
    for path in PACKAGE.glob("plots*.py"):
        module = importlib.import_module(f"msc.{path.stem}")
        found |= {
            function
            for name, function in inspect.getmembers(module, inspect.isfunction)
            if name.startswith(("plot_", "scrub_"))
        }
    assert found == set(FIGURES), "give the new figure an example"


@pytest.fixture(scope="module", params=FIGURES, ids=lambda plot: plot.__name__)
def figure(request):
    return FIGURES[request.param]()


def texts(figure):
    """Return all that is written in a figure, with where it is (inches)."""
    figure.draw_without_rendering()
    found = [text for text in figure.findobj(Text) if text.get_text().strip()]
    hidden = set().union(*(hidden_labels(axes) for axes in figure.axes))
    return [
        (text, text.get_window_extent().extents / figure.dpi)
        for text in found
        if text.get_visible() and text not in hidden
    ]


def hidden_labels(axes):
    """Return what belongs to ticks that are not drawn: in store, or out of view."""
    hidden = set()
    for axis in (axes.xaxis, axes.yaxis):
        low, high = sorted(axis.get_view_interval())
        in_use = {*axis.get_major_ticks(), *axis.get_minor_ticks()}
        for tick in {*axis.majorTicks, *axis.minorTicks}:
            if not (axes.axison and tick in in_use and low <= tick.get_loc() <= high):
                hidden |= {tick.label1, tick.label2}
    return hidden


def test_text_is_large_enough(figure):
    shrunk = min(1.0, WIDEST / figure.get_figwidth())
    small = {
        text.get_text(): round(text.get_fontsize() * shrunk, 2)
        for text, _ in texts(figure)
        if text.get_fontsize() * shrunk < SMALLEST
    }
    assert not small


def test_nothing_is_cut_off(figure):
    width, height = figure.get_size_inches()
    outside = [
        text.get_text()
        for text, (x0, y0, x1, y1) in texts(figure)
        if min(x0, y0) < -0.05 or x1 > width + 0.05 or y1 > height + 0.05
    ]
    assert not outside


def test_a_figure_loses_hardly_anything_to_the_column(figure):
    assert figure.get_figwidth() <= 7.5
