"""A page shows its figure first, and how that was made at its end."""

import json
from pathlib import Path

import pytest
from docutils import nodes
from docutils.utils import new_document

from press._making import HEADING, TAG, move_making

BOOK = Path(__file__).parents[1] / "book"


def cell(text, *tags):
    classes = ["cell", *(f"tag_{tag}" for tag in tags)]
    return nodes.container("", nodes.paragraph(text=text), classes=classes)


def section(title, *children):
    return nodes.section("", nodes.title(text=title), *children, ids=[title])


def page_of(*last):
    page = new_document("book/page.ipynb")
    first = [cell("parameters", TAG), cell("load", TAG), cell("figure", "hide-input")]
    page += section("Figure", *first, nodes.paragraph(text="words"), *last)
    return page


def texts(page):
    return [node.astext() for node in page.findall(nodes.paragraph)]


def test_cells_move_under_the_last_heading_in_their_order():
    page = page_of(section("More"), section(HEADING, nodes.paragraph(text="by hand")))
    move_making(page)
    assert texts(page) == ["figure", "words", "by hand", "parameters", "load"]
    assert page.astext().index(HEADING) < page.astext().index("parameters")


def test_a_page_without_such_cells_stays(monkeypatch):
    page = new_document("book/page.ipynb")
    page += section("Title", cell("figure"), section("Another"))
    before = page.pformat()
    move_making(page)
    assert page.pformat() == before


def test_without_the_heading_there_is_no_place_for_them():
    with pytest.raises(
        ValueError, match=r"page\.ipynb: .* 'how', and the last heading"
    ):
        move_making(page_of(section(HEADING), section("After")))
    page = new_document("book/page.ipynb")
    page += cell("parameters", TAG)
    with pytest.raises(ValueError, match="the last heading is not"):
        move_making(page)


@pytest.mark.parametrize("path", sorted(BOOK.glob("fig*.ipynb")), ids=lambda p: p.stem)
def test_a_figure_s_chapter_shows_it_before_anything_else(path):
    cells = json.loads(path.read_text("utf-8"))["cells"]
    title, *others = cells
    assert title["source"][0].startswith("# ")
    assert len(title["source"]) == 1
    hidden = {"remove-cell", TAG}
    shown = [c for c in others if not hidden & set(c["metadata"].get("tags", ()))]
    assert "alt" in shown[0]["metadata"].get("mystnb", {}).get("image", {})
