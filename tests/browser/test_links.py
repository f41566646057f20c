"""Links: within the book each leads somewhere; out of it each has a sound address.

Only the files are read here. Addresses outside are not looked up: a book's tests must
not fail because a host is down. They are listed in `_build/links.txt`.
"""

import posixpath
import re
from collections import Counter
from urllib.parse import unquote, urlsplit

import pytest
from built import HTML, PAGES, ROOT, built, read

FILES = sorted(file.relative_to(HTML).as_posix() for file in HTML.rglob("*.html"))
FILES = [file for file in FILES if not file.startswith("_static/")]

# Anchors that a script makes, or that every browser knows.
MADE = {"", "top"}

UNFINISHED = re.compile(
    r"localhost|127\.0\.0\.1|0\.0\.0\.0|example\.(com|org|net)|\.(local|test|invalid)\b|"
    r"todo|fixme|xxx|your[-_ ]|username|placeholder|[<>{}\s]|%7b|%3c",
    re.IGNORECASE,
)


def is_external(link):
    parts = urlsplit(link)
    return bool(parts.scheme or parts.netloc)


def dangling(file, link):
    """Say what is wrong with a link from a file to another; empty if nothing."""
    parts = urlsplit(link)
    if parts.path.startswith("/"):
        return "begins at the host, not at the book: breaks below a prefix"
    here = posixpath.dirname(file)
    path = posixpath.normpath(posixpath.join(here, unquote(parts.path)))
    target = HTML / (path if parts.path else file)
    if path.startswith("..") or not target.is_file():
        return "no such file in the book"
    if not target.stat().st_size:
        return "the file is empty"
    anchor = unquote(parts.fragment)
    if target.suffix == ".html" and anchor not in MADE | set(read(target).ids):
        return f"no element there has the id {anchor!r}"
    return ""


def unsound(link):
    """Say what is wrong with the form of an external address; empty if nothing."""
    parts = urlsplit(link)
    if parts.scheme == "mailto":
        return "" if re.fullmatch(r"[^@\s]+@[^@\s]+\.\w+", parts.path) else "no address"
    if parts.scheme != "https":
        return "not https"
    if found := UNFINISHED.search(link):
        return f"unfinished: {found[0]}"
    if not re.fullmatch(r"([\w-]+\.)+[a-z]{2,}", parts.hostname or ""):
        return "no host"
    return "ends in punctuation" if re.search(r"[.,;:)\]'\"]$", link) else ""


def bad(file, links, fault):
    """Describe the bad ones among links."""
    faults = {link: fault(link) for link in dict.fromkeys(links)}
    return [f"{file}: {link!r}: {why}" for link, why in faults.items() if why]


def test_every_page_is_built_and_in_the_contents_of_the_first():
    missing = [name for name in PAGES if not built(name).is_file()]
    assert not missing, f"make book has not built: {missing}"
    listed = {urlsplit(link).path for link in read(built(PAGES[0])).links}
    lost = [name for name in PAGES[1:] if f"{name}.html" not in listed]
    assert not lost, f"{PAGES[0]}.html does not link to: {lost}"


@pytest.mark.parametrize("file", FILES)
def test_links_within_the_book_lead_somewhere(file):
    links = [link for link in read(HTML / file).links if not is_external(link)]
    assert not (found := bad(file, links, lambda link: dangling(file, link))), found


@pytest.mark.parametrize("file", FILES)
def test_files_that_a_page_loads_are_in_the_book(file):
    named = [one for one in read(HTML / file).resources if not one.startswith("data:")]

    def fault(name):
        return "on another host" if is_external(name) else dangling(file, name)

    assert not (found := bad(file, named, fault)), found


@pytest.mark.parametrize("file", FILES)
def test_external_links_are_sound(file):
    links = [link for link in read(HTML / file).links if is_external(link)]
    assert not (found := bad(file, links, unsound)), found


@pytest.mark.parametrize("file", FILES)
def test_no_anchor_is_there_twice(file):
    twice = [one for one, n in Counter(read(HTML / file).ids).items() if n > 1]
    assert not twice, f"{file}: {twice}"


def test_external_links_are_listed():
    lines = sorted(
        {
            f"{link}  ({file})"
            for file in FILES
            for link in read(HTML / file).links
            if is_external(link)
        }
    )
    report = ROOT / "_build" / "links.txt"
    report.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    assert report.read_text(encoding="utf-8").count("\n") == len(lines)


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ("https://doi.org/10.1109/IROS.2017.8206046", ""),
        ("mailto:someone@somewhere.org", ""),
        ("http://doi.org/10.1109/1", "not https"),
        ("javascript:void(0)", "not https"),
        ("//cdn.somewhere.org/x.js", "not https"),
        ("https://localhost:8000/", "unfinished: localhost"),
        ("https://github.com/USERNAME/msc", "unfinished: USERNAME"),
        ("https://example.org/x", "unfinished: example.org"),
        ("https://host/x", "no host"),
        ("https://somewhere.org/x.", "ends in punctuation"),
        ("mailto:someone", "no address"),
    ],
)
def test_what_is_sound(link, why):
    assert unsound(link) == why


@pytest.mark.parametrize(
    ("link", "why"),
    [
        ("#", ""),
        ("index.html", ""),
        ("../index.html", "no such file"),
        ("/index.html", "begins at the host"),
        ("nowhere.html", "no such file"),
        ("index.html#nowhere", "no element there has the id 'nowhere'"),
        ("#nowhere", "no element there has the id 'nowhere'"),
    ],
)
def test_what_dangles(link, why):
    assert dangling("index.html", link).startswith(why)
    assert bool(dangling("index.html", link)) == bool(why)
