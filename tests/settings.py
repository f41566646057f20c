"""Legal settings of the chapters, drawn from what the chapters declare."""

import random
import re
from pathlib import Path

from press._notebook import parameters, read_notebook
from press._parameters import check

BOOK = Path(__file__).parents[1] / "book"
CHAPTERS = {path.stem: path for path in sorted(BOOK.glob("*.ipynb"))}
DECLARED = {
    name: found
    for name, path in CHAPTERS.items()
    if (found := parameters(read_notebook(path)))
}
ANGLES = (0, 360, -5, 359.9, 360 - 1e-9, 725.5, -1e-20, 180, 300.0)

ONCE_DIED = [  # the first three are quick
    ("method_arm", {"weight": 3}),
    ("method_charts", {"n_charts": None}),
    ("method_skill", {"n_samples": 8, "n_charts": 8}),
    ("method_arm", {"task_deg": 300.0}),
    ("method_arm", {"strength": 1.0}),
    ("method_charts", {"n_charts": 8}),
    ("method_skill", {"n_charts": 1}),
    ("method_search", {"task_deg": 359.9}),
    ("method_search", {"task_deg": 0.0}),  # given as 360
    ("method_search", {"task_deg": 355.0}),  # given as -5
    # half-way between two tasks, where charts meet
    ("method_skill", {"n_samples": 72, "n_charts": 6, "task_deg": 147.5}),
]


def draw_settings(n_settings, seed):
    """Draw legal settings, of each chapter in turn; half of all values are extreme."""
    draw = random.Random(seed)
    settings = []
    while len(settings) < n_settings:
        name = [*DECLARED][len(settings) % len(DECLARED)]
        values = {key: _draw(one, draw) for key, one in DECLARED[name].items()}
        values["profile"] = "full" if draw.random() < 0.1 else "quick"
        try:
            settings.append((name, check(DECLARED[name], values)))
        except ValueError as error:
            if "at most" not in str(error):  # else the next one
                raise
    return settings


def _draw(one, draw):
    """Draw a value from those that a parameter may take."""
    is_extreme = draw.random() < 0.5
    if one.values.endswith("or None") and draw.random() < 0.2:
        return None
    if one.values.startswith("any number"):
        return draw.choice(ANGLES) if is_extreme else draw.uniform(-400, 800)
    if not (bounds := re.match(r"(\S+) to ([\d.]+)", one.values)):
        return draw.choice(re.findall(r'"([^"]*)"', one.values))
    low, high = map(float, bounds.groups())
    if is_extreme:
        value = draw.choice([low, high])
    else:  # as many small ones as large
        value = (low + 1) * ((high + 1) / (low + 1)) ** draw.random() - 1
    return round(value) if one.default.isdigit() else value
