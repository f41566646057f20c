"""Build the book: execute its chapters, lay out a staging folder, render it as HTML.

Everything happens under `_build/`: `cache/` keeps the runs of chapters, `stage/` what
Jupyter Book reads, `html/` the finished book. The last one is replaced only when a
whole new book is ready.

Sphinx reads pages into trees and then writes these as HTML. Reading takes longer, above
all of the pages made from docstrings, so trees of unchanged pages are kept. All pages
are written each time: a heading shows up on the pages around it too.
"""

import filecmp
import hashlib
import json
import os
import re
import shutil
import sysconfig
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import yaml

from press._chapters import (
    BookError,
    Chapter,
    ChapterError,
    find_changed,
    run_chapters,
)
from press._edition import (
    DOWNLOADS,
    source_address,
    with_repository,
    write_edition,
)
from press._files import locked
from press._junit import write_report
from press._markup import plain
from press._notebook import (
    complaints,
    first_heading,
    parameters,
    read_notebook,
    title,
    unmet,
    write_notebook,
)
from press._pages import (
    SECONDS_JS,
    Picture,
    Subject,
    find_pictures,
    seconds_script,
    with_provenance,
    without_lines,
    write_gallery,
    write_reference,
    write_shown,
    write_vectors,
)
from press._processes import run_tool

PROFILE_NAMES = ("quick", "full")
ENDINGS = (".ipynb", ".md", ".rst")  # of pages

# A list in a result file that is longer holds data, which no page quotes.
LONGEST = 10

IN_USE = "{} is in use by another build; wait for it or stop it"

# The package of the lock that carries MathJax: the book needs no network.
MATHJAX = "sphinx-mathjax-offline"
_MATHJAX = "tex-svg-full.js"

# Results hold thousands of numbers, which take seconds without the one in C.
_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

_WORK = "_build"  # of Jupyter Book, within the stage: trees, and the HTML
_CONDITIONS = "conditions"  # file there: what the trees depend on besides their pages


def build_book(
    *,
    profile: str = "quick",
    jobs: int = 2,
    root: Path | None = None,
    subject: Subject | None = None,
    say: Callable[[str], object] | None = None,
    junit: Path | None = None,
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
    subject : Subject, optional
        What the book is about; without, it is made of the repository alone.
    say : callable, optional
        Is told in a line which chapter is executed, and why.
    junit : Path, optional
        Where to report of each chapter, in JUnit's XML. Then all chapters are executed,
        though some may fail.

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
    root, subject = (root or Path.cwd()).resolve(), subject or Subject()
    given = _given(root, profile)
    build = root / "_build"
    build.mkdir(exist_ok=True)
    with locked(build, IN_USE.format(build)):
        failed: list[ChapterError] | None = [] if junit else None
        executed = run_chapters(
            given, root=root, cache=build / "cache", jobs=jobs, say=say, failed=failed
        )
        if junit:
            write_report(executed, failed or [], junit)
        _refuse_unfit(executed, failed or [])
        pictures = {one.name: find_pictures(one.name, one.notebook) for one in executed}
        chapters = [
            replace(one, notebook=without_lines(one.notebook)) for one in executed
        ]
        stage = build / "stage"
        _write_stage(stage, lambda: _stage(root, stage, chapters, pictures, subject))
        rendered = _render(stage, subject.packages)
        _complete(rendered, root, chapters, [p for o in pictures.values() for p in o])
        html = build / "html"
        shutil.rmtree(html, ignore_errors=True)
        rendered.rename(html)
        return html / "index.html"


def changed_chapters(
    *, profile: str = "quick", root: Path | None = None
) -> dict[str, str]:
    """Say which chapters `build_book` would execute, and why; execute none.

    Parameters
    ----------
    profile : {"quick", "full"}, default "quick"
        How much the chapters compute.
    root : Path, optional
        The repository; the working directory by default. Nothing is written there.

    Returns
    -------
    dict of str to str
        By chapter, in the order of the book, the reasons in one line.

    Raises
    ------
    ValueError
        If `profile` makes no sense.
    FileNotFoundError
        If `root` holds no book, or the book lacks a page of its table of contents.
    """
    root = (root or Path.cwd()).resolve()
    return find_changed(
        _given(root, profile), root=root, cache=root / "_build" / "cache"
    )


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
    found = []
    for name in page_names(read_toc(root)):
        sources = [root / "book" / f"{name}{ending}" for ending in ENDINGS]
        existing = [source for source in sources if source.exists()]
        if not existing:
            raise FileNotFoundError(
                f"_toc.yml lists {name}, but book/ has no {name} with one of the "
                f"endings {', '.join(ENDINGS)}"
            )
        found.append(existing[0])
    return found


def page_titles(root: Path) -> dict[str, str]:
    """Return the titles of all pages in the order of the table of contents.

    Parameters
    ----------
    root : Path
        Repository, as for `pages`.

    Returns
    -------
    dict of str to str
        By name: the first heading, as Markdown; of a page without one its name.
    """
    return {
        page.stem: title(read_notebook(page))
        if page.suffix == ".ipynb"
        else first_heading(page.read_text(encoding="utf-8")) or page.stem
        for page in pages(root)
    }


def read_toc(root: Path) -> Any:
    """Read the table of contents of the book that a repository holds."""
    toc = root / "_toc.yml"
    if not toc.exists():
        raise FileNotFoundError(f"{root} holds no book: it has no _toc.yml")
    return yaml.safe_load(toc.read_text(encoding="utf-8"))


def _notebooks(root: Path) -> list[Path]:
    """Return the pages that are chapters."""
    return [page for page in pages(root) if page.suffix == ".ipynb"]


def _given(root: Path, profile: str) -> dict[Path, dict[str, str]]:
    """Return the chapters, each with the profile if it declares that."""
    if profile not in PROFILE_NAMES:
        raise ValueError(f"profile={profile!r}; wanted one of {PROFILE_NAMES}")
    return {
        page: {"profile": profile}
        if "profile" in parameters(read_notebook(page))
        else {}
        for page in _notebooks(root)
    }


def page_names(toc: Any) -> list[str]:
    """List the pages named anywhere in a table of contents, in order.

    >>> page_names({"root": "index", "chapters": [{"file": "fig1"}]})
    ['index', 'fig1']
    """
    if isinstance(toc, list):
        return [name for item in toc for name in page_names(item)]
    if not isinstance(toc, dict):
        return []
    own = [toc[key] for key in ("root", "file") if key in toc]
    return own + [name for value in toc.values() for name in page_names(value)]


def substitutions(root: Path) -> dict[str, Any]:
    """Collect the numbers of `data/results/*.json` that prose may quote.

    Nested names are joined by underscores, the file's own first: `single.mse` in
    `fig3.json` becomes `fig3_single_mse`, and a page writes `{{ fig3_single_mse }}`.
    Whatever cannot stand in a name becomes an underscore. Text is shown as it is.
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
    return flat


def _refuse_unfit(chapters: Sequence[Chapter], failed: Sequence[ChapterError]) -> None:
    """Refuse runs that failed, wrote to stderr or contradict a claim, all at once."""
    said = [str(error) for error in failed]
    said += [
        f"{one.name}, {words}"
        for one in chapters
        for words in (*complaints(one.notebook), unmet(one.notebook))
        if words
    ]
    if said:
        raise BookError("\n".join(said))


def _write_stage(stage: Path, write: Callable[[], None]) -> None:
    """Have a stage written anew, but leave the time of what comes out as it was.

    By the time of a page's last change Sphinx knows whether to read it again.
    """
    former = stage.with_name(f"{stage.name}.former")
    shutil.rmtree(former, ignore_errors=True)
    if stage.exists():
        stage.rename(former)
    write()
    for file in stage.rglob("*"):
        before = former / file.relative_to(stage)
        if before.is_file() and filecmp.cmp(before, file, shallow=False):
            shutil.copystat(before, file)
    if (former / _WORK).exists():
        (former / _WORK).rename(stage / _WORK)
    shutil.rmtree(former, ignore_errors=True)


def _stage(
    root: Path,
    stage: Path,
    chapters: Sequence[Chapter],
    pictures: Mapping[str, Sequence[Picture]],
    subject: Subject,
) -> None:
    """Write what Jupyter Book reads: the executed book, and the data."""
    ignore = shutil.ignore_patterns("*.ipynb", "*.partial*", ".*")
    for folder in ("book", "data"):
        if (root / folder).exists():
            shutil.copytree(root / folder, stage / folder, ignore=ignore)
    book = stage / "book"
    config = yaml.safe_load((root / "_config.yml").read_text(encoding="utf-8"))
    address = source_address(config)
    for chapter in chapters:
        notebook = with_provenance(chapter, pictures[chapter.name], subject, address)
        write_notebook(notebook, book / f"{chapter.name}.ipynb")
    figures = [one for own in pictures.values() for one in own]
    write_gallery(figures, book, stage.with_name("cache") / "thumbnails")
    write_shown([chapter.notebook for chapter in chapters], book)
    write_edition(root, book, config)
    write_reference(root, stage, _notebooks(root), subject)
    for name, text in subject.fragments.items():
        (book / name).write_text(text, encoding="utf-8")
    shutil.copy(root / "_toc.yml", book)
    config = with_repository(config)
    values = substitutions(root) | dict(subject.values)
    config.setdefault("parse", {})["myst_substitutions"] = values
    scripts = config["sphinx"]["config"].setdefault("html_js_files", [])
    scripts.append([SECONDS_JS, {"defer": "defer"}])
    # Jupyter Book finds these itself, but not in a path with brackets.
    known = {page.relative_to(root / "book") for page in pages(root)}
    texts = {f.relative_to(book) for f in book.rglob("*") if f.suffix in ENDINGS}
    config["exclude_patterns"] = sorted(map(str, texts - known))
    (book / "_config.yml").write_text(yaml.dump(config, Dumper=_DUMPER), "utf-8")


def _render(stage: Path, packages: Sequence[str]) -> Path:
    """Render a staged book as if nothing had been kept of earlier ones.

    If a page does not render without a warning, all trees are given up, so that the
    next rendering warns again.
    """
    work = stage / _WORK
    html, conditions = work / "html", work / _CONDITIONS
    now = _conditions(stage / "book", packages)
    if conditions.exists() and conditions.read_text("utf-8") == now:
        shutil.rmtree(html, ignore_errors=True)
    else:
        shutil.rmtree(work, ignore_errors=True)
    arguments: list[str | Path] = ["build", stage / "book", "--path-output", stage]
    arguments += ["-W", "-n", "--keep-going", "--quiet"]
    result = run_tool(
        "jupyter_book.cli.main:main", arguments, cache=stage.with_name("cache")
    )
    if result.returncode != 0 or not (html / "index.html").exists():
        shutil.rmtree(work, ignore_errors=True)
        said = re.sub(r"\x1b\[[0-9;]*m", "", result.stderr or result.stdout)
        said = said.replace(f"{stage}{os.sep}", "")
        raise BookError(f"the book did not render:\n{said.strip()}")
    conditions.write_text(now, "utf-8")
    return html


def _conditions(book: Path, packages: Sequence[str]) -> str:
    """Identify what any page may depend on: settings, code, installed packages."""
    settings = [book / "_config.yml", book / "_toc.yml"]
    specs = [find_spec(name) for name in (*packages, "press")]
    folders = [
        Path(folder)
        for spec in specs
        for folder in (spec and spec.submodule_search_locations) or ()
    ]
    code = [file for folder in folders for file in sorted(folder.rglob("*.py"))]
    installed = Path(sysconfig.get_path("purelib")).glob("*.dist-info")
    digest = hashlib.sha256("\n".join(sorted(p.name for p in installed)).encode())
    for file in (*settings, *code):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _complete(
    html: Path, root: Path, chapters: Sequence[Chapter], pictures: Sequence[Picture]
) -> None:
    """Add what is no page: MathJax, notebooks, figures as SVG, seconds."""
    (html / ".buildinfo").unlink()  # Sphinx's own, of folders on this machine
    script = distribution(MATHJAX).locate_file(f"{MATHJAX}/static/mathjax/{_MATHJAX}")
    (html / "_static" / "mathjax").mkdir(exist_ok=True)
    shutil.copy(str(script), html / "_static" / "mathjax")
    write_vectors(pictures, html / DOWNLOADS)
    for chapter in chapters:
        file = f"{chapter.name}.ipynb"
        shutil.copy(root / "book" / file, html / DOWNLOADS)
        write_notebook(chapter.notebook, html / "_sources" / file)
    (html / "_static" / SECONDS_JS).write_text(
        seconds_script(chapters), encoding="utf-8"
    )
