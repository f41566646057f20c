"""The table of the paper's section V: every system, both worlds, no empty cell."""

import ast
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from msc.data import load_dataset
from msc.plots import SECTION_V, plot_section_v, section_v_table
from msc.plots._rivals import BESIDE
from msc.study import METHODS
from msc.study._store import Trials, method_path
from msc.study._study import PROFILES, _summarise, list_sets

ROOT = Path(__file__).parents[1]
WORLDS = "free", "obstacles"
SHOWN = [*BESIDE, *(one for s in SECTION_V for one in (s.before, s.method) if one)]
NAMED = {  # in the paper
    "da Silva", "Kober", "Mülling", "Deisenroth", "Hausknecht", "Liu", "Soni",
}  # fmt: skip


@cache
def study(world):
    """Summarise what is kept of those that are shown, 24 evenly spaced tasks."""
    datasets = load_dataset(world), load_dataset(f"{world}_test")
    sets = list_sets(PROFILES["full"], datasets[0].tasks, 0)
    kept = {n: Trials.read(method_path(ROOT / "data/results", world, n)) for n in SHOWN}
    known = {name: trials for name, trials in kept.items() if trials is not None}
    own = {("even", 24): sets["even", 24]}
    return {"workspace": world, **_summarise(datasets, own, known)}


@pytest.fixture(scope="module")
def table():
    return section_v_table(*map(study, WORLDS))


def test_every_system_has_a_row_with_numbers_in_both_worlds(table):
    assert {name for name in NAMED for row in table.index if row.startswith(name)} == (
        NAMED
    )
    assert len(table) == len(NAMED)
    assert table.notna().all().all()
    numbers = table.drop(columns="here", level=0)
    assert set(numbers.columns.get_level_values(0)) == {
        "without obstacles", "with obstacles",
    }  # fmt: skip
    shares = numbers.xs("touched", axis=1, level=1)
    assert shares.map(lambda cell: bool(re.fullmatch(r"\d+%", cell))).all(axis=None)
    spans = numbers.drop(columns=["rollouts", "touched"], level=1)
    assert spans.map(lambda cell: bool(re.fullmatch(r"\S+ \[\S+, \S+\]", cell))).all(
        axis=None
    )
    rollouts = numbers.xs("rollouts", axis=1, level=1)
    assert rollouts.map(lambda cell: bool(re.fullmatch(r"none|[\d,]+", cell))).all(
        axis=None
    )


def test_those_that_execute_tell_how_often(table):
    for system in SECTION_V:
        told = table.xs("rollouts", axis=1, level=1).loc[system.name]
        executes = METHODS[system.method].group == "rollouts"
        assert (told != "none").all() == executes


@pytest.mark.parametrize("world", WORLDS)
def test_its_numbers_are_those_that_are_kept(table, world):
    title = {"free": "without obstacles", "obstacles": "with obstacles"}[world]
    for system in SECTION_V:
        kept = Trials.read(method_path(ROOT / "data/results", world, system.method))
        told = table.loc[system.name, (title, "distance at the end (cm)")].split()[0]
        mean = kept.errors["even/24/error_cm"].mean()
        assert float(told) == pytest.approx(mean, rel=6e-3)


@pytest.mark.parametrize("system", SECTION_V, ids=lambda system: system.cited)
def test_a_system_s_check_is_a_test_and_its_method_is_named_by_the_rule(system):
    file, name = system.test.split(".")
    source = (ROOT / "tests" / f"{file}.py").read_text("utf-8")
    assert name in {
        node.name for node in ast.parse(source).body
        if isinstance(node, ast.FunctionDef)
    }  # fmt: skip
    assert f"{{{system.cited}," in (ROOT / "book/references.bib").read_text("utf-8")
    assert system.method in METHODS
    if system.method.startswith("after "):
        assert re.fullmatch(r"after \w+: .+", system.method)  # and what is left
    assert max(map(len, (system.part, system.check))) <= 50  # or a page cuts it short


def test_the_figure_has_a_dot_a_training_set_and_a_mean_a_method():
    figure = plot_section_v(*map(study, WORLDS))
    labels = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert set(labels) == set(SHOWN)
    for axis, (measure, world) in zip(
        figure.axes, [(m, w) for m in ("error_cm", "excess_cost") for w in WORLDS],
        strict=True,
    ):  # fmt: skip
        lines = {}
        for line in axis.lines:
            place = -int(np.atleast_1d(line.get_ydata())[0])
            if line.get_marker() in ("o", "D"):
                lines.setdefault(labels[place], {})[line.get_marker()] = line
        cell = study(world)["cells"][0]["measures"][measure]
        assert set(lines) == set(SHOWN)
        for name, drawn in lines.items():
            sets = drawn["o"].get_xdata()
            np.testing.assert_array_equal(sets, cell[name]["per_repetition"])
            few = METHODS[name].sets == "few"
            assert len(sets) == (
                3 if few else 10 if METHODS[name].sets == "some" else 15
            )
            hollow = drawn["D"].get_markerfacecolor() == "white"
            assert hollow == name.startswith("after ")


def test_what_was_not_run_is_said():
    bare = {**study("free"), "cells": [{
        **study("free")["cells"][0],
        "measures": {m: {} for m in ("error_cm", "excess_cost", "touched")},
    }]}  # fmt: skip
    numbers = section_v_table(bare).drop(columns="here", level=0)
    assert (numbers.drop(columns="rollouts", level=1) == "not run").all(axis=None)
