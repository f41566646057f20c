"""A report of chapters in JUnit's XML, which CI systems show: a test case a chapter.

A case has the seconds that its run took, be it of this build or one that still holds,
and what its cells printed. A chapter fails if a cell does, if it wrote to stderr or if
a claim in it does not hold (see `press.expect`).
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from press._chapters import Chapter, ChapterError
from press._files import replace_file
from press._notebook import Notebook, code_cells, complaints, shown, unmet

PLAIN = "text/plain"
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")
_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Case:
    """What is reported of a chapter."""

    name: str
    seconds: float
    out: str
    err: str = ""
    failure: str = ""  # in a sentence; empty if there is none
    traceback: str = ""


def write_report(
    chapters: Sequence[Chapter], failed: Sequence[ChapterError], file: Path
) -> None:
    """Write a report of chapters, whole or not at all."""
    cases = [_finished(one) for one in chapters] + [_failed(one) for one in failed]
    replace_file(file, report(sorted(cases, key=lambda case: case.name)))


def report(cases: Sequence[Case]) -> bytes:
    """Write cases as XML; characters that it cannot hold become a �, colours go."""
    total = {
        "tests": f"{len(cases)}",
        "failures": f"{sum(bool(case.failure) for case in cases)}",
        "errors": "0",
        "time": f"{sum(case.seconds for case in cases):.2f}",
    }
    top = ET.Element("testsuites", total)
    suite = ET.SubElement(top, "testsuite", {"name": "chapters", **total})
    for case in cases:
        named = {"classname": "book", "name": _legal(case.name)}
        test = ET.SubElement(suite, "testcase", named, time=f"{case.seconds:.2f}")
        if case.failure:
            told = ET.SubElement(test, "failure", message=_legal(case.failure))
            told.text = _legal(case.traceback or case.failure)
        for kind, text in {"system-out": case.out, "system-err": case.err}.items():
            if text:
                ET.SubElement(test, kind).text = _legal(text)
    ET.indent(top)
    whole: bytes = ET.tostring(top, encoding="utf-8", xml_declaration=True)
    return whole + b"\n"


def _legal(text: str) -> str:
    """Make of a text one that XML can hold."""
    return _NO_XML.sub("�", _COLOURS.sub("", text))


def _finished(chapter: Chapter) -> Case:
    """Report a chapter that came to its end."""
    run, seconds = chapter.notebook, chapter.record.seconds
    failure = "\n".join(filter(None, [*complaints(run), unmet(run)]))
    why = f"executed: {chapter.reasons}" if chapter.reasons else "kept: nothing changed"
    out = f"{why}\n{_printed(run)}"
    return Case(chapter.name, seconds, out, _streamed(run, "stderr"), failure)


def _failed(error: ChapterError) -> Case:
    """Report a chapter that did not."""
    run = error.run or {"cells": []}
    traceback = "\n".join(
        line
        for cell in code_cells(run)
        for output in cell["outputs"]
        for line in output.get("traceback", ())
    )
    out, err = _printed(run), _streamed(run, "stderr")
    return Case(error.name, error.seconds, out, err, error.words, traceback)


def _printed(run: Notebook) -> str:
    """Return what cells printed, then what they returned, as text."""
    returned = [f"{text}\n" for cell in code_cells(run) for text in shown(cell, PLAIN)]
    return _streamed(run, "stdout") + "".join(returned)


def _streamed(run: Notebook, name: str) -> str:
    """Return all that cells wrote to one stream."""
    return "".join(
        "".join(output["text"])
        for cell in code_cells(run)
        for output in cell["outputs"]
        if output.get("name") == name
    )
