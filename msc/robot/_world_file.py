"""A world as a file: the numbers of a `Workspace` in TOML.

    name = "mine"

    [units] # optional: mm, cm or m; deg or rad; g or kg
    length = "cm"

    [arm]
    link_lengths = [40, 35, 25]
    home = [-168.9, 40.5, 40.5]

    [goals]
    radius = 45

    [[obstacles]]
    x = -40
    y = 45
    radius = 5

    [physics]
    engine = "mujoco"

What is left out is as in ``Workspace.free()``. Further sections are ``[tasks]``, the
ranges of what tasks have besides their angle, ``[cost]``, ``[policy]`` and
``[controller]``; their keys are those of `CostWeights`, `DMP`, `ControllerGains` and
`Physics`.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np

from msc._checks import check_kind, to_floats
from msc.robot._control import ControllerGains
from msc.robot._dmp import DMP
from msc.robot._physics import Physics
from msc.robot._tasks import TASK_NUMBERS, CostWeights
from msc.robot._workspace import Workspace

_UNITS = {  # how many make one of ours
    "length": {"m": 1.0, "cm": 100.0, "mm": 1000.0},
    "angle": {"deg": 1.0, "rad": math.pi / 180},
    "mass": {"kg": 1.0, "g": 1000.0},
}
# By section and key, the field of a `Workspace` and what it is a measure of.
_FIELDS = {
    "arm": {
        "link_lengths": ("link_lengths", "length"),
        "link_masses": ("link_masses", "mass"),
        "home": ("home", "angle"),
    },
    "goals": {"radius": ("goal_radius", "length"), "cut": ("cut_deg", "angle")},
}
_TASKS = {name.rpartition("_")[0]: name for name in TASK_NUMBERS}
_PARTS: dict[str, tuple[str, Any]] = {
    "cost": ("cost", CostWeights),
    "policy": ("dmp", DMP),
    "controller": ("controller", ControllerGains),
    "physics": ("physics", Physics),
}
_SECTIONS = ("name", "units", *_FIELDS, "tasks", "obstacles", *_PARTS)
_CIRCLE = ("x", "y", "radius")


def read_world(path: str | Path) -> Workspace:
    """Read a world from a file.

    Parameters
    ----------
    path : str or Path
        A `.toml` file, as `format_world` writes it.

    Returns
    -------
    Workspace
        The world; what the file leaves out is as in ``Workspace.free()``.

    Raises
    ------
    ValueError
        If the file cannot be read or is no TOML, a section, key, unit or engine is
        unknown, or the world cannot be; it names file and field.

    Examples
    --------
    >>> read_world("elsewhere.toml")
    Traceback (most recent call last):
    ...
    ValueError: elsewhere.toml: cannot be read: No such file or directory
    """
    file = Path(path)
    try:
        return _build(tomllib.loads(file.read_text(encoding="utf-8")), file.stem)
    except OSError as error:
        raise ValueError(f"{file.name}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{file.name}: wanted TOML: {error}") from None
    except ValueError as error:
        raise ValueError(f"{file.name}: {error}") from None


def _build(told: dict[str, Any], stem: str) -> Workspace:
    """Build a workspace of what a file tells."""
    _check_keys("the file", told, _SECTIONS)
    units = _table(told, "units")
    _check_keys("[units]", units, _UNITS)
    for kind, unit in units.items():
        if not isinstance(unit, str) or unit not in _UNITS[kind]:
            raise ValueError(
                f"[units] {kind} = {unit!r} is unknown; wanted one of "
                f"{', '.join(_UNITS[kind])}"
            )

    def measured(name: str, values: Any, kind: str) -> Any:
        numbers = to_floats(name, values)
        if np.asarray(values).dtype.kind not in "iuf":  # text, or true
            raise ValueError(f"{name} = {values!r}; wanted numbers")
        return (numbers / _UNITS[kind].get(units.get(kind, ""), 1.0)).tolist()

    given: dict[str, Any] = {"name": told.get("name", stem)}
    if not isinstance(given["name"], str) or not given["name"]:
        raise ValueError(f"name = {given['name']!r}; wanted a text")
    for section, known in _FIELDS.items():
        of_section = _table(told, section)
        _check_keys(f"[{section}]", of_section, known)
        for key, value in of_section.items():
            field, kind = known[key]
            number = measured(f"[{section}] {key}", value, kind)
            given[field] = tuple(number) if isinstance(number, list) else number
    if "home" in given:
        given["home"] = tuple(np.deg2rad(given["home"]).tolist())
    given["circles"] = tuple(
        _read_obstacle(one, number, measured)
        for number, one in enumerate(_listed(told, "obstacles"), start=1)
    )
    ranges = _table(told, "tasks")
    _check_keys("[tasks]", ranges, _TASKS)
    given["further"] = tuple(
        (name, *_pair(measured(f"[tasks] {key}", ranges[key], _kind(name)), key))
        for key, name in _TASKS.items()
        if key in ranges
    )
    for section, (field, kind) in _PARTS.items():
        of_section = _table(told, section)
        _check_keys(f"[{section}]", of_section, [one.name for one in fields(kind)])
        if of_section:
            given[field] = _part(section, kind, of_section)
    return Workspace(**given)


def _part(section: str, kind: Any, values: Mapping[str, Any]) -> Any:
    """Build a part of a world, its section named if it cannot be."""
    plain = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    try:
        return kind(**plain)
    except ValueError as error:
        raise ValueError(f"[{section}] {error}") from None


def _kind(name: str) -> str:
    """Tell what a task number is a measure of."""
    return "length" if name.endswith("_m") else "angle"


def _pair(values: Any, key: str) -> list[float]:
    """Refuse what is no range."""
    if not isinstance(values, list) or len(values) != 2:
        raise ValueError(f"[tasks] {key} = {values}; wanted two numbers, low and high")
    return values


def _table(told: Mapping[str, Any], section: str) -> dict[str, Any]:
    """Return a section, empty if it is not there."""
    found = told.get(section, {})
    if not isinstance(found, dict):
        raise ValueError(f"{section} = {found!r}; wanted a section, [{section}]")
    return found


def _listed(told: Mapping[str, Any], section: str) -> list[dict[str, Any]]:
    """Return sections of one name, none if there are none."""
    found = told.get(section, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise ValueError(f"{section}: wanted sections, one [[{section}]] each")
    return found


def _read_obstacle(
    one: Mapping[str, Any], number: int, measured: Any
) -> tuple[float, ...]:
    """Read an obstacle."""
    where = f"[[obstacles]] {number}"
    _check_keys(where, one, _CIRCLE)
    if missing := [key for key in _CIRCLE if key not in one]:
        raise ValueError(f"{where} lacks {', '.join(missing)}")
    return tuple(measured(f"{where} {key}", one[key], "length") for key in _CIRCLE)


def _check_keys(where: str, given: Mapping[str, Any], known: Any) -> None:
    """Refuse a key that is unknown, and guess what was meant."""
    for key in given:
        if key not in known:
            close = get_close_matches(key, [*known]) or [*known]
            raise ValueError(
                f"{where} has an unknown key {key!r}; wanted {' or '.join(close)}"
            )


def format_world(workspace: Workspace, comment: str = "") -> str:
    """Write a world down, as `read_world` reads it.

    Parameters
    ----------
    workspace : Workspace
        The world.
    comment : str, optional
        What the file says first.

    Returns
    -------
    str
        TOML, in metres, kilograms and degrees: what is not as in ``Workspace.free()``.

    Raises
    ------
    TypeError
        If `workspace` is none.

    Notes
    -----
    What is read back is the same world to the bit, but for a home pose of angles that
    no number of degrees gives exactly: they are off by their last digit.

    Examples
    --------
    >>> print(format_world(Workspace(goal_radius=0.4, cut_deg=60.0)))
    name = "free"
    <BLANKLINE>
    [goals]
    radius = 0.4
    cut = 60.0
    <BLANKLINE>
    """
    check_kind("workspace", workspace, Workspace)
    usual, lines = Workspace.free(), [f"# {line}" for line in comment.splitlines()]
    lines.append(f"name = {_toml(workspace.name)}")
    sections: dict[str, dict[str, Any]] = {}
    for section, known in _FIELDS.items():
        told, as_usual = (
            {key: getattr(world, field) for key, (field, _) in known.items()}
            for world in (workspace, usual)
        )
        sections[section] = _changed(told, as_usual)
    if "home" in sections["arm"]:
        sections["arm"]["home"] = [_degrees(angle) for angle in workspace.home]
    sections["tasks"] = {n.rpartition("_")[0]: ends for n, *ends in workspace.further}
    for section, (field, kind) in _PARTS.items():
        part = asdict(getattr(workspace, field))
        sections[section] = _changed(part, asdict(kind()))
    for section, values in sections.items():
        if values:
            lines += ["", f"[{section}]"]
            lines += [f"{key} = {_toml(value)}" for key, value in values.items()]
    for circle in workspace.circles:
        lines += ["", "[[obstacles]]"]
        lines += [f"{key} = {_toml(v)}" for key, v in circle._asdict().items()]
    return "\n".join(lines) + "\n"


def _changed(values: dict[str, Any], usual: dict[str, Any]) -> dict[str, Any]:
    """Keep the values that are not as usual."""
    return {key: value for key, value in values.items() if value != usual[key]}


def _degrees(angle: float) -> float:
    """Return the shortest number of degrees that is read as this angle (rad)."""
    exact = math.degrees(angle)
    short = (round(exact, digits) for digits in range(15))
    return next((one for one in short if np.deg2rad(one) == angle), exact)


def _toml(value: Any) -> str:
    """Write a value in TOML."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):  # JSON's, but for one sign
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(np.asarray(value).item()).replace("Infinity", "inf")
