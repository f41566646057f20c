"""Text that is data, shown as it is: in Markdown, and in what Sphinx makes of headings.

The book's own Markdown knows no HTML (`_config.yml`), so that a tag in it is text.

The rest is an extension of Sphinx. A heading is text, also where a theme or the search
takes it for HTML. Two places put what a heading says into a page as it is: the title
that the theme prints (sphinx-book-theme 1.3), and the page of search results (Sphinx
7.4). A heading about ``<img>`` would show, and run, one.

Sources are read from their files. Without this Sphinx imports every module whose source
a page shows, and all that these import, each time it writes the book. Links from them
to their documentation lead to where it stands. Sphinx takes all names of a module to be
documented under one prefix; here the public ones go by the package, and others by their
folder.
"""

import html
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_MARKUP = re.compile(r"[\\`*_{}<>|$&]|\](?=[(\[:{])|(?<=\[)\^")
_OPENING = re.compile(r"^(\d*)([!-/:-@~])")
_BRACKET = re.compile(r"\\.|(`+).*?\1|([\[\]])")

_TITLES = ("pagetitle", "root_title")  # as the theme's templates call them
_LAST = 900  # after the theme has set them


# Markdown


def plain(text: str) -> str:
    r"""Write text so that Markdown shows it as it is, on one line.

    Parameters
    ----------
    text : str
        Any text; white space in it counts as one blank.

    Returns
    -------
    str
        Markdown, to stand within a line or a table's cell.

    Examples
    --------
    >>> print(plain("a <b> | *c* [0.4, 0.6]"))
    a \<b\> \| \*c\* [0.4, 0.6]
    """
    return _MARKUP.sub(r"\\\g<0>", " ".join(text.split()))


def paragraph(text: str) -> str:
    r"""Write text so that it is a paragraph, and no list, heading or rule.

    Parameters
    ----------
    text : str
        Any text; white space in it counts as one blank.

    Returns
    -------
    str
        Markdown, to stand at the beginning of a line.

    Examples
    --------
    >>> print(paragraph("1. No list"), paragraph("# No heading"), sep=" ")
    1\. No list \# No heading
    """
    return _OPENING.sub(r"\1\\\2", plain(text))


def label(markdown: str) -> str:
    r"""Keep the brackets in a line of Markdown from ending the link that it names.

    Parameters
    ----------
    markdown : str
        A line, such as a heading or what `plain` returned.

    Returns
    -------
    str
        Markdown, to stand between the brackets of a link.

    Examples
    --------
    >>> print(label("a] *b* `c[0]`"))
    a\] *b* `c[0]`
    """
    return _BRACKET.sub(lambda m: f"\\{m[2]}" if m[2] else m[0], markdown)


def code(text: str) -> str:
    r"""Write text as code, within a line or a table's cell.

    >>> print(code("None | `x`"))
    `` None \| `x` ``
    """
    line = " ".join(text.split()).replace("|", r"\|")
    ticks = "`" * (_longest_run(line) + 1)
    space = " " if "`" in line[:1] + line[-1:] else ""
    return f"{ticks}{space}{line}{space}{ticks}"


def fenced(text: str, kind: str) -> str:
    r"""Write lines as a block of a language, whatever fences they hold themselves.

    >>> print(fenced("a = '```'", "python"))
    ````python
    a = '```'
    ````
    """
    ticks = "`" * max(3, _longest_run(text) + 1)
    return f"{ticks}{kind}\n{text}\n{ticks}"


def _longest_run(text: str) -> int:
    return max(map(len, re.findall("`+", text)), default=0)


# Sphinx


def setup(app: "Sphinx") -> dict[str, Any]:
    """Take part in a build, which may read in parallel."""
    app.connect("viewcode-find-source", find_source)
    app.connect(
        "html-page-context", lambda *given: _escape_titles(given[3]), priority=_LAST
    )
    app.connect("build-finished", _finish)
    return {"parallel_read_safe": True}


def find_source(app: "Sphinx | None", module: str) -> tuple[str, dict[str, Any]] | None:
    """Find the source of a module of ours, and where in it things stand.

    Sphinx asks at each name that it documents, and again to write the source. What it
    has noted by then holds: trees are kept only as long as the code is the same.

    >>> text, places = find_source(None, "press._markup")
    >>> places["find_source"][0], find_source(None, "pathlib")
    ('def', None)
    """
    from sphinx.pycode import ModuleAnalyzer  # noqa: PLC0415 (only Sphinx has loaded it)

    if app and (noted := getattr(app.env, "_viewcode_modules", {}).get(module)):
        return noted[0], noted[1]
    file = Path(__file__).parents[1] / f"{module.replace('.', '/')}.py"
    if not file.is_file():
        return None
    analyzer = ModuleAnalyzer.for_string(file.read_text(encoding="utf-8"), module)
    analyzer.analyze()
    return analyzer.code, analyzer.tags


def escape_index(text: str) -> str:
    r"""Write the headings in a search index, the script `searchindex.js`, as HTML.

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


def mend_backlinks(folder: Path) -> None:
    """Lead links from sources to names that pages `api…`, if there are any, have."""
    known = {
        page.name: set(re.findall(r'id="([\w.]+)"', page.read_text(encoding="utf-8")))
        for page in folder.glob("api*.html")
    }
    for source in (folder / "_modules").glob("*/**/*.html"):
        package, *floors = source.relative_to(folder / "_modules").parts[:-1]
        floor = ".".join(floors)

        def mend(link: re.Match[str], prefix: str = f"{package}.{floor}") -> str:
            page, whole, name = link.groups()
            there = whole in known.get(page, ())
            return f"{page}#{whole if there else f'{prefix}.{name}'}"

        text = source.read_text(encoding="utf-8")
        names = rf"({package}\.(?:{floor}\.)?(?:_\w+\.)?([\w.]+))"
        text = re.sub(rf"\b(api\w*\.html)#{names}", mend, text)
        source.write_text(text, encoding="utf-8")


def _escape_titles(context: dict[str, Any]) -> None:
    """Escape a page's title, and the book's, before they are put into a template."""
    for name in _TITLES:
        if name in context:
            context[name] = html.escape(context[name], quote=False)


def _finish(app: "Sphinx", error: Exception | None) -> None:
    """Mend what only the finished book shows."""
    folder = Path(app.outdir)
    index = folder / "searchindex.js"
    if error is None and index.is_file():
        index.write_text(escape_index(index.read_text("utf-8")), "utf-8")
        mend_backlinks(folder)
