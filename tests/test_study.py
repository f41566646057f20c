import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imagined import imagine_study, imagine_table
from joblib.externals.loky import get_reusable_executor
from schema import departures
from sklearn.base import BaseEstimator

import msc.study._study
from msc.cli import main
from msc.data import load_dataset, save_table
from msc.estimates import compare
from msc.robot import Arm, Workspace
from msc.search import cost
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
from msc.study._measure import measure_method
from msc.study._methods import COMMON, METHODS, Method
from msc.study._sampling import DESIGNS
from msc.study._store import Trials, method_path
from msc.study._study import PROFILES, Profile, list_sets, sets_of
from msc.study._summaries import summarise_cell
from msc.study.rivals import StoppedMovement
from press import checksum

ROOT = Path(__file__).parents[1]
GRID, TEST = np.arange(0, 360, 15.0), np.array([5.0, 95.0, 170.0, 200.0, 292.0])
EVEN = ("single, Matérn", "charts, Matérn", "ladder: SMCE, true gate")
SOME = ("mean policy, projected", "change points")
SWEEP = ("1 chart", "2 charts")
TINY = Profile(
    2,
    {"even": (8, 24), "nonuniform": (8,)},
    some_sizes=(8,),
    some_repetitions=1,
    few_sizes=(12,),
    few_repetitions=2,
    sweep_sizes=(8,),
    sweep_repetitions=2,
    n_elbows=3,
    methods=(*COMMON, *EVEN, *SOME, *SWEEP),
)
FEW = ("charts", "single regression", "CrKr")
LEAST = replace(
    TINY, sizes={"even": (8,)}, repetitions=1, sweep_repetitions=1, methods=FEW
)


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
        return run_study("obstacles", folder / "kept", seed=3)


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
                assert 1 <= len(summary["per_repetition"]) <= cell["repetitions"]
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
        ("even", 8, 2), ("even", 24, 1), ("nonuniform", 8, 2),
    ]  # fmt: skip
    for cell in study["cells"]:
        names = COMMON
        if cell["design"] == "even":
            names += EVEN + (SOME if cell["n_samples"] == 8 else ())
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


def test_a_subset_without_tasks_is_left_out(monkeypatch, tmp_path):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    free = run_study("free", tmp_path)
    assert "mse, beside jumps" not in free["cells"][0]["measures"]
    away = free["cells"][0]["measures"]["mse, away from jumps"]
    assert away == free["cells"][0]["measures"]["mse, gate learned"]


def test_a_handful_of_test_tasks_makes_no_ratio(monkeypatch, tmp_path):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    monkeypatch.setattr("msc.study._summaries.FEW", len(TEST) + 1)
    (cell,) = run_study("free", tmp_path)["cells"]
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
        np.testing.assert_allclose(found["per_repetition"], means, rtol=1e-4)
        assert found["mean"] == pytest.approx(means.mean(), rel=1e-4)
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
            assert found[key] == pytest.approx(expected[key], rel=2e-3)


def test_subsets_pick_test_tasks(trials):
    trial, datasets = (
        trials[0],
        [load_dataset(f"obstacles{end}") for end in ("", "_test")],
    )

    def measured(name):
        method = trial.methods[name]
        return measure_method(name, method, trial.workspace, datasets, trial.chosen)

    raw = {key: values[None] for key, values in measured("charts").items()}
    away = trial.away_from_jumps
    assert TEST[away].tolist() == [task for task in TEST if abs(task - 112.5) > 45]
    found = summarise_cell({"charts": raw}, away, np.ones(len(TEST)))["measures"]
    for side, which in (("away from", away), ("beside", ~away)):
        summary = found[f"mse, {side} jumps"]["charts"]
        assert summary["mean"] == pytest.approx(raw["mse"][0, which].mean(), rel=1e-4)
        assert summary["n_tasks"] == which.sum()
    near = found["under_1_cm"]["charts"]["mean"]
    assert near == pytest.approx((raw["error_cm"] < 1).mean())
    by_dimension = trial.test_policies**2 / trial.policies.var(axis=0)
    standardised = measured("zero policy")["standardised mse"]
    np.testing.assert_allclose(standardised, by_dimension.mean(axis=1))


def test_scatter_is_that_of_all_errors():
    rng = np.random.default_rng(0)
    values, weights = rng.exponential(size=(3, 40)), np.repeat([1.0, 2.0], 20)
    raw = {"charts": dict.fromkeys(("mse", "error_cm", "excess_cost"), values)}
    raw["charts"] |= {"standardised mse": values, "touched": values > 1}
    away = np.ones(40, dtype=bool)
    plain, weighted = (
        summarise_cell(raw, away, w)["measures"]["error_cm"]["charts"]
        for w in (np.ones(40), weights)
    )
    for found, expected in (
        (plain, values),
        (weighted, np.repeat(values, weights.astype(int), axis=1)),
    ):
        assert found["mean"] == pytest.approx(expected.mean(), rel=1e-4)
        assert found["std"] == pytest.approx(expected.std(), rel=0.01)
        quantiles = np.quantile(expected, [0.5, 0.95], method="inverted_cdf")
        np.testing.assert_allclose(
            [found["median"], found["p95"]], quantiles, rtol=0.05
        )


# What is kept


class Refusing(BaseEstimator):
    """A method that cannot be fitted to some training sets."""

    def fit(self, X, y):
        if X[0, 0] == 0:
            raise ValueError("no")
        self.shape = y.shape[1:]
        return self

    def predict(self, X):
        return np.zeros((len(X), *self.shape))


def drawn(effort):
    return list_sets(effort, load_dataset("free").tasks, 3)


def keep(tmp_path, **options):
    return run_study("free", tmp_path, seed=3, **options)


def test_what_still_holds_is_not_done_again(tmp_path, monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    first = keep(tmp_path)
    kept = {path: path.read_bytes() for path in tmp_path.rglob("*.npz")}
    assert len(kept) == len(FEW)
    monkeypatch.setattr("msc.study._study.call_in_order", None)  # not needed
    assert keep(tmp_path) == first
    monkeypatch.undo()


def test_exactly_what_is_stale_is_done_again(tmp_path, monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    first, done = keep(tmp_path), []
    really = msc.study._study.call_in_order

    def call(work, calls, **options):
        done.append(calls[0][0])
        return really(work, calls, **options)

    monkeypatch.setattr("msc.study._study.call_in_order", call)
    path = method_path(tmp_path, "free", "CrKr")
    old = Trials.read(path)
    for change in ({"code": "other"}, {"protocol": "other"}, {"tables": {}}):
        Trials({**old.about, **change}, old.errors).write(path)
        with pytest.raises(ValueError, match="'CrKr': what is kept of it in 'free'"):
            keep(tmp_path, names=["charts"])
        assert done == []
        assert keep(tmp_path) == first
        assert done == ["CrKr"]
        done.clear()
    path.write_bytes(path.read_bytes()[:100])  # torn
    with pytest.raises(
        ValueError, match=r"'CrKr': what .* 'free' cannot be read; make"
    ):
        keep(tmp_path, names=["charts"])
    assert done == []
    assert keep(tmp_path) == first
    assert done == ["CrKr"]


def test_what_only_other_code_has_made_stale_may_be_rechecked(tmp_path, monkeypatch):
    effort = replace(LEAST, repetitions=3)
    monkeypatch.setitem(PROFILES, "quick", effort)
    first, path = keep(tmp_path), method_path(tmp_path, "free", "CrKr")
    old, really, done = Trials.read(path), msc.study._study.call_in_order, []

    def call(work, calls, **options):
        done.append(len(calls))
        return really(work, calls, **options)

    monkeypatch.setattr("msc.study._study.call_in_order", call)
    n_all = len(
        [s for some in sets_of("CrKr", effort, drawn(effort)).values() for s in some]
    )
    n_first = len(sets_of("CrKr", effort, drawn(effort)))
    assert n_first < n_all
    Trials({**old.about, "code": "other"}, old.errors).write(path)
    assert keep(tmp_path, recheck=True) == first
    assert Trials.read(path).about == {**old.about, "rechecked": n_first}
    other = {key: errors * 1.01 for key, errors in old.errors.items()}
    for about, errors in [
        ({"code": "other"}, other),  # something else comes out
        ({"tables": {}}, old.errors),  # not only code
        ({"versions": {}}, old.errors),
    ]:
        Trials({**old.about, **about}, errors).write(path)
        assert keep(tmp_path, recheck=True) == first
        assert Trials.read(path).about == old.about
    assert done == [n_first, n_first, n_all, n_all, n_all]


def test_what_was_not_tried_is_not_there_and_what_is_unknown_is_named(
    tmp_path, monkeypatch
):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    found = keep(tmp_path, names=["CrKr"])
    assert list(find_cell(found, "even", 8)["measures"]["error_cm"]) == ["CrKr"]
    with pytest.raises(
        ValueError, match=r"methods=\['CrKR'\] are unknown; wanted some"
    ):
        keep(tmp_path, names=["CrKR"])


@pytest.mark.parametrize(
    "other", [{"profile": "full"}, {"seed": 8}, {"engine": "mujoco"}]
)
def test_results_of_another_profile_seed_or_engine_are_not_overwritten(
    other, tmp_path, monkeypatch
):
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    keep(tmp_path)
    path = method_path(tmp_path, "free", "CrKr")
    old = Trials.read(path)
    Trials({**old.about, **other}, old.errors).write(path)
    before = path.read_bytes()
    monkeypatch.setattr("msc.study._study.call_in_order", None)  # not come to that
    for names in (None, ["CrKr"], ["charts"]):
        with pytest.raises(
            ValueError, match=r"cr?kr\.npz was made with --profile .*dir"
        ):
            keep(tmp_path, names=names)
    assert path.read_bytes() == before


def test_policies_may_be_executed_in_the_other_engine(tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.setitem(PROFILES, "quick", replace(LEAST, methods=("mean policy",)))
    found = [
        keep(tmp_path / engine, engine=engine) for engine in ("pybullet", "mujoco")
    ]
    here, there = (one["cells"][0]["measures"] for one in found)
    assert there["mse, gate learned"] == here["mse, gate learned"]
    error = here["error_cm"]["mean policy"]["mean"]  # nothing is touched
    assert there["error_cm"]["mean policy"]["mean"] == pytest.approx(error, rel=1e-9)
    assert "mujoco-core" in found[1]["provenance"]["versions"]
    assert found[1]["provenance"]["command"].endswith("--engine mujoco")


def test_a_name_that_is_nearly_one_is_answered_with_it():
    with pytest.raises(ValueError, match=r"wanted some of \['charts', "):
        run_study("free", Path(), names=["Chart"])


def test_a_fit_that_fails_is_told_and_not_averaged(tmp_path, monkeypatch):
    least = replace(LEAST, repetitions=2, methods=("charts", "CrKr"))
    monkeypatch.setitem(PROFILES, "quick", least)
    refusing = Method(lambda _: Refusing(), "paper", "all")
    monkeypatch.setitem(METHODS, "CrKr", refusing)
    found = keep(tmp_path)
    (reasons,) = found["failed"].values()
    assert list(found["failed"]) == ["CrKr"]
    assert set(reasons.values()) == {"ValueError: no"}
    cell = find_cell(found, "even", 8)
    for by_method in cell["measures"].values():  # shares too: it is not "never near"
        assert by_method["CrKr"]["mean"] is None
    assert cell["measures"]["error_cm"]["charts"]["mean"] > 0
    assert not cell["ratios"]
    json.loads(format_study(found))


# Methods with rollouts of their own, and one that plans movements


class Spending(Refusing):
    """A method that spends as many rollouts as its first task says."""

    def fit(self, X, y):
        self.n_rollouts_ = 70_001 + round(np.rad2deg(X[0, 0]))
        return super().fit(X + 1, y)


def test_few_sets_of_one_size_for_those_with_rollouts(tmp_path, monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", replace(TINY, methods=("CrKr",)))
    monkeypatch.setitem(METHODS, "CrKr", Method(lambda _: Spending(), "paper", "few"))
    found = keep(tmp_path)
    (cell,) = found["cells"]
    assert (cell["design"], cell["n_samples"]) == ("even", 12)
    kept = Trials.read(method_path(tmp_path, "free", "CrKr"))
    sets = draw_samples("even", np.deg2rad(GRID)[:, None], 12, n_draws=2, seed=3)
    spent = kept.errors["even/12/n_rollouts"]  # whole, where errors are shortened
    assert spent.tolist() == [70_001 + GRID[chosen[0]] for chosen in sets]
    assert found["rollouts"] == {"CrKr": 70_008.5}
    again = Trials.read(method_path(tmp_path, "free", "CrKr"))
    again.write(tmp_path / "again.npz")
    path = method_path(tmp_path, "free", "CrKr")
    assert (tmp_path / "again.npz").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("profile", ORIGINAL)
def test_the_first_sets_of_24_are_those_of_other_methods_too(profile):
    effort = ORIGINAL[profile]
    sets = list_sets(effort, np.deg2rad(np.arange(360.0))[:, None], seed=0)
    own, others = (sets_of(name, effort, sets) for name in ("Kober's practice", "CrKr"))
    assert list(own) == [("even", 24)]
    n_sets = {"quick": 1, "full": 3}[profile]
    np.testing.assert_array_equal(own["even", 24], others["even", 24][:n_sets])


def test_a_study_without_rollouts_says_so(study):
    assert study["rollouts"] == {}


def test_a_planner_s_movements_are_followed_and_have_no_errors_of_policies(
    tmp_path, monkeypatch
):
    name = "after Soni: stopped"
    least = replace(TINY, some_sizes=(12,), methods=("mean policy", name))
    monkeypatch.setitem(PROFILES, "quick", least)
    found = keep(tmp_path)
    measures = find_cell(found, "even", 12)["measures"]
    assert set(measures["mse, gate learned"]) == set()
    assert found["failed"] == {}
    kept = Trials.read(method_path(tmp_path, "free", name))
    wanted = {"error_cm", "excess_cost", "touched"}
    assert {key.rpartition("/")[2] for key in kept.errors} == wanted
    grid, test = load_dataset("free"), load_dataset("free_test")
    chosen = draw_samples("even", grid.tasks, 12, n_draws=1, seed=3)[0]
    option = StoppedMovement().fit(grid.tasks[chosen], grid.policies[chosen])
    with Arm(Workspace.free()) as arm:
        rollouts = arm.follow(option.plan(test.tasks), TEST)
    missed = [100 * one.error for one in rollouts]
    away = np.abs(TEST[:, None] - GRID).min(axis=1) != 7.5  # of ties the mean counts
    np.testing.assert_allclose(
        kept.errors["even/12/error_cm"][0][away], np.array(missed)[away], rtol=1e-4
    )
    extra = [cost(one) for one in rollouts] - test.table["cost"]
    np.testing.assert_allclose(
        kept.errors["even/12/excess_cost"][0], extra, rtol=1e-3, atol=1e-4
    )
    assert "even/12/mse" not in kept.errors


def test_the_same_trials_are_the_same_bytes(tmp_path):
    errors = {"even/8/mse": np.random.default_rng(0).exponential(size=(2, 5))}
    errors["even/8/touched"] = errors["even/8/mse"] > 1
    paths = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for path in paths:
        Trials({"method": "x"}, errors).write(path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    again = Trials.read(paths[0])
    assert again.about == {"method": "x"}
    mse = "even/8/mse"
    np.testing.assert_allclose(again.errors[mse], errors[mse], rtol=2**-16)
    assert again.errors["even/8/touched"].dtype == bool
    assert Trials.read(tmp_path / "none.npz") is None


def test_no_two_methods_share_a_file():
    paths = {method_path(Path(), "free", name) for name in METHODS}
    assert len(paths) == len(METHODS)


# How it is made


def test_the_result_does_not_depend_on_the_workers(tmp_path, monkeypatch):
    monkeypatch.setitem(PROFILES, "quick", replace(LEAST, repetitions=2))
    get_reusable_executor().shutdown()  # workers of other tests stand in other folders
    one, two = (
        run_study("obstacles", tmp_path / f"{jobs}", seed=3, jobs=jobs)
        for jobs in (1, 2)
    )
    assert format_study(one) == format_study(two)
    kept = [*(tmp_path / "2").rglob("*.npz")]
    assert len(kept) == len(FEW)
    for path in kept:
        other = tmp_path / "1" / path.relative_to(tmp_path / "2")
        assert path.read_bytes() == other.read_bytes()


def test_another_seed_draws_other_training_sets(study, monkeypatch, tmp_path):
    drawn_at_random = replace(LEAST, sizes={"nonuniform": (8,)}, repetitions=2)
    monkeypatch.setitem(PROFILES, "quick", drawn_at_random)
    other = run_study("obstacles", tmp_path, seed=4)
    same, again = (find_cell(one, "nonuniform", 8) for one in (study, other))
    mse = "mse, gate learned"
    assert same["measures"][mse]["CrKr"] != again["measures"][mse]["CrKr"]


def test_the_profiles_are_as_the_protocol_says():
    grid = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    quick, full = (list_sets(ORIGINAL[name], grid, seed=0) for name in ORIGINAL)
    assert {len(some) for some in quick.values()} == {3}

    def of(name):
        return sets_of(name, ORIGINAL["full"], full)

    counts = {
        name: {key: len(some) for key, some in of(name).items()}
        for name in ("charts", "single, Matérn", "random forest", "3 charts")
    }
    everywhere = counts["charts"]
    assert everywhere["even", 24] == everywhere["uniform", 24] == 15
    assert everywhere["even", 360] == 1
    assert everywhere["uniform", 8] == everywhere["nonuniform", 100] == 15
    even = {key: n for key, n in everywhere.items() if key[0] == "even"}
    assert counts["single, Matérn"] == even
    assert counts["random forest"] == {
        ("even", 12): 10,
        ("even", 24): 10,
        ("even", 50): 8,
    }
    assert counts["3 charts"] == {("even", 24): 10, ("even", 100): 4, ("even", 360): 1}
    assert {design for design, _ in everywhere} == set(DESIGNS)
    first = full["even", 24][:10]  # of a method that is tried on some sets
    np.testing.assert_array_equal(of("random forest")["even", 24], first)


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
        run_study("free", Path(), profile="quik")


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
    monkeypatch.setitem(PROFILES, "quick", LEAST)
    arguments = ["--seed", "3", "--jobs", "1", "--out-dir", str(tmp_path / "new")]
    assert main(["evaluate", *arguments]) == 0
    files = [f"{kind}_{world}.json" for world in ("free", "obstacles")
             for kind in ("study", "elbow")]  # fmt: skip
    assert sorted(path.name for path in (tmp_path / "new").glob("*.*")) == sorted(files)
    found = json.loads((tmp_path / "new" / "study_obstacles.json").read_text("utf-8"))
    assert found == run_study("obstacles", tmp_path / "new", seed=3)
    options = {"n_resamples": 3, "seed": 3, "jobs": 1, "progress": True}
    assert asked == [(24, 24, options)] * 2
    found = json.loads((tmp_path / "new" / "elbow_free.json").read_text("utf-8"))
    assert found["readings"]["eigengap"]["picked"] == 4
    assert found["provenance"]["command"] == "msc evaluate --profile quick --seed 3"
    out, err = capsys.readouterr()
    assert out.split() == [str(tmp_path / "new" / name) for name in files]
    assert "charts, obstacles: 100%" in err


def test_what_is_done_is_kept_when_interrupted(monkeypatch, tmp_path, capsys):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    elbows(monkeypatch, interrupt)
    arguments = ["evaluate", "--jobs", "1", "--out-dir", str(tmp_path)]
    assert main(arguments) == 130
    assert capsys.readouterr().err.endswith("msc: interrupted\n")
    assert [path.name for path in tmp_path.glob("*.*")] == ["study_free.json"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ("--profile quik", "profile='quik'; wanted one of ('quick', 'full')"),
        ("--jobs 0", "jobs=0; wanted at least 1"),
        ("--seed -1", "seed=-1; wanted 0 or more"),
        ("--out-dir file", "out-dir=file is a file; wanted the name of a folder"),
        ("--methods=", "methods='' has an empty name; wanted NAME,…"),
        ("--methods charts,", "methods='charts,' has an empty name"),
        ("--methods CrKR", "methods=['CrKR'] are unknown; wanted some of ['CrKr'"),
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


def test_commas_part_methods_and_may_be_in_their_names(monkeypatch, tmp_path, capsys):
    asked = []

    def study(world, folder, names, **_):
        asked.append(names)
        return {"workspace": world, "failed": {"CrKr": {"even/8/0": "E: no,\nnever"}}}

    monkeypatch.setattr("msc.study.run_study", study)
    for text in ("CrKr, charts,Matérn,charts, nearest neighbour", "charts, nope"):
        assert main(["evaluate", "--out-dir", str(tmp_path), "--methods", text]) == 0
    first = ["CrKr", "charts, Matérn", "charts", "nearest neighbour"]
    assert asked == [first, first, ["charts", "nope"], ["charts", "nope"]]
    told = "msc: 'CrKr' failed on 1 of its training sets in"
    why = "first on even/8/0: E: no, never"
    told = [f"{told} '{world}', {why}" for world in ("free", "obstacles")]
    assert capsys.readouterr().err.splitlines() == told


def test_savings_refuse_what_is_no_folder_before_the_work(monkeypatch, capsys):
    monkeypatch.setattr("msc.study.run_savings", None)
    Path("file").touch()
    assert main(["savings", "--out-dir", "file"]) == 2
    assert "out-dir=file is a file; wanted the name of a folder" in (
        capsys.readouterr().err
    )


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
