"""The reference pages name what exists, and all of it."""

import contextlib
import inspect
import io
import re
from importlib import import_module
from pathlib import Path

import pytest

import msc
import msc.study.rivals
from msc.cli import main, make_subject
from msc.plots import SECTION_V
from press import Subject
from press._markup import mend_backlinks
from press._notebook import Parameter, parameters, read_notebook
from press._pages import (
    commands_markdown,
    named_tests,
    parameters_markdown,
    sources_markdown,
    write_reference,
)

ROOT = Path(__file__).parents[1]
BOOK = ROOT / "book"
CHAPTERS = sorted(BOOK.glob("*.ipynb"))
EQUATIONS = (BOOK / "equations.md").read_text(encoding="utf-8")
PAGES = sorted(BOOK.glob("api*.rst"))
API = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
SECTIONS = dict(re.findall(r"^## Eq\. (\d+): .+\n((?:(?!## ).*\n)*)", EQUATIONS, re.M))


def chapter(code):
    metadata = {"tags": ["parameters"]}
    cell = {"cell_type": "code", "source": code, "metadata": metadata}
    title = {"cell_type": "markdown", "source": "# One and only\n", "metadata": {}}
    return {"cells": [title, cell]}


# From equation to code


def test_no_equation_is_missing():
    assert list(SECTIONS) == [str(number) for number in range(1, 9)]


@pytest.mark.parametrize("number", SECTIONS)
def test_an_equation_has_its_words_its_functions_and_its_tests(number):
    section = SECTIONS[number]
    assert section.count("$$") >= 2
    assert re.search(r"\*\*It says:\*\* \w", section)
    assert re.search(r"\*\*Code:\*\*.*\{py:\w+\}`", section)
    assert named_tests(section.partition("**Held by:**")[2])


def roles(page):
    return re.findall(r"\{py:\w+\}`(?:[^`<]*<)?([\w.]+)>?`", page)


@pytest.mark.parametrize("name", dict.fromkeys(roles(EQUATIONS)))
def test_a_named_function_exists_and_is_on_the_package_s_page(name):
    *path, last = name.split(".")
    owner = "class" if path[-1][0].isupper() else "module"
    home = (
        getattr(msc, path.pop()) if owner == "class" else import_module(".".join(path))
    )
    assert callable(getattr(home, last))
    if owner == "class":
        members = re.search(
            rf"autoclass:: {'.'.join(path)}\.{home.__name__}\b.*\n(.*)", API
        )
        assert re.search(rf"\b{last}\b", members[1])
    else:
        assert re.search(rf"auto(function|class):: {re.escape(name)}\b", API)


def test_named_tests_are_shown_as_they_stand():
    page = sources_markdown(named_tests(EQUATIONS), ROOT, "msc")
    shown = re.findall(r"^\((test_\w+)\.(test_\w+)\)=\n### [^_]+\n", page, re.M)
    assert sorted(shown) == sorted(named_tests(EQUATIONS))
    for file in {file for file, _ in shown}:
        assert f"../tests/{file}.py" in page
        whole = (ROOT / "tests" / f"{file}.py").read_text(encoding="utf-8")
        section = page.partition(f"{file}.py`")[2].partition("\n## ")[0]
        for code in re.findall(r"```python\n(.*?)\n```", section, re.S):
            assert f"\n{code}\n" in whole


def test_decorators_belong_to_a_test():
    page = sources_markdown([("test_dmp", "test_reference_cases")], ROOT, "msc")
    assert '```python\n@pytest.mark.parametrize("case", CASES)\n' in page


@pytest.mark.parametrize(
    ("file", "name"), [("test_dmp", "test_nothing"), ("test_nowhere", "test_a")]
)
def test_a_test_that_does_not_exist_is_named(file, name):
    with pytest.raises(ValueError, match=rf"names {file}\.{name}, but tests/{file}.py"):
        sources_markdown([(file, name)], ROOT, "msc")


# The package


@pytest.mark.parametrize("name", msc.study.rivals.__all__)
def test_every_rival_is_on_the_package_s_page(name):
    thing = getattr(msc.study.rivals, name)
    if callable(thing) and not hasattr(msc, name):
        kind = "class" if inspect.isclass(thing) else "function"
        assert f".. auto{kind}:: msc.study.rivals.{name}\n" in API
        assert re.search(rf"^   {name}$", API, re.M)  # the table of rivals


@pytest.mark.parametrize("name", msc.__all__)
def test_everything_public_is_on_its_page(name):
    thing = getattr(msc, name)
    entry = re.search(rf"auto(class|function):: msc\.{name}\b.*\n(.*)", API)
    assert re.search(rf"^   {name}$", API, re.M)  # the table at the top
    assert (entry[1] == "class") == inspect.isclass(thing)
    if inspect.isclass(thing):
        lines = re.findall(r"^(\w[\w, ]*) : ", inspect.getdoc(thing), re.M)
        told = set(re.findall(r"\w+", " ".join([*lines, entry[2]])))
        inherited = {key for base in thing.__mro__[1:] for key in vars(base)}
        own = {key for key in vars(thing) if not re.match(r"_|set_\w+_request", key)}
        assert own - inherited <= told


def test_the_written_out_signature_is_the_workspace_s():
    """Only the home pose is left out, whose digits say nothing."""
    [written] = re.findall(r"^.. autoclass:: msc\.Workspace(\(.+\))$", API, re.M)
    signature = inspect.signature(msc.Workspace)
    given = [
        one.replace(annotation=inspect.Parameter.empty)
        for one in signature.parameters.values()
    ]
    bare = inspect.Signature(given)
    home = str(signature.parameters["home"].default)
    assert written == str(bare).replace(home, "…")


# Parameters of the chapters


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_every_parameter_of_a_chapter_has_a_meaning(path):
    found = parameters(read_notebook(path))
    assert [name for name, one in found.items() if not one.meaning] == []


def test_a_parameter_s_meaning_is_its_comment():
    code = (
        "# Above\n"
        'design: str = "even # odd"  # how sets are drawn\n'
        "sizes = (\n    8,  # small\n    24,\n)  # of training sets\n"
        "seed = 0"
    )
    assert parameters(chapter(code)) == {
        "design": Parameter("'even # odd'", "how sets are drawn"),
        "sizes": Parameter("(8, 24)", "of training sets"),
        "seed": Parameter("0", ""),
    }


def test_parameters_become_a_table_a_chapter():
    text = parameters_markdown(CHAPTERS)
    for path in CHAPTERS:
        assert text.count(f"]({path.stem})") == 1
    row = r"^\| `n_samples` \| `24` \| training tasks, .*\|$"
    assert re.search(row, text.partition("`book/fig3_free_24.ipynb`")[2], re.M)
    without = text.partition("Without parameters: ")[2]
    assert "](what_it_costs)" in without
    assert "](fig3_free_24)" not in without


# The command line


@pytest.fixture(scope="module")
def told():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "80")
        return call("help")


def call(*arguments):
    """Return what a command prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
        main(arguments)
    return printed.getvalue()


def test_help_tells_what_each_command_tells(told, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    commands = re.findall(r"^usage: msc ([a-z]+)", told, re.M)
    assert {"search", "evaluate", "claims", "book", "help"} <= set(commands)
    for command in commands:
        assert call(command, "--help") in told
    assert told.startswith(call("--help"))


def test_every_command_has_a_section(told):
    page = commands_markdown(told)
    sections = re.findall(r"^## msc ([a-z]+)$", page, re.M)
    assert sections == re.findall(r"^    ([a-z]+) ", told, re.M)
    assert page.count("```text") == len(sections) + 1
    assert all(len(line) <= 80 for line in page.splitlines())


# Together


def test_pages_find_what_they_include(tmp_path):
    (tmp_path / "book").mkdir()
    write_reference(ROOT, tmp_path, CHAPTERS[:2], make_subject(ROOT))
    for page in ("parameters", "commands", "tests", "changelog"):
        text = (BOOK / f"{page}.md").read_text(encoding="utf-8")
        [included] = re.findall(r"\{include\} (\S+)", text)
        assert (tmp_path / "book" / included).resolve().read_text(encoding="utf-8")
    for file in re.findall(
        r"<(\.\./\S+)>", (tmp_path / "book" / "tests_sources.md").read_text("utf-8")
    ):
        assert (tmp_path / "book" / file).is_file()


def test_a_book_without_reference_pages_gets_none(tmp_path):
    (tmp_path / "stage" / "book").mkdir(parents=True)
    write_reference(tmp_path, tmp_path / "stage", [], Subject())
    assert list((tmp_path / "stage").rglob("*.*")) == []


# The related work


def test_seven_systems_each_with_its_reference():
    page = (BOOK / "related_work.md").read_text(encoding="utf-8")
    *sections, beside = page.split("\n## ")[1:]
    known = (BOOK / "references.bib").read_text(encoding="utf-8")
    assert len(sections) == 7
    for section in [*sections, beside]:
        cited = re.findall(r"\{cite\}`(\w+)`", section)
        assert cited, section[:40]
        assert all(f"{{{key}," in known for key in cited)
    for section in sections:
        assert "*Here:*" in section
        assert "*Adapted:*" in section
        assert re.search(r"\*Left\sout:\*", section)


def test_systems_are_said_to_run_by_the_names_of_their_methods():
    page = " ".join((BOOK / "related_work.md").read_text(encoding="utf-8").split())
    *sections, _ = page.split(" ## ")[1:]
    for system, section in zip(SECTION_V, sections, strict=True):
        assert f"{{cite}}`{system.cited}`" in section
        assert f"*{system.method}*" in section
        assert not system.before or f"*{system.before}*" in section


def test_links_from_sources_lead_to_where_a_name_is_documented(tmp_path):
    sources = tmp_path / "_modules" / "msc" / "search"
    sources.mkdir(parents=True)
    (tmp_path / "api.html").write_text('<dt id="msc.Arm">', "utf-8")
    (tmp_path / "api_search.html").write_text('<dt id="msc.search.cost">', "utf-8")
    links = "api.html#msc.Arm", "api_search.html#msc.cost"
    (sources / "_policy.html").write_text(" ".join(links), "utf-8")
    mend_backlinks(tmp_path)
    mended = "api.html#msc.Arm api_search.html#msc.search.cost"
    assert (sources / "_policy.html").read_text("utf-8") == mended
