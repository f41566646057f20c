"""The command line: `msc COMMAND …`.

A command is a function that takes the parsed arguments and one, `_add_…`, that declares
them; both stand together, below, in `msc.cli._search` or in `press.cli`, whose
`COMMANDS` are the latter. What takes seconds to load is imported by the commands that
need it.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from msc._parallel import WorkersLost
from msc.cli._search import COMMANDS as SEARCH
from msc.data import load_dataset
from press import COMMANDS as BOOK
from press import (
    BookError,
    Commands,
    add_jobs,
    add_profile,
    add_seed,
    check_output,
    replace_file,
    write_json,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command and options; those of the process by default.

    Returns
    -------
    int
        Exit status: 0; 2 after a bad argument, an unusable file, a killed worker or a
        failed chapter; 130 if interrupted.
    """
    parser = argparse.ArgumentParser(
        prog="msc", description="Parameterized skills by manifold clustering."
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run, *others = BOOK
    for add in (*SEARCH, _add_evaluate, run, _add_claims, *others):
        add(commands)
    _add_help(commands, parser)
    options = parser.parse_args(arguments)
    try:
        options.run(options)
    except KeyboardInterrupt:
        print("msc: interrupted", file=sys.stderr)
        return 130
    except WorkersLost as error:
        print(f"msc: error: {error}; the same command begins anew", file=sys.stderr)
        return 2
    except (ValueError, OSError, BookError) as error:
        print(f"msc: error: {_sentence(error)}", file=sys.stderr)
        return 2
    return 0


def _add_evaluate(commands: Commands) -> None:
    """Declare `msc evaluate`."""
    parser = commands.add_parser("evaluate", help="compare all methods, many times")
    add_profile(parser)
    add_seed(parser)
    add_jobs(parser)
    parser.add_argument(
        "--out-dir",
        type=Path,
        default=Path("data/results"),
        help="a folder (data/results)",
    )
    parser.set_defaults(run=_run_evaluate)


def _run_evaluate(options: argparse.Namespace) -> None:
    """Study both workspaces; write each one's results as soon as they are there."""
    from msc.study import format_study, run_elbows, run_study

    worlds = "free", "obstacles"
    folder: Path = options.out_dir
    what = {"profile": options.profile, "seed": options.seed, "jobs": options.jobs}
    what |= {"progress": True}
    for world in worlds:
        out = folder / f"study_{world}.json"
        check_output(out, ".json", jobs=options.jobs, seed=options.seed)
        for table in (world, f"{world}_test"):
            load_dataset(table)
    for world in worlds:
        out = folder / f"study_{world}.json"
        replace_file(out, format_study(run_study(world, **what)))
        print(out)
        out = folder / f"elbow_{world}.json"
        replace_file(out, format_study(run_elbows(world, **what)))
        print(out)


def _add_claims(commands: Commands) -> None:
    """Declare `msc claims`."""
    parser = commands.add_parser("claims", help="judge the paper's claims")
    parser.add_argument("--out", type=Path, help="a .json file")
    parser.add_argument("--readme", type=Path, help="a .md file, to be renewed")
    parser.set_defaults(run=_run_claims)


def _run_claims(options: argparse.Namespace) -> None:
    """Hold the measured results against every claim; print the verdicts."""
    from msc.claims import judge_all, summarise, with_summary

    out: Path | None = options.out
    readme: Path | None = options.readme
    if out:
        check_output(out, ".json")
    text = ""
    if readme:
        text = readme.read_text(encoding="utf-8")
        with_summary(text, {})  # refuses what has no place for it
    verdicts = judge_all(Path.cwd())
    width = max(len(one.claim.id) for one in verdicts)
    for one in verdicts:
        print(f"{one.claim.id:{width}}  {one.words:18}  {one.measured}")
        if one.differs:
            print(f"{'':{width}}  {'':18}  {one.sentence}")
    for one in verdicts:
        if one.unexplained:
            print(f"{one.claim.id}: {one.verdict}, but no `why` quotes a measurement")
    if out:
        write_json(out, summarise(verdicts))
        print(out)
    if readme:
        replace_file(readme, with_summary(text, summarise(verdicts)))
        print(readme)


def _add_help(commands: Commands, whole: argparse.ArgumentParser) -> None:
    """Declare `msc help`, which tells every command's options."""
    parser = commands.add_parser("help", help="tell the options of all commands")
    parsers = [whole, *commands.choices.values()]
    parser.set_defaults(
        run=lambda _: print("\n".join(one.format_help() for one in parsers), end="")
    )


def _sentence(error: Exception) -> str:
    """Say what went wrong, without an error number."""
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.strerror}: {error.filename}"
    return str(error)
