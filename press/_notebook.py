"""Notebooks as the files they are: JSON of the notebook format 4.

A chapter is a notebook without outputs; papermill returns a run of it: the same code
cells with outputs, and one more, *injected*, that sets the parameters it was given.
"""

import json
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from press._files import replace_file
from press._parameters import WORDS, Parameter, declared

Notebook = dict[str, Any]
NotebookCell = dict[str, Any]

_CELL = {"cell_type", "metadata", "source"}  # what every cell has
_LONGEST = 400  # that an error quotes of what a cell wrote

# The last two rows of a table's head, as pandas writes them, and a cell there.
_HEAD_ROWS = re.compile(
    r"(<tr[^>]*>\s*)((?:<th\b[^>]*>[^<]*</th>\s*)+)</tr>\s*"
    r"<tr[^>]*>\s*((?:<th\b[^>]*>[^<]*</th>\s*)+)(</tr>\s*</thead>)"
)
_HEAD = re.compile(r"<th\b([^>]*)>([^<]*)</th>")


def read_notebook(path: Path) -> Notebook:
    """Read a notebook; a file that is none is a ValueError that names it."""
    try:
        notebook: Notebook = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path.name} is not a notebook: {error}") from error
    if not (isinstance(notebook, dict) and isinstance(notebook.get("cells"), list)):
        raise ValueError(f"{path.name} is not a notebook: it has no cells")
    for number, cell in enumerate(notebook["cells"], start=1):
        if not (isinstance(cell, dict) and cell.keys() >= _CELL):
            raise ValueError(
                f"{path.name} is not a notebook: cell {number} lacks "
                f"one of {', '.join(sorted(_CELL))}"
            )
    return notebook


def write_notebook(notebook: Notebook, path: Path) -> None:
    """Write a notebook, whole or not at all."""
    text = json.dumps(notebook, indent=1, ensure_ascii=False)
    replace_file(path, text + "\n")


# What is in a notebook


def code_cells(notebook: Notebook) -> list[NotebookCell]:
    """Return the author's own code cells: all but the injected one."""
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    return [cell for cell in cells if "injected-parameters" not in tags(cell)]


def tags(cell: NotebookCell) -> set[str]:
    """Return a cell's tags."""
    return set(cell["metadata"].get("tags", ()))


def source(cell: NotebookCell) -> str:
    """Return a cell's text, which its file holds whole or as a list of lines."""
    return "".join(cell["source"])


def shown(cell: NotebookCell, kind: str) -> list[str]:
    """Return what a code cell's outputs show, of one MIME type."""
    data = [output.get("data", {}) for output in cell.get("outputs", ())]
    return ["".join(one[kind]) for one in data if kind in one]


def alternative_text(cell: NotebookCell) -> str:
    """Return what a cell's figure shows, in words; empty if the cell does not say."""
    text: str = cell["metadata"].get("mystnb", {}).get("image", {}).get("alt", "")
    return text


def parameters(notebook: Notebook) -> dict[str, Parameter]:
    r"""Return what a chapter's cell tagged `parameters` assigns, in its order.

    >>> code = "n_samples = 24  # training tasks (2 to 360)\nseed: int = 0"
    >>> cell = {"source": code, "metadata": {"tags": ["parameters"]}}
    >>> for name, found in parameters({"cells": [cell]}).items():
    ...     print(name, tuple(found))
    n_samples ('24', 'training tasks', '2 to 360')
    seed ('0', '', '')
    """
    found: dict[str, Parameter] = {}
    for cell in notebook["cells"]:
        if "parameters" in tags(cell):
            found |= declared(source(cell))
    return found


def title(notebook: Notebook) -> str:
    """Return a chapter's first heading; empty if it has none.

    >>> cell = {"cell_type": "markdown", "source": "# Figure 1: worlds", "metadata": {}}
    >>> title({"cells": [cell]})
    'Figure 1: worlds'
    """
    texts = [source(c) for c in notebook["cells"] if c["cell_type"] == "markdown"]
    return first_heading("\n".join(texts))


def first_heading(text: str) -> str:
    """Return the first heading of Markdown; empty if it has none."""
    found = re.search(r"^# (.*)$", text, re.MULTILINE)
    return found[1].strip() if found else ""


# Runs


def with_outputs(chapter: Notebook, run: Notebook) -> Notebook:
    """Put the outputs of a run into a chapter's current text.

    The injected cell is hidden from the book's pages, papermill's record of paths and
    times is left behind, and the corners of pandas' tables are plain cells.
    """
    hidden = {"tags": ["injected-parameters", "remove-cell"]}
    fixed = {"metadata": hidden, "id": "injected-parameters"}
    injected = [
        {key: fixed.get(key, value) for key, value in cell.items()}
        for cell in run["cells"]
        if "injected-parameters" in tags(cell)
    ]
    runs = iter(code_cells(run))
    cells = []
    for cell in chapter["cells"]:
        if cell["cell_type"] == "code":
            done = next(runs)
            outputs = [_readable_tables(output) for output in done["outputs"]]
            count = done["execution_count"]
            cells.append(cell | {"outputs": outputs, "execution_count": count})
        else:
            cells.append(cell)
        if "parameters" in tags(cell):
            cells += injected
    return chapter | {"cells": cells}


def failure(run: Notebook) -> str:
    """Name the cell at which a run stopped, and its error; empty if none failed."""
    for where, cell in reversed([*_named(run)]):
        for output in cell["outputs"]:
            if output["output_type"] == "error":
                return f"{where}: {output['ename']}: {output['evalue']}"
    return ""


def complaints(run: Notebook) -> list[str]:
    """Name the cells that wrote to stderr, and what, cut where that is long."""
    found = []
    for where, cell in _named(run):
        streams = [out for out in cell["outputs"] if out.get("name") == "stderr"]
        if text := "".join("".join(stream["text"]) for stream in streams):
            short = textwrap.shorten(text, _LONGEST, placeholder=" …")
            found.append(f"{where} wrote to stderr: {short}")
    return found


def unmet(run: Notebook) -> str:
    """Name the first cell whose claims do not hold, and them; empty if all hold."""
    for number, cell in enumerate(code_cells(run), start=1):
        for words in shown(cell, "text/plain"):
            if words.startswith(WORDS):
                return f"code cell {number}: {' '.join(words.split())}"
    return ""


def without_picture(run: Notebook) -> str:
    """Name the first cell with alternative text that shows no picture."""
    for where, cell in _named(run):
        if alternative_text(cell) and not shown(cell, "image/png"):
            return where
    return ""


def _named(run: Notebook) -> Iterator[tuple[str, NotebookCell]]:
    """Yield each code cell, and its number and first line to name it."""
    for number, cell in enumerate(code_cells(run), start=1):
        first_line = source(cell).strip().partition("\n")[0]
        yield f"code cell {number} ({first_line})", cell


def _readable_tables(output: dict[str, Any]) -> dict[str, Any]:
    """Give tables of pandas one row of heads where it writes two, and yes and no.

    Names of what stands in a row's head have a row of their own, below the columns';
    they move into the corner above. Whatever heads are empty then are plain cells.
    Truth is told in words.
    """
    data = output.get("data", {})
    if "text/html" not in data:
        return output
    html = _HEAD_ROWS.sub(_join_heads, "".join(data["text/html"]))
    html = re.sub(r"<th\b([^>]*)></th>", r"<td\1></td>", html)
    html = html.replace("<td>True</td>", "<td>yes</td>")
    html = html.replace("<td>False</td>", "<td>no</td>")
    return output | {"data": data | {"text/html": html}}


def _join_heads(rows: re.Match[str]) -> str:
    """Move names of row heads into the row above, beside what columns are named."""
    begin, first, second, end = rows.groups()
    above, below = _HEAD.findall(first), _HEAD.findall(second)
    named = [bool(text) for _, text in below]
    n_names = len(named) - named[::-1].index(True) if any(named) else 0
    corner, over = above[:n_names], any(text for _, text in above[: n_names - 1])
    if not 0 < n_names < len(below) == len(above) or over:
        return rows[0]
    names = below[:n_names]
    if of_columns := corner[-1][1]:
        look, text = names[-1]
        names[-1] = look, f"{text} ↓ {of_columns} →"
    cells = [f"<th{look}>{text}</th>" for look, text in [*names, *above[n_names:]]]
    return f"{begin}{''.join(cells)}{end}"
