import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from imagined import imagine_study, imagine_table
from joblib.externals.loky import get_reusable_executor
from schema import departures

from msc.cli import main
from msc.data import save_table
from msc.estimates import compare
from msc.study import (
    MEASURES,
    Experiment,
    Study,
    draw_samples,
    find_cell,
    format_study,
    run_study,
    task_density,
)
from msc.study._methods import COMMON, METHODS
from msc.study._sampling import DESIGNS
from msc.study._study import PROFILES, Profile, list_groups
from msc.study._summaries import measure_errors, summarise_trials
from press import checksum

ROOT = Path(__file__).parents[1]
GRID, TEST = np.arange(0, 360, 15.0), np.array([5.0, 95.0, 170.0, 200.0, 292.0])
TINY = Profile(
    2,
    {"even": (8, 24), "uniform": (8,), "nonuniform": (8,)},
    sweep_charts=(1, 2),
    sweep_sizes=(8,),
    sweep_repetitions=2,
    n_elbows=3,
)
LEAST = replace(TINY, sizes={"even": (8,)}, repetitions=1, sweep_charts=())


ORIGINAL = dict(PROFILES)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("repository")
    for name, jumps in (("free", []), ("obstacles", [112.5])):
        for suffix, tasks in (("", GRID), ("_test", TEST)):
            path = folder / "data" / f"{name}{suffix}.csv"
            save_table(imagine_table(tasks, jumps), path, command="", seed=0)
    return folder


@pytest.fixture(autouse=True)
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setitem(PROFILES, "quick", TINY)
    monkeypatch.setattr("msc.study._summaries.FEW", 1)


@pytest.fixture(scope="module")
def study(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setitem(PROFILES, "quick", TINY)
        patch.setattr("msc.study._summaries.FEW", 1)
        return run_study("obstacles", seed=3)


# The layout: of what is computed, of what is stored, and of what tests imagine


def stored(name):
    return json.loads((ROOT / "data" / "results" / name).read_text("utf-8"))


@pytest.mark.parametrize(
    "made",
    [
        "computed",
        *(stored(f"study_{world}.json") for world in ("free", "obstacles")),
        *(imagine_study(right, "free") for right in (True, False)),
    ],
    ids=["computed", "free", "obstacles", "right", "wrong"],
)
def test_every_study_is_laid_out_as_the_type_says(made, study):
    found = study if made == "computed" else made
    assert not departures(found, Study)
    assert found["workspace"] in {"free", "obstacles"}
    assert found["profile"] in ORIGINAL
    assert {cell["design"] for cell in found["cells"]} <= set(DESIGNS)
    for cell in found["cells"] + found["sweep"]:
        assert set(cell["measures"]) <= set(MEASURES)
        for by_method in cell["measures"].values():
            assert set(by_method) <= set(METHODS)
            for summary in by_method.values():
                assert summary["low"] <= summary["mean"] <= summary["high"]
                assert len(summary["per_repetition"]) == cell["repetitions"]
        for ratio in cell.get("ratios", []):
            assert MEASURES[ratio["measure"]].has_ratio
            assert {ratio["method"], ratio["baseline"]} <= set(METHODS)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda one: one.pop("seed"), "it lacks 'seed'"),
        (lambda one: one.update(sead=0), "it has 'sead'"),
        (lambda one: one.update(seed="0"), "it['seed'] is '0'; wanted <class 'int'>"),
        (
            lambda one: one["sweep"][2].update(n_charts=True),
            "it['sweep'][2]['n_charts'] is True; wanted <class 'int'>",
        ),
        (lambda one: one["cells"].append([]), "it['cells'][20] is []; wanted fields"),
    ],
)
def test_a_departure_from_the_layout_is_told(change, said):
    found = imagine_study(right=True, world="free")
    change(found)
    assert departures(found, Study) == [said]


def test_a_study_has_the_cells_that_its_profile_asks_for(study):
    assert (study["workspace"], study["profile"]) == ("obstacles", "quick")
    assert (study["seed"], study["n_charts"]) == (3, 4)
    shapes = [
        (cell["design"], cell["n_samples"], cell["repetitions"])
        for cell in study["cells"]
    ]
    assert shapes == [
        ("even", 8, 2), ("even", 24, 1), ("uniform", 8, 2), ("nonuniform", 8, 2),
    ]  # fmt: skip
    for cell in study["cells"]:
        names = METHODS if cell["design"] == "even" else COMMON
        nearest = 17.5  # degrees, of the test tasks to the jump
        is_far = 360 / cell["n_samples"] < nearest
        expected = set(MEASURES) - ({"mse, beside jumps"} if is_far else set())
        assert set(cell["measures"]) == expected
        for by_method in cell["measures"].values():
            assert tuple(by_method) == names
        pairs = [
            (ratio["measure"], ratio["baseline"])
            for ratio in cell["ratios"]
            if ratio["method"] == "charts"
        ]
        missing = {
            (label, name)
            for label in expected - {"under_1_cm", "touched"}
            for name in names[1:]
        } - set(pairs)
        assert {label for label, _ in missing} <= {"excess_cost"}  # may be negative
        assert len(pairs) == len(set(pairs))
        others = {
            (ratio["method"], ratio["baseline"])
            for ratio in cell["ratios"]
            if ratio["method"] != "charts"
        }
        same_kernel = {("charts, Matérn", "single, Matérn")}
        assert others == (same_kernel if cell["design"] == "even" else set())


def test_the_sweep_tries_numbers_of_charts(study):
    tried = [(one["n_charts"], one["n_samples"]) for one in study["sweep"]]
    assert tried == [(1, 8), (2, 8)]
    for one in study["sweep"]:
        assert all(tuple(found) == ("charts",) for found in one["measures"].values())
    one_chart = study["sweep"][0]["measures"]["mse, gate learned"]["charts"]
    single = find_cell(study, "even", 8)["measures"]["mse, gate learned"]
    assert one_chart == single["single regression"]


def test_its_origin_is_told(study, folder):
    origin = study["provenance"]
    assert origin["command"] == "msc evaluate --profile quick --seed 3"
    tables = ("obstacles.csv", "obstacles_test.csv")
    assert origin["data"] == {one: checksum(folder / "data" / one) for one in tables}
    assert set(origin["versions"]) == {"numpy", "scikit-learn", "cvxpy", "pybullet"}


def test_a_subset_without_tasks_is_left_out(monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    free = run_study("free")
    assert "mse, beside jumps" not in free["cells"][0]["measures"]
    away = free["cells"][0]["measures"]["mse, away from jumps"]
    assert away == free["cells"][0]["measures"]["mse, gate learned"]


def test_a_handful_of_test_tasks_makes_no_ratio(monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    monkeypatch.setattr("msc.study._summaries.FEW", len(TEST) + 1)
    (cell,) = run_study("free")["cells"]
    assert cell["ratios"] == []
    assert cell["measures"]["error_cm"]["charts"]["n_tasks"] == len(TEST)


# What it says


@pytest.fixture(scope="module")
def trials(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        tasks = np.deg2rad(GRID)
        return [
            Experiment("obstacles", chosen=chosen, seed=3, names=COMMON)
            for chosen in draw_samples("nonuniform", tasks, 8, n_draws=2, seed=3)
        ]


def test_a_cell_says_what_its_trials_say(study, trials):
    cell, weights = find_cell(study, "nonuniform", 8), task_density(np.deg2rad(TEST))
    for name, subset in (
        ("mse, gate learned", "gate learned"),
        ("mse, chart known", "chart known"),
    ):
        errors = np.array([trial.squared_errors(subset)["charts"] for trial in trials])
        means = np.average(errors, axis=1, weights=weights)
        found = cell["measures"][name]["charts"]
        np.testing.assert_allclose(found["per_repetition"], means, rtol=1e-5)
        assert found["mean"] == pytest.approx(means.mean(), rel=1e-5)
        assert found["low"] <= found["mean"] <= found["high"]


def test_its_ratios_are_those_of_compare(study, trials):
    cell, weights = find_cell(study, "nonuniform", 8), task_density(np.deg2rad(TEST))
    tables = [trial.executed_by_method("error_cm") for trial in trials]
    errors = {name: np.array([table[name] for table in tables]) for name in COMMON}
    for label, spread in (("error_cm", False), ("error_cm spread", True)):
        expected = compare(
            label,
            errors,
            "charts",
            "CrKr",
            weights=weights,
            spread=spread,
        ).stored("ratio")
        (found,) = (
            ratio
            for ratio in cell["ratios"]
            if (ratio["measure"], ratio["baseline"]) == (label, "CrKr")
        )
        for key in ("ratio", "low", "high"):
            assert found[key] == pytest.approx(expected[key], rel=1e-5)


def test_subsets_pick_test_tasks(trials):
    trial = trials[0]
    found = measure_errors(trial)
    away = found["mse, away from jumps"].index
    assert away.tolist() == [task for task in TEST if abs(task - 112.5) > 45]
    beside = found["mse, beside jumps"].index
    assert sorted([*away, *beside]) == TEST.tolist()
    standardised = found["standardised mse, gate learned"]["zero policy"]
    by_dimension = trial.test_policies**2 / trial.policies.var(axis=0)
    np.testing.assert_allclose(standardised, by_dimension.mean(axis=1))
    assert (found["under_1_cm"] == (found["error_cm"] < 1)).all(axis=None)


def test_scatter_is_that_of_all_errors():
    rng = np.random.default_rng(0)
    values, weights = rng.exponential(size=(3, 40)), np.repeat([1.0, 2.0], 20)
    tasks = pd.Index(range(40))
    trials = [
        {"error_cm": pd.DataFrame({"charts": row}, index=tasks)} for row in values
    ]
    plain, weighted = (
        summarise_trials(trials, w)["measures"]["error_cm"]["charts"]
        for w in (None, pd.Series(weights, index=tasks))
    )
    for found, expected in (
        (plain, values),
        (weighted, np.repeat(values, weights.astype(int), axis=1)),
    ):
        assert found["mean"] == pytest.approx(expected.mean(), rel=1e-5)
        assert found["std"] == pytest.approx(expected.std(), rel=0.01)
        quantiles = np.quantile(expected, [0.5, 0.95], method="inverted_cdf")
        np.testing.assert_allclose(
            [found["median"], found["p95"]], quantiles, rtol=0.05
        )


# How it is made


def test_the_result_does_not_depend_on_the_workers(study):
    get_reusable_executor().shutdown()  # workers of other tests stand in other folders
    assert format_study(run_study("obstacles", seed=3, jobs=2)) == format_study(study)


def test_another_seed_draws_other_training_sets(study, monkeypatch):
    uniform = replace(LEAST, sizes={"uniform": (8,)}, repetitions=2)
    monkeypatch.setitem(PROFILES, "quick", uniform)
    other = run_study("obstacles", seed=4)
    assert find_cell(other, "uniform", 8) != find_cell(study, "uniform", 8)


def test_the_profiles_are_as_the_protocol_says():
    quick, full = (
        list_groups(profile, np.linspace(0, 2 * np.pi, 360, endpoint=False), seed=0)
        for profile in (ORIGINAL["quick"], ORIGINAL["full"])
    )
    assert {len(group.sets) for group in quick} == {3}
    sizes = {
        design: [
            (len(group.sets[0]), len(group.sets))
            for group in full
            if group.design == design and not group.is_sweep
        ]
        for design in DESIGNS
    }
    assert dict(sizes["even"])[24] == 15
    assert dict(sizes["even"])[360] == 1
    assert dict(sizes["uniform"])[8] == dict(sizes["nonuniform"])[100] == 15
    assert {group.n_charts for group in full if group.is_sweep} == set(range(1, 9))


def test_it_is_written_a_summary_a_line(study):
    text = format_study(study)
    assert json.loads(text) == study
    assert max(map(len, text.splitlines())) < 300
    assert len(re.findall(r"^ +\"charts\": {\"mean\".*}", text, re.MULTILINE)) == sum(
        len(one["measures"]) for one in study["cells"] + study["sweep"]
    )
    with pytest.raises(ValueError, match="JSON"):
        format_study({"mean": np.nan})


def test_an_unknown_profile_is_named():
    with pytest.raises(ValueError, match="profile='quik'; wanted one of"):
        run_study("free", profile="quik")


# msc evaluate


def elbows(monkeypatch, measure_elbows):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    monkeypatch.setattr("msc.study._study.measure_elbows", measure_elbows)


def test_evaluate_writes_what_it_found(monkeypatch, tmp_path, capsys):
    asked = []

    def measure_elbows(tasks, policies, **options):
        asked.append((len(tasks), len(policies), options))
        return {"readings": {"eigengap": {"picked": 4}}}

    elbows(monkeypatch, measure_elbows)
    arguments = ["--seed", "3", "--jobs", "1", "--out-dir", str(tmp_path / "new")]
    assert main(["evaluate", *arguments]) == 0
    files = [f"{kind}_{world}.json" for world in ("free", "obstacles")
             for kind in ("study", "elbow")]  # fmt: skip
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == sorted(files)
    found = json.loads((tmp_path / "new" / "study_obstacles.json").read_text("utf-8"))
    assert found == run_study("obstacles", seed=3)
    options = {"n_resamples": 3, "seed": 3, "jobs": 1, "progress": True}
    assert asked == [(24, 24, options)] * 2
    found = json.loads((tmp_path / "new" / "elbow_free.json").read_text("utf-8"))
    assert found["readings"]["eigengap"]["picked"] == 4
    assert found["provenance"]["command"] == "msc evaluate --profile quick --seed 3"
    out, err = capsys.readouterr()
    assert out.split() == [str(tmp_path / "new" / name) for name in files]
    assert "study, obstacles: 100%" in err


def test_what_is_done_is_kept_when_interrupted(monkeypatch, tmp_path, capsys):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    elbows(monkeypatch, interrupt)
    arguments = ["evaluate", "--jobs", "1", "--out-dir", str(tmp_path)]
    assert main(arguments) == 130
    assert capsys.readouterr().err.endswith("msc: interrupted\n")
    assert [path.name for path in tmp_path.iterdir()] == ["study_free.json"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ("--profile quik", "profile='quik'; wanted one of ('quick', 'full')"),
        ("--jobs 0", "jobs=0; wanted at least 1"),
        ("--seed -1", "seed=-1; wanted 0 or more"),
        ("--out-dir file", "out-dir=file is a file; wanted the name of a folder"),
    ],
)
def test_bad_input_is_named_in_a_sentence(
    arguments, complaint, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(
        "msc.study._study.call_in_order", None
    )  # it must not come to that
    Path("file").touch()
    assert main(["evaluate", "--out-dir", str(tmp_path), *arguments.split()]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.startswith("msc: error: ")
    assert err.count("\n") == 1
    assert complaint in err
    assert not list(tmp_path.iterdir())


def test_a_missing_table_is_named_before_the_work(folder, monkeypatch, capsys):
    monkeypatch.setattr("msc.study._study.call_in_order", None)
    table = folder / "data" / "obstacles_test.csv"
    content = table.read_bytes()
    table.unlink()
    try:
        assert main(["evaluate"]) == 2
    finally:
        table.write_bytes(content)
    assert "dataset 'obstacles_test' is not there" in capsys.readouterr().err
