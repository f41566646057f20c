import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import interp1d
from scipy.sparse import csr_array
from sklearn.base import clone
from sklearn.cluster import KMeans
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    ConstantKernel,
    ExpSineSquared,
    Matern,
    WhiteKernel,
)
from sklearn.metrics import adjusted_rand_score
from sklearn.model_selection import RandomizedSearchCV
from sklearn.svm import SVC

from msc import SMCE, CrKR, ParameterizedSkill
from msc.learn import gaussian_process
from msc.study import METHODS, build_method, fit_methods
from msc.study._methods import COMMON
from msc.study.rivals import ChosenByTrial
from msc.study.rivals._interpolation import Interpolation

rng = np.random.default_rng(0)
tasks = np.sort(rng.uniform(0, 2 * np.pi, 14))[:, None]
policies = np.c_[np.sin(tasks), np.cos(2 * tasks)] + 4 * (tasks > 3)
cost = rng.uniform(0.05, 0.3, 14)
new_tasks = np.linspace(-0.2, 2 * np.pi, 25)[:, None]


@pytest.fixture(scope="module")
def fitted():
    names = [f"charts{part}" for part in ("", ", SVM gate", ", k-means", ", Matérn")]
    names += [f"single{part}" for part in (" regression", ", Matérn", ", periodic")]
    names += ["CrKr", "nearest neighbour", "mean policy", "zero policy"]
    return fit_methods(tasks, policies, cost, n_charts=2, names=names)


ALIKE = {"charts, λ 1", "charts, λ 100", "charts, 10 neighbours"}  # but for a number
ALIKE |= {f"{count} charts" for count in range(3, 9)}


@pytest.mark.parametrize("name", [name for name in METHODS if name not in ALIKE])
def test_a_method_is_fresh_can_be_cloned_and_predicts_policies(name):
    one, other = (build_method(name, seed=1, n_charts=2) for _ in range(2))
    assert one is not other
    assert repr(clone(one)) == repr(one)
    cheaply(name, one, other)
    n_params = 6 if knows_the_arm(name) else 2
    X, y = np.linspace(0.3, 6, 16)[:, None], rng.normal(size=(16, n_params))
    if name == "after Soni: stopped":
        assert one.fit(X, y).plan(X[:3]).shape == (3, 67, 3)
        return
    found = one.fit(X, y).predict(X[:3])
    assert found.shape == (3, n_params)
    np.testing.assert_array_equal(other.fit(X, y).predict(X[:3]), found)


def knows_the_arm(name):
    """Say whether a method takes the arm's policies only."""
    return name.endswith(("projected", "by trial", "ProMP", "mapped", "stopped"))


def cheaply(name, *methods):
    """Let methods practise, or choose their hyper-parameters, with little effort."""
    rollouts = {
        "n_rollouts": 256,
        "execute": lambda policies, X: 1 + policies[:, 0] ** 2,
    }
    for method in methods:
        if METHODS[name].group == "rollouts":
            method.set_params(settings=[{}], n_checks=9)
            method.estimator.set_params(**rollouts)
        for part in (method, *method.get_params().values()):
            if isinstance(part, RandomizedSearchCV):
                part.set_params(n_iter=1, cv=2)


def test_methods_with_rollouts_are_tried_on_few_sets_and_no_others():
    few = {name for name, method in METHODS.items() if method.sets == "few"}
    assert few == {
        name for name, method in METHODS.items() if method.group == "rollouts"
    }
    for name, method in METHODS.items():
        built = build_method(name)
        spends = "n_rollouts" in built.get_params(deep=False)
        spends |= isinstance(built, ChosenByTrial)
        assert spends == (method.sets == "few"), name


def test_one_that_executes_is_given_costs_in_the_unit_of_what_it_pays(monkeypatch):
    given = {}

    def fit(self, X, y, cost=None):
        given[self.estimator.__class__.__name__] = cost

    monkeypatch.setattr(ChosenByTrial, "fit", fit)
    fit_methods(tasks, policies, cost, names=["Kober's practice"])
    np.testing.assert_array_equal(given["PractisedCrKR"], cost)


def test_the_paper_s_methods_come_first():
    assert COMMON[:3] == ("charts", "single regression", "CrKr")


def test_a_number_of_charts_is_as_many():
    for name in ("1 chart", "3 charts"):
        skill = build_method(name).fit(tasks, policies)
        assert skill.n_charts_ == int(name[0])


def test_one_kernel_is_one_for_all_weights():
    skill = build_method("charts, Matérn, one kernel", n_charts=2).fit(tasks, policies)
    for chart in skill.regressors_:
        scales = {model.kernel_.k1.k2.length_scale for model in chart}
        assert len(scales) == 1


def test_charts_are_as_many_as_asked_for(fitted):
    assert fitted["charts"].n_charts_ == 2
    alone = ParameterizedSkill(SMCE(2, random_state=0), random_state=0)
    np.testing.assert_array_equal(
        fitted["charts"].predict(new_tasks),
        alone.fit(tasks, policies).predict(new_tasks),
    )


def test_variants_of_the_charts_differ_in_one_part(fitted):
    ours, gated, means, rough = (
        fitted[f"charts{part}"] for part in ("", ", SVM gate", ", k-means", ", Matérn")
    )
    np.testing.assert_array_equal(gated.charts_, ours.charts_)
    chart = ours.predict_chart(new_tasks)
    same = gated.predict(new_tasks, chart=chart), ours.predict(new_tasks)
    np.testing.assert_array_equal(*same)
    assert isinstance(gated.gate_[-1], SVC)
    expected = KMeans(2, random_state=0).fit_predict(policies)
    assert adjusted_rand_score(means.charts_, expected) == 1
    np.testing.assert_array_equal(rough.charts_, ours.charts_)
    assert {type(r.kernel_.k1.k2) for r in np.ravel(rough.regressors_)} == {Matern}


@pytest.mark.parametrize(
    ("part", "changed"),
    [
        ("λ 1", {"charts__regularization": 1.0}),
        ("λ 100", {"charts__regularization": 100.0}),
        ("10 neighbours", {"charts__n_neighbors": 10}),
        ("raw form", {"charts__form": "raw"}),
        ("GP gate", {"gate": "gp"}),
        ("SVM gate", {"gate": "svm"}),
        ("one kernel", {"kernel_per": "chart"}),
    ],
)
def test_a_choice_changes_one_parameter(part, changed):
    ours, other = (build_method(f"charts{end}") for end in ("", f", {part}"))
    before, after = (one.get_params(deep=True) for one in (ours, other))
    found = {key: after[key] for key in after if key != "charts"}
    assert found == {key: before[key] for key in before if key != "charts"} | changed


# Single regressions


@pytest.mark.parametrize(
    ("name", "kernel"),
    [
        ("single, Matérn", Matern(1.0, (1e-2, 1e2), nu=1.5)),
        (
            "single, periodic",
            ExpSineSquared(1.0, 2 * np.pi, (1e-2, 1e2), periodicity_bounds="fixed"),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_other_kernels_are_scikit_learn_s_at_their_likeliest(fitted, name, kernel):
    kernel = ConstantKernel(1.0, (1e-3, 1e3)) * kernel + WhiteKernel(1e-3, (1e-8, 1))
    for ours, values in zip(fitted[name].regressors_[0], policies.T, strict=True):
        assert str(ours.kernel).replace("Periodic", "ExpSineSquared") == str(kernel)
        plain = GaussianProcessRegressor(
            kernel, normalize_y=True, n_restarts_optimizer=4, random_state=0
        ).fit(tasks, values)
        best = plain.log_marginal_likelihood_value_
        assert ours.log_marginal_likelihood_value_ >= best - 1e-3
        fixed = GaussianProcessRegressor(
            ours.kernel_, normalize_y=True, optimizer=None
        ).fit(tasks, values)
        np.testing.assert_allclose(
            ours.predict(new_tasks), fixed.predict(new_tasks), rtol=1e-6
        )


def test_a_periodic_regression_closes_the_circle(fitted):
    ends = fitted["single, periodic"].predict([[0.0], [2 * np.pi]])
    np.testing.assert_allclose(*ends, atol=1e-9)
    ends = fitted["single regression"].predict([[0.0], [2 * np.pi]])
    assert np.abs(ends[1] - ends[0]).max() > 0.1


def test_an_unknown_kernel_is_named():
    with pytest.raises(ValueError, match="kernel='rbf'; wanted one of"):
        gaussian_process("rbf")


# CrKr


def test_crkr_is_given_the_cost_over_its_mean(fitted):
    alone = CrKR(tune=True).fit(tasks, policies, cost=cost / cost.mean())
    assert fitted["CrKr"].ridge_ == alone.ridge_
    np.testing.assert_array_equal(
        fitted["CrKr"].predict(new_tasks), alone.predict(new_tasks)
    )
    indifferent = CrKR(tune=True).fit(tasks, policies)
    assert np.abs(indifferent.predict(tasks) - alone.predict(tasks)).max() > 1e-9


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_a_cost_is_positive(bad):
    with pytest.raises(
        ValueError, match=f"cost must be positive and finite. Got {bad}"
    ):
        fit_methods(tasks, policies, np.where(cost == cost[3], bad, 1), names=["CrKr"])


def test_there_is_a_cost_a_task():
    with pytest.raises(ValueError, match=r"cost must have shape \(14,\), one entry"):
        fit_methods(tasks, policies, cost[:-1], names=["mean policy"])


# What needs no learning


def test_the_nearest_neighbour_s_policy(fitted):
    nearest = np.abs(new_tasks - tasks.T).argmin(axis=1)
    predicted = fitted["nearest neighbour"].predict(new_tasks)
    np.testing.assert_array_equal(predicted, policies[nearest])


def test_the_mean_and_the_zero_policy(fitted):
    mean, zero = (
        fitted[f"{one} policy"].predict(new_tasks) for one in ("mean", "zero")
    )
    np.testing.assert_allclose(mean, np.tile(policies.mean(axis=0), (25, 1)))
    assert zero.shape == (25, 2)
    assert not zero.any()


@settings(max_examples=25, deadline=None)
@given(st.integers(2, 20), st.integers(1, 3), st.integers(0, 99))
def test_interpolation_is_scipy_s_and_holds_beyond_the_ends(n_tasks, n_params, seed):
    draws = np.random.default_rng(seed)
    X, y = (
        draws.permutation(n_tasks)[:, None] / 3,
        draws.normal(size=(n_tasks, n_params)),
    )
    new = draws.uniform(-1, n_tasks / 3 + 1, size=(30, 1))
    ends = y[X[:, 0].argmin()], y[X[:, 0].argmax()]
    expected = interp1d(X[:, 0], y, axis=0, bounds_error=False, fill_value=ends)
    found = Interpolation().fit(X, y)
    np.testing.assert_allclose(found.predict(new), expected(new[:, 0]), atol=1e-12)
    np.testing.assert_allclose(found.predict(X), y, atol=1e-12)
    flat = Interpolation().fit(X, y[:, 0])
    np.testing.assert_array_equal(flat.predict(new), found.predict(new)[:, 0])


# Bad input


def test_interpolation_wants_numbers():
    with pytest.raises(ValueError, match="X has 2 features, but Interpolation"):
        Interpolation().fit(tasks, policies).predict([[0.0, 1.0]])
    with pytest.raises(ValueError, match="Input y contains NaN"):
        Interpolation().fit([[0.0], [1.0]], [0.0, np.nan])


def test_interpolation_says_what_is_wrong_with_its_data():
    model = Interpolation().fit(tasks, policies)
    with pytest.raises(ValueError, match=r"X must hold numbers.*'a'"):
        model.predict([["a"]])
    with pytest.raises(ValueError, match=r"X must hold numbers.*'a'"):
        Interpolation().fit([["a"], ["b"]], policies[:2])
    with pytest.raises(ValueError, match=r"y must hold numbers.*'b'"):
        Interpolation().fit(tasks[:2], [["b"], ["c"]])
    with pytest.raises(TypeError, match="Sparse data was passed for X"):
        Interpolation().fit(csr_array(tasks), policies)
    with pytest.raises(TypeError, match="Sparse data was passed for y"):
        Interpolation().fit(tasks, csr_array(policies))


def test_names_of_columns_are_kept_and_compared():
    model = Interpolation().fit(pd.DataFrame({"angle": tasks[:, 0]}), policies)
    assert model.feature_names_in_.tolist() == ["angle"]
    with pytest.raises(ValueError, match="feature names should match"):
        model.predict(pd.DataFrame({"turn": tasks[:, 0]}))


def test_linear_interpolation_takes_the_mean_of_equal_tasks():
    found = Interpolation().fit([[1.0], [0.0], [1.0]], [2.0, 0.0, 4.0])
    assert found.predict([[0.5], [1.0]]).tolist() == [1.5, 3.0]


def test_unknown_methods_are_named():
    with pytest.raises(ValueError, match="name='chart' is no method; wanted"):
        fit_methods(tasks, policies, cost, names=["charts", "chart"])
