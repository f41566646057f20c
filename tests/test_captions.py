"""A figure of the book is a cell's drawing and its caption, numbered together."""

import pytest
from docutils import nodes
from docutils.utils import new_document

from press._captions import BEGINNING, FIGURE, gather_figures
from press._chapters import Chapter, Record
from press._notebook import source
from press._pages import Picture, Subject, gallery_markdown, with_provenance


def cell(text):
    return nodes.container("", nodes.paragraph(text=text), classes=["cell"])


def caption(text):
    return nodes.figure("", nodes.caption(text=text), classes=[FIGURE])


def test_a_cell_and_the_caption_after_it_are_one_figure():
    page = new_document("book/page.ipynb")
    page += [cell("one"), cell("two"), caption("What to see."), nodes.paragraph()]
    gather_figures(page)
    first, figure, _ = page.children
    assert first.astext() == "one"
    assert [child.astext() for child in figure] == ["two", "What to see."]


def test_a_caption_without_a_cell_before_it_is_refused():
    page = new_document("book/page.ipynb")
    page += [cell("one"), nodes.paragraph(text="words"), caption("What to see.")]
    with pytest.raises(ValueError, match=r"page\.ipynb: no cell .* 'What to see\.'"):
        gather_figures(page)


def test_figures_of_other_pages_stay_as_they_are():
    page = new_document("book/page.md")
    page += nodes.figure("", nodes.image(uri="a.png"), nodes.caption(text="A."))
    before = page.pformat()
    gather_figures(page)
    assert page.pformat() == before


def picture(chapter, number, place):
    alt = "Two *lines*. They cross."
    return Picture(chapter, chapter.title(), number, place, alt, png=b"", svg="")


def test_every_figure_has_one_caption_and_what_made_it_stands_below():
    def some(kind, text):
        return {"cell_type": kind, "metadata": {}, "source": text}

    own = f"{BEGINNING}\nWords.\n:::"
    cells = [some("code", "a"), some("code", "b"), some("markdown", own)]
    record = Record(code="", files={}, packages={}, environment={}, seconds=1.0)
    chapter = Chapter("one", {"cells": cells}, record, {})
    pictures = [picture("one", 1, 0), picture("one", 2, 1)]
    done = with_provenance(chapter, pictures, Subject())["cells"]
    texts = [source(one).partition(" html")[0] for one in done]
    made, lines = "```{raw}", f"{BEGINNING}\nTwo \\*lines\\*.\n:::"
    assert texts == ["a", lines, made, "b", own, made]


def test_cards_have_the_numbers_of_cells():
    pictures = [picture("one", 1, 4), picture("one", 2, 4), picture("two", 1, 0)]
    text = gallery_markdown(pictures)
    told = [line for line in text.splitlines() if line.startswith("Figure ")]
    assert told == [f"Figure {number} of this book" for number in (1, 1, 2)]
