import numpy as np
import pandas as pd
import pytest
from imagined import imagine_table

import msc.study._measure
from msc import Arm, Workspace
from msc.data import WEIGHTS, save_table
from msc.robot import cached_arm
from msc.search import cost
from msc.study import TEST_SUBSETS, Experiment, execute_policies

GRID, TEST = np.arange(0, 360, 15.0), np.array([5.0, 95.0, 170.0, 200.0, 292.0])
METHODS = ["charts", "single regression", "CrKr", "nearest neighbour"]
METHODS += ["linear interpolation", "mean policy", "zero policy"]


def made_up(tasks_deg):
    """Make a table of policies that jump twice, between grid tasks 7, 8 and 15, 16."""
    return imagine_table(tasks_deg, [112.5, 232.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("repository")
    for name, tasks in (("free", GRID), ("free_test", TEST)):
        table = made_up(tasks)
        save_table(table, folder / "data" / f"{name}.csv", command="", seed=0)
    return folder


@pytest.fixture(scope="module")
def experiment(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return Experiment("free", n_samples=12, n_charts=3)


@pytest.fixture(autouse=True)
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)


policies, searched = (
    made_up(tasks)[list(WEIGHTS)].to_numpy() for tasks in (GRID, TEST)
)


# The experiment


def test_training_tasks_are_spread_over_the_grid(experiment):
    assert experiment.chosen.tolist() == list(range(0, 24, 2))
    assert experiment.n_samples == 12
    np.testing.assert_array_equal(experiment.policies, policies)
    np.testing.assert_array_equal(experiment.test_policies, searched)
    np.testing.assert_allclose(np.rad2deg(experiment.test_tasks[:, 0]), TEST)


def test_jumps_are_found_on_the_whole_grid(experiment):
    assert experiment.jumps.tolist() == [7, 15]


def test_all_methods_are_fitted_on_the_training_tasks_alone(experiment):
    assert list(experiment.methods) == METHODS
    nearest = experiment.predict("nearest neighbour", experiment.tasks[::2])
    np.testing.assert_array_equal(nearest, policies[::2])
    mean = experiment.predict("mean policy", experiment.test_tasks)
    np.testing.assert_allclose(mean, np.tile(policies[::2].mean(axis=0), (5, 1)))
    assert not experiment.predict("zero policy", experiment.test_tasks).any()
    assert experiment.methods["charts"].n_charts_ == 3
    assert experiment.methods["single regression"].n_charts_ == 1


def test_the_elbow_counts_charts_of_the_training_policies(experiment):
    assert 1 <= experiment.elbow <= 10


def test_any_training_tasks_may_be_chosen(experiment):
    few = {"n_charts": 3, "names": ["linear interpolation"]}
    chosen = Experiment("free", chosen=[20, 0, 9], **few)
    assert chosen.chosen.tolist() == [0, 9, 20]
    predicted = chosen.predict("linear interpolation", experiment.tasks[[0, 9, 23]])
    np.testing.assert_array_equal(predicted, policies[[0, 9, 20]])
    even = Experiment("free", chosen=range(0, 24, 2), **few)
    assert even.chosen.tolist() == experiment.chosen.tolist()


def test_the_same_seed_gives_the_same_numbers(experiment):
    again = Experiment("free", n_samples=12, n_charts=3)
    for subset in TEST_SUBSETS:
        pd.testing.assert_frame_equal(
            again.squared_errors(subset),
            experiment.squared_errors(subset),
            check_exact=True,
        )


# Mean squared errors


def test_errors_are_averaged_over_the_six_dimensions(experiment):
    errors = experiment.squared_errors()
    assert list(errors.columns) == METHODS
    np.testing.assert_allclose(errors.index, TEST)
    np.testing.assert_allclose(errors["zero policy"], (searched**2).mean(axis=1))
    nearest = policies[[0, 6, 12, 14, 20]]
    np.testing.assert_allclose(
        errors["nearest neighbour"], ((nearest - searched) ** 2).mean(axis=1)
    )


def test_a_known_chart_is_that_of_the_nearest_policy(experiment):
    charts = experiment.methods["charts"].charts_
    assert experiment.known_charts.tolist() == charts[[0, 3, 6, 7, 10]].tolist()


def test_knowing_the_chart_concerns_the_charts_alone(experiment):
    learned, known = (experiment.squared_errors(one) for one in TEST_SUBSETS[:2])
    pd.testing.assert_frame_equal(learned[METHODS[1:]], known[METHODS[1:]])
    predicted = experiment.methods["charts"].predict(
        experiment.test_tasks, chart=experiment.known_charts
    )
    np.testing.assert_allclose(
        known["charts"], np.mean((predicted - searched) ** 2, axis=1), rtol=1e-4
    )


@pytest.mark.parametrize("shift", [-1e-12, 0.0, 1e-12])
def test_half_way_between_two_training_tasks_each_counts_half(shift):
    trial = Experiment("free", n_samples=12, names=["nearest neighbour"])
    trial.test_tasks = trial.tasks[1:2] + shift  # between the first two trained on
    trial.test_policies = np.zeros((1, 6))
    trial.test_table = pd.DataFrame({"task_deg": [15.0], "cost": [0.1]})
    both = np.mean(policies[[0, 2]] ** 2)
    assert trial.squared_errors().to_numpy() == pytest.approx(both)
    with Arm(trial.workspace) as arm:
        done = arm.execute_many(policies[[0, 2]], 15.0)
    error = 50 * sum(rollout.error for rollout in done)
    assert trial.executed["error_cm"].tolist() == pytest.approx([error])


@pytest.mark.parametrize("shift", [-1e-12, 0.0, 1e-12])
def test_as_far_from_a_jump_as_training_tasks_lie_apart_is_beside_it(shift):
    trial = Experiment("free", n_samples=12, names=["nearest neighbour"])
    trial.test_tasks = np.deg2rad([[112.5 - 30 + 1e-12], [112.5 - 30.01]]) + shift
    assert trial.away_from_jumps.tolist() == [False, True]


def test_away_from_jumps_is_farther_than_training_tasks_lie_apart(experiment):
    far = [abs(task - np.array([112.5, 232.5])).min() > 30 for task in TEST]
    assert far == [True, False, True, True, True]
    assert experiment.away_from_jumps.tolist() == far
    pd.testing.assert_frame_equal(
        experiment.squared_errors("away from jumps"), experiment.squared_errors()[far]
    )
    near = experiment.squared_errors("beside jumps")
    assert near.index.tolist() == [95.0]


def test_the_summary_averages_over_test_tasks(experiment):
    summary = experiment.mse_summary()
    assert list(summary.index) == METHODS
    assert list(summary.columns) == list(TEST_SUBSETS)
    for subset in TEST_SUBSETS:
        errors = experiment.squared_errors(subset)
        np.testing.assert_allclose(summary[subset], errors.mean())


# Execution


def test_predicted_policies_are_executed(experiment):
    table = experiment.executed
    assert len(table) == len(METHODS) * len(TEST)
    for name in ("charts", "zero policy"):
        rows = table[table["method"] == name]
        predicted = experiment.predict(name, experiment.test_tasks)
        with Arm(experiment.workspace) as arm:
            rollouts = arm.execute_many(predicted, TEST)
        found = [100 * rollout.error for rollout in rollouts]
        np.testing.assert_allclose(rows["error_cm"], found, rtol=1e-6)
        excess = [cost(rollout) for rollout in rollouts] - (0.1 + TEST / 1000)
        np.testing.assert_allclose(rows["excess_cost"], excess, rtol=1e-6)
        assert not rows["touched"].any()


def test_what_is_predicted_again_is_not_executed_again(monkeypatch):
    world, table = Workspace.free(), pd.DataFrame({"task_deg": [10, 20, 10, 10.0]})
    table["cost"] = [0.1, 0.2, 0.3, 0.1]
    policies = np.random.default_rng(8).normal(size=(4, 6))
    policies[2] = policies[0]
    with Arm(world) as arm:
        wanted = [100 * one.error for one in arm.execute_many(policies, table.task_deg)]
    asked = []

    class Counted:
        def execute_many(self, rows, angles):
            asked.append(len(rows))
            return cached_arm(world).execute_many(rows, angles)

    monkeypatch.setattr(msc.study._measure, "cached_arm", lambda _: Counted())
    once = execute_policies(world, policies, table)
    again = execute_policies(world, policies[::-1], table[::-1])
    other = execute_policies(Workspace.obstacles(), policies, table)
    assert asked == [3, 0, 3]
    np.testing.assert_array_equal(once["error_cm"], wanted)
    np.testing.assert_array_equal(again["error_cm"], wanted[::-1])
    assert once["excess_cost"][0] - once["excess_cost"][2] == pytest.approx(0.2)
    assert other["touched"].dtype == bool


def test_a_column_is_spread_over_the_methods(experiment):
    wide = experiment.executed_by_method("error_cm")
    assert list(wide.columns) == METHODS
    np.testing.assert_allclose(wide.index, TEST)
    for name, rows in experiment.executed.groupby("method"):
        np.testing.assert_array_equal(wide[name], rows["error_cm"])


def test_one_policy_a_task_is_executed():
    table = pd.DataFrame({"task_deg": [90.0, 180.0], "cost": [0.05, 0.05]})
    with pytest.raises(ValueError, match="3 policies for 2 tasks; wanted as many"):
        execute_policies(Workspace.free(), np.zeros((3, 6)), table)


def test_execution_is_summarised_by_method(experiment):
    summary = experiment.executed_summary()
    assert list(summary.index) == METHODS
    error = experiment.executed_by_method("error_cm")["charts"]
    excess = experiment.executed_by_method("excess_cost")["charts"]
    found = summary.loc["charts"]
    assert found["excess cost, mean"] == pytest.approx(excess.mean())
    assert found["excess cost, median"] == pytest.approx(excess.median())
    assert found["error (cm), mean"] == pytest.approx(error.mean())
    assert found["error (cm), std"] == pytest.approx(error.std())
    assert found["error (cm), median"] == pytest.approx(error.median())
    assert found["share under 1 cm"] == (error < 1).mean()
    assert found["share that touched"] == 0


# Comparisons


def test_comparisons_divide_the_means(experiment):
    means = experiment.mse_summary()["chart known"]
    found = experiment.compare_mse("chart known")
    assert found.value == pytest.approx(means["charts"] / means["single regression"])
    assert found.label == "MSE, chart known"
    assert found.low < found.value < found.high
    wide = experiment.executed_by_method("error_cm").mean()
    found = experiment.compare_executed("error_cm", baseline="zero policy")
    assert found.value == pytest.approx(wide["charts"] / wide["zero policy"])


# Bad input


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"name": "fre"}, r"workspace='fre'"),
        ({"name": "obstacles"}, r"dataset 'obstacles' is not there"),
        ({"n_samples": 25}, r"n_samples=25 .* at most 24"),
        ({"n_samples": 1}, r"n_samples=1; wanted at least 2, whole"),
        ({"chosen": [0, 5]}, r"n_samples=12, chosen=\[0, 5\]; wanted one of the two"),
        ({"n_samples": None}, r"n_samples=None, chosen=None; wanted one of the two"),
        ({"n_samples": None, "chosen": [3, 3]}, r"chosen=\[3, 3\]; wanted different"),
        ({"n_samples": None, "chosen": [0, 24]}, r"chosen=\[0, 24\]; .* from 0 to 23"),
        ({"names": ["chart"]}, "name='chart' is no method"),
        ({"n_samples": 12.5}, r"n_samples=12\.5; wanted at least 2, whole"),
    ],
)
def test_bad_arguments_are_named(arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        Experiment(**{"name": "free", "n_samples": 12} | arguments).predict(
            "charts", []
        )


def test_an_unknown_subset_is_refused(experiment):
    with pytest.raises(ValueError, match=r"subset='gates'; wanted one of"):
        experiment.squared_errors("gates")
