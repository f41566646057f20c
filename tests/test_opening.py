"""What the first page shows comes from the cells that are tagged, one a tag."""

import pytest

from press._pages import SHOWN, write_shown

SLIDER = {"data": {"text/html": ["<div>\n", "</div>"], "image/png": "…"}}
WORDS = {"output_type": "stream", "text": "words"}


def run(tag, *cells):
    """Return a chapter with its outputs: a cell for each list of them."""
    return {
        "cells": [
            {
                "cell_type": "code",
                "source": "import this\nshow(it)",
                "metadata": {"tags": ["hide-input", tag] if outputs else []},
                "outputs": outputs,
            }
            for outputs in cells
        ]
    }


@pytest.mark.parametrize("tag", SHOWN)
def test_the_tagged_cell_is_written(tmp_path, tag):
    write_shown(iter([run(tag, []), run(tag, [], [WORDS, SLIDER])]), tmp_path)
    (written,) = tmp_path.iterdir()
    assert written.name == f"{tag}.html"
    assert written.read_text("utf-8") == "<div>\n</div>"


def test_each_tag_has_its_file(tmp_path):
    write_shown([run("opening", [SLIDER]), run("matrix", [SLIDER])], tmp_path)
    assert {one.name for one in tmp_path.iterdir()} == set(SHOWN.values())


def test_a_book_may_have_none(tmp_path):
    write_shown([run("opening", [])], tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("tag", SHOWN)
def test_two_are_refused(tmp_path, tag):
    with pytest.raises(ValueError, match=rf"2 cells are tagged '{tag}'; wanted one"):
        write_shown([run(tag, [SLIDER]), run(tag, [SLIDER])], tmp_path)


@pytest.mark.parametrize("tag", SHOWN)
def test_a_cell_without_html_is_refused(tmp_path, tag):
    with pytest.raises(ValueError, match=rf"'{tag}' \(show\(it\)\) shows no HTML"):
        write_shown([run(tag, [WORDS])], tmp_path)
