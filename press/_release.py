"""What is handed on: the book as a folder, zip and PDF; and proof that bytes repeat.

On paper all pages are one, with a title page and contents; Chromium prints it, as
`print.css` says. Sliders give way to their pictures, what is folded is opened, links
between pages become links within the document. All bytes depend on the book alone.
"""

import filecmp
import html as markup
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import unquote

import yaml

from press._book import IN_USE, build_book, page_names, pages, read_toc
from press._chapters import BookError
from press._edition import (
    ARCHIVAL,
    find_edition,
    offer,
    told_edition,
    withdraw,
)
from press._files import locked
from press._kernel import is_aside
from press._pages import SECONDS_JS, Subject
from press._processes import environment

T = TypeVar("T")

# What two builds of one commit may differ in: how long the chapters took.
MAY_DIFFER = frozenset({f"_static/{SECONDS_JS}"})

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
_STYLE = Path(__file__).with_name("print.css")
_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip can hold
_EPOCH = b"D:20000101000000"  # the same for every PDF, as long as what Chromium writes


def release_name(root: Path) -> str:
    """Name what is handed on: the project's name, "book" and its version."""
    text = (root / "pyproject.toml").read_text(encoding="utf-8")
    project = tomllib.loads(text)["project"]
    return f"{project['name']}-book-{project['version']}"


def release_book(root: Path) -> Path:
    """Pack the built book; whoever unpacks it opens `index.html`, without a network.

    Parameters
    ----------
    root : Path
        The repository, whose `_build/html` holds the book.

    Returns
    -------
    Path
        The zip in `_build/release/`, beside a folder with the same content. Its bytes
        depend on the book alone.

    Raises
    ------
    FileNotFoundError
        If `root` holds no book, or the book is not built.
    ValueError
        If it is being built.
    """
    read_toc(root)
    html, name = root / "_build" / "html", release_name(root)
    if not (html / "index.html").is_file():
        raise FileNotFoundError(
            f"{html} has no index.html: build the book first, by `make book`"
        )
    folder = root / "_build" / "release" / name
    target = folder.with_name(f"{name}.zip")
    with locked(html.parent, IN_USE.format(html.parent)):
        shutil.rmtree(folder, ignore_errors=True)
        made = shutil.ignore_patterns(f"{release_name(root)}.*")
        shutil.copytree(html, folder, ignore=made)
        index = folder / "index.html"
        index.write_text(withdraw(index.read_text("utf-8")), "utf-8")
        pack(folder, target)
        offer(html, "zip", target)
    return target


def pack(folder: Path, target: Path) -> None:
    """Pack a folder, whose name comes first inside; equal contents give equal bytes."""
    with zipfile.ZipFile(target, "w") as archive:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            name = file.relative_to(folder.parent).as_posix()
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file.read_bytes())


# The book again


def build_twice(
    root: Path,
    *,
    profile: str = "quick",
    jobs: int = 2,
    subject: Subject | None = None,
    say: Callable[[str], object] | None = None,
    whole: bool = False,
) -> list[str]:
    """Build the book, and again by a copy of the code in another folder.

    There all pages are rendered from nothing, but of the chapters a fifth is executed,
    which one the commit decides: five commits have each executed about once. The
    others' runs are taken from here.

    Parameters
    ----------
    root : Path
        The repository. Its own book is built as by `build_book`, from runs that hold.
    profile : {"quick", "full"}, default "quick"
        How much the chapters compute.
    jobs : int, default 2
        How many chapters are executed at a time.
    subject : Subject, optional
        What the book is about; the copy is built by its program.
    say : callable, optional
        Is told in a line which chapter is executed here, and why; and which are again.
    whole : bool, default False
        Execute all chapters again.

    Returns
    -------
    list of str
        Files that differ, but for `MAY_DIFFER`.

    Raises
    ------
    BookError
        If the copy cannot be built; it has printed why.
    """
    root, subject = root.resolve(), subject or Subject()
    here = build_book(profile=profile, jobs=jobs, root=root, subject=subject, say=say)
    with tempfile.TemporaryDirectory(prefix="twice-") as temporary:
        copy = Path(temporary, "elsewhere")

        def aside(folder: str, names: list[str]) -> list[str]:
            inside = Path(folder).relative_to(root)
            return [name for name in names if is_aside(str(inside / name))]

        shutil.copytree(root, copy, ignore=aside)
        edition = find_edition(root)
        (copy / ARCHIVAL).write_text(edition.archival, encoding="utf-8")
        names = [page.stem for page in pages(root) if page.suffix == ".ipynb"]
        again = names if whole else pick_some(names, edition.commit, every=5)
        if say:
            say(f"executed again elsewhere: {', '.join(again)}")
        cache = copy / "_build" / "cache"
        cache.mkdir(parents=True)
        for run in (root / "_build" / "cache").glob("*.ipynb"):
            if run.stem.rpartition("-")[0] not in again:
                shutil.copy(run, cache)
        module = subject.program.split()[-1]
        command = [sys.executable, "-m", module, "book", "--profile", profile]
        command += ["--jobs", str(jobs)]
        chosen = environment(cache)
        if subprocess.run(command, cwd=copy, env=chosen, check=False).returncode:
            raise BookError("the book could not be built again elsewhere")
        there = copy / "_build" / "html"
        return [n for n in differences(here.parent, there) if n not in MAY_DIFFER]


def pick_some(names: Sequence[T], commit: str, every: int) -> list[T]:
    """Pick every so manieth of some names, the first of them by the commit.

    >>> pick_some(["one", "two", "three", "four"], commit="", every=3)
    ['one', 'four']
    """
    return list(names[sum(commit.encode()) % every :: every])


def differences(one: Path, other: Path) -> list[str]:
    """List the files in which two folders differ, or that only one of them has."""
    files = [
        {path.relative_to(top).as_posix() for path in top.rglob("*") if path.is_file()}
        for top in (one, other)
    ]
    shared = sorted(files[0] & files[1])
    _, different, unreadable = filecmp.cmpfiles(one, other, shared, shallow=False)
    return sorted({*(files[0] ^ files[1]), *different, *unreadable})


# On paper


def print_book(root: Path) -> Path:
    """Print the built book as a PDF.

    Parameters
    ----------
    root : Path
        The repository, whose `_build/html` holds the book.

    Returns
    -------
    Path
        The PDF, in `_build/release/`.

    Raises
    ------
    FileNotFoundError
        If `root` holds no book, the book is not built, or there is no Chromium.
    ValueError
        If the book is being built.
    BookError
        If Chromium prints nothing.
    """
    build, toc = root.resolve() / "_build", read_toc(root)
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise FileNotFoundError(
            f"no browser to print with: none of {', '.join(BROWSERS)} is installed"
        )
    config = yaml.safe_load((root / "_config.yml").read_text(encoding="utf-8"))
    text = one_page(build / "html", toc, config["title"], config["author"])
    page = build / "book.html"
    target = build / "release" / f"{release_name(root)}.pdf"
    target.parent.mkdir(exist_ok=True)
    with locked(build, IN_USE.format(build)):
        page.write_text(text, encoding="utf-8")
        target.unlink(missing_ok=True)
        said = _print(browser, page, target)
        if not target.exists():
            last_words = (said.strip() or "it said nothing").splitlines()[-1]
            raise BookError(f"{Path(browser).name} printed nothing: {last_words}")
        target.write_bytes(without_dates(target.read_bytes()))
        offer(build / "html", "pdf", target)
    return target


def without_dates(pdf: bytes) -> bytes:
    """Replace the dates in a PDF by a fixed one; nothing moves.

    >>> without_dates(b"<</CreationDate (D:20261122220550+00'00')>>")
    b"<</CreationDate (D:20000101000000+00'00')>>"
    """
    return re.sub(rb"(/(?:Creation|Mod)Date ?\()D:\d{14}", rb"\1" + _EPOCH, pdf)


def one_page(html: Path, toc: Mapping[str, Any], title: str, author: str) -> str:
    """Join the pages of a finished book to one, in HTML that is to stand beside it."""
    names = page_names(toc)
    if missing := [name for name in names if not (html / f"{name}.html").is_file()]:
        raise FileNotFoundError(
            f"{html} has no {missing[0]}.html: build the book first, by `make book`"
        )
    pages = {n: (html / f"{n}.html").read_text(encoding="utf-8") for n in names}
    first = pages[names[0]] = withdraw(pages[names[0]])
    head = re.search(r"<head>(.*?)</head>", first, re.DOTALL)
    styles = re.findall(r'<link[^>]*rel="stylesheet"[^>]*>', head[1] if head else "")
    everything = "".join(pages.values())
    # MathJax and its settings, from whichever page has an equation.
    scripts = [
        found[0]
        for pattern in (
            r"<script>window\.MathJax.*?</script>",
            r'<script[^>]*src="[^"]*mathjax[^"]*"[^>]*></script>',
        )
        if (found := re.search(pattern, everything))
    ]
    bodies = [
        f'<article class="bd-article" id="{markup.escape(name)}">'
        f"{_body(name, text, names)}</article>"
        for name, text in pages.items()
    ]
    titles = {name: _title(text) for name, text in pages.items()}
    front = (
        f'<header class="msc-title"><h1>{markup.escape(title)}</h1>'
        f"<p>{markup.escape(author)}</p><p>{told_edition(first)}</p>"
        '<img src="_static/reach.png" alt=""></header>'
        f'<nav class="msc-contents"><h1>Contents</h1>{_contents(toc, titles)}</nav>'
    )
    page = "\n".join(
        [
            '<!DOCTYPE html>\n<html lang="en" data-theme="light" data-mode="light">',
            f'<head><meta charset="utf-8"><title>{markup.escape(title)}</title>',
            *styles,
            f"<style>{_STYLE.read_text(encoding='utf-8')}</style>",
            *scripts,
            f"</head>\n<body>{front}",
            *bodies,
            "</body></html>\n",
        ]
    )
    return re.sub(r'((?:src|<link[^>]*href)=")(?=_)', rf"\1{html.name}/", page)


def _print(browser: str, page: Path, target: Path) -> str:
    """Print a page as a PDF; return what the browser wrote to stderr."""
    with tempfile.TemporaryDirectory(prefix="print-") as profile:
        return subprocess.run(
            [
                browser,
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-background-networking",
                "--no-first-run",
                "--no-pdf-header-footer",
                "--generate-pdf-document-outline",
                "--virtual-time-budget=60000",
                f"--user-data-dir={profile}",
                f"--print-to-pdf={target}",
                page.as_uri(),
            ],
            env=environment(page.with_name("cache")),
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            check=False,
        ).stderr


def _contents(toc: Mapping[str, Any], titles: Mapping[str, str]) -> str:
    """Write links to all pages, part by part."""

    def links(entries: Any) -> str:
        items = [
            f'<li><a href="#{markup.escape(name)}">{titles[name]}</a></li>'
            for name in page_names(entries)
        ]
        return f"<ul>{''.join(items)}</ul>"

    text = links([{"root": toc["root"]}]) if "root" in toc else ""
    for part in toc.get("parts") or [{"chapters": toc.get("chapters", [])}]:
        if "caption" in part:
            text += f"<p>{markup.escape(part['caption'])}</p>"
        text += links(part["chapters"])
    return text


def _title(page: str) -> str:
    """Return the text of a page's first heading."""
    found = re.search(r"<h1>(.*?)</h1>", page, re.DOTALL)
    heading = re.sub(r'<a class="headerlink".*?</a>', "", found[1] if found else "")
    return re.sub(r"<[^>]+>", "", heading).strip()


def _body(name: str, page: str, names: Sequence[str]) -> str:
    """Return a page's text with names and links that hold in the whole document."""
    found = re.search(r"<article[^>]*>(.*)</article>", page, re.DOTALL)
    text = found[1] if found else ""
    text = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    text = re.sub(r'<a class="headerlink".*?</a>', "", text, flags=re.DOTALL)
    text = re.sub(r"<button.*?</button>", "", text, flags=re.DOTALL)
    text = re.sub(r"<details\b", "<details open", text)
    # A film would be caught at any moment; it has a picture beside it.
    text = re.sub(r'src="_images/(\w+)\.gif"', r'src="_static/\1.png"', text)
    text = re.sub(
        r'(\s(?:id|for|name|aria-labelledby)=")',
        lambda found: f"{found[1]}{markup.escape(name)}--",
        text,
    )

    def link(match: re.Match[str]) -> str:
        before, address, after, content = match.groups()
        file, _, anchor = unquote(markup.unescape(address)).partition("#")
        target = file.removesuffix(".html") if file else name
        if target in names:
            address = markup.escape(f"#{target}--{anchor}" if anchor else f"#{target}")
        elif not re.match(r"[a-z]+:", address):  # a file beside the book
            return f"<span>{content}</span>"
        return f'<a{before}href="{address}"{after}>{content}</a>'

    return re.sub(
        r'<a((?:\s[^>]*?)?\s)href="([^"]*)"([^>]*)>(.*?)</a>',
        link,
        text,
        flags=re.DOTALL,
    )
