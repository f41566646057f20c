"""What a search has finished so far, kept on disk so that it can be gone on with."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from msc.search import SearchResult, Start

_CODE = ("workspace", "dmp", "kinematics", "bullet", "arm", "search", "dataset")


class Journal:
    """Results of a search, one line of JSON each, under a line that names the search.

    Parameters
    ----------
    path : Path or None
        The file; None keeps nothing. One that belongs to another plan, or to other
        code, is begun anew; a last line torn by a crash is dropped.
    plan : object
        What is searched; its `repr` identifies it.

    Attributes
    ----------
    results : dict
        What is done, by phase and task number.
    """

    def __init__(self, path: Path | None, plan: object) -> None:
        self.results: dict[tuple[str, int], SearchResult] = {}
        self._path = path
        header = json.dumps({"plan": _fingerprint(plan)})
        if path is None:
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text().split("\n") if path.is_file() else [""]
        if lines[0] != header or len(lines) == 1:
            path.write_text(header + "\n")
            return
        path.write_text(
            "".join(f"{line}\n" for line in lines[:-1])
        )  # no torn last line
        for line in lines[1:-1]:
            entry = json.loads(line)
            self.results[entry["phase"], entry["k"]] = _result(entry["result"])

    def append(self, phase: str, k: int, result: SearchResult) -> None:
        """Keep a result.

        Parameters
        ----------
        phase : str
            The phase it belongs to.
        k : int
            The task's number.
        result : SearchResult
            What was found.
        """
        self.results[phase, k] = result
        if self._path is not None:
            entry = {"phase": phase, "k": k, "result": asdict(result)}
            with self._path.open("a") as file:
                file.write(json.dumps(entry, default=np.ndarray.tolist) + "\n")


def _result(entry: dict[str, Any]) -> SearchResult:
    """Rebuild a result from its JSON."""
    starts = tuple(
        Start(**{**start, "policy": np.array(start["policy"])})
        for start in entry["starts"]
    )
    fields = {**entry, "policy": np.array(entry["policy"]), "starts": starts}
    return SearchResult(**fields)


def _fingerprint(plan: object) -> str:
    """Identify a plan together with the code that carries it out."""
    digest = hashlib.sha256(repr(plan).encode())
    for name in _CODE:
        digest.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return digest.hexdigest()
