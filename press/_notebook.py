"""Notebooks as the files they are: JSON of the notebook format 4.

A chapter is a notebook without outputs; papermill returns a run of it: the same code
cells with outputs, and one more, *injected*, that sets the parameters it was given.
"""

import json
import re
import textwrap
from pathlib import Path
from typing import Any

from press._files import replace_file
from press._parameters import Parameter, declared

Notebook = dict[str, Any]
Cell = dict[str, Any]

_CELL = {"cell_type", "metadata", "source"}  # what every cell has
_LONGEST = 400  # that an error quotes of what a cell wrote


def read_notebook(path: Path) -> Notebook:
    """Read a notebook.

    Parameters
    ----------
    path : Path
        An `.ipynb` file.

    Returns
    -------
    dict
        The notebook.

    Raises
    ------
    ValueError
        If the file is no notebook.
    """
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
    """Write a notebook, whole or not at all.

    Parameters
    ----------
    notebook : dict
        The notebook.
    path : Path
        The file; its folder is created if missing.
    """
    text = json.dumps(notebook, indent=1, ensure_ascii=False)
    replace_file(path, text + "\n")


def code_cells(notebook: Notebook) -> list[Cell]:
    """Return the author's own code cells.

    Parameters
    ----------
    notebook : dict
        A chapter or a run.

    Returns
    -------
    list of dict
        All code cells but the injected one.
    """
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    return [cell for cell in cells if "injected-parameters" not in tags(cell)]


def tags(cell: Cell) -> set[str]:
    """Return a cell's tags.

    Parameters
    ----------
    cell : dict
        Any cell.

    Returns
    -------
    set of str
        Possibly empty.
    """
    return set(cell["metadata"].get("tags", ()))


def source(cell: Cell) -> str:
    """Return a cell's text.

    Parameters
    ----------
    cell : dict
        Any cell; its file may hold the text whole or as a list of lines.

    Returns
    -------
    str
        The text.
    """
    return "".join(cell["source"])


def parameters(notebook: Notebook) -> dict[str, Parameter]:
    r"""Return what a chapter's cell tagged `parameters` assigns.

    Parameters
    ----------
    notebook : dict
        The chapter.

    Returns
    -------
    dict of str to Parameter
        By name, in the order of the cell; empty if no cell has the tag.

    Raises
    ------
    ValueError
        If the cell is no Python, or the values in a comment cannot be understood.

    Examples
    --------
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
    """Return a chapter's title.

    Parameters
    ----------
    notebook : dict
        The chapter.

    Returns
    -------
    str
        Its first heading; empty if it has none.

    Examples
    --------
    >>> cell = {"cell_type": "markdown", "source": "# Figure 1: worlds", "metadata": {}}
    >>> title({"cells": [cell]})
    'Figure 1: worlds'
    """
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            for line in source(cell).splitlines():
                if line.startswith("# "):
                    return line.removeprefix("# ").strip()
    return ""


def with_outputs(chapter: Notebook, run: Notebook) -> Notebook:
    """Put the outputs of a run into a chapter's current text.

    Parameters
    ----------
    chapter : dict
        The chapter as it is now.
    run : dict
        A run of a chapter with the same code cells.

    Returns
    -------
    dict
        The chapter with outputs and with the injected cell, hidden from the book's
        pages. papermill's record of paths and times is left behind, and the corners
        of pandas' tables are plain cells.
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
            outputs = [_without_empty_headers(output) for output in done["outputs"]]
            count = done["execution_count"]
            cells.append(cell | {"outputs": outputs, "execution_count": count})
        else:
            cells.append(cell)
        if "parameters" in tags(cell):
            cells += injected
    return chapter | {"cells": cells}


def failure(run: Notebook) -> str:
    """Name the cell at which a run stopped, and its error.

    Parameters
    ----------
    run : dict
        A run that papermill gave up.

    Returns
    -------
    str
        The cell's number among the code cells, its first line, the error and its text;
        empty if no cell failed.
    """
    for number, cell in reversed([*enumerate(code_cells(run), start=1)]):
        for output in cell["outputs"]:
            if output["output_type"] == "error":
                error = f"{output['ename']}: {output['evalue']}"
                return f"{_named(number, cell)}: {error}"
    return ""


def complaints(run: Notebook) -> list[str]:
    """Name the cells that wrote to stderr, and what.

    Parameters
    ----------
    run : dict
        A notebook with outputs.

    Returns
    -------
    list of str
        For each such cell its number among the code cells, its first line and what it
        wrote, cut where that is long.
    """
    found = []
    for number, cell in enumerate(code_cells(run), start=1):
        streams = [out for out in cell["outputs"] if out.get("name") == "stderr"]
        if text := "".join("".join(stream["text"]) for stream in streams):
            short = textwrap.shorten(text, _LONGEST, placeholder=" …")
            found.append(f"{_named(number, cell)} wrote to stderr: {short}")
    return found


def without_picture(run: Notebook) -> str:
    """Name a cell that should have shown a picture.

    Parameters
    ----------
    run : dict
        A notebook with outputs.

    Returns
    -------
    str
        The number among the code cells, and the first line, of the first cell that has
        alternative text but shows no picture; empty if there is none.
    """
    for number, cell in enumerate(code_cells(run), start=1):
        shown = {kind for output in cell["outputs"] for kind in output.get("data", ())}
        if alternative_text(cell) and "image/png" not in shown:
            return _named(number, cell)
    return ""


def alternative_text(cell: Cell) -> str:
    """Return what a cell's figure shows, in words.

    Parameters
    ----------
    cell : dict
        Any cell.

    Returns
    -------
    str
        Empty if the cell does not say.
    """
    text: str = cell["metadata"].get("mystnb", {}).get("image", {}).get("alt", "")
    return text


def _named(number: int, cell: Cell) -> str:
    first_line = source(cell).strip().partition("\n")[0]
    return f"code cell {number} ({first_line})"


def _without_empty_headers(output: dict[str, Any]) -> dict[str, Any]:
    """Turn header cells without text, which name nothing, into plain cells."""
    data = output.get("data", {})
    if "text/html" not in data:
        return output
    html = re.sub(r"<th\b([^>]*)></th>", r"<td\1></td>", "".join(data["text/html"]))
    return output | {"data": data | {"text/html": html}}
