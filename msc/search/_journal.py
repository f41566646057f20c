"""What a search has finished so far, kept on disk so that it can be gone on with."""

from __future__ import annotations

import hashlib
import json
from contextlib import ExitStack, suppress
from dataclasses import asdict
from pathlib import Path
from typing import IO, Any

import numpy as np

from msc.search._cmaes import CmaRun
from msc.search._policy import SearchResult
from press import locked

CODE = (
    "_checks",
    "data/_graph",
    "robot/_workspace",
    "robot/_tasks",
    "robot/_physics",
    "robot/_obstacles",
    "robot/_dmp",
    "robot/_kinematics",
    "robot/_control",
    "robot/_turns",
    "robot/_bullet",
    "robot/_mujoco",
    "robot/_arm",
    "search/_options",
    "search/_cmaes",
    "search/_lockstep",
    "search/_policy",
    "search/_sweep",
)
_SEAL = len('{"digest": "", ') + 64  # bytes that a line's digest takes


class Journal:
    """Results of a search, one line of JSON each, under a line that names the search.

    Each line has a digest of the rest of it and of the search, so that no other line is
    ever taken for one. `results` has what is done, by phase and task number.

    A file of another plan, which its `repr` identifies, or of other code is begun anew;
    what follows a line that was torn by a crash, or that this search did not write, is
    dropped with it. Without a path nothing is kept. To be used as a context manager,
    which holds the file locked and refuses one that another process has.
    """

    def __init__(self, path: Path | None, plan: object) -> None:
        self.results: dict[tuple[str, int], SearchResult] = {}
        self._path, self._held = path, ExitStack()
        self._file: IO[bytes] | None = None
        if path is None:
            return
        named = f"{plan!r} {identify_code()}".encode()
        self._header = json.dumps({"plan": hashlib.sha256(named).hexdigest()}).encode()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        refusal = (
            f"{path} is in use by another search; wait for it, stop it, or write "
            "elsewhere"
        )
        with ExitStack() as held:
            held.enter_context(locked(path, refusal))
            self._file = held.enter_context(path.open("a+b"))
            self._take_over(self._file)
            self._held = held.pop_all()

    def __enter__(self) -> Journal:
        """Return the journal itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Let the file go."""
        with suppress(OSError):  # of a line that could not be written, told before
            self._held.close()

    def append(self, phase: str, k: int, result: SearchResult) -> None:
        """Keep a result."""
        self.results[phase, k] = result
        if self._file:
            entry = {"phase": phase, "k": k, "result": asdict(result)}
            text = json.dumps(entry, default=np.ndarray.tolist).encode()
            self._write(self._file, self._seal(text[1:]))

    def _take_over(self, file: IO[bytes]) -> None:
        """Take over what the file holds of this search, and drop the rest."""
        file.seek(0)
        lines = file.read().split(b"\n")
        if lines[0] != self._header or len(lines) == 1:
            file.truncate(0)
            self._write(file, self._header)
            return
        whole = len(self._header) + 1
        for line in lines[1:-1]:
            if line != self._seal(line[_SEAL:]):
                break
            entry = json.loads(line)
            self.results[entry["phase"], entry["k"]] = _result(**entry["result"])
            whole += len(line) + 1
        file.truncate(whole)

    def _seal(self, rest: bytes) -> bytes:
        """Begin a line with the digest of its rest and of the search."""
        digest = hashlib.sha256(self._header + rest).hexdigest()
        return b'{"digest": "%b", %b' % (digest.encode(), rest)

    def _write(self, file: IO[bytes], line: bytes) -> None:
        """Append a line at once."""
        try:
            file.write(line + b"\n")
            file.flush()
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self._path)) from None


def _result(policy: Any, runs: Any, **numbers: Any) -> SearchResult:
    """Rebuild a result from its JSON."""
    if isinstance(task := numbers.get("task_deg"), list):
        numbers["task_deg"] = tuple(task)
    runs = [CmaRun(**run | {"policy": np.array(run["policy"])}) for run in runs]
    return SearchResult(policy=np.array(policy), runs=tuple(runs), **numbers)


def identify_code() -> str:
    """Identify the code that a search runs."""
    digest, package = hashlib.sha256(), Path(__file__).parents[1]
    for name in CODE:
        digest.update((package / f"{name}.py").read_bytes())
    return digest.hexdigest()
