"""The words of pages: what is found, where, and what is left alone."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_book import chapter

from press._notebook import write_notebook
from press._prose import Style, find_faults, main, read_style

ROOT = Path(__file__).parents[1]
STYLE = Style(4, {"train sets?": "training set"}, ["had"])
FAULTY = "# Once once\n\nA train\nset. One two three four five.\n"


@pytest.mark.parametrize(
    "text",
    [
        "`is is` train",
        "```\nA train set train set train set.\n```",
        "> A train set of five words, quoted {cite}`paper`",
        "$is is$ {ref}`is is` {{ is }} {{ is }}",
        "[a](<train set>)",
        "He had had it.",
        "One two three; four five six: seven.",
        "constrain sets",
        "| is | is |\n|---|---|\n| is | is |",
        "Is. Is it?",
    ],
)
def test_what_is_no_prose_or_no_fault_is_left_alone(text):
    assert not [*find_faults(text, STYLE)]


def test_each_fault_is_found_where_it_is():
    assert [*find_faults(FAULTY, STYLE)] == [
        (1, "'Once once': once"),
        (3, "'train set': training set"),
        (3, "'One two three four five.' …: 5 words; at most 4"),
    ]


@given(st.integers(1, 12), st.sampled_from(".;:?!"))
def test_words_of_a_sentence_are_counted_up_to_its_end(n_words, end):
    half = " ".join(f"w{number}" for number in range(n_words)) + end
    found = [*find_faults(f"{half} {half}\n{half}", STYLE)]
    assert len(found) == (3 if n_words > STYLE.longest else 0)


def test_pages_are_named_with_their_faults(tmp_path, monkeypatch, capsys):
    (tmp_path / "book").mkdir()
    (tmp_path / "book/words.toml").write_text("longest = 4\n[terms]\n", "utf-8")
    (tmp_path / "a.md").write_text("Good.\n\nNot not good.\n", "utf-8")
    write_notebook(chapter("Is is.", "'is is'"), tmp_path / "b.ipynb")
    monkeypatch.chdir(tmp_path)
    assert main(["a.md", "b.ipynb"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "a.md:3: 'Not not': once",
        "b.ipynb, cell 1:1: 'Is is': once",
    ]
    assert main([]) == 0


def test_no_wanted_word_is_a_fault_itself():
    style = read_style(ROOT / "book" / "words.toml")
    for wanted in style.terms.values():
        assert not [*find_faults(wanted, style)]
