"""The examples of the page on extending run as they stand."""

import re
import runpy
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from sklearn.kernel_ridge import KernelRidge

from msc import find_jumps
from msc.search import SearchOptions, search_tasks
from msc.study import _methods as methods

PAGE = (Path(__file__).parents[1] / "book" / "extend.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE, re.M | re.S)
DIFF = re.search(r"^```diff\n--- (\S+)\n(.*?)^```", PAGE, re.M | re.S)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Run all blocks one after another, as a reader would; but many tasks briefly."""
    script = tmp_path_factory.mktemp("extend") / "blocks.py"
    script.write_text("\n\n".join(BLOCKS), encoding="utf-8")
    brief = SearchOptions(max_evaluations=90, max_sweeps=0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "msc.search.search_tasks",
            lambda plan: search_tasks(replace(plan, options=brief)),
        )
        return runpy.run_path(str(script))


def test_the_charts_break_where_the_policies_jump(ran):
    breaks = np.flatnonzero(np.diff(ran["charts"].labels_))
    np.testing.assert_array_equal(breaks, find_jumps(ran["X"], ran["y"]))
    assert len(breaks) == 1


def test_an_added_method_is_part_of_every_result(ran):
    experiment, name = ran["experiment"], "weighted neighbours"
    assert name in experiment.mse_summary().index
    assert name in experiment.executed_summary().index
    wide = experiment.executed_by_method("excess_cost")
    assert list(wide) == [*ran["rivals"], name]


def test_the_searched_workspace_is_the_one_told(ran):
    assert ran["world"].name == "one post"
    assert len(ran["world"].circles) == 1
    assert (ran["table"]["distance_m"] < 0.01).all()
    assert ran["rollout"].error < 0.1


def test_the_change_of_the_list_of_methods_fits_it(monkeypatch):
    """Make the change that the page shows, and ask the changed module."""
    source = Path(methods.__file__).read_text(encoding="utf-8")
    assert DIFF[1] == "msc/study/_methods.py"
    for hunk in DIFF[2].split("@@\n")[1:]:
        lines = hunk.splitlines()
        before = "\n".join(line[1:] for line in lines if line[:1] != "+")
        after = "\n".join(line[1:] for line in lines if line[:1] != "-")
        assert source.count(f"\n{before}\n") == 1, before
        source = source.replace(f"\n{before}\n", f"\n{after}\n")
    changed = ModuleType("changed")
    monkeypatch.setitem(sys.modules, "changed", changed)  # dataclasses ask for it
    exec(source, vars(changed))
    assert set(changed.METHODS) == {*methods.METHODS, "kernel ridge"}
    assert isinstance(changed.build_method("kernel ridge"), KernelRidge)
