"""Faces: what a package offers, loaded on first use."""

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


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
