"""The quick benchmark as it is run: a program, both worlds, all of its processes."""

import subprocess
import sys

from test_bench import BENCH, leaves, shape

from msc.plots import benchmark_table, load_benchmark


def test_the_program_measures_and_prints_all(tmp_path):
    arguments = [sys.executable, BENCH, "--quick", "--out", tmp_path / "costs.json"]
    result = subprocess.run(
        arguments, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    figures, committed = load_benchmark(tmp_path / "costs.json"), load_benchmark()
    assert shape(figures) <= shape(committed)
    assert [*figures["rollouts"]] == [*figures["searches"]] == ["free", "obstacles"]
    assert {row["workers"] for row in figures["growth"]} == {1, 2}
    assert all(value > 0 for name, value in leaves(figures["growth"]))
    fits = figures["learners"]["fits"]
    assert [fit["of"] for fit in fits[2:]] == ["curve", "ring", "sheet"]
    for what in ("rollouts", "searches", "tasks", "growth", "SMCE", "skills"):
        assert benchmark_table(figures, what).to_string() in result.stdout
