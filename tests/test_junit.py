"""What CI is told: which chapters would run, and a report of those that did."""

import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_book import COUNT, chapter, make_book, times_run

from press import BookError, _book
from press._junit import Case, report
from press._notebook import write_notebook
from press.cli import main

# Of the schema that CI systems share: what each element must have, and may hold.
ATTRIBUTES = {
    "testsuites": {"tests", "failures", "errors", "time"},
    "testsuite": {"name", "tests", "failures", "errors", "time"},
    "testcase": {"classname", "name", "time"},
    "failure": {"message"},
    "system-out": set(),
    "system-err": set(),
}
HOLDS = {
    "testsuites": ["testsuite"],
    "testsuite": ["testcase"],
    "testcase": ["failure", "system-out", "system-err"],
}


def read(text):
    """Parse a report, hold it to the schema, return its test cases."""
    top = ET.fromstring(text)
    assert top.tag == "testsuites"
    for element in top.iter():
        assert set(element.attrib) == ATTRIBUTES[element.tag]
        order = HOLDS.get(element.tag, [])
        inside = [order.index(child.tag) for child in element]
        assert inside == sorted(inside)
        for name in {"tests", "failures", "errors", "time"} & set(element.attrib):
            assert float(element.get(name)) >= 0
    cases = top.findall("testsuite/testcase")
    for suite in (top, top[0]):
        assert int(suite.get("tests")) == len(cases)
        assert int(suite.get("failures")) == len(top.findall(".//failure"))
    return cases


text = st.text(st.characters(exclude_categories=()))


@given(st.lists(st.builds(Case, text, st.floats(0, 1e6), text, text, text, text)))
def test_a_report_of_whatever_chapters_say_is_xml(cases):
    for case, read_again in zip(cases, read(report(cases)), strict=True):
        assert (read_again.find("failure") is None) == (not case.failure)


def test_what_xml_holds_comes_back_and_nothing_else():
    odd = "a < b & c ]]> d \x1b[31mred\x1b[0m \x00\x08\ud800\ufffe é\t\n'\" \U0001f916"
    [case] = read(report([Case("one", 1.234, odd, failure="no", traceback=odd)]))
    told = "a < b & c ]]> d red ���� é\t\n'\" \U0001f916"
    assert case.findtext("system-out") == case.findtext("failure") == told
    assert case.get("time") == "1.23"


@pytest.fixture
def book(tmp_path, monkeypatch):
    """Return a book of three chapters, all but one with a fault, as working folder."""
    root = make_book(tmp_path)
    claim = "from press import expect\nexpect({'It holds.': n > 3})"
    said = {
        "fails": ["print('so far')", "raise ValueError('too \\x1b[1mfew ]]>')"],
        "unmet": [claim, "import sys; print('odd', file=sys.stderr)"],
    }
    with (root / "_toc.yml").open("a", encoding="utf-8") as toc:
        for name, codes in said.items():
            toc.write(f"- file: {name}\n")
            write_notebook(chapter(f"# {name}", *codes), root / f"book/{name}.ipynb")
    one = chapter("# One", COUNT, "print(profile, 2 * n)")
    write_notebook(one, root / "book" / "one.ipynb")
    monkeypatch.chdir(root)
    return root


def render_nothing(*_):
    """Stand in for the rendering of pages, which takes seconds."""
    raise BookError("nothing rendered")


def test_the_report_has_every_chapter_and_what_went_wrong_in_it(
    book, capsys, monkeypatch
):
    assert main(["book", "--junit", "made/report.xml"]) == 2
    error = capsys.readouterr().err
    by_name = {
        case.get("name"): case for case in read((book / "made/report.xml").read_bytes())
    }
    assert list(by_name) == ["fails", "one", "unmet"]
    failures = {
        name: case.find("failure").get("message")
        for name, case in by_name.items()
        if case.find("failure") is not None
    }
    assert list(failures) == ["fails", "unmet"]
    said = error.replace("\x1b[1m", "")
    assert f"fails, {failures['fails']}" in said
    loud, unmet = failures["unmet"].splitlines()
    assert f"unmet, {loud}\nunmet, {unmet}" in said
    assert failures["fails"].endswith("ValueError: too few ]]>")
    assert "wrote to stderr: odd" in loud
    assert "not hold" in unmet
    told = by_name["fails"].findtext("failure")
    assert "Traceback (most recent call last)" in told
    assert "raise ValueError(" in told
    assert by_name["fails"].findtext("system-out") == "so far\n"
    assert by_name["unmet"].findtext("system-err") == "odd\n"
    one = by_name["one"]
    assert one.findtext("system-out").startswith("executed: never executed with")
    assert "quick 6\n" in one.findtext("system-out")
    assert float(one.get("time")) > 0.1
    # Again: what went well is kept, with the time that it took.
    (book / "_toc.yml").write_text("root: index\nc:\n- file: one\n", "utf-8")
    monkeypatch.setattr(_book, "_render", render_nothing)
    assert main(["book", "--junit", "made/report.xml"]) == 2
    assert "nothing rendered" in capsys.readouterr().err
    [kept] = read((book / "made/report.xml").read_bytes())
    assert kept.findtext("system-out").startswith("kept: nothing changed\n")
    assert kept.get("time") == one.get("time")
    assert main(["book", "--changed"]) == 0
    assert capsys.readouterr() == ("", "no chapter has to be executed\n")
    write_notebook(chapter("# One", "n"), book / "book" / "one.ipynb")
    assert main(["book", "--changed"]) == 0
    assert capsys.readouterr().out == "one: its code cells changed\n"
    assert times_run(book) == 1


def test_changed_names_chapters_and_executes_none(book, capsys):
    def tell(*options):
        assert main(["book", "--changed", *options]) == 0
        return capsys.readouterr().out

    never = "never executed with profile='quick'"
    names = ["one", "fails", "unmet"]
    assert tell().splitlines() == [f"{name}: {never}" for name in names]
    assert tell("--profile", "full").startswith(f"one: {never[:-7]}'full'\n")
    assert not (book / "ran.txt").exists()


def test_changed_writes_nothing(tmp_path, monkeypatch, capsys):
    (tmp_path / "_toc.yml").write_text("root: index\n", "utf-8")
    (tmp_path / "book").mkdir()
    (tmp_path / "book" / "index.md").write_text("# Empty\n", "utf-8")
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert main(["book", "--changed"]) == 0
    assert sorted(tmp_path.rglob("*")) == before
    assert capsys.readouterr().err == "no chapter has to be executed\n"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--junit", "report.txt"], "out=report.txt; wanted a name ending in .xml"),
        (["--junit", "r.xml", "--changed"], "--changed executes nothing that --junit"),
        (["--changed", "--profile", "quik"], "profile='quik'; wanted one of"),
    ],
)
def test_options_that_make_no_sense_are_named(
    tmp_path, monkeypatch, capsys, options, message
):
    (tmp_path / "_toc.yml").write_text("root: index\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["book", *options]) == 2
    assert message in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["_toc.yml"]
