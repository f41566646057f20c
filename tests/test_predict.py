import hashlib
import io
import os
import pickle
import subprocess
import sys
import warnings
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import skops.io
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sklearn import config_context
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_predict
from sklearn.preprocessing import FunctionTransformer
from sklearn.utils.estimator_checks import parametrize_with_checks
from weights import REFUSED, hold

import msc.skills._saved
from msc.cli import main
from msc.skills import METHODS, TableSkill, load_skill, predict_table, save_skill
from msc.skills._bands import Doubt
from msc.skills._digits import format_lines
from msc.skills._saved import TRUSTED, skill_bytes
from msc.skills._trees import quicken

PERIODS = {"angle": 360.0}


def solved(n_tasks=50, seed=0):
    """Tasks of an angle (degrees) and a mass (kg), and two columns of policies."""
    rng = np.random.default_rng(seed)
    tasks = pd.DataFrame(
        {"angle": rng.uniform(0, 360, n_tasks), "mass": rng.uniform(1, 3, n_tasks)}
    )
    turn = np.radians(tasks["angle"])
    push = np.cos(turn) * tasks["mass"] + 9 * (tasks["mass"] > 2)
    return tasks, pd.DataFrame({"push": push, "lift": 100 * np.sin(turn)})


def fitted(method, **how):
    tasks, policies = solved()
    how = {"periods": PERIODS, "random_state": 0} | how
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The graph has")
        return TableSkill(method, **how).fit(tasks, policies, np.ones(len(tasks)))


@pytest.fixture(scope="module")
def skills():
    return {name: fitted(name) for name in METHODS}


NEW = solved(40, seed=1)[0]
DRAWN = {"check_sample_weight_equivalence_on_dense_data": "trees draw among copies"}
TREES = {"n_estimators": 9}
FAILING = {"nearest neighbour": REFUSED, "random forest": DRAWN}


@parametrize_with_checks([TableSkill("nearest neighbour"), TableSkill("random forest")])
def test_it_is_an_estimator(estimator, check, monkeypatch):
    forest = METHODS["random forest"]
    small = replace(forest, build=lambda *of: forest.build(*of).set_params(**TREES))
    monkeypatch.setitem(METHODS, "random forest", small)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "(The graph has|tasks span)")
        hold(check, estimator, FAILING[estimator.method])


@pytest.mark.parametrize("method", METHODS)
def test_units_do_not_matter(method, skills):
    tasks, policies = solved()
    radians = {"angle": np.pi / 180, "mass": 1000.0}
    skill = TableSkill(method, periods={"angle": 2 * np.pi}, random_state=0)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "The graph has")
        skill.fit(tasks * radians, policies / [1.0, 1000.0], np.ones(len(tasks)))
    found = skill.predict(NEW * radians) * [1.0, 1000.0]
    np.testing.assert_allclose(found, skills[method].predict(NEW), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("method", METHODS)
def test_a_period_closes_the_circle(method, skills):
    on, off = NEW.assign(angle=0.0), NEW.assign(angle=360.0)
    before, after = (skills[method].predict(one) for one in (on, off))
    np.testing.assert_allclose(before, after, atol=1e-6)
    turned = skills[method].predict(NEW.assign(angle=NEW["angle"] + 720))
    np.testing.assert_allclose(turned, skills[method].predict(NEW), atol=1e-6)


@pytest.mark.parametrize(
    "method", ["four neighbours", "charts, k-means", "single regression"]
)
def test_where_a_circle_is_cut_does_not_matter(method, skills):
    tasks, policies = solved()
    turned = tasks.assign(angle=(tasks["angle"] + 123) % 360)
    skill = TableSkill(method, periods=PERIODS, random_state=0).fit(turned, policies)
    found = skill.predict(NEW.assign(angle=NEW["angle"] + 123))
    np.testing.assert_allclose(found, skills[method].predict(NEW), atol=1e-4)


def test_a_deviation_is_known_or_told_to_be_unknown(skills):
    has = {name for name, skill in skills.items() if skill.has_std}
    assert has == {name for name in METHODS if name.startswith(("charts", "single"))}
    for name, skill in skills.items():
        means, stds = skill.predict(NEW, return_std=True)
        np.testing.assert_array_equal(means, skill.predict(NEW))
        assert stds.shape == means.shape
        assert (stds > 0).all() if name in has else np.isnan(stds).all()


def test_tasks_beside_the_cut_have_neighbours_beyond_it():
    tasks = np.array([[5.0], [100.0], [200.0], [355.0], [150.0], [250.0]])
    values = np.array([1.0, 0.0, 0.0, 3.0, 0.0, 0.0])
    for method, wanted in [("nearest neighbour", 3.0), ("linear interpolation", 2.2)]:
        skill = TableSkill(method, periods={0: 360.0}, random_state=0)
        found = skill.fit(tasks, values).predict([[-1.0]])
        np.testing.assert_allclose(found, [wanted])
    assert not skill.find_outside([[-1.0], [400.0]]).any()
    narrow = TableSkill("mean policy", periods={0: 360.0}).fit(
        tasks[:1] % 10, values[:1]
    )
    assert narrow.find_outside([[100.0], [365.0]]).ravel().tolist() == [True, False]


def test_outside_is_told_by_column(skills):
    rows = pd.DataFrame({"angle": [10.0, -350.0, 900.0], "mass": [0.5, 2.0, 3.5]})
    found = skills["charts"].find_outside(rows)
    assert found.tolist() == [[False, True], [False, False], [False, True]]


def test_a_chart_is_as_sure_as_its_neighbourhood(skills):
    skill = skills["charts"]
    charts, share = skill.predict_chart(NEW)
    assert set(charts) <= {*range(skill.model_.n_charts_)}
    assert share.min() > 0
    assert set(np.round(5 * share, 9)) <= {*map(float, range(6))}
    inside = np.abs(NEW["mass"] - 2) > 0.5
    assert share[inside].mean() >= share[~inside].mean()


def test_four_tasks_on_two_charts_are_enough():
    tasks = [[0.0], [1.0], [2.0], [3.0]]
    skill = TableSkill("charts", random_state=0).fit(tasks, [0.0, 0.1, 9.0, 9.2])
    charts, share = skill.predict_chart(tasks)
    assert len({*charts}) > 1
    assert set(share * 4) <= {1.0, 2.0, 3.0}


def test_it_is_at_home_in_scikit_learn():
    tasks, policies = solved(40)
    groups = np.arange(40) // 4
    how = {"cv": GroupKFold(3)}
    skill = TableSkill("nearest neighbour", periods=PERIODS, random_state=0)
    search = GridSearchCV(
        skill, {"method": ["mean policy", "four neighbours"]}, **how
    ).fit(tasks, policies, groups=groups)
    assert search.best_params_ == {"method": "four neighbours"}
    assert search.best_estimator_.feature_names_in_.tolist() == ["angle", "mass"]
    found = cross_val_predict(skill, tasks, policies, groups=groups, **how)
    assert found.shape == policies.shape
    again = pickle.loads(pickle.dumps(skill.fit(tasks, policies)))
    np.testing.assert_array_equal(again.predict(NEW), skill.predict(NEW))
    assert clone(skill).get_params() == skill.get_params()
    with pytest.raises(ValueError, match="feature names"):
        skill.predict(NEW[["mass", "angle"]])


@pytest.mark.parametrize("method", [n for n in METHODS if METHODS[n].takes_weights])
@pytest.mark.parametrize("is_routed", [False, True])
def test_a_method_that_takes_weights_learns_what_weighs(method, is_routed):
    """Of two groups of rows that contradict each other, the one that counts."""
    tasks, policies = solved(200)
    weights = np.arange(200) % 2.0
    policies = policies.mul(np.where(weights == 1, 1, -1), axis=0)
    skill = TableSkill(method, periods=PERIODS, random_state=0)
    with config_context(enable_metadata_routing=is_routed):
        skill.fit(tasks, policies, sample_weight=weights)
    heavy = weights == 1
    alone = clone(skill).fit(tasks[heavy], policies[heavy])
    found, wanted = skill.predict(NEW), alone.predict(NEW)
    missed = np.abs(found - wanted).mean(axis=0)
    without = np.abs(clone(skill).fit(tasks, policies).predict(NEW) - wanted)
    assert (missed < without.mean(axis=0) / 2).all()


def test_methods_without_weights_say_which_take_some():
    with pytest.raises(ValueError, match=r"'charts' takes no sample_weight.*'CrKr'"):
        TableSkill("charts").fit(*solved(), sample_weight=np.ones(50))


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"method": "magic"}, "method"),
        ({"periods": {"angel": 1.0}}, "'angel' is no column; there are"),
        ({"periods": {"angle": 0.0}}, r"periods\['angle'\]=0.0; wanted it positive"),
        ({"max_tasks": 2}, "max_tasks"),
    ],
)
def test_bad_parameters(how, words):
    with pytest.raises(ValueError, match=words):
        fitted(**{"method": "mean policy"} | how)


# Files


def seal(skill, tasks):
    """Identify all that a skill says, to the last bit."""
    parts = [*skill.predict(tasks, return_std=True), *skill.predict_chart(tasks)]
    return hashlib.sha256(b"".join(one.tobytes() for one in parts)).hexdigest()


TOLD = """
import sys
from pathlib import Path

import pandas as pd
from msc.skills import load_skill
from test_predict import NEW, seal

for path in sorted(Path().glob("*.skops")):
    print(path.stem, seal(load_skill(path), NEW), sep="=")
"""


def test_another_process_predicts_the_same_bytes(skills, tmp_path):
    for name, skill in skills.items():
        save_skill(skill, tmp_path / f"{name}.skops")
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", TOLD],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    found = dict(line.split("=") for line in ran.stdout.splitlines())
    assert found == {name: seal(skill, NEW) for name, skill in skills.items()}


def test_equal_skills_have_equal_files():
    assert skill_bytes(fitted("charts")) == skill_bytes(fitted("charts"))


def test_no_more_is_trusted_than_skills_are_made_of(skills):
    used = {*skops.io.get_untrusted_types(data=skops.io.dumps(Doubt().fit(NEW, NEW)))}
    for skill in skills.values():
        used |= {*skops.io.get_untrusted_types(data=skops.io.dumps(skill))}
    assert used == {*TRUSTED}


def harmful(path):
    skops.io.dump(FunctionTransformer(os.getcwd), path)


def foreign(path):
    skops.io.dump({"a": 1}, path)


def cut(path, share=0.6):
    whole = skill_bytes(fitted("mean policy"))
    path.write_bytes(whole[: int(share * len(whole))])


def damaged(path):
    whole = bytearray(skill_bytes(fitted("mean policy")))
    whole[len(whole) // 3] ^= 1
    path.write_bytes(whole)


def empty(path):
    path.write_bytes(b"")


def archive(path):
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("a.txt", "a")


def garbled(path):
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("schema.json", '{"protocol": 2}')


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (harmful, r"holds \w+.getcwd, which is not trusted"),
        (foreign, "holds a dict; wanted a skill"),
        (cut, "no file of a skill, or was cut short"),
        (damaged, "no file of a skill, or was cut short"),
        (empty, "no file of a skill, or was cut short"),
        (archive, "no file of a skill, or was cut short"),
        (garbled, "no file of a skill"),
    ],
)
@pytest.mark.filterwarnings("ignore:.*was written with")
def test_files_that_are_no_skills(make, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    make(Path("a.skops"))
    NEW.to_csv("new.csv", index=False)
    with pytest.raises(ValueError, match=words):
        load_skill("a.skops")
    assert main(["predict", "a.skops", "new.csv", "--out", "out.csv"]) == 2
    *_, said = capsys.readouterr().err.splitlines()
    assert "a.skops" in said
    assert sorted(path.name for path in Path().iterdir()) == ["a.skops", "new.csv"]


def test_skops_is_an_extra(skills, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "skops.io", None)
    with pytest.raises(ValueError, match=r"wanted the extra, pip install 'msc\[skills"):
        save_skill(skills["mean policy"], tmp_path / "a.skops")
    words = ["fit", "t.csv", "--tasks", "a", "--policies", "b", "--out", "out"]
    assert main(words) == 2
    assert "pip install 'msc[skills]'" in capsys.readouterr().err


def test_files_of_other_versions_say_so(skills, tmp_path, monkeypatch):
    file, real = tmp_path / "a.skops", msc.skills._saved.versions()
    with monkeypatch.context() as patched:
        older = real | {"scikit-learn": "0.1"}
        patched.setattr(msc.skills._saved, "versions", lambda: older)
        save_skill(skills["mean policy"], file)
    words = rf"a.skops was written with scikit-learn 0.1 \(here {real['scikit-learn']}"
    with pytest.warns(UserWarning, match=words):
        load_skill(file)


def test_a_members_name_leads_nowhere(skills):
    names = zipfile.ZipFile(io.BytesIO(skill_bytes(skills["charts"]))).namelist()
    assert len(names) == len({*names})
    assert {"msc.json", "schema.json"} < {*names}


# The command


@pytest.fixture(scope="module")
def in_degrees():
    return fitted("charts", units={"angle": "deg"})


@pytest.fixture
def here(in_degrees, tmp_path, monkeypatch, skills):
    monkeypatch.chdir(tmp_path)
    save_skill(in_degrees, Path("charts.skops"))
    save_skill(skills["nearest neighbour"], Path("near.skops"))
    rows = NEW.assign(mass=NEW["mass"].where(NEW.index != 3, 9.0), note="x")
    rows[["note", "mass", "angle"]].to_csv("new.csv", index=False)
    return rows[["angle", "mass"]]


def contents():
    """Return all files here, to the byte."""
    return {path.name: path.read_bytes() for path in Path().iterdir()}


def predict(*words):
    return main(["predict", *words, "--out", "out.csv"])


def test_the_file_says_what_the_skill_does(here, capsys):
    assert predict("charts.skops", "new.csv", "--units", "angle=deg") == 0
    told = capsys.readouterr()
    outside = load_skill("charts.skops").find_outside(here)[:, 1]
    assert f"{outside.sum()} of 40 tasks lie outside" in told.err
    found = pd.read_csv("out.csv")
    means, stds = load_skill("charts.skops").predict(here, return_std=True)
    ends = ["", "_std", "_band90"]
    columns = [f"{name}{end}" for name in ("push", "lift") for end in ends]
    end = ["chart", "gate_probability", "doubtful", "outside"]
    assert [*found] == ["angle", "mass", *columns, *end]
    known = ["push", "lift", "push_std", "lift_std"]
    np.testing.assert_allclose(found[known], np.hstack([means, stds]), rtol=1e-8)
    unknown = ["push_band90", "lift_band90", "doubtful"]
    assert found[unknown].isna().all(axis=None), "no task was left out for this skill"
    pd.testing.assert_frame_equal(found[["angle", "mass"]], here, rtol=1e-14)
    assert found["outside"].notna().tolist() == outside.tolist()
    assert found["outside"][3] == "mass"


@given(st.lists(st.floats(-1e280, 1e280), min_size=1), st.integers(-12, 12))
@example([0.0, -0.0, 0.5, 999999999.5, 999.5, 1e-4, 1e9, 0.1234567885, 1e-5, 5e-324], 0)
@settings(max_examples=200, deadline=None)
def test_numbers_are_written_as_percent_writes_them(numbers, power):
    column = np.array([*numbers, *(np.round(numbers, 3) * 10.0**power)])[:, None]
    for form in ("%.9g", "%.3g", "%.15g"):
        wanted = [f"{form % number},,{form % number}" for number in column[:, 0]]
        assert format_lines(np.hstack([column] * 2), [form, "", form]) == wanted
    whole = np.rint(column[np.abs(column) < 1e12])[:, None]
    assert format_lines(whole, ["%d"]) == [str(int(number)) for number in whole[:, 0]]


def test_trees_answer_many_tasks_with_the_bits_of_scikit_learn():
    tasks, policies = solved(400)
    policies["flat"] = 1.0
    skill = TableSkill("boosted trees", random_state=0).fit(tasks, policies)
    points = skill.scale_.transform(solved(3000, seed=1)[0].to_numpy())
    points[:400] = skill.scale_.transform(tasks.to_numpy())  # nearest to thresholds
    trees = skill.model_.estimators_
    splits = [tree.nodes["num_threshold"] for (tree,) in trees[0]._predictors]
    points[-200:] = np.concatenate(splits)[:200, None]  # which belong to the left
    quick = quicken(skill.model_, len(points))
    assert quick is not skill.model_
    np.testing.assert_array_equal(quick.predict(points), skill.model_.predict(points))
    assert quicken(skill.model_, 10) is skill.model_, "few are not worth the tables"


@pytest.mark.parametrize("name", ["charts", "four neighbours"])
def test_threads_write_the_same_bytes_and_ask_neighbours_once(
    name, skills, here, monkeypatch
):
    asked = []
    doubt = Doubt().fit(np.zeros((1, 3)), np.zeros((1, 2)))
    doubt.halves_, doubt.limit_ = np.ones(2), 0.1
    measure = Doubt.measure
    monkeypatch.setattr(
        Doubt, "measure", lambda self, X: asked.append(len(X)) or measure(self, X)
    )
    monkeypatch.setattr(skills[name], "doubt_", doubt)
    many = solved(9000, seed=2)[0]
    many.to_csv("many.csv", index=False)
    for jobs in (1, 3):
        asked.clear()
        predict_table(skills[name], Path("many.csv"), Path(f"{jobs}.csv"), jobs=jobs)
        assert sum(asked) == len(many)
    assert Path("1.csv").read_bytes() == Path("3.csv").read_bytes()
    told, read = skills[name].predict(many), pd.read_csv("1.csv")
    np.testing.assert_allclose(read[["push", "lift"]], told, rtol=1e-8, atol=1e-9)


def test_what_has_no_deviation_leaves_it_blank(here):
    assert predict("near.skops", "new.csv") == 0
    found = pd.read_csv("out.csv")
    assert found[["push_std", "lift_std"]].isna().all(axis=None)
    assert found["lift"].notna().all()
    assert (found["chart"] == 0).all()


def test_awkward_names_are_quoted(here):
    tasks, policies = (one.copy() for one in solved())
    tasks.columns, policies.columns = ["a, b", 'c "d"'], ["p;q", "50 %"]
    skill = TableSkill("mean policy").fit(tasks, policies)
    save_skill(skill, Path("a.skops"))
    (tasks + 1e6).to_csv("new.csv", index=False)
    assert predict("a.skops", "new.csv") == 0
    found = pd.read_csv("out.csv")
    names = ["a, b", 'c "d"', "p;q", "p;q_std", "p;q_band90"]
    assert [*found][:5] == names
    assert found["outside"][0] == 'a, b and c "d"'


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["angle=rad"], "'angle' is in rad, but the skill learned it in deg"),
        (["angel=deg"], "no task column 'angel'"),
        (["angle=grad"], "unit 'grad' of 'angle' is unknown"),
    ],
)
def test_other_units_are_refused(words, said, here, capsys):
    before = contents()
    assert predict("charts.skops", "new.csv", "--units", *words) == 2
    assert said in capsys.readouterr().err
    assert contents() == before


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        (NEW[["angle"]], "there is no column 'mass'; wanted one of 'angle'"),
        (NEW.rename(columns={"mass": "Mass"}), "did you mean 'Mass'"),
        (NEW.assign(mass=np.nan), "blank or not finite in rows 1, 2, 3, 4, 5 and 35"),
        (NEW[:0], "has no column of numbers"),
    ],
)
def test_bad_new_tasks(frame, said, here, capsys):
    frame.to_csv("new.csv", index=False)
    Path("out.csv").write_text("kept", encoding="utf-8")
    before = contents()
    assert predict("near.skops", "new.csv") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert contents() == before
