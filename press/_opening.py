"""The drawing that opens the book: a chapter has made it, the first page shows it.

That page runs no code. It includes `opening.html`: what the cell tagged `opening` of
some chapter showed.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from press._notebook import Notebook, code_cells, source, tags

FILE = "opening.html"
TAG = "opening"


def write_opening(runs: Iterable[Notebook], folder: Path) -> None:
    """Write what the cell tagged `opening` showed as HTML.

    Parameters
    ----------
    runs : iterable of dict
        Chapters with their outputs; if none has such a cell, nothing is written.
    folder : Path
        Where the pages are laid out.

    Raises
    ------
    ValueError
        If there is more than one such cell, or it showed no HTML.
    """
    cells = [cell for run in runs for cell in code_cells(run) if TAG in tags(cell)]
    if not cells:
        return
    if len(cells) > 1:
        raise ValueError(f"{len(cells)} cells are tagged {TAG!r}; wanted one at most")
    shown = [
        "".join(output["data"]["text/html"])
        for output in cells[0]["outputs"]
        if "text/html" in output.get("data", {})
    ]
    if not shown:
        line = source(cells[0]).strip().splitlines()[-1]
        raise ValueError(f"the cell tagged {TAG!r} ({line}) shows no HTML")
    (folder / FILE).write_text(shown[-1], encoding="utf-8")
