"""The command line: `msc COMMAND …`.

A command is a function that takes the parsed arguments and one, `_add_…`, that declares
them; both stand together below.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from msc.book import build_book
from msc.chapters import BookError

if TYPE_CHECKING:
    _Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command and options; those of the process by default.

    Returns
    -------
    int
        Exit status: 0; 2 after a bad argument, an unusable file or a failed chapter;
        130 if interrupted.
    """
    parser = argparse.ArgumentParser(
        prog="msc", description="Parameterized skills by manifold clustering."
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in (_add_book,):
        add(commands)
    options = parser.parse_args(arguments)
    try:
        options.run(options)
    except KeyboardInterrupt:
        print("msc: interrupted", file=sys.stderr)
        return 130
    except (ValueError, OSError, BookError) as error:
        print(f"msc: error: {_sentence(error)}", file=sys.stderr)
        return 2
    return 0


def _add_book(commands: "_Commands") -> None:
    """Declare `msc book`."""
    parser = commands.add_parser("book", help="execute the chapters, build the book")
    parser.add_argument("--profile", default="quick", help="quick (default) or full")
    parser.add_argument("--jobs", type=int, default=2, help="chapters at a time (2)")
    parser.set_defaults(run=_run_book)


def _run_book(options: argparse.Namespace) -> None:
    """Build the book; print each chapter's seconds and where the index page is."""
    index = build_book(profile=options.profile, jobs=options.jobs)
    seconds = json.loads((index.parents[1] / "chapters.json").read_text())
    for name, value in seconds.items():
        print(f"{name:32} {value:6.1f} s")
    print(f"The book: {index}")


def _sentence(error: Exception) -> str:
    """Say what went wrong, without an error number."""
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.strerror}: {error.filename}"
    return str(error)
