"""For Sphinx: a heading is text, also where a theme or the search takes it for HTML.

Two places put what a heading says into a page as it is: the title that the theme prints
(sphinx-book-theme 1.3), and the page of search results (Sphinx 7.4). A heading about
``<img>`` would show, and run, one.
"""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

_TITLES = ("pagetitle", "root_title")  # as the theme's templates call them
_LAST = 900  # after the theme has set them


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
    app.connect(
        "html-page-context", lambda *given: _write_titles(given[3]), priority=_LAST
    )
    app.connect("build-finished", _write_index)
    return {"parallel_read_safe": True}


def escape_index(text: str) -> str:
    r"""Write the headings in a search index as HTML.

    Parameters
    ----------
    text : str
        The script `searchindex.js`.

    Returns
    -------
    str
        The same, but for headings that hold markup.

    Examples
    --------
    >>> print(escape_index('Search.setIndex({"alltitles": {"a <b>": [[0, null]]}})'))
    Search.setIndex({"alltitles": {"a &lt;b&gt;": [[0, null]]}})
    """
    before, _, rest = text.partition("(")
    index, _, after = rest.rpartition(")")
    found = json.loads(index)
    titles = {
        html.escape(one, quote=False): at for one, at in found["alltitles"].items()
    }
    return f"{before}({json.dumps(found | {'alltitles': titles})}){after}"


def _write_titles(context: dict[str, Any]) -> None:
    """Escape a page's title, and the book's, before they are put into a template."""
    for name in _TITLES:
        if name in context:
            context[name] = html.escape(context[name], quote=False)


def _write_index(app: Sphinx, error: Exception | None) -> None:
    """Escape headings in the finished search index."""
    file = Path(app.outdir, "searchindex.js")
    if error is None and file.is_file():
        file.write_text(escape_index(file.read_text("utf-8")), "utf-8")
