"""The page: sentences, tables and pictures, as a file of HTML that needs no other."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from msc.estimates import Estimate
from msc.plots import slide_policies
from msc.report._pictures import (
    MOST_POLICIES,
    MOST_TASKS,
    Picture,
    Scene,
    draw_charts,
    draw_comparison,
    draw_policies,
    walk_along,
)
from msc.report._words import Card, quote, share, tell_found, tell_read, tell_trust
from msc.skills import Fit, Table

_STYLE = Path(__file__).with_name("report.css")
_CLOSED = (  # nothing is loaded, whatever the page says
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'"
)


def make_report(table: Table, fit: Fit) -> str:
    """Tell of a fit in one page.

    Parameters
    ----------
    table : Table
        What was read.
    fit : Fit
        What `msc.skills.fit_table` made of it.

    Returns
    -------
    str
        A document of HTML that loads nothing. It begins with what was found, and shows
        policies over tasks, a slider along the first task column, charts, and methods
        compared; it ends in what to trust, and how it was made.

    Examples
    --------
    >>> import numpy as np, pandas as pd
    >>> from msc.skills import fit_table
    >>> angle = np.arange(0.0, 300.0, 10.0)
    >>> push = pd.DataFrame({"<push>": np.cos(np.radians(angle))})
    >>> table = Table(pd.DataFrame({"angle": angle}), push, name="made.csv")
    >>> page = make_report(table, fit_table(table, methods=["nearest neighbour"]))
    >>> "<h1>made.csv</h1>" in page, "<push>" in page
    (True, False)
    """
    name = escape(fit.card["table"]["name"])
    with threadpool_limits(1), warnings.catch_warnings():
        # Names may have letters that no font here has.
        warnings.filterwarnings("ignore", "Glyph", UserWarning)
        body = "\n".join(_tell(Scene(table, fit)))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_CLOSED}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{name}: what was learned</title>\n"
        f"<style>\n{_STYLE.read_text(encoding='utf-8')}</style>\n</head>\n"
        f"<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _tell(scene: Scene) -> Iterator[str]:
    """Give the parts of the page."""
    card = scene.card
    yield f"<h1>{escape(card['table']['name'])}</h1>"
    yield f'<p class="lead">{_text(tell_found(card))}</p>'
    yield "<h2>What was read</h2>"
    yield from map(_paragraph, tell_read(card))
    yield _columns_table(card)
    yield "<h2>Policies over tasks</h2>"
    yield from map(_paragraph, _tell_shown(scene))
    yield _figures(draw_policies(scene))
    yield f"<h2>Along {escape(scene.tasks[0])}</h2>"
    yield _paragraph(_tell_walk(scene))
    yield slide_policies(walk_along(scene)).to_html()
    yield "<h2>Charts</h2>"
    yield _paragraph(_tell_charts(card))
    yield _figures(draw_charts(scene))
    yield "<h2>Methods compared</h2>"
    yield _paragraph(_tell_errors(card))
    yield _figures(draw_comparison(card))
    yield _errors_table(card)
    yield "<h2>What to trust, and what not</h2>"
    yield f"<ul>{''.join(f'<li>{_text(one)}</li>' for one in tell_trust(card))}</ul>"
    yield "<h2>How it was made</h2>"
    yield from _made(card)


def _paragraph(words: str) -> str:
    return f"<p>{_text(words)}</p>"


def _text(words: str) -> str:
    """Write a sentence, in which numbers and their percent signs stay together."""
    return escape(words).replace(" %", "&nbsp;%")


def _figures(pictures: Iterable[Picture]) -> str:
    """Lay pictures out side by side, as many as there is room for."""
    images = "\n".join(
        f'<img alt="{escape(one.alt)}" src="data:image/png;base64,{one.to_png()}">'
        for one in pictures
    )
    return f'<div class="figures">\n{images}\n</div>'


def _table(
    head: Sequence[str], rows: Iterable[Sequence[str]], chosen: str | None = None
) -> str:
    """Write a table whose first cells name rows; one of these may stand out."""
    lines = []
    for first, *cells in rows:
        look = ' class="chosen"' if first == chosen else ""
        told = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        lines.append(f'<tr{look}><th scope="row">{escape(first)}</th>{told}</tr>')
    names = "".join(f'<th scope="col">{escape(one)}</th>' for one in head)
    rest = "\n".join(lines)
    return (
        f'<div class="wide" tabindex="0"><table>\n<thead><tr>{names}</tr></thead>\n'
        f"<tbody>\n{rest}\n</tbody>\n</table></div>"
    )


def _columns_table(card: Card) -> str:
    """List columns with their units, ranges and periods."""
    rows = [
        (
            column["name"],
            what,
            column["unit"] or "not told",
            f"{column['lowest']:.6g}",
            f"{column['highest']:.6g}",
            f"{column['spread']:.4g}",
            "no" if column["period"] is None else f"after {column['period']:g}",
        )
        for what, key in (("task", "tasks"), ("policy", "policies"))
        for column in card[key]
    ]
    head = "column", "is", "unit", "lowest", "highest", "spread", "comes round again"
    return _table(head, rows)


def _errors_table(card: Card) -> str:
    """List the errors of all methods."""
    rows = [
        (one["method"], str(Estimate.read(one, "error")), share(one["error"]))
        for one in card["methods"]
    ]
    head = "method", "error, 95 % interval", "off by, of the spread"
    return _table(head, rows, card["chosen"])


def _tell_shown(scene: Scene) -> list[str]:
    """Say what pictures show, and what they leave out."""
    n_rows, n_tasks = len(scene.X), len(scene.tasks)
    if n_tasks == 1:
        told = ["Each point is a row, in the colour and with the mark of its chart."]
        told[0] += " The line is what the recommended skill predicts"
        bands = scene.fit.skill.has_std
        told[0] += ", grey two standard deviations to either side." if bands else "."
    else:
        told = ["Maps of two task columns: a point is a row, coloured by its chart, or"]
        told[0] += " by a policy column, the lighter the more."
    if len(scene.shown) < n_rows:
        told.append(
            f"Pictures show {len(scene.shown):,} of {n_rows:,} rows, spread over all "
            f"and drawn by seed {scene.card['seed']}: those that charts were found of."
        )
    drawn = min(n_tasks, MOST_TASKS)
    counted = (
        (drawn, n_tasks, "task"),
        (MOST_POLICIES[drawn], len(scene.policies), "policy"),
    )
    told += [
        f"Of {n} {what} columns, the first {most} are shown."
        if most > 1
        else f"Of {n} {what} columns, the first is shown."
        for most, n, what in counted
        if most < n
    ]
    return told


def _tell_walk(scene: Scene) -> str:
    """Say what the slider does."""
    told = f"Move along {scene.tasks[0]}: "
    others = [
        f"{name} {value:.4g}"
        for name, value in zip(scene.tasks[1:], scene.line(1)[0, 1:], strict=True)
    ]
    if others:
        told += f"the others stay at their medians ({', '.join(others)}); "
    bar = ", the bar two standard deviations to either side"
    return (
        f"{told}the dot is the policy predicted by {quote(scene.card['chosen'])}"
        f"{bar if scene.fit.skill.has_std else ''}; rings are the nearest rows known."
    )


def _tell_charts(card: Card) -> str:
    """Say how many charts there are, and of what."""
    found = card["charts"]
    n_charts, sizes = found["n_charts"], ", ".join(map(str, found["sizes"]))
    one = "one chart" if n_charts == 1 else f"{n_charts} charts"
    return (
        f"Policies that reconstruct each other are joined (SMCE); the graph of "
        f"{found['n_tasks']:,} policies was cut where the elbow is, into {one} of "
        f"{sizes} policies."
    )


def _tell_errors(card: Card) -> str:
    """Say what an error is."""
    blocks = card["blocks"]
    return (
        f"Tasks were parted into {blocks['n_blocks']} blocks of neighbours, and these "
        f"dealt into {blocks['n_folds']} folds; a method predicts each fold from the "
        "others. Its error is the mean square of what it missed, with each policy "
        "column's spread for a unit: the mean of all policies would have about 1. Of "
        "those not surely worse than the best, the simplest is recommended, which is "
        "the uppermost."
    )


def _made(card: Card) -> list[str]:
    """Say how to make it again, and of what."""
    versions = ", ".join(f"{name} {one}" for name, one in card["versions"].items())
    rows: list[tuple[str, Any]] = [
        ("seed", card["seed"]),
        ("profile", card["profile"]),
        ("versions", versions),
        ("SHA-256 of the table", card["table"]["sha256"]),
    ]
    parts = [f"<p>{what}: {escape(str(told))}</p>" for what, told in rows if told != ""]
    if card["command"]:
        parts.insert(0, f"<pre>{escape(card['command'])}</pre>")
    return parts
