"""What many worlds cost: one of them in each of its steps, and four with Dask.

`python benchmarks/worlds.py` searches, bisects and studies one layout in processes of
their own, which takes some ten minutes, and then four layouts with few tasks through
one, two and four of Dask's workers on this machine. To be run on a machine that does
nothing else (the second part above all: it can be run alone, `--only-dask`). The result
goes to `data/results/worlds_cost.json`.
"""

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from bench import machine
from timing import clock

import msc.worlds._search
from msc.estimates import six_digits
from msc.robot import format_world
from msc.worlds import FAMILIES, draw_worlds, search_worlds
from press import checksum, write_json

DATA = Path(__file__).parents[1] / "data"
ONE = "layout09"
N_WORKERS = 1, 2, 4
FEW = {"n_train": 2, "n_test": 2}  # tasks of each of so many layouts:
N_WORLDS = 4


def main() -> None:
    """Measure, write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="less, to see it run")
    parser.add_argument("--only-dask", action="store_true", help="keep the first part")
    parser.add_argument("--out", type=Path, default=DATA / "results/worlds_cost.json")
    options = parser.parse_args()
    found: dict[str, Any] = {"quick": options.quick, "machine": machine()}
    if options.only_dask:
        found["core_seconds"] = json.loads(options.out.read_bytes())["core_seconds"]
    elif not options.quick:
        found["core_seconds"] = {"world": ONE, **measure_steps()}
        write_json(options.out, found)
    how = (1, N_WORKERS[:1]) if options.quick else (N_WORLDS, N_WORKERS)
    found["dask"] = measure_dask(*how)
    write_json(options.out, found)


def measure_steps() -> dict[str, float]:
    """Search, bisect and study a world; return the processor's seconds of each."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(DATA / "worlds" / f"{ONE}.toml", folder)
        return {step: _cpu(step, folder) for step in ("search", "jumps", "study")}


def _cpu(step: str, folder: str) -> float:
    """Run one step in a process of its own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "msc", "worlds", step, ONE, "--jobs", "1"]
    where = ["--folder", folder, "--out-dir", folder]
    alone = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    subprocess.run([*command, *where], check=True, env=os.environ | alone)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return six_digits(after.ru_utime - before.ru_utime)


def measure_dask(n_worlds: int, workers: Sequence[int]) -> dict[str, Any]:
    """Search some worlds with few tasks through Dask, with ever more workers."""
    import distributed  # noqa: PLC0415  an extra

    FAMILIES["layout"] = replace(FAMILIES["layout"], **FEW)
    msc.worlds._search._OFFSETS_DEG[FEW["n_test"]] = 45.0
    worlds = list(islice(draw_worlds(0, n_worlds), n_worlds))
    seconds, tables = {}, set()
    for n_workers in workers:
        with (
            tempfile.TemporaryDirectory() as folder,
            distributed.LocalCluster(
                n_workers=n_workers,
                threads_per_worker=1,
                dashboard_address=None,
                local_directory=folder,
            ) as cluster,
        ):
            for world in worlds:
                told = format_world(world, "")
                Path(folder, f"{world.name}.toml").write_text(told, "utf-8")
            names = [world.name for world in worlds]
            how = {"dask": cluster.scheduler_address, "progress": True}
            search = partial(search_worlds, Path(folder), names, **how)
            seconds[f"{n_workers}"] = six_digits(clock(search))
            found = sorted(Path(folder).glob("*.csv"))
            tables.add(tuple(checksum(table) for table in found))
    return {
        "worlds": n_worlds,
        "tasks": n_worlds * sum(FEW.values()),
        "seconds": seconds,
        "same_tables": len(tables) == 1,
    }


if __name__ == "__main__":
    main()
