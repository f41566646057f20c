"""Of what docstrings say the first paragraph stays, the rest of it is folded."""

from docutils import nodes
from docutils.utils import new_document
from sphinx import addnodes

from press._folds import fold_descriptions


def described(name, *content):
    return addnodes.desc(
        "",
        addnodes.desc_signature("", "", addnodes.desc_name(text=name)),
        addnodes.desc_content("", *content),
    )


def page_of(*children):
    page = new_document("book/api.rst")
    page += children
    fold_descriptions(page)
    return page


def test_all_but_the_first_paragraph_is_folded():
    lines = [nodes.paragraph(text=text) for text in ("One.", "Two.", "Three.")]
    page = page_of(described("a<b", *lines))
    content = page.next_node(addnodes.desc_content)
    assert [child.astext() for child in content] == [
        "One.",
        '<details class="msc-fold"><summary>All of a&lt;b</summary>',
        *("Two.", "Three.", "</details>"),
    ]


def test_a_method_is_folded_with_its_class_and_not_again():
    method = described("fit", nodes.paragraph(text="Fit."), nodes.paragraph(text="X."))
    page = page_of(described("Skill", nodes.paragraph(text="Skill."), method))
    assert page.astext().count("<details") == 1


def test_a_sentence_alone_stays():
    page = page_of(described("a", nodes.paragraph(text="One.")), described("b"))
    assert "<details" not in page.astext()
