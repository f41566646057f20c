"""Result files: what commands found, refused once their tables are others."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd

from msc.data._tables import find_data
from press import checksum

# What makes the files whose names begin so.
_COMMANDS = {
    "study": "msc evaluate --profile full",
    "elbow": "msc evaluate --profile full",
    "audit": "msc audit data/{world}.csv --out data/results/audit_{world}.json",
    "claims": "msc claims --out data/results/claims.json --readme README.md",
    "bench": "make bench",
}


def load_results(*names: str) -> list[dict[str, Any]]:
    """Load results from the folder `data/results`.

    Parameters
    ----------
    *names : str
        Files without their ending, as "study_free", "elbow_free" or "audit_free".

    Returns
    -------
    list of dict
        Their contents, see `msc.study`, `msc.learn` and `msc.search`.

    Raises
    ------
    ValueError
        If a file is missing, or rests on other tables than those in `data`.

    Examples
    --------
    >>> free, obstacles = load_results("study_free", "study_obstacles")
    >>> obstacles["workspace"]
    'obstacles'
    """
    data = find_data()
    return [read_result(data / "results" / f"{name}.json", data) for name in names]


def read_result(path: Path, data: Path) -> Any:
    """Read one result file, or a table of policies.

    Parameters
    ----------
    path : Path
        A `.json` or a `.csv` file.
    data : Path
        The folder of the tables that it rests on.

    Returns
    -------
    dict or DataFrame
        The content.

    Raises
    ------
    ValueError
        If the file is missing, or rests on other tables than those in `data`.
    """
    kind, _, world = path.stem.partition("_")
    remake = _COMMANDS.get(kind, "make data").format(world=world)
    if not path.is_file():
        raise ValueError(f"{path.name} is not there; make it: {remake}")
    if path.suffix.lower() == ".csv":
        return pd.read_csv(path)
    found = json.loads(path.read_text(encoding="utf-8"))
    for table, digest in found.get("provenance", {}).get("data", {}).items():
        if checksum(data / table) != digest:
            raise ValueError(
                f"{path.name} rests on another {table}; make it anew: {remake}"
            )
    return found


def describe_origin(command: str, *tables: Path) -> dict[str, Any]:
    """Say what made a result, for its file.

    Parameters
    ----------
    command : str
        The command line.
    *tables : Path
        The tables that it rests on.

    Returns
    -------
    dict
        The command, and under ``"data"`` the tables' checksums by name.
    """
    return {
        "command": command,
        "data": {table.name: checksum(table) for table in tables},
    }
