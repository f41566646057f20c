"""The figures of executed chapters: as files to download, and small on one page."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from press import _notebook as nb

SVG, PNG = "image/svg+xml", "image/png"
DOWNLOADS = "downloads"  # folder of the finished book
THUMBNAILS = "_thumbnails"  # folder of the staged book
GALLERY = "figures_gallery.md"
_SIZE = (480, 360)  # no thumbnail is larger (pixels)


@dataclass(frozen=True)
class Picture:
    """A figure of a chapter.

    Attributes
    ----------
    chapter : str
        The chapter's name.
    title : str
        The chapter's title.
    number : int
        Which of the chapter's figures, from 1.
    cell : int
        Place of its cell in the executed notebook.
    alt : str
        What it shows, in words; empty if the cell does not say.
    png : bytes
        The figure in pixels.
    svg : str
        The figure in lines; empty if it has only pixels.
    """

    chapter: str
    title: str
    number: int
    cell: int
    alt: str
    png: bytes
    svg: str

    @property
    def name(self) -> str:
        """File name without ending."""
        return f"{self.chapter}-{self.number}"


def find_pictures(chapter: str, notebook: nb.Notebook) -> list[Picture]:
    """Find the figures of an executed chapter.

    Parameters
    ----------
    chapter : str
        Its name.
    notebook : dict
        The chapter with outputs.

    Returns
    -------
    list of Picture
        In the order of the page.
    """
    found: list[Picture] = []
    title = nb.title(notebook)
    for place, cell in enumerate(notebook["cells"]):
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if PNG in data:
                picture = Picture(
                    chapter,
                    title,
                    number=len(found) + 1,
                    cell=place,
                    alt=nb.alternative_text(cell),
                    png=base64.b64decode("".join(data[PNG])),
                    svg="".join(data.get(SVG, "")),
                )
                found.append(picture)
    return found


def without_lines(notebook: nb.Notebook) -> nb.Notebook:
    """Leave SVG out of an executed chapter: pages show PNG, and link to the SVG.

    Parameters
    ----------
    notebook : dict
        The chapter with outputs.

    Returns
    -------
    dict
        The same, without the data of type SVG.
    """

    def lighter(output: nb.Cell) -> nb.Cell:
        data = output.get("data", {})
        if SVG not in data or PNG not in data:
            return output
        kept = {kind: value for kind, value in data.items() if kind != SVG}
        return output | {"data": kept}

    cells = [
        cell | {"outputs": [lighter(output) for output in cell["outputs"]]}
        if "outputs" in cell
        else cell
        for cell in notebook["cells"]
    ]
    return notebook | {"cells": cells}


def write_vectors(pictures: Sequence[Picture], folder: Path) -> None:
    """Write the figures that consist of lines as SVG.

    Parameters
    ----------
    pictures : sequence of Picture
        The figures.
    folder : Path
        Where to; created if missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        if picture.svg:
            (folder / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")


def write_gallery(pictures: Sequence[Picture], book: Path) -> None:
    """Write a thumbnail of each figure, and what the page that shows them includes.

    Parameters
    ----------
    pictures : sequence of Picture
        The figures.
    book : Path
        Folder of the staged book.
    """
    (book / THUMBNAILS).mkdir(exist_ok=True)

    def save_small(picture: Picture) -> None:
        with Image.open(io.BytesIO(picture.png)) as image:
            small = image.convert("RGB")
        small.thumbnail(_SIZE, Image.Resampling.LANCZOS, reducing_gap=2.0)
        small.quantize(64, dither=Image.Dither.NONE).save(
            book / THUMBNAILS / f"{picture.name}.png", optimize=True
        )

    with ThreadPoolExecutor() as pool:
        list(pool.map(save_small, pictures))
    (book / GALLERY).write_text(gallery_markdown(pictures), encoding="utf-8")


def gallery_markdown(pictures: Sequence[Picture]) -> str:
    """Write the page of thumbnails.

    Parameters
    ----------
    pictures : sequence of Picture
        The figures.

    Returns
    -------
    str
        Markdown: a card a figure, which leads to its chapter; a sentence if there is
        no figure.
    """
    if not pictures:
        return "*No chapter draws a figure.*\n"
    cards = "\n".join(_card(picture, pictures) for picture in pictures)
    return f"::::{{grid}} 1 2 2 3\n:gutter: 3\n\n{cards}\n::::\n"


def _card(picture: Picture, pictures: Sequence[Picture]) -> str:
    siblings = [other for other in pictures if other.chapter == picture.chapter]
    which = f" ({picture.number})" if len(siblings) > 1 else ""
    return (
        f":::{{grid-item-card}} {picture.title}{which}\n"
        f":link: {_option(picture.chapter)}\n:link-type: doc\n"
        f":img-top: {_option(f'{THUMBNAILS}/{picture.name}.png')}\n"
        f":img-alt: {_option(picture.alt or picture.title)}\n"
        ":class-card: msc-thumbnail\n"
        ":::\n"
    )


def _option(text: str) -> str:
    """Write text as the value of a directive's option, which is YAML."""
    return json.dumps(" ".join(text.split()), ensure_ascii=False)
