"""Text as Markdown: what is data is shown as it is, and means nothing more.

The book's own Markdown knows no HTML (`_config.yml`), so that a tag in it is text.
"""

import re

_MARKUP = re.compile(r"[\\`*_{}<>|$&]|\](?=[(\[:{])|(?<=\[)\^")
_OPENING = re.compile(r"^(\d*)([!-/:-@~])")
_BRACKET = re.compile(r"\\.|(`+).*?\1|([\[\]])")


def plain(text: str) -> str:
    r"""Write text so that Markdown shows it as it is, on one line.

    Parameters
    ----------
    text : str
        Any text; white space in it counts as one blank.

    Returns
    -------
    str
        Markdown, to stand within a line or a table's cell.

    Examples
    --------
    >>> print(plain("a <b> | *c* [0.4, 0.6]"))
    a \<b\> \| \*c\* [0.4, 0.6]
    """
    return _MARKUP.sub(r"\\\g<0>", " ".join(text.split()))


def paragraph(text: str) -> str:
    r"""Write text so that it is a paragraph, and no list, heading or rule.

    Parameters
    ----------
    text : str
        Any text; white space in it counts as one blank.

    Returns
    -------
    str
        Markdown, to stand at the beginning of a line.

    Examples
    --------
    >>> print(paragraph("1. No list"), paragraph("# No heading"), sep=" ")
    1\. No list \# No heading
    """
    return _OPENING.sub(r"\1\\\2", plain(text))


def label(markdown: str) -> str:
    r"""Keep the brackets in a line of Markdown from ending the link that it names.

    Parameters
    ----------
    markdown : str
        A line, such as a heading or what `plain` returned.

    Returns
    -------
    str
        Markdown, to stand between the brackets of a link.

    Examples
    --------
    >>> print(label("a] *b* `c[0]`"))
    a\] *b* `c[0]`
    """
    return _BRACKET.sub(lambda m: f"\\{m[2]}" if m[2] else m[0], markdown)


def code(text: str) -> str:
    r"""Write text as code, within a line or a table's cell.

    >>> print(code("None | `x`"))
    `` None \| `x` ``
    """
    line = " ".join(text.split()).replace("|", r"\|")
    ticks = "`" * (_longest_run(line) + 1)
    space = " " if "`" in line[:1] + line[-1:] else ""
    return f"{ticks}{space}{line}{space}{ticks}"


def fenced(text: str, kind: str) -> str:
    r"""Write lines as a block of a language, whatever fences they hold themselves.

    >>> print(fenced("a = '```'", "python"))
    ````python
    a = '```'
    ````
    """
    ticks = "`" * max(3, _longest_run(text) + 1)
    return f"{ticks}{kind}\n{text}\n{ticks}"


def _longest_run(text: str) -> int:
    return max(map(len, re.findall("`+", text)), default=0)
