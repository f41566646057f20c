"""The benchmark: that it measures the same work each way, and all that is shown."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

from msc import load_dataset
from msc.plots import benchmark_table, load_benchmark, plot_benchmark

BENCH = Path(__file__).parents[1] / "benchmarks" / "bench.py"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run the quick benchmark, away from the repository."""
    folder = tmp_path_factory.mktemp("bench")
    arguments = [sys.executable, BENCH, "--quick", "--out", folder / "costs.json"]
    result = subprocess.run(
        arguments, cwd=folder, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return load_benchmark(folder / "costs.json"), result.stdout


def leaves(value, name=""):
    """List all entries of nested figures under their joined names."""
    if isinstance(value, dict | list):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, item in pairs:
            yield from leaves(item, f"{name}.{key}")
    else:
        yield name, value


def shape(figures):
    """Return the names of all figures, list entries under one name."""
    names = (name for name, value in leaves(figures) if value is not None)
    parts = (name.split(".") for name in names)
    return {tuple(part for part in name if not part.isdigit()) for name in parts}


def test_every_figure_is_finite_and_positive(run):
    figures, _ = run
    assert figures["quick"] is True
    measured = {k: v for k, v in figures.items() if k not in ("machine", "quick")}
    for name, value in leaves(measured):
        if isinstance(value, int | float):
            assert math.isfinite(value), name
            assert value > 0 or name.endswith(("growth_mb", "apart_mm.mujoco")), name


def test_other_ways_do_the_same_job(run):
    figures, _ = run
    for measured in figures["rollouts"].values():
        assert measured["apart_mm"]["naive"] < 10
        if measured["apart_mm"]["mujoco"] is not None:
            assert measured["apart_mm"]["mujoco"] < 1


def test_smce_one_by_one_finds_the_same_optima(run):
    figures, _ = run
    learners = figures["learners"]
    assert learners["smce"]["objectives_apart"] < 1e-6
    assert learners["fits"][0]["n_points"] == 60
    assert learners["fits"][0]["peak_mb"] >= learners["fits"][0]["before_mb"]


def test_committed_smce_is_fast_enough():
    learners = load_benchmark()["learners"]
    assert learners["smce"]["n_points"] == 360
    assert learners["smce"]["one_by_one_over_fit"]["median"] > 15
    largest = learners["fits"][-1]
    assert largest["n_points"] == 10_000
    assert largest["seconds"] < 120
    assert largest["peak_mb"] < 2048


def test_what_is_printed_is_the_chapters_tables(run):
    figures, printed = run
    for what in ("rollouts", "tasks", "growth", "SMCE", "learners"):
        assert benchmark_table(figures, what).to_string() in printed
    assert "MuJoCo" in printed.splitlines()[-3]


@pytest.mark.parametrize("mujoco", [True, False])
def test_figure_and_tables_come_from_the_file_alone(run, mujoco):
    figures = json.loads(json.dumps(run[0]))
    if not mujoco:
        for measured in figures["rollouts"].values():
            measured["rollout_over_mujoco"] = None
            measured["milliseconds"]["mujoco"] = None
        labels = benchmark_table(figures, "rollouts").loc[
            "rollout / MuJoCo's, open loop"
        ]
        assert set(labels) == {"left out"}
    ways, growth = plot_benchmark(figures, {"free": load_dataset("free")[2]}).axes
    n_ways = 6 if figures["rollouts"]["free"]["milliseconds"]["mujoco"] else 5
    assert len(ways.get_yticks()) == n_ways
    assert growth.get_ylim()[0] == 0


def test_committed_figures_are_whole_and_of_a_full_run(run):
    committed = load_benchmark()
    assert committed["quick"] is False
    missing = shape(run[0]) - shape(committed)
    assert not missing


def test_a_missing_or_old_file_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.json is not there; `make bench`"):
        load_benchmark(tmp_path / "none.json")
    (tmp_path / "old.json").write_text('{"machine": {}, "memory": {}}', "utf-8")
    with pytest.raises(
        ValueError, match=r"lacks rollouts, searches, growth, skill, learners"
    ):
        load_benchmark(tmp_path / "old.json")


def test_costs_of_something_else_are_refused():
    with pytest.raises(ValueError, match=r"what='films'; wanted one of \('rollouts', "):
        benchmark_table(load_benchmark(), "films")
