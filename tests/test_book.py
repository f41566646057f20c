"""The book machinery on a tiny book, and the chapters of the real one."""

import html
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from msc.cli import main, make_subject
from press import (
    BookError,
    _chapters,
    _release,
    build_book,
    build_twice,
    locked,
    pages,
    print_book,
    release_book,
)
from press._book import substitutions
from press._chapters import Record, find_changed, run_chapters, version_of
from press._notebook import (
    code_cells,
    read_notebook,
    source,
    tags,
    with_outputs,
    write_notebook,
)
from press._pages import find_pictures, gallery_markdown
from press._processes import environment
from press._release import MAY_DIFFER, differences, one_page, pack, without_dates

ROOT = Path(__file__).parents[1]
PARAMETERS = 'profile = "full"\nn = 3'
COUNT = "with open('ran.txt', 'a') as log:\n    log.write('x')"
DRAW = """import matplotlib.pyplot as plt

figure, _ = plt.subplots(figsize=(3, 2))
plt.close()
figure"""


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
    root.mkdir(exist_ok=True)
    shutil.copy(ROOT / "_config.yml", root)
    (root / "_toc.yml").write_text(
        "format: jb-book\nroot: index\nchapters:\n- file: one\n- file: figures\n",
        "utf-8",
    )
    (root / "book").mkdir()
    shutil.copytree(ROOT / "book" / "_static", root / "book" / "_static")
    shutil.copy(ROOT / "book" / "references.bib", root / "book")
    (root / "book" / "index.md").write_text(
        "# Tiny\n\n$x^2$ is {{ sums_a_b }}.\n", "utf-8"
    )
    one = chapter("# One", COUNT, "print(profile, 2 * n)", DRAW)
    one["cells"][-1]["metadata"] = {"mystnb": {"image": {"alt": "A tiny circle."}}}
    write_notebook(one, root / "book" / "one.ipynb")
    shutil.copy(ROOT / "book" / "figures.md", root / "book")
    (root / "data" / "results").mkdir(parents=True)
    (root / "data" / "results" / "sums.json").write_text('{"a": {"b": 41.5}}', "utf-8")
    home = Path(environment(ROOT / "_build" / "cache")["MPLCONFIGDIR"])
    shutil.copytree(home, root / "_build" / "cache" / "home" / home.name)
    return root


CLAIM = """
- id: no-jumps
  claim: The manifold has no jumps.
  quote: smooth changes to the task (angle) result in smooth changes […]
  section: IV-A
  chapter: one
  measured: {file: data/results/audit.json}
  interpretations:
    the circle cut open: {jumps: besides the cut, equals: 0, by_construction: We cut.}
    the circle closed: {jumps: on the circle, equals: 0, unit: jumps}
  margin: One is too many.
  why: There are {the circle closed}.
"""


def add_claims(root):
    """Add a claim, what was measured of it, and a page of its readings."""
    jump = {"between_deg": [359, 360], "is_jump": True}
    results = root / "data" / "results"
    (results / "audit.json").write_text(json.dumps({"jumps": [jump]}), "utf-8")
    (results / "claims.json").write_text("{}", "utf-8")
    (root / "book" / "claims.yml").write_text(CLAIM, "utf-8")
    include = "\n```{{include}} {}\n```\n"
    page = "# Claims\n\n## Readings\n" + include.format("claims_readings.md")
    (root / "book" / "claims.md").write_text(
        page + "\n```{bibliography}\n```\n", "utf-8"
    )
    with (root / "book" / "index.md").open("a", encoding="utf-8") as index:
        index.write(include.format("claims_table.md"))
    with (root / "_toc.yml").open("a", encoding="utf-8") as toc:
        toc.write("- file: claims\n")
    return root


@pytest.fixture
def repository(tmp_path):
    return make_book(tmp_path)


def run(root, *, say=None, **parameters):
    """Execute the tiny book's chapter, or take it from the cache."""
    path = root / "book" / "one.ipynb"
    cache = root / "_build" / "cache"
    return run_chapters({path: parameters}, root=root, cache=cache, say=say)[0]


def text_of(notebook):
    """Return all that a notebook's cells printed or returned."""
    outputs = [out for cell in code_cells(notebook) for out in cell["outputs"]]
    return "".join("".join(output.get("text", "")) for output in outputs)


def times_run(root):
    return len((root / "ran.txt").read_text("utf-8"))


def test_chapter_gets_its_parameters_and_tells_nothing_of_the_machine(built):
    repository = built.parents[2]
    notebook = run(repository, profile="quick").notebook
    assert times_run(repository) == 1, "it is the book's run"
    assert "quick 6\n" in text_of(notebook)
    [injected] = [c for c in notebook["cells"] if "injected-parameters" in tags(c)]
    assert "remove-cell" in tags(injected)
    everything = json.dumps(notebook)
    assert str(repository) not in everything
    assert not re.search(r"\d\d:\d\d:\d\d", everything)


READS = """
import sys
sys.path.insert(0, ".")
import early
from pathlib import Path
print(early.late(), Path("data/t.csv").read_text(), Path("new.txt").exists())
Path("new.txt").write_text("mine")
Path("new.txt").read_text()
try:
    open("data/late.csv")
except OSError:
    print("none")
"""


@pytest.fixture(scope="module")
def read_once(tmp_path_factory):
    """Return a repository whose chapter reads modules and tables, and has run."""
    repository = make_book(tmp_path_factory.mktemp("reading"))
    late = "import lately\ndef late():\n    import latest\n    return latest.VALUE"
    (repository / "early.py").write_text(late, "utf-8")
    for name in ("lately", "latest", "never"):
        (repository / f"{name}.py").write_text("VALUE = 1", "utf-8")
    for name in ("t.csv", "u.csv"):
        (repository / "data" / name).write_text("old", "utf-8")
    path = repository / "book" / "one.ipynb"
    write_notebook(chapter("# One", COUNT, READS), path)
    run(repository)
    return repository


@pytest.fixture
def reading(read_once, tmp_path):
    """Return a copy of it, as deep: files outside are named from there."""
    return shutil.copytree(read_once, tmp_path, dirs_exist_ok=True)


def test_prose_is_rendered_anew_without_execution(reading):
    path = reading / "book" / "one.ipynb"
    first = run(reading)
    edited = read_notebook(path)
    edited["cells"][0]["source"] = "# Uno"
    write_notebook(edited, path)
    second = run(reading)
    assert source(second.notebook["cells"][0]) == "# Uno"
    assert text_of(second.notebook) == text_of(first.notebook) != ""
    assert second.record == first.record
    assert times_run(reading) == 1


def test_a_run_knows_exactly_what_it_read(reading):
    files = run(reading).record.files
    assert {name for name in files if not name.startswith("..")} == {
        "data/late.csv",
        "data/t.csv",
        "early.py",
        "lately.py",
        "latest.py",
    }
    assert run(reading).record.files == files  # with bytecode there
    assert times_run(reading) == 1


def test_what_a_chapter_read_executes_it_again_and_is_named(reading):
    kept, said = run(reading).record, []
    late = reading / "data" / "late.csv"
    late.write_text("x", "utf-8")  # it was missing
    assert kept.changes(kept.code, reading) == ["data/late.csv changed"]
    late.unlink()
    for name in ("data/t.csv", "early.py", "lately.py", "latest.py"):
        before = (reading / name).read_bytes()
        (reading / name).write_bytes(before + b"# new")
        assert kept.changes(kept.code, reading) == [f"{name} changed"]
        (reading / name).write_bytes(before)
    (reading / name).write_bytes(before + b"# new")
    run(reading, say=said.append)
    assert said == [f"one: {name} changed"]
    assert times_run(reading) == 2
    run(reading, say=said.append)
    assert times_run(reading) == 2


def test_a_chapter_edited_while_it_waits_is_named_and_not_kept(repository, monkeypatch):
    def edit_and_execute(path, *_, code, **__):
        write_notebook(chapter("# One", "print(n)"), path)
        return read_notebook(path), Record(code, {}, {}, {}, 0.0)

    monkeypatch.setattr(_chapters, "_execute", edit_and_execute)
    with pytest.raises(BookError, match="one, its code was edited while"):
        run(repository)
    assert not [*(repository / "_build" / "cache").glob("one*")]


def test_what_a_chapter_did_not_read_executes_nothing(reading):
    for name in ("never.py", "data/u.csv", "requirements.txt", "new.txt", "msc/a.py"):
        (reading / name).parent.mkdir(exist_ok=True)
        (reading / name).write_text("new", "utf-8")
    run(reading)
    assert times_run(reading) == 1


def test_new_code_parameters_and_packages_execute_again(reading, monkeypatch):
    path = reading / "book" / "one.ipynb"

    def reasons(**given):
        cache = reading / "_build" / "cache"
        return find_changed({path: given}, root=reading, cache=cache).get("one")

    assert reasons() is None
    assert reasons(n=5) == "never executed with n=5"
    version = version_of("ipykernel")
    newer = {"ipykernel": "99.0"}
    with monkeypatch.context() as patch:
        patch.setattr(
            _chapters, "version_of", lambda name: newer.get(name, version_of(name))
        )
        assert reasons() == f"ipykernel {version} became 99.0"
    write_notebook(chapter("# One", COUNT, "print('new')"), path)
    assert reasons() == "its code cells changed"
    assert text_of(run(reading).notebook) == "new\n"


def set_by_readers(folder):
    """Return an environment in which everything is set that might matter."""
    kernel = folder / "jupyter" / "kernels" / "python3" / "kernel.json"
    kernel.parent.mkdir(parents=True)
    spec = {"argv": ["false"], "display_name": "Another", "language": "python"}
    kernel.write_text(json.dumps(spec), "utf-8")
    nowhere = folder / "file"
    nowhere.write_text("c.InlineBackend.figure_formats = {'jpeg'}\n", "utf-8")
    ipython = folder / "ipython" / "profile_default"
    (ipython / "startup").mkdir(parents=True)
    (ipython / "startup" / "first.py").write_text(
        "profile = 'theirs'; print('hi')", "utf-8"
    )
    shutil.copy(nowhere, ipython / "ipython_kernel_config.py")
    rc = folder / "matplotlibrc"
    rc.write_text("figure.facecolor: red\nbackend: pdf\nsavefig.dpi: 30\n", "utf-8")
    return {
        "HOME": str(nowhere),
        "MPLBACKEND": "Agg",
        "MPLCONFIGDIR": str(nowhere),
        "MATPLOTLIBRC": str(rc),
        "XDG_CACHE_HOME": str(nowhere),
        "XDG_CONFIG_HOME": str(folder),
        "IPYTHONDIR": str(folder / "ipython"),
        "JUPYTER_CONFIG_DIR": str(folder),
        "JUPYTER_PATH": str(kernel.parents[2]),
        "JUPYTER_RUNTIME_DIR": str(nowhere),
        "PYTHONWARNINGS": "default",
        "PYTHONOPTIMIZE": "1",
        "PYTHONSTARTUP": str(nowhere),
        "PYTHONPATH": str(folder),
        "PYTHONUTF8": "0",
        "LC_ALL": "C",
        "TZ": "Asia/Kolkata",
        "OMP_NUM_THREADS": "7",
        "SOURCE_DATE_EPOCH": "1",
        "FORCE_COLOR": "1",
        "COLUMNS": "40",
    }


STATE = """import locale, os, sys, time, warnings
import numpy as np
from threadpoolctl import threadpool_info
def f(): assert False
try:
    f()
except AssertionError:
    print("asserts")
print(time.tzname, locale.getencoding(), os.environ.get("COLUMNS"))
print(max(one["num_threads"] for one in threadpool_info()))
warnings.warn("not shown by default", ImportWarning)
_ = open("python.txt", "w").write(sys.executable)"""


COMPLAINTS = {
    "import sys\nprint('not', file=sys.stderr, flush=True)\nsys.stderr.write('good')": (
        r"code cell 2 \(import sys\) wrote to stderr: not good"
    ),
    "import warnings\nwarnings.warn('odd')": r"code cell 3 .*UserWarning: odd .*",
    "import logging\nlogging.warning('odd')": r"code cell 4 .*: WARNING:root:odd",
    "import os\n_ = os.system('echo odd >&2')": r"code cell 5 .* stderr: odd",
}


def test_a_run_that_wrote_to_stderr_is_not_kept(repository):
    path = repository / "book" / "one.ipynb"
    write_notebook(chapter("# One", *COMPLAINTS), path)
    lines = "\n".join(f"one, {wanted}" for wanted in COMPLAINTS.values())
    with pytest.raises(BookError, match=f"^{lines}$"):
        build_book(root=repository)
    assert not list((repository / "_build" / "cache").glob("*.ipynb"))


def test_a_figure_without_a_picture_is_named(reading):
    path = reading / "book" / "one.ipynb"
    lacking = read_notebook(path)  # it has not said that there is a figure
    lacking["cells"][-1]["metadata"] = {"mystnb": {"image": {"alt": "A circle."}}}
    write_notebook(lacking, path)
    message = r"one, code cell 3 \(import sys.* alternative text, but no picture"
    with pytest.raises(BookError, match=f"^{message}$"):
        run(reading)
    assert times_run(reading) == 1


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


def test_failing_cell_is_named_and_the_earlier_run_is_left(reading):
    first = run(reading).record
    path = reading / "book" / "one.ipynb"
    good = read_notebook(path)
    write_notebook(chapter("# One", "n", "assert n > 3, 'too few'\nn"), path)
    message = r"one, code cell 3 \(assert n > 3, 'too few'\): AssertionError: too few"
    with pytest.raises(BookError, match=f"^{message}$"):
        run(reading)
    write_notebook(good, path)
    assert run(reading).record == first


def test_mistyped_parameter_is_named(repository):
    with pytest.raises(ValueError, match=r"no parameter 'm'; it declares: n, profile"):
        run(repository, m=1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--profile", "quik"], "profile='quik'; wanted one of ('quick', 'full')"),
        (["--jobs", "0"], "jobs=0; wanted at least 1"),
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


def test_runs_want_a_process(repository):
    with pytest.raises(ValueError, match="jobs=0; wanted at least 1"):
        build_book(root=repository, jobs=0)


@pytest.mark.parametrize("act", [release_book, print_book])
def test_without_a_book_nothing_is_handed_on(act, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileNotFoundError, match=r"holds no book: it has no _toc\.yml"):
        act(tmp_path)


def test_results_become_substitutions(repository):
    file = repository / "data" / "results" / "fig-3.json"
    many = list(range(11))
    results = {"mse": [1, {"low.5": 0.5}], "holds": True, "many": many, "a, b": "c"}
    file.write_text(json.dumps(results), "utf-8")
    assert substitutions(repository) == {
        "fig_3_a__b": "c",
        "fig_3_mse_0": 1,
        "fig_3_mse_1_low_5": 0.5,
        "fig_3_holds": True,
        "sums_a_b": 41.5,
    }


def build_about_msc(root):
    return build_book(root=root, subject=make_subject(root))


def make_whole(root):
    """Lay out the tiny book with claims, its chapter telling of its process."""
    path = add_claims(make_book(root)) / "book" / "one.ipynb"
    one = read_notebook(path)
    one["cells"][3]["source"] += f"\n{STATE}"
    write_notebook(one, path)
    return root


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return the index page of the tiny book, built."""
    root = make_whole(tmp_path_factory.mktemp("a {tiny} {{ book }} 'of' $HOME [é]*"))
    return build_about_msc(root)


def test_the_book_is_told_of_the_package_and_its_claims(tmp_path):
    assert make_subject(tmp_path).values == {}
    root = add_claims(make_book(tmp_path))
    verdicts = root / "data/results/claims.json"
    verdicts.unlink()
    subject = make_subject(root)
    assert subject.values == {"n_claims": 1}
    assert "No verdicts yet" in subject.fragments["claims_table.md"]
    verdicts.write_text("{}", "utf-8")
    subject = make_subject(root)
    assert subject.values == {"n_claims": 1, "verdicts": "1 by construction"}
    assert "[The manifold has no jumps.](one)" in subject.fragments["claims_table.md"]
    assert subject.commands.startswith("usage: msc [-h] COMMAND")


def contents(folder):
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {path.relative_to(folder): path.read_bytes() for path in files}


def test_book_is_complete(built):
    index = built.read_text("utf-8")
    page = (built.parent / "one.html").read_text("utf-8")
    assert "is 41.5." in index
    assert "quick 6" in page
    assert "# Parameters" not in page  # what papermill writes above injected values


def test_book_opens_with_the_verdicts_and_shows_their_readings(built):
    index, page = (
        re.sub(r"\s+", " ", (built.parent / name).read_text("utf-8"))
        for name in ("index.html", "claims.html")
    )
    claim = '<span class="doc std std-doc">The manifold has no jumps.'
    assert f'href="one.html">{claim}' in index
    assert re.search(
        r'href="claims.html#claim-no-jumps">.{,40}◇ by construction', index
    )
    assert 'id="claim-no-jumps"' in page
    assert "There are 1 jumps." in page


def test_book_needs_no_network(built):
    loaded = r"""<(?:script|link|img|iframe)\b[^>]*?\b(?:src|href)=["']([^"']+)"""
    for page in built.parent.glob("*.html"):
        for address in re.findall(loaded, page.read_text("utf-8")):
            assert not re.match("(https?:)?//", address), f"{page.name}: {address}"
            if not address.startswith(("#", "data:")):
                assert (page.parent / address.partition("?")[0]).exists(), address


def another_python(folder):
    """Lay out the packages of this environment, with the theme, elsewhere; but msc."""
    venv.create(folder, symlinks=True)
    [packages] = folder.glob("lib/*/site-packages")
    for package in Path(sysconfig.get_path("purelib")).iterdir():
        if package.name == "sphinx_book_theme":
            shutil.copytree(package, packages / package.name)
        elif not package.name.startswith(("msc", "__editable__")):
            (packages / package.name).symlink_to(package)
    (packages / "press").symlink_to(ROOT / "press")
    return folder / "bin" / "python"


def test_book_is_the_same_when_built_from_nothing_and_elsewhere(
    built, tmp_path, monkeypatch, tmp_path_factory
):
    warm, cold = built.parents[2], make_whole(tmp_path)
    for root in (warm, cold):  # the first has kept what it read of all other pages
        with (root / "book" / "index.md").open("a", encoding="utf-8") as index:
            index.write("\nMore prose.\n")
    pages = [build_about_msc(warm).parent]
    plain = run(warm, profile="quick")
    theirs = tmp_path_factory.mktemp("theirs")
    for name, value in set_by_readers(theirs).items():
        monkeypatch.setenv(name, value)
    assert run(warm, profile="quick") == plain  # nothing chosen has changed
    assert times_run(warm) == 1
    python = another_python(theirs / "python")
    monkeypatch.setattr(sys, "executable", str(python))
    pages.append(build_about_msc(cold).parent)
    assert "More prose." in (pages[0] / "index.html").read_text("utf-8")
    assert "asserts" in text_of(plain.notebook)
    assert (cold / "python.txt").read_text("utf-8") == str(python)
    assert set(differences(*pages)) <= MAY_DIFFER
    assert (pages[1] / "downloads" / "one-1.svg").is_file()
    there = run(cold, profile="quick").record
    for what in ("code", "packages", "environment"):
        assert getattr(there, what) == getattr(plain.record, what)


def test_where_there_is_no_msc_the_press_tells_what_it_would_execute(
    repository, tmp_path_factory
):
    python = another_python(tmp_path_factory.mktemp("python"))

    def call(*arguments):
        told = {"capture_output": True, "text": True}
        command = [python, *arguments]
        return subprocess.run(command, cwd=repository, check=False, **told)

    assert "No module named 'msc'" in call("-c", "import msc").stderr
    told = call("-m", "press.cli", "book", "--changed", "--profile", "full")
    assert told.stdout == "one: never executed with profile='full'\n"


def test_some_chapters_are_executed_again_elsewhere(repository, monkeypatch):
    """The builds themselves are made up; `make twice` is the whole."""
    write_notebook(chapter("# Two", "1 + 1"), repository / "book" / "two.ipynb")
    with (repository / "_toc.yml").open("a", encoding="utf-8") as toc:
        toc.write("- file: two\n")
    cache, html = (repository / "_build" / name for name in ("cache", "html"))
    (html / "_static").mkdir(parents=True)
    for file in (*(cache / f"{name}-1.ipynb" for name in ("one", "two")),
                 html / "index.html", html / "_static" / "seconds.js"):  # fmt: skip
        file.write_text("here", "utf-8")

    told = ["-m", "press.cli", "book", "--profile", "full", "--jobs", "2"]

    def build(command, *, cwd, env, check):
        assert command[1:] == told
        assert env == {"cache": cwd / "_build" / "cache"}
        kept = sorted(path.name for path in (cwd / "_build").rglob("*"))
        assert kept == ["cache", "two-1.ipynb"]
        assert (cwd / "book" / "one.ipynb").is_file()
        shutil.copytree(html, cwd / "_build" / "html")
        (cwd / "_build" / "html" / "_static" / "seconds.js").write_text("1", "utf-8")
        (cwd / "_build" / "html" / "index.html").write_text(elsewhere, "utf-8")
        return subprocess.CompletedProcess(command, status)

    monkeypatch.setattr(_release, "build_book", lambda **_: html / "index.html")
    monkeypatch.setattr(_release, "environment", lambda cache: {"cache": cache})
    monkeypatch.setattr(_release.subprocess, "run", build)
    said, elsewhere, status = [], "here", 0
    assert not build_twice(repository, profile="full", say=said.append)
    assert said == ["executed again elsewhere: one"]
    elsewhere = "there"
    assert build_twice(repository, profile="full") == ["index.html"]
    status = 1
    with pytest.raises(BookError, match="could not be built again elsewhere"):
        build_twice(repository, profile="full")


def test_differences_are_found(tmp_path):
    for name, files in {"a": {"x": "1", "y": "2"}, "b": {"x": "1", "y": "3"}}.items():
        (tmp_path / name / "deep").mkdir(parents=True)
        for file, text in files.items():
            (tmp_path / name / "deep" / file).write_text(text, "utf-8")
    (tmp_path / "b" / "z").write_text("", "utf-8")
    assert differences(tmp_path / "a", tmp_path / "b") == ["deep/y", "z"]


def test_every_figure_says_what_made_it_and_how_to_make_it_again(built):
    page = (built.parent / "one.html").read_text("utf-8")
    [block] = re.findall(r'<details class="msc-provenance">.*?</details>', page, re.S)
    text = html.unescape(re.sub(r"<[^>]+>", "", block))
    assert "book/one.ipynb, profile = 'quick', n = 3" in text
    assert f"Python {version_of('python')}" in text
    assert f"matplotlib {version_of('matplotlib')}" in text
    assert "msc run book/one.ipynb -p profile quick --out one.ipynb" in text
    for address in re.findall('href="([^"]+)"', block):
        assert (built.parent / address).is_file(), address
    seconds = (built.parent / "_static" / "seconds.js").read_text("utf-8")
    assert re.search(r'"one": \d+\.\d', seconds)
    assert page.index("data-seconds") < page.index("</details>")


def test_notebooks_are_there_with_and_without_outputs(built):
    executed = read_notebook(built.parent / "_sources" / "one.ipynb")
    assert "quick 6" in text_of(executed)
    assert "msc-provenance" not in json.dumps(executed)
    source = (built.parents[2] / "book" / "one.ipynb").read_bytes()
    assert (built.parent / "downloads" / "one.ipynb").read_bytes() == source


def test_gallery_shows_every_figure_and_leads_to_its_chapter(built):
    page = (built.parent / "figures.html").read_text("utf-8")
    [image] = re.findall(r'<img[^>]*one-1\.png"[^>]*>', page)
    assert 'alt="A tiny circle."' in image
    assert 'href="one.html"' in page[page.index(image) - 500 :]
    chapter = (built.parent / "one.html").read_text("utf-8")
    [number] = re.findall(r'class="caption-number">(Figure 1 of this book) <', chapter)
    assert number in page[page.index(image) :]
    assert "No chapter" in gallery_markdown([])


def test_figures_are_found_in_order():
    def output(kind):
        return {"output_type": "display_data", "data": {kind: "AAAA"}}

    text = {"cell_type": "markdown", "source": "# T", "metadata": {}}
    cells = [
        {"cell_type": "code", "source": "", "metadata": {}, "outputs": [output(kind)]}
        for kind in ("image/png", "text/plain", "image/png")
    ]
    found = find_pictures("c", {"cells": [text, *cells]})
    assert [(one.name, one.cell, one.title) for one in found] == [
        ("c-1", 1, "T"),
        ("c-2", 3, "T"),
    ]


def test_a_book_is_built_by_one_at_a_time(built):
    root = built.parents[2]
    before = contents(root)
    shutil.copy(ROOT / "pyproject.toml", root)
    for act in (lambda: build_about_msc(root), lambda: release_book(root)):
        with (
            locked(root / "_build"),
            pytest.raises(ValueError, match="_build is in use by another build; wait"),
        ):
            act()
    (root / "pyproject.toml").unlink()
    assert contents(root) == before


def test_release_is_the_book_and_has_the_same_bytes_whenever_packed(built, tmp_path):
    root = tmp_path
    for name in ("pyproject.toml", "_config.yml", "_toc.yml"):
        shutil.copy(ROOT / name, root)
    html = root / "_build" / "html"
    heavy = shutil.ignore_patterns("_static")
    shutil.copytree(built.parent, html, ignore=heavy)
    book = contents(html)
    target = release_book(root)
    before = target.read_bytes()
    assert release_book(root).read_bytes() == before, "it does not hold itself"
    for file in (target.parent / target.stem).rglob("*"):
        os.utime(file, (1e9, 1e9))
    pack(target.parent / target.stem, target)
    assert target.read_bytes() == before
    with zipfile.ZipFile(target) as archive:
        names = {name.partition("/")[2] for name in archive.namelist()}
        assert archive.testzip() is None
    assert names == {path.as_posix() for path in book}


def test_release_and_pdf_want_a_built_book(tmp_path):
    for name in ("pyproject.toml", "_config.yml", "_toc.yml"):
        shutil.copy(ROOT / name, tmp_path)
    with pytest.raises(FileNotFoundError, match="build the book first, by `make book`"):
        release_book(tmp_path)
    with pytest.raises(FileNotFoundError, match="build the book first, by `make book`"):
        one_page(tmp_path, {"root": "index"}, "", "")


def test_on_paper_links_lead_within_the_document_and_sliders_are_pictures(tmp_path):
    head = '<head><link rel="stylesheet" href="_static/a.css"></head>'
    page = (
        '<article><h1 id="t">{}<a class="headerlink" href="#t">#</a></h1>{}</article>'
    )
    one = (
        '<a href="two.html#t">there</a> <a class="x" href="two.html">page</a> '
        '<a href="#t">here</a> <a href="https://example.org/">far</a> '
        '<a href="downloads/f.svg">file</a> <details><p>open</p></details>'
        '<img src="_images/film.gif"><script>live()</script>'
    )
    (tmp_path / "one.html").write_text(head + page.format("One", one), "utf-8")
    (tmp_path / "two.html").write_text(head + page.format("Two", ""), "utf-8")
    toc = {"root": "one", "parts": [{"caption": "P", "chapters": [{"file": "two"}]}]}
    text = one_page(tmp_path, toc, "Title & all", "us")
    assert set(re.findall('<a[^>]*href="([^"]*)"', text)) == {
        "#one",
        "#two",
        "#one--t",
        "#two--t",
        "https://example.org/",
    }
    ids = re.findall(r'\sid="([^"]*)"', text)
    assert sorted(ids) == ["one", "one--t", "two", "two--t"]
    assert "<span>file</span>" in text
    assert "<details open>" in text
    assert "live()" not in text
    assert f'src="{tmp_path.name}/_static/film.png"' in text
    assert f'href="{tmp_path.name}/_static/a.css"' in text
    assert "<h1>Title &amp; all</h1>" in text


def test_dates_of_a_pdf_are_fixed_and_nothing_moves():
    pdf = (
        b"1 /CreationDate (D:20261122220550+00'00')\n/ModDate (D:20261122220550+00'00')"
    )
    fixed = without_dates(pdf)
    assert len(fixed) == len(pdf)
    assert b"2026" not in fixed
    assert without_dates(fixed) == fixed


def test_printing_names_the_missing_browser(built, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileNotFoundError, match=r"none of chromium, .* is installed"):
        print_book(built.parents[2])


@pytest.mark.skipif(shutil.which("chromium") is None, reason="there is no Chromium")
def test_a_pdf_is_the_same_when_printed_again(built):
    root = built.parents[2]
    shutil.copy(ROOT / "pyproject.toml", root)
    first = print_book(root).read_bytes()
    assert first.startswith(b"%PDF")
    assert print_book(root).read_bytes() == first


def test_warning_stops_the_build_and_keeps_the_earlier_book(built):
    root = built.parents[2]
    before = contents(built.parent)
    page = root / "book" / "index.md"
    text = page.read_text("utf-8")
    page.write_text(text + "See {doc}`nowhere`.\n", "utf-8")
    with pytest.raises(BookError, match=r"book/index\.md.*WARNING.*nowhere"):
        build_about_msc(root)
    assert not (root / "_build/stage/_build").exists(), "it would not warn again"
    page.write_text(text, "utf-8")
    assert contents(built.parent) == before
