"""A place for each world: what it is, a picture, and how methods fare in it.

`WorldSheets` shows itself as folded sections, a world each; `world_address` says where
in the book a world's section is. What is not measured yet is left out, and said to be.
"""

from __future__ import annotations

import base64
import html
import io
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle as Disc
from numpy.typing import NDArray
from PIL import Image

from msc.data import (
    Dataset,
    find_data,
    find_jump_edges,
    find_pieces,
    load_dataset,
    read_result,
    task_edges,
)
from msc.estimates import Average, rounded
from msc.plots._style import SMALL, TRIO, chart_colour, chart_marker, styled, widen
from msc.plots._tables import SIGNS
from msc.plots._world import VIEWS, draw_links
from msc.robot import Arm, Workspace, forward_kinematics, read_world
from msc.study import METHODS, build_method, find_cell
from msc.worlds import family_of

N_SAMPLES = 24  # training tasks of the tables
N_SHOWN = 8  # movements of a strip
N_COLUMNS = 6  # of small worlds
APART = 2.1  # m; from one small world to the next
DRAG = "drag-"  # before a world's name: its place among those to choose from
N_LABELS = 6  # as many colours and marks as charts have
LEFT_OUT = "projected", "ladder", "number of charts", "choices"  # groups
PAGES = {
    "layout": "worlds_layouts",
    "priced": "worlds_priced",
    "mujoco": "worlds_priced",
    "arm": "worlds_others",
    "annulus": "worlds_others",
    "height": "worlds_others",
    "turn": "worlds_others",
}
_FURTHER = {
    "radius_m": "goals {:.2f} to {:.2f} m from the base",
    "height_m": "the first obstacle moved by −{1:g} to {1:g} m",
    "turn_deg": "home turned by −{1:g} to {1:g}°",
}
_WORDS = {"holds": "hold", "fails": "fail", "cannot tell": "cannot be told"}
_COLOURS = 64  # of a picture in a page: a third of its bytes

Array = NDArray[np.float64]
Labels = NDArray[np.intp]
Shift = tuple[float, float]


def world_address(name: str) -> str:
    """Say where in the book a world's section is.

    Parameters
    ----------
    name : str
        The world's name.

    Returns
    -------
    str
        A page's address, from another page of the book.

    Raises
    ------
    ValueError
        If its family has no chapter.

    Examples
    --------
    >>> world_address("layout07")
    'worlds_layouts.html#layout07'
    """
    family = family_of(name).name
    if family not in PAGES:
        raise ValueError(f"world={name!r} has no section; wanted of {', '.join(PAGES)}")
    return f"{PAGES[family]}.html#{name}"


class Found(NamedTuple):
    """What is known of a world; None: not yet."""

    world: Workspace
    train: Dataset | None = None
    jumps: Mapping[str, Any] | None = None
    study: Mapping[str, Any] | None = None
    answers: Mapping[str, Any] | None = None
    moves: Mapping[str, Any] | None = None


def look_up(
    name: str, folder: Path | None = None, results: Path | None = None
) -> Found:
    """Load what is known of a world.

    Parameters
    ----------
    name : str
        Its name.
    folder, results : Path, optional
        Where worlds and tables are, and what was found in them; by default in the
        book's data.

    Returns
    -------
    Found
        World, table and results.
    """
    folder = folder or find_data() / "worlds"
    results = results or find_data() / "results" / "worlds"

    def read(stem: str) -> Any:
        path = results / f"{stem}.json"
        return read_result(path, folder.parent) if _is_there(path) else None

    table = folder / f"{name}.csv"
    train = load_dataset(table) if _is_there(table) else None
    verdicts = read("verdicts") or {"worlds": {}}
    answers = verdicts["worlds"].get(name, {}).get("answers")
    world = read_world(folder / f"{name}.toml")
    jumps, moves = read(f"jumps_{name}"), read(f"moves_{name}")
    return Found(world, train, jumps, read(name), answers, moves)


def _is_there(path: Path) -> bool:
    """Tell whether there is a file, by opening it: a chapter's kernel notes that."""
    try:
        path.open("rb").close()
    except FileNotFoundError:
        return False
    return True


@dataclass(frozen=True)
class WorldSheets:
    """Folded sections, a world each.

    Parameters
    ----------
    names : sequence of str
        Which worlds.
    folder, results : Path, optional
        Where worlds and tables are, and what was found in them; by default in the
        book's data.

    Examples
    --------
    >>> WorldSheets(["layout07"], results=Path("elsewhere"))
    layout07: 4 obstacles; jumps not settled yet
    """

    names: Sequence[str]
    folder: Path | None = None
    results: Path | None = None

    @cached_property
    def _found(self) -> list[Found]:
        """What is known of each."""
        return [look_up(name, self.folder, self.results) for name in self.names]

    def __repr__(self) -> str:
        """Write a line a world."""
        return "\n".join(f"{one.world.name}: {_summary(one)}" for one in self._found)

    def _repr_html_(self) -> str:
        """Show the sections."""
        return f'<div class="msc-sheets">{"".join(map(_section, self._found))}</div>'


def _section(found: Found) -> str:
    """Write a world's section."""
    world, name = found.world, html.escape(found.world.name, quote=True)
    image = _encode(plot_sheet(world, found.train, found.jumps))
    alt = html.escape(describe_picture(found), quote=True)
    files = [f"{name}.toml"]
    if found.train is not None:
        files += [f"{name}.csv", f"{name}_test.csv"]
    listed = ", ".join(f"<code>data/worlds/{file}</code>" for file in files)
    link = f'<p><a href="#{DRAG}{name}">Drag its goal</a></p>' if found.moves else ""
    return (
        f'<details id="{name}"><summary><b>{name}</b>: '
        f"{html.escape(_summary(found))}</summary>"
        f'<img alt="{alt}" src="data:image/png;base64,{image}">{link}'
        f"{_missing(found)}{_leaderboard(found)}"
        f"<p>Files: {listed}</p></details>"
    )


def _summary(found: Found) -> str:
    """Say in a line what a world is, and what was found in it."""
    parts = [", ".join(describe_world(found.world)), tell_jumps(found.jumps)]
    if found.answers is not None:
        counts = Counter(one["answer"] for one in found.answers.values())
        told = ", ".join(f"{counts[key]} {word}" for key, word in _WORDS.items())
        parts.append(f"of {sum(counts[key] for key in _WORDS)} questions {told}")
    return "; ".join(parts)


def describe_world(world: Workspace) -> list[str]:
    """Say what is particular about a world."""
    n_circles = len(world.circles)
    told = [f"{n_circles or 'no'} obstacle{'s' * (n_circles != 1)}"]
    told += [_FURTHER[one.name].format(one.low, one.high) for one in world.further]
    if world.link_lengths != Workspace.link_lengths:
        lengths = ", ".join(f"{length:g}" for length in world.link_lengths)
        told.append(f"links of {lengths} m")
    if world.cost.contact:
        told.append(f"contact costs {world.cost.contact:g} a newton-second")
    if world.physics.engine == "mujoco":
        told.append("in MuJoCo")
    return told


def tell_jumps(jumps: Mapping[str, Any] | None) -> str:
    """Say how many jumps there are."""
    if jumps is None:
        return "jumps not settled yet"
    if "jumps" not in jumps:
        tried = jumps["bisected"]
        kept = sum(one["is_jump"] for one in tried)
        large = f"{jumps['large']} of {jumps['edges']} steps are large"
        return f"{large}, {kept} of {len(tried)} bisected ones jumps"
    inside = [one for one in _confirmed(jumps) if one["between_deg"][1] < 360]
    n_jumps = len(inside)
    cut = ", and one at the cut" * (n_jumps < len(_confirmed(jumps)))
    return f"{n_jumps or 'no'} jump{'s' * (n_jumps != 1)}{cut}"


def _confirmed(jumps: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the jumps of a circle that bisection kept."""
    return [one for one in jumps["jumps"] if one["is_jump"]]


def _missing(found: Found) -> str:
    """Say what is not there yet, and what makes it."""
    name = html.escape(found.world.name)
    steps = {"search": found.train, "jumps": found.jumps, "study": found.study}
    words = {"search": "searched", "jumps": "bisected", "study": "studied"}
    return "".join(
        f"<p>Not {words[step]} yet: <code>msc worlds {step} {name}</code></p>"
        for step, there in steps.items()
        if there is None
    )


def describe_picture(found: Found) -> str:
    """Say what the picture of a world shows."""
    what = f"{found.world.name} from above, {', '.join(describe_world(found.world))}"
    if found.train is None:
        return f"{what}, with the arm at home."
    if found.world.further:
        more = "its goals twice, by the pieces between jumps and by charts"
    else:
        more = "its goals by the pieces between jumps; six weights over the task angle"
    return f"{what}; {more}; below, {N_SHOWN} movements."


def _encode(figure: Figure) -> str:
    """Write a figure as PNG in few colours, base 64."""
    whole, small = io.BytesIO(), io.BytesIO()
    figure.savefig(whole, format="png", dpi=110)
    with Image.open(whole) as image:
        few = image.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE)
    few.save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


# How methods fare


def _leaderboard(found: Found) -> str:
    """Write the table of methods, the nearest to their goals first."""
    if found.study is None:
        return ""
    design = "uniform" if found.world.further else "even"
    of = find_cell(found.study, design, N_SAMPLES)["measures"]["error_cm"]
    means = {
        name: Average.read(one)
        for name, one in of.items()
        if _is_listed(name) and one["mean"] is not None
    }
    names = sorted(means, key=lambda name: means[name].value)
    rows = "".join(_row(name, means[name], means.get("charts")) for name in names)
    n_sets = max(len(one.per_set) for one in means.values())
    caption = (
        f"Distance at the end, {N_SAMPLES} training tasks, "
        f"up to {n_sets} training set{'s' * (n_sets != 1)}"
    )
    heads = "method", "cm [95 % interval]", "charts over it"
    head = "".join(f'<th scope="col">{text}</th>' for text in heads)
    table = (
        f"<table><caption>{caption}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )
    if failed := _list_failed(found.study, design, set(means)):
        table += f"<p>No result: {html.escape(', '.join(failed))}</p>"
    return table


def _is_listed(name: str) -> bool:
    """Tell whether a method is in the tables: all but those that know more."""
    return name not in METHODS or METHODS[name].group not in LEFT_OUT


def _list_failed(study: Mapping[str, Any], design: str, there: set[str]) -> list[str]:
    """List methods that could be fitted to no training set."""
    tried = (key.rsplit("/", 3) for key in study["failed"])
    names = (n for n, *cell, _ in tried if cell == [design, str(N_SAMPLES)])
    return sorted({name for name in names if _is_listed(name)} - there)


def _row(name: str, mean: Average, charts: Average | None) -> str:
    """Write a method's row."""
    cells = [_interval(rounded(mean.value, 2), mean.estimate.bounds), ""]
    if charts is not None and name != "charts":
        ratio = charts.over(mean)
        sign = SIGNS[ratio.verdict]
        cells[1] = _interval(f"{sign} {rounded(ratio.value, 2)} ×", ratio.bounds)
    ours = ' class="msc-charts"' * (name == "charts")
    row = "".join(f"<td>{cell}</td>" for cell in cells)
    return f'<tr{ours}><th scope="row">{html.escape(name)}</th>{row}</tr>'


def _interval(number: str, bounds: tuple[float, float]) -> str:
    """Write a number with its interval below it."""
    low, high = (f"{float(rounded(bound, 2)):g}" for bound in bounds)
    return f"{number} <small>[{low}, {high}]</small>"


# Pictures


@styled
def plot_sheet(
    world: Workspace,
    train: Dataset | None = None,
    jumps: Mapping[str, Any] | None = None,
) -> Figure:
    """Draw a world: from above, some of its movements, and its policies.

    Parameters
    ----------
    world : Workspace
        The world.
    train : Dataset, optional
        Its searched tasks; without them there is but the world.
    jumps : dict, optional
        What `msc.worlds.bisect_world` found in them.

    Returns
    -------
    Figure
        Left the world with the arm at home, and goals of the training tasks in the
        colour and mark of the piece that each belongs to; right the weights of their
        policies over the task angle, in those of the charts that SMCE finds, or, where
        tasks have further numbers, the goals again. Below, movements of evenly spaced
        tasks: the way of the end effector, orange if the arm met an obstacle, and the
        last pose.
    """
    if train is None:
        figure = plt.figure(figsize=(7.4, 3.2), layout="none")
        draw_plan(_panel(figure, (0.29, 0.02, 0.42, 0.96)), world)
        return figure
    figure = plt.figure(figsize=(7.4, 4.5), layout="none")  # half the time
    goals = world.target(world.tasks_in(train.table))
    above = _panel(figure, (0.0, 0.25, 0.43, 0.7))
    draw_plan(above, world)
    _draw_jumps(above, world, jumps)
    draw_labels(above, goals, tell_pieces(world, train, jumps))
    words = "goals of training tasks" if jumps is None else "goals, by pieces"
    figure.text(0.01, 0.955, words, fontsize=10)
    charts = build_method("charts", workspace=world).charts
    labels = charts.fit_predict(train.policies)
    if world.further:
        right = _panel(figure, (0.5, 0.25, 0.43, 0.7))
        draw_plan(right, world)
        draw_labels(right, goals, labels)
    else:
        _draw_weights(figure, train, labels, jumps)
    words = "goals" if world.further else "weights"
    figure.text(0.5, 0.955, f"{words}, by charts found", fontsize=10)
    strip = _panel(figure, (0.0, 0.0, 1.0, 0.24))
    _draw_strip(strip, world, train)
    return figure


def _panel(figure: Figure, box: tuple[float, float, float, float]) -> Axes:
    """Add a panel for a world from above."""
    axis = figure.add_axes(box)
    axis.set(aspect="equal", xlim=(-0.95, 0.95), ylim=(-0.95, 0.95))
    axis.set_axis_off()
    return axis


def tell_pieces(
    world: Workspace, train: Dataset, jumps: Mapping[str, Any] | None
) -> Labels:
    """Tell which piece between jumps each task of a world belongs to.

    Parameters
    ----------
    world : Workspace
        The world.
    train : Dataset
        Its tasks.
    jumps : dict or None
        What `msc.worlds.bisect_world` found in them; None: they are not settled yet.

    Returns
    -------
    ndarray of shape (n_tasks,)
        Numbers of pieces: on a circle between confirmed jumps, otherwise between all
        steps that look like one. `N_LABELS` if jumps are not settled.
    """
    n_tasks = len(train.tasks)
    if jumps is None:
        return np.full(n_tasks, N_LABELS)
    if "jumps" in jumps:
        ring = np.arange(n_tasks)
        edges = np.stack([ring, np.roll(ring, -1)], axis=1)
        starts = [one["between_deg"][0] for one in _confirmed(jumps)]
        return find_pieces(n_tasks, edges, np.searchsorted(train.task_deg, starts))
    edges = task_edges(train.tasks / world.task_units, closed=False)
    return find_pieces(n_tasks, edges, find_jump_edges(train.policies, edges))


def draw_plan(axis: Axes, world: Workspace, shift: Shift = (0.0, 0.0)) -> None:
    """Draw a world from above with its arm at home, somewhere in a panel."""
    _draw_round(axis, world, shift)
    places = forward_kinematics(world.home, world.link_lengths)
    draw_links(axis, places + shift, {"lw": 2, "color": "0.6"}, ms=2.5)


def _draw_round(axis: Axes, world: Workspace, shift: Shift) -> None:
    """Draw the circle of goals, or the rims of their annulus, and obstacles."""
    rims = [one[1:] for one in world.further if one.name == "radius_m"]
    for radius in rims[0] if rims else (world.goal_radius,):
        axis.add_patch(Disc(shift, radius, fill=False, **VIEWS["movement"].goals))
    for x, y, radius in world.circles:
        axis.add_patch(Disc((x + shift[0], y + shift[1]), radius, color="black"))


def _draw_jumps(
    axis: Axes,
    world: Workspace,
    jumps: Mapping[str, Any] | None,
    shift: Shift = (0.0, 0.0),
) -> None:
    """Draw where on the circle of goals jumps are."""
    for place in find_places(jumps):
        ends = np.outer((0.86, 1.14), world.target(place)) + shift
        axis.plot(*ends.T, color="black", lw=1.2, zorder=4)


def find_places(jumps: Mapping[str, Any] | None) -> list[float]:
    """Return the tasks (degrees) of the jumps of a circle."""
    if jumps is None or "jumps" not in jumps:
        return []
    return [float(np.mean(one["located_deg"])) for one in _confirmed(jumps)]


def draw_labels(axis: Axes, points: Array, labels: Labels, size: float = 4) -> None:
    """Draw points, the first labels in colours and marks, all others grey."""
    for label in np.unique(np.minimum(labels, N_LABELS)):
        is_other = label == N_LABELS
        own = points[labels >= N_LABELS if is_other else labels == label]
        colour, marker = ("0.6", "x") if is_other else _look(label)
        axis.plot(*own.T, ls="", marker=marker, ms=size, color=colour)


def _look(label: int) -> tuple[str, str]:
    """Return a label's colour and mark."""
    return chart_colour(label), chart_marker(label)


def _draw_weights(
    figure: Figure, train: Dataset, labels: Labels, jumps: Mapping[str, Any] | None
) -> None:
    """Draw weights over the task angle, with jumps as lines."""
    n_columns = train.policies.shape[1] // 2
    box = {"left": 0.5, "right": 0.975, "bottom": 0.36, "top": 0.9}
    grid = figure.add_gridspec(2, n_columns, wspace=0.45, hspace=0.32, **box)
    for number, weights in enumerate(train.policies.T):
        row, column = divmod(number, n_columns)
        axis = figure.add_subplot(grid[row, column])
        for place in find_places(jumps):
            axis.axvline(place, color="0.75", lw=0.8, zorder=1)
        draw_labels(axis, np.c_[train.task_deg, weights], labels, size=2)
        name = f"$w_{column + 1}^{'xy'[row]}$"
        axis.set_title(name, loc="right", y=1.0, pad=2)  # else it is sought for long
        axis.set(xlim=(0, 360), ylim=widen(weights, 0.08), xticks=(0, 180, 360))
        axis.tick_params(labelsize=SMALL, labelbottom=row == 1, pad=2)
        if row == 1:
            axis.set_xlabel("task (°)", fontsize=SMALL, labelpad=1)


def _draw_strip(axis: Axes, world: Workspace, train: Dataset) -> None:
    """Draw movements of evenly spaced tasks side by side."""
    shown = np.linspace(0, len(train.tasks), N_SHOWN, endpoint=False).astype(int)
    tasks = world.tasks_in(train.table)[shown]
    with Arm(world, n_parallel=N_SHOWN) as arm:
        rollouts = arm.execute_many(train.policies[shown], tasks)
    for number, (task, rollout) in enumerate(zip(tasks, rollouts, strict=True)):
        shift = APART * number, 0.0
        _draw_round(axis, world.at(task), shift)
        end = forward_kinematics(rollout.joints[-1], world.link_lengths)
        draw_links(axis, end + shift, {"lw": 1.5, "color": "0.6"}, ms=2)
        colour = TRIO[1] if rollout.touched else TRIO[0]
        axis.plot(*(rollout.path + shift).T, color=colour, lw=1.3, zorder=4)
        goal = {**VIEWS["movement"].goal, "ms": 4, "mew": 1.2}
        axis.plot(*(world.target(task) + shift), **goal)
        _name(axis, f"{np.ravel(task)[0]:.0f}°", shift)
    axis.set(xlim=(-APART / 2, APART * (N_SHOWN - 0.5)), ylim=(-1.0, 1.2))


def _name(axis: Axes, text: str, shift: Shift) -> None:
    """Write something above one of several worlds in a panel."""
    axis.text(shift[0], shift[1] + 0.97, text, fontsize=SMALL, ha="center")


@styled
def plot_contact_sheet(
    names: Sequence[str], folder: Path | None = None, results: Path | None = None
) -> Figure:
    """Draw many worlds from above, side by side.

    Parameters
    ----------
    names : sequence of str
        Which worlds.
    folder, results : Path, optional
        Where worlds and tables are, and what was found in them; by default in the
        book's data.

    Returns
    -------
    Figure
        A panel a world, six a row: the arm at home, obstacles, and goals of training
        tasks in the colour and mark of the piece between jumps that each belongs to.
    """
    n_rows = -(-len(names) // N_COLUMNS)
    width = 7.4
    height = width * (n_rows + 0.05) / N_COLUMNS
    figure = plt.figure(figsize=(width, height), layout="none")
    axis = _panel(figure, (0.0, 0.0, 1.0, 1.0))  # one for all: panels take long
    for number, name in enumerate(names):
        row, column = divmod(number, N_COLUMNS)
        found, shift = look_up(name, folder, results), (APART * column, -APART * row)
        draw_plan(axis, found.world, shift)
        if found.train is not None:
            goals = found.world.target(found.world.tasks_in(found.train.table))
            pieces = tell_pieces(found.world, found.train, found.jumps)
            draw_labels(axis, goals + shift, pieces, size=1.8)
            _draw_jumps(axis, found.world, found.jumps, shift)
        _name(axis, name, shift)
    bottom = -APART * (n_rows - 0.5)
    top = bottom + APART * N_COLUMNS * height / width
    axis.set(xlim=(-APART / 2, APART * (N_COLUMNS - 0.5)), ylim=(bottom, top))
    return figure
