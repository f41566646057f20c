"""The commands for tables of one's own: `msc fit` and `msc predict`."""

from __future__ import annotations

import argparse
import shlex
import sys
import warnings
from pathlib import Path

from threadpoolctl import threadpool_limits

import msc.report
import msc.skills
from msc.data import read_package
from press import Commands, add_jobs, add_profile, add_seed, check_output


def _add_fit(commands: Commands) -> None:
    """Declare `msc fit`."""
    parser = commands.add_parser("fit", help="learn a skill from a table of your own")
    parser.add_argument("table", type=Path, help="a .csv or .parquet file")
    about = "task columns; of a table that msc search made, known"
    parser.add_argument("--tasks", nargs="+", metavar="COL", default=[], help=about)
    about = "policy columns; the same"
    parser.add_argument("--policies", nargs="+", metavar="COL", default=[], help=about)
    parser.add_argument("--cost", metavar="COL", help="what was paid for each policy")
    _add_units(parser)
    parser.add_argument(
        "--period",
        nargs="+",
        metavar="COL=NUMBER",
        default=[],
        help="task columns that come round again, as angle=360",
    )
    add_seed(parser)
    add_jobs(parser)
    add_profile(parser)
    parser.add_argument(
        "--out", type=Path, metavar="DIR", required=True, help="a new folder"
    )
    parser.add_argument(
        "--force", action="store_true", help="replace an earlier fit in that folder"
    )
    parser.set_defaults(run=_run_fit)


def _add_units(parser: argparse.ArgumentParser) -> None:
    """Declare units of columns."""
    parser.add_argument(
        "--units",
        nargs="+",
        metavar="COL=UNIT",
        default=[],
        help="units of columns, as angle=deg mass=kg",
    )


def _run_fit(options: argparse.Namespace) -> None:
    """Compare methods on a table; write the best skill, the paper's, a card, a page."""
    folder: Path = options.out
    msc.skills.check_folder(folder, force=options.force)
    if not options.tasks and not options.policies:
        _describe(options)
    if not (options.tasks and options.policies):
        raise ValueError(
            "--tasks and --policies: wanted names of columns, of each some"
        )
    periods = {}
    for name, word in msc.skills.read_pairs("period", options.period).items():
        try:
            periods[name] = float(word)
        except ValueError:
            raise ValueError(
                f"period of {name!r} is {word!r}; wanted a number"
            ) from None
    units = msc.skills.read_pairs("units", options.units)
    table = msc.skills.read_table(
        options.table,
        options.tasks,
        options.policies,
        cost=options.cost,
        units=units,
        periods=periods,
    )
    print(*msc.skills.tell_table(table), sep="\n", flush=True)
    fit = msc.skills.fit_table(
        table,
        profile=options.profile,
        seed=options.seed,
        jobs=options.jobs,
        progress=True,
        command=_command(options),
    )
    report = msc.report.make_report(table, fit)
    msc.skills.save_fit(fit, folder, report=report, force=options.force)
    print(*msc.skills.tell_fit(fit.card), sep="\n")
    print(f"{folder}: report.html, skill.skops, paper.skops, card.json, scores.csv")


def _describe(options: argparse.Namespace) -> None:
    """Take columns and units from what msc search wrote beside its table."""
    path: Path = options.table
    told = {one["path"]: one for one in read_package(path.parent)["resources"]}
    if path.name not in told:
        return
    of = told[path.name]
    names = [field["name"] for field in of["schema"]["fields"]]
    options.tasks = of["schema"]["primaryKey"]
    options.policies = [name for name in names if name.startswith("weight_")]
    options.cost = options.cost or "cost"
    options.period = options.period or ["task_deg=360"]
    units = {name: name.rpartition("_")[2] for name in options.tasks}
    options.units = options.units or [f"{name}={unit}" for name, unit in units.items()]


def _command(options: argparse.Namespace) -> str:
    """Return the command that does it again, in the table's folder."""
    words = ["msc", "fit", options.table.name, "--tasks", *options.tasks]
    words += ["--policies", *options.policies]
    words += ["--cost", options.cost] if options.cost else []
    words += ["--units", *options.units] if options.units else []
    words += ["--period", *options.period] if options.period else []
    words += ["--seed", str(options.seed), "--profile", options.profile]
    return shlex.join([*words, "--out", options.out.name])


def _add_predict(commands: Commands) -> None:
    """Declare `msc predict`."""
    parser = commands.add_parser("predict", help="predict policies of new tasks")
    parser.add_argument("skill", type=Path, help="a .skops file that msc fit wrote")
    parser.add_argument("new", type=Path, help="a .csv or .parquet file of tasks")
    _add_units(parser)
    add_jobs(parser, "threads")
    parser.add_argument("--out", type=Path, required=True, help="a .csv file")
    parser.set_defaults(run=_run_predict)


def _run_predict(options: argparse.Namespace) -> None:
    """Predict the policies of a file of tasks, and warn of those outside the range."""
    out: Path = options.out
    check_output(out, ".csv")
    units = msc.skills.read_pairs("units", options.units)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        skill = msc.skills.load_skill(options.skill)
    for one in caught:
        print(f"msc: {one.message}", file=sys.stderr)
    with threadpool_limits(1):  # the same numbers on however many processors
        found = msc.skills.predict_table(
            skill, options.new, out, units=units, jobs=options.jobs, progress=True
        )
    if found["n_outside"]:
        print(
            f"msc: {found['n_outside']:,} of {found['n_tasks']:,} tasks lie outside "
            "the range of the training tasks, see the column 'outside'",
            file=sys.stderr,
        )
    if found["n_doubtful"]:
        print(
            f"msc: {found['n_doubtful']:,} of {found['n_tasks']:,} tasks lie where "
            "neighbours' policies are far apart, see the column 'doubtful'",
            file=sys.stderr,
        )
    print(f"{out}: {found['n_tasks']:,} tasks, by {skill.method}")


FIT_COMMANDS = (_add_fit, _add_predict)
