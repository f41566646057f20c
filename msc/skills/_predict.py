"""New tasks in a file -> their policies in another."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sklearn.utils import gen_batches
from tqdm import tqdm

from msc.skills._digits import format_lines
from msc.skills._skill import TableSkill
from msc.skills._table import check_units, read_columns
from msc.skills._trees import quicken
from press import replace_file

Array = NDArray[np.float64]

_TASKS = 4096  # at once: as many as a skill takes at once, so that rounding is the same
_TASK, _NUMBER = "%.15g", "%.9g"


def predict_table(
    skill: TableSkill,
    new: Path,
    out: Path,
    *,
    units: Mapping[str, str] | None = None,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Predict the policies of a file of tasks.

    Parameters
    ----------
    skill : TableSkill
        Fitted to a table with named columns.
    new : Path
        CSV or Parquet, see `read_table`, with the task columns; others are ignored.
    out : Path
        CSV, written whole or not at all: a row a task, with its columns; each policy
        column to nine digits, all in its unit: named ``…_std``, its standard deviation,
        blank if the method has none; named ``…_band90``, half the width of the band
        that holds nine in ten policies, see `TableSkill.predict_band`, blank if it is
        not known; the ``chart``; ``gate_probability``, see `TableSkill.predict_chart`;
        ``doubtful``, 1 or 0, see `TableSkill.find_doubtful`, blank if that is not
        known; and in ``outside`` the task columns that are outside the range of the
        training tasks.
    units : mapping of str to str, optional
        Units of task columns in the file.
    jobs : int, default=1
        Threads, each of which takes some tasks after the others; the bytes do not
        depend on them.
    progress : bool, default=False
        Whether to show a bar with an estimate on standard error, after two seconds.

    Returns
    -------
    dict
        ``"n_tasks"`` and, of these, ``"n_outside"`` and ``"n_doubtful"``.

    Raises
    ------
    ValueError
        If columns are missing, hold anything but finite numbers, or have other units
        than the skill learned.

    Notes
    -----
    Of 100,000 tasks with three numbers and policies with twelve, trees and neighbours
    take seconds. Gaussian processes take several times longer, most of it for their
    deviations: each asks for products of a vector with matrices of the kernel's rank,
    which of spread-out tasks is hundreds, and once more for each length scale.
    """
    names = [*getattr(skill, "feature_names_in_", [])]
    policies = skill.policy_names_
    if not names or policies is None:
        raise ValueError("the skill has no names of columns; wanted one of msc fit")
    _compare_units(units or {}, skill.units or {}, names)
    tasks = read_columns(new, names)
    found = _ask(skill, tasks, jobs, progress)
    means, stds, charts, shares, halves, doubtful, outside = found
    columns, formats = [*tasks.to_numpy().T], [_TASK] * len(names)

    def add(column: NDArray[Any], form: str, known: bool = True) -> None:
        """Write a column, blank if it is not known."""
        columns.extend([column] if known else [])
        formats.append(form if known else "")

    has_band = [bool(np.isfinite(one).all()) for one in halves.T]
    for k, (mean, std) in enumerate(zip(_columns(means), _columns(stds), strict=True)):
        add(mean, _NUMBER)
        add(std, _NUMBER, skill.has_std)
        add(halves[:, k], _NUMBER, has_band[k])
    add(charts, "%d")
    add(shares, "%.3g")
    add(doubtful, "%d", all(has_band))
    ends = "", "_std", "_band90"
    header = [*names, *(f"{name}{end}" for name in policies for end in ends)]
    header += ["chart", "gate_probability", "doubtful", "outside"]
    words = _name_outside(outside, names)
    lines = _format(np.column_stack(columns), words, formats, jobs)
    replace_file(out, _line(header) + lines)
    return {
        "n_tasks": len(tasks),
        "n_outside": int(outside.any(axis=1).sum()),
        "n_doubtful": int(doubtful.sum()),
    }


def _columns(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a row a policy column."""
    return np.atleast_2d(values.T)


def _ask(
    skill: TableSkill, tasks: pd.DataFrame, jobs: int, progress: bool
) -> list[NDArray[Any]]:
    """Return all that a skill tells: means, deviations, charts, shares, doubts."""
    quick = copy(skill)
    quick.model_ = quicken(skill.model_, len(tasks))

    def ask(some: slice) -> tuple[NDArray[Any], ...]:
        X = tasks.iloc[some]
        told = quick.predict(X, return_std=True), skill.predict_chart(X)
        return *told[0], *told[1], *skill.predict_doubt(X), skill.find_outside(X)

    batches, found = [*gen_batches(len(tasks), _TASKS)], []
    with (
        ThreadPoolExecutor(jobs) as pool,
        tqdm(total=len(tasks), unit=" tasks", delay=2, disable=not progress) as bar,
    ):
        for one in pool.map(ask, batches):
            found.append(one)
            bar.update(len(one[0]))
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def _format(
    numbers: Array, words: Sequence[str], formats: Sequence[str], jobs: int
) -> str:
    """Write rows, numbers as `formats` say, and a word at the end."""

    def write(some: slice) -> str:
        lines = format_lines(numbers[some], formats)
        pairs = zip(lines, words[some], strict=True)
        return "".join([f"{line},{word}\n" for line, word in pairs])

    with ThreadPoolExecutor(jobs) as pool:
        return "".join(pool.map(write, gen_batches(len(numbers), _TASKS)))


def _name_outside(outside: NDArray[np.bool_], names: Sequence[str]) -> list[str]:
    """Return for each task the columns that are outside, as a cell."""
    cells = [""] * len(outside)
    for row in np.flatnonzero(outside.any(axis=1)):
        which = [
            name for name, is_out in zip(names, outside[row], strict=True) if is_out
        ]
        cells[row] = _line([" and ".join(which)])[:-1]
    return cells


def _line(cells: Sequence[str]) -> str:
    """Write a line of words."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _compare_units(
    given: Mapping[str, str], known: Mapping[str, str], names: Sequence[str]
) -> None:
    """Refuse units other than the skill's."""
    check_units(given)
    for name, unit in given.items():
        if name not in names:
            raise ValueError(
                f"units: the skill has no task column {name!r}; wanted some of {names}"
            )
        if name in known and unit != known[name]:
            raise ValueError(
                f"{name!r} is in {unit}, but the skill learned it in {known[name]}; "
                "wanted it converted"
            )
