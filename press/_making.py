"""A page shows its figure first, and how that was made at its end.

An extension of Sphinx. In a notebook cells stand in the order in which they run, so
that parameters and loading come before the figure. On its page those with the tag
``how`` stand under its last heading, which is to be `HEADING`.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

HEADING = "How it was made"
TAG = "how"


def setup(app: "Sphinx") -> dict[str, Any]:
    """Take part in a build, which may read in parallel."""
    app.connect("doctree-read", lambda _, page: move_making(page))
    return {"parallel_read_safe": True}


def move_making(page: "document") -> None:
    """Move the cells that say how a page was made under its last heading.

    Parameters
    ----------
    page : document
        What Sphinx read; it is changed.

    Raises
    ------
    ValueError
        If there are such cells, and the last heading is another.
    """
    from docutils import nodes  # noqa: PLC0415 (only Sphinx has loaded it)

    cells = [
        node
        for node in page.findall(nodes.container)
        if {"cell", f"tag_{TAG}"} <= set(node["classes"])
    ]
    if not cells:
        return
    sections = [*page.findall(nodes.section)]
    last = sections[-1] if sections else None
    if last is None or last.next_node(nodes.title).astext() != HEADING:
        raise ValueError(
            f"{page.get('source')}: cells with the tag {TAG!r}, and the last heading "
            f"is not {HEADING!r}"
        )
    for cell in cells:
        cell.parent.remove(cell)
        last.append(cell)
