"""What the README says is so."""

import json
import re
from pathlib import Path

import pytest

from msc.claims import VERDICTS, with_summary
from msc.claims._page import summary_markdown

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SUMMARY = json.loads((ROOT / VERDICTS).read_text(encoding="utf-8"))


def test_readme_quotes_the_verdicts():
    assert with_summary(README, SUMMARY) == README, (
        f"run: msc claims --out {VERDICTS} --readme README.md"
    )


def test_summary_has_each_claim_once():
    table = summary_markdown(SUMMARY)
    named = re.findall(r"[a-z0-9-]{5,}", table)
    assert sorted(set(named) & set(SUMMARY)) == sorted(SUMMARY)
    counts = [int(count) for count in re.findall(r"\| (\d+) \|", table)]
    assert sum(counts) == len(SUMMARY)


def test_a_page_without_marks_is_refused():
    with pytest.raises(ValueError, match=r"page: no lines <!-- verdicts"):
        with_summary("# A page", SUMMARY)


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_code_of_the_readme_compiles(code):
    compile(code, "README.md", "exec")


def test_first_example_of_the_readme_finds_the_break(capsys):
    exec(re.findall(r"```python\n(.*?)```", README, re.DOTALL)[0], {})
    assert "jumps after [35]" in capsys.readouterr().out


def test_files_that_the_readme_names_are_there():
    for name in re.findall(r"\]\(([^):]+)\)", README):
        assert (ROOT / name).exists(), name
    targets = re.findall(r"^make ([a-z]+)|`make ([a-z]+)`", README, re.MULTILINE)
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in {one or other for one, other in targets}:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
