"""The command line: what every program of it shares, and the commands of the book.

A command is a function that takes the parsed arguments and one, `_add_…`, that declares
them; both stand together. What takes seconds to load, the face of `press` loads when a
command asks for it. `python -m press.cli COMMAND …` has the commands of the book;
another program has them among its own, and hands the book its subject.
"""

import argparse
import re
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from tqdm import tqdm

import press
from press._chapters import BookError, read_chapter, run_chapters
from press._notebook import complaints, write_notebook
from press._pages import Subject
from press._parameters import resolve

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command of the book alone.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command and options; those of the process by default.

    Returns
    -------
    int
        Exit status, as `run_command` returns it.
    """
    words = "Notebooks, executed and rendered as a book."
    return run_command(make_parser(Subject().program, words, BOOK_COMMANDS), arguments)


def make_parser(
    program: str,
    description: str,
    commands: Iterable[Callable[[Commands], None]],
    subject: Callable[[Path], Subject] = lambda _: Subject(),
) -> argparse.ArgumentParser:
    """Make the parser of a command line, with a command `help` for all options.

    Parameters
    ----------
    program, description : str
        How it is called, and what it is for.
    commands : iterable of callable
        Each declares a command, whose function is the default of `run`.
    subject : callable, optional
        Is given the repository and returns the `Subject` of its book.

    Returns
    -------
    ArgumentParser
        The parser.
    """
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.set_defaults(subject=subject)
    known = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in commands:
        add(known)
    helping = known.add_parser("help", help="tell the options of all commands")
    helping.set_defaults(run=lambda _: print(tell_options(parser), end=""))
    for one in known.choices.values():
        # argparse takes -1e-3 for an option: of numbers it knows -1 and -0.001 only.
        one._negative_number_matcher = re.compile(r"-(\.?\d|inf|nan)")
    return parser


def tell_options(parser: argparse.ArgumentParser, width: int | None = None) -> str:
    """Return the help of a command line, then of each of its commands.

    Parameters
    ----------
    parser : ArgumentParser
        What `make_parser` returned.
    width : int, optional
        Columns; the terminal's by default.

    Returns
    -------
    str
        Lines of text.
    """
    (known,) = (
        action.choices.values()
        for action in parser._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    told = []
    for one in (parser, *known):
        one.formatter_class = partial(argparse.HelpFormatter, width=width and width - 2)
        told.append(one.format_help())
    return "\n".join(told)


def run_command(
    parser: argparse.ArgumentParser, arguments: Sequence[str] | None = None
) -> int:
    """Run one command; tell in a sentence what went wrong.

    Parameters
    ----------
    parser : ArgumentParser
        What `make_parser` returned.
    arguments : sequence of str, optional
        Command and options; those of the process by default.

    Returns
    -------
    int
        Exit status: 0; 2 after a bad argument, an unusable file or a failed chapter;
        130 if interrupted.
    """
    options = parser.parse_args(arguments)
    try:
        _check_numbers(options)
        options.run(options)
    except KeyboardInterrupt:
        print(f"{parser.prog}: interrupted", file=sys.stderr)
        return 130
    except (ValueError, OSError, BookError) as error:
        words = str(error)
        if isinstance(error, OSError) and error.strerror and error.filename:
            words = f"{error.strerror}: {error.filename}"  # without its number
        print(f"{parser.prog}: error: {words}", file=sys.stderr)
        return 2
    return 0


# Options


def _check_numbers(options: argparse.Namespace) -> None:
    """Refuse what makes no sense for `add_seed` or `add_jobs`, in every command."""
    if (seed := getattr(options, "seed", 0)) < 0:
        raise ValueError(f"seed={seed}; wanted 0 or more")
    if (jobs := getattr(options, "jobs", 1)) < 1:
        raise ValueError(f"jobs={jobs}; wanted at least 1")


def add_profile(parser: argparse.ArgumentParser) -> None:
    """Add ``--profile``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    """
    parser.add_argument("--profile", default="quick", help="quick (default) or full")


def add_seed(
    parser: argparse.ArgumentParser, seed: int = 0, what: str = "seed of every draw"
) -> None:
    """Add ``--seed``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    seed : int, default=0
        The default.
    what : str
        Its meaning.
    """
    parser.add_argument("--seed", type=int, default=seed, help=f"{what} ({seed})")


def add_jobs(parser: argparse.ArgumentParser, what: str = "worker processes") -> None:
    """Add ``--jobs``.

    Parameters
    ----------
    parser : ArgumentParser
        Parser of a command.
    what : str
        Its meaning.
    """
    parser.add_argument("--jobs", type=int, default=2, help=f"{what} (2)")


def check_output(out: Path, suffix: str) -> None:
    """Refuse, before hours of work, what would spoil its end.

    Parameters
    ----------
    out : Path
        The file to be written; its folder is made if it is missing.
    suffix : str
        How its name must end, in whatever case.

    Raises
    ------
    ValueError
        If the name is not as wanted, or the file cannot be written.
    """
    if out.suffix.lower() != suffix.lower():
        raise ValueError(f"out={out}; wanted a name ending in {suffix}")
    if out.is_dir():
        raise ValueError(f"out={out} is a folder; wanted the name of a file")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=out.parent):
            pass
    except OSError as error:
        raise ValueError(
            f"out={out}: its folder cannot be written to: {error.strerror}"
        ) from None


# The book


def _add_run(commands: Commands) -> None:
    """Declare `run`."""
    parser = commands.add_parser("run", help="execute one chapter")
    parser.add_argument(
        "chapter", type=Path, help="for example book/fig3_free_24.ipynb"
    )
    parser.add_argument(
        "-p",
        dest="parameters",
        nargs=2,
        action="append",
        default=[],
        metavar=("NAME", "VALUE"),
        help="a parameter of the chapter; may be repeated",
    )
    parser.add_argument("--out", type=Path, required=True, help="an .ipynb file")
    parser.set_defaults(run=_run_chapter)


def _run_chapter(options: argparse.Namespace) -> None:
    """Execute a chapter by papermill; refuse parameters that it cannot take."""
    out: Path = options.out
    given: dict[str, Any] = {}
    for name, word in options.parameters:
        if name in given:
            raise ValueError(f"{name} is given twice; wanted one value for it")
        given[name] = resolve(word)
    read_chapter(options.chapter, given)
    check_output(out, ".ipynb")
    if out.resolve() == options.chapter.resolve():
        raise ValueError(f"out={out} is the chapter itself; wanted another file")
    root = Path.cwd()
    chapters = {options.chapter: given}
    (chapter,) = run_chapters(
        chapters, root=root, cache=root / "_build/cache", jobs=1, say=print
    )
    write_notebook(chapter.notebook, out)
    for words in complaints(chapter.notebook):
        print(f"{chapter.name}, {words}", file=sys.stderr)
    print(f"{out}: {chapter.record.seconds:.1f} s")


def _add_building(commands: Commands) -> None:
    """Declare `book`, `release`, `pdf` and `twice`."""
    declared = {
        "book": (_run_book, "execute the chapters, build the book"),
        "release": (_run_release, "pack the built book as a zip"),
        "pdf": (_run_pdf, "print the built book as a PDF"),
        "twice": (_run_twice, "build the book again, and compare"),
    }
    for name, (run, words) in declared.items():
        parser = commands.add_parser(name, help=words)
        parser.set_defaults(run=run)
        if name in ("book", "twice"):
            add_profile(parser)
            add_jobs(parser, "chapters at a time")
        if name == "twice":
            parser.add_argument(
                "--all",
                action="store_true",
                help="execute all chapters again, not a fifth of them by the commit",
            )
        if name == "book":
            parser.add_argument(
                "--changed",
                action="store_true",
                help="execute nothing; print a line for each chapter that would be, "
                "its name, a colon, and why",
            )
            parser.add_argument(
                "--junit",
                type=Path,
                metavar="FILE",
                help="report of each chapter in a .xml file, as JUnit does; all are "
                "executed then, though some may fail",
            )


def _run_book(options: argparse.Namespace) -> None:
    """Build the book; print which chapters are executed, why, and the index page."""
    if options.changed:
        _tell_changed(options)
        return
    if options.junit:
        check_output(options.junit, ".xml")
    print(f"The book: {press.build_book(**_building(options), junit=options.junit)}")


def _tell_changed(options: argparse.Namespace) -> None:
    """Print which chapters would be executed, and why."""
    if options.junit:
        raise ValueError("--changed executes nothing that --junit could report of")
    changed = press.changed_chapters(profile=options.profile, root=Path.cwd())
    for name, reasons in changed.items():
        print(f"{name}: {reasons}")
    if not changed:
        print("no chapter has to be executed", file=sys.stderr)  # stdout stays empty


def _run_release(_: argparse.Namespace) -> None:
    """Pack the built book."""
    print(press.release_book(Path.cwd()))


def _run_pdf(_: argparse.Namespace) -> None:
    """Print the built book."""
    print(press.print_book(Path.cwd()))


def _run_twice(options: argparse.Namespace) -> None:
    """Build the book here and elsewhere; fail where they differ."""
    if different := press.build_twice(**_building(options), whole=options.all):
        raise BookError(f"built again, these differ: {', '.join(different)}")
    print("built again elsewhere, the book has the same bytes")


def _building(options: argparse.Namespace) -> dict[str, Any]:
    """Return what a build is asked for."""
    root = Path.cwd()
    return {
        "profile": options.profile,
        "jobs": options.jobs,
        "root": root,
        "subject": options.subject(root),
        "say": tqdm.write,
    }


BOOK_COMMANDS = (_add_run, _add_building)


if __name__ == "__main__":
    sys.exit(main())
