"""Render a staged book as HTML; of an earlier rendering, keep what was read.

Sphinx reads pages into trees and then writes these as HTML. Reading takes longer, above
all of the pages made from docstrings, so trees of unchanged pages are kept. All pages
are written each time: a heading shows up on the pages around it too.
"""

import filecmp
import hashlib
import os
import re
import shutil
import sysconfig
from collections.abc import Callable
from pathlib import Path

from press._chapters import BookError, run_tool

_WORK = "_build"  # of Jupyter Book, within the stage: trees, and the HTML
_CONDITIONS = "conditions"  # file there: what the trees depend on besides their pages


def lay_out(stage: Path, write: Callable[[Path], None]) -> None:
    """Write a stage anew, but leave the time of what comes out as it was.

    By the time of a page's last change Sphinx knows whether to read it again.

    Parameters
    ----------
    stage : Path
        The folder.
    write : callable
        Writes it; is given the folder, which does not exist yet.
    """
    former = stage.with_name(f"{stage.name}.former")
    shutil.rmtree(former, ignore_errors=True)
    if stage.exists():
        stage.rename(former)
    write(stage)
    for file in stage.rglob("*"):
        before = former / file.relative_to(stage)
        if before.is_file() and filecmp.cmp(before, file, shallow=False):
            shutil.copystat(before, file)
    if (former / _WORK).exists():
        (former / _WORK).rename(stage / _WORK)
    shutil.rmtree(former, ignore_errors=True)


def render(stage: Path) -> Path:
    """Render a staged book, without executing anything.

    Parameters
    ----------
    stage : Path
        The folder; its `book/` holds the pages, their configuration and table of
        contents. The folder `cache` beside it holds the home of processes.

    Returns
    -------
    Path
        Folder of the finished pages, the same as if nothing had been kept.

    Raises
    ------
    BookError
        If a page does not render without a warning. Then all trees are given up, so
        that the next rendering warns again.
    """
    work = stage / _WORK
    html, conditions = work / "html", work / _CONDITIONS
    now = _conditions(stage / "book")
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


def _conditions(book: Path) -> str:
    """Identify what any page may depend on: settings, our code, installed packages."""
    settings = [book / "_config.yml", book / "_toc.yml"]
    code = sorted(Path(__file__).parents[1].glob("[mp]*/**/*.py"))
    packages = Path(sysconfig.get_path("purelib")).glob("*.dist-info")
    digest = hashlib.sha256("\n".join(sorted(p.name for p in packages)).encode())
    for file in (*settings, *code):
        digest.update(file.read_bytes())
    return digest.hexdigest()
