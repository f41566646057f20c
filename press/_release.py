"""What is handed on: the book as a folder and a zip; and proof that bytes repeat."""

from __future__ import annotations

import filecmp
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path

from press._book import IN_USE, build_book
from press._chapters import BookError
from press._environment import environment
from press._files import locked
from press._provenance import SECONDS

# What two builds of one commit may differ in: how long the chapters took.
MAY_DIFFER = frozenset({f"_static/{SECONDS}"})

# What a book is built from.
_SOURCES = (
    "CHANGELOG.md",
    "CITATION.cff",
    "_config.yml",
    "_toc.yml",
    "benchmarks",
    "book",
    "data",
    "msc",
    "tests",
)
_EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip can hold


def release_name(root: Path) -> str:
    """Name what is handed on.

    Parameters
    ----------
    root : Path
        The repository.

    Returns
    -------
    str
        ``"msc-book-"`` and the version.
    """
    text = (root / "pyproject.toml").read_text(encoding="utf-8")
    return f"msc-book-{tomllib.loads(text)['project']['version']}"


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
        If the book is not built.
    ValueError
        If it is being built.
    """
    html, name = root / "_build" / "html", release_name(root)
    if not (html / "index.html").is_file():
        raise FileNotFoundError(
            f"{html} has no index.html: build the book first, by `make book`"
        )
    folder = root / "_build" / "release" / name
    target = folder.with_name(f"{name}.zip")
    with locked(html.parent, IN_USE.format(html.parent)):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(html, folder)
        pack(folder, target)
    return target


def pack(folder: Path, target: Path) -> None:
    """Pack a folder so that equal contents give equal bytes.

    Parameters
    ----------
    folder : Path
        What to pack; its name comes first in each name inside.
    target : Path
        The zip.
    """
    with zipfile.ZipFile(target, "w") as archive:
        for file in sorted(path for path in folder.rglob("*") if path.is_file()):
            name = file.relative_to(folder.parent).as_posix()
            entry = zipfile.ZipInfo(name, _EARLIEST)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file.read_bytes())


def build_twice(
    root: Path,
    *,
    profile: str = "quick",
    jobs: int = 2,
    say: Callable[[str], object] | None = None,
) -> list[str]:
    """Build the book, and again from nothing by a copy of the code in another folder.

    Parameters
    ----------
    root : Path
        The repository. Its own book is built as `make book` does, from runs that hold.
    profile : {"quick", "full"}, default "quick"
        How much the chapters compute.
    jobs : int, default 2
        How many chapters are executed at a time.
    say : callable, optional
        Is told in a line which chapter is executed here, and why.

    Returns
    -------
    list of str
        Files that differ, but for `MAY_DIFFER`.

    Raises
    ------
    BookError
        If the copy cannot be built; it has printed why.
    """
    here = build_book(root=root, profile=profile, jobs=jobs, say=say).parent
    with tempfile.TemporaryDirectory(prefix="msc-twice-") as temporary:
        copy = Path(temporary, "elsewhere")
        copy.mkdir()
        for name in _SOURCES:
            source = root / name
            if source.is_dir():
                shutil.copytree(source, copy / name)
            elif source.is_file():
                shutil.copy(source, copy)
        command = [sys.executable, "-m", "msc", "book", "--profile", profile]
        command += ["--jobs", str(jobs)]
        chosen = environment(copy / "_build" / "cache")
        if subprocess.run(command, cwd=copy, env=chosen, check=False).returncode:
            raise BookError("the book could not be built again elsewhere")
        there = copy / "_build" / "html"
        return [name for name in differences(here, there) if name not in MAY_DIFFER]


def differences(one: Path, other: Path) -> list[str]:
    """List the files in which two folders differ.

    Parameters
    ----------
    one, other : Path
        The folders.

    Returns
    -------
    list of str
        Names relative to the folders: contents differ, or only one has the file.
    """
    files = [
        {path.relative_to(top).as_posix() for path in top.rglob("*") if path.is_file()}
        for top in (one, other)
    ]
    shared = sorted(files[0] & files[1])
    _, different, unreadable = filecmp.cmpfiles(one, other, shared, shallow=False)
    return sorted({*(files[0] ^ files[1]), *different, *unreadable})
