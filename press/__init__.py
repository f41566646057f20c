"""Notebooks -> the book: executed, rendered, packed. Imports nothing of `msc`."""

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from press._chapters import BookError
    from press._checks import expect
    from press._files import (
        checksum,
        locked,
        replace_file,
        replace_files,
        write_json,
    )
    from press._markdown import label, paragraph, plain
    from press._options import (
        Commands,
        add_jobs,
        add_profile,
        add_seed,
        check_output,
    )
    from press._parameters import check_parameters
    from press.cli import COMMANDS


def face(
    package: str, file: str
) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Make a package offer what its `if TYPE_CHECKING` block imports, when asked for.

    So a name is listed once, type checkers follow it, and whoever uses one loads only
    the module it lives in.

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
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    homes = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    names = sorted(homes)

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(str(homes[name])), name)

    return names, get, lambda: names


__all__, __getattr__, __dir__ = face(__name__, __file__)
