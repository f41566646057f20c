"""One small example of every figure and slider: what it needs, and a call."""

import numpy as np
import pandas as pd
import pytest

import msc.cmaes
import msc.movements
from msc import SMCE, Arm, Workspace, load_dataset
from msc.cost_tables import load_costs
from msc.evaluation import Experiment
from msc.generations import record_search
from msc.looks import LOOKS
from msc.movements import Movements
from msc.plots import plot_execution, plot_manifold
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
from msc.plots_world import plot_workspaces
from msc.results import load_results
from msc.toys import near_curves

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


def recordings():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.cmaes, "MAX_EVALUATIONS", 170)
        return record_search(Workspace.obstacles(), 120, seed=3, n_starts=2)


def curves():
    points, labels = near_curves()
    return points, labels, SMCE(2, random_state=0).fit(points)


def clusterings():
    points, labels, _ = curves()
    ways = ("k-means", "spectral, nearest", "SMCE")
    return plot_clusterings(points, dict.fromkeys(ways, labels))


def graph():
    points, _, smce = curves()
    return plot_graph(points, smce, "20 neighbours")


def reconstruction():
    points, _, smce = curves()
    return plot_reconstruction(points, smce, 29)


def charts():
    found = experiment()
    X, y = found.tasks[found.chosen], found.policies[found.chosen]
    return scrub_charts(X, y, 1).poster


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
    plot_generations: lambda: plot_generations(
        Workspace.obstacles(), 120, recordings(), shown=(1, 5, 10)
    ),
    scrub_generations: lambda: (
        scrub_generations(Workspace.obstacles(), 120, recordings()[0]).poster
    ),
    plot_clusterings: clusterings,
    plot_graph: graph,
    plot_reconstruction: reconstruction,
    plot_affinity: lambda: plot_affinity(curves()[2]),
    scrub_regularization: lambda: (
        scrub_regularization(*curves()[:2], [0, 10], first=1).poster
    ),
    scrub_charts: charts,
}
