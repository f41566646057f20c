"""Which edition a book says it is, how it is cited, and what needs an address."""

import json
import os
import shutil
import subprocess

import pytest
import yaml
from test_layers import ROOT

from press._edition import (
    ARCHIVAL,
    Edition,
    bibtex,
    find_edition,
    offer,
    repository,
    source_address,
    told_edition,
    with_repository,
    withdraw,
    write_edition,
)

WHEN = "2026-11-28T23:30:00-05:00"  # in universal time it is a day later


def git(root, *command):
    """Let git do something in a repository, whoever's machine this is."""
    names = "AUTHOR", "COMMITTER"
    who = {
        f"GIT_{name}_{part}": "a@b.org" for name in names for part in ("NAME", "EMAIL")
    }
    when = {f"GIT_{name}_DATE": WHEN for name in names}
    env = os.environ | who | when | {"GIT_CONFIG_GLOBAL": os.devnull}
    done = subprocess.run(
        ["git", *command], cwd=root, env=env, check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


@pytest.fixture
def archived(tmp_path):
    """Return a repository with a commit, and its name."""
    root = tmp_path / "repository"
    root.mkdir()
    for name in (".gitattributes", ARCHIVAL, "pyproject.toml", "CITATION.cff"):
        shutil.copy(ROOT / name, root)
    git(root, "init", "--quiet")
    git(root, "add", ".")
    git(root, "commit", "--quiet", "-m", "One")
    return root, git(root, "rev-parse", "HEAD")


def test_git_tells_commit_and_its_own_day(archived):
    root, commit = archived
    assert find_edition(root) == Edition("0.1.0", commit, "2026-11-28")


def test_a_change_since_is_told_and_a_new_file_is_none(archived):
    root, _ = archived
    (root / "new").write_text("", "utf-8")
    assert not find_edition(root).changed
    (root / "CITATION.cff").write_text("", "utf-8")
    assert find_edition(root).changed
    assert find_edition(root).words.endswith(" and changes since")


def test_an_archive_knows_its_commit_without_git(archived, tmp_path):
    root, _ = archived
    git(root, "archive", "--output", str(tmp_path / "one.tar"), "HEAD")
    there = tmp_path / "elsewhere"
    shutil.unpack_archive(tmp_path / "one.tar", there, filter="data")
    assert find_edition(there) == find_edition(root)


@pytest.mark.parametrize("changed", [False, True])
def test_so_does_a_copy_that_is_told(tmp_path, changed):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    edition = Edition("0.1.0", "6a7c48b0", "2026-11-28", changed)
    (tmp_path / ARCHIVAL).write_text(edition.archival, "utf-8")
    assert find_edition(tmp_path) == edition


def test_without_either_there_is_the_version_alone(tmp_path):
    assert find_edition(tmp_path) == Edition()
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for words in ((ROOT / ARCHIVAL).read_text("utf-8"), Edition().archival):
        (tmp_path / ARCHIVAL).write_text(words, "utf-8")
        assert find_edition(tmp_path) == Edition("0.1.0")
    assert find_edition(tmp_path).words == "Version 0.1.0"


def test_the_citation_has_one_source(archived):
    root, commit = archived
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert cited["version"] == find_edition(root).version
    (root / "book").mkdir()
    shutil.copy(ROOT / "book" / "references.bib", root / "book")
    ours, paper = bibtex(root, find_edition(root), "https://forge.org/arm").split(
        "\n\n"
    )
    for line in (
        "@software{msc,",
        "author = {{The msc authors}}",
        f"title = {{{{{cited['title']}}}}}",
        "year = {2026}",
        f"note = {{Commit {commit[:7]}}}",
        "url = {https://forge.org/arm}",
    ):
        assert line in ours
    assert paper.startswith("@misc{paper,")
    assert paper in (ROOT / "book" / "references.bib").read_text("utf-8")


def test_persons_are_named_as_bibtex_wants_them(tmp_path):
    person = {"family-names": "Doe", "given-names": "Jane"}
    cited = {"title": "arm: a book", "version": 1, "authors": [person, {"name": "We"}]}
    (tmp_path / "CITATION.cff").write_text(json.dumps(cited), "utf-8")
    entry = bibtex(tmp_path, Edition())
    assert "author = {Doe, Jane and {We}}" in entry
    assert not {"year", "note", "url"} & set(entry.split())


# Where the repository is


def test_our_address_is_empty_so_that_nothing_needs_it():
    config = yaml.safe_load((ROOT / "_config.yml").read_text("utf-8"))
    assert repository(config) == source_address(config) == ""
    html = config["html"]
    assert with_repository(config) == {
        key: value for key, value in config.items() if key != "repository"
    }
    assert not any(key.startswith("use_") for key in html)


def test_an_address_brings_buttons_and_links(tmp_path):
    place = {"url": "https://forge.org/arm/", "branch": "trunk"}
    config = {"html": {"favicon": "a.svg"}, "repository": place}
    full = with_repository(config)
    assert full["repository"] == {"url": "https://forge.org/arm", "branch": "trunk"}
    assert full["html"]["favicon"] == "a.svg"
    assert full["html"]["use_edit_page_button"] is True
    assert full["launch_buttons"]["binderhub_url"].startswith("https://")
    assert source_address(config) == "https://forge.org/arm/blob/trunk"
    write_edition(tmp_path, tmp_path, config)
    line = (tmp_path / "edition.md").read_text("utf-8")
    assert '<a href="https://forge.org/arm">repository</a>' in line


# What is made of a finished book


@pytest.fixture
def html(tmp_path):
    (tmp_path / "downloads").mkdir()
    write_edition(ROOT, tmp_path, {})
    shutil.move(tmp_path / "edition.md", tmp_path / "index.html")
    (tmp_path / "arm.pdf").write_bytes(b"%PDF")
    return tmp_path


def test_what_is_made_of_the_book_is_linked_until_it_is_withdrawn(html):
    index = html / "index.html"
    before = index.read_text("utf-8")
    assert "href" not in before
    offer(html, "pdf", html / "arm.pdf")
    offer(html, "pdf", html / "arm.pdf")
    after = index.read_text("utf-8")
    assert after.count('<a href="downloads/arm.pdf" download>PDF</a>') == 1
    assert (html / "downloads" / "arm.pdf").read_bytes() == b"%PDF"
    assert withdraw(after) == before
    assert told_edition(after) == find_edition(ROOT).words


def test_a_page_without_an_edition_tells_none():
    assert told_edition("<p>A book.</p>") == ""
