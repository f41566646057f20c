"""Many worlds at a glance: claim × world, where charts pay, and maps of an annulus.

A `Matrix` shows itself as an HTML table whose cells lead to the worlds' pages; what it
is made of are the verdicts of `msc.worlds.judge_worlds`.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import ArrayLike, NDArray

from msc.data import Dataset
from msc.estimates import Estimate, rounded
from msc.plots._sheets import draw_labels, draw_plan, world_address
from msc.plots._style import (
    METHOD_STYLES,
    SMALL,
    TRIO,
    chart_colour,
    chart_marker,
    styled,
)
from msc.robot import Workspace
from msc.worlds import Question

ANSWER_SIGNS = {"holds": "●", "fails": "✕", "cannot tell": "○", "not asked": ""}
_LOOKS: dict[str, dict[str, Any]] = {
    "holds": {"marker": "o", "mfc": "0.2", "mec": "0.2"},
    "fails": {"marker": "X", "mfc": "0.2", "mec": "0.2"},
    "cannot tell": {"marker": "o", "mfc": "white", "mec": "0.2"},
}
FAMILY_WORDS = {
    "layout": "layouts of obstacles",
    "arm": "arms, no obstacles",
    "annulus": "goals in an annulus",
    "priced": "a price on contact",
    "mujoco": "MuJoCo",
    "height": "a moving obstacle",
    "turn": "a turning home",
}
QUESTION_WORDS = {
    "broken": "broken at least once",
    "broken-thrice": "broken three times",
    "continuous": "not broken",
    "mse": "MSE: one regression",
    "mse-known": "MSE: … right chart known",
    "mse-one-kernel": "MSE: … one kernel for both",
    "crkr": "MSE: CrKr",
    "every-size": "MSE: both, at every size",
    "executed": "cm: one regression",
    "executed-spread": "cm: … the spread",
    "executed-one-kernel": "cm: … one kernel for both",
    "as-good-as-search": "cost: as searched",
    "more-charts": "MSE: one chart",
    "too-many-charts": "MSE: eight charts",
    "beats-nearest": "cm: nearest task",
    "beats-interpolation": "cm: interpolation",
}
"""By what and against whom charts are asked, in a few words."""
_TOLD = "holds", "fails", "cannot tell"
_STEPS = 0.5, 0.8, 1.25, 2.0
_LEANINGS = (  # sides, and how far
    ("for", 2, "half the error or less"),
    ("for", 1, "below 0.8"),
    ("against", 1, "above 1.25"),
    ("against", 2, "twice the error or more"),
)

Array = NDArray[np.float64]
Verdicts = Mapping[str, Any]


@dataclass(frozen=True)
class Matrix:
    """Answers at a glance: a row a question, a column a world, say.

    Attributes
    ----------
    caption : str
        What it shows.
    groups : sequence of (str, dict from str to str)
        Columns that belong together: their title, and their names and heads.
    rows : sequence of (str, dict from str to dict)
        Their heads, and by column "answer" and, if it is a number, "value", "low" and
        "high"; how far it "leans" to holding, from -2 to 2; whether it "differs" from
        what is expected.
    address : callable, optional
        Tells where the cells of a column lead.
    joint : collection of str, default=()
        Columns that join others: they stand out, lead nowhere and are not counted.
    """

    caption: str
    groups: Sequence[tuple[str, Mapping[str, str]]]
    rows: Sequence[tuple[str, Mapping[str, Mapping[str, Any]]]]
    address: Callable[[str], str] | None = None
    joint: Collection[str] = ()

    @property
    def _columns(self) -> list[str]:
        """Names of all columns."""
        return [name for _, heads in self.groups for name in heads]

    def __repr__(self) -> str:
        """Write it as text, a sign a cell."""
        lines = [self.caption]
        for words, answers in self.rows:
            signs = [
                ANSWER_SIGNS[answers[one]["answer"]] or "·" for one in self._columns
            ]
            lines.append(f"{''.join(signs)}  {words}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Show it as a table."""
        titles = "".join(
            f'<th scope="colgroup" colspan="{len(heads)}">{html.escape(title)}</th>'
            for title, heads in self.groups
        )
        heads = "".join(
            f'<th scope="col"{self._look(name)}><span>{html.escape(head)}</span></th>'
            for _, heads in self.groups
            for name, head in heads.items()
        )
        rows = "".join(self._row(words, answers) for words, answers in self.rows)
        return (
            '<div class="msc-matrix"><table>'
            f"<caption>{html.escape(self.caption)}</caption><thead>"
            f'<tr><td rowspan="2"></td>{titles}<th rowspan="2">●&nbsp;/&nbsp;✕&nbsp;/'
            f"&nbsp;○</th></tr><tr>{heads}</tr></thead><tbody>{rows}</tbody></table>"
            "<p>● holds, ✕ fails, ○ cannot tell; blank: not asked."
            f"{self._key()}</p></div>"
        )

    def _key(self) -> str:
        """Explain the backgrounds, if there are any."""
        if not any(one.get("leans") for _, of in self.rows for one in of.values()):
            return ""
        return "".join(
            f' <span class="msc-{side}-{far}">&nbsp;{words}&nbsp;</span>'
            for side, far, words in _LEANINGS
        )

    def _look(self, name: str) -> str:
        """Let a column stand out that joins others."""
        return ' class="msc-joint"' if name in self.joint else ""

    def _row(self, words: str, answers: Mapping[str, Mapping[str, Any]]) -> str:
        """Write a row."""
        single = [name for name in self._columns if name not in self.joint]
        cells, given = [], [answers[name]["answer"] for name in single]
        for name in self._columns:
            one = answers[name]
            shown = ANSWER_SIGNS[one["answer"]]
            if shown and self.address and name in single:
                shown = f'<a href="{html.escape(self.address(name))}">{shown}</a>'
            kinds = f"msc-{one['answer'].replace(' ', '-')}"
            if leans := one.get("leans"):
                kinds += f" msc-{'for' if leans > 0 else 'against'}-{abs(leans)}"
            if one.get("differs"):
                kinds += " msc-differs"
            if name in self.joint:
                kinds += " msc-joint"
            title = html.escape(f"{name}: {_tell(one)}")
            cells.append(f'<td class="{kinds}" title="{title}">{shown}</td>')
        total = " / ".join(
            f"{given.count(one)}" for one in ANSWER_SIGNS if one in _TOLD
        )
        head = f'<th scope="row">{html.escape(words)}</th>'
        return f"<tr>{head}{''.join(cells)}<td>{total}</td></tr>"


def _short(name: str) -> str:
    """Return a world's number."""
    return name.lstrip("abcdefghijklmnopqrstuvwxyz").lstrip("0")


def _tell(answer: Mapping[str, Any]) -> str:
    """Say an answer in words."""
    words = str(answer["answer"])
    if answer.get("value") is None:
        return words
    return f"{Estimate.read(answer, 'value')}, {words}"


def world_matrix(verdicts: Verdicts, questions: Sequence[Question]) -> Matrix:
    """Show what each world answers to each question.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.

    Returns
    -------
    Matrix
        A row a question, a column a world; cells lead to the world's own section. The
        first column of a family is the answer of all its worlds together.
    """
    worlds, together = verdicts["worlds"], verdicts["families"]
    families = [*FAMILY_WORDS]
    shown = [name for name in worlds if worlds[name]["family"] != "variant"]
    shown.sort(key=lambda name: (families.index(worlds[name]["family"]), name))
    groups, joint = [], {}
    for family, names in groupby(shown, lambda name: worlds[name]["family"]):
        joint[all_of := f"all, {FAMILY_WORDS[family]}"] = family
        heads = {all_of: "all", **{name: _short(name) for name in names}}
        groups.append((FAMILY_WORDS[family], heads))
    nothing = {"answer": "not asked"}
    rows = []
    for one in questions:
        answers = {name: worlds[name]["answers"][one.id] for name in shown}
        answers |= {
            name: together[one.id].get(family, nothing)
            for name, family in joint.items()
        }
        leaning = {name: _leaning(one, answer) for name, answer in answers.items()}
        rows.append((QUESTION_WORDS[one.id], leaning))
    return Matrix("What each world answers", groups, rows, world_address, [*joint])


def assumption_matrix(
    verdicts: Verdicts, questions: Sequence[Question], of: Mapping[str, str]
) -> Matrix:
    """Show what becomes of the answers if one choice of ours is another.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.
    of : mapping of str to str
        Of which headline worlds, or families, and their titles.

    Returns
    -------
    Matrix
        A row a choice, a column a question; answers that differ from those with
        nothing changed stand out.
    """
    own = {
        name: {
            row["choice"]: row for row in verdicts["assumptions"] if row["of"] == name
        }
        for name in of
    }
    asked = {
        name: [
            one
            for one in questions
            if any(_is_asked(row["answers"][one.id]) for row in rows.values())
        ]
        for name, rows in own.items()
    }
    groups = [
        (of[name], {f"{name} {one.id}": QUESTION_WORDS[one.id] for one in asked[name]})
        for name in of
    ]
    table = []
    for choice in dict.fromkeys(choice for rows in own.values() for choice in rows):
        cells: dict[str, Mapping[str, Any]] = {}
        for name, rows in own.items():
            first = next(row for row in rows.values() if not row["changed"])
            for one in asked[name]:
                nothing = {"answer": "not asked"}
                answer = rows[choice]["answers"][one.id] if choice in rows else nothing
                differs = _is_asked(answer) and (
                    answer["answer"] != first["answers"][one.id]["answer"]
                )
                cells[f"{name} {one.id}"] = {**answer, "differs": differs}
        table.append((choice, cells))
    return Matrix("One choice changed at a time", groups, table)


def _leaning(asked: Question, answer: Mapping[str, Any]) -> dict[str, Any]:
    """Say how far a ratio leans to holding, sure or not."""
    told = dict(answer)
    if asked.predicate == "below" and told.get("value") is not None:
        ratio = told["value"] / asked.wanted
        told["leans"] = 2 - int(np.searchsorted(_STEPS, ratio, side="right"))
    return told


def _is_asked(answer: Mapping[str, Any]) -> bool:
    return bool(answer["answer"] != "not asked")


def count_table(verdicts: Verdicts, questions: Sequence[Question]) -> pd.DataFrame:
    """Count what worlds, and changed choices, answer.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.

    Returns
    -------
    DataFrame
        A row a question: over worlds, and over choices, in how many it holds, fails,
        cannot be told, and is not asked.
    """
    counts = verdicts["counts"]
    columns = {
        (over, f"{ANSWER_SIGNS[answer] or '–'} {answer}"): [
            counts[one.id][over][answer] for one in questions
        ]
        for over in ("worlds", "assumptions")
        for answer in ANSWER_SIGNS
    }
    rows = pd.Index([one.question for one in questions], name="asked")
    return pd.DataFrame(columns, index=rows)


@styled
def plot_families(verdicts: Verdicts, questions: Sequence[Question]) -> Figure:
    """Draw what families of worlds answer in the mean.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        Those whose answer is a ratio of two errors.

    Returns
    -------
    Figure
        A row a question, in it a mark a family: the mean of its worlds' ratios, with
        its interval.
    """
    families = [
        name
        for name in FAMILY_WORDS
        if any(name in verdicts["families"][one.id] for one in questions)
    ]
    height = (0.2 + 0.07 * len(families)) * len(questions) + 0.8
    figure, axis = plt.subplots(figsize=(7.4, height))
    for number, name in enumerate(families):
        shift = 0.7 * ((number + 0.5) / len(families) - 0.5)
        look: dict[str, Any] = {
            "color": chart_colour(number),
            "marker": chart_marker(number),
        }
        label = FAMILY_WORDS[name]
        for row, asked in enumerate(questions):
            told = verdicts["families"][asked.id].get(name)
            if told is None:
                continue
            one = Estimate.read(told, "value")
            axis.plot(one.bounds, (row + shift,) * 2, color=look["color"], lw=1.2)
            axis.plot(one.value, row + shift, ls="", ms=4.5, label=label, **look)
            label = ""
    axis.axvline(1, color="0.3", lw=1, ls="--")
    axis.set(xscale="log", xlabel="error of charts over that of the other")
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter("{x:g}")
    words = [QUESTION_WORDS[one.id] for one in questions]
    axis.set_yticks(range(len(questions)), words)
    axis.invert_yaxis()
    axis.legend(loc="lower left", bbox_to_anchor=(0, 1), ncol=3, frameon=False)
    return figure


@styled
def plot_standings(verdicts: Verdicts, family: str = "layout") -> Figure:
    """Draw how near methods end, over the worlds of a family.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    family : str, default="layout"
        Which family.

    Returns
    -------
    Figure
        A row a method, the best first: how far from the goal executed policies end
        (cm), the mean of logarithms over worlds with its interval; at the end, its mean
        rank, and in how many worlds it is the first.
    """
    standings = verdicts["standings"][family]
    names = sorted(standings, key=lambda name: standings[name]["error_cm"])
    figure, axis = plt.subplots(figsize=(7.4, 0.27 * len(names) + 0.7))
    for row, name in enumerate(names):
        one = Estimate.read(standings[name], "error_cm")
        look = METHOD_STYLES.get(name, {"color": "0.45", "marker": "o"})
        axis.plot(one.bounds, (row, row), color=look["color"], lw=1.4)
        mark = look["marker"] or "|"
        axis.plot(one.value, row, ls="", marker=mark, ms=5, color=look["color"])
        told = f"{standings[name]['rank']:.1f}"
        if first := standings[name]["first"]:
            told += f", first in {first}"
        axis.text(1.02, row, told, transform=axis.get_yaxis_transform(), va="center")
    axis.text(1.02, -1, "mean rank", transform=axis.get_yaxis_transform(), va="center")
    axis.set_yticks(range(len(names)), names)
    axis.set(xscale="log", xlabel="executed distance (cm)")
    axis.xaxis.set_major_formatter("{x:g}")
    axis.invert_yaxis()
    return figure


@styled
def plot_payoff(
    verdicts: Verdicts, questions: Sequence[Question], family: str = "layout"
) -> Figure:
    """Draw ratios against how broken a world is.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        Which ratios, a panel each; at most six.
    family : str, default="layout"
        Whose worlds.

    Returns
    -------
    Figure
        Across, the sizes of all jumps over the spread of policies; up, the ratio with
        its interval, a mark a world as in the matrix.
    """
    worlds = [one for one in verdicts["worlds"].values() if one["family"] == family]
    n_rows = -(-len(questions) // 2)
    figure, axes = plt.subplots(
        n_rows, 2, figsize=(7.4, 2.5 * n_rows), sharex=True, squeeze=False
    )
    for axis in axes.flat[len(questions) :]:
        axis.set_axis_off()
    for axis, asked in zip(axes.flat, questions, strict=False):
        for world in worlds:
            answer = world["answers"][asked.id]
            if answer.get("value") is not None:
                _draw_answer(axis, world["size"], answer)
        axis.axhline(asked.wanted, color="0.3", lw=1, ls="--")
        axis.set_yscale("log")
        axis.yaxis.set_major_formatter("{x:g}")
        rho = verdicts["payoff"].get(asked.id)
        axis.set_title(QUESTION_WORDS[asked.id], loc="left", fontsize=SMALL + 1)
        if rho:
            words = f"ρ = {Estimate.read(rho, 'rho')}"
            axis.text(0.98, 0.03, words, transform=axis.transAxes, ha="right")
        axis.set_ylabel("ratio")
    for axis in axes[-1]:
        axis.set_xlabel("sizes of all jumps, over the policies' spread")
    return figure


def _draw_answer(axis: Axes, place: float, answer: Mapping[str, Any]) -> None:
    """Draw a number with its interval, its mark by the answer."""
    one = Estimate.read(answer, "value")
    axis.plot((place, place), one.bounds, color="0.6", lw=1)
    look = _LOOKS[answer["answer"]]
    axis.plot(place, one.value, ls="", ms=5, mew=0.9, **look)


@styled
def plot_maps(
    world: Workspace,
    train: Dataset,
    *,
    pieces: NDArray[np.intp],
    charts: NDArray[np.intp],
    test: Dataset,
    error_cm: Mapping[str, ArrayLike],
) -> Figure:
    """Draw a manifold over the annulus of its goals.

    Parameters
    ----------
    world : Workspace
        Its tasks have an angle and a radius.
    train : Dataset
        Searched tasks.
    pieces, charts : ndarray of shape (n_train,)
        The piece between jumps, and the chart, that each belongs to.
    test : Dataset
        Tasks tested on.
    error_cm : mapping of str to array_like of shape (n_test,)
        By method, how far from the goal each test task ended (cm); two of them.

    Returns
    -------
    Figure
        From above: goals of training tasks in the colour and mark of their piece, and
        of their chart, the largest first; goals of test tasks, the larger the farther
        the arm ended.
    """
    figure, axes = plt.subplots(2, 2, figsize=(7.4, 7.4))
    goals, tested = (world.target(world.tasks_in(one.table)) for one in (train, test))
    titles = "pieces between jumps", "charts found"
    for axis, labels, title in zip(axes[0], (pieces, charts), titles, strict=True):
        draw_plan(axis, world)
        draw_labels(axis, goals, _by_size(labels), size=3.5)
        axis.set_title(title, loc="left")
    for axis, (name, errors) in zip(axes[1], error_cm.items(), strict=True):
        draw_plan(axis, world)
        far = np.asarray(errors, dtype=float)
        look = {"edgecolors": TRIO[0], "facecolors": "none", "linewidths": 0.9}
        axis.scatter(*tested.T, s=3 + 40 * np.minimum(far, 10), **look)
        mean = rounded(float(far.mean()), 2)
        axis.set_title(f"executed: {name}, mean {mean} cm", loc="left")
    for axis in axes.flat:
        axis.set(aspect="equal", xlim=(-0.86, 0.86), ylim=(-0.86, 0.86))
        axis.set_axis_off()
    return figure


def _by_size(labels: NDArray[np.intp]) -> NDArray[np.intp]:
    """Renumber labels, the most frequent first."""
    order = np.argsort(-np.bincount(labels), kind="stable")
    return np.argsort(order)[labels]
