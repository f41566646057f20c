"""The drawing that opens the book comes from the one cell that is tagged."""

import pytest

from press._pages import write_opening

SLIDER = {"data": {"text/html": ["<div>\n", "</div>"], "image/png": "…"}}
WORDS = {"output_type": "stream", "text": "words"}


def run(*cells):
    """Return a chapter with its outputs: a cell for each list of them."""
    return {
        "cells": [
            {
                "cell_type": "code",
                "source": "import this\nshow(it)",
                "metadata": {"tags": ["hide-input", "opening"] if outputs else []},
                "outputs": outputs,
            }
            for outputs in cells
        ]
    }


def test_the_tagged_cell_is_written(tmp_path):
    write_opening([run([]), run([], [WORDS, SLIDER])], tmp_path)
    assert (tmp_path / "opening.html").read_text("utf-8") == "<div>\n</div>"


def test_a_book_may_have_none(tmp_path):
    write_opening([run([])], tmp_path)
    assert not list(tmp_path.iterdir())


def test_two_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"2 cells are tagged 'opening'; wanted one"):
        write_opening([run([SLIDER]), run([SLIDER])], tmp_path)


def test_a_cell_without_html_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"'opening' \(show\(it\)\) shows no HTML"):
        write_opening([run([WORDS])], tmp_path)
