"""A term of the glossary says what it means wherever a page uses it.

An extension of Sphinx: each link that a role ``term`` makes is given the definition as
its title, which browsers show under the pointer, and a class; a script of the book has
the keyboard and a touch show it, too.
"""

from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from docutils.nodes import document
    from sphinx.application import Sphinx

CLASS = "msc-term"
_ROLE = "std-term"  # the class of what Sphinx links to a glossary


def setup(app: "Sphinx") -> dict[str, Any]:
    """Take part in a build, which may read in parallel."""
    app.connect("doctree-resolved", explain_terms)
    return {"parallel_read_safe": True}


def explain_terms(app: "Sphinx", page: "document", _: str) -> None:
    """Give links to terms their sentences.

    Parameters
    ----------
    app : Sphinx
        Whose pages have been read.
    page : document
        A page; it is changed.
    _ : str
        Its name.
    """
    from docutils import nodes  # noqa: PLC0415 (only Sphinx has loaded it)

    @cache
    def sentences(name: str) -> dict[str, str]:
        """Return the definitions on a page by the names of their anchors."""
        items = app.env.get_doctree(name).findall(nodes.definition_list_item)
        return {
            anchor: " ".join(item[-1].astext().split())
            for item in items
            for term in item.findall(nodes.term)
            for anchor in term["ids"]
        }

    known = {
        anchor: home
        for kind, words in app.env.domains["std"].objects.items()
        if kind[0] == "term"
        for home, anchor in [words]
    }
    for link in page.findall(nodes.reference):
        anchor = link.get("refid") or link.get("refuri", "").partition("#")[2]
        if anchor in known and any(_ROLE in one["classes"] for one in link.children):
            link["reftitle"] = sentences(known[anchor])[anchor]
            link["classes"].append(CLASS)
