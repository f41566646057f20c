"""Worlds: the rules that draw them, what is asked of them, and what is kept."""

import json
import math
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import msc.worlds._jumps
import msc.worlds._search
from msc import Workspace
from msc.claims import load_claims
from msc.cli import main
from msc.data import load_dataset, read_package
from msc.robot import (
    Arm,
    TaskRange,
    clearance,
    forward_kinematics,
    read_world,
)
from msc.search import SearchOptions, SweepPlan, cost, search_policy
from msc.study import MEASURES, METHODS
from msc.worlds import (
    FAMILIES,
    VARIANTS,
    bisect_world,
    compare_engines,
    draw_worlds,
    execute_elsewhere,
    family_of,
    list_tasks,
    list_worlds,
    load_choices,
    load_questions,
    locate_jumps,
    make_worlds,
    refine_steps,
    resample,
    search_worlds,
    study_worlds,
)
from msc.worlds._questions import load_kin
from msc.worlds._study import ALWAYS, CHOICES, CHOICES_ASKED, _list_methods
from press import checksum

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "data" / "worlds"
DRAWN = {world.name: world for world in draw_worlds(0)}
SEARCHED = sorted(path.stem.removesuffix("_test") for path in FOLDER.glob("*_test.csv"))


# Rules


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10_000))
def test_layouts_keep_the_rule(seed):
    world = next(iter(draw_worlds(seed, 1)))
    assert 1 <= len(world.circles) <= 5
    home = forward_kinematics(world.home, world.link_lengths)
    for number, one in enumerate(world.circles):
        away = math.hypot(one.x, one.y)
        assert 0.5499 < away < 0.8001
        assert 0.0399 < one.radius < 0.0701
        assert clearance(home, one) - one.radius > 0.0298
        for other in world.circles[:number]:
            apart = math.hypot(one.x - other.x, one.y - other.y)
            assert apart - one.radius - other.radius > 0.0298


@settings(max_examples=4, deadline=None)
@given(st.integers(0, 1000))
def test_arms_keep_the_rule(seed):
    arms = [w for w in draw_worlds(seed) if family_of(w.name).name == "arm"]
    assert len(arms) == 6
    for world in arms:
        assert sum(world.link_lengths) == pytest.approx(1.0, abs=1e-12)
        start = forward_kinematics(world.home, world.link_lengths)[-1]
        assert not world.circles
        assert (abs(start) > world.goal_radius - 0.01).all()  # goal minus start


def test_there_are_as_many_worlds_of_each_family_as_it_says():
    names = [family_of(name).name for name in DRAWN]
    assert {name: names.count(name) for name in FAMILIES} == {
        family.name: family.count for family in FAMILIES.values()
    }


def test_priced_annulus_and_mujoco_worlds_are_layouts_but_for_one_thing():
    for k in (1, 3, 23):
        layout = DRAWN[f"layout{k:02}"]
        priced = DRAWN[f"priced{k:02}"]
        assert priced.cost.contact == 0.01
        assert replace(priced, name=layout.name, cost=layout.cost) == layout
    annulus = DRAWN["annulus2"]
    assert annulus.task_names == ("task_deg", "radius_m")
    assert replace(annulus, name="layout02", further=()) == DRAWN["layout02"]
    other = DRAWN["mujoco01"]
    assert other.physics.engine == "mujoco"
    assert other.circles == DRAWN["layout01"].circles


def test_variants_differ_from_their_base_in_one_part():
    for name in VARIANTS:
        base, world = Workspace.obstacles(), DRAWN[f"obstacles-{name}"]
        parts = "home", "cut_deg", "cost", "dmp", "controller", "physics"
        changed = [p for p in parts if getattr(world, p) != getattr(base, p)]
        wanted = {"base": 0, "quick": 2, "slow": 2}.get(name, 1)
        assert len(changed) == wanted, name
        assert world.circles == base.circles


@pytest.mark.parametrize("name", ["layout", "lay01", "free", "free-fast", ""])
def test_a_name_of_no_family_is_refused(name):
    with pytest.raises(
        ValueError, match=rf"world='{name}' is of no family; wanted lay"
    ):
        family_of(name)


def test_worlds_are_not_written_over_others(tmp_path, monkeypatch):
    monkeypatch.setattr("msc.worlds._draw._measure_cut", lambda _: 12.5)
    names = make_worlds(tmp_path, seed=3, count=2)
    texts = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert read_world(tmp_path / "free-home.toml").cut_deg == 12.5
    assert make_worlds(tmp_path, seed=3, count=2) == names  # the same again
    with pytest.raises(ValueError, match=r"layout01\.toml is another world"):
        make_worlds(tmp_path, seed=4, count=2)
    assert texts == {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(ValueError, match="count=0; wanted at least 1"):
        make_worlds(tmp_path, seed=4, count=0)


# What is committed


@pytest.mark.parametrize("name", DRAWN)
def test_the_files_are_those_that_are_drawn(name):
    found = read_world(FOLDER / f"{name}.toml")
    assert replace(found, cut_deg=DRAWN[name].cut_deg) == DRAWN[name]
    if found.home == Workspace.home:
        assert found.cut_deg == DRAWN[name].cut_deg


@pytest.mark.parametrize("name", SEARCHED)
def test_tables_are_of_their_worlds(name):
    package = {one["path"]: one for one in read_package(FOLDER)["resources"]}
    world = read_world(FOLDER / f"{name}.toml")
    for table, tasks in zip((name, f"{name}_test"), list_tasks(world), strict=True):
        assert package[f"{table}.csv"]["world"] == checksum(FOLDER / f"{name}.toml")
        data = load_dataset(FOLDER / f"{table}.csv")
        kept = data.table[list(world.task_names)].to_numpy().tolist()
        assert kept == sorted(list(np.atleast_1d(task)) for task in tasks)


@pytest.mark.parametrize("name", SEARCHED)
def test_stored_policies_do_again_what_is_stored(name):
    world = read_world(FOLDER / f"{name}.toml")
    if world.physics.engine == "mujoco":
        pytest.importorskip("mujoco")
    data = load_dataset(FOLDER / f"{name}.csv")
    some = slice(None, None, max(1, len(data.table) // 9))
    tasks = data.table[list(world.task_names)].to_numpy()[some]
    with Arm(world) as arm:
        rollouts = arm.execute_many(
            data.policies[some], tasks if world.further else tasks[:, 0]
        )
    found = [cost(one, world.cost) for one in rollouts]
    np.testing.assert_allclose(found, data.table["cost"][some], rtol=1e-6)


def test_every_claim_is_asked_of_worlds_or_not_asked_for_a_reason():
    questions = load_questions(FOLDER / "asked.yml")
    told = yaml.safe_load((FOLDER / "asked.yml").read_text("utf-8"))
    asked = {claim for one in questions for claim in one.claims}
    claims = {claim.id for claim in load_claims(ROOT / "book" / "claims.yml")}
    assert asked | set(told["not_asked"]) == claims
    assert not asked & set(told["not_asked"])
    assert told["order"] == [name for name in FAMILIES if name != "variant"]
    again = [
        one for asked in load_choices(FOLDER / "asked.yml").values() for one in asked
    ]
    assert len(again) == len(told["choices"]) * len(told["choices_asked"])
    for one in (*questions, *again):
        assert set(one.families) <= set(FAMILIES)
        if one.measure != "jumps":
            assert one.measure in MEASURES
            assert {one.method, *one.baselines} <= {*METHODS, "cost"}


# Searching them


@pytest.fixture
def small(tmp_path, monkeypatch):
    few = replace(FAMILIES["layout"], n_train=2, n_test=2)
    monkeypatch.setitem(FAMILIES, "layout", few)
    monkeypatch.setattr(msc.worlds._search, "_OFFSETS_DEG", {2: 20.0})
    brief = SearchOptions(apart=0.3, max_evaluations=9, max_sweeps=0)
    monkeypatch.setattr(msc.worlds._search, "OPTIONS", brief)
    plan = partial(SweepPlan, n_starts=1)
    monkeypatch.setattr(msc.worlds._search, "SweepPlan", plan)
    monkeypatch.setattr("msc.worlds._draw._measure_cut", lambda _: 12.5)
    make_worlds(tmp_path, seed=0, count=2)
    return tmp_path


@pytest.fixture
def would_search(monkeypatch):
    """Tell whether the first world would be searched: nothing is there to do it."""

    def ask(folder, **options):
        monkeypatch.setattr(msc.worlds._search, "search_tasks", None)
        with pytest.raises(TypeError, match="'NoneType' object is not callable"):
            search_worlds(folder, ["layout01"], **options)
        return True

    return ask


def test_worlds_are_searched_once(small, would_search):
    names = ["layout01", "layout02"]
    assert list_worlds(small)[:2] == names
    with pytest.raises(ValueError, match="no world is searched; do so: msc worlds sea"):
        list_worlds(small, searched=True)
    assert search_worlds(small, names) == names
    assert list_worlds(small, searched=True) == names
    before = {path: path.read_bytes() for path in small.iterdir()}
    assert search_worlds(small, names) == []
    (small / "layout02_test.csv").unlink()
    assert search_worlds(small, names) == ["layout02"]
    assert before == {path: path.read_bytes() for path in small.iterdir()}
    assert would_search(small, seed=1)


def test_a_world_that_has_changed_is_searched_again(small, would_search):
    search_worlds(small, ["layout01"])
    path = small / "layout01.toml"
    path.write_text(path.read_text("utf-8") + "\n[cost]\nenergy = 0.01\n", "utf-8")
    assert would_search(small)


def test_what_is_amiss_is_told_before_any_search(small, monkeypatch):
    monkeypatch.setattr(msc.worlds._search, "search_tasks", None)
    with pytest.raises(ValueError, match=r"layout99\.toml: cannot be read"):
        search_worlds(small, ["layout01", "layout99"])
    (small / "layout02.toml").write_text("[arm]\nlinks = 3\n", "utf-8")
    with pytest.raises(ValueError, match=r"layout02\.toml: \[arm\] has an unknown key"):
        search_worlds(small, ["layout01", "layout02"])
    with pytest.raises(ValueError, match="has no worlds; make some: msc worlds make"):
        list_worlds(small / "elsewhere")


def test_goals_in_obstacles_are_left_out_and_no_test_task_is_trained_on():
    for name, world in DRAWN.items():
        train, test = list_tasks(world)
        family = family_of(name)
        assert (len(train), len(test)) == (family.n_train, family.n_test)
        assert not set(train) & set(test)
    wall = Workspace(name="layout01", circles=((0.47, 0.0, 0.01),))
    train, _ = list_tasks(wall)
    goals = wall.target(train)
    assert 60 < len(train) < 72
    assert (np.hypot(goals[:, 0] - 0.47, goals[:, 1]) > 0.03).all()


# Jumps


def told(world, n_tasks, policy):
    """Searched tasks of a world whose policies are known."""
    tasks = np.linspace(0, 360, n_tasks, endpoint=False)
    if world.further:
        rng = np.random.default_rng(0)
        low, high = world.further[0][1:]
        tasks = np.stack(
            [rng.uniform(0, 360, n_tasks), rng.uniform(low, high, n_tasks)], 1
        )
    columns = tasks.T.reshape(-1, n_tasks)
    frame = pd.DataFrame(dict(zip(world.task_names, columns, strict=True)))
    points = np.deg2rad(tasks[:, None]) if tasks.ndim == 1 else tasks * [np.pi / 180, 1]
    policies = np.array([policy(task) for task in tasks])
    return SimpleNamespace(table=frame, tasks=points, policies=policies)


def searching(policy):
    return lambda world, tasks, **_: [
        SimpleNamespace(policy=np.asarray(policy(task))) for task in tasks
    ]


def test_a_leap_is_a_jump_and_what_is_steep_is_none(monkeypatch):
    def policy(angle):
        steep = 6 * math.tanh((angle - 122.5) / 1.0)
        return [(5.0 if angle % 360 >= 201.3 else 0.0) + steep, math.sin(angle / 57)]

    monkeypatch.setattr(msc.worlds._jumps, "search_policies", searching(policy))
    found = bisect_world(Workspace(name="layout01"), told(Workspace(), 72, policy))
    by_start = {one["between_deg"][0]: one for one in found["jumps"]}
    assert by_start[200.0]["is_jump"]
    low, high = by_start[200.0]["located_deg"]
    assert low <= 201.3 <= high
    assert high - low < 1 / 8
    assert not by_start[120.0]["is_jump"]
    assert by_start[355.0]["is_jump"]  # the cut


def test_several_jumps_in_a_step_are_one_jump_at_least(monkeypatch):
    def policy(angle):
        return [
            4.0 * sum(angle >= at for at in (50.7, 51.9, 53.1)) - 12 * (angle > 180)
        ]

    monkeypatch.setattr(msc.worlds._jumps, "search_policies", searching(policy))
    found = bisect_world(Workspace(name="layout01"), told(Workspace(), 72, policy))
    assert [one["is_jump"] for one in found["jumps"] if one["between_deg"][0] == 50]


def test_of_many_large_edges_a_sample_is_bisected(monkeypatch):
    world = Workspace(name="annulus1", further=(TaskRange("radius_m", 0.3, 0.45),))

    def policy(task):
        angle, radius = task
        return [10.0 * (angle > 100 + 400 * radius), math.cos(angle / 57), radius]

    monkeypatch.setattr(msc.worlds._jumps, "search_policies", searching(policy))
    found = bisect_world(world, told(world, 300, policy))
    assert found["large"] > 10
    assert sum(found["pieces"]) == 300
    assert found["pieces"][0] < 250
    assert len(found["bisected"]) == min(20, found["large"])
    assert all(one["is_jump"] for one in found["bisected"])


# Which methods are tried where


def test_choices_of_ours_are_tried_where_they_are_asked():
    tried = {name: _list_methods(DRAWN[name], 24, full=False) for name in DRAWN}
    kin = load_kin(FOLDER / "asked.yml")
    assert set(kin.values()) == set(CHOICES_ASKED)
    for name, methods in tried.items():
        asked = family_of(name).name in kin.values()
        assert set(CHOICES) <= set(methods) if asked else methods == ALWAYS
    world = DRAWN["layout09"]
    assert _list_methods(world, 12, full=True) == ALWAYS
    full = _list_methods(world, 24, full=True)
    assert {"gradient boosting", *ALWAYS, *CHOICES} < set(full)
    rollouts = {n for n, method in METHODS.items() if method.group == "rollouts"}
    assert not rollouts & set(full)
    assert rollouts <= set(_list_methods(DRAWN["layout02"], 24, full=True))


# The other engine


def test_only_searched_worlds_are_executed_elsewhere(small):
    with pytest.raises(ValueError, match=r"layout01: .* searched: msc worlds search"):
        compare_engines(small, small / "engines.json", ["layout01"])
    assert not (small / "engines.json").exists()


def test_without_contact_both_engines_do_the_same():
    pytest.importorskip("mujoco")
    world = Workspace.free()
    found = search_policy(world, 200, seed=1, n_starts=1)
    data = SimpleNamespace(
        table=pd.DataFrame({"task_deg": [200.0]}),
        policies=found.policy[None],
    )
    told = execute_elsewhere(world, data)
    assert told["joints_rad"][0] < 1e-12
    assert told["cost"] == told["cost_elsewhere"]


def test_finer_steps_are_taken_of_movements_that_touch():
    pytest.importorskip("mujoco")
    world = read_world(FOLDER / "layout02.toml")
    data = load_dataset(FOLDER / "layout02.csv")
    few = SimpleNamespace(table=data.table[::6], policies=data.policies[::6])
    told, whole = refine_steps(world, few, (4, 8)), execute_elsewhere(world, few)
    met = np.logical_and(whole["touched"], whole["touched_elsewhere"])
    assert met.any()
    assert told["pybullet"]["cost"][0] == list(np.array(whole["cost"])[met])
    other = np.array(whole["impulse_n_s_elsewhere"])
    assert told["mujoco"]["impulse_n_s"][0] == list(other[met])
    assert told["mujoco"]["cost"][1] != told["mujoco"]["cost"][0]


# Over worlds


def test_resampling_covers_the_mean_as_often_as_it_says():
    rng = np.random.default_rng(0)
    hits = []
    for _ in range(300):
        low, high = resample(rng.normal(1.0, 1.0, 6))
        hits.append(low <= 1.0 <= high)
    assert 0.92 <= np.mean(hits) <= 0.99  # plain percentiles: 0.86


def test_verdicts_are_those_of_what_is_committed():
    path = ROOT / "data" / "results" / "worlds" / "verdicts.json"
    if not path.is_file():
        pytest.skip("the worlds are being studied")
    from msc.worlds import judge_worlds  # noqa: PLC0415

    found = judge_worlds(FOLDER, path.parent)
    assert json.loads(json.dumps(found)) == json.loads(path.read_text("utf-8"))


def test_results_are_made_anew_when_their_tables_change(tmp_path, monkeypatch):
    for end in (".toml", ".csv", "_test.csv"):
        shutil.copy(FOLDER / f"layout01{end}", tmp_path)
    shutil.copy(FOLDER / "datapackage.json", tmp_path)
    monkeypatch.setattr("msc.worlds._jumps.bisect_world", lambda *_: {"jumps": []})
    monkeypatch.setattr("msc.worlds._study.study_world", lambda *_: {"cells": []})
    for work in (locate_jumps, study_worlds):
        assert work(tmp_path, tmp_path / "new", ["layout01"]) == ["layout01"]
        assert work(tmp_path, tmp_path / "new", ["layout01"]) == []
    with pytest.raises(ValueError, match=r"has no layout02.toml; wanted the name of"):
        locate_jumps(tmp_path, tmp_path, ["layout02"])
    shutil.copy(FOLDER / "layout02.toml", tmp_path)
    with pytest.raises(ValueError, match=r"no tables of it, .* msc worlds search lay"):
        locate_jumps(tmp_path, tmp_path, ["layout02"])
    shutil.copy(FOLDER / "layout02.toml", tmp_path / "layout01.toml")
    with pytest.raises(ValueError, match=r"or of another world; wanted them searched"):
        study_worlds(tmp_path, tmp_path, ["layout01"])
    comment = (FOLDER / "layout01.toml").read_text("utf-8") + "# another\n"
    (tmp_path / "layout01.toml").write_text(comment, "utf-8")
    package = json.loads((tmp_path / "datapackage.json").read_text("utf-8"))
    for one in package["resources"]:
        one["world"] = checksum(tmp_path / "layout01.toml")
    (tmp_path / "datapackage.json").write_text(json.dumps(package), "utf-8")
    for work in (locate_jumps, study_worlds):
        assert work(tmp_path, tmp_path / "new", ["layout01"]) == ["layout01"]


# One's own, by command

MINE = """
name = "mine"
[tasks]
radius = [0.3, 0.45]
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(MINE, "utf-8")
    return ["--workspace", "mine.toml"]


def run(*words):
    return main([str(word) for word in words])


def test_one_s_own_world_is_searched_audited_and_drawn(mine, capsys):
    brief = ["--set", "max_evaluations=20", "--set", "max_sweeps=0"]
    assert run("search", *mine, "--tasks", 5, *brief, "--out", "mine.csv") == 0
    tasks, _, table = load_dataset("mine.csv")
    assert tasks.shape == (5, 2)
    np.testing.assert_array_equal(np.rad2deg(tasks[:, 0]).round(3), table["task_deg"])
    np.testing.assert_array_equal(tasks[:, 1], table["radius_m"])
    (resource,) = read_package(Path())["resources"]
    assert " --tasks 5 --skip 0 " in resource["command"]
    how = ["--skip", 5, "--guide", "mine.csv", *brief, "--out", "more.csv"]
    assert run("search", *mine, "--tasks", 2, *how) == 0
    more = load_dataset("more.csv")
    assert not {*more.task_deg} & {*table["task_deg"]}
    assert (
        run("audit", "mine.csv", *mine, "--sample", 1, *brief, "--out", "a.json") == 0
    )
    audit = json.loads(Path("a.json").read_text("utf-8"))
    assert audit["executed"]["identical"] == 5
    assert "jumps" not in audit
    assert run("render", *mine, "--task", 120, 0.4, "--out", "a.png") == 0
    assert "the policy searched for" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["render", "--task", "120", "--out", "a.png"], "--task has 1 numbers; wanted"),
        (
            ["search", "--offset", "3", "--out", "a.csv"],
            "--offset=3.0: tasks of 'mine'",
        ),
        (["search", "--guide", "free", "--out", "a.csv"], "the table lacks radius_m"),
        (["render", "--task", "1", "9", "--out", "a.png"], "mine.csv' is not there"),
    ],
)
def test_what_does_not_fit_one_s_world_is_told(mine, words, message, capsys):
    assert run(words[0], *mine, *words[1:]) == 2
    assert message in capsys.readouterr().err
    assert [path.name for path in Path().iterdir()] == ["mine.toml"]


def test_tasks_of_one_number_are_not_skipped(capsys, tmp_path):
    out = tmp_path / "a.csv"
    assert run("search", "--skip", 3, "--tasks", 4, "--out", out) == 2
    assert "--skip=3: tasks of 'free' have task_deg" in capsys.readouterr().err


def test_worlds_are_made_and_searched_by_command(small, capsys):
    assert run("worlds", "search", "layout01", "--folder", small, "--jobs", 1) == 0
    assert (small / "layout01_test.csv").is_file()
    assert run("worlds", "search", "layout77", "--folder", small) == 2
    assert "layout77.toml: cannot be read" in capsys.readouterr().err
