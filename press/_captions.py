"""Figures of a book have numbers and captions, whatever a chapter draws them with.

An extension of Sphinx. The directive ``caption`` stands right after the cell that draws
a figure, and makes of both one figure that Sphinx numbers::

    :::{caption}
    What to see. Whatever follows in further paragraphs stands below it.
    :::
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

BEGINNING = ":::{caption}"  # of a cell that holds a caption, and nothing else
FIGURE = "msc-figure"  # class of what Sphinx numbers


def setup(app: "Sphinx") -> dict[str, Any]:
    """Take part in a build, which may read in parallel."""
    from docutils import nodes  # noqa: PLC0415 (only Sphinx has loaded it)
    from sphinx.util.docutils import SphinxDirective  # noqa: PLC0415

    class Caption(SphinxDirective):
        """Make a figure that has its caption only, as yet."""

        has_content = True

        def run(self) -> list[nodes.Node]:
            """Read the words."""
            words = nodes.Element()
            self.state.nested_parse(self.content, self.content_offset, words)
            first, *others = words.children
            figure = nodes.figure("", classes=[FIGURE])
            figure += nodes.caption("", "", *first.children)
            if others:
                figure += nodes.legend("", *others)
            self.set_source_info(figure)
            return [figure]

    app.add_directive("caption", Caption)
    app.connect("doctree-read", lambda _, page: gather_figures(page))
    return {"parallel_read_safe": True}


def gather_figures(page: "document") -> None:
    """Move the cells that draw figures to their captions.

    Parameters
    ----------
    page : document
        What Sphinx read; it is changed.

    Raises
    ------
    ValueError
        If no cell stands right before a caption.
    """
    from docutils import nodes  # noqa: PLC0415 (only Sphinx has loaded it)

    for figure in [*page.findall(nodes.figure)]:
        if FIGURE not in figure["classes"]:
            continue
        place = figure.parent.index(figure)
        cell = figure.parent[place - 1] if place else figure
        if "cell" not in cell.get("classes", ()):
            raise ValueError(
                f"{page.get('source')}: no cell right before the caption "
                f"{figure.astext()[:60]!r}"
            )
        figure.parent.remove(cell)
        figure.insert(0, cell)
