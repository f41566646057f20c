"""What was read, found and measured, in sentences."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from msc.estimates import Estimate
from msc.skills._methods import METHODS
from msc.skills._table import Table

_NAMED = 5  # columns, jumps, sizes that a sentence lists
_CLOSED = 0.9  # of a turn: degrees or radians that span more may come round again
_TURNS = {"deg": 360.0, "rad": 2 * np.pi, "turn": 1.0}


def tell_table(table: Table) -> list[str]:
    r"""Say what was read.

    Parameters
    ----------
    table : Table
        The table.

    Returns
    -------
    list of str
        Sentences, a line each.

    Examples
    --------
    >>> import pandas as pd
    >>> from msc.skills import Table
    >>> angles = pd.DataFrame({"angle": [0.0, 90.0, 90.0]})
    >>> table = Table(angles, pd.DataFrame({"push": [1.0, 2.0, 3.0]}), name="a.csv")
    >>> print(*tell_table(table), sep="\n")
    a.csv: 3 rows, none with a number missing, of 2 different tasks
    task angle: 0 to 90
    policy push: 1 to 3
    1 task comes more than once, in 2 rows: all are kept
    """
    times = np.bincount(table.copies)
    notes = "".join(f"; {note}" for note in table.notes)
    lines = [
        f"{table.name}: {len(table.tasks):,} rows, none with a number missing, of "
        f"{len(times):,} different tasks{notes}"
    ]
    for what, frame in (("task", table.tasks), ("policy", table.policies)):
        for name, column in [*frame.items()][:_NAMED]:
            unit = table.units.get(str(name))
            period = table.periods.get(str(name))
            lines.append(
                f"{what} {name}: {column.min():.6g} to {column.max():.6g}"
                + (f" {unit}" if unit else "")
                + (f", again from {period:g} on" if period else "")
                + _hint(table, str(name), float(np.ptp(column)))
            )
        if frame.shape[1] > _NAMED:
            lines.append(f"and {frame.shape[1] - _NAMED} {what} columns more")
    if (times > 1).any():
        n_tasks = int((times > 1).sum())
        comes = "task comes" if n_tasks == 1 else "tasks come"
        lines.append(
            f"{n_tasks:,} {comes} more than once, in {times[times > 1].sum():,} rows: "
            "all are kept"
        )
    return lines


def _hint(table: Table, name: str, span: float) -> str:
    """Ask whether an angle that goes all round comes round again."""
    turn = _TURNS.get(table.units.get(name, ""), np.inf)
    if name not in table.tasks or name in table.periods or not span > _CLOSED * turn:
        return ""
    return f" (if it comes round again: --period {name}={turn:.17g})"


def tell_fit(card: Mapping[str, Any]) -> list[str]:
    """Say what was found and measured.

    Parameters
    ----------
    card : mapping
        Of a `Fit`.

    Returns
    -------
    list of str
        Sentences, a line each, and a line a method.
    """
    jumps, charts, chosen = card["jumps"], card["charts"], card["chosen"]
    n_jumps = jumps["n_jumps"]
    found = "no jump" if not n_jumps else f"{n_jumps} jump{'s' * (n_jumps > 1)}"
    pieces = jumps["pieces"]
    lines = [
        f"{found} between neighbours among {jumps['n_tasks']:,} tasks"
        + (f"; between {_list(pieces)} tasks" if len(pieces) > 1 else "")
    ]
    if not n_jumps:
        lines[0] += f" (one of less than {jumps['least_jump']:.2g} spreads is not seen)"
    elif len(card["tasks"]) == 1:
        between = list_breaks(card, _NAMED)
        places = [f"{low:.6g} and {high:.6g}" for low, high in between]
        lines[0] += f": {card['tasks'][0]['name']} between {'; '.join(places)}"
    lines.append(
        f"{charts['n_charts']} charts by SMCE and the elbow, of "
        f"{_list(charts['sizes'])} policies"
    )
    lines += [f"  {words}" for words in card["warnings"]]
    if card["curve"]:
        lines.append(
            f"all but the mean, neighbours and trees learn from {card['max_tasks']} "
            "tasks, spread over all"
        )
    lines.append(
        "error of policies (squared, a column's spread is 1) in "
        f"{card['blocks']['n_blocks']} blocks of neighbouring tasks left out:"
    )
    width = max(map(len, METHODS))
    lines += [
        f"  {one['method']:{width}}  {Estimate.read(one, 'error')}"
        for one in card["methods"]
    ]
    lines += [
        f"  {name:{width}}  failed: {why}" for name, why in card["failed"].items()
    ]
    choosing = card["error_of_choosing"]
    error = Estimate.read(choosing, "error")
    lines.append(f"chosen anew without the blocks it is measured on: {error}")
    lines += _tell_doubt(card["held_out"])
    if chosen == next(iter(METHODS)):
        lines.append("nothing beats the mean policy for certain: it is recommended")
    else:
        beats = "and beats" if choosing["below_mean_low"] > 0 else "and may not beat"
        lines.append(
            f"recommended: {chosen}, the simplest of those as good as the best, "
            f"{beats} the mean policy where it was chosen anew"
        )
    return lines


def _tell_doubt(held_out: Mapping[str, Any]) -> list[str]:
    """Say what bands and flags of predictions are worth, if they are known."""
    band, flag = held_out["conformal"], held_out["flag"]
    if band is None:
        return []
    return [
        f"bands of 90 % held {band['held']:.0%} in blocks left out; doubtful were "
        f"{flag['n_flagged']} of {flag['n_blocks']} blocks, and of the worst tenth "
        f"{flag['n_caught']} of {flag['n_worst']}"
    ]


def list_breaks(card: Mapping[str, Any], most: int) -> list[tuple[float, float]]:
    """List the widest jumps along the one task column.

    Parameters
    ----------
    card : mapping
        Of a `Fit` to a table with one task column.
    most : int
        How many at most.

    Returns
    -------
    list of tuple of float
        In their order, the tasks on either side; on a circle the second may be the
        lower number, where it was cut between them.

    Examples
    --------
    >>> widest = [[[150.2], [149.9]], [[3.0], [358.0]]]
    >>> card = {"tasks": [{"period": 360.0}], "jumps": {"widest_jumps": widest}}
    >>> list_breaks(card, 5)
    [(149.9, 150.2), (358.0, 3.0)]
    """
    period = card["tasks"][0]["period"] or np.inf
    found = []
    for (one,), (other,) in card["jumps"]["widest_jumps"][:most]:
        low, high = sorted((one, other))
        found.append((low, high) if high - low <= period / 2 else (high, low))
    return sorted(found)


def _list(sizes: Iterable[int]) -> str:
    """List numbers, if there are many the first."""
    listed = [f"{size:,}" for size in sizes]
    shown = ", ".join(listed[:_NAMED])
    return shown if len(listed) <= _NAMED else f"{shown} … ({len(listed)} in all)"
