"""Fits that take long say so, others and those without a terminal do not."""

import io
import sys

import numpy as np
import pytest
import tqdm.std
from sklearn.base import BaseEstimator, RegressorMixin

import msc.study.rivals._crkr
from msc import CrKR, ParameterizedSkill

clock = [0.0]


class Slow(RegressorMixin, BaseEstimator):
    """Takes its seconds on a clock of our own."""

    def __init__(self, seconds=0.0):
        self.seconds = seconds

    def fit(self, X, y):
        clock[0] += self.seconds
        return self

    def predict(self, X):
        return np.zeros(len(X))


class Screen(io.StringIO):
    def __init__(self, is_terminal):
        super().__init__()
        self.is_terminal = is_terminal

    def isatty(self):
        return self.is_terminal


@pytest.fixture
def screen(monkeypatch):
    def set_up(is_terminal=True):
        screen = Screen(is_terminal)
        monkeypatch.setattr(sys, "stderr", screen)
        return screen

    monkeypatch.setattr(tqdm.std, "time", lambda: clock[0])
    return set_up


def fit(n_tasks, seconds, verbose=None):
    skill = ParameterizedSkill(None, regressor=Slow(seconds), verbose=verbose)
    return skill.fit(np.linspace(0, 6, n_tasks)[:, None], np.ones((n_tasks, 6)))


def test_a_long_fit_tells_how_far_it_is_and_how_long_it_will_take(screen):
    shown = screen()
    fit(24, seconds=1.5)
    lines = shown.getvalue().split("\r")
    assert "fit to 24 tasks:  33%" in shown.getvalue()  # after 3 s, not after 1.5
    assert "17%" not in shown.getvalue()
    assert "2/6 [00:03<00:05,  1.50s/ regressions]" in lines[1]
    assert not "".join(lines[-2:]).strip()  # and the bar is gone


def test_a_fit_to_many_tasks_says_so_before_its_first_regression_is_done(screen):
    shown = screen()
    fit(301, seconds=20.0)
    assert shown.getvalue().startswith("\rfit to 301 tasks:   0%")


@pytest.mark.parametrize(
    ("n_tasks", "seconds", "is_terminal", "verbose"),
    [
        (24, 0.3, True, None),  # 1.8 s in all
        (24, 0.3, False, True),
        (301, 20.0, False, None),  # a chapter, a log
        (301, 20.0, True, False),
    ],
)
def test_nothing_is_said_otherwise(screen, n_tasks, seconds, is_terminal, verbose):
    shown = screen(is_terminal)
    fit(n_tasks, seconds, verbose)
    assert shown.getvalue() == ""


def test_who_asks_is_told_without_a_terminal_too(screen):
    shown = screen(is_terminal=False)
    fit(24, seconds=3.0, verbose=True)
    assert "fit to 24 tasks:" in shown.getvalue()
    with pytest.raises(ValueError, match="'verbose' parameter of ParameterizedSkill"):
        fit(24, seconds=0.0, verbose="loud")


class Halves(BaseEstimator):
    def fit_predict(self, X):
        return np.arange(len(X)) < len(X) // 2


@pytest.mark.parametrize("n_tasks", [24, 302])
def test_the_fit_of_the_gate_is_told(screen, n_tasks):
    shown = screen(is_terminal=False)
    parts = {"gate": Slow(5.0), "regressor": Slow()}
    skill = ParameterizedSkill(Halves(), **parts, verbose=True)
    skill.fit(np.linspace(0, 6, n_tasks)[:, None], np.ones((n_tasks, 2)))
    assert f"fit to {n_tasks} tasks" in shown.getvalue()
    assert "1/5 [00:05<00:20,  5.00s/ fits]" in shown.getvalue()
    assert ("0/5" in shown.getvalue()) == (n_tasks > 300)
    assert skill.gate_.seconds == 5.0
    assert [len(dims) for dims in skill.regressors_] == [2, 2]


def test_tuning_tells_too(screen, monkeypatch):
    def slow(*arguments, **options):
        clock[0] += 5.0
        return minimize(*arguments, **options)

    minimize = msc.study.rivals._crkr.minimize
    monkeypatch.setattr(msc.study.rivals._crkr, "minimize", slow)
    X = np.linspace(0, 6, 12)[:, None]
    shown = screen()
    CrKR(tune=True).fit(X, np.sin(X))
    assert "1/3 [00:05<00:10,  5.00s/ starts of the search]" in shown.getvalue()
    quiet = screen(is_terminal=False)
    CrKR(tune=True).fit(X, np.sin(X))
    assert quiet.getvalue() == ""
