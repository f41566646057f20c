"""Verdicts as Markdown: the table that opens the book, and every reading of a claim."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from msc.claims._elsewhere import Counts, write_counts
from msc.claims._judge import BUILT_IN, SYMBOLS, VERDICTS, Verdict
from press import label, plain

TABLE = "claims_table.md"
SECTIONS = "claims_readings.md"

Elsewhere = Mapping[str, Counts]  # by claim

# Between these the README quotes the verdicts.
BEGIN, END = "<!-- verdicts, by msc claims -->", "<!-- end of verdicts -->"


def claim_fragments(
    verdicts: Sequence[Verdict],
    pages: Mapping[str, str],
    elsewhere: Elsewhere | None = None,
) -> dict[str, str]:
    """Write what pages of the book include: the table, and all readings.

    Parameters
    ----------
    verdicts : sequence of Verdict
        What `msc.claims.judge_all` returned; none before there are any.
    pages : mapping of str to str
        Titles of the book's pages by their names; only these are linked to.
    elsewhere : mapping, optional
        What `msc.claims.count_elsewhere` returned; by default no other worlds are told
        of.

    Returns
    -------
    dict of str to str
        Markdown, by the name of the file to include: without verdicts, a sentence that
        says so.
    """
    if not verdicts:
        none = f"*No verdicts yet: `msc claims --out {VERDICTS}`.*\n"
        return {TABLE: none, SECTIONS: none}
    return {
        TABLE: table_markdown(verdicts, pages, elsewhere or {}),
        SECTIONS: sections_markdown(verdicts, pages, elsewhere or {}),
    }


def table_markdown(
    verdicts: Sequence[Verdict], pages: Mapping[str, str], elsewhere: Elsewhere
) -> str:
    """Write the table that opens the book: links to chapters and to sections."""
    heads = ["the paper claims", "here", "measured"]
    heads += ["in other worlds"] if elsewhere else []
    widths = "5 2 4 2" if elsewhere else "5 2 4"  # in shares of the page
    rows = ["```{table}", f":widths: {widths}", _row(*heads), "|---" * len(heads) + "|"]
    for one in verdicts:
        claim, says = one.claim, plain(one.claim.claim)
        shown = f"[{label(says)}]({claim.chapter})" if claim.chapter in pages else says
        here = f"[{one.words}](claim-{claim.id})"
        more = f"; [other readings differ](claim-{claim.id})" if one.differs else ""
        more += "; could hardly fail" if claim.hardly_fails else ""
        cells = [shown, here, f"{plain(one.measured)}{more}"]
        if elsewhere:
            counts = elsewhere.get(claim.id)
            cells.append(write_counts(counts["worlds"]) if counts else "not asked")
        rows.append(_row(*cells))
    return "\n".join([*rows, "```"]) + "\n"


def tally(summary: Mapping[str, Mapping[str, Any]]) -> str:
    """Count the verdicts, in words.

    Parameters
    ----------
    summary : mapping
        What `msc.claims.summarise` returned.

    Returns
    -------
    str
        The verdicts that occur, in the order of `SYMBOLS`, on claims that could fail.

    Examples
    --------
    >>> a, b = {"verdict": "partly"}, {"verdict": "reproduced"}
    >>> tally({"a": a | {"could_fail": True}, "b": b | {"could_fail": True}})
    '1 reproduced, 1 partly'
    """
    counts = Counter(one["verdict"] for one in summary.values() if one["could_fail"])
    return ", ".join(f"{counts[name]} {name}" for name in SYMBOLS if counts[name])


def sections_markdown(
    verdicts: Sequence[Verdict], pages: Mapping[str, str], elsewhere: Elsewhere
) -> str:
    """Write a section a chapter, in the order of the book, and in it a fold a claim."""
    chapters = {one.claim.chapter for one in verdicts}
    known = [name for name in pages if name in chapters]
    sections = []
    for name in [*known, *sorted(chapters - {*known})]:
        own = [one for one in verdicts if one.claim.chapter == name]
        head = f"### {pages.get(name, plain(name))}"
        folds = [_fold(one, elsewhere.get(one.claim.id)) for one in own]
        shown = [f"[The chapter]({name}) shows it."] if name in pages else []
        sections += [head, *shown, *folds]
    return "\n\n".join(sections) + "\n"


def summary_markdown(summary: Mapping[str, Mapping[str, Any]]) -> str:
    """Write which claims got which verdict, a row each that occurs."""
    rows = [_row("verdict", "claims", "which"), "|---|---|---|"]
    for could_fail, (verdict, sign) in product((True, False), SYMBOLS.items()):
        wanted = {"verdict": verdict, "could_fail": could_fail}.items()
        ids = [name for name, one in summary.items() if wanted <= one.items()]
        if ids:
            note = "" if could_fail else ", could hardly fail"
            rows.append(_row(f"{sign} {verdict}{note}", str(len(ids)), ", ".join(ids)))
    return "\n".join(rows) + "\n"


def with_summary(page: str, summary: Mapping[str, Mapping[str, Any]]) -> str:
    """Renew the summary that a page quotes.

    Parameters
    ----------
    page : str
        Markdown with the marks `BEGIN` and `END`.
    summary : mapping
        What `msc.claims.summarise` returned.

    Returns
    -------
    str
        The page; what stands between the marks is new.

    Raises
    ------
    ValueError
        If there are no such marks.
    """
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"page: no lines {BEGIN} and {END} to write between")
    table = summary_markdown(summary)
    return f"{before}{BEGIN}\n\n{table}\n{END}{after}"


def _fold(one: Verdict, counts: Counts | None) -> str:
    """Write a claim: its sentence and verdict in a line, and what is folded below."""
    claim = one.claim
    built_in = [
        asked.by_construction
        for asked, found in zip(claim.interpretations, one.findings, strict=True)
        if found.verdict == BUILT_IN
    ]
    rows = [_row("reading", "measured", "wanted", "verdict"), "|---|---|---|---|"]
    for found in one.findings:
        name, *cells = map(
            plain, (found.name, found.measured, found.wanted or "–", found.verdict)
        )
        rows.append(_row(f"**{name}**" if found in one.literal else name, *cells))
    paragraphs = [
        f"> “{plain(claim.quote)}” {{cite}}`paper` ({plain(claim.section)})",
        "\n".join(rows),
        f"**Margin.** {plain(claim.margin)}" if claim.margin else "",
        f"**Could hardly fail.** {plain(claim.hardly_fails)}"
        if claim.hardly_fails
        else "",
        *(f"**By construction.** {plain(reason)}" for reason in built_in),
        f"**Why.** {plain(one.why)}" if one.why else "",
        f"**Elsewhere.** In other worlds {write_counts(counts['worlds'])}; with one "
        f"choice of ours changed {write_counts(counts['assumptions'])}."
        if counts
        else "",
    ]
    told = "\n\n".join(paragraph for paragraph in paragraphs if paragraph)
    head = f":::{{dropdown}} {plain(claim.claim)} **{one.words}**"
    return f"{head}\n:name: claim-{claim.id}\n\n{told}\n:::"


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
