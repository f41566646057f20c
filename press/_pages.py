"""What is added to the pages: figures to take away, where each comes from, references.

Each is made from what it tells of (the runs of chapters, the command line, the tests
that `equations.md` names), so that no page holds a copy that could grow old:

- under every figure a caption, unless its chapter has one for it, what made it, and the
  one command that makes it again; the figure as a file to download, and small on one
  page, `figures_gallery.md`;
- `opening.html`, the drawing that opens the book, and `matrix.html`, its answers at a
  glance: what cells tagged `opening` and `matrix` of some chapters showed, as the first
  page runs no code;
- `parameters_tables.md`, `commands_help.md` and `tests_sources.md`.
"""

import ast
import base64
import hashlib
import html
import io
import json
import re
import shlex
import shutil
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import quote

import PIL
from PIL import Image

from press._captions import BEGINNING
from press._chapters import Chapter
from press._edition import DOWNLOADS
from press._files import replace_file
from press._markup import code, fenced, label, paragraph, plain
from press._notebook import (
    Notebook,
    NotebookCell,
    alternative_text,
    code_cells,
    parameters,
    read_notebook,
    shown,
    source,
    tags,
    title,
)
from press._parameters import Parameter

SVG, PNG, HTML = "image/svg+xml", "image/png", "text/html"
SECONDS_JS = "seconds.js"
GALLERY = "figures_gallery.md"
SHOWN = {"opening": "opening.html", "matrix": "matrix.html"}
PARAMETERS = "parameters_tables.md"
COMMANDS_PAGE = "commands_help.md"
TESTS = "tests_sources.md"
_THUMBNAILS = "_thumbnails"  # folder of the staged book
_SIZE = (480, 360)  # no thumbnail is larger (pixels)

# Packages that figures owe their numbers and looks to; others only carry them.
_TELLING = ["python", "numpy", "scipy", "scikit-learn", "cvxpy", "pybullet", "pandas"]
_TELLING += ["matplotlib", "pillow"]

# A link to a test: [its words](test_file.test_name).
_TEST_LINK = re.compile(r"\]\((test_\w+)\.(test_\w+)\)")


@dataclass(frozen=True)
class Subject:
    """What a book is about: what a package hands to the book that tells of it.

    Parameters
    ----------
    program : str, default "python -m press.cli"
        How its command line is called; ``python -m`` runs the last word of it, too.
    packages : tuple of str, optional
        Packages whose docstrings the pages show; the first is the book's own.
    commands : str, optional
        What the command line tells of its options, as `press.tell_options` returns it.
    values : mapping of str to object, optional
        What pages may quote, by name, besides the results.
    fragments : mapping of str to str, optional
        Markdown that pages include, by the name of a file.
    """

    program: str = "python -m press.cli"
    packages: tuple[str, ...] = ()
    commands: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    fragments: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The book's own package; empty if there is none."""
        return self.packages[0] if self.packages else ""


# Figures


@dataclass(frozen=True)
class Picture:
    """A figure of a chapter."""

    chapter: str  # name
    title: str  # of the chapter
    number: int  # which of the chapter's figures, from 1
    cell: int  # place of its cell in the executed notebook
    alt: str  # what it shows, in words; empty if the cell does not say
    png: bytes
    svg: str  # empty if it has only pixels

    @property
    def name(self) -> str:
        """File name without ending."""
        return f"{self.chapter}-{self.number}"


def _number_clips(svg: str) -> str:
    """Name the clips of a figure by numbers.

    Matplotlib makes their names of places to the last bit, and that of a layout may
    differ from run to run.

    >>> _number_clips('<clipPath id="p0123456789"/> <g clip-path="url(#p0123456789)"/>')
    '<clipPath id="clip0"/> <g clip-path="url(#clip0)"/>'
    """
    known: dict[str, str] = {}
    return re.sub(
        r'(?<=id="|rl\(#)p[0-9a-f]{10}\b',
        lambda name: known.setdefault(name[0], f"clip{len(known)}"),
        svg,
    )


def find_pictures(chapter: str, notebook: Notebook) -> list[Picture]:
    """Find the figures of an executed chapter, in the order of the page."""
    found: list[Picture] = []
    for place, cell in enumerate(notebook["cells"]):
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if PNG in data:
                picture = Picture(
                    chapter,
                    title(notebook),
                    number=len(found) + 1,
                    cell=place,
                    alt=alternative_text(cell),
                    png=base64.b64decode("".join(data[PNG])),
                    svg=_number_clips("".join(data.get(SVG, ""))),
                )
                found.append(picture)
    return found


def without_lines(notebook: Notebook) -> Notebook:
    """Leave SVG out of an executed chapter: pages show PNG, and link to the SVG."""

    def lighter(output: NotebookCell) -> NotebookCell:
        data = output.get("data", {})
        if SVG not in data or PNG not in data:
            return output
        return output | {"data": {key: data[key] for key in data if key != SVG}}

    cells = [
        cell | {"outputs": [lighter(output) for output in cell["outputs"]]}
        if "outputs" in cell
        else cell
        for cell in notebook["cells"]
    ]
    return notebook | {"cells": cells}


def write_vectors(pictures: Sequence[Picture], folder: Path) -> None:
    """Write the figures that consist of lines as SVG."""
    folder.mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        if picture.svg:
            (folder / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")


def write_gallery(pictures: Sequence[Picture], book: Path, cache: Path) -> None:
    """Write a thumbnail of each figure, and what the page that shows them includes.

    Thumbnails are kept in the cache as long as their figures are the same.
    """
    (book / _THUMBNAILS).mkdir(exist_ok=True)
    cache.mkdir(parents=True, exist_ok=True)

    def save_small(picture: Picture) -> Path:
        made_of = picture.png + repr((_SIZE, PIL.__version__)).encode()
        kept = cache / f"{hashlib.sha256(made_of).hexdigest()}.png"
        if not kept.exists():
            replace_file(kept, _shrink(picture.png))
        shutil.copy(kept, book / _THUMBNAILS / f"{picture.name}.png")
        return kept

    with ThreadPoolExecutor() as pool:
        used = {*pool.map(save_small, pictures)}
    for old in {*cache.iterdir()} - used:
        old.unlink()
    (book / GALLERY).write_text(gallery_markdown(pictures), encoding="utf-8")


def _shrink(png: bytes) -> bytes:
    """Draw a picture small and in few colours, as PNG."""
    with Image.open(io.BytesIO(png)) as image:
        small = image.convert("RGB")
    small.thumbnail(_SIZE, Image.Resampling.LANCZOS, reducing_gap=2.0)
    file = io.BytesIO()
    few = small.quantize(64, dither=Image.Dither.NONE)
    few.save(file, format="png", optimize=True)
    return file.getvalue()


def gallery_markdown(pictures: Sequence[Picture]) -> str:
    """Write a card a figure, which leads to its chapter."""
    if not pictures:
        return "*No chapter draws a figure.*\n"
    cells = dict.fromkeys((one.chapter, one.cell) for one in pictures)
    numbers = {cell: number for number, cell in enumerate(cells, start=1)}
    cards = "\n".join(_card(one, numbers[one.chapter, one.cell]) for one in pictures)
    return f"::::{{grid}} 1 2 2 3\n:gutter: 3\n\n{cards}\n::::\n"


def _card(picture: Picture, number: int) -> str:
    """Write one card, with the number that Sphinx gives to the figure."""
    return (
        f":::{{grid-item-card}} {picture.title}\n"
        f":link: {_option(picture.chapter)}\n:link-type: doc\n"
        f":img-top: {_option(f'{_THUMBNAILS}/{picture.name}.png')}\n"
        f":img-alt: {_option(picture.alt or picture.title)}\n"
        ":class-card: msc-thumbnail\n"
        f"\nFigure {number} of this book\n"
        ":::\n"
    )


def _option(text: str) -> str:
    """Write text as the value of a directive's option, which is YAML."""
    return json.dumps(" ".join(text.split()), ensure_ascii=False)


def write_shown(runs: Iterable[Notebook], folder: Path) -> None:
    """Write what cells showed as HTML that first pages begin with, by their tags."""
    runs = list(runs)
    for tag, name in SHOWN.items():
        cells = [cell for run in runs for cell in code_cells(run) if tag in tags(cell)]
        if not cells:
            continue
        if len(cells) > 1:
            raise ValueError(
                f"{len(cells)} cells are tagged {tag!r}; wanted one at most"
            )
        if not (drawings := shown(cells[0], HTML)):
            line = source(cells[0]).strip().splitlines()[-1]
            raise ValueError(f"the cell tagged {tag!r} ({line}) shows no HTML")
        (folder / name).write_text(drawings[-1], encoding="utf-8")


# Where a figure comes from


def with_provenance(
    chapter: Chapter, pictures: Sequence[Picture], subject: Subject, address: str = ""
) -> Notebook:
    """Put a caption and a block under each figure; without figures, one at the end.

    With an address, where the repository's files are shown, a block leads to the
    notebook.
    """

    def cell(name: str, text: str) -> NotebookCell:
        return {"cell_type": "markdown", "id": name, "metadata": {}, "source": text}

    def block(picture: Picture | None) -> NotebookCell:
        told = _provenance(chapter, picture, subject, address)
        name = f"provenance-{picture.number if picture else 0}"
        return cell(name, fenced(told, "{raw} html"))

    cells = list(chapter.notebook["cells"])
    if not pictures:
        cells.append(block(None))
    for picture in reversed(pictures):
        after = picture.cell + 1
        if not any(source(one).startswith(BEGINNING) for one in cells[after:][:1]):
            words = paragraph(picture.alt.partition(". ")[0] or picture.title)
            text = f"{BEGINNING}\n{words.removesuffix('.')}.\n:::"
            cells.insert(after, cell(f"caption-{picture.number}", text))
        cells.insert(after + 1, block(picture))
    return chapter.notebook | {"cells": cells}


def _provenance(
    chapter: Chapter, picture: Picture | None, subject: Subject, address: str
) -> str:
    """Write in HTML where a figure, or without one the chapter, comes from."""
    name, record = chapter.name, chapter.record
    given = chapter.parameters
    declared = {k: one.default for k, one in parameters(chapter.notebook).items()}
    settings = ", ".join(
        _code(f"{key} = {value}")
        for key, value in (declared | {k: repr(v) for k, v in given.items()}).items()
    )
    modules = [file for file in record.files if file.endswith(".py")]
    inputs = [
        f"{_code(file)} {digest[:8]}"
        for file, digest in record.files.items()
        if file not in modules and PurePosixPath(file).suffix != ".js"
    ]
    together = hashlib.sha256("".join(record.files[m] for m in modules).encode())
    versions = [
        f"{'Python' if package == 'python' else package} "
        f"{html.escape(record.packages[package])}"
        for package in _TELLING
        if package in record.packages
    ]
    links = [
        (f"_sources/{name}.ipynb", "executed notebook"),
        (f"{DOWNLOADS}/{name}.ipynb", "source notebook"),
    ]
    if picture and picture.svg:
        links.insert(0, (f"{DOWNLOADS}/{picture.name}.svg", "figure as SVG"))
    of = f" of {subject.name}" if subject.name else ""
    made_by = _code(f"book/{name}.ipynb")
    if address:
        made_by = f'<a href="{address}/book/{quote(name)}.ipynb">{made_by}</a>'
    rows = {
        # Seconds differ from run to run: the page fetches them from `seconds.js`.
        "Made by": f'{made_by}<span data-seconds="{html.escape(name)}"></span>'
        + (f", {settings}" if settings else ""),
        "From": ", ".join(inputs),
        "Code": f"{len(modules)} modules{of}, {together.hexdigest()[:8]}"
        if modules
        else "",
        "With": ", ".join(versions),
        "Again": _code(f"{subject.program} {_remake(chapter)}"),
        "Take": ", ".join(
            f'<a href="{quote(address)}" download>{what}</a>' for address, what in links
        ),
    }
    what = "figure" if picture else "chapter"
    return (
        '<details class="msc-provenance">\n'
        f"<summary>How this {what} was made</summary>\n<dl>\n"
        + "\n".join(f"<dt>{key}</dt><dd>{row}</dd>" for key, row in rows.items() if row)
        + "\n</dl>\n</details>\n"
    )


def _remake(chapter: Chapter) -> str:
    """Say how a chapter is run alone; only parameters not as declared are named."""
    declared = parameters(chapter.notebook)
    options = "".join(
        f" -p {name} {shlex.quote(str(value))}"
        for name, value in chapter.parameters.items()
        if name not in declared or declared[name].default != repr(value)
    )
    notebook = f"{chapter.name}.ipynb"
    path, target = shlex.quote(f"book/{notebook}"), shlex.quote(notebook)
    return f"run {path}{options} --out {target}"


def seconds_script(chapters: Sequence[Chapter]) -> str:
    """Write the one file of the book that differs between two runs of the chapters.

    Its JavaScript puts each chapter's seconds where its pages want them.
    """
    seconds: dict[str, Any] = {c.name: round(c.record.seconds, 1) for c in chapters}
    return (
        f"const seconds = {json.dumps(seconds, indent=2)};\n"
        'for (const place of document.querySelectorAll("[data-seconds]")) {\n'
        "  place.textContent = ` in ${seconds[place.dataset.seconds]} s`;\n"
        "}\n"
    )


def _code(text: str) -> str:
    """Write text as code in HTML."""
    return f"<code>{html.escape(text)}</code>"


# The reference


def write_reference(
    root: Path, stage: Path, chapters: Sequence[Path], subject: Subject
) -> None:
    """Write what pages of the reference include, and lay out what they link to.

    What belongs to a page that the book lacks is left out.
    """
    book, folder = root / "book", stage / "book"
    for name in ("CHANGELOG.md", "CITATION.cff"):
        if (root / name).is_file():
            shutil.copy(root / name, stage)
    if (book / "parameters.md").is_file():
        tables = parameters_markdown(chapters)
        (folder / PARAMETERS).write_text(tables, encoding="utf-8")
    if (book / "commands.md").is_file():
        told = commands_markdown(subject.commands)
        (folder / COMMANDS_PAGE).write_text(told, encoding="utf-8")
    if (book / "equations.md").is_file():
        links = named_tests((book / "equations.md").read_text(encoding="utf-8"))
        (stage / "tests").mkdir(exist_ok=True)
        for file in dict.fromkeys(file for file, _ in links):
            shutil.copy(root / "tests" / f"{file}.py", stage / "tests")
        sources = sources_markdown(links, root, subject.name)
        (folder / TESTS).write_text(sources, encoding="utf-8")


def parameters_markdown(chapters: Sequence[Path]) -> str:
    """Write a table for each chapter with parameters, and name the others."""
    sections, others = [], []
    for path in chapters:
        notebook = read_notebook(path)
        link = f"[{label(title(notebook) or plain(path.stem))}]({path.stem})"
        if not (declared := parameters(notebook)):
            others.append(link)
            continue
        rows = [
            f"| {' | '.join((code(name), code(one.default), *_words(one)))} |"
            for name, one in declared.items()
        ]
        head = f"## {link}\n\n{code(f'book/{path.name}')}\n"
        table = ["| parameter | default | meaning | values |", "|---|---|---|---|"]
        sections.append("\n".join([head, *table, *rows]))
    if others:
        sections.append(f"Without parameters: {', '.join(others)}.")
    return "\n\n".join(sections) + "\n"


def _words(parameter: Parameter) -> tuple[str, str]:
    """Say what a parameter means and may be; what is quoted is code."""
    wanted = re.sub(
        r'("[^"]*")|[^\s"]+|"',
        lambda word: (code if word[1] else plain)(word[0]),
        parameter.wanted,
    )
    return plain(parameter.meaning) or "–", wanted


def commands_markdown(text: str) -> str:
    r"""Lay out what a command line tells: an overview, and a section a command.

    >>> told = "usage: arm [-h] COMMAND\n\nusage: arm move [-h]\n"
    >>> print(commands_markdown(told))
    ```text
    usage: arm [-h] COMMAND
    ```
    <BLANKLINE>
    ## arm move
    <BLANKLINE>
    ```text
    usage: arm move [-h]
    ```
    <BLANKLINE>
    """
    _, *parts = re.split(r"^(?=usage: )", text, flags=re.MULTILINE)
    heads = [re.match(r"usage: (.+?) \[-h\]", part) for part in parts]
    sections = [
        (f"## {head[1]}\n\n" if head and number else "") + fenced(part.strip(), "text")
        for number, (head, part) in enumerate(zip(heads, parts, strict=True))
    ]
    return "\n\n".join(sections) + "\n"


def named_tests(page: str) -> list[tuple[str, str]]:
    """List the tests that a page links to: file, without its ending, and name.

    >>> named_tests("[a spring](test_dmp.test_a), [again](test_dmp.test_a)")
    [('test_dmp', 'test_a')]
    """
    return list(dict.fromkeys(_TEST_LINK.findall(page)))


def sources_markdown(links: Sequence[tuple[str, str]], root: Path, package: str) -> str:
    """Show the source of tests, each under the anchor `file.name`, module by module."""
    sections = []
    for file in dict.fromkeys(file for file, _ in links):
        path = root / "tests" / f"{file}.py"
        sections.append(
            f"## {package}.{file.removeprefix('test_')}\n\n"
            f"{{download}}`tests/{file}.py <../tests/{file}.py>`"
        )
        for name in (name for other, name in links if other == file):
            block = fenced(_source(path, name), "python")
            words = name.removeprefix("test_").replace("_", " ")
            sections.append(f"({file}.{name})=\n### {words}\n\n{block}")
    return "\n\n".join(sections) + "\n"


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
