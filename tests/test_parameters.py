"""Parameters: what a chapter declares of them, what is refused, that the rest runs."""

import ast
import json
import os
import re
import time
from pathlib import Path

import numpy as np
import papermill.cli
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from settings import CHAPTERS, DECLARED, ONCE_DIED, draw_settings

from msc.cli import main
from press import BookError, check_parameters, expect
from press import _book as book
from press._chapters import Chapter, Record, run_chapters
from press._notebook import (
    code_cells,
    read_notebook,
    source,
    tags,
    unmet,
    write_notebook,
)
from press._pages import parameters_markdown
from press._parameters import WORDS, Parameter, check, declared, resolve
from press._processes import environment, run_tool

ROOT = Path(__file__).parents[1]
CACHE = ROOT / "_build" / "cache"
CELL = """\
n = 24  # tasks (2 to 360)
k = 4  # parts; None leaves it open (1 to 10, at most n, or None)
angle = 60.0  # degrees (any number, modulo 360)
size = 0.5  # how large (0.1 to 2.5)
way = "even"  # how they are drawn
# ("even", "uniform" or "at random")
power = 2  # of two (1, 2, 4 or None)
shown = True  # whether it is drawn
name = "x"  # whatever
"""
KNOWN = declared(CELL)


# What is declared


@pytest.mark.parametrize("name", DECLARED)
def test_every_parameter_declares_its_values_and_its_default_is_one(name):
    assert [key for key, one in DECLARED[name].items() if not one.values] == []
    assert check(DECLARED[name], {}) == {}


@pytest.mark.parametrize("name", DECLARED)
def test_a_chapter_checks_its_parameters_before_anything(name):
    declaring, first, *_ = code_cells(read_notebook(CHAPTERS[name]))
    assert "parameters" in tags(declaring)
    assert source(first).splitlines() == [
        "from press import check_parameters",
        "",
        "check_parameters(globals())",
    ]


def test_a_comment_is_a_meaning_and_the_values():
    assert KNOWN["n"] == Parameter("24", "tasks", "2 to 360")
    assert KNOWN["way"].meaning == "how they are drawn"
    assert {name: one.wanted for name, one in KNOWN.items()} == {
        "n": "a whole number from 2 to 360",
        "k": "a whole number from 1 to 10, at most n or None",
        "angle": "any number, modulo 360",
        "size": "a number from 0.1 to 2.5",
        "way": '"even", "uniform" or "at random"',
        "power": "1, 2, 4 or None",
        "shown": "True or False",
        "name": "text",
    }


@pytest.mark.parametrize(
    "values",
    [
        "2 too 360",
        "2 to",
        "3",
        "to 3",
        "a or b",
        "see the ledger",
        "1 to 10, at most",
        "",
    ],
)
def test_values_that_cannot_be_understood_are_named(values):
    with pytest.raises(ValueError, match=rf"^n: its comment ends in \({values}\); "):
        declared(f"n = 3  # tasks ({values})")


def test_a_bound_has_to_be_declared():
    with pytest.raises(ValueError, match=r"^k is bounded by m, which is not declared"):
        declared("k = 3  # parts (1 to 10, at most m)")


@pytest.mark.parametrize("code", ["n = ", "n = (", "%matplotlib inline", "  n = 3\n 4"])
def test_a_cell_that_is_no_python_is_told_in_a_sentence(code):
    with pytest.raises(ValueError, match=r"^its cell of parameters is no Python: "):
        declared(code)


def test_the_page_of_parameters_tells_the_values():
    page = parameters_markdown([ROOT / FIG3, ROOT / FIG8])
    row = "| `n_samples` | `24` | training tasks, evenly spaced over the circle | {} |"
    assert row.format("a whole number from 2 to 360") in page
    choices = '| `"even"`, `"uniform"` or `"nonuniform"` |'
    assert f"| `design` | `'even'` | how sets are drawn {choices}" in page


# What is read


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("n", 48, 48),
        ("n", 48.0, 48),
        ("n", "48", 48),
        ("n", "1e2", 100),
        ("n", np.int64(48), 48),
        ("k", None, None),
        ("k", "None", None),
        ("k", "null", None),
        ("angle", 360, 0.0),
        ("angle", -5, 355.0),
        ("angle", "7.225e2", 2.5),
        ("angle", -1e-20, 0.0),
        ("size", 1, 1.0),
        ("size", "1e-1", 0.1),
        ("way", "at random", "at random"),
        ("power", 4.0, 4),
        ("power", "None", None),
        ("shown", False, False),
        ("name", "1.5 apples", "1.5 apples"),
    ],
)
def test_a_value_is_read_as_its_type_has_it(name, value, read):
    found = check(KNOWN, {name: value})[name]
    assert found == read
    assert type(found) is type(read)


NO_NUMBER = [True, "True", "", "many", [24], {24: 1}, 2j, b"24", "24,0"]
NO_NUMBER += [1e999, float("nan"), "nan", "-inf", "1e999"]
WRONG = {
    "n": [*NO_NUMBER, None, 1, 361, 2.5, "2.5", 1e300, 10**5000, "9" * 5000],
    "k": [*NO_NUMBER, 0, 11, "none"],
    "angle": [*NO_NUMBER, None, 10**400],
    "size": [*NO_NUMBER, None, 0.09, 2.51, -1, "0"],
    "way": ["Even", "even ", "", 1, None, True, ["even"]],
    "power": [*NO_NUMBER, 3, 2.5],
    "shown": [1, 0, "yes", None],
    "name": [5, None, ["x"], True],
}


@pytest.mark.parametrize("name", WRONG)
def test_a_value_that_cannot_be_is_refused_by_name(name):
    wanted = re.escape(KNOWN[name].wanted)
    for value in WRONG[name]:
        with pytest.raises(ValueError, match=rf"^{name}=.{{,60}}; wanted {wanted}$"):
            check(KNOWN, {name: value})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"n": 3}, "k=4, n=3; wanted k at most n"),
        ({"n": "2", "k": 3.0}, "k=3, n=2; wanted k at most n"),
        ({"m": 3}, "no parameter 'm'; it declares: "),
    ],
)
def test_parameters_are_held_against_each_other(values, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        check(KNOWN, values)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_an_angle_lands_in_the_first_turn(angle):
    found = check(KNOWN, {"angle": angle})["angle"]
    assert 0 <= found < 360
    assert found == pytest.approx(np.mod(angle, 360)) or found == 0


@given(
    st.text(max_size=8)
    | st.integers().map(str)
    | st.floats().map(str)
    | st.sampled_from(["True", "False", "None", "null", "1_000", "0x10", "010", "٣"])
)
def test_words_mean_what_they_mean_to_papermill(word):
    ours, theirs = resolve(word), papermill.cli._resolve_type(word)
    assert repr(ours) == repr(theirs)


# In a running chapter


def running(*cells, **values):
    """Return the variables of a chapter after its first cells."""
    return {"In": ["", *cells], **values}


def test_text_becomes_a_number_in_a_running_chapter():
    names = running(CELL, "# Parameters\nn = '1e2'", n="1e2", k=None, angle=-5)
    check_parameters(names)
    assert (names["n"], names["k"], names["angle"]) == (100, None, 355.0)


def test_the_cell_as_it_was_last_run_counts():
    wider = CELL.replace("2 to 360", "2 to 999")
    check_parameters(running(CELL, "n = 500", wider, n=500))
    with pytest.raises(
        ValueError, match=r"^n=500; wanted a whole number from 2 to 360"
    ):
        check_parameters(running(wider, CELL, n=500))


def test_an_edited_default_keeps_the_type():
    edited = CELL.replace("24 ", "'48' ").replace("60.0", "-5").replace("0.5", "1")
    names = running(edited, n="48", angle=-5, size="1.5", k=2)
    check_parameters(names)
    assert (names["n"], names["angle"], names["size"]) == (48, 355.0, 1.5)


def test_other_cells_and_a_plain_script_declare_nothing():
    scratch = [
        "x = 5  # tasks (of ten)",
        "x = 6  # Eq. (4)",
        "print(3)  # (1 to 2)",
        "x = (",
        "%time x",
    ]
    names = running(*scratch, x=5)
    check_parameters(names)
    check_parameters({"n": "anything"})
    with pytest.raises(ValueError, match=r"^x: its comment ends in \(1 two 3\)"):
        check_parameters(running("y = 1  # (1 to 2)\nx = 5  # (1 two 3)"))


def tiny(*codes):
    """Return a chapter: its parameters, the check, further code cells."""
    first = "from press import check_parameters\n\ncheck_parameters(globals())"
    cells = [
        {
            "cell_type": "code",
            "id": str(number),
            "metadata": {} if number else {"tags": ["parameters"]},
            "source": code,
            "outputs": [],
            "execution_count": None,
        }
        for number, code in enumerate((CELL, first, *codes))
    ]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    metadata = {"kernelspec": kernel}
    return {"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}


@pytest.fixture
def chapter(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "tiny.ipynb"
    touch = "from pathlib import Path\nPath('ran').touch()"
    write_notebook(tiny(touch, "print(n, k, angle, size)"), path)
    return path


def printed(path):
    """Return what a run's last cell printed."""
    *_, last = code_cells(read_notebook(path))
    return "".join(last["outputs"][0]["text"]).strip()


def test_papermill_reads_text_as_numbers_and_refuses_before_anything(chapter, tmp_path):
    papermill = "papermill.cli:papermill"
    file = tmp_path / "given.yaml"
    file.write_text("n: 3e0\nsize: 1e-1\n", "utf-8")
    assert isinstance(yaml.safe_load(file.read_text("utf-8"))["n"], str)
    run = [chapter, "out.ipynb", "--no-progress-bar", "-f", file]
    refused = run_tool(papermill, run, cache=CACHE)
    assert refused.returncode == 1
    assert refused.stderr.strip().endswith("ValueError: k=4, n=3; wanted k at most n")
    assert not (tmp_path / "ran").exists()


def test_the_command_line_reads_words_and_tells_what_is_amiss(chapter, capfd):
    claims = "from press import expect\n\nexpect({'size is large': size > 1})"
    warn = "import warnings\nwarnings.warn(f'{n} is few')"
    write_notebook(tiny(claims, warn, "print(n, k, angle, size)"), chapter)
    words = ["-p", "n", "1e2", "-p", "k", "None", "-p", "angle", "1e-5"]
    assert main(["run", str(chapter), *words, "--out", "out.ipynb"]) == 0
    assert printed(Path("out.ipynb")) == "100 None 1e-05 0.5"
    said = capfd.readouterr()
    assert said.out.startswith("tiny: never executed with n=100, k=None, angle=1e-05\n")
    told = r"tiny, code cell 4 \(import warnings\) wrote to stderr: .*: 100 is few.*\n"
    assert re.fullmatch(told, said.err)
    assert not [*Path("_build/cache").glob("*.ipynb")], "it would not be told again"
    told = unmet(read_notebook(Path("out.ipynb")))
    assert told == f"code cell 3: {WORDS} - size is large"


# What is refused


FIG3 = "book/fig3_free_24.ipynb"
FIG8 = "book/fig8_sample_size.ipynb"
ARM = "book/method_arm.ipynb"
SKILL = "book/method_skill.ipynb"
ILLEGAL = [
    (FIG8, ["design", "gaussian"], "design='gaussian'; wanted \"even\", "),
    (FIG8, ["reading", "'gate lost'"], "reading="),
    (FIG8, ["reading", "beside jumps"], "reading='beside jumps'; wanted "),
    (FIG8, ["design", ""], "design=''; wanted "),
    (FIG8, ["design", "1"], "design=1; wanted "),
    (FIG8, ["profile", "slow"], 'profile=\'slow\'; wanted "quick" or "full"'),
    (FIG8, ["profile", "None"], "profile=None; wanted "),
    (FIG8, ["profile", "True"], "profile=True; wanted "),
    (FIG3, ["n_samples", "1"], "n_samples=1; wanted a whole number from 2 to 360"),
    (FIG3, ["n_samples", "361"], "n_samples=361; wanted "),
    (FIG3, ["n_samples", "0"], "n_samples=0; wanted "),
    (FIG3, ["n_samples", "-24"], "n_samples=-24; wanted "),
    (FIG3, ["n_samples", "24.5"], "n_samples=24.5; wanted "),
    (FIG3, ["n_samples", "many"], "n_samples='many'; wanted "),
    (FIG3, ["n_samples", ""], "n_samples=''; wanted "),
    (FIG3, ["n_samples", "True"], "n_samples=True; wanted "),
    (FIG3, ["n_samples", "None"], "n_samples=None; wanted "),
    (FIG3, ["n_samples", "nan"], "n_samples=nan; wanted "),
    (FIG3, ["n_samples", "1e999"], "n_samples=inf; wanted "),
    (FIG3, ["n_samples", "9" * 99], "n_samples=9999"),
    (FIG3, ["n_samples", "[24]"], "n_samples='[24]'; wanted "),
    (FIG3, ["n_samples", "{24: 1}"], "n_samples='{24: 1}'; wanted "),
    (FIG3, ["n_samples", "3"], "n_charts=4, n_samples=3; wanted n_charts at most n_s"),
    (
        FIG3,
        ["n_charts", "0"],
        "n_charts=0; wanted a whole number from 1 to 10, at most",
    ),
    (FIG3, ["n_charts", "11"], "n_charts=11; wanted "),
    (FIG3, ["n_charts", "four"], "n_charts='four'; wanted "),
    (
        FIG3,
        ["n_samples", "8", "-p", "n_charts", "9"],
        "n_charts=9, n_samples=8; wanted",
    ),
    (FIG3, ["seed", "-1"], "seed=-1; wanted a whole number from 0 to 4294967295"),
    (FIG3, ["seed", "4294967296"], "seed=4294967296; wanted "),
    (FIG3, ["seed", "0.5"], "seed=0.5; wanted "),
    (FIG3, ["seed", "1", "-p", "seed", "2"], "seed is given twice; wanted one value"),
    (
        FIG3,
        ["n_sample", "24"],
        "no parameter 'n_sample'; it declares:",
    ),
    (FIG3, ["", "24"], "no parameter ''; it declares: "),
    (ARM, ["weight", "6"], "weight=6; wanted a whole number from 0 to 5"),
    (ARM, ["weight", "-1"], "weight=-1; wanted "),
    (ARM, ["strength", "0"], "strength=0; wanted a number from 0.1 to 1000"),
    (ARM, ["strength", "1e9"], "strength=1000000000.0; wanted "),
    (ARM, ["task_deg", "nan"], "task_deg=nan; wanted any number, modulo 360"),
    (ARM, ["task_deg", "-inf"], "task_deg=-inf; wanted "),
    (ARM, ["strength", "-1e2"], "strength=-100.0; wanted "),
    (ARM, ["task_deg", "north"], "task_deg='north'; wanted "),
    (SKILL, ["n_samples", "2"], "n_charts=4, n_samples=2; wanted n_charts at most"),
    ("book/gallery.ipynb", ["n_tasks", "1"], "n_tasks=1; wanted "),
    ("book/gallery.ipynb", ["n_poses", "1e3"], "n_poses=1000.0; wanted "),
    ("book/what_it_costs.ipynb", ["n", "1"], "no parameter 'n'; it"),
]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("path", "words", "message"), ILLEGAL)
def test_the_illegal_is_refused_in_a_sentence_before_anything(
    path, words, message, here, capfd
):
    out = Path("out.ipynb")
    out.write_text("mine", "utf-8")
    start = time.process_time()
    command = ["run", str(ROOT / path), "-p", *words, "--out", "out.ipynb"]
    assert main(command) == 2
    assert time.process_time() - start < 1
    said = capfd.readouterr()
    where = "" if "twice" in message else f"{Path(path).stem}: "
    assert said.err.startswith(f"msc: error: {where}{message}")
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert list(here.iterdir()) == [here / "out.ipynb"]
    assert out.read_text("utf-8") == "mine"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "No such file or directory: no.ipynb"),
        (b"", "no.ipynb is not a notebook: "),
        (b"\xff\x00", "no.ipynb is not a notebook: "),
        (b"[" * 100_000, "no.ipynb is not a notebook: "),
        (b"[]", "no.ipynb is not a notebook: it has no cells"),
        (b'{"cells": 3}', "no.ipynb is not a notebook: it has no cells"),
        (
            b'{"cells": [3]}',
            "no.ipynb is not a notebook: cell 1 lacks one of cell_type",
        ),
        (
            json.dumps(tiny()).replace("2 to 360", "2 two 3").encode(),
            "no: n: its",
        ),
        (
            json.dumps(tiny()).replace("24 ", "= ").encode(),
            "no: its cell of para",
        ),
    ],
)
@pytest.mark.usefixtures("here")
def test_what_is_no_chapter_is_told_in_a_sentence(content, message, capfd):
    if content is not None:
        Path("no.ipynb").write_bytes(content)
    assert main(["run", "no.ipynb", "--out", "new/out.ipynb"]) == 2
    assert capfd.readouterr().err.startswith(f"msc: error: {message}")
    assert not Path("new").exists()


def test_a_refusal_takes_less_than_two_seconds_from_the_start(tmp_path):
    words = [ROOT / FIG8, "-p", "design", "gaussian", "--out", tmp_path / "out.ipynb"]
    environment(CACHE)  # made once
    before = os.times()
    refused = run_tool("msc.cli:main", ["run", *words], cache=CACHE)
    after = os.times()  # of the processor, however busy the machine is
    assert sum(after[2:4]) - sum(before[2:4]) < 2
    assert refused.stderr.startswith(
        "msc: error: fig8_sample_size: design='gaussian'; wanted "
    )


def test_a_chapter_is_never_written_over(chapter, capfd):
    before = chapter.read_bytes()
    same = f"../{chapter.parent.name}/{chapter.name}"
    assert main(["run", "tiny.ipynb", "--out", same]) == 2
    assert "is the chapter itself; wanted another file" in capfd.readouterr().err
    assert chapter.read_bytes() == before


def test_no_chapter_runs_if_one_is_refused(chapter, tmp_path):
    other = tmp_path / "other.ipynb"
    write_notebook(tiny(), other)
    with pytest.raises(ValueError, match=r"^other: n=1; wanted"):
        run_chapters(
            {chapter: {}, other: {"n": 1}}, root=tmp_path, cache=tmp_path / "cache"
        )
    assert not (tmp_path / "ran").exists()


# What runs


def test_claims_that_do_not_hold_are_told_in_words():
    assert expect({"two is even": True, "three is odd": np.True_}) is None
    shown = repr(expect({"two is even": True, "three is": False, "five is": None}))
    assert shown == f"{WORDS}\n- three is\n- five is"


def test_a_book_is_not_built_on_claims_that_do_not_hold(chapter, tmp_path, monkeypatch):
    run = read_notebook(chapter)
    data = {"text/plain": repr(expect({"two is odd": False})).splitlines(keepends=True)}
    run["cells"][2]["outputs"] = [{"output_type": "execute_result", "data": data}]
    done = Chapter("tiny", run, Record("", {}, {}, {}, 0.0), {})
    monkeypatch.setattr(book, "pages", lambda _: [])
    monkeypatch.setattr(book, "run_chapters", lambda *_, **__: [done])
    with pytest.raises(BookError, match=rf"^tiny, code cell 3: {WORDS} - two is odd$"):
        book.build_book(root=tmp_path)


# Of those that once died the quickest, and of the hundred (see tests/slow) as well.
QUICK = [*ONCE_DIED[:3:2]]
QUICK += [one for one in draw_settings(100, seed=14) if one[0] == "fig2_free_360"][-1:]


@pytest.mark.parametrize(("name", "values"), QUICK)
def test_a_handful_of_the_legal_settings_run(name, values, monkeypatch):
    monkeypatch.chdir(ROOT / "book")  # where JupyterLab runs them
    names = {"In": [""]}
    for cell in code_cells(read_notebook(CHAPTERS[name])):
        shown = execute(source(cell), names)
        if "parameters" in tags(cell):
            names |= values
        if hasattr(shown, "savefig"):
            shown.draw_without_rendering()


def execute(code, names):
    """Execute a cell as IPython does; return its last expression's value."""
    names["In"].append(code)
    lines = ast.parse(code)
    last = lines.body.pop() if isinstance(lines.body[-1], ast.Expr) else None
    exec(compile(lines, "cell", "exec"), names)
    return (
        eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        if last
        else None
    )
