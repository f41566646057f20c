"""The first page: its numbers are the studies', its words are explained."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from docutils import nodes
from test_sentences import ROOT, ahead, mean, ratio

from msc.claims import headline_values
from msc.data import load_results
from press._terms import CLASS, explain_terms

PAGE = (ROOT / "book" / "index.md").read_text("utf-8")
GLOSSARY = (ROOT / "book" / "glossary.md").read_text("utf-8")


@pytest.fixture(scope="module")
def values():
    return headline_values(
        {world: load_results(f"study_{world}")[0] for world in ("free", "obstacles")}
    )


def test_numbers_of_the_first_page_are_the_studies(values):
    mse, both = "mse, gate learned", ("charts", "single regression")
    for name, method in {
        "cm_charts": "charts",
        "cm_single": "single regression",
        "cm_line": "linear interpolation",
        "cm_single_one": "single, one kernel",
    }.items():
        there = mean("obstacles", "error_cm", 24, method)
        assert float(values[f"first_{name}"]) == pytest.approx(there, rel=0.05)
    found = ratio("obstacles", "mse, away from jumps", 24, both[1])
    told = [
        values["first_broken_away"],
        *values["first_broken_away_interval"][1:-1].split(),
    ]
    numbers = [float(one.strip(",")) for one in told]
    np.testing.assert_allclose(numbers, found, rtol=0.05)
    assert values["first_free_all"] == f"{ratio('free', mse, 360, both[1])[0]:.2g}"
    assert (values["first_ahead_cm"], values["first_n_sets"]) == ("13", "15")
    assert values["first_behind_free_cm"] == str(
        15 - ahead("free", "error_cm", 24, both[1])[0]
    )


def test_what_the_first_page_says_of_them_is_so():
    # Beside a break charts lose what they gain elsewhere; a rougher kernel; executed.
    everywhere = ratio("obstacles", "mse, gate learned", 24, "single regression")
    away = ratio("obstacles", "mse, away from jumps", 24, "single regression")
    assert everywhere[1] < 1 < everywhere[2]
    assert away[0] < everywhere[0] / 2
    rough = ratio("free", "mse, gate learned", 360, "single, Matérn", "charts, Matérn")
    plain = ratio("free", "mse, gate learned", 360, "single regression")
    assert rough[1] < 1 < rough[2]
    assert plain[2] < 1
    told = ratio("obstacles", "mse, chart known", 24, "single regression")
    assert away[0] < told[0] < everywhere[0]


def test_no_number_of_the_first_page_is_typed(values):
    quoted = set(re.findall(r"\{\{ (first_\w+) \}\}", PAGE))
    assert quoted <= set(values)
    assert len(quoted) > 12
    assert not re.findall(r"\d\.\d", PAGE)


def test_a_term_is_marked_where_the_first_page_uses_it_first():
    marked = re.findall(r"\{term\}`(?:[^`<]*<)?([^`>]+)>?`", PAGE)
    assert len(marked) == len(set(marked)) > 15
    defined = re.findall(r"^(\S.*)\n  \S", GLOSSARY, re.MULTILINE)
    assert set(marked) <= set(defined)
    assert len(defined) == len(set(defined))


def test_a_term_is_one_sentence():
    for sentence in re.findall(r"^  (\S.*)", GLOSSARY, re.MULTILINE):
        assert re.fullmatch(r"[A-Z].*\.", sentence)
        assert not re.search(r"\. [A-Z]", sentence), sentence


def link_to(anchor, kind):
    """Return what Sphinx makes of a role that names something on another page."""
    words = nodes.inline("", anchor, classes=[kind])
    return nodes.reference("", "", words, refuri=f"glossary.html#{anchor}")


def test_links_to_terms_say_the_sentence():
    item = nodes.definition_list_item(
        "",
        nodes.term("", "chart", ids=["term-chart"]),
        nodes.definition("", nodes.paragraph("", "A group\nof tasks.")),
    )
    glossary = nodes.container("", nodes.definition_list("", item))
    known = {("term", "chart"): ("glossary", "term-chart"), ("label", "x"): ("a", "x")}
    env = SimpleNamespace(
        get_doctree={"glossary": glossary}.__getitem__,
        domains={"std": SimpleNamespace(objects=known)},
    )
    term, other = link_to("term-chart", "std-term"), link_to("term-chart", "std-ref")
    page = nodes.container(
        "", term, other, nodes.reference("", "", refuri="https://a.b")
    )
    explain_terms(SimpleNamespace(env=env), page, "index")
    assert term["reftitle"] == "A group of tasks."
    assert CLASS in term["classes"]
    assert "reftitle" not in other
