"""One small example of every figure and slider: what it needs, and a call."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import pytest
from imagined import imagine_controls
from imagined_worlds import FOLDER, imagine_layouts

import msc.plots._search
import msc.skills
from msc import SMCE, Arm, Workspace, load_dataset
from msc.data import Dataset, find_data, load_results, make_two_arcs
from msc.estimates import Estimate
from msc.plots import (
    METHOD_STYLES,
    Movements,
    Walk,
    find_ratios,
    load_benchmark,
    load_times,
    plot_affinity,
    plot_bands,
    plot_benchmark,
    plot_breaks,
    plot_caught,
    plot_clusterings,
    plot_column,
    plot_comparisons,
    plot_composition,
    plot_contact_sheet,
    plot_coverage,
    plot_curves,
    plot_elbow,
    plot_elbows,
    plot_engines,
    plot_errors,
    plot_execution,
    plot_families,
    plot_finer_steps,
    plot_fits,
    plot_followed,
    plot_generations,
    plot_graph,
    plot_held,
    plot_kernels,
    plot_ladder,
    plot_leaderboard,
    plot_learning,
    plot_manifold,
    plot_maps,
    plot_other_coverage,
    plot_payoff,
    plot_pieces,
    plot_plane,
    plot_poses,
    plot_projection,
    plot_quality,
    plot_ranks,
    plot_ratios,
    plot_reconstruction,
    plot_rivals,
    plot_rollouts_spent,
    plot_sample_sizes,
    plot_savings,
    plot_searched,
    plot_section_v,
    plot_sheet,
    plot_standings,
    plot_stops,
    plot_sweep,
    plot_tasks,
    plot_times,
    plot_weights,
    plot_workspaces,
    slide_charts,
    slide_execution,
    slide_experiments,
    slide_generations,
    slide_path,
    slide_policies,
    slide_predictions,
    slide_regularization,
    slide_weight,
)
from msc.plots._sheets import look_up
from msc.robot import read_world
from msc.search import (
    SearchOptions,
    coordinates,
    draw_tasks,
    record_search,
    search_curves,
)
from msc.study import METHODS, Experiment, Ranks
from msc.worlds import load_questions

NAMES = ("without obstacles", "with obstacles")


@cache
def results(kind):
    return load_results(f"{kind}_free", f"{kind}_obstacles")


@cache
def tables():
    return [load_dataset(name)[2] for name in ("free", "obstacles")]


@cache
def experiment():
    return Experiment("obstacles", n_samples=24, names=("charts", "single regression"))


def few_movements():
    degrees = np.arange(0.0, 360.0, 45.0)
    policies = np.zeros((8, 6))
    table = pd.DataFrame({"task_deg": degrees})
    found = Dataset(np.deg2rad(degrees)[:, None], policies, table)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(msc.plots._search, "load_dataset", lambda _: found)
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
        return slide_predictions(methods, X, y, **more).poster


@cache
def verdicts():
    with TemporaryDirectory() as folder:
        return imagine_layouts(Path(folder))


def ratios():
    asked = load_questions(FOLDER / "asked.yml")
    return [one for one in asked if one.wanted == 1 and one.measure != "jumps"]


def maps():
    world = read_world(FOLDER / "annulus1.toml")
    tasks = draw_tasks(world, 60)
    table = pd.DataFrame(tasks, columns=list(world.task_names))
    angles = np.deg2rad(table["task_deg"])
    labels = (angles // 0.9).astype(int).to_numpy()
    data = Dataset(coordinates(world, tasks), np.zeros((60, 6)), table)
    error_cm = {"charts": angles, "single regression": 2 * angles}
    shown = {"pieces": labels, "charts": labels // 2, "error_cm": error_cm}
    return plot_maps(world, data, test=data, **shown)


def engines():
    rng = np.random.default_rng(0)
    met = [number % 3 == 0 for number in range(72)]
    one = {
        "touched": met,
        "touched_elsewhere": met,
        "joints_rad": [0.1 if one else 1e-15 for one in met],
        "cost": [0.05] * 72,
        "cost_elsewhere": [
            0.05 * rng.uniform(0.9, 1.3) if one else 0.05 for one in met
        ],
    }
    return plot_engines({"worlds": {"layout01": one}})


def finer_steps():
    one = {
        "cost": [[2, 3], [2.1, 3], [2.2, 3]],
        "impulse_n_s": [[1, 2], [3, 4], [1, 2]],
    }
    other = {
        "cost": [[2, 3], [2, 3], [2.02, 3]],
        "impulse_n_s": [[2, 2], [2, 3], [2, 3]],
    }
    steps = {"substeps": [4, 16, 64], "pybullet": one, "mujoco": other}
    return plot_finer_steps({"steps": {"layout01": steps}})


def searched():
    folder = find_data() / "worlds"
    both = {"PyBullet": "layout01", "MuJoCo": "mujoco01"}
    return {name: load_dataset(folder / f"{of}.csv") for name, of in both.items()}


def bands():
    def told(coverage, score):
        pairs = {"coverage": coverage, "width": score, "score": score}
        return {
            key: {"value": one, "low": 0.9 * one, "high": min(1.1 * one, 1)}
            for key, one in pairs.items()
        }

    some = {"away": told(0.9, 0.5), "beside": told(0.6, 0.8)}
    caught = {"0.1": 0.3, "0.2": 0.5, "0.5": 0.9}
    of = {
        "bands": {"gaussian": some, "conformal": {**some, "beside": {}}},
        "failures": [20, 100],
        "caught": {"std": caught, "gate": caught},
    }
    return {"charts": of, "single regression": {**of, "caught": {"std": caught}}}


def weights():
    with Arm(Workspace.free()) as arm:
        return slide_weight(arm, np.zeros(6), 60, 1, [-30, 0, 30]).poster


@cache
def recordings():
    brief = SearchOptions(max_evaluations=45)
    return record_search(Workspace.obstacles(), 120, seed=3, n_starts=2, options=brief)


def plain():
    every = SearchOptions(max_evaluations=45, agreement=2)
    return search_curves(
        Workspace.obstacles(), [120], seed=3, n_starts=2, options=every
    )[0]


@cache
def curves():
    points, labels = make_two_arcs()
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


@cache
def controls():
    """Return studies of all methods, each with means of its own, over decades."""
    names = [name for name in METHODS if METHODS[name].sets != "sweep"]
    means = dict(zip(names, np.geomspace(1e-3, 1e3, len(names)), strict=True))
    return [imagine_controls(world, means) for world in ("free", "obstacles")]


def charts():
    found = experiment()
    X, y = found.tasks[found.chosen], found.policies[found.chosen]
    return slide_charts(X, y, 1).poster


def ranks():
    means = pd.Series(np.linspace(2, 28, 30), index=[*METHODS][:30])
    return Ranks(means, 16, 10.8, 0.0, 0.0, {[*METHODS][30]: "no results in 'free'"})


def column():
    places = np.linspace(0, 300, 30)
    rows, doubt = np.c_[places, np.sin(places)], np.full(30, 0.1)
    names = "an angle of $5 and $6, in degrees, which is long", "push (N)"
    charts = np.arange(30) // 5
    curve = places, rows[:, 1], doubt
    return plot_column(rows, charts, names=names, curve=curve, jumps=[140.0])


def plane():
    points = np.random.default_rng(0).uniform(size=(30, 2))
    names = "mass (kg)", "the angle at which it is held (deg)"
    look = {"values": points.sum(axis=1), "jumps": points[:4].reshape(2, 2, 2)}
    return plot_plane(points, names=names, title="push", **look)


def learners_of_tables():
    return [
        {"method": name, "error": 0.1 + k / 9, "low": 0.05, "high": 1.0 + k}
        for k, name in enumerate(msc.skills.METHODS)
    ]


def learning():
    return plot_learning(
        [
            {"method": name, "n_tasks": size, "error": (3 + k) / size}
            for k, name in enumerate([*msc.skills.METHODS][3:10])
            for size in (125, 250, 500)
        ]
    )


def walk():
    places = np.linspace(0, 300, 5)
    rows = np.c_[places, np.cos(places), 1000 * np.sin(places)]
    return Walk(
        task="angle (deg)",
        policies=["push $", "lift"],
        places=places,
        means=rows[:, 1:],
        stds=np.full((5, 2), 0.1),
        rows=rows,
        charts=np.array([0, 0, 1, 1, 1]),
        near=rows[[[0, 1], [1, 2], [2, 3], [3, 4], [4, 3]]],
        captions=[f"at {place:g}" for place in places],
    )


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
    slide_predictions: predictions,
    slide_execution: lambda: slide_execution(experiment(), every=60).poster,
    slide_experiments: lambda: (
        slide_experiments({24: experiment()}, "training tasks", first=24).poster
    ),
    plot_benchmark: lambda: plot_benchmark(load_benchmark()),
    plot_fits: lambda: plot_fits(load_benchmark()),
    plot_composition: composition,
    plot_leaderboard: lambda: plot_leaderboard(results("study")[1]),
    plot_ranks: lambda: plot_ranks(ranks()),
    plot_times: lambda: plot_times(load_times()),
    plot_coverage: lambda: plot_coverage(*load_results("coverage")),
    plot_other_coverage: lambda: plot_other_coverage(*load_results("coverage")),
    plot_ratios: lambda: plot_ratios(
        find_ratios(*results("study"), measures=["mse, gate learned", "error_cm"])
    ),
    plot_comparisons: lambda: plot_comparisons(
        *(Estimate(0.5, 0, 3, "execution error", name) for name in METHOD_STYLES)
    ),
    plot_pieces: lambda: plot_pieces(
        np.arange(360.0), {"single linkage, 9": np.arange(360) // 40}, [14, 93]
    ),
    plot_sample_sizes: lambda: plot_sample_sizes(
        *results("study"), methods=list(METHOD_STYLES), verdicts=False
    ),
    plot_section_v: lambda: plot_section_v(*results("study")),
    plot_savings: lambda: plot_savings(*results("savings")),
    plot_sweep: lambda: plot_sweep(*results("study"), measures=["mse, gate learned"]),
    slide_weight: weights,
    slide_path: lambda: slide_path(Workspace.free(), np.zeros(6), 60, 60).poster,
    plot_rollouts_spent: lambda: plot_rollouts_spent(recordings(), plain()),
    plot_generations: lambda: plot_generations(
        Workspace.obstacles(), 120, recordings(), shown=(1, 3, 5)
    ),
    slide_generations: lambda: (
        slide_generations(Workspace.obstacles(), 120, recordings()[0]).poster
    ),
    plot_clusterings: clusterings,
    plot_graph: graph,
    plot_reconstruction: reconstruction,
    plot_affinity: lambda: plot_affinity(curves()[2]),
    slide_regularization: lambda: (
        slide_regularization(*curves()[:2], [0, 10], first=1).poster
    ),
    slide_charts: charts,
    plot_stops: lambda: plot_stops(experiment(), ["charts", "single regression"]),
    plot_kernels: lambda: plot_kernels(*controls()),
    plot_ladder: lambda: plot_ladder(*controls()),
    plot_sheet: lambda: plot_sheet(*look_up("layout07")[:3]),
    plot_contact_sheet: lambda: plot_contact_sheet(["layout01", "arm6"] * 4),
    plot_projection: lambda: plot_projection(*controls()),
    plot_families: lambda: plot_families(verdicts(), ratios()),
    plot_standings: lambda: plot_standings(verdicts()),
    plot_payoff: lambda: plot_payoff(verdicts(), ratios()[:4]),
    plot_maps: maps,
    plot_bands: lambda: plot_bands(bands()),
    plot_caught: lambda: plot_caught(bands()),
    plot_engines: engines,
    plot_finer_steps: finer_steps,
    plot_searched: lambda: plot_searched(searched()),
    plot_column: column,
    plot_plane: plane,
    plot_elbow: lambda: plot_elbow([5.0, 2.0, 0.5, 0.4, 0.3], 3),
    plot_errors: lambda: plot_errors(learners_of_tables(), "charts"),
    plot_held: lambda: plot_held(
        [
            {"level": level, "held": 0.9 * level, "low": 0.8 * level, "high": level}
            for level in (0.5, 0.8, 0.9, 0.99)
        ]
    ),
    plot_learning: learning,
    slide_policies: lambda: slide_policies(walk()).poster,
}
