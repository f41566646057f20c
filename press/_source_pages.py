"""For Sphinx: the sources of our modules, read from their files.

Without this Sphinx imports every module whose source a page shows, and all that these
import, each time it writes the book.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.pycode import ModuleAnalyzer


def setup(app: Sphinx) -> dict[str, Any]:
    """Take part in a build, as an extension.

    Parameters
    ----------
    app : Sphinx
        The build.

    Returns
    -------
    dict
        That it may read in parallel.
    """
    app.connect("viewcode-find-source", find_source)
    return {"parallel_read_safe": True}


def find_source(_: Sphinx | None, module: str) -> tuple[str, dict[str, Any]] | None:
    """Find a module's source and where in it things stand.

    Parameters
    ----------
    _ : Sphinx or None
        The build; not needed.
    module : str
        Name of a module.

    Returns
    -------
    tuple of (str, dict) or None
        The text, and by name the kind of thing and its lines; None if it is none of
        ours, which leaves it to Sphinx.

    Examples
    --------
    >>> text, places = find_source(None, "press._source_pages")
    >>> places["find_source"][0], find_source(None, "pathlib")
    ('def', None)
    """
    file = Path(__file__).parents[1] / f"{module.replace('.', '/')}.py"
    if not file.is_file():
        return None
    analyzer = ModuleAnalyzer.for_string(file.read_text(encoding="utf-8"), module)
    analyzer.analyze()
    return analyzer.code, analyzer.tags
