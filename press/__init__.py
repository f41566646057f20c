"""The press: notebooks -> a book. It imports nothing of the package a book tells of.

A *chapter* is a notebook without outputs; a *run* of it has them, and a *record* of
what it depended on. A *page* is a chapter or a text. The *stage* is a folder that
mirrors the repository; Sphinx renders it. The *subject* is what the book is about, with
all that a package hands to its book: numbers, fragments of pages, the help of its
command line.

What a chapter itself calls
    `check_parameters`, `expect`
The book
    `build_book`, `changed_chapters`, `build_twice`, `release_book`, `print_book`,
    `pages`, `page_titles`, `Subject`, `BookError`; on the command line
    `python -m press.cli`
What a program is made of
    `make_parser`, `run_command`, `tell_options`, `BOOK_COMMANDS`, `Commands`,
    `add_jobs`, `add_profile`, `add_seed`, `check_output`
What all floors use
    `face`, `homes`; `locked`, `replace_file`, `replace_files`, `write_json`,
    `checksum`; `plain`, `paragraph`, `label`
"""

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from press._book import build_book, changed_chapters, page_titles, pages
    from press._chapters import BookError
    from press._files import (
        checksum,
        locked,
        replace_file,
        replace_files,
        write_json,
    )
    from press._markup import label, paragraph, plain
    from press._pages import Subject
    from press._parameters import check_parameters, expect
    from press._release import build_twice, print_book, release_book
    from press.cli import (
        BOOK_COMMANDS,
        Commands,
        add_jobs,
        add_profile,
        add_seed,
        check_output,
        make_parser,
        run_command,
        tell_options,
    )


def face(
    package: str, file: str
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Make a package offer what its `if TYPE_CHECKING` block imports, and its floors.

    Nothing is imported before it is asked for. So a name is listed once, type checkers
    follow it, and whoever uses one loads only the module it lives in.

    Parameters
    ----------
    package, file : str
        `__name__` and `__file__` of the package.

    Returns
    -------
    names : list of str
        For ``__all__``.
    get, list : callable
        For ``__getattr__`` and ``__dir__``.
    """
    offered = homes(file)
    names = sorted(offered)

    def get(name: str) -> Any:
        if name in offered:
            return getattr(import_module(offered[name]), name)
        if name in floors():
            return import_module(f"{package}.{name}")
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    def floors() -> set[str]:
        return {
            path.stem
            for path in Path(file).parent.iterdir()
            if path.stem[0] not in "_."
            if path.suffix == ".py" or (path / "__init__.py").is_file()
        }

    return names, get, lambda: sorted({*names, *floors()})


def homes(file: str) -> dict[str, str]:
    """Tell where the names live that a package offers.

    Parameters
    ----------
    file : str
        `__file__` of the package.

    Returns
    -------
    dict of str to str
        By name, the module it is imported from.
    """
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.name: node.module or ""
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


__all__, __getattr__, __dir__ = face(__name__, __file__)
