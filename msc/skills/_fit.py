"""From a table to a skill, with a card that says what it is worth."""

from __future__ import annotations

import json
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits
from tqdm import tqdm

from msc._parallel import open_workers
from msc.estimates import Estimate, six_digits
from msc.skills._bands import Doubt, judge_doubt, leave_out, part_alone
from msc.skills._blocks import N_FOLDS, make_blocks
from msc.skills._choose import (
    Comparison,
    average,
    compare_methods,
    exceed,
    is_nested,
    plan_fits,
)
from msc.skills._held_out import judge_chosen
from msc.skills._methods import METHODS, MOST_NUMBERS, PAPER
from msc.skills._saved import load_skops, skill_bytes, versions
from msc.skills._skill import TableSkill
from msc.skills._structure import describe_charts, find_structure
from msc.skills._table import Table

MAX_TASKS = {"quick": 500, "full": 1000}
"""By profile: tasks that methods other than neighbours and trees learn from."""

CARD, SKILL, OURS, SCORES = "card.json", "skill.skops", "paper.skops", "scores.csv"
REPORT = "report.html"
FILES = {CARD, SKILL, OURS, SCORES, REPORT}


@dataclass(frozen=True)
class Fit:
    """What became of a table.

    Attributes
    ----------
    skill : TableSkill
        The recommended one, fitted to the whole table.
    paper : TableSkill
        The paper's: one Gaussian process a chart and policy column.
    card : dict
        What was read, found and measured; fit for JSON.
    """

    skill: TableSkill
    paper: TableSkill
    card: dict[str, Any]

    @property
    def scores(self) -> pd.DataFrame:
        """Errors of all methods, a row each, as the card has them."""
        return pd.DataFrame(self.card["methods"])


def fit_table(
    table: Table,
    *,
    profile: str = "quick",
    seed: int = 0,
    jobs: int = 1,
    methods: Sequence[str] | None = None,
    progress: bool = False,
    command: str = "",
) -> Fit:
    """Compare methods on a table of solved tasks; fit the best, and the paper's.

    Parameters
    ----------
    table : Table
        What `read_table` read.
    profile : {"quick", "full"}
        From how many tasks methods other than neighbours and trees learn, where there
        are more: 500 or 1000.
    seed : int, default=0
        Seed of every draw.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    methods : sequence of str, optional
        Which of `METHODS` to compare with the mean policy; by default all that apply:
        "CrKr" needs costs, interpolation at most four task columns.
    progress : bool, default=False
        Whether to show a bar with an estimate on standard error.
    command : str, optional
        For the card: what was asked.

    Returns
    -------
    Fit
        Two skills and the card.

    Raises
    ------
    ValueError
        If the profile or a method is unknown, or the paper's method cannot be fitted.

    Notes
    -----
    An error is the mean squared error of policies, with each policy column brought to
    unit spread over the whole table: otherwise the column with the largest numbers, a
    matter of units, would decide alone. It is measured on blocks of neighbouring tasks,
    none of which was in the fit: of a single row left out, the neighbours, or its own
    replicate, would give the answer away. The blocks are dealt into five folds.

    Of all whose error is not above the least for certain, by the interval of their
    difference or of their ratio, the simplest is recommended, in the order of
    `METHODS`; that may be the mean policy.
    The error of the recommendation is that of making it: each fold is predicted by what
    the other folds recommend. Methods are fitted without each fold, and without each
    pair of folds, from which all choices follow. Of more than 10,000 rows no pairs are
    left out, which would be twice as many fits: what the other folds recommend is told
    by fits which had this one among their rows.

    Examples
    --------
    >>> angle = np.arange(0.0, 360.0, 9.0)
    >>> table = Table(
    ...     pd.DataFrame({"angle": angle}),
    ...     pd.DataFrame({"push": np.cos(np.radians(angle))}),
    ...     periods={"angle": 360.0},
    ... )
    >>> some = "nearest neighbour", "single, one kernel"
    >>> fit_table(table, methods=some).card["chosen"]
    'single, one kernel'
    """
    if profile not in MAX_TASKS:
        raise ValueError(f"profile={profile!r}; wanted one of {tuple(MAX_TASKS)}")
    most = MAX_TASKS[profile]
    X, y = table.tasks.to_numpy(), table.policies.to_numpy()
    centers, spreads = y.mean(axis=0), y.std(axis=0)
    spreads[spreads <= 1e-12 * np.abs(y).max(axis=0)] = 1.0
    unit = (y - centers) / spreads
    columns = {name: k for k, name in enumerate(table.tasks)}
    numbered = {columns[name]: period for name, period in table.periods.items()}
    names = _select(methods, table)
    skills = {
        name: TableSkill(name, periods=numbered, max_tasks=most, random_state=seed)
        for name in names
    }
    scale = TableSkill("mean policy", periods=numbered).fit(X, unit).scale_
    with threadpool_limits(1):  # more add up in another order
        blocks = make_blocks(scale.flatten(X), scale.transform(X), table.copies, seed)
    data = X, unit, table.cost
    sizes = [most // 4, most // 2] if len(X) > most else []

    def fitted(name: str) -> TableSkill:
        """Fit to the whole table."""
        skill = TableSkill(
            name,
            periods=table.periods or None,
            units=table.units or None,
            max_tasks=most,
            random_state=seed,
        )
        return skill.fit(table.tasks, table.policies, table.cost)

    alone = part_alone(table.copies, seed)
    n_fits = len(plan_fits(skills, blocks, sizes)) + 2 * N_FOLDS + blocks.n_folds + 2
    with tqdm(
        desc="fits", total=n_fits, disable=not progress, dynamic_ncols=True
    ) as bar:
        with open_workers(jobs) as run:
            compared = compare_methods(
                skills,
                data,
                blocks,
                sizes=sizes,
                run=run,
                done=bar.update,
            )
            held, left_out = judge_chosen(
                skills[compared.chosen],
                data,
                blocks,
                seed=seed,
                run=run,
                done=bar.update,
            )
            missed, _, apart = leave_out(
                skills[compared.chosen], data, alone, run, bar.update
            )
        with threadpool_limits(1), warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            paper = fitted(PAPER)
            bar.update()
            is_paper = compared.chosen == PAPER
            skill = paper if is_paper else fitted(compared.chosen)
            bar.update()
            jumps = find_structure(table, unit, scale, seed)
            first = np.unique(table.copies, return_index=True)[1]  # one error a task
            doubt = Doubt().fit(skill.scale_.transform(X), unit)
            skill.doubt_ = doubt.calibrate(missed[first], apart[first])
    card = {
        "command": command,
        "seed": seed,
        "profile": profile,
        "versions": versions(),
        "table": {"name": table.name, "sha256": table.sha256, "notes": [*table.notes]}
        | _count(table),
        "tasks": _describe(table, table.tasks),
        "policies": _describe(table, table.policies),
        "jumps": jumps,
        "charts": describe_charts(paper),
        "blocks": {"n_blocks": len(blocks.folds), "n_folds": blocks.n_folds},
        "max_tasks": most,
        "held_out": held | judge_doubt(doubt, left_out, blocks),
        "methods": _scores(compared),
        "failed": compared.failed,
        "chosen": compared.chosen,
        "error_of_choosing": _choosing(compared) | {"nested": is_nested(blocks)},
        "curve": [
            {"method": name, "n_tasks": size, "error": six_digits(error)}
            for name, points in compared.curve.items()
            for size, error in points.items()
        ],
        "warnings": sorted({" ".join(str(one.message).split()) for one in caught}),
    }
    return Fit(skill, paper, card)


def _select(methods: Sequence[str] | None, table: Table) -> list[str]:
    """Return which methods are compared, the simplest first."""
    if unknown := sorted({*(methods or [])} - {*METHODS}):
        raise ValueError(f"methods={unknown} are unknown; wanted some of {[*METHODS]}")

    def applies(name: str) -> bool:
        if METHODS[name].wants_cost and table.cost is None:
            return False
        return not METHODS[name].is_flat or table.tasks.shape[1] <= MOST_NUMBERS

    mean, *others = METHODS
    asked = others if methods is None else [name for name in others if name in methods]
    return [mean, *filter(applies, asked)]


def _count(table: Table) -> dict[str, int]:
    """Count rows, different tasks, and rows whose task another row has, too."""
    times = np.bincount(table.copies)
    return {
        "n_rows": len(table.tasks),
        "n_tasks": len(times),
        "n_repeated_tasks": int((times > 1).sum()),
        "n_replicates": int(times[times > 1].sum()),
    }


def _describe(table: Table, frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Describe columns."""
    return [
        {
            "name": name,
            "unit": table.units.get(name),
            "period": table.periods.get(name),
            "lowest": float(column.min()),
            "highest": float(column.max()),
            "spread": six_digits(float(column.std())),
        }
        for name, column in zip(map(str, frame), frame.to_numpy().T, strict=True)
    ]


def _scores(compared: Comparison) -> list[dict[str, Any]]:
    """Write the errors of all methods, and by how much they exceed the least."""
    sizes = compared.sizes
    best = min(compared.errors.values(), key=lambda errors: errors @ sizes)
    return [
        {
            "method": name,
            **average(errors, sizes).stored("error"),
            **_renamed(exceed(errors, best, sizes), "above_best"),
        }
        for name, errors in compared.errors.items()
    ]


def _choosing(compared: Comparison) -> dict[str, Any]:
    """Write the error of choosing, and by how much that of the mean exceeds it."""
    mean = next(iter(compared.errors.values()))
    return {
        **average(compared.nested, compared.sizes).stored("error"),
        **_renamed(exceed(mean, compared.nested, compared.sizes), "below_mean"),
        "chosen_without_fold": [*compared.picks],
    }


def _renamed(estimate: Estimate, name: str) -> dict[str, float | None]:
    """Write a second number beside another."""
    stored = estimate.stored(name)
    return {
        key if key == name else f"{name}_{key}": value for key, value in stored.items()
    }


def check_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse, before the work, a folder that is not to be replaced.

    Parameters
    ----------
    folder : Path
        Where a fit is to be written.
    force : bool, default=False
        Whether an earlier fit may be replaced.

    Raises
    ------
    ValueError
        If there is something: unless `force`, and a fit and nothing else. If nothing
        can be written there. Or if skops, which writes skills, is not installed.
    """
    load_skops()
    nearest = next(above for above in folder.absolute().parents if above.exists())
    try:
        with tempfile.TemporaryFile(dir=nearest):
            pass
    except OSError as error:
        raise ValueError(
            f"out={folder}: nothing can be written there: {error.strerror}"
        ) from None
    if not (folder.exists() or folder.is_symlink()):
        return
    if not folder.is_dir():
        raise ValueError(f"out={folder} is a file; wanted the name of a new folder")
    found = {path.name for path in folder.iterdir()}
    if not found <= FILES or CARD not in found:
        raise ValueError(
            f"out={folder} exists, and is no earlier fit; wanted a new folder"
        )
    if not force:
        raise ValueError(
            f"out={folder} has an earlier fit; --force replaces it, or wanted the name "
            "of a new folder"
        )


def save_fit(
    fit: Fit, folder: Path, *, report: str | None = None, force: bool = False
) -> None:
    """Write a fit as a folder, whole or not at all.

    Parameters
    ----------
    fit : Fit
        What `fit_table` returned.
    folder : Path
        Where to: ``skill.skops``, ``paper.skops``, ``card.json`` and ``scores.csv``.
    report : str, optional
        A page of HTML that tells of it, as ``report.html``.
    force : bool, default=False
        Whether an earlier fit is replaced.

    Raises
    ------
    ValueError
        See `check_folder`.
    """
    check_folder(folder, force=force)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".fit.") as name:
        whole = Path(name) / "new"
        whole.mkdir()
        (whole / SKILL).write_bytes(skill_bytes(fit.skill))
        (whole / OURS).write_bytes(skill_bytes(fit.paper))
        fit.scores.to_csv(whole / SCORES, index=False)
        text = json.dumps(fit.card, indent=2, ensure_ascii=False) + "\n"
        (whole / CARD).write_text(text, encoding="utf-8")
        if report is not None:
            (whole / REPORT).write_text(report, encoding="utf-8")
        if folder.exists():
            folder.rename(Path(name) / "old")
        whole.rename(folder)
