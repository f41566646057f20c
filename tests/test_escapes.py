"""Words are never markup: a whole book of odd ones, and each way to write them."""

import json
import shutil
from html.parser import HTMLParser

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from matplotlib.figure import Figure
from test_book import CLAIM, add_claims, build_about_msc, make_book

from msc.claims import load_claims
from msc.plots._slider import Panel, Slider
from press import label, paragraph, plain
from press._markup import code, fenced
from press._notebook import read_notebook, write_notebook
from press._release import one_page

EVIL = "<script>alert(1)</script><img src=x onerror=alert(1)>"
ODD = (
    f"{EVIL} & &lt; \"q\" 'q' `c` ``` {{{{ n_claims }}}} {{py:func}}`x` $x$ | *i* _i_ "
    r"[a](javascript:alert(1)) [^1] <https://a.b> ]]> \ --> <!-- <!--<script> # :::"
)
PRINTED = ODD.replace('"q"', "“q”").replace("'q'", "‘q’").replace("--", "–")


class Elements(HTMLParser):
    """What a browser makes of a page: elements, and the words between them."""

    def __init__(self, page):
        super().__init__()
        self.found, self.words, self.inside = [], "", ""
        self.feed(page)
        self.words = " ".join(self.words.split())

    def handle_starttag(self, tag, attrs):
        self.inside = tag
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        if self.inside in ("script", "style"):
            self.found.append((self.inside, {"runs": data}))
        else:
            self.words += data

    def values(self, *names):
        """Return the values of attributes."""
        return [value or "" for _, one in self.found for name, value in one.items()
                if name in names]  # fmt: skip


def make_odd(root):
    """Make a book whose words are markup, or would break some."""
    add_claims(make_book(root))
    book = root / "book"
    with (root / "_toc.yml").open("a", encoding="utf-8") as toc:
        toc.writelines(
            f"- file: {name}\n"
            for name in ("parameters", "changelog", "equations", "tests")
        )
    notebook = read_notebook(book / "one.ipynb")
    text, first, _, second, last = notebook["cells"]
    title = f'{EVIL} & "q" ] | *i*'
    text["source"] = f"# {title}\n\nText {EVIL}\n\n{EVIL}\n\n## Part {EVIL}\n"
    first["source"] = f"profile = 'full'  # {ODD}\nn = '`|'"
    first["source"] += f'  # {EVIL} *x* ("`|" or "{EVIL.replace("(1)", "")}")'
    second["source"] = f"text = {ODD!r}\nprint(text)\ntext"
    last["metadata"]["mystnb"]["image"]["alt"] = ODD
    write_notebook(notebook, book / "one.ipynb")
    for name, file in {
        "parameters": "parameters_tables.md",
        "changelog": "../CHANGELOG.md",
        "tests": "tests_sources.md",
    }.items():
        page = f"# {name}\n\n" if name != "changelog" else ""
        (book / f"{name}.md").write_text(f"{page}```{{include}} {file}\n```\n", "utf-8")
    (root / "CHANGELOG.md").write_text(f"# Changes\n\n- {EVIL}\n\n{EVIL}\n", "utf-8")
    (book / "equations.md").write_text(
        "# Equations\n\n[it](test_odd.test_odd)\n", "utf-8"
    )
    (root / "tests").mkdir()
    test = f"def test_odd():\n    r'''\n```\n{EVIL}'''\n"
    (root / "tests" / "test_odd.py").write_text(test, "utf-8")
    [claim] = yaml.safe_load(CLAIM)
    claim |= {"claim": ODD, "section": ODD, "margin": ODD, "quote": f"1. {EVIL} | *x*"}
    claim["why"] += EVIL.replace("1", "")
    claim["interpretations"]["the circle cut open"]["by_construction"] = ODD
    claim["interpretations"][f"{EVIL} | *x*"] = {"cannot_be_tested": ODD}
    (book / "claims.yml").write_text(yaml.safe_dump([claim]), "utf-8")
    results = root / "data" / "results"
    (results / "sums.json").write_text(json.dumps({"a": {"b": ODD}}), "utf-8")
    return root


def test_in_a_whole_book_words_are_never_markup(tmp_path):
    pages = build_about_msc(make_odd(tmp_path)).parent
    toc = yaml.safe_load((tmp_path / "_toc.yml").read_text("utf-8"))
    shutil.copytree(pages, tmp_path / "seen")
    (tmp_path / "seen" / "paper.html").write_text(
        one_page(pages, toc, EVIL, EVIL), "utf-8"
    )
    seen = {
        page.stem: Elements(page.read_text("utf-8"))
        for page in (tmp_path / "seen").glob("*.html")
    }
    for name, page in seen.items():
        for run in page.values("runs", "href", "onerror", "onclick", "onload"):
            assert "alert(" not in run, name
        assert "x" not in page.values("src"), name
    words = {name: page.words for name, page in seen.items()}
    assert EVIL in words["genindex"]  # in the list of pages
    assert words["claims"].count(PRINTED) == 5
    assert f"“1. {EVIL} | *x*”" in words["claims"]
    assert words["index"].count(PRINTED) == 3
    assert f"is {PRINTED}." in words["index"]
    assert PRINTED in words["parameters"]
    assert "'`|'" in words["parameters"]
    values = f'"`|" or "{EVIL.replace("(1)", "")}"'
    assert f"{EVIL} *x* {values}" in " ".join(words["parameters"].split())
    assert words["one"].count(ODD) == 2
    assert f"``` {EVIL}" in words["tests"]
    assert words["changelog"].count(f"{EVIL} {EVIL}") == 1
    for name in ("one", "figures", "paper"):
        assert ODD in seen[name].values("alt"), name
    index = (pages / "searchindex.js").read_text("utf-8")
    titles = json.loads(index.removeprefix("Search.setIndex(").removesuffix(")"))
    assert (
        f"Part {EVIL}".replace("<", "&lt;").replace(">", "&gt;") in titles["alltitles"]
    )
    assert not [title for title in titles["alltitles"] if "<" in title]


LINES = st.text(st.characters(exclude_categories=["C", "Z"]) | st.just(" "))
MARKS = st.lists(st.sampled_from([*'`*_{}[]()<>|$&#~^:!-+=.\\ab1" ', EVIL])).map(
    "".join
)


def shown(markdown):
    """Return what Markdown shows, and its elements."""
    page = Elements(MarkdownIt("commonmark").enable("table").render(markdown))
    return page.words, [tag for tag, _ in page.found]


@given(LINES | MARKS)
def test_text_is_shown_as_it_is(text):
    line = " ".join(text.split())
    assert shown(paragraph(text)) == (line, ["p"] if line else [])
    row = f"| {plain(text)} | {code(text)} |\n|---|---|\n"
    cells, tags = shown(row)
    assert set(tags) <= {"table", "thead", "tr", "th", "code"}
    if line:
        assert cells == f"{line} {line}"
        assert tags.count("code") == 1
    words, tags = shown(f"x [{label(plain(text))}](page)")
    assert words == f"x {line}".strip()
    assert tags == ["p", "a"]
    assert shown(fenced(text, "text"))[1] == ["pre", "code"]


@given(MARKS)
def test_a_slider_s_words_end_no_script(text):
    sliders = Slider(
        text, [text], [text], [Panel(text, (0, 1), (0, 1), [])], Figure(), text,
        legend={text: text},
    )  # fmt: skip
    page = Elements(sliders.to_html(b"png"))
    [script] = page.values("runs")
    assert "<" not in script.rpartition("previousElementSibling,")[2]
    given = script.rpartition("previousElementSibling,")[2].removesuffix(");")
    assert json.loads(given)["captions"] == [text]
    tags = [tag for tag, _ in page.found]
    assert tags.count("script") == 2  # the element, and what it holds
    assert not {"onerror", "onclick"} & {key for _, one in page.found for key in one}
    assert page.values("aria-label") == [text]
    assert page.values("alt") == [text]


@pytest.mark.parametrize("name", ["a b", "a<b>", "a)=", 'a"b', "a\n", ""])
def test_a_claim_s_name_is_a_word(tmp_path, name):
    [claim] = yaml.safe_load(CLAIM)
    path = tmp_path / "claims.yml"
    path.write_text(yaml.safe_dump([claim | {"id": name}]), "utf-8")
    with pytest.raises(ValueError, match=r"id: (missing|.*wanted letters, digits and)"):
        load_claims(path)
