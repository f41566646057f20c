"""What each method did, in a file of its own, with all that it rests on.

`data/results/methods/<world>/<method>.npz` holds, by ``"design/n_samples/measure"``, an
array with a row a training set and a column a test task, and under "about" what it
rests on. NumPy reads it: ``np.load(path)["even/24/error_cm"]``.
"""

from __future__ import annotations

import ast
import hashlib
import io
import json
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from press import replace_file

_TOLD = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
_BITS = 16  # of a number's 24 that are kept: nearly five digits

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Trials:
    """What a method did on its training sets, in a world.

    Attributes
    ----------
    about : dict
        The method, the world, and what both rest on, see `msc.study.run_study`; under
        ``"failed"`` by "design/n_samples/set" why a fit failed, whose errors are NaN.
    errors : dict from str to ndarray of shape (n_sets, n_test_tasks)
        By "design/n_samples/measure". Of a method with rollouts of its own also their
        numbers, by "design/n_samples/n_rollouts", of shape (n_sets,).
    """

    about: dict[str, Any]
    errors: Mapping[str, Array]

    def write(self, path: Path) -> None:
        """Write the file, whole or not at all: the same trials, the same bytes."""
        memory = io.BytesIO()
        about = np.array(json.dumps(self.about, ensure_ascii=False))
        errors = {key: _shorten(values) for key, values in self.errors.items()}
        np.savez_compressed(memory, about=about, **errors)  # type: ignore[arg-type]
        replace_file(path, memory.getvalue())

    def begins(self, others: Trials) -> bool:
        """Whether all errors of others begin with these, to the bit that is kept."""
        return others.errors.keys() <= self.errors.keys() and all(
            np.array_equal(
                _shorten(self.errors[key]),
                errors[: len(self.errors[key])],
                equal_nan=errors.dtype.kind == "f",
            )
            for key, errors in others.errors.items()
        )

    @classmethod
    def read(cls, path: Path) -> Trials | None:
        """Read a file, or nothing if it is missing or torn."""
        try:
            with np.load(io.BytesIO(path.read_bytes())) as file:
                errors = {key: file[key] for key in file.files if key != "about"}
                return cls(json.loads(str(file["about"])), errors)
        except (OSError, ValueError, KeyError, zipfile.BadZipFile):
            return None


def method_path(folder: Path, world: str, name: str) -> Path:
    """Tell where a method's results are kept.

    Examples
    --------
    >>> method_path(Path("results"), "free", "da Silva's skill").as_posix()
    'results/methods/free/da-silva-s-skill.npz'
    """
    plain = name.lower().translate(str.maketrans("äéüß", "aeus"))
    return folder / "methods" / world / f"{re.sub('[^a-z0-9]+', '-', plain)}.npz"


@cache
def identify_module(name: str) -> str:
    """Identify what a module and all of this package that it imports compute.

    Comments, docstrings and the layout of the source do not count.
    """
    digest, known, waiting = hashlib.sha256(), set[str](), [name]
    sources = {}
    while waiting:
        module = waiting.pop()
        if module in known or (spec := _find(module)) is None:
            continue
        known.add(module)
        tree = ast.parse(spec.read_text(encoding="utf-8"))
        waiting += _imported(tree)
        sources[module] = ast.dump(_without_docstrings(tree))
    for module in sorted(sources):
        digest.update(f"{module} {sources[module]}\n".encode())
    return digest.hexdigest()


def identify_estimator(estimator: Any) -> str:
    """Identify an estimator: its parameters, and what its parts' classes compute."""
    told = []
    parts = {"": estimator, **estimator.get_params(deep=True)}
    for key, value in sorted(parts.items()):
        if hasattr(value, "get_params"):
            kind = type(value)
            code = identify_module(kind.__module__) if _is_ours(kind.__module__) else ""
            told.append(f"{key} {kind.__module__}.{kind.__qualname__} {code}")
        else:
            told.append(f"{key} {getattr(value, '__qualname__', repr(value))}")
    return hashlib.sha256("\n".join(told).encode()).hexdigest()


def _is_ours(module: str) -> bool:
    return module.partition(".")[0] == "msc"


def _find(module: str) -> Path | None:
    """Return a module's file; nothing if it is no module, but a name in one."""
    try:
        spec = find_spec(module)
    except ModuleNotFoundError:  # its parent is no package
        return None
    return Path(spec.origin) if spec and spec.origin else None


def _imported(tree: ast.Module) -> list[str]:
    """Return what of this package is imported, modules and names in them."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module, *(f"{node.module}.{a.name}" for a in node.names)]
    return [name for name in found if _is_ours(name)]


def _without_docstrings(tree: ast.Module) -> ast.Module:
    """Drop them all; what is left may be empty."""
    for node in ast.walk(tree):
        if isinstance(node, _TOLD) and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:]
    return tree


def _shorten(values: NDArray[Any]) -> NDArray[Any]:
    """Drop the last bits of numbers, which only take space."""
    if values.dtype.kind in "bi":
        return values
    mantissa, exponent = np.frexp(values.astype(np.float64))
    kept = np.round(mantissa * 2**_BITS) / 2**_BITS
    return np.asarray(np.ldexp(kept, exponent), dtype=np.float32)
