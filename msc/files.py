"""Files: the folder of the data, locks, writing whole or not at all, checksums."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


def find_data() -> Path:
    """Return the folder of the tables: `data` here or in a folder above, or beside msc.

    Returns
    -------
    Path
        The folder.
    """
    here = Path.cwd()
    folders = [here, *here.parents, Path(__file__).resolve().parent.parent]
    return next(
        (f / "data" for f in folders if (f / "data" / "datapackage.json").is_file()),
        folders[-1] / "data",
    )


@contextmanager
def locked(path: Path, refusal: str | None = None) -> Iterator[None]:
    """Hold a file or a folder, to the exclusion of all others that ask for it here.

    Parameters
    ----------
    path : Path
        What to hold; it has to exist. Its content may be changed, also by others who do
        not ask.
    refusal : str, optional
        What to say if another holds it; without, it is waited for.

    Raises
    ------
    ValueError
        With `refusal`, if another holds it.

    Notes
    -----
    A folder is held as it is: nothing is left in it. The lock goes with the process,
    even if that is killed, and programs that it started do not inherit it.

    Examples
    --------
    >>> with locked(Path(), "this folder is in use"), locked(Path(), "wait for it"):
    ...     pass
    Traceback (most recent call last):
    ...
    ValueError: wait for it
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (fcntl.LOCK_NB if refusal else 0))
        except BlockingIOError:
            raise ValueError(refusal) from None
        yield
    finally:
        os.close(handle)


def replace_file(path: Path, text: str) -> None:
    """Write a text file whole or not at all.

    Parameters
    ----------
    path : Path
        Where to; its folder is made if it is missing.
    text : str
        The new content.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    """Write what a command found, whole or not at all.

    Parameters
    ----------
    path : Path
        Where to; its folder is made if it is missing.
    content : object
        What JSON can tell.
    """
    replace_file(path, json.dumps(content, indent=2) + "\n")


def checksum(path: Path) -> str:
    """Identify the content of a file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    str
        ``"sha256:"`` and the digest.
    """
    return f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}"
