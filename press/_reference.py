"""What pages of the reference include: parameters, commands and tests, as Markdown.

Each is made from what it tells of (the chapters, the command line, the tests that
`equations.md` names), so that no page holds a copy that could grow old.
"""

from __future__ import annotations

import ast
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

from press import _notebook as nb
from press._chapters import BookError, run_tool
from press._markdown import code, fenced, label, plain
from press._parameters import Parameter

PARAMETERS = "parameters_tables.md"
COMMANDS = "commands_help.md"
TESTS = "tests_sources.md"

# A link to a test: [its words](test_file.test_name).
_TEST_LINK = re.compile(r"\]\((test_\w+)\.(test_\w+)\)")


def write_reference(root: Path, stage: Path, chapters: Sequence[Path]) -> None:
    """Write what pages of the reference include, and lay out what they link to.

    Parameters
    ----------
    root : Path
        The repository. What belongs to a page that it lacks is left out.
    stage : Path
        Folder that mirrors the repository; the pages lie in its `book/`.
    chapters : sequence of Path
        The notebooks, in the order of the book.

    Raises
    ------
    ValueError
        If `equations.md` names a test that does not exist.
    BookError
        If the command line does not tell its options.
    """
    book, folder = root / "book", stage / "book"
    for name in ("CHANGELOG.md", "CITATION.cff"):
        if (root / name).is_file():
            shutil.copy(root / name, stage)
    if (book / "parameters.md").is_file():
        tables = parameters_markdown(chapters)
        (folder / PARAMETERS).write_text(tables, encoding="utf-8")
    if (book / "commands.md").is_file():
        told = run_tool("msc.cli:main", ["help"], cache=root / "_build" / "cache")
        if told.returncode != 0:
            raise BookError(f"msc help failed:\n{told.stderr.strip()}")
        (folder / COMMANDS).write_text(commands_markdown(told.stdout), encoding="utf-8")
    if (book / "equations.md").is_file():
        links = named_tests((book / "equations.md").read_text(encoding="utf-8"))
        (stage / "tests").mkdir(exist_ok=True)
        for file in dict.fromkeys(file for file, _ in links):
            shutil.copy(root / "tests" / f"{file}.py", stage / "tests")
        (folder / TESTS).write_text(sources_markdown(links, root), encoding="utf-8")


def mend_backlinks(html: Path) -> None:
    """Lead links from sources to their documentation to where it stands.

    Sphinx takes all names of a module to be documented under one prefix. Here the
    public ones go by `msc`, and others by their module.

    Parameters
    ----------
    html : Path
        Folder of the finished book; without a page `api` nothing is done.
    """
    page = html / "api.html"
    if not page.is_file():
        return
    known = set(re.findall(r'id="(msc\.[\w.]+)"', page.read_text(encoding="utf-8")))
    for source in (html / "_modules" / "msc").rglob("*.html"):
        floor = source.parent.name

        def mend(link: re.Match[str], floor: str = floor) -> str:
            return link[1] if link[1] in known else f"msc.{floor}.{link[2]}"

        text = source.read_text(encoding="utf-8")
        pattern = rf"(?<=api\.html#)(msc\.(?:{floor}\.)?(?:_\w+\.)?([\w.]+))"
        text = re.sub(pattern, mend, text)
        source.write_text(text, encoding="utf-8")


def parameters_markdown(chapters: Sequence[Path]) -> str:
    """Write a table of parameters for each chapter that has some.

    Parameters
    ----------
    chapters : sequence of Path
        Notebooks.

    Returns
    -------
    str
        Markdown: a section a chapter, named and linked by its title, and a sentence
        that names the others.
    """
    sections, others = [], []
    for path in chapters:
        notebook = nb.read_notebook(path)
        parameters = nb.parameters(notebook)
        link = f"[{label(nb.title(notebook) or plain(path.stem))}]({path.stem})"
        if not parameters:
            others.append(link)
            continue
        rows = [
            f"| {' | '.join((code(name), code(one.default), *_words(one)))} |"
            for name, one in parameters.items()
        ]
        head = f"## {link}\n\n{code(f'book/{path.name}')}\n"
        table = ["| parameter | default | meaning | values |", "|---|---|---|---|"]
        table += rows
        sections.append("\n".join([head, *table]))
    if others:
        sections.append(f"Without parameters: {', '.join(others)}.")
    return "\n\n".join(sections) + "\n"


def commands_markdown(text: str) -> str:
    r"""Lay out what `msc help` prints.

    Parameters
    ----------
    text : str
        The overview, then the help of each command.

    Returns
    -------
    str
        Markdown: the overview, and a section a command.

    Examples
    --------
    >>> print(commands_markdown("usage: msc COMMAND\n\nusage: msc run [-h]\n"))
    ```text
    usage: msc COMMAND
    ```
    <BLANKLINE>
    ## msc run
    <BLANKLINE>
    ```text
    usage: msc run [-h]
    ```
    <BLANKLINE>
    """
    sections = []
    for part in re.split(r"^(?=usage: )", text, flags=re.MULTILINE):
        if part.strip():
            command = re.match(r"usage: (msc [a-z]+)", part)
            head = f"## {command[1]}\n\n" if command else ""
            sections.append(f"{head}{fenced(part.strip(), 'text')}")
    return "\n\n".join(sections) + "\n"


def named_tests(page: str) -> list[tuple[str, str]]:
    """List the tests that a page links to.

    Parameters
    ----------
    page : str
        Markdown.

    Returns
    -------
    list of tuple of str
        File, without its ending, and name of each test, once, in order.

    Examples
    --------
    >>> named_tests("[a spring](test_dmp.test_a), [again](test_dmp.test_a)")
    [('test_dmp', 'test_a')]
    """
    return list(dict.fromkeys(_TEST_LINK.findall(page)))


def sources_markdown(links: Sequence[tuple[str, str]], root: Path) -> str:
    """Show the source of tests.

    Parameters
    ----------
    links : sequence of tuple of str
        File and name of each.
    root : Path
        The repository.

    Returns
    -------
    str
        Markdown: a section a module, with its whole file for download, and in it the
        tests, each under the anchor `file.name` and headed by the words of its name.

    Raises
    ------
    ValueError
        If a test does not exist.
    """
    sections = []
    for file in dict.fromkeys(file for file, _ in links):
        path = root / "tests" / f"{file}.py"
        sections.append(
            f"## msc.{file.removeprefix('test_')}\n\n"
            f"{{download}}`tests/{file}.py <../tests/{file}.py>`"
        )
        for name in (name for other, name in links if other == file):
            block = fenced(_source(path, name), "python")
            words = name.removeprefix("test_").replace("_", " ")
            sections.append(f"({file}.{name})=\n### {words}\n\n{block}")
    return "\n\n".join(sections) + "\n"


def _words(parameter: Parameter) -> tuple[str, str]:
    """Say what a parameter means and may be; what is quoted is code."""
    wanted = re.sub(
        r'("[^"]*")|[^\s"]+|"',
        lambda word: (code if word[1] else plain)(word[0]),
        parameter.wanted,
    )
    return plain(parameter.meaning) or "–", wanted


def _source(path: Path, name: str) -> str:
    """Return the source of one test, its decorators included."""
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            first = min([node.lineno, *(one.lineno for one in node.decorator_list)])
            return "\n".join(text.splitlines()[first - 1 : node.end_lineno])
    raise ValueError(
        f"equations.md names {path.stem}.{name}, but tests/{path.name} has no such test"
    )
