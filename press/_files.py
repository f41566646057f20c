"""Files: locks, writing whole or not at all, checksums."""

import fcntl
import hashlib
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any


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


def replace_file(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all.

    Parameters
    ----------
    path : Path
        Where to; its folder is made if it is missing.
    content : str or bytes
        The new content.

    Raises
    ------
    OSError
        If it cannot be written; what was there is left intact.
    """
    replace_files({path: content})


def replace_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write files that belong together: all of them, whole, or none.

    Parameters
    ----------
    contents : mapping of Path to str or bytes
        Where to, and the new content; folders are made if they are missing.

    Raises
    ------
    OSError
        If one cannot be written; what was there is left intact.
    """
    written: dict[Path, Path] = {}
    try:
        for path, content in contents.items():
            with _naming(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                handle, name = tempfile.mkstemp(
                    dir=path.parent, prefix=f".{path.name}."
                )
                written[path] = Path(name)
                raw = content if isinstance(content, bytes) else content.encode()
                with os.fdopen(handle, "wb") as file:
                    file.write(raw)
                    file.flush()
                    os.fsync(file.fileno())
                written[path].chmod(0o644)
        for path, whole in written.items():
            with _naming(path):
                whole.replace(path)
    finally:
        for whole in written.values():
            whole.unlink(missing_ok=True)


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Have errors of the system name the file that was to be written."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from None


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
