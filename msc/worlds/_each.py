"""The same done to many worlds: in parallel, each kept as soon as it is done."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from msc._parallel import open_workers
from msc.search import identify_code
from press import write_json

Load = Callable[[str], tuple[tuple[Any, ...], Mapping[str, Any]]]


def do_each(
    function: Callable[..., Any],
    calls: Sequence[tuple[Any, ...]],
    keep: Callable[[int, Any], object],
    bar: tqdm[Any],
    *,
    sizes: Sequence[int] | None = None,
    jobs: int = 1,
    dask: str | None = None,
) -> None:
    """Call a function for each world, and keep what it gives, by the call's number.

    A world moves the bar by its size, by default by one.
    """
    with bar, open_workers(jobs, dask, code=identify_code) as run:
        for number, found in run(function, calls):
            keep(number, found)
            bar.update(1 if sizes is None else sizes[number])


def fill(
    what: str,
    function: Callable[..., dict[str, Any]],
    files: Mapping[str, Path],
    load: Load,
    write: Callable[[Path, Any], object] = write_json,
    *,
    seed: int,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Write the results of worlds that are not there yet, or rest on other tables.

    Of a world `load` tells what the function is called with, before the seed, and what
    its result rests on; all are asked before any is called.
    """
    loaded = {name: load(name) for name in files}
    left = [name for name, (_, to) in loaded.items() if not is_done(files[name], to)]
    bar = tqdm(desc=what, total=len(left), unit="world", disable=not progress)

    def keep(number: int, found: dict[str, Any]) -> None:
        name = left[number]
        told = {"world": name, "seed": seed, "provenance": loaded[name][1], **found}
        write(files[name], told)

    calls = [(*loaded[name][0], seed) for name in left]
    do_each(function, calls, keep, bar, jobs=jobs, dask=dask)
    return left


def is_done(out: Path, origin: Mapping[str, Any]) -> bool:
    """Whether a result is there, and rests on the tables that it would rest on now."""
    if not out.is_file():
        return False
    kept: Any = json.loads(out.read_text("utf-8"))
    return bool(kept["provenance"]["data"] == origin["data"])
