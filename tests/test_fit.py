import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from sklearn.neighbors import KNeighborsRegressor
from sklearn.tree import DecisionTreeRegressor

import msc.skills._choose
import msc.skills._fit
import msc.skills._methods
from msc.cli import main
from msc.skills import (
    METHODS,
    Table,
    TableSkill,
    check_folder,
    fit_table,
    read_table,
    save_fit,
    tell_fit,
)
from msc.skills._blocks import make_blocks
from msc.skills._choose import choose, compare_methods
from msc.skills._subsample import spread_out

BREAK = 150.0  # degrees
QUICK = ["nearest neighbour", "linear interpolation"]


def broken(n_tasks=48, noise=0.01, seed=0):
    """Two smooth pieces, and a leap of three between them."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 300, n_tasks))
    turn = np.radians(angle)
    push = np.cos(turn) + 3 * (angle > BREAK)
    lift = 1000 * (np.sin(turn) + rng.normal(0, noise, n_tasks))
    return pd.DataFrame({"angle": angle, "push": push, "lift": lift})


def as_table(frame, tasks=("angle",), **options):
    policies = [name for name in frame if name not in tasks]
    return Table(frame[[*tasks]], frame[policies], **options)


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def fit():
    return fit_table(as_table(broken()), methods=QUICK)


def test_a_known_break_is_found(fit):
    (pair,) = fit.card["jumps"]["widest_jumps"]
    assert pair[0][0] < BREAK < pair[1][0]
    assert fit.card["jumps"]["n_jumps"] == 1
    after = broken()["angle"].to_numpy() > BREAK
    assert sorted(fit.card["jumps"]["pieces"]) == sorted(np.bincount(after))
    charts = fit.paper.model_.charts_
    assert not {*charts[after]} & {*charts[~after]}, "no chart leads over the break"


def test_errors_are_those_of_blocks_left_out(fit):
    """Nearest neighbours found by brute force, each block without its fold."""
    frame = broken()
    X, y = frame[["angle"]].to_numpy(), frame[["push", "lift"]].to_numpy()
    y = (y - y.mean(axis=0)) / y.std(axis=0)
    blocks = make_blocks(X, X, np.arange(len(X)), 0)
    missed = []
    for row in range(len(X)):
        others = blocks.folds[blocks.of_row] != blocks.folds[blocks.of_row[row]]
        near = cdist(X[[row]], X[others])[0].argmin()
        missed.append(np.mean((y[others][near] - y[row]) ** 2))
    (told,) = (
        one["error"]
        for one in fit.card["methods"]
        if one["method"] == "nearest neighbour"
    )
    assert told == pytest.approx(np.mean(missed), rel=1e-5)


def test_bands_are_judged_in_blocks_left_out():
    """Each fold predicted by a skill of the others; nine of ten lie within 1.645."""
    rng = np.random.default_rng(0)
    angle = np.sort(rng.uniform(0, 300, 40))
    push = np.cos(np.radians(angle)) + rng.normal(0, 0.2, 40)
    frame = pd.DataFrame({"angle": angle, "push": push})
    fit = fit_table(as_table(frame), methods=["single, one kernel"])
    assert fit.skill.method == "single, one kernel"
    X, y = frame[["angle"]].to_numpy(), frame[["push"]].to_numpy()
    blocks = make_blocks(X, X, np.arange(40), 0)
    held = []
    for fold in range(5):
        test = blocks.folds[blocks.of_row] == fold
        skill = TableSkill("single, one kernel", random_state=0)
        mean, std = skill.fit(X[~test], y[~test]).predict(X[test], return_std=True)
        held += [*(np.abs(mean - y[test]) < 1.6449 * std).ravel()]
    (band,) = (one for one in fit.card["held_out"]["bands"] if one["level"] == 0.9)
    assert band["held"] == pytest.approx(np.mean(held), rel=1e-5)
    assert 0 <= band["low"] <= band["held"] <= band["high"] <= 1


def test_single_rows_left_out_have_their_neighbours():
    frame = broken()
    fit = fit_table(as_table(frame), methods=QUICK[:1])
    assert fit.card["chosen"] == "nearest neighbour"
    assert fit.card["held_out"]["bands"] == []
    X, y = frame[["angle"]].to_numpy(), frame[["push", "lift"]].to_numpy()
    y = (y - y.mean(axis=0)) / y.std(axis=0)
    folds = np.random.default_rng(0).permutation(len(X)) % 5
    apart = np.where(folds[:, None] == folds, np.inf, cdist(X, X))
    missed = np.mean((y[apart.argmin(axis=1)] - y) ** 2)
    told = fit.card["held_out"]["single_rows_error"]
    assert told == pytest.approx(missed, rel=1e-5)


def test_the_result_does_not_depend_on_workers(fit):
    again = fit_table(as_table(broken()), methods=QUICK, jobs=2)
    assert again.card == fit.card


@pytest.mark.parametrize("n_columns", [1, 2])
def test_blocks_hold_neighbours_and_equal_tasks(n_columns):
    rng = np.random.default_rng(n_columns)
    different = rng.uniform(size=(60, n_columns))
    rows = rng.integers(60, size=200)
    points = different[rows]
    blocks = make_blocks(points, points, np.unique(rows, return_inverse=True)[1], 0)
    for task in np.unique(rows):
        assert len({*blocks.of_row[rows == task]}) == 1
    assert (blocks.sizes > 0).all()
    assert (np.diff(blocks.folds) != 0).all(), "neighbours are in different folds"
    apart = cdist(points, points)
    same = blocks.of_row[:, None] == blocks.of_row
    assert apart[same].mean() < apart[~same].mean() / 3
    if n_columns == 1:
        assert (np.diff(blocks.of_row[np.argsort(points[:, 0])]) >= 0).all()


errors = st.lists(st.floats(0, 10), min_size=8, max_size=8).map(np.array)


@given(st.dictionaries(st.sampled_from("abcde"), errors, min_size=1), st.randoms())
@settings(max_examples=60, deadline=None)
def test_the_choice_is_as_good_as_the_best_and_as_simple_as_can_be(given_errors, draw):
    sizes = np.ones(8)
    name = choose(given_errors, sizes)
    least = min(one.mean() for one in given_errors.values())
    simpler = [*given_errors][: [*given_errors].index(name)]
    assert all(given_errors[one].mean() > least for one in simpler)
    order = draw.sample(range(8), 8)
    shuffled = {one: values[order] for one, values in given_errors.items()}
    assert choose(shuffled, sizes) == name or np.ptp(given_errors[name]) < 1e-9


def test_doubt_spares_the_simpler_and_certainty_does_not():
    noise = np.tile([-1.0, 1.0], 10)
    close = {"simple": 5.1 + noise, "better": 5 - noise}
    far = {"simple": 5.1 + noise / 100, "better": 5 - noise / 100}
    few = {"simple": np.r_[np.full(19, 0.01), 1.0], "better": np.full(20, 1e-4)}
    found = [choose(errors, np.ones(20)) for errors in (close, far, few)]
    assert found == ["simple", "better", "better"]


def test_what_is_chosen_for_a_fold_was_not_told_by_it():
    """Fits without one fold favour one method, those without two the other."""
    blocks = make_blocks(*2 * [np.arange(40.0)[:, None]], np.arange(40), 0)
    skills = {name: TableSkill(name) for name in ("mean policy", *QUICK[:1])}

    def run(_, calls):
        for number, (skill, _, _, left_out) in enumerate(calls):
            is_good = (skill.method == "mean policy") == (len(left_out) == 2)
            errors = np.full(len(blocks.folds), np.nan)
            errors[np.isin(blocks.folds, left_out)] = 0.0 if is_good else 1.0
            yield number, errors

    none = np.zeros((40, 1)), np.zeros((40, 1)), None
    found = compare_methods(skills, none, blocks, sizes=[], run=run, done=list)
    assert found.chosen == "nearest neighbour"
    assert found.picks == ("mean policy",) * 5
    assert (found.nested == found.errors["mean policy"]).all()


def test_costs_bring_a_method_that_wants_them():
    frame = broken(24)
    tables = [as_table(frame, cost=cost) for cost in (np.linspace(1, 2, 24), None)]
    with_costs, without = (fit_table(one, methods=["CrKr"]).card for one in tables)
    names = [one["method"] for one in with_costs["methods"]]
    assert names == ["mean policy", "CrKr"]
    assert [one["method"] for one in without["methods"]] == ["mean policy"]


def test_a_method_that_fails_is_told_and_left_out(monkeypatch):
    def fail(*_):
        raise ValueError("no luck")

    lucky = msc.skills._methods.Learner(fail)
    monkeypatch.setitem(METHODS, "nearest neighbour", lucky)
    card = fit_table(as_table(broken(24)), methods=QUICK).card
    assert card["failed"] == {"nearest neighbour": "no luck"}
    assert "nearest neighbour" not in [one["method"] for one in card["methods"]]
    assert "nearest neighbour     failed: no luck" in "\n".join(tell_fit(card))


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"profile": "slow"}, "profile='slow'; wanted one of"),
        ({"methods": ["magic"]}, r"methods=\['magic'\] are unknown"),
    ],
)
def test_bad_wishes(how, words):
    with pytest.raises(ValueError, match=words):
        fit_table(as_table(broken(24)), **how)


def test_of_noise_nothing_beats_the_mean_and_choosing_is_no_better():
    rng = np.random.default_rng(3)
    frame = pd.DataFrame(rng.standard_normal((40, 3)), columns=list("abc"))
    card = fit_table(as_table(frame, ("a", "b")), methods=QUICK).card
    assert card["chosen"] == "mean policy"
    assert card["error_of_choosing"]["error"] > 0.95
    assert not card["error_of_choosing"]["below_mean_low"] > 0


def test_many_tasks_are_served_as_well_as_by_the_neighbours_of_all(monkeypatch):
    monkeypatch.setitem(msc.skills._fit.MAX_TASKS, "quick", 40)
    rng = np.random.default_rng(0)
    tasks = rng.uniform(-3, 3, (800, 2))
    policy = np.sin(3 * tasks[:, 0]) * np.cos(3 * tasks[:, 1])
    frame = pd.DataFrame(np.c_[tasks, policy], columns=["x", "y", "p"])
    names = [*QUICK, "four neighbours"]
    card = fit_table(as_table(frame, ("x", "y")), methods=names).card
    error = {one["method"]: one["error"] for one in card["methods"]}
    takes_all = [name for name in error if METHODS[name].takes_all]
    assert card["chosen"] in takes_all
    assert error[card["chosen"]] <= 1.1 * error["nearest neighbour"]
    assert error["linear interpolation"] > error["four neighbours"]
    sizes = [point["n_tasks"] for point in card["curve"]]
    assert sizes == [10, 20, 40]
    assert card["curve"][-1]["error"] == error["linear interpolation"]


def test_of_thousands_what_is_recommended_is_as_good_as_others_of_all(monkeypatch):
    """New tasks of a known function; a neighbour and a tree have learned all rows."""
    monkeypatch.setitem(msc.skills._fit.MAX_TASKS, "quick", 100)
    rng = np.random.default_rng(0)
    tasks, new = rng.uniform(-3, 3, (4000, 2)), rng.uniform(-3, 3, (2000, 2))

    def known(x):
        return np.sin(2 * x[:, 0]) * np.cos(2 * x[:, 1])

    policy = known(tasks) + rng.normal(0, 0.05, 4000)
    frame = pd.DataFrame(np.c_[tasks, policy], columns=["x", "y", "p"])
    names = ["nearest neighbour", "four neighbours"]
    skill = fit_table(as_table(frame, ("x", "y")), methods=names).skill
    found = skill.predict(pd.DataFrame(new, columns=["x", "y"]))[:, 0]
    others = KNeighborsRegressor(1), DecisionTreeRegressor(random_state=0)
    errors = [
        np.mean((other.fit(tasks, policy).predict(new) - known(new)) ** 2)
        for other in others
    ]
    assert np.mean((found - known(new)) ** 2) <= 1.1 * min(errors)


def test_where_policies_leap_often_the_forest_is_as_good_as_a_tree_of_all():
    """Four hundred levels along one of two columns: more than boosted trees' bins."""
    rng = np.random.default_rng(3)
    levels = rng.normal(size=400)
    tasks, new = rng.uniform(0, 1, (4000, 2)), rng.uniform(0, 1, (2000, 2))
    known, truth = (levels[(400 * x[:, 0]).astype(int)] for x in (tasks, new))
    ways = METHODS["random forest"].build(4000, 0), DecisionTreeRegressor()
    ours, tree = (
        np.mean((way.fit(tasks, known).predict(new) - truth) ** 2) for way in ways
    )
    assert ours <= 1.1 * tree


@pytest.mark.parametrize(("height", "n_jumps"), [(0.3, 0), (0.6, 1)])
def test_how_large_a_jump_has_to_be_is_told(height, n_jumps):
    """Even tasks, and one step higher than all others."""
    angle = np.arange(40.0)
    policy = np.sin(angle / 8) + height * (angle > 20)
    frame = pd.DataFrame({"angle": angle, "lift": policy})
    card = fit_table(as_table(frame), methods=["nearest neighbour"]).card
    step = abs(policy[21] - policy[20]) / policy.std()
    assert card["jumps"]["n_jumps"] == n_jumps
    assert (step > card["jumps"]["least_jump"]) == bool(n_jumps)
    told = [words for words in tell_fit(card) if "is not seen" in words]
    assert len(told) == 1 - n_jumps


def test_of_many_rows_the_choice_is_told_by_half_the_fits(monkeypatch):
    table = as_table(broken(noise=0)[["angle", "lift"]])
    nested = fit_table(table, methods=QUICK[1:]).card["error_of_choosing"]
    calls = []
    measure = msc.skills._choose.measure_left_out

    def counted(*given):
        calls.append(given[-1])
        return measure(*given)

    monkeypatch.setattr(msc.skills._choose, "measure_left_out", counted)
    monkeypatch.setattr(msc.skills._choose, "MOST_NESTED", len(table.tasks) - 1)
    card = fit_table(table, methods=QUICK[1:]).card
    assert {len(left_out) for left_out in calls} == {1}
    assert len(calls) == 5 * 2, "each method without each fold"
    told = card["error_of_choosing"]
    assert nested["nested"]
    assert not told["nested"]
    assert {*told["chosen_without_fold"]} == {"linear interpolation"}
    error = {one["method"]: one["error"] for one in card["methods"]}
    assert told["error"] == error["linear interpolation"]


def test_a_subsample_fills_the_space():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(4000, 2))
    some = spread_out(points, 50, seed=1)
    assert len({*some}) == 50
    near = cdist(points[some], points[some]) + 9 * np.eye(50)
    drawn = points[rng.choice(4000, 50, False)]
    assert near.min() > 5 * (cdist(drawn, drawn) + 9 * np.eye(50)).min()
    copies = np.zeros((30, 1))
    assert len({*spread_out(copies, 12, seed=0)}) == 12


@pytest.mark.filterwarnings("ignore:The graph has")
def test_bands_hold_what_they_say_away_from_jumps():
    rng = np.random.default_rng(4)

    def draw(n_tasks):
        tasks = rng.uniform(0, 360, (n_tasks, 1))
        truth = 50 * np.cos(np.radians(tasks)) + 300 * (tasks > 180)
        return tasks, truth + rng.normal(0, 5, tasks.shape)

    X, y = draw(160)
    skill = TableSkill("charts", periods={0: 360.0}, random_state=0).fit(X, y)
    X, y = draw(3000)
    away = np.abs((X[:, 0] + 90) % 180 - 90) > 15  # degrees from either jump
    mean, std = skill.predict(X[away], return_std=True)
    inside = np.abs(mean - y[away]) < 1.645 * std
    assert 0.85 < inside.mean() < 0.95


def run_fit(*words, table="t.csv"):
    return main(["fit", table, "--jobs", "1", "--out", "out", *words])


GOOD = broken(30)
COLUMNS = ["--tasks", "angle", "--policies", "push", "lift"]


@pytest.fixture
def quickly(monkeypatch):
    """Compare what takes no time, and draw it coarsely."""
    monkeypatch.setattr("msc.report._pictures._DPI", 20)
    few = {name: METHODS[name] for name in ["mean policy", "nearest neighbour"]}
    monkeypatch.setattr(msc.skills._fit, "METHODS", few)


def changed(**columns):
    return GOOD.assign(**columns)


def put(column, rows, value):
    frame = GOOD.astype({column: object})
    frame.loc[rows, column] = value
    return frame


BAD = {
    "words": (changed(angle="a", push="b", lift="c"), [], "no column of numbers"),
    "few": (GOOD[:9], [], "9 different tasks in 9 rows; wanted at least 10"),
    "copies": (changed(angle=np.arange(30) % 7), [], "7 different tasks in 30 rows"),
    "task": (changed(angle=3.0), [], "task column 'angle' of t.csv is constant"),
    "policy": (changed(push=1.0, lift=2.0), [], "policy columns .* are constant"),
    "blank": (put("push", [2, 6], None), [], "'push' .* blank .* in rows 3, 7;"),
    "many": (put("push", [*range(8)], ""), [], "rows 1, 2, 3, 4, 5 and 3 more"),
    "infinite": (put("lift", 4, np.inf), [], "'lift' .* not finite in row 5"),
    "word": (put("lift", 4, "left"), [], "'lift' of t.csv is 'left' in row 5"),
    "comma": (put("push", 1, "0,5"), [], "'0,5' in row 2; .* by semicolons"),
    "twice": (GOOD, ["--policies", "push", "angle"], "'angle' is named twice"),
    "unknown": (GOOD, ["--tasks", "Angel"], "'Angel' .did you mean 'angle'"),
    "unit": (GOOD, ["--units", "angle=degree"], "unit 'degree' .* .did you mean 'deg'"),
    "unit of": (GOOD, ["--units", "angl=deg"], "units: there is no column 'angl'"),
    "pair": (GOOD, ["--units", "deg"], "units='deg'; wanted COLUMN=VALUE"),
    "period": (GOOD, ["--period", "angle=x"], "period of 'angle' is 'x'"),
    "no period": (GOOD, ["--period", "angle=-1"], "is -1; wanted it positive"),
    "of policy": (
        GOOD,
        ["--period", "push=2"],
        "period: there is no task column 'push'",
    ),
    "cost": (changed(c=np.arange(30)), ["--cost", "c"], "cost 'c' is 0 in row 1"),
    "huge": (changed(push=1e200), [], "'push' of t.csv must .* to 1e.100.* Got 1e.200"),
    "heads": (
        GOOD.rename(columns={"lift": "push"}),
        [],
        "has 2 columns 'push'; wanted",
    ),
    "nowhere": (GOOD, ["--out", "t.csv/out"], "out=t.csv/out: nothing can be written"),
    "profile": (GOOD, ["--profile", "slow"], "profile='slow'; wanted one of"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_are_told_in_a_sentence(name, here, capsys):
    frame, options, words = BAD[name]
    frame.to_csv("t.csv", index=False)
    assert run_fit(*COLUMNS, *options) == 2
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 1
    with pytest.raises(ValueError, match=words):
        raise ValueError(said[0])
    assert sorted(path.name for path in here.iterdir()) == ["t.csv"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "t.csv is no table: No columns"),
        (b"a,b\n1,2\n3,4,5,6\n", "t.csv is no table: .*line 3"),
        (b"a,b\n1,2,3\n4,5,6\n", "t.csv is no table: Length of header"),
        (b"\xff\xfea\0,\0", "t.csv is not UTF-8"),
        (b"a,b\n\0\0", "has bytes of zero"),
    ],
)
def test_files_that_are_no_tables(content, words, here, capsys):
    Path("t.csv").write_bytes(content)
    assert run_fit(*COLUMNS) == 2
    with pytest.raises(ValueError, match=words):
        raise ValueError(capsys.readouterr().err)
    assert sorted(path.name for path in here.iterdir()) == ["t.csv"]


def test_parquet_asks_for_its_engine(here, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "fastparquet", None)
    Path("t.parquet").write_bytes(b"PAR1")
    assert run_fit(*COLUMNS, table="t.parquet") == 2
    assert "pip install pyarrow" in capsys.readouterr().err
    assert sorted(path.name for path in here.iterdir()) == ["t.parquet"]


@pytest.mark.parametrize(
    ("options", "encoding", "note"),
    [
        ({"sep": ";"}, "utf-8", "semicolons stand between"),
        ({"sep": ";", "decimal": ","}, "utf-8", "decimal commas"),
        ({"sep": "\t"}, "utf-8", "tabs stand between"),
        ({}, "utf-8-sig", "byte-order mark"),
    ],
)
def test_other_ways_to_write_a_table_are_read_and_told(options, encoding, note, here):
    GOOD.to_csv("t.csv", index=False, encoding=encoding, **options)
    table = read_table(Path("t.csv"), ["angle"], ["push", "lift"])
    assert any(note in one for one in table.notes)
    found = pd.concat([table.tasks, table.policies], axis=1)
    pd.testing.assert_frame_equal(found, GOOD, rtol=1e-15)


@pytest.mark.usefixtures("quickly")
def test_what_is_amiss_leaves_an_earlier_fit(here, capsys):
    GOOD.to_csv("t.csv", index=False)
    assert run_fit(*COLUMNS) == 0
    before = {path.name: path.read_bytes() for path in (here / "out").iterdir()}
    put("push", 4, "left").to_csv("t.csv", index=False)
    assert run_fit(*COLUMNS, "--force") == 2
    assert "'push' of t.csv is 'left' in row 5" in capsys.readouterr().err
    after = {path.name: path.read_bytes() for path in (here / "out").iterdir()}
    assert after == before
    assert sorted(path.name for path in here.iterdir()) == ["out", "t.csv"]


@pytest.mark.usefixtures("quickly")
def test_a_task_solved_by_different_policies_counts_as_replicates(here, capsys):
    twice = pd.concat([GOOD, GOOD.assign(push=-GOOD["push"])])
    twice.to_csv("t.csv", index=False)
    assert run_fit(*COLUMNS) == 0
    said = capsys.readouterr().out
    assert "30 tasks come more than once, in 60 rows: all are kept" in said
    card = json.loads((here / "out" / "card.json").read_text("utf-8"))["table"]
    counted = [card[f"n_{one}"] for one in ("rows", "tasks", "replicates")]
    assert counted == [60, 30, 60]


@pytest.mark.usefixtures("quickly")
def test_a_fit_is_written_whole_and_replaced_only_when_told(here, capsys):
    frame = pd.concat([GOOD, GOOD[:2].assign(push=[7.0, 8.0])])
    frame.to_csv("t.csv", index=False)
    words = [*COLUMNS, "--units", "angle=deg", "--period", "angle=360"]
    assert run_fit(*words) == 0
    said = capsys.readouterr().out
    assert "2 tasks come more than once, in 4 rows: all are kept" in said
    assert "recommended" in said
    out = here / "out"
    first = {path.name: path.read_bytes() for path in out.iterdir()}
    pages = {"card.json", "report.html", "scores.csv"}
    assert {*first} == pages | {"paper.skops", "skill.skops"}
    card = json.loads(first["card.json"])
    assert card["table"]["n_replicates"] == 4
    assert card["command"].startswith("msc fit t.csv --tasks angle --policies push")
    scores = pd.read_csv(out / "scores.csv")
    assert scores["method"].tolist() == ["mean policy", "nearest neighbour"]
    assert run_fit(*words) == 2
    assert "--force replaces it" in capsys.readouterr().err
    assert run_fit(*words, "--force") == 0
    again = {path.name: path.read_bytes() for path in out.iterdir()}
    assert again == first, "to the last byte"
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    assert run_fit(*words, "--force") == 2
    assert "is no earlier fit" in capsys.readouterr().err
    assert sorted(path.name for path in here.iterdir()) == ["out", "t.csv"]


def test_a_folder_that_is_only_looked_at_is_not_made(tmp_path):
    check_folder(tmp_path / "some" / "where")
    assert not [*tmp_path.iterdir()]


def test_nothing_is_left_of_a_fit_that_cannot_be_written(fit, here, monkeypatch):
    def fail(*_, **__):
        raise OSError("full")

    monkeypatch.setattr(Path, "write_text", fail)
    with pytest.raises(OSError, match="full"):
        save_fit(fit, here / "out")
    assert not [*here.iterdir()]


def curved(n_tasks=140, seed=20_260_711):
    """Draw tasks of 0 to 2000 mm/s and 0.1 to 0.9 kg, crowded where both are small.

    A curved break, noise of a fiftieth of the spread, and thirty tasks solved twice.
    """
    rng = np.random.default_rng(seed)
    speed, load = rng.beta(1, 2, (2, n_tasks)) * [[2000], [0.8]] + [[0], [0.1]]
    again = rng.choice(n_tasks, 30, replace=False)
    speed, load = np.r_[speed, speed[again]], np.r_[load, load[again]]
    above = load > edge(speed)
    u = speed / 2000
    grip = 40 * np.cos(2 * u) + 60 * above + rng.normal(0, 0.8, len(u))
    lean = np.sin(3 * load) - 0.8 * above + rng.normal(0, 0.02, len(u))
    return pd.DataFrame({"speed": speed, "load": load, "grip": grip, "lean": lean})


def edge(speed):
    """Return the load, in kg, where another behaviour sets in."""
    return 0.25 + 0.5 * (speed / 2000) ** 2


def test_a_curved_break_of_two_columns_is_found():
    table = as_table(curved(), ("speed", "load"))
    card = fit_table(table, methods=["nearest neighbour"]).card
    assert card["table"]["n_repeated_tasks"] == 30
    jumps = card["jumps"]
    pairs = np.array(jumps["widest_jumps"])
    sides = pairs[..., 1] > edge(pairs[..., 0])
    assert jumps["n_jumps"] >= 15
    assert (sides[:, 0] != sides[:, 1]).all(), "all lead over the break"
