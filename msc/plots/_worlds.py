"""Many worlds at a glance: claim × world, where charts pay, and maps of an annulus.

A `Matrix` shows itself as an HTML table whose cells lead to the worlds' pages; what it
is made of are the verdicts of `msc.worlds.judge_worlds`.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from msc.data import Dataset
from msc.estimates import Estimate, rounded
from msc.plots._style import (
    SMALL,
    TRIO,
    chart_colour,
    chart_marker,
    styled,
)
from msc.plots._world import draw_world
from msc.robot import Workspace
from msc.worlds import VARIANTS, Question, family_of

ANSWER_SIGNS = {"holds": "●", "fails": "✕", "cannot tell": "○", "not asked": ""}
_LOOKS: dict[str, dict[str, Any]] = {
    "holds": {"marker": "o", "mfc": "0.2", "mec": "0.2"},
    "fails": {"marker": "X", "mfc": "0.2", "mec": "0.2"},
    "cannot tell": {"marker": "o", "mfc": "white", "mec": "0.2"},
}
_FAMILY_WORDS = {
    "layout": "layouts of obstacles",
    "arm": "arms, no obstacles",
    "annulus": "goals in an annulus",
    "priced": "a price on contact",
    "mujoco": "MuJoCo",
    "height": "a moving obstacle",
    "turn": "a turning home",
    "variant": "variants",
}
_TOUCHED = "touched", "touched_elsewhere"

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Matrix:
    """Answers at a glance: a row a question, a column a world, or a variant.

    Attributes
    ----------
    caption : str
        What it shows.
    groups : sequence of (str, sequence of str)
        Columns that belong together: their title, and names.
    rows : sequence of (str, dict from str to dict)
        What was asked, and by column "answer" and, if it is a number, "value", "low"
        and "high".
    link : str
        Where a cell leads, with the column's name for ``{}``; empty: nowhere.
    """

    caption: str
    groups: Sequence[tuple[str, Sequence[str]]]
    rows: Sequence[tuple[str, Mapping[str, Mapping[str, Any]]]]
    link: str = ""

    def __repr__(self) -> str:
        """Write it as text, a sign a cell."""
        lines = [self.caption]
        for words, answers in self.rows:
            signs = [
                ANSWER_SIGNS[answers[name]["answer"]] or "·"
                for _, names in self.groups
                for name in names
            ]
            lines.append(f"{''.join(signs)}  {words}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Show it as a table."""
        heads = "".join(
            f'<th scope="colgroup" colspan="{len(names)}">{html.escape(title)}</th>'
            for title, names in self.groups
        )
        names = [name for _, group in self.groups for name in group]
        numbers = "".join(f'<th scope="col">{_short(name)}</th>' for name in names)
        rows = "".join(self._row(words, answers) for words, answers in self.rows)
        return (
            '<div class="msc-matrix"><table>'
            f"<caption>{html.escape(self.caption)}</caption><thead>"
            f'<tr><td rowspan="2"></td>{heads}<th rowspan="2">●&nbsp;/&nbsp;✕&nbsp;/'
            f"&nbsp;○</th></tr><tr>{numbers}</tr></thead><tbody>{rows}</tbody></table>"
            "<p>● holds, ✕ fails, ○ cannot tell; blank: not asked.</p></div>"
        )

    def _row(self, words: str, answers: Mapping[str, Mapping[str, Any]]) -> str:
        """Write a row."""
        cells, counts = [], dict.fromkeys(ANSWER_SIGNS, 0)
        for _, names in self.groups:
            for name in names:
                answer = answers[name]["answer"]
                counts[answer] += 1
                sign, told = ANSWER_SIGNS[answer], f"{name}: {_tell(answers[name])}"
                shown = sign
                if sign and self.link:
                    href = html.escape(self.link.format(name))
                    shown = f'<a href="{href}">{sign}</a>'
                kind = answer.replace(" ", "-")
                title = html.escape(told)
                cells.append(f'<td class="msc-{kind}" title="{title}">{shown}</td>')
        total = " / ".join(str(counts[a]) for a in ("holds", "fails", "cannot tell"))
        head = f'<th scope="row">{html.escape(words)}</th>'
        return f"<tr>{head}{''.join(cells)}<td>{total}</td></tr>"


def _short(name: str) -> str:
    """Return a world's number, or a variant's name."""
    return html.escape(name.lstrip("abcdefghijklmnopqrstuvwxyz").lstrip("0") or name)


def _tell(answer: Mapping[str, Any]) -> str:
    """Say an answer in words."""
    words = str(answer["answer"])
    if answer.get("value") is None:
        return words
    return f"{Estimate.read(answer, 'value')}, {words}"


def world_matrix(
    verdicts: Mapping[str, Any], questions: Sequence[Question], link: str = ""
) -> Matrix:
    """Show what each world answers to each question.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.
    link : str, optional
        Where a cell leads, with the world's name for ``{}``.

    Returns
    -------
    Matrix
        A row a question, a column a world.
    """
    worlds = verdicts["worlds"]
    families = [*_FAMILY_WORDS]
    shown = [name for name in worlds if worlds[name]["family"] != "variant"]
    shown.sort(key=lambda name: (families.index(worlds[name]["family"]), name))
    groups = [
        (_FAMILY_WORDS[family], list(names))
        for family, names in groupby(shown, lambda name: family_of(name).name)
    ]
    rows = [
        (one.question, {name: worlds[name]["answers"][one.id] for name in shown})
        for one in questions
    ]
    return Matrix("What each world answers", groups, rows, link)


def variant_matrix(
    verdicts: Mapping[str, Any], questions: Sequence[Question], base: str
) -> Matrix:
    """Show what becomes of the answers if one choice of ours is another.

    Parameters
    ----------
    verdicts : dict
        What `msc.worlds.judge_worlds` returned.
    questions : sequence of Question
        What was asked.
    base : {"free", "obstacles"}
        The headline world.

    Returns
    -------
    Matrix
        A row a choice, a column a question.
    """
    worlds = verdicts["worlds"]
    rows = [
        (words, worlds[f"{base}-{name}"]["answers"])
        for name, (words, _) in VARIANTS.items()
        if f"{base}-{name}" in worlds
    ]
    asked = [
        one.id
        for one in questions
        if any(answers[one.id]["answer"] != "not asked" for _, answers in rows)
    ]
    title = {"free": "without obstacles", "obstacles": "with obstacles"}[base]
    return Matrix(f"One choice changed, {title}", [("questions", asked)], rows)


@styled
def plot_payoff(
    verdicts: Mapping[str, Any], questions: Sequence[Question], family: str = "layout"
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
        told = f", ρ = {Estimate.read(rho, 'rho')}" if rho else ""
        axis.set_title(f"{asked.id}{told}", loc="left", fontsize=SMALL + 1)
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
    pieces: ArrayLike,
    charts: ArrayLike,
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
    pieces, charts : array_like of shape (n_train,)
        The piece between jumps, and the chart, that each belongs to.
    test : Dataset
        Tasks tested on.
    error_cm : mapping of str to array_like of shape (n_test,)
        By method, how far from the goal each test task ended (cm); two of them.

    Returns
    -------
    Figure
        From above: goals of training tasks in the colour and mark of their piece, and
        of their chart; goals of test tasks, the larger the farther the arm ended.
    """
    figure, axes = plt.subplots(2, 2, figsize=(7.4, 7.2), sharex=True, sharey=True)
    names = list(world.task_names)
    goals, tested = (world.target(one.table[names].to_numpy()) for one in (train, test))
    titles = "pieces between jumps", "charts found"
    for axis, labels, title in zip(axes[0], (pieces, charts), titles, strict=True):
        _draw_labels(axis, goals, np.asarray(labels))
        axis.set_title(title, loc="left")
    for axis, (name, errors) in zip(axes[1], error_cm.items(), strict=True):
        far = np.asarray(errors, dtype=float)
        look = {"edgecolors": TRIO[0], "facecolors": "none", "linewidths": 0.9}
        axis.scatter(*tested.T, s=4 + 40 * np.minimum(far, 10), **look)
        mean = rounded(float(far.mean()), 2)
        axis.set_title(f"executed: {name}, mean {mean} cm", loc="left")
    for axis in axes.flat:
        draw_world(axis, world, view="above")
        axis.set(xlim=(-0.95, 0.95), ylim=(-0.95, 0.95))
    return figure


def _draw_labels(axis: Axes, goals: Array, labels: NDArray[np.intp]) -> None:
    """Draw goals, the six largest labels in colours, all others grey."""
    by_size = np.argsort(-np.bincount(labels), kind="stable")
    for place, label in enumerate(by_size):
        own = goals[labels == label]
        is_shown = place < 6
        colour = chart_colour(place) if is_shown else "0.7"
        marker = chart_marker(place) if is_shown else "x"
        axis.plot(*own.T, ls="", marker=marker, ms=3.5, color=colour)


@styled
def plot_engines(engines: Mapping[str, Any]) -> Figure:
    """Draw how far movements differ between the engines.

    Parameters
    ----------
    engines : dict
        What `msc.worlds.compare_engines` wrote.

    Returns
    -------
    Figure
        Left, shares of movements whose joints differ by no more than so much; right,
        what they cost elsewhere over what they cost where they were searched. Apart:
        those that met an obstacle in neither engine, and the others.
    """
    apart, own, elsewhere, *touched = (
        np.concatenate([np.asarray(one[key]) for one in engines["worlds"].values()])
        for key in ("joints_rad", "cost", "cost_elsewhere", *_TOUCHED)
    )
    ratio, met = elsewhere / own, np.any(touched, axis=0)
    figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 2.9))
    kinds = (
        ("no contact", ~met, TRIO[0], "-"),
        ("contact", met, TRIO[1], "--"),
    )
    for words, of, colour, dashes in kinds:
        if not of.any():
            continue
        share = (np.arange(of.sum()) + 1) / of.sum()
        look = {"color": colour, "ls": dashes, "label": f"{words} ({of.sum()})"}
        left.step(np.sort(np.maximum(apart[of], 1e-17)), share, where="post", **look)
        right.step(np.sort(ratio[of]), share, where="post", **look)
    left.set(xscale="log", xlabel="largest difference of a joint (rad)")
    left.set_ylabel("share of movements")
    left.legend(loc="upper left")
    right.set(xlabel="cost in the other engine, over its own")
    return figure
