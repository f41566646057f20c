"""Tables of anybody's: which columns, in which units, and what is amiss with them."""

from __future__ import annotations

import difflib
import hashlib
import io
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pandas.errors import ParserWarning

from msc._checks import check_magnitude

UNITS = (
    *("deg", "rad", "turn", "m", "cm", "mm", "km", "in", "s", "ms", "min", "h", "Hz"),
    *("kg", "g", "N", "kN", "Nm", "J", "W", "V", "A", "Pa", "K", "degC", "%", "1"),
    *("m/s", "m/s2", "rad/s", "rad/s2", "deg/s", "deg/s2", "N/m", "kg/m3", "px"),
)
"""Units that a column may be said to have; "1" is none."""

LEAST_TASKS = 10
"""Different tasks that a table needs: as many blocks of them are told apart."""

_SHOWN = 5  # rows that a sentence names
_COMMA = re.compile(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*")


@dataclass(frozen=True)
class Table:
    """Solved tasks, a row each.

    Attributes
    ----------
    tasks, policies : DataFrame
        Columns of numbers.
    cost : ndarray of shape (n_rows,), optional
        What was paid for each.
    units : dict of str to str
        Of the columns for which one was told.
    periods : dict of str to float
        Of the task columns that come round again.
    name : str
        Name of the file.
    sha256 : str
        Of its bytes.
    notes : tuple of str
        What was remarkable about how it is written.
    """

    tasks: pd.DataFrame
    policies: pd.DataFrame
    cost: np.ndarray | None = None
    units: dict[str, str] = field(default_factory=dict)
    periods: dict[str, float] = field(default_factory=dict)
    name: str = "table"
    sha256: str = ""
    notes: tuple[str, ...] = ()

    @property
    def copies(self) -> np.ndarray:
        """Number of the task of each row, equal for equal tasks."""
        return self.tasks.groupby([*self.tasks], sort=False).ngroup().to_numpy()


def read_table(
    path: Path,
    tasks: Sequence[str],
    policies: Sequence[str],
    *,
    cost: str | None = None,
    units: Mapping[str, str] | None = None,
    periods: Mapping[str, float] | None = None,
) -> Table:
    """Read solved tasks from a file, or say in a sentence what is amiss.

    Parameters
    ----------
    path : Path
        CSV, or Parquet if its name ends so. Semicolons or tabs may stand between
        columns, and decimal commas in numbers then; a byte-order mark is skipped.
    tasks, policies : sequence of str
        Names of the task columns and of the policy columns.
    cost : str, optional
        Name of the column that says what was paid for each.
    units : mapping of str to str, optional
        Units of columns, some of `UNITS`.
    periods : mapping of str to float, optional
        After which task columns come round again.

    Returns
    -------
    Table
        The columns.

    Raises
    ------
    ValueError
        If the file is no table, a column is unknown, named twice or has anything but
        finite numbers, a unit is unknown, tasks or policies are constant, or there are
        fewer than ten different tasks.
    """
    frame, content, notes = _read(path)
    wanted = [*tasks, *policies, *([cost] if cost else [])]
    twice = sorted({name for name in wanted if wanted.count(name) > 1})
    if twice:
        raise ValueError(
            f"{twice[0]!r} is named twice among tasks, policies and cost; wanted each "
            "column in one place"
        )
    frame = pick_columns(frame, wanted, path.name)
    for what, given in (("units", units or {}), ("period", periods or {})):
        for name in given:
            if what == "units":
                _check_known(what, name, wanted)
            else:
                _check_known(what, name, tasks, "task column")
    check_units(units or {})
    for name, period in (periods or {}).items():
        if not 0 < period < np.inf:
            raise ValueError(f"period of {name!r} is {period:g}; wanted it positive")
    constant = [name for name in tasks if _is_constant(frame[name])]
    if constant:
        raise ValueError(
            f"task column {constant[0]!r} of {path.name} is constant: there is nothing "
            "to learn from it; wanted it left out"
        )
    if all(_is_constant(frame[name]) for name in policies):
        raise ValueError(
            f"the policy columns of {path.name} are constant: one policy serves all "
            "tasks, and there is nothing to learn"
        )
    costs = None if cost is None else frame[cost].to_numpy()
    if costs is not None and not (costs > 0).all():
        row = int(np.argmin(costs > 0)) + 1
        raise ValueError(
            f"cost {cost!r} is {costs[row - 1]:g} in row {row} of {path.name}; wanted "
            "it positive"
        )
    table = Table(
        frame[[*tasks]],
        frame[[*policies]],
        costs,
        dict(units or {}),
        {name: float(period) for name, period in (periods or {}).items()},
        path.name,
        hashlib.sha256(content).hexdigest(),
        tuple(notes),
    )
    n_different = int(table.copies.max()) + 1
    if n_different < LEAST_TASKS:
        raise ValueError(
            f"{path.name} has {n_different} different tasks in {len(frame)} rows; "
            f"wanted at least {LEAST_TASKS}"
        )
    return table


def read_columns(path: Path, names: Sequence[str]) -> pd.DataFrame:
    """Read some columns of a file, all finite numbers; errors as of `read_table`."""
    frame, _, _ = _read(path)
    return pick_columns(frame, names, path.name)


def read_pairs(option: str, pairs: Sequence[str]) -> dict[str, str]:
    """Read what is said of columns.

    Parameters
    ----------
    option : str
        Where it is said.
    pairs : sequence of str
        Each ``"COLUMN=VALUE"``; of several signs of equality the last one counts.

    Returns
    -------
    dict of str to str
        Values by column.

    Raises
    ------
    ValueError
        If one is no pair, or a column comes twice.

    Examples
    --------
    >>> read_pairs("units", ["angle=deg", "mass=kg"])
    {'angle': 'deg', 'mass': 'kg'}
    """
    found: dict[str, str] = {}
    for pair in pairs:
        name, sign, value = pair.rpartition("=")
        if not (sign and name and value):
            raise ValueError(f"{option}={pair!r}; wanted COLUMN=VALUE")
        if name in found:
            raise ValueError(f"{option}: {name!r} comes twice; wanted it once")
        found[name] = value
    return found


def check_units(units: Mapping[str, str]) -> None:
    """Refuse units that are unknown."""
    for name, unit in units.items():
        if unit not in UNITS:
            raise ValueError(
                f"unit {unit!r} of {name!r} is unknown{_nearest(unit, UNITS)}; wanted "
                f"one of {', '.join(UNITS)}"
            )


def pick_columns(frame: pd.DataFrame, names: Sequence[str], table: str) -> pd.DataFrame:
    """Return columns as floats, or say what is amiss with the first that is none."""
    columns = (column for _, column in frame.items())
    if not any(pd.to_numeric(column, "coerce").notna().any() for column in columns):
        raise ValueError(f"{table} has no column of numbers")
    return pd.DataFrame({name: _numbers(frame, name, table) for name in names})


def _numbers(frame: pd.DataFrame, name: str, table: str) -> np.ndarray:
    """Return a column's numbers, all finite, of which squares are, too."""
    _check_known(table, name, [*frame])
    if (n_times := [*frame].count(name)) > 1:
        raise ValueError(
            f"{table} has {n_times} columns {name!r}; wanted names that differ"
        )
    column = frame[name]
    if column.dtype.kind in "mM":
        raise ValueError(f"{name!r} of {table} holds dates or times; wanted numbers")
    is_blank = column.isna().to_numpy()
    numbers = pd.to_numeric(column, "coerce").to_numpy(dtype=float, na_value=np.nan)
    if (other := np.isnan(numbers) & ~is_blank).any():
        row = int(np.argmax(other))
        word = str(column.iloc[row])
        hint = ""
        if _COMMA.fullmatch(word):
            hint = " (for decimal commas, separate columns by semicolons)"
        raise ValueError(
            f"{name!r} of {table} is {word!r} in row {row + 1}; wanted a number{hint}"
        )
    if (bad := ~np.isfinite(numbers)).any():
        rows = np.flatnonzero(bad) + 1
        told = ", ".join(map(str, rows[:_SHOWN]))
        more = f" and {len(rows) - _SHOWN} more" if len(rows) > _SHOWN else ""
        which = "row" if len(rows) == 1 else "rows"
        raise ValueError(
            f"{name!r} of {table} is blank or not finite in {which} {told}{more}; "
            "wanted a number, or the row left out"
        )
    check_magnitude(f"{name!r} of {table}", numbers)
    return numbers


def _check_known(
    where: str, name: str, known: Sequence[str], what: str = "column"
) -> None:
    """Refuse a column that is not there, and name the nearest one."""
    if name not in known:
        listed = ", ".join(repr(one) for one in known)
        raise ValueError(
            f"{where}: there is no {what} {name!r}{_nearest(name, known)}; wanted one "
            f"of {listed}"
        )


def _nearest(word: str, known: Sequence[str]) -> str:
    """Ask for the known word that is most like one."""
    lowered = {one.lower(): one for one in reversed(known)}
    like = difflib.get_close_matches(word.lower(), [*lowered], 1, 0.5)
    return f" (did you mean {lowered[like[0]]!r}?)" if like else ""


def _is_constant(column: pd.Series) -> bool:
    """Whether a column does not vary, but for rounding."""
    values = column.to_numpy()
    return bool(np.ptp(values) <= 1e-12 * np.abs(values).max())


def _read(path: Path) -> tuple[pd.DataFrame, bytes, list[str]]:
    """Read all of a file; return its bytes, too, and what is to be told of it."""
    content = path.read_bytes()
    if path.suffix.lower() in (".parquet", ".pq"):
        try:
            frame = pd.read_parquet(io.BytesIO(content))
        except ImportError:
            raise ValueError(
                f"{path.name} is Parquet, for which pandas needs an engine: pip "
                "install pyarrow, or write the table as CSV"
            ) from None
        except Exception as error:  # whatever an engine makes of the file
            raise ValueError(f"{path.name} is no Parquet: {error}") from None
        return frame.rename(columns=str), content, []
    notes = []
    if content.startswith(b"\xef\xbb\xbf"):
        notes.append("it begins with a byte-order mark, which is skipped")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(
            f"{path.name} is not UTF-8; wanted a CSV file that is"
        ) from None
    if "\0" in text:
        raise ValueError(f"{path.name} has bytes of zero; wanted a CSV file") from None
    separator, decimal = _dialect(text)
    if separator != ",":
        what = {";": "semicolons", "\t": "tabs"}[separator]
        notes.append(f"{what} stand between its columns")
    if decimal == ",":
        notes.append("its numbers have decimal commas")
    form: Any = {"sep": separator, "skipinitialspace": True, "index_col": False}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", ParserWarning)  # rows longer than the header
            frame = pd.read_csv(
                io.StringIO(text), decimal=decimal, low_memory=False, **form
            )
        header = pd.read_csv(
            io.StringIO(text), header=None, nrows=1, dtype=str, na_filter=False, **form
        )
    except (ValueError, ParserWarning) as error:
        words = " ".join(str(error).split())
        raise ValueError(f"{path.name} is no table: {words}") from None
    # As they are written: pandas numbers names that come again, and blank ones.
    frame.columns = [
        given.strip() or name
        for given, name in zip(header.iloc[0], frame.columns, strict=True)
    ]
    return frame, content, notes


def _dialect(text: str) -> tuple[str, str]:
    """Guess what stands between columns, and before decimals, from the first lines."""
    header, *lines = text[:20_000].splitlines() or [""]
    separator = max(",;\t", key=header.count)
    cells = [cell.strip('" ') for line in lines[:50] for cell in line.split(separator)]
    has_commas = separator != "," and any(map(_COMMA.fullmatch, cells))
    return separator, "," if has_commas else "."
