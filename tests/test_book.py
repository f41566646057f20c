"""The book machinery on a tiny book, and the chapters of the real one."""

import json
import re
import shutil
import sys
from pathlib import Path

import pytest

from msc.book import build_book, pages, substitutions
from msc.chapters import BookError, run_chapters
from msc.cli import main
from msc.notebook import (
    code_cells,
    declared_parameters,
    read_notebook,
    source,
    tags,
    with_outputs,
    write_notebook,
)

ROOT = Path(__file__).parents[1]
CHAPTERS = sorted((ROOT / "book").glob("*.ipynb"))
PARAMETERS = 'profile = "full"\nn = 3'
COUNT = "with open('ran.txt', 'a') as log:\n    log.write('x')"


def chapter(text, *codes):
    """Return a chapter: one paragraph, the parameters, further code cells."""
    cells = [{"cell_type": "markdown", "source": text, "metadata": {}}]
    for code in (PARAMETERS, *codes):
        metadata = {"tags": ["parameters"]} if code == PARAMETERS else {}
        empty = {"outputs": [], "execution_count": None}
        cells.append(
            {"cell_type": "code", "source": code, "metadata": metadata} | empty
        )
    cells = [cell | {"id": str(number)} for number, cell in enumerate(cells)]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    metadata = {"kernelspec": kernel}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


def make_book(root):
    """Lay out a repository with a book of an index page and one chapter."""
    shutil.copy(ROOT / "_config.yml", root)
    (root / "_toc.yml").write_text(
        "format: jb-book\nroot: index\nchapters:\n- file: one\n"
    )
    (root / "book").mkdir()
    shutil.copytree(ROOT / "book" / "_static", root / "book" / "_static")
    shutil.copy(ROOT / "book" / "references.bib", root / "book")
    (root / "book" / "index.md").write_text("# Tiny\n\n$x^2$ is {{ sums_a_b }}.\n")
    write_notebook(
        chapter("# One", COUNT, "print(profile, 2 * n)"), root / "book" / "one.ipynb"
    )
    (root / "data" / "results").mkdir(parents=True)
    (root / "data" / "results" / "sums.json").write_text('{"a": {"b": 41.5}}')
    return root


CLAIM = """
- id: no-jumps
  claim: The manifold has no jumps.
  quote: smooth changes to the task (angle) result in smooth changes […]
  section: IV-A
  chapter: one
  measured: {file: data/results/audit.json}
  readings:
    the circle cut open: {jumps: besides the cut, equals: 0, by_construction: We cut.}
    the circle closed: {jumps: on the circle, equals: 0, unit: jumps}
  margin: One is too many.
  why: There are {the circle closed}.
"""


def add_claims(root):
    """Add a claim, what was measured of it, and a page of its readings."""
    jump = {"between_deg": [359, 360], "is_jump": True}
    results = root / "data" / "results"
    (results / "audit.json").write_text(json.dumps({"jumps": [jump]}))
    (results / "claims.json").write_text("{}")
    (root / "book" / "claims.yml").write_text(CLAIM)
    include = "\n```{{include}} {}\n```\n"
    page = "# Claims\n\n## Readings\n" + include.format("claims_readings.md")
    (root / "book" / "claims.md").write_text(page + "\n```{bibliography}\n```\n")
    with (root / "book" / "index.md").open("a") as index:
        index.write(include.format("claims_table.md"))
    with (root / "_toc.yml").open("a") as toc:
        toc.write("- file: claims\n")
    return root


@pytest.fixture
def repository(tmp_path):
    return make_book(tmp_path)


def run(root, **parameters):
    """Execute the tiny book's chapter, or take it from the cache."""
    path = root / "book" / "one.ipynb"
    return run_chapters({path: parameters}, root=root, cache=root / "cache")[0]


def text_of(notebook):
    """Return all that a notebook's cells printed or returned."""
    outputs = [out for cell in code_cells(notebook) for out in cell["outputs"]]
    return "".join("".join(output.get("text", "")) for output in outputs)


def times_run(root):
    return len((root / "ran.txt").read_text())


def test_chapter_gets_its_parameters(repository):
    assert text_of(run(repository, profile="quick").notebook) == "quick 6\n"
    assert text_of(run(repository, n=5).notebook) == "full 10\n"


def test_prose_is_rendered_anew_without_execution(repository):
    path = repository / "book" / "one.ipynb"
    first = run(repository)
    edited = read_notebook(path)
    edited["cells"][0]["source"] = "# Uno"
    write_notebook(edited, path)
    second = run(repository)
    assert source(second.notebook["cells"][0]) == "# Uno"
    assert text_of(second.notebook) == text_of(first.notebook)
    assert second.seconds == first.seconds
    assert times_run(repository) == 1


def test_whatever_outputs_depend_on_executes_again(repository):
    run(repository)
    for number, name in enumerate(("data/t.csv", "msc/a.py", "requirements.txt"), 2):
        (repository / name).parent.mkdir(exist_ok=True)
        (repository / name).write_text("new")
        run(repository)
        assert times_run(repository) == number, name
    path = repository / "book" / "one.ipynb"
    write_notebook(chapter("# One", COUNT, "print('new')"), path)
    assert text_of(run(repository).notebook) == "new\n"


def test_executed_chapter_tells_nothing_of_the_machine(repository):
    notebook = run(repository, profile="quick").notebook
    [injected] = [c for c in notebook["cells"] if "injected-parameters" in tags(c)]
    assert "remove-cell" in tags(injected)
    everything = json.dumps(notebook)
    assert str(repository) not in everything
    assert not re.search(r"\d\d:\d\d:\d\d", everything)


def test_corners_of_a_table_are_no_headers():
    empty = '<tr><th></th><th class="blank"></th><th>error</th></tr>'
    plain = '<tr><td></td><td class="blank"></td><th>error</th></tr>'
    written = chapter("# Table", "table")
    run = chapter("# Table", "table")
    data = {"text/html": [empty, "\n", empty], "text/plain": "<th></th>"}
    kept = {"output_type": "display_data", "metadata": {}}
    run["cells"][2]["outputs"] = [kept | {"data": data}, {"output_type": "stream"}]
    table, stream = with_outputs(written, run)["cells"][2]["outputs"]
    assert table["data"]["text/html"] == f"{plain}\n{plain}"
    assert table["data"]["text/plain"] == "<th></th>"
    assert table["output_type"] == "display_data"
    assert stream == {"output_type": "stream"}


def test_kernel_is_of_this_interpreter(repository, monkeypatch, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("jupyter") / "kernels" / "python3"
    elsewhere.mkdir(parents=True)
    spec = {"argv": ["false"], "display_name": "Another", "language": "python"}
    (elsewhere / "kernel.json").write_text(json.dumps(spec))
    monkeypatch.setenv("JUPYTER_PATH", str(elsewhere.parents[1]))
    path = repository / "book" / "one.ipynb"
    write_notebook(chapter("# One", "import sys; print(sys.executable)"), path)
    assert text_of(run(repository).notebook).strip() == sys.executable


def test_failing_cell_is_named(repository):
    path = repository / "book" / "one.ipynb"
    write_notebook(chapter("# One", "n", "assert n > 3, 'too few'\nn"), path)
    message = r"one, code cell 3 \(assert n > 3, 'too few'\): AssertionError: too few"
    with pytest.raises(BookError, match=f"^{message}$"):
        run(repository, profile="quick")


def test_mistyped_parameter_is_named(repository):
    with pytest.raises(ValueError, match=r"no parameter 'm'; it declares: n, profile"):
        run(repository, m=1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--profile", "quik"], "profile must be 'quick' or 'full', not 'quik'"),
        (["--jobs", "0"], "jobs must be at least 1, not 0"),
    ],
)
def test_command_line_says_one_sentence(
    repository, monkeypatch, capsys, arguments, message
):
    monkeypatch.chdir(repository)
    assert main(["book", *arguments]) == 2
    assert capsys.readouterr().err == f"msc: error: {message}\n"


def test_missing_page_and_missing_book_are_named(repository):
    (repository / "book" / "one.ipynb").unlink()
    with pytest.raises(FileNotFoundError, match=r"_toc\.yml lists one, but book/ has"):
        pages(repository)
    with pytest.raises(FileNotFoundError, match="holds no book"):
        pages(repository / "book")


def test_results_become_substitutions(repository):
    file = repository / "data" / "results" / "fig-3.json"
    many = list(range(11))
    results = {"mse": [1, {"low.5": 0.5}], "holds": True, "many": many, "a, b": "c"}
    file.write_text(json.dumps(results))
    assert substitutions(repository) == {
        "fig_3_a__b": "c",
        "fig_3_mse_0": 1,
        "fig_3_mse_1_low_5": 0.5,
        "fig_3_holds": True,
        "sums_a_b": 41.5,
    }


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return the index page of the tiny book, built."""
    root = make_book(tmp_path_factory.mktemp("a tiny book"))
    return build_book(root=add_claims(root))


def contents(folder):
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {path.relative_to(folder): path.read_bytes() for path in files}


def test_book_is_complete(built):
    root = built.parents[2]
    index = built.read_text()
    page = (built.parent / "one.html").read_text()
    assert "is 41.5." in index
    assert "quick 6" in page
    assert "# Parameters" not in page  # what papermill writes above injected values
    assert list(json.loads((root / "_build" / "chapters.json").read_text())) == ["one"]


def test_book_opens_with_the_verdicts_and_shows_their_readings(built):
    index, page = (
        re.sub(r"\s+", " ", (built.parent / name).read_text())
        for name in ("index.html", "claims.html")
    )
    assert 'href="one.html"><span class="doc std std-doc">no-jumps' in index
    assert re.search(
        r'href="claims.html#claim-no-jumps">.{,40}◇ by construction', index
    )
    assert 'id="claim-no-jumps"' in page
    assert "There are 1 jumps." in page


def test_book_needs_no_network(built):
    loaded = r"""<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=["']([^"']+)"""
    for page in built.parent.glob("*.html"):
        for address in re.findall(loaded, page.read_text()):
            assert not re.match("(https?:)?//", address), f"{page.name}: {address}"
            if not address.startswith(("#", "data:")):
                assert (page.parent / address.partition("?")[0]).exists(), address


def test_book_is_the_same_when_built_again(built):
    before = contents(built.parent)
    build_book(root=built.parents[2])
    assert contents(built.parent) == before


def test_warning_stops_the_build_and_keeps_the_earlier_book(built):
    root = built.parents[2]
    before = contents(built.parent)
    page = root / "book" / "index.md"
    text = page.read_text()
    page.write_text(text + "See {doc}`nowhere`.\n")
    with pytest.raises(BookError, match=r"book/index\.md.*WARNING.*nowhere"):
        build_book(root=root)
    page.write_text(text)
    assert contents(built.parent) == before


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_chapter_is_clean(path):
    notebook = read_notebook(path)
    parameters = declared_parameters(notebook)
    assert not parameters or "profile" in parameters
    for number, cell in enumerate(code_cells(notebook), start=1):
        where = f"code cell {number}"
        assert not cell["outputs"], where
        assert cell["execution_count"] is None, where
        assert not re.search(r"^\s*(async )?(def|class) ", source(cell), re.M), where
        assert len(source(cell).splitlines()) <= 10, where


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_chapter_runs_and_its_images_have_alternative_text(path, tmp_path):
    given = {"profile": "quick"} if declared_parameters(read_notebook(path)) else {}
    [done] = run_chapters({path: given}, root=ROOT, cache=tmp_path)
    for cell in code_cells(done.notebook):
        if any("image/png" in output.get("data", {}) for output in cell["outputs"]):
            assert cell["metadata"]["mystnb"]["image"]["alt"], source(cell)


@pytest.mark.parametrize("path", CHAPTERS[:1], ids=lambda path: path.stem)
def test_chapter_runs_in_its_own_folder(path, tmp_path):
    run_chapters({path: {"profile": "quick"}}, root=path.parent, cache=tmp_path)
