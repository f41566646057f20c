"""What a run of a chapter depended on: enough to tell whether it still holds.

A run holds as long as the code cells are the same, every file that it read (see
`press._kernel`) has the content it had then, every package that it imported has the
version it had then, and so has every variable of its environment (see
`press._environment`) the value.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from press._environment import chosen
from press._kernel import digest

_NAMED = 4  # of the files that changed; the others are counted


@dataclass(frozen=True)
class Record:
    """What a run depended on, and how long it took.

    Attributes
    ----------
    code : str
        Digest of the code cells.
    files : dict of str to str
        What was read: path relative to the repository, and SHA-256.
    packages : dict of str to str
        What was imported: distribution and version; Python itself is among them.
    environment : dict of str to str
        What was chosen of the environment.
    seconds : float
        Wall time of the run, the start of its kernel included.
    """

    code: str
    files: dict[str, str]
    packages: dict[str, str]
    environment: dict[str, str]
    seconds: float

    def changes(self, code: str, root: Path) -> list[str]:
        """Say what has changed since the run.

        Parameters
        ----------
        code : str
            Digest of the code cells as they are now.
        root : Path
            The repository.

        Returns
        -------
        list of str
            One reason each; none if the run still holds.
        """
        reasons = [] if code == self.code else ["its code cells changed"]
        now = {name: digest(root / name) for name in self.files}
        changed = [name for name, content in self.files.items() if content != now[name]]
        if changed:
            more = len(changed) - _NAMED
            further = f" and {more} more" if more > 0 else ""
            reasons.append(f"{', '.join(changed[:_NAMED])}{further} changed")
        for name, version in self.packages.items():
            if (installed := version_of(name)) != version:
                reasons.append(f"{name} {version} became {installed or 'missing'}")
        present = chosen()
        for name in sorted({*present, *self.environment}):
            then, is_now = (
                one.get(name, "unset") for one in (self.environment, present)
            )
            if then != is_now:
                reasons.append(f"{name} {then} became {is_now}")
        return reasons

    def to_json(self) -> dict[str, Any]:
        """Return the record as a notebook's metadata keep it.

        Returns
        -------
        dict
            Strings, numbers and dictionaries.
        """
        return asdict(self)


def read_record(content: Mapping[str, Any]) -> Record | None:
    """Take a record out of a notebook's metadata.

    Parameters
    ----------
    content : mapping
        What `Record.to_json` returned.

    Returns
    -------
    Record or None
        None if it is no record, as in a cache of another version.
    """
    try:
        return Record(**content)
    except TypeError:
        return None


def read_log(log: Path, root: Path) -> tuple[dict[str, str], dict[str, str]]:
    """Read what a kernel wrote down.

    Parameters
    ----------
    log : Path
        The kernel's log.
    root : Path
        The repository.

    Returns
    -------
    files : dict of str to str
        Path relative to the repository, and the content's SHA-256.
    packages : dict of str to str
        Distribution and version.
    """
    files, imported = {}, set()
    for line in log.read_text(encoding="utf-8").splitlines():
        entry = json.loads(line)
        if "file" in entry:
            path = Path(os.path.relpath(entry["file"], root.resolve()))
            if not path.parts[0].endswith(".egg-info"):  # how msc is installed
                files[path.as_posix()] = entry["sha256"]
        else:
            imported |= set(_distributions().get(entry["package"], ()))
    imported = {name for name in imported if name != "msc"} | {"python"}
    return (
        dict(sorted(files.items())),
        {name: version_of(name) for name in sorted(imported, key=str.lower)},
    )


@cache
def version_of(name: str) -> str:
    """Return the version of an installed package.

    Parameters
    ----------
    name : str
        A distribution, or "python".

    Returns
    -------
    str
        The version; empty if there is none.
    """
    if name == "python":
        return platform.python_version()
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


@cache
def _distributions() -> Mapping[str, list[str]]:
    return metadata.packages_distributions()
