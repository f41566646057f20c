"""Chapters by papermill alone: what they import needs no Jupyter Book and no Sphinx."""

import ast
import subprocess
import sys
from pathlib import Path

from press._notebook import code_cells, read_notebook, source

ROOT = Path(__file__).parents[1]
BLOCKED = ("jupyter_book", "sphinx", "myst_nb", "myst_parser", "docutils")
BLOCK = f"""
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {BLOCKED}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Missing())
"""


def imports():
    """Return every import of any chapter as a line."""
    found = {}
    for path in sorted((ROOT / "book").glob("*.ipynb")):
        for cell in code_cells(read_notebook(path)):
            for node in ast.walk(ast.parse(source(cell))):
                if isinstance(node, ast.Import | ast.ImportFrom):
                    found[ast.unparse(node)] = None
    return list(found)


def run(code):
    command = [sys.executable, "-c", BLOCK + code]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=False
    )


def test_all_that_chapters_import_is_there_without_the_book():
    lines = imports()
    assert any(line.startswith("from msc") for line in lines)
    assert run("\n".join(lines)).stderr == ""


def test_the_book_s_own_tools_are_missed_where_they_are_blocked():
    assert "ModuleNotFoundError" in run("import jupyter_book").stderr
