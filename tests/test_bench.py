"""The benchmark: that it measures the same work each way, and all that is shown."""

import ast
import gc
import importlib
import io
import json
import math
import sys
import warnings
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path

import pytest

from msc import load_dataset
from msc.plots import benchmark_table, load_benchmark, plot_benchmark, plot_fits

ROOT = Path(__file__).parents[1]
BENCH = ROOT / "benchmarks" / "bench.py"
WORLD = "obstacles"  # that is measured here


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run the quick benchmark in this process; return figures, text, file.

    What is of the other world, of several workers or of GPy is as it is committed:
    tests/slow runs the program itself, and all of it.
    """
    out, committed = tmp_path_factory.mktemp("bench") / "costs.json", load_benchmark()
    printed = io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCH.parent)
        bench, learners = map(importlib.import_module, ("bench", "learners"))
        patch.setattr(sys, "argv", ["bench.py", "--quick", "--out", f"{out}"])
        patch.setattr(bench, "QUICK", replace(bench.QUICK, rounds=1, points=12))
        for of in ("rollouts", "searches", "skill"):
            kept, measure = committed[of], getattr(bench, f"measure_{of}")
            patch.setattr(
                bench,
                f"measure_{of}",
                lambda world, *how, kept=kept, measure=measure: (
                    measure(world, *how) if world.name == WORLD else kept[world.name]
                ),
            )
        patch.setattr(bench, "measure_circles", lambda *_: committed["growth"])
        patch.setattr(bench, "measure_fits", lambda smce, _: fit_shapes(learners, smce))
        patch.setattr(learners, "GPy", None)
        with redirect_stdout(printed), warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # arms go with the program
            bench.main()
            gc.collect()
    return load_benchmark(out), printed.getvalue(), out


def fit_shapes(learners, smce):
    """Fit SMCE to few points of each shape, as the benchmark does to many."""
    fits = [learners.fit_once(shape, 60) for shape in ("curve", "ring", "sheet")]
    return [*learners.measure_fits(smce, ()), *fits]


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
    figures, *_ = run
    assert figures["quick"] is True
    measured = {k: v for k, v in figures.items() if k not in ("machine", "quick")}
    for name, value in leaves(measured):
        if isinstance(value, int | float):
            assert math.isfinite(value), name
            signed = "growth_mb", "apart_mm.mujoco", "ln p"
            assert value > 0 or name.endswith(signed), name


def test_other_ways_do_the_same_job(run):
    figures, *_ = run
    apart = figures["rollouts"][WORLD]["apart_mm"]
    assert apart["naive"] < 10
    if apart["mujoco"] is not None:
        assert apart["mujoco"] < 1


def test_smce_one_by_one_finds_the_same_optima(run):
    figures, *_ = run
    learners = figures["learners"]
    assert learners["smce"]["objectives_apart"] < 1e-6
    by_cvxpy = learners["fits"][1]
    assert by_cvxpy["seconds"] == learners["smce"]["one_by_one_seconds"]["median"]
    shapes = learners["fits"][2:]
    assert [fit["of"] for fit in shapes] == ["curve", "ring", "sheet"]
    assert all(fit["MB, at most"] >= fit["MB before"] for fit in shapes)


def test_a_search_finds_the_same_in_lock_step_and_alone(run):
    figures, *_ = run
    ways = figures["searches"][WORLD]["ways"]
    for key in ("evaluations", "cost", "first_evaluations", "first_cost"):
        assert ways["lockstep"][key] == ways["alone"][key]
    # Whole generations of nine and the last rollout, not what a surrogate leaves.
    assert {spent % 9 for spent in ways["plain"]["first_evaluations"]} == {0}
    assert ways["plain"]["cost"] != ways["alone"]["cost"]
    for way in ("fmin2", "lq_surr2"):  # which have one start
        assert ways[way]["cost"] == ways[way]["first_cost"]


def test_all_processes_are_fitted_to_the_same_targets(run):
    """A likelihood can be compared only with one of the same data."""
    likely = {
        (fit["learner"], fit["samples"], fit["by"]): fit["ln p"]
        for fit in run[0]["learners"]["skills"]
    }
    jumps = "one regression across jumps", 12
    assert likely[*jumps, "scikit-learn"] == pytest.approx(likely[*jumps, "msc"], abs=1)
    assert ("four charts, known", 361, "msc") in likely
    assert ("four charts, known", 361, "scikit-learn") not in likely


def test_committed_smce_is_fast_enough():
    learners = load_benchmark()["learners"]
    assert learners["smce"]["n_points"] == 360
    assert learners["smce"]["one_by_one_over_fit"]["median"] > 15
    (largest,) = (fit for fit in learners["fits"][-3:] if fit["of"] == "curve")
    assert largest["points"] == 50_000
    assert largest["MB, at most"] < 2048


def test_what_is_printed_is_the_chapters_tables(run):
    figures, printed, _ = run
    for what in ("rollouts", "searches", "tasks", "growth", "SMCE", "skills"):
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
    rollouts, searches = plot_benchmark(figures).axes
    n_ways = 6 if figures["rollouts"]["free"]["milliseconds"]["mujoco"] else 5
    assert len(rollouts.get_yticks()) == n_ways
    assert len(searches.get_yticks()) == 5


def test_fits_are_drawn_beside_what_grows_as_their_number(run):
    regressions, seconds, memory = plot_fits(run[0]).axes
    by = {fit["by"] for fit in run[0]["learners"]["skills"]}
    assert len(regressions.lines) == 3 * len(by)
    assert [line.get_label() for line in seconds.lines][-1] == "as their number"
    assert len(memory.lines) == 3


def test_ratios_are_to_ours_and_data_are_timed_in_lock_step(run):
    figures = json.loads(json.dumps(run[0]))
    for measured in figures["searches"].values():
        way = measured["ways"]["lockstep"]
        way["seconds"] = [2.0] * len(way["cost"])
        way["evaluations"] = [40] * len(way["cost"])
        measured["ways"]["alone"]["seconds"] = [5.0] * len(way["cost"])
    rows = benchmark_table(figures, "searches").loc["free"]
    assert rows.loc["msc, in lock-step", "ms a rollout"] == "50.0"
    assert rows.loc["msc, one by one", "× lock-step"] == "2.50"
    counted = load_dataset("free").table["evaluations"].sum()
    minutes = benchmark_table(figures, "data").loc["minutes of one core", "free"]
    assert float(minutes.replace(",", "")) == pytest.approx(
        counted * 0.05 / 60, rel=0.01
    )
    skills = benchmark_table(figures, "skills")
    assert set(skills.xs("msc", level="by")["fit (s) / msc"]) == {"1.00"}


def test_the_chapter_shows_whatever_the_benchmark_measured(run):
    """All its cells, but for what it asserts of a full run."""
    book = json.loads((ROOT / "book" / "what_it_costs.ipynb").read_text("utf-8"))
    cells = [cell["source"] for cell in book["cells"] if cell["cell_type"] == "code"]
    text = "\n".join("".join(lines) for lines in cells)
    assert text.count("load_benchmark()") == 1
    tree = ast.parse(
        text.replace("load_benchmark()", f"load_benchmark({str(run[2])!r})")
    )
    tree.body = [line for line in tree.body if not isinstance(line, ast.Assert)]
    names = {}
    exec(compile(tree, "what_it_costs", "exec"), names)
    assert names["costs"] == run[0]


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
