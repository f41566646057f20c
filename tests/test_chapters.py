"""The chapters themselves: what their cells may hold, and that each of them runs."""

import json
import re
from pathlib import Path

import pytest

from press._captions import BEGINNING
from press._chapters import run_chapters
from press._notebook import (
    alternative_text,
    code_cells,
    complaints,
    parameters,
    read_notebook,
    source,
    unmet,
)

ROOT = Path(__file__).parents[1]
CHAPTERS = sorted((ROOT / "book").glob("*.ipynb"))
CACHE = ROOT / "_build" / "cache"  # of `make book`: what holds runs once


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_chapter_is_clean(path):
    notebook = read_notebook(path)
    saved = json.dumps(notebook, indent=1, ensure_ascii=False, sort_keys=True)
    assert path.read_text(encoding="utf-8") == f"{saved}\n", "as JupyterLab saves it"
    declared = parameters(notebook)
    assert not declared or "profile" in declared
    for number, cell in enumerate(code_cells(notebook), start=1):
        where = f"code cell {number}"
        assert not cell["outputs"], where
        assert cell["execution_count"] is None, where
        assert not re.search(r"^\s*(async )?(def|class) ", source(cell), re.M), where
        assert len(source(cell).splitlines()) <= 10, where


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_chapter_runs_and_its_images_have_alternative_text(path):
    given = {"profile": "quick"} if parameters(read_notebook(path)) else {}
    [done] = run_chapters({path: given}, root=ROOT, cache=CACHE)
    assert not complaints(done.notebook)
    assert unmet(done.notebook) == ""
    for cell in code_cells(done.notebook):
        if any("image/png" in output.get("data", {}) for output in cell["outputs"]):
            assert cell["metadata"]["mystnb"]["image"]["alt"], source(cell)


FIGURES = sorted((ROOT / "book").glob("fig*.ipynb"))


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_a_figure_s_chapter_says_what_to_see_and_what_differs(path):
    cells = read_notebook(path)["cells"]
    drawn = [number for number, cell in enumerate(cells) if alternative_text(cell)]
    for number in drawn:
        assert source(cells[number + 1]).startswith(BEGINNING), source(cells[number])
    beside = source(cells[drawn[0] + 2])
    assert "msc-beside" in beside
    claim, finding = re.findall(r":::\{grid-item-card\} (.+)", beside)
    assert (claim, finding) == ("The paper", "Here")
    assert "Its Figure" in beside
    assert "{cite}`paper`" in beside
    text = "\n".join(source(c) for c in cells if c["cell_type"] == "markdown")
    heads = re.findall("^## (.+)$", text, re.MULTILINE)
    assert heads[-2:] == ["What differs from the paper", "How it was made"]
