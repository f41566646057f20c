"""Under every figure: what made it, and the one command that makes it again."""

from __future__ import annotations

import hashlib
import html
import json
import shlex
from collections.abc import Sequence
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import quote

from press import _notebook as nb
from press._chapters import Chapter
from press._figures import DOWNLOADS, Picture
from press._markdown import fenced

# Packages that figures owe their numbers and looks to; others only carry them.
TELLING = ["python", "numpy", "scipy", "scikit-learn", "cvxpy", "pybullet", "pandas"]
TELLING += ["matplotlib", "pillow"]

SECONDS = "seconds.js"


def with_provenance(chapter: Chapter, pictures: Sequence[Picture]) -> nb.Notebook:
    """Put a block under each figure of an executed chapter.

    Parameters
    ----------
    chapter : Chapter
        The chapter.
    pictures : sequence of Picture
        Its figures. If it has none, the block stands at its end.

    Returns
    -------
    dict
        The chapter's notebook with one more cell a figure.
    """
    cells = list(chapter.notebook["cells"])
    if not pictures:
        cells.append(_cell(chapter, None))
    for picture in reversed(pictures):
        cells.insert(picture.cell + 1, _cell(chapter, picture))
    return chapter.notebook | {"cells": cells}


def provenance_html(chapter: Chapter, picture: Picture | None = None) -> str:
    """Write where a figure comes from.

    Parameters
    ----------
    chapter : Chapter
        The chapter that makes it.
    picture : Picture, optional
        The figure; without, the block is about the chapter.

    Returns
    -------
    str
        HTML: a block that is opened by a click. Seconds differ from run to run, so the
        page fetches them from the one file that holds them (`seconds_script`).
    """
    name, record = chapter.name, chapter.record
    given = chapter.parameters
    declared = {k: one.default for k, one in nb.parameters(chapter.notebook).items()}
    settings = ", ".join(
        _code(f"{key} = {value}")
        for key, value in (declared | {k: repr(v) for k, v in given.items()}).items()
    )
    modules = [file for file in record.files if file.endswith(".py")]
    inputs = [
        f"{_code(file)} {digest[:8]}"
        for file, digest in record.files.items()
        if file not in modules and PurePosixPath(file).suffix != ".js"
    ]
    together = hashlib.sha256("".join(record.files[m] for m in modules).encode())
    versions = [
        f"{'Python' if package == 'python' else package} "
        f"{html.escape(record.packages[package])}"
        for package in TELLING
        if package in record.packages
    ]
    links = [
        (f"_sources/{name}.ipynb", "executed notebook"),
        (f"{DOWNLOADS}/{name}.ipynb", "source notebook"),
    ]
    if picture and picture.svg:
        links.insert(0, (f"{DOWNLOADS}/{picture.name}.svg", "figure as SVG"))
    rows = {
        "Made by": f"{_code(f'book/{name}.ipynb')}"
        f'<span data-seconds="{html.escape(name)}"></span>'
        + (f", {settings}" if settings else ""),
        "From": ", ".join(inputs),
        "Code": f"{len(modules)} modules of msc, {together.hexdigest()[:8]}"
        if modules
        else "",
        "With": ", ".join(versions),
        "Again": _code(remake_command(chapter)),
        "Take": ", ".join(
            f'<a href="{quote(address)}" download>{what}</a>' for address, what in links
        ),
    }
    what = "figure" if picture else "chapter"
    return (
        '<details class="msc-provenance">\n'
        f"<summary>How this {what} was made</summary>\n<dl>\n"
        + "\n".join(f"<dt>{key}</dt><dd>{row}</dd>" for key, row in rows.items() if row)
        + "\n</dl>\n</details>\n"
    )


def remake_command(chapter: Chapter) -> str:
    """Say how a chapter is executed alone.

    Parameters
    ----------
    chapter : Chapter
        The chapter.

    Returns
    -------
    str
        A command line; it names only parameters that differ from the declared ones.
    """
    declared = nb.parameters(chapter.notebook)
    options = "".join(
        f" -p {name} {shlex.quote(str(value))}"
        for name, value in chapter.parameters.items()
        if name not in declared or declared[name].default != repr(value)
    )
    notebook = f"{chapter.name}.ipynb"
    source, target = shlex.quote(f"book/{notebook}"), shlex.quote(notebook)
    return f"msc run {source}{options} --out {target}"


def seconds_script(chapters: Sequence[Chapter]) -> str:
    """Write the one file of the book that differs between two runs of the chapters.

    Parameters
    ----------
    chapters : sequence of Chapter
        The chapters.

    Returns
    -------
    str
        JavaScript that writes each chapter's seconds where its pages want them.
    """
    seconds: dict[str, Any] = {c.name: round(c.record.seconds, 1) for c in chapters}
    return (
        f"const seconds = {json.dumps(seconds, indent=2)};\n"
        'for (const place of document.querySelectorAll("[data-seconds]")) {\n'
        "  place.textContent = ` in ${seconds[place.dataset.seconds]} s`;\n"
        "}\n"
    )


def _cell(chapter: Chapter, picture: Picture | None) -> nb.Cell:
    number = picture.number if picture else 0
    return {
        "cell_type": "markdown",
        "id": f"provenance-{number}",
        "metadata": {},
        "source": fenced(provenance_html(chapter, picture), "{raw} html"),
    }


def _code(text: str) -> str:
    return f"<code>{html.escape(text)}</code>"
