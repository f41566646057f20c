"""What a card says, in plain sentences: what was found, and what of it to trust."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from msc.skills import list_breaks

Card = Mapping[str, Any]

FEW = 60  # different tasks: fewer make less than twenty blocks
_LARGE = 1.0  # spreads: a break of as much as the policies differ at all
_UNSEEN = (
    "A break over which policies move by less than {least:.2g} of their spreads would "
    "not have been seen: the tasks are so few that neighbours differ by much anyway. "
    "More tasks show smaller breaks."
)
_NAMED = 3  # breaks and methods that a sentence lists
_FLATTERED = 1.25  # times: a root mean square that is said to be smaller
_LEVEL = 0.9
_MEAN, _NEAREST = "mean policy", "nearest neighbour"


def share(error: float) -> str:
    """Write a squared error as its root, in percent of a column's spread.

    >>> share(0.0225), share(1.21), share(0.00010)
    ('15 %', '110 %', '1 %')
    """
    return percent(max(error, 0.0) ** 0.5)


def percent(value: float) -> str:
    """Write a share.

    >>> percent(0.12345), percent(0.012345), percent(0.9999)
    ('12 %', '1.2 %', '100 %')
    """
    return f"{100 * value:.0f} %" if value >= 0.0995 else f"{100 * value:.2g} %"


def errors_of(card: Card) -> dict[str, float]:
    """Return errors by method."""
    return {one["method"]: one["error"] for one in card["methods"]}


def quote(method: str) -> str:
    """Write the name of a method, which may have commas."""
    return f"“{method}”"


def unit_of(column: Mapping[str, Any]) -> str:
    """Write a column's unit after a number, if it has one."""
    return f" {column['unit']}" if column["unit"] not in (None, "1") else ""


def nothing_beats_the_mean(card: Card) -> bool:
    """Tell whether the mean policy is recommended."""
    return bool(card["chosen"] == _MEAN)


def tell_found(card: Card) -> str:
    """Say in a sentence what was found."""
    errors, chosen = errors_of(card), card["chosen"]
    others = [f"the mean policy is off by {share(errors[_MEAN])}"]
    if _NEAREST in errors and chosen != _NEAREST:
        others.append(f"the nearest row by {share(errors[_NEAREST])}")
    if nothing_beats_the_mean(card):
        return (
            f"{_tell_breaks(card)}, and of {len(errors)} methods none beats the mean "
            f"policy for certain: on tasks left out, {' and '.join(others)} of the "
            "policies' spread."
        )
    return (
        f"{_tell_breaks(card)}; of {len(errors)} methods, {quote(chosen)} is "
        f"recommended: on tasks left out it is off by {share(errors[chosen])} of the "
        f"policies' spread, where {' and '.join(others)}."
    )


def _tell_breaks(card: Card) -> str:
    """Say whether the policies break, and where."""
    jumps = card["jumps"]
    n_jumps, pieces = jumps["n_jumps"], jumps["pieces"]
    if not n_jumps:
        return "No break was found between neighbouring tasks"
    if len(card["tasks"]) == 1:
        places = f"{n_jumps} places" if n_jumps > 1 else "one place"
        return f"The policies break at {places} ({break_places(card)})"
    into = f", into {len(pieces):,} pieces" if len(pieces) > 1 else ""
    return (
        f"The policies break between {n_jumps:,} of {jumps['n_edges']:,} pairs of "
        f"neighbouring tasks{into}"
    )


def break_places(card: Card) -> str:
    """List the widest breaks along the one task column, in its order."""
    (task,), between = card["tasks"], list_breaks(card, _NAMED)
    listed = ", ".join(f"{low:.5g} and {high:.5g}" for low, high in between)
    n_more = card["jumps"]["n_jumps"] - len(between)
    more = f", and {n_more} more" if n_more else ""
    return f"{task['name']} between {listed}{unit_of(task)}{more}"


def tell_read(card: Card) -> list[str]:
    """Say what was read."""
    table = card["table"]
    told = [
        f"{table['n_rows']:,} rows, none with a number missing, of "
        f"{table['n_tasks']:,} different tasks; {_columns(card)}."
    ]
    if table["n_repeated_tasks"]:
        told.append(
            f"Replicates: {table['n_repeated_tasks']:,} tasks come more than once, in "
            f"{table['n_replicates']:,} rows; all are kept, and are left out together."
        )
    return told + [f"Of the file: {note}." for note in table["notes"]]


def _columns(card: Card) -> str:
    """Count columns."""
    counted = [(len(card["tasks"]), "task"), (len(card["policies"]), "policy")]
    return " and ".join(f"{n} {what} column{'s' * (n > 1)}" for n, what in counted)


def tell_trust(card: Card) -> list[str]:
    """Say what to trust, and what not."""
    told = [
        _tell_worth(card),
        *_tell_ties(card),
        _tell_range(card),
        *_tell_beside(card),
        *_tell_few(card),
        *_tell_alone(card),
        _tell_bands(card),
        *_tell_conformal(card),
    ]
    told += [
        f"{quote(name)} could not be fitted: {why}."
        for name, why in card["failed"].items()
    ]
    told += [f"Told while fitting: {words}" for words in card["warnings"]]
    return [*told, "All errors are of policies: what these do was not measured."]


def _tell_worth(card: Card) -> str:
    """Say what the recommendation is worth where it was made anew."""
    choosing = card["error_of_choosing"]
    picks = Counter(choosing["chosen_without_fold"])
    often, other = picks[card["chosen"]], len(choosing["chosen_without_fold"])
    told = (
        "Chosen anew without the blocks that it is measured on, "
        f"{quote(card['chosen'])} was taken {often} of {other} times, and the choice "
        f"was off by {share(choosing['error'])}: that is the figure for new tasks of "
        "this range"
    )
    if not choosing["nested"]:
        told += " (rows being many, what was compared had learned from the blocks)"
    if nothing_beats_the_mean(card):
        return f"{told}. From this table no policy can be told by its task for certain."
    surely = choosing["below_mean_low"] > 0
    return told + (
        ", for certain less than the mean policy."
        if surely
        else ", which may be no better than the mean policy: take more tasks."
    )


def _tell_ties(card: Card) -> list[str]:
    """Name methods that are not told apart from the best."""
    tied = [
        quote(one["method"])
        for one in card["methods"]
        if one["above_best_low"] <= 0 and one["method"] != card["chosen"]
    ]
    if not tied:
        return []
    return [
        f"Not told apart from the best for certain: {_list(tied)}. Of such "
        f"{quote(card['chosen'])} was taken as the simplest; another table may turn "
        "the order."
    ]


def _tell_range(card: Card) -> str:
    """Say where predictions are extrapolated."""
    ranges, told = [], []
    for task in card["tasks"]:
        name, low, high = task["name"], task["lowest"], task["highest"]
        if task["period"] is None:
            ranges.append(f"{name} {low:.5g} to {high:.5g}{unit_of(task)}")
        else:
            told.append(
                f"{name} comes round again after {task['period']:g}, and only a gap of "
                "more than a quarter of that is outside"
            )
    if ranges:
        told.insert(
            0,
            f"Trust nothing outside the range of the rows ({', '.join(ranges)}); msc "
            "predict names such columns under 'outside'",
        )
    return f"{'; '.join(told)}."


def _tell_beside(card: Card) -> list[str]:
    """Say that beside a break a prediction may be of its other side."""
    least = card["jumps"]["least_jump"]
    if not card["jumps"]["n_jumps"]:
        return [_UNSEEN.format(least=least)] * (least > _LARGE)
    where = f" ({break_places(card)})" if len(card["tasks"]) == 1 else ""
    return [
        f"Beside a break{where} a prediction may belong to its other side: where in "
        "the gap it lies, no row tells. Search such tasks anew, or try both sides."
    ]


def _tell_few(card: Card) -> list[str]:
    """Say if there are few tasks, and whether more would help."""
    table, chosen, told = card["table"], quote(card["chosen"]), []
    (one,) = (one for one in card["methods"] if one["method"] == card["chosen"])
    interval = f"{share(one['low'])} to {share(one['high'])}"
    if table["n_tasks"] < FEW:
        told.append(
            f"{table['n_tasks']} different tasks are few: the error of {chosen} rests "
            f"on {card['blocks']['n_blocks']} blocks, and may be anything from "
            f"{interval}."
        )
    else:
        told.append(
            f"The error of {chosen} rests on {card['blocks']['n_blocks']} "
            f"blocks; its 95 % interval is {interval}."
        )
    curve = [one for one in card["curve"] if one["method"] == card["chosen"]]
    for before, after in [*pairwise(curve)][-1:]:
        falls = (
            "still fell" if after["error"] < 0.9 * before["error"] else "hardly fell"
        )
        told.append(
            f"Of {table['n_rows']:,} rows {chosen} learned {card['max_tasks']}, spread "
            f"over all: from {before['n_tasks']} to {after['n_tasks']} its error "
            f"{falls}, from {share(before['error'])} to {share(after['error'])}."
        )
    return told


def _tell_alone(card: Card) -> list[str]:
    """Compare blocks left out with single rows left out."""
    single = card["held_out"]["single_rows_error"]
    if single is None:
        return []
    error = errors_of(card)[card["chosen"]]
    told = (
        f"Errors are of whole blocks of neighbouring tasks left out: {share(error)}. "
        f"With single rows left out it would be {share(single)}"
    )
    flatters = error > _FLATTERED**2 * single
    return [
        told
        + (
            ", which flatters: neighbours and replicates give the answer away. Between "
            "rows that lie close, though, it is what to expect."
            if flatters
            else ": rows are not so close together that it matters."
        )
    ]


def _tell_bands(card: Card) -> str:
    """Say whether bands hold what they say."""
    bands, chosen = card["held_out"]["bands"], quote(card["chosen"])
    told = next((one for one in bands if one["level"] == _LEVEL), None)
    if told is None:
        return (
            f"{chosen} does not know how sure it is: its predictions have no standard "
            "deviations; those of paper.skops have."
        )
    verdict = "as they should"
    if told["high"] < _LEVEL:
        verdict = "they are too narrow, do not rely on them"
    elif told["low"] > _LEVEL:
        verdict = "they are wider than need be"
    return (
        f"Bands that should hold {percent(_LEVEL)} held {percent(told['held'])} of the "
        f"policies left out ({percent(told['low'])} to {percent(told['high'])}): "
        f"{verdict}."
    )


def _tell_conformal(card: Card) -> list[str]:
    """Say what the bands and flags of `msc predict` are worth, if they are known."""
    band, flag = card["held_out"]["conformal"], card["held_out"]["flag"]
    if band is None:
        return []
    low, high = percent(band["low"]), percent(band["high"])
    verdict = "no fewer than they should"
    if band["high"] < _LEVEL:
        verdict = "do not rely on them where rows are so far off"
    return [
        f"The bands of msc predict (columns …_band90) hold {percent(_LEVEL)} of the "
        "policies of tasks that lie among the rows as these do: they are made of the "
        "errors of tasks left out alone. In whole blocks left out, which is harder, "
        f"they held {percent(band['held'])} ({low} to {high}): {verdict}.",
        "Where the five nearest tasks have policies far apart, msc predict calls a "
        f"task doubtful. Of {flag['n_blocks']} blocks left out {flag['n_flagged']} "
        f"were; of the {flag['n_worst']} with the largest errors {flag['n_caught']}, "
        + (
            "for certain more than by chance: search such tasks anew."
            if flag["is_sure"]
            else "which may be chance: do not rely on it."
        ),
    ]


def _list(words: Sequence[str]) -> str:
    """List words, of many the first."""
    more = f" and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    return ", ".join(words[:_NAMED]) + more
