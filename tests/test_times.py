"""What methods take: measured as the benchmark says, and shown."""

import json
import sys
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from msc.plots import load_times, plot_times, times_table
from msc.study import METHODS

ROOT = Path(__file__).parents[1]


PROGRAM = ROOT / "benchmarks" / "methods.py"


def measure(folder, *more):
    """Run the program in this process, in a folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.syspath_prepend(PROGRAM.parent)
        patch.setattr(
            sys, "argv", [PROGRAM.name, "--quick", "--out", "times.json", *more]
        )
        run_path(str(PROGRAM), run_name="__main__")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("times")
    measure(found)
    return found


@pytest.fixture(scope="module")
def times(folder):
    return load_times(folder / "times.json")


def test_all_is_measured_beside_the_charts(times):
    assert times["quick"] is True
    for what in ("fit", "predict"):
        charts = times["methods"]["charts"][what]["12"]
        assert charts["over_charts"]["median"] == 1
        for one in times["methods"].values():
            taken, over = one[what]["12"]["seconds"], one[what]["12"]["over_charts"]
            assert 0 < taken["low"] <= taken["median"] <= taken["high"]
            wanted = taken["median"] / charts["seconds"]["median"]
            assert over["median"] == pytest.approx(wanted, rel=1e-3)
    known = times["methods"]["nearest neighbour"]["fit"]["12"]
    assert known["over_charts"]["median"] < 0.1  # it only keeps what it is given


def test_whoever_was_not_timed_is_last_and_says_so(times):
    spent = {"workspace": "free", "rollouts": {"CrKr": 199.6}}
    table = times_table(times, spent, {"workspace": "obstacles"})
    assert list(table.index[:2]) == ["nearest neighbour", "CrKr"]
    assert set(table.index) == {n for n, one in METHODS.items() if one.sets != "sweep"}
    assert table.loc["random forest", ("fit (s)", "n = 12")] == "not timed"
    rollouts = table["rollouts"]
    assert rollouts.loc["CrKr"].tolist() == ["200", "0"]
    assert set(rollouts["with obstacles"]) == {"0"}


def test_the_quickest_is_on_top(times):
    left, right = plot_times(times).axes
    names = [label.get_text() for label in left.get_yticklabels()]
    assert names == ["nearest neighbour", "CrKr", "charts"]
    (line,) = left.lines
    assert list(line.get_xdata()) == sorted(line.get_xdata())
    assert right.get_title(loc="left") == "predict 120 tasks (s)"


def test_who_is_tried_at_one_size_is_timed_there_alone(times):
    one = {"seconds": {"median": 9.0}, "over_charts": {"median": 3.0}}
    more = {name: {"fit": {"12": one, "24": one}, "predict": {"12": one, "24": one}}
            for name in ("charts", "random forest")}  # fmt: skip
    few = {"contextual search": {"fit": {"24": one}, "predict": {"24": one}}}
    found = times | {"methods": more | few}
    table = times_table(found)["fit (s)"]
    assert table.loc["contextual search"].tolist() == ["not timed", "9.00"]
    twelve, twentyfour = (line.get_xdata() for line in plot_times(found).axes[0].lines)
    assert np.isnan(twelve).sum() == 1
    assert not np.isnan(twentyfour).any()


def test_committed_times_are_of_a_full_run():
    committed = load_times()
    assert committed["quick"] is False
    assert committed["rounds"] > 1
    wanted = {name for name, method in METHODS.items() if method.sets != "sweep"}
    assert {*committed["methods"]} == wanted
    for name, one in committed["methods"].items():
        sizes = ["24"] if METHODS[name].sets == "few" else ["12", "24", "50"]
        assert [*one["fit"]] == [*one["predict"]] == sizes


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none\.json is not there; `make bench`"):
        load_times(tmp_path / "none.json")


def test_one_method_is_timed_beside_the_charts_and_the_others_are_kept(
    folder, times, tmp_path, monkeypatch
):
    file = tmp_path / "times.json"
    file.write_bytes((folder / "times.json").read_bytes())
    measure(tmp_path, "--methods", "linear interpolation")
    found = load_times(file)["methods"]
    assert found["CrKr"] == times["methods"]["CrKr"]
    assert found["charts"] != times["methods"]["charts"]
    assert [*found] == [*times["methods"], "linear interpolation"]
    file.write_text(json.dumps(times | {"machine": "another"}), "utf-8")
    monkeypatch.syspath_prepend(PROGRAM.parent)
    with pytest.raises(SystemExit, match="another machine: measure all anew"):
        run_path(str(PROGRAM))["known_before"](file, times)
