"""Tables of searched policies, and files of results that rest on them.

A folder of tables carries a `datapackage.json` (Frictionless Data Package): columns and
units, the command that made each table, its seed, the package versions and a SHA-256.
"""

from __future__ import annotations

import hashlib
import json
import platform
import re
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from msc._checks import LARGEST
from msc.robot import TASK_NUMBERS, Workspace, read_world
from press import checksum, locked, replace_files


def name_weights(n_params: int) -> tuple[str, ...]:
    """Name the columns of a policy.

    Parameters
    ----------
    n_params : int
        Length of a policy.

    Returns
    -------
    tuple of str
        The weights of x, then those of y.

    Examples
    --------
    >>> name_weights(4)
    ('weight_x1', 'weight_x2', 'weight_y1', 'weight_y2')
    """
    numbers = range(1, n_params // 2 + 1)
    return tuple(f"weight_{axis}{number}" for axis in "xy" for number in numbers)


WEIGHTS = name_weights(6)

COLUMNS: dict[str, tuple[str, str]] = {
    "task_deg": ("number", "Task angle, counted from the cut (degrees)"),
    **dict.fromkeys(WEIGHTS, ("number", "Weight of Eq. 7: an entry of the policy")),
    "distance_m": ("number", "Final distance of end effector and target (m)"),
    "energy_rad2_per_s": ("number", "Integral of the squared joint velocity (rad²/s)"),
    "cost": ("number", "100/m² · distance² + 0.005 s/rad² · energy"),
    "cost_distance": ("number", "First term of the cost"),
    "cost_energy": ("number", "Second term of the cost"),
    "contact_impulse_n_s": ("number", "Normal force of contacts over time (N s)"),
    "evaluations": ("integer", "Rollouts that the search took"),
    "starts": ("integer", "Runs of CMA-ES"),
    "starts_agreeing": (
        "integer",
        "Runs that ended within 1 % of the policy, or were stopped within 5 % of it",
    ),
    "margin": (
        "number",
        "Cost of the best run that ended elsewhere, over this one; empty if none did",
    ),
    "winner": ("string", "Run that found the policy: a start, or from a neighbour's"),
    "seed": ("integer", "Seed of the search"),
}

_FURTHER: dict[str, tuple[str, str]] = {
    name: ("number", f"Of the task: {what} ({name.rpartition('_')[2]})")
    for name, what in TASK_NUMBERS.items()
}

PACKAGE = "datapackage.json"
_SEPARATORS = {
    ",": "commas",
    ";": "semicolons",
    "\t": "tabs",
    "|": "pipes",
    " ": "spaces",
}
WORLDS = "worlds"  # a folder beside the tables
_NAME = re.compile(r"[\w-]+")
_NAMED = ("free", "obstacles", "free_test", "obstacles_test")
_PACKAGES = ("msc", "numpy", "scipy", "cma", "pybullet")

# What makes the files whose names begin so.
_COMMANDS = {
    "study": "msc evaluate --profile full",
    "elbow": "msc evaluate --profile full",
    "jumps": "msc worlds jumps {workspace}",
    "audit": "msc audit data/{workspace}.csv --out data/results/audit_{workspace}.json",
    "claims": "msc claims --out data/results/claims.json --readme README.md",
    "bench": "make bench",
    "coverage": "python benchmarks/coverage.py",
}


def find_data() -> Path:
    """Find the folder of the tables.

    Returns
    -------
    Path
        `data` in this folder or in the nearest one above that has it, or beside msc.
    """
    beside = Path(__file__).resolve().parents[2] / "data"
    folders = [folder / "data" for folder in (Path.cwd(), *Path.cwd().parents)]
    return next((data for data in folders if (data / PACKAGE).is_file()), beside)


def find_world(name: str | Path) -> Workspace:
    """Find a world by its name.

    Parameters
    ----------
    name : str or Path
        "free", "obstacles", one of `data/worlds`, or a path to a world's file.

    Returns
    -------
    Workspace
        The world.

    Raises
    ------
    ValueError
        If there is none, or it cannot be.

    Examples
    --------
    >>> find_world("obstacles") == Workspace.obstacles()
    True
    """
    if Path(name).suffix == ".toml":
        return read_world(name)
    file = find_data() / WORLDS / f"{name}.toml"
    if _NAME.fullmatch(str(name)) and file.is_file():
        return read_world(file)
    try:
        return Workspace.named(str(name))
    except ValueError as error:
        raise ValueError(
            f"{error}, one of {WORLDS} in the folder of the data, or a .toml file"
        ) from None


def find_table(name: str | Path) -> Path:
    """Find a table by its name.

    Parameters
    ----------
    name : str or Path
        "free", "obstacles", "free_test" or "obstacles_test", or a table of a world in
        `data/worlds`, as text or as a path that is no more than that; or a path to a
        table.

    Returns
    -------
    Path
        The table: of a known name that of `find_data`, whether it is there or not.

    Examples
    --------
    >>> find_table("free") == find_table(Path("free")) == find_data() / "free.csv"
    True
    >>> find_table("elsewhere/free.csv")
    PosixPath('elsewhere/free.csv')
    """
    if str(name) in _NAMED:
        return find_data() / f"{name}.csv"
    if _NAME.fullmatch(str(name)):
        of_world = find_data() / WORLDS / f"{name}.csv"
        if of_world.is_file() or of_world.with_name(_world_of(of_world)).is_file():
            return of_world
    return Path(name)


def _world_of(table: Path) -> str:
    """Return the name of the file of a table's world."""
    return f"{table.stem.removesuffix('_test')}.toml"


class Dataset(NamedTuple):
    """Searched policies, as ``tasks, policies, table``.

    Attributes
    ----------
    tasks : ndarray of shape (n_tasks, n_numbers)
        Task angles in radians, counted from the cut: in [0, 2π), ascending; further
        numbers of a task in metres and radians.
    policies : ndarray of shape (n_tasks, n_params)
        Their policies.
    table : DataFrame
        All columns, in degrees and metres.
    """

    tasks: NDArray[np.float64]
    policies: NDArray[np.float64]
    table: pd.DataFrame

    @property
    def task_deg(self) -> NDArray[np.float64]:
        """Task angles in degrees, exactly as in the table, of shape (n_tasks,)."""
        return self.table["task_deg"].to_numpy()


def load_dataset(name: str | Path) -> Dataset:
    """Load searched policies.

    Parameters
    ----------
    name : str or Path
        "free", "obstacles", "free_test" or "obstacles_test", looked up in the folder
        `data` of the current directory or of the repository; or a path to a table.

    Returns
    -------
    Dataset
        A named tuple of tasks (radians), policies and the whole table; its `task_deg`
        are the tasks in degrees, exactly as in the table.

    Raises
    ------
    ValueError
        If the file is missing, lacks a column, has duplicate tasks, tasks outside [0°,
        360°) or NaN, is not separated by commas, or no longer has the checksum that its
        data package states.

    Examples
    --------
    >>> tasks, policies, table = load_dataset("free")
    >>> tasks.shape[1], policies.shape[1]
    (1, 6)
    """
    path = find_table(name)
    if not path.is_file():
        raise ValueError(
            f"dataset {str(name)!r} is not there; wanted one of {', '.join(_NAMED)} or "
            "a path to a table"
        )
    _verify(path)
    try:
        table = _read(path)
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None
    names = _task_columns(table)
    table = table.sort_values(names, ignore_index=True)
    tasks = table[names].to_numpy()
    is_angle = [one.endswith("_deg") for one in names]
    tasks = np.where(is_angle, np.deg2rad(tasks), tasks)
    return Dataset(tasks, table[_weight_columns(table)].to_numpy(), table)


def _task_columns(table: pd.DataFrame) -> list[str]:
    """Name a table's columns of tasks."""
    return ["task_deg", *(name for name in _FURTHER if name in table)]


def _weight_columns(table: pd.DataFrame) -> list[str]:
    """Name a table's columns of policies."""
    n_params = sum(str(name).startswith("weight_") for name in table)
    return list(name_weights(n_params))


def _columns(table: pd.DataFrame) -> dict[str, tuple[str, str]]:
    """Describe a table's columns: those of any table, with its tasks and weights."""
    tasks = {name: (COLUMNS | _FURTHER)[name] for name in _task_columns(table)}
    weights = dict.fromkeys(_weight_columns(table), COLUMNS[WEIGHTS[0]])
    others = {k: v for k, v in COLUMNS.items() if k not in WEIGHTS}
    return tasks | weights | others


def _read(path: Path) -> pd.DataFrame:
    """Read a table, or say what is wrong with it."""
    try:
        table = pd.read_csv(path, skipinitialspace=True)
        table.columns = table.columns.astype(str).str.strip()
        wanted = {**COLUMNS, **_columns(table)}
        if not {*WEIGHTS} <= {*table} and {*_weight_columns(table)} <= {*table}:
            wanted = _columns(table)  # fewer weights than usual
        missing = [column for column in wanted if column not in table]
        if missing:
            found = ", ".join(map(repr, table.columns[:3]))
            raise ValueError(
                f"columns missing: {', '.join(missing)}; the first ones are {found}"
            )
    except ValueError as error:
        raise ValueError(_foreign(path) or error) from None
    twice = table.columns[table.columns.duplicated()]
    if len(twice):
        raise ValueError(f"columns given twice: {', '.join(twice)}")
    if not isinstance(table.index, pd.RangeIndex):
        raise ValueError(
            "rows hold more values than there are columns; wanted as many, and "
            "decimal points, not commas"
        )
    if table.empty:
        raise ValueError("no rows; wanted at least one task")
    for name, (kind, _) in _columns(table).items():
        if kind != "string":
            table[name] = _numbers(name, kind, table[name])
    tasks, again = table["task_deg"], table.duplicated(_task_columns(table))
    if again.any():
        raise ValueError(f"duplicate tasks at task_deg={tasks[again].tolist()}")
    beyond = tasks[~tasks.between(0, 360, "left")].tolist()
    if beyond:
        raise ValueError(
            f"tasks outside the turn at task_deg={beyond}; wanted angles from 0 to "
            "below 360"
        )
    return table


def _numbers(name: str, kind: str, column: pd.Series) -> pd.Series:
    """Return a column of numbers as such, or say what is none, where."""
    values = pd.to_numeric(column, errors="coerce")
    wrong = (values.isna() & column.notna()).to_numpy()
    if column.dtype == bool or wrong.any():
        row = int(wrong.argmax())
        said = str(column.iloc[row])
        commas = "; wanted decimal points, no commas" if "," in said else ""
        raise ValueError(f"wanted numbers: {name} in row {row + 1} is {said!r}{commas}")
    if not np.isfinite(values.fillna(0.0) if name == "margin" else values).all():
        raise ValueError(f"NaN or infinite values in {name}")
    largest = values.abs().max()
    if name.startswith("weight_") and largest > LARGEST:
        raise ValueError(f"{name} reaches {largest:g}; wanted at most {LARGEST:g}")
    if kind == "integer" and (values % 1 != 0).any():
        raise ValueError(f"{name} holds fractions; wanted whole numbers")
    return values


def save_table(
    table: pd.DataFrame, path: Path, *, command: str, seed: int, **extra: Any
) -> None:
    """Write a table, and what it is into the data package beside it.

    Parameters
    ----------
    table : DataFrame
        Rows with the columns of `COLUMNS`.
    path : Path
        Where to, a `.csv` file.
    command : str
        The command line that makes it.
    seed : int
        The seed of that command.
    **extra : dict
        Further facts for the data package.

    Raises
    ------
    ValueError
        If the data package that is there is broken.
    OSError
        If one of the two cannot be written; both are then left as they were.
    """
    columns = _columns(table)
    text = table[list(columns)].to_csv(index=False, lineterminator="\n")
    content = text.encode()
    versions = {name: metadata.version(name) for name in _PACKAGES}
    fields = [
        {"name": name, "type": kind, "description": description}
        for name, (kind, description) in columns.items()
    ]
    resource = {
        "name": path.stem.replace("_", "-"),
        "path": path.name,
        "profile": "tabular-data-resource",
        "format": "csv",
        "encoding": "utf-8",
        "bytes": len(content),
        "hash": f"sha256:{hashlib.sha256(content).hexdigest()}",
        "command": command,
        "seed": seed,
        **extra,
        "versions": {"python": platform.python_version()} | versions,
        "schema": {"fields": fields, "primaryKey": _task_columns(table)},
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with locked(path.parent):  # another search may end in this folder
        package = read_package(path.parent)
        others = [one for one in package["resources"] if one["path"] != path.name]
        package["resources"] = sorted([*others, resource], key=lambda one: one["path"])
        described = json.dumps(package, indent=2, ensure_ascii=False) + "\n"
        replace_files({path: text, path.parent / PACKAGE: described})


def read_package(folder: Path) -> dict[str, Any]:
    """Read the data package of a folder of tables.

    Parameters
    ----------
    folder : Path
        The folder.

    Returns
    -------
    dict
        What it says; a package without tables if there is none.

    Raises
    ------
    ValueError
        If the file is not what a data package should be, or cannot be read.
    """
    file = folder / PACKAGE
    if not file.exists():
        licences = [{"name": "CC0-1.0"}]
        return {"name": "msc-policies", "licenses": licences, "resources": []}
    try:
        package = json.loads(file.read_text(encoding="utf-8"))
        json.dumps(package, ensure_ascii=False).encode()  # as it is to be written again
    except OSError as error:
        raise ValueError(f"{file}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise ValueError(
            f"{file}: wanted a data package, which is JSON in UTF-8: {error}; mend it "
            "or remove it"
        ) from None
    listed = package.get("resources") if isinstance(package, dict) else None
    if not isinstance(listed, list) or not all(
        isinstance(one, dict) and isinstance(one.get("path"), str) for one in listed
    ):
        raise ValueError(
            f"{file}: wanted a data package, an object whose `resources` is a list of "
            "objects with a `path` each; mend it or remove it"
        )
    return dict(package)


def _foreign(path: Path) -> str:
    """Say what separates a table's columns, if it is not commas."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        return f"wanted a table in UTF-8: {error}"
    first = next((line for line in lines if line.strip()), "")

    def n_columns(separator: str) -> int:
        return sum(name.strip(" \"'") in COLUMNS for name in first.split(separator))

    says = re.fullmatch(r"\"?sep=(.?)\"?,*", first.strip(" "), re.IGNORECASE)
    signs = dict.fromkeys([*_SEPARATORS, *re.findall(r"[^\w\"']", first)])
    separator = says[1] or "\t" if says else max(signs, key=n_columns)
    wanted = "commas, decimal points and nothing before the names of the columns"
    if separator == ",":
        if not says:
            return ""
        wanted = "the names of the columns there"
    also = f" and the first line is {first!r}" if says else ""
    name = _SEPARATORS.get(separator, repr(separator))
    return f"columns are separated by {name}{also}; wanted {wanted}"


def _verify(path: Path) -> None:
    """Compare a table with the checksum in the data package beside it, if any."""
    known = {one["path"]: one for one in read_package(path.parent)["resources"]}
    if not (resource := known.get(path.name)):
        return
    found, stated = checksum(path), resource.get("hash")
    if found == stated:
        return
    command = resource.get("command")
    package = f"{str(stated)[7:19]}…" if stated else "none"
    remake = f", or remake it: {command}" if command else ""
    raise ValueError(
        f"{path.name}: checksum {found[7:19]}… differs from the data package's "
        f"{package}; restore the file{remake}"
    )


def load_results(*names: str) -> list[dict[str, Any]]:
    """Load results from the folder `data/results`, each as `read_result` does.

    Parameters
    ----------
    *names : str
        Files without their ending, as "study_free", "elbow_free" or "audit_free".

    Returns
    -------
    list of dict
        Their contents, see `msc.study`.

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
    kind, _, workspace = path.stem.partition("_")
    remake = _COMMANDS.get(kind, "make data").format(workspace=workspace)
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
        The tables that it rests on, in the folder of the data or that of worlds in it.

    Returns
    -------
    dict
        The command, and under ``"data"`` the tables' checksums by name.
    """
    of_world = f"{WORLDS}/"
    return {
        "command": command,
        "data": {
            f"{of_world if one.parent.name == WORLDS else ''}{one.name}": checksum(one)
            for one in tables
        },
    }
