"""Regressions under the reader's hand: over how many tasks, or into how many charts."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from msc.plots._manifold import COMPARED, plot_manifold
from msc.plots._slider import FLAT, TASK_AXIS, Mark, Panel, Slider, choose_ticks
from msc.plots._style import COLOURS, WEIGHT_NAMES, Array, chart_colour, widen
from msc.study import Experiment

_TASKS = np.linspace(0, 2 * np.pi, 180, endpoint=False)[:, None]  # (rad)


def slide_experiments(
    experiments: Mapping[int, Experiment], name: str, *, first: int
) -> Slider:
    """Let the reader go from one training to the next.

    Parameters
    ----------
    experiments : mapping of int to Experiment
        In one world, by what the slider sets, ascending.
    name : str
        What that is, in the plural, as "training tasks".
    first : int
        Where the slider is at first.

    Returns
    -------
    Slider
        Three panels: the weight that varies most, predicted by the charts, and by the
        single regression; and the mean squared errors of both on the test tasks.
    """
    steps, found = [*experiments], [*experiments.values()]
    errors = np.array([one.squared_errors()[[*COMPARED]].mean() for one in found])
    captions = [
        f"{step} {name}. Mean squared error: single regression {single:.3g}, "
        f"charts {charts:.3g}."
        for step, (single, charts) in zip(steps, errors, strict=True)
    ]
    at = steps.index(first)
    return Slider(
        name=name,
        labels=[f"{step} {name}" for step in steps],
        captions=captions,
        panels=[
            _weight_panel("charts", found, _by_chart(found)),
            _weight_panel("single regression", found, [_curve(found)]),
            _errors_panel(steps, errors, name),
        ],
        poster=plot_manifold(found[at]),
        poster_alt=f"One policy weight over the task angle. {captions[at]}",
        first=at,
        walks=True,
        legend={name: COLOURS[name] for name in (*COMPARED, "searched")},
    )


def _weight(found: list[Experiment]) -> int:
    """Return the weight that varies most."""
    return int(np.argmax(found[0].policies.std(axis=0)))


def _points(one: Experiment, method: str, weight: int) -> Array:
    """Return what a method predicts: task angles (degrees), and a weight."""
    columns = np.rad2deg(_TASKS[:, 0]), one.predict(method, _TASKS)[:, weight]
    return np.stack(columns, axis=1)


def _curve(found: list[Experiment]) -> Mark:
    """Draw the single regressions, one a step."""
    name, weight = "single regression", _weight(found)
    curves = [_points(one, name, weight) for one in found]
    return Mark("line", curves, "step", colour=COLOURS[name], width=2.0)


def _by_chart(found: list[Experiment]) -> list[Mark]:
    """Draw the regressions of charts, in the colours of these, one set a step."""
    weight = _weight(found)
    pieces: list[dict[int, Array]] = []
    for one in found:
        points = _points(one, "charts", weight)
        charts = one.methods["charts"].predict_chart(_TASKS)
        pairs = np.stack([points[:-1], points[1:]], axis=1)
        same = charts[:-1] == charts[1:]
        own = {c: pairs[same & (charts[:-1] == c)].reshape(-1, 2) for c in set(charts)}
        pieces.append(own)
    none = np.empty((0, 2))
    return [
        Mark(
            "segments",
            [own.get(chart, none) for own in pieces],
            "step",
            colour=chart_colour(chart),
            width=2.0,
        )
        for chart in sorted(set().union(*pieces))
    ]


def _weight_panel(method: str, found: list[Experiment], curves: list[Mark]) -> Panel:
    """Show a weight over the tasks: searched, trained on, predicted."""
    weight = _weight(found)
    degrees = np.rad2deg(found[0].tasks[:, 0])
    searched = np.c_[degrees, found[0].policies[:, weight]]
    trained = [searched[one.chosen] for one in found]
    span = widen(searched[:, 1], 0.15)
    marks = [
        Mark("dots", searched, colour=COLOURS["searched"], width=1.2),
        *curves,
        Mark("dots", trained, "step", colour=COLOURS[method], width=3.5),
    ]
    return Panel(
        f"One policy weight over the task angle, predicted by {method}.",
        (0, 360),
        span,
        marks,
        aspect=FLAT,
        **TASK_AXIS,
        y_label=f"policy weight {WEIGHT_NAMES[weight]}",
        y_ticks=choose_ticks(*span),
    )


def _errors_panel(steps: list[int], errors: Array, name: str) -> Panel:
    """Show mean squared errors over what the slider sets, on a logarithmic axis."""
    logs = np.log10(errors)
    low, high = float(logs.min()) - 0.2, float(logs.max()) + 0.2
    decades = range(math.ceil(low), math.floor(high) + 1)
    marks = []
    for method, column in zip(COMPARED, logs.T, strict=True):
        points, colour = np.c_[steps, column], COLOURS[method]
        marks.append(Mark("line", points, colour=colour))
        marks.append(Mark("dots", points[:, None], "step", colour=colour, width=4.5))
    margin = 0.03 * (steps[-1] - steps[0])
    return Panel(
        f"Mean squared errors of both methods over the number of {name}.",
        (steps[0] - margin, steps[-1] + margin),
        (low, high),
        marks,
        aspect=FLAT,
        x_label=name,
        y_label="mean squared error",
        x_ticks=choose_ticks(steps[0], steps[-1]),
        y_ticks=tuple(map(float, decades)),
        y_names=tuple(f"{10.0**decade:g}" for decade in decades),
    )
