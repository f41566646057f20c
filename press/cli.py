"""The command line of the book: run a chapter, build, print, pack, compare."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

from press._chapters import BookError, read_chapter, run_chapters
from press._notebook import complaints, write_notebook
from press._options import Commands, add_jobs, add_profile, check_output
from press._parameters import resolve


def _add_run(commands: Commands) -> None:
    """Declare `msc run`."""
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
    # argparse takes -1e-3 for an option: of numbers it knows -1 and -0.001 only.
    parser._negative_number_matcher = re.compile(r"-(\.?\d|inf|nan)")
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


def _add_book(commands: Commands) -> None:
    """Declare `msc book`."""
    parser = commands.add_parser("book", help="execute the chapters, build the book")
    _add_building(parser)
    parser.set_defaults(run=_run_book)


def _run_book(options: argparse.Namespace) -> None:
    """Build the book; print which chapters are executed, why, and the index page."""
    from press._book import build_book

    index = build_book(profile=options.profile, jobs=options.jobs, say=tqdm.write)
    print(f"The book: {index}")


def _add_release(commands: Commands) -> None:
    """Declare `msc release`."""
    parser = commands.add_parser("release", help="pack the built book as a zip")
    parser.set_defaults(run=_run_release)


def _run_release(_: argparse.Namespace) -> None:
    """Pack the built book."""
    from press._release import release_book

    print(release_book(Path.cwd()))


def _add_pdf(commands: Commands) -> None:
    """Declare `msc pdf`."""
    parser = commands.add_parser("pdf", help="print the built book as a PDF")
    parser.set_defaults(run=_run_pdf)


def _run_pdf(_: argparse.Namespace) -> None:
    """Print the built book."""
    from press._print import print_book

    print(print_book(Path.cwd()))


def _add_twice(commands: Commands) -> None:
    """Declare `msc twice`."""
    parser = commands.add_parser("twice", help="build the book again, and compare")
    _add_building(parser)
    parser.set_defaults(run=_run_twice)


def _run_twice(options: argparse.Namespace) -> None:
    """Build the book here and elsewhere; fail where they differ."""
    from press._release import build_twice

    different = build_twice(
        Path.cwd(), profile=options.profile, jobs=options.jobs, say=tqdm.write
    )
    if different:
        raise BookError(f"built again, these differ: {', '.join(different)}")
    print("built again elsewhere, the book has the same bytes")


def _add_building(parser: argparse.ArgumentParser) -> None:
    add_profile(parser)
    add_jobs(parser, "chapters at a time")


COMMANDS = (_add_run, _add_book, _add_release, _add_pdf, _add_twice)
