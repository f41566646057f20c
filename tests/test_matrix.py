"""Answers at a glance: a row a question, a column a world."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from imagined_worlds import FOLDER, LAYOUTS, imagine_layouts

from msc.plots import assumption_matrix, world_matrix
from msc.plots._worlds import FAMILY_WORDS, QUESTION_WORDS, Matrix, _leaning
from msc.worlds import FAMILIES, load_questions

QUESTIONS = load_questions(FOLDER / "asked.yml")
ASKED = {one.id: one for one in QUESTIONS}


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory):
    return imagine_layouts(tmp_path_factory.mktemp("imagined"))


def test_all_questions_and_families_have_words():
    assert set(QUESTION_WORDS) == set(ASKED)
    assert set(FAMILY_WORDS) == set(FAMILIES) - {"variant"}


def test_a_cell_is_a_world_s_answer_and_leads_to_it(verdicts):
    matrix = world_matrix(verdicts, QUESTIONS)
    text, page = repr(matrix).splitlines(), matrix._repr_html_()
    place = [*QUESTION_WORDS].index("mse")
    assert text[1 + place] == f"●{'●' * len(LAYOUTS)}  MSE: one regression"
    assert text[1 + [*QUESTION_WORDS].index("continuous")].startswith("·······")
    for name in LAYOUTS:
        answer = verdicts["worlds"][name]["answers"]["mse"]
        told = f'title="{name}: {answer["value"]:.2f}'[:-1]
        assert told in page
        assert f'<a href="worlds_layouts.html#{name}">●</a>' in page
    assert "<td>6 / 0 / 0</td>" in page


def test_a_family_s_answer_stands_first_and_is_not_counted(verdicts):
    matrix = world_matrix(verdicts, QUESTIONS)
    told = dict(matrix.rows)["MSE: one regression"]["all, layouts of obstacles"]
    together = verdicts["families"]["mse"]["layout"]
    assert (told["answer"], told["value"]) == (together["answer"], together["value"])
    page = matrix._repr_html_()
    assert 'scope="col" class="msc-joint"><span>all</span>' in page
    assert "<td>6 / 0 / 0</td>" in page  # of six layouts


def test_ratios_lean_and_counts_do_not(verdicts):
    answers = verdicts["worlds"][LAYOUTS[0]]["answers"]
    assert _leaning(ASKED["mse"], answers["mse"])["leans"] == 1  # about a half
    assert _leaning(ASKED["executed-one-kernel"], {"value": 2.1})["leans"] == -2
    assert _leaning(ASKED["as-good-as-search"], {"value": 0.15})["leans"] == -1
    assert "leans" not in _leaning(ASKED["broken"], answers["broken"])
    assert "leans" not in _leaning(ASKED["mse"], {"answer": "not asked"})


@given(st.floats(-1, 100), st.floats(-1, 100))
def test_a_smaller_ratio_leans_no_less_to_holding(one, other):
    leans = [
        _leaning(ASKED["mse"], {"value": v})["leans"] for v in sorted((one, other))
    ]
    assert 2 >= leans[0] >= leans[1] >= -2


def test_a_key_explains_backgrounds_only_where_there_are_any():
    plain = Matrix("Plain", [("A", {"a": "1"})], [("row", {"a": {"answer": "holds"}})])
    assert "half the error" not in plain._repr_html_()
    leaning = {"a": {"answer": "holds", "leans": 2}}
    page = Matrix("", [("A", {"a": "1"})], [("row", leaning)])._repr_html_()
    assert 'class="msc-holds msc-for-2"' in page
    assert "half the error" in page


def test_heads_are_text():
    odd = Matrix("<b>", [("<i>", {"a": "<u>"})], [("<s>", {"a": {"answer": "fails"}})])
    page = odd._repr_html_()
    assert not any(tag in page for tag in ("<b>", "<i>", "<u>", "<s>"))


def test_an_answer_that_changes_with_a_choice_stands_out(verdicts):
    matrix = assumption_matrix(verdicts, QUESTIONS, {"layout": "over layouts"})
    rows = dict(matrix.rows)
    first = rows["nothing changed"]
    assert not any(one["differs"] for one in first.values())
    changed = rows["one kernel for all weights"]
    for key, one in changed.items():
        differs = one["answer"] not in ("not asked", first[key]["answer"])
        assert one["differs"] == differs
    assert any(one["differs"] for one in changed.values())
    assert "msc-differs" in matrix._repr_html_()
