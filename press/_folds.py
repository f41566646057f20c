"""Pages of the package are an overview: a name, a sentence, and the rest folded.

An extension of Sphinx. Of what is documented from docstrings the first paragraph stays,
and what follows opens when it is clicked, or when a link leads into it (`sheets.js`).
"""

import html
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

FOLD = "msc-fold"


def setup(app: "Sphinx") -> dict[str, Any]:
    """Take part in a build, which may read in parallel."""
    app.connect("doctree-read", lambda _, page: fold_descriptions(page))
    return {"parallel_read_safe": True}


def fold_descriptions(page: "document") -> None:
    """Fold all of a description but its first paragraph, those within another excepted.

    Parameters
    ----------
    page : document
        What Sphinx read; it is changed.
    """
    from docutils import nodes  # noqa: PLC0415 (only Sphinx has loaded it)
    from sphinx import addnodes  # noqa: PLC0415

    def raw(text: str) -> nodes.raw:
        return nodes.raw("", text, format="html")

    for described in [*page.findall(addnodes.desc)]:
        content = described.next_node(addnodes.desc_content)
        inside = isinstance(described.parent, addnodes.desc_content)
        first = content and content.first_child_matching_class(nodes.paragraph)
        if inside or first is None or first + 1 == len(content):
            continue
        name = described.next_node(addnodes.desc_name).astext()
        begin = f'<details class="{FOLD}"><summary>All of {html.escape(name)}</summary>'
        content.insert(first + 1, raw(begin))
        content.append(raw("</details>"))
