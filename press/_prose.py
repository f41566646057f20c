"""Check the words of pages: one word a thing, no sentence too long, no word twice.

`book/words.toml` says what to guard. Only prose is read: no code, no formulas, no
targets of links. `python -m press._prose FILE …` prints a line for each thing found.
"""

import re
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from mdit_py_plugins.dollarmath import dollarmath_plugin
from mdit_py_plugins.myst_blocks import myst_block_plugin
from mdit_py_plugins.myst_role import myst_role_plugin
from mdit_py_plugins.substitution import substitution_plugin

from press._notebook import read_notebook, source

_DOUBLED = re.compile(r"\b([^\W\d_]+)\s+\1\b", re.IGNORECASE)
_END = re.compile(r"(?<=[.!?:;])[)\"”’]*\s+")  # of a sentence, or of its half


@dataclass(frozen=True)
class Style:
    """What to guard."""

    longest: int  # words in a sentence, or up to a colon or a semicolon
    terms: Mapping[str, str]  # a pattern, and the word to use instead
    twice: Sequence[str] = ()  # what may stand twice in a row


def read_style(file: Path) -> Style:
    """Read a file of words."""
    return Style(**tomllib.loads(file.read_text(encoding="utf-8")))


def find_faults(text: str, style: Style) -> Iterator[tuple[int, str]]:
    r"""Yield the line and the words of each thing found in Markdown.

    >>> style = Style(6, {"train set": "training set"})
    >>> [*find_faults("A `train set` is is\n\na train set.", style)]
    [(1, "'is is': once"), (3, "'train set': training set")]
    """
    for line, prose in _paragraphs(text):
        for found in _DOUBLED.finditer(prose):
            if found[1].lower() not in style.twice:
                yield line, f"{found[0]!r}: once"
        for pattern, wanted in style.terms.items():
            for found in re.finditer(rf"\b{pattern}\b", prose, re.IGNORECASE):
                yield line, f"{found[0]!r}: {wanted}"
        for sentence in _END.split(prose):
            if (n_words := len(sentence.split())) > style.longest:
                start = " ".join(sentence.split()[:6])
                yield line, f"{start!r} …: {n_words} words; at most {style.longest}"


def _paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """Yield each paragraph, heading or cell of a table: its line, and its prose."""
    parser = MarkdownIt("commonmark").enable("table").use(dollarmath_plugin)
    for plugin in (myst_block_plugin, myst_role_plugin, substitution_plugin):
        parser.use(plugin)
    line, quotes = 0, 0  # those hold the words of others
    for token in parser.parse(text):
        line = token.map[0] + 1 if token.map else line
        quotes += token.nesting * token.type.startswith("blockquote")
        if token.type == "inline" and not quotes:
            yield line, "".join(map(_prose, token.children or ()))


def _prose(token: Any) -> str:
    """Return the text of a piece of a paragraph; of what is none, a dot."""
    if token.type in ("softbreak", "hardbreak"):
        return " "
    if token.type == "text":
        return str(token.content)
    return "·" if token.content else ""


def main(names: Sequence[str]) -> int:
    """Print what is found in pages; the exit status is 1 if there is anything."""
    style = read_style(Path("book/words.toml"))
    n_faults = 0
    for file in map(Path, names):
        if file.suffix == ".ipynb":
            cells = enumerate(read_notebook(file)["cells"], start=1)
            texts = {
                f"{file}, cell {number}": source(cell)
                for number, cell in cells
                if cell["cell_type"] == "markdown"
            }
        else:
            texts = {f"{file}": file.read_text(encoding="utf-8")}
        for where, text in texts.items():
            for line, words in find_faults(text, style):
                n_faults += 1
                print(f"{where}:{line}: {words}")
    return int(n_faults > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
