"""Build the book: execute its chapters, lay out a staging folder, render it as HTML.

Everything happens under `_build/`: `cache/` keeps the runs of chapters, `stage/` what
Jupyter Book reads, `html/` the finished book. The last one is replaced only when a
whole new book is ready.
"""

import json
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import yaml

from msc.claims import CLAIMS, VERDICTS, claim_fragments, load_claims, tally
from press._chapters import BookError, Chapter, run_chapters
from press._checks import unmet
from press._figures import (
    DOWNLOADS,
    Picture,
    find_pictures,
    without_lines,
    write_gallery,
    write_vectors,
)
from press._files import locked
from press._markdown import plain
from press._notebook import complaints, parameters, read_notebook, write_notebook
from press._opening import write_opening
from press._provenance import SECONDS, seconds_script, with_provenance
from press._reference import mend_backlinks, write_reference
from press._rendering import lay_out, render

PROFILES = ("quick", "full")
ENDINGS = (".ipynb", ".md", ".rst")  # of pages

# A list in a result file that is longer holds data, which no page quotes.
LONGEST = 10

IN_USE = "{} is in use by another build; wait for it or stop it"

# The package of the lock that carries MathJax: the book needs no network.
MATHJAX = "sphinx-mathjax-offline"
_MATHJAX = "tex-svg-full.js"


def build_book(
    *,
    profile: str = "quick",
    jobs: int = 2,
    root: Path | None = None,
    say: Callable[[str], object] | None = None,
) -> Path:
    """Execute the chapters that changed and render the book.

    Parameters
    ----------
    profile : {"quick", "full"}, default "quick"
        How much the chapters compute; given to each that declares it.
    jobs : int, default 2
        How many chapters are executed at a time.
    root : Path, optional
        The repository; the working directory by default.
    say : callable, optional
        Is told in a line which chapter is executed, and why.

    Returns
    -------
    Path
        The book's index page.

    Raises
    ------
    ValueError
        If `profile` or `jobs` makes no sense, or the book is being built already.
    FileNotFoundError
        If `root` holds no book, or the book lacks a page of its table of contents.
    BookError
        If a chapter fails or writes to stderr, a claim in one does not hold (see
        `press.expect`), or a page does not render without a warning. An earlier
        book in `_build/html` is left as it was.

    Notes
    -----
    The book's bytes depend on nothing but the repository, with one exception: the file
    `_static/seconds.js` holds the seconds that each chapter took.
    """
    if profile not in PROFILES:
        raise ValueError(f"profile must be 'quick' or 'full', not {profile!r}")
    root = (root or Path.cwd()).resolve()
    build = root / "_build"
    given = {
        page: {"profile": profile}
        if "profile" in parameters(read_notebook(page))
        else {}
        for page in pages(root)
        if page.suffix == ".ipynb"
    }
    build.mkdir(exist_ok=True)
    with locked(build, IN_USE.format(build)):
        cache = build / "cache"
        executed = run_chapters(given, root=root, cache=cache, jobs=jobs, say=say)
        _refuse_unfit(executed)
        pictures = {one.name: find_pictures(one.name, one.notebook) for one in executed}
        chapters = [
            replace(one, notebook=without_lines(one.notebook)) for one in executed
        ]
        stage = build / "stage"
        lay_out(stage, lambda folder: _stage(root, folder, chapters, pictures))
        rendered = render(stage)
        _complete(rendered, root, chapters, [p for o in pictures.values() for p in o])
        html = build / "html"
        shutil.rmtree(html, ignore_errors=True)
        rendered.rename(html)
        return html / "index.html"


def pages(root: Path) -> list[Path]:
    """Return the sources of all pages in the order of the table of contents.

    Parameters
    ----------
    root : Path
        Repository: `_toc.yml` names pages of its folder `book/`, without endings.

    Returns
    -------
    list of Path
        Notebooks and text files.

    Raises
    ------
    FileNotFoundError
        If there is no table of contents, or a page is missing.
    """
    toc = root / "_toc.yml"
    if not toc.exists():
        raise FileNotFoundError(f"{root} holds no book: it has no _toc.yml")
    found = []
    for name in page_names(yaml.safe_load(toc.read_text(encoding="utf-8"))):
        sources = [root / "book" / f"{name}{ending}" for ending in ENDINGS]
        existing = [source for source in sources if source.exists()]
        if not existing:
            raise FileNotFoundError(
                f"_toc.yml lists {name}, but book/ has no {name} with one of the "
                f"endings {', '.join(ENDINGS)}"
            )
        found.append(existing[0])
    return found


def substitutions(root: Path) -> dict[str, Any]:
    """Collect the numbers that prose may quote.

    Parameters
    ----------
    root : Path
        Repository: the files `data/results/*.json` count.

    Returns
    -------
    dict from str to number, string or bool
        Nested names are joined by underscores, the file's own first: `single.mse` in
        `fig3.json` becomes `fig3_single_mse`, and a page writes
        `{{ fig3_single_mse }}`. Whatever cannot stand in a name becomes an underscore;
        lists longer than ten entries are left out. Text is shown as it is. `n_claims`
        counts the claims, `verdicts` says how many got which verdict.
    """
    flat: dict[str, Any] = {}

    def collect(name: str, value: Any) -> None:
        if isinstance(value, list) and len(value) > LONGEST:
            return
        if isinstance(value, dict | list):
            pairs = value.items() if isinstance(value, dict) else enumerate(value)
            for key, item in pairs:
                collect(re.sub(r"\W", "_", f"{name}_{key}"), item)
        else:
            flat[name] = plain(value) if isinstance(value, str) else value

    for file in sorted(root.glob("data/results/*.json")):
        collect(
            file.stem.replace("-", "_"), json.loads(file.read_text(encoding="utf-8"))
        )
    if (root / CLAIMS).is_file():
        flat["n_claims"] = len(load_claims(root / CLAIMS))
    if (root / VERDICTS).is_file():
        flat["verdicts"] = tally(json.loads((root / VERDICTS).read_text("utf-8")))
    return flat


def page_names(toc: Any) -> list[str]:
    """List the pages named anywhere in a table of contents.

    Parameters
    ----------
    toc : list or dict
        The table of contents, or a part of it.

    Returns
    -------
    list of str
        Names in order.

    Examples
    --------
    >>> page_names({"root": "index", "chapters": [{"file": "fig1"}]})
    ['index', 'fig1']
    """
    if isinstance(toc, list):
        return [name for item in toc for name in page_names(item)]
    if not isinstance(toc, dict):
        return []
    own = [toc[key] for key in ("root", "file") if key in toc]
    return own + [name for value in toc.values() for name in page_names(value)]


def _refuse_unfit(chapters: Sequence[Chapter]) -> None:
    """Refuse runs that wrote to stderr or show that a claim fails, all at once."""
    said = [
        f"{one.name}, {words}"
        for one in chapters
        for words in (*complaints(one.notebook), unmet(one.notebook))
        if words
    ]
    if said:
        raise BookError("\n".join(said))


def _stage(
    root: Path,
    stage: Path,
    chapters: Sequence[Chapter],
    pictures: Mapping[str, Sequence[Picture]],
) -> None:
    """Write what Jupyter Book reads: the executed book, and the data."""
    ignore = shutil.ignore_patterns("*.ipynb", "*.partial*", ".*")
    for folder in ("book", "data"):
        if (root / folder).exists():
            shutil.copytree(root / folder, stage / folder, ignore=ignore)
    book = stage / "book"
    for chapter in chapters:
        shown = with_provenance(chapter, pictures[chapter.name])
        write_notebook(shown, book / f"{chapter.name}.ipynb")
    write_gallery([one for own in pictures.values() for one in own], book)
    config = yaml.safe_load((root / "_config.yml").read_text(encoding="utf-8"))
    config.setdefault("parse", {})["myst_substitutions"] = substitutions(root)
    scripts = config["sphinx"]["config"].setdefault("html_js_files", [])
    scripts.append([SECONDS, {"defer": "defer"}])
    shutil.copy(root / "_toc.yml", book)
    fragments = claim_fragments(root, {page.stem for page in pages(root)})
    for name, text in fragments.items():
        (book / name).write_text(text, encoding="utf-8")
    write_opening([chapter.notebook for chapter in chapters], book)
    notebooks = [page for page in pages(root) if page.suffix == ".ipynb"]
    write_reference(root, stage, notebooks)
    # Jupyter Book finds these itself, but not in a path with brackets.
    known = {page.relative_to(root / "book") for page in pages(root)}
    texts = {f.relative_to(book) for f in book.rglob("*") if f.suffix in ENDINGS}
    config["exclude_patterns"] = sorted(map(str, texts - known))
    (book / "_config.yml").write_text(yaml.safe_dump(config), "utf-8")


def _complete(
    html: Path, root: Path, chapters: Sequence[Chapter], pictures: Sequence[Picture]
) -> None:
    """Add what is no page: MathJax, notebooks, figures as SVG, seconds."""
    (html / ".buildinfo").unlink()  # Sphinx's own, of folders on this machine
    script = distribution(MATHJAX).locate_file(f"{MATHJAX}/static/mathjax/{_MATHJAX}")
    (html / "_static" / "mathjax").mkdir(exist_ok=True)
    shutil.copy(str(script), html / "_static" / "mathjax")
    mend_backlinks(html)
    write_vectors(pictures, html / DOWNLOADS)
    for chapter in chapters:
        file = f"{chapter.name}.ipynb"
        shutil.copy(root / "book" / file, html / DOWNLOADS)
        write_notebook(chapter.notebook, html / "_sources" / file)
    (html / "_static" / SECONDS).write_text(seconds_script(chapters), encoding="utf-8")
