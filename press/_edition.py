"""Which book this is: version, date, commit; how to cite it; where its files are.

The commit is asked of git. Where there is none, a file tells it: `git archive` writes
it into `.git_archival.txt`, as `.gitattributes` asks for, and so does whoever copies a
repository without its `.git`. Without either a book has a version alone. The date is
the commit's, so that two builds of one commit are the same.

One setting, `repository.url` in `_config.yml`, says where the repository is. As long as
it is empty, a book has no buttons and no links that would need it.
"""

import re
import shutil
import subprocess
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import yaml

from press._markup import fenced

ARCHIVAL = ".git_archival.txt"
EDITION, CITE = "edition.md", "cite.md"  # what pages include
DOWNLOADS = "downloads"  # folder of the finished book
BINDER = "https://mybinder.org"
_BUTTONS = ("use_repository_button", "use_edit_page_button", "use_issues_button")
_OFFERED = re.compile(r'(<span data-take="(\w+)">).*?(</span>)')
_LINE = re.compile(r'<p class="msc-edition">(.*?)</p>', re.DOTALL)


@dataclass(frozen=True)
class Edition:
    """What tells one build of a book from another."""

    version: str = ""
    commit: str = ""  # its whole name
    day: str = ""  # of the commit, as 2026-11-28
    changed: bool = False  # files that git knows differ from the commit

    @property
    def words(self) -> str:
        """What a reader is told.

        >>> Edition("0.1.0", "6a7c48b0", "2026-11-28").words
        'Version 0.1.0, 28 November 2026, commit 6a7c48b'
        """
        parts = [f"Version {self.version}"] if self.version else []
        if self.commit:
            day = date.fromisoformat(self.day)
            parts += [f"{day.day} {day:%B %Y}", f"commit {self.commit[:7]}"]
        return ", ".join(parts) + (" and changes since" if self.changed else "")

    @property
    def archival(self) -> str:
        """The commit as `ARCHIVAL` has it."""
        lines = {"node": self.commit, "node-date": self.day}
        lines |= {"changed": "yes"} if self.changed else {}
        return "".join(f"{name}: {value}\n" for name, value in lines.items())


def find_edition(root: Path) -> Edition:
    """Find out which version and commit of a repository is built.

    Parameters
    ----------
    root : Path
        The repository.

    Returns
    -------
    Edition
        Without a commit if neither git nor the file `ARCHIVAL` knows of one.
    """
    version, project = "", root / "pyproject.toml"
    if project.is_file():
        version = tomllib.loads(project.read_text("utf-8"))["project"]["version"]
    if told := _ask_git(root, "log", "-1", "--format=%H %cs"):
        changed = bool(_ask_git(root, "status", "--porcelain", "--untracked-files=no"))
        commit, day = told.split()
        return Edition(version, commit, day, changed)
    archival = root / ARCHIVAL
    lines = archival.read_text("utf-8").splitlines() if archival.is_file() else ()
    known = dict(line.split(": ", 1) for line in lines)
    if (commit := known.get("node", "")).isalnum():  # and no "$Format:%H$"
        return Edition(version, commit, known["node-date"], "changed" in known)
    return Edition(version)


def _ask_git(root: Path, *question: str) -> str:
    """Ask git of the very repository; empty if there is none, or no git."""
    git = shutil.which("git")
    if git is None or not (root / ".git").exists():
        return ""
    command = [git, "-C", str(root), *question]
    asked = subprocess.run(command, capture_output=True, text=True, check=False)
    return asked.stdout.strip() if asked.returncode == 0 else ""


# What pages include


def write_edition(root: Path, book: Path, config: Mapping[str, Any]) -> None:
    """Write what the first page includes: which edition it is, and how to cite it."""
    edition, address = find_edition(root), repository(config)
    where = f' · <a href="{address}">repository</a>' if address else ""
    takes = "".join(f'<span data-take="{kind}"></span>' for kind in ("pdf", "zip"))
    line = f'<p class="msc-edition">{edition.words}{where}{takes}</p>'
    (book / EDITION).write_text(fenced(line, "{raw} html") + "\n", encoding="utf-8")
    entries = bibtex(root, edition, address)
    block = fenced(f":class: msc-cite\n\n{entries}", "{code-block} bibtex")
    (book / CITE).write_text(f"{block}\n", encoding="utf-8")


def bibtex(root: Path, edition: Edition, address: str = "") -> str:
    """Write `CITATION.cff` as BibTeX, and what it refers to as the book's own entries.

    Parameters
    ----------
    root : Path
        The repository; without that file nothing is written.
    edition : Edition
        Its version, date and commit.
    address : str, optional
        Where the repository is.

    Returns
    -------
    str
        Entries.
    """
    source = root / "CITATION.cff"
    if not source.is_file():
        return ""
    cited = yaml.safe_load(source.read_text(encoding="utf-8"))
    fields = {
        "author": " and ".join(map(_name, cited["authors"])),
        "title": f"{{{cited['title']}}}",
        "version": edition.version or str(cited["version"]),
        "year": edition.day[:4],
        "note": f"Commit {edition.commit[:7]}" if edition.commit else "",
        "url": address,
    }
    rows = [f"  {key} = {{{value}}},\n" for key, value in fields.items() if value]
    key = re.split(r"\W", cited["title"])[0].lower()
    found = root / "book" / "references.bib"
    known = found.read_text(encoding="utf-8") if found.is_file() else ""
    entries = re.findall(r"^@\w+\{.*?^\}$", known, re.DOTALL | re.MULTILINE)
    titles = [one["title"] for one in cited.get("references", ())]
    others = [one for one in entries if any(f"{{{title}}}" in one for title in titles)]
    return "\n\n".join([f"@software{{{key},\n{''.join(rows)}}}", *others])


def _name(author: Mapping[str, str]) -> str:
    """Write an author for BibTeX: a person, or an entity in braces."""
    if "family-names" in author:
        return f"{author['family-names']}, {author.get('given-names', '')}".rstrip(", ")
    return f"{{{author['name']}}}"


# Where the repository is


def repository(config: Mapping[str, Any]) -> str:
    """Return the address that a book's settings give; empty if none."""
    return str(config.get("repository", {}).get("url") or "").rstrip("/")


def with_repository(config: Mapping[str, Any]) -> dict[str, Any]:
    """Add to a book's settings what needs the repository's address, if there is one.

    Parameters
    ----------
    config : mapping
        What `_config.yml` holds.

    Returns
    -------
    dict
        With buttons that lead to the repository, edit a page, open an issue or start
        Binder; without an address as if nothing had been said of a repository.

    Examples
    --------
    >>> with_repository({"title": "Arms", "repository": {"url": ""}})
    {'title': 'Arms'}
    """
    others = {key: value for key, value in config.items() if key != "repository"}
    if not (address := repository(config)):
        return others
    shown = others.get("html", {}) | dict.fromkeys(_BUTTONS, True)
    launch = {"binderhub_url": BINDER, "notebook_interface": "jupyterlab"}
    place = config["repository"] | {"url": address}
    return others | {"repository": place, "html": shown, "launch_buttons": launch}


def source_address(config: Mapping[str, Any]) -> str:
    """Return where files of the repository are shown; empty without an address."""
    branch = config.get("repository", {}).get("branch", "main")
    address = repository(config)
    return f"{address}/blob/{branch}" if address else ""


# What is made of a finished book


def told_edition(page: str) -> str:
    """Return what a finished first page says of its edition, as text."""
    found = _LINE.search(withdraw(page))
    return re.sub(r"<[^>]+>", "", found[1]).strip() if found else ""


def offer(html: Path, kind: str, file: Path) -> None:
    """Have a finished book's first page lead to a file made of it.

    Parameters
    ----------
    html : Path
        The finished book.
    kind : {"pdf", "zip"}
        Which.
    file : Path
        It is copied into the book.
    """
    shutil.copy(file, html / DOWNLOADS)
    index = html / "index.html"
    link = f' · <a href="{DOWNLOADS}/{file.name}" download>{kind.upper()}</a>'

    def fill(place: re.Match[str]) -> str:
        return f"{place[1]}{link}{place[3]}" if place[2] == kind else place[0]

    text = index.read_text(encoding="utf-8")
    index.write_text(_OFFERED.sub(fill, text), encoding="utf-8")


def withdraw(page: str) -> str:
    """Take from a finished first page what `offer` has put there."""
    return _OFFERED.sub(r"\1\3", page)
