"""Every method, at many sample sizes, drawn in three ways, many times over.

Evenly spaced sets are all there are, one for each first task, up to thirty; uniform and
nonuniform ones fifteen. In the nonuniform design test tasks count by the same density,
as in Eq. 1. Every training set is fitted and tested in a worker, on the same datasets.
"""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from msc._parallel import call_in_order
from msc.data import Dataset, describe_origin, find_data, find_jumps, load_dataset
from msc.learn import SMCE
from msc.robot import Physics, Workspace, cached_arm
from msc.study._choices import measure_elbows
from msc.study._gates import average_gates, compare_gates
from msc.study._measure import RAW, measure_method
from msc.study._methods import METHODS, build_method, fit_methods
from msc.study._plans import measure_plans
from msc.study._sampling import Indices, draw_samples, task_density
from msc.study._setting import N_CHARTS
from msc.study._store import (
    Trials,
    identify_estimator,
    identify_module,
    method_path,
)
from msc.study._summaries import summarise_cell
from msc.study._trial import away_from_jumps
from press import checksum

_PACKAGES = ("numpy", "scikit-learn", "cvxpy")
_PACKAGE_OF = {"pybullet": "pybullet", "mujoco": "mujoco-core"}  # each engine
_ENGINE = Physics.engine  # in which policies are searched
_OF_CODE = "protocol", "code"  # of what results rest on
AT_RANDOM = 15  # training sets of each size at most, where they are drawn at random


@dataclass(frozen=True)
class Profile:
    """How much a study does."""

    repetitions: int  # training sets of each size and design, at most
    sizes: dict[str, tuple[int, ...]]  # of samples, by design
    some_sizes: tuple[int, ...]  # evenly spaced, of methods not tried on all sets,
    some_repetitions: int  # on so many training sets, at most
    few_sizes: tuple[int, ...]  # evenly spaced, of methods with rollouts of their own,
    few_repetitions: int  # on so many training sets, at most
    sweep_sizes: tuple[int, ...]  # evenly spaced, for every number of charts,
    sweep_repetitions: int  # on so many training sets, at most
    n_elbows: int  # parts of the policies in which an elbow is looked for
    methods: tuple[str, ...] = tuple(METHODS)  # who is compared


_LONG = "after Deisenroth: model-free", "contextual search"  # a minute a set, and more
_SIZES = (8, 12, 16, 24, 36, 50, 72, 100, 180, 360)
PROFILES = {
    "quick": Profile(
        repetitions=3,
        sizes={"even": (8, 24, 72)},
        some_sizes=(24,),
        some_repetitions=1,
        few_sizes=(24,),
        few_repetitions=1,
        sweep_sizes=(24,),
        sweep_repetitions=3,
        n_elbows=5,
        methods=tuple(name for name in METHODS if name not in _LONG),
    ),
    "full": Profile(
        repetitions=30,
        sizes={"even": _SIZES, "uniform": _SIZES, "nonuniform": (16, 24, 50, 100)},
        some_sizes=(12, 24, 50),
        some_repetitions=10,
        few_sizes=(24,),
        few_repetitions=3,
        sweep_sizes=(24, 100, 360),
        sweep_repetitions=10,
        n_elbows=50,
    ),
}

# By design and number of samples, training sets.
Sets = dict[tuple[str, int], list[Indices]]


def list_sets(profile: Profile, tasks: NDArray[np.float64], seed: int) -> Sets:
    """Draw all training sets there are."""
    sizes = {**profile.sizes}
    some = profile.some_sizes + profile.few_sizes + profile.sweep_sizes
    sizes["even"] = tuple(sorted({*sizes.get("even", ()), *some}))
    return {
        (design, n_samples): draw_samples(
            design,
            tasks,
            n_samples,
            n_draws=min(profile.repetitions, AT_RANDOM)
            if design != "even"
            else profile.repetitions,
            seed=seed,
        )
        for design, of_design in sizes.items()
        for n_samples in of_design
    }


def sets_of(name: str, profile: Profile, sets: Sets) -> Sets:
    """Take the training sets that a method is tried on."""
    kind = METHODS[name].sets
    if kind == "all":
        wanted = {(design, n) for design, sizes in profile.sizes.items() for n in sizes}
        return {key: some for key, some in sets.items() if key in wanted}
    if kind == "even":
        wanted = {("even", n) for n in profile.sizes.get("even", ())}
        return {key: some for key, some in sets.items() if key in wanted}
    sizes, most = {
        "some": (profile.some_sizes, profile.some_repetitions),
        "few": (profile.few_sizes, profile.few_repetitions),
        "sweep": (profile.sweep_sizes, profile.sweep_repetitions),
    }[kind]
    return {("even", n): sets["even", n][:most] for n in sizes}


def run_study(
    world: str,
    folder: Path,
    *,
    names: Iterable[str] | None = None,
    profile: str = "quick",
    seed: int = 0,
    engine: str = _ENGINE,
    recheck: bool = False,
    jobs: int = 1,
    progress: bool = False,
) -> Any:
    """Fit methods to many training sets of a workspace, and test them.

    Parameters
    ----------
    world : {"free", "obstacles"}
        The workspace and its data.
    folder : Path
        Where each method's results are kept, see `msc.study.method_path`. What is there
        and still holds is not done again.
    names : iterable of str, optional
        Whom to try, if that has to be done again; by default all that the profile has.
    profile : {"quick", "full"}, default="quick"
        How much to do, see `PROFILES`.
    seed : int, default=0
        Seed of the training sets and the clustering.
    engine : {"pybullet", "mujoco"}, default="pybullet"
        In which engine predicted policies are executed.
    recheck : bool, default=False
        What is stale because code has changed, and nothing else, is tried again on the
        first training set of each design and size; if all errors come out the same, to
        the last bit kept, the results hold, and say on how many sets that was checked.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    dict
        Laid out as `msc.study.Study` says, of all methods whose results are there.

    Raises
    ------
    ValueError
        If the workspace, profile, engine or a method is unknown, the data are unusable,
        results of another profile, seed or engine are there, which are never
        overwritten, or results of other tables, another protocol or other code, of a
        method that is not among those to be tried.
    """
    effort = _effort(profile)
    wanted = tuple(effort.methods if names is None else names)
    if unknown := [name for name in wanted if name not in METHODS]:
        raise ValueError(
            f"methods={unknown} are unknown; wanted some of {_alike(unknown)}"
        )
    where = _workspace(world, engine)
    cached_arm(where)  # refuses, before the work, an engine that is not installed
    _check_kept(folder, profile, seed, engine)
    datasets = grid, test = load_dataset(world), load_dataset(f"{world}_test")
    sets = list_sets(effort, grid.tasks, seed)
    origin = partial(_about, where, effort, sets, profile=profile, seed=seed)
    how: dict[str, Any] = {"jobs": jobs, "progress": progress}
    work = partial(_fit_and_test, where, datasets=datasets, seed=seed)
    for name in wanted:
        path = method_path(folder, world, name)
        kept, wanted_of = Trials.read(path), origin(name)
        if _agrees(kept, wanted_of):
            continue
        own = sets_of(name, effort, sets)
        label = f"{name}, {world}"
        if recheck and kept and _agrees(kept, wanted_of, but=_OF_CODE):
            firsts = {key: drawn[:1] for key, drawn in own.items()}
            calls = [(name, drawn[0]) for drawn in own.values()]
            found = call_in_order(work, calls, label=f"{label}, rechecked", **how)
            if _gather(firsts, found, wanted_of, len(test.tasks)).begins(kept):
                told = {"failed": kept.about["failed"], "rechecked": len(firsts)}
                Trials({**wanted_of, **told}, kept.errors).write(path)
                continue
        calls = [(name, chosen) for drawn in own.values() for chosen in drawn]
        found = call_in_order(work, calls, label=label, **how)
        _gather(own, found, wanted_of, len(test.tasks)).write(path)
    known = read_trials(world, folder, profile=profile, seed=seed, engine=engine)
    return {
        "workspace": world,
        "profile": profile,
        "seed": seed,
        "n_charts": N_CHARTS,
        "provenance": _provenance(world, profile, seed, engine),
        **_summarise(datasets, sets, known),
    }


def _workspace(world: str, engine: str) -> Workspace:
    """Return a headline world in an engine."""
    one = Workspace.named(world)
    return replace(one, physics=replace(one.physics, engine=engine))


def _check_kept(folder: Path, profile: str, seed: int, engine: str) -> None:
    """Refuse, before the work, results of another profile, seed or engine."""
    for path in sorted(folder.glob("methods/*/*.npz")):
        trials = Trials.read(path)
        if trials is None:  # torn
            continue
        about = trials.about
        made_in = about.get("engine", _ENGINE)
        kept = _options(about.get("profile"), about.get("seed"), made_in)
        asked = _options(profile, seed, engine)
        if kept != asked:
            raise ValueError(
                f"{path} was made with {kept}, not {asked}; wanted the same, or "
                "another --out-dir"
            )


def _options(profile: Any, seed: Any, engine: str) -> str:
    """Write what a study is asked for, as its command has it."""
    told = f"--profile {profile} --seed {seed}"
    return told if engine == _ENGINE else f"{told} --engine {engine}"


def read_trials(
    world: str,
    folder: Path,
    *,
    profile: str = "full",
    seed: int = 0,
    engine: str = _ENGINE,
) -> dict[str, Trials]:
    """Read what methods did in a world, of all whose results are there.

    Parameters
    ----------
    world : {"free", "obstacles"}
        The workspace.
    folder : Path
        Where each method's results are kept.
    profile : {"quick", "full"}, default="full"
        How much was done.
    seed : int, default=0
        As for `run_study`.
    engine : {"pybullet", "mujoco"}, default="pybullet"
        As for `run_study`.

    Returns
    -------
    dict from str to Trials
        By method.

    Raises
    ------
    ValueError
        If the profile is unknown, or results are torn, or of other tables, another
        protocol or other code.
    """
    effort, known, where = _effort(profile), {}, _workspace(world, engine)
    sets = list_sets(effort, load_dataset(world).tasks, seed)
    for name in effort.methods:
        path = method_path(folder, world, name)
        if not path.exists():
            continue
        trials = Trials.read(path)
        about = _about(where, effort, sets, name, profile=profile, seed=seed)
        if trials is None or not _agrees(trials, about):
            why = "rests on other tables, another protocol or other code"
            raise ValueError(
                f"{name!r}: what is kept of it in {world!r} "
                f"{'cannot be read' if trials is None else why}; make it anew: "
                f"msc evaluate {_options(profile, seed, engine)} --out-dir {folder} "
                f"--methods {shlex.quote(name)}"
            )
        known[name] = trials
    return known


def _alike(unknown: Iterable[str]) -> list[str]:
    """List the methods that are called nearly so, or all of them."""
    plain = {name.casefold(): name for name in METHODS}
    close = [get_close_matches(name.casefold(), plain) for name in unknown]
    return [plain[name] for some in close for name in some] or [*METHODS]


def _about(
    where: Workspace, effort: Profile, sets: Sets, name: str, *, profile: str, seed: int
) -> dict[str, Any]:
    """Say what a method's results rest on."""
    world, engine = where.name, where.physics.engine
    tables = (find_data() / f"{table}.csv" for table in (world, f"{world}_test"))
    own = sets_of(name, effort, sets).items()
    drawn = [[*key, *np.array(some).tolist()] for key, some in own]
    digest = hashlib.sha256(json.dumps(drawn).encode())
    method = build_method(name, seed=seed, workspace=where)
    measure = "_plans" if hasattr(method, "plan") else "_measure"
    digest.update(identify_module(f"msc.study.{measure}").encode())
    return {
        **({} if engine == _ENGINE else {"engine": engine}),
        "method": name,
        "world": world,
        "profile": profile,
        "seed": seed,
        "tables": {table.name: checksum(table) for table in tables},
        "protocol": digest.hexdigest(),
        "code": identify_estimator(method),
        "versions": _versions(engine),
    }


def _agrees(
    trials: Trials | None, wanted: dict[str, Any], but: tuple[str, ...] = ()
) -> bool:
    """Whether results are there, and rest on what they would rest on now."""
    if trials is None:
        return False
    return all(trials.about.get(key) == wanted[key] for key in wanted if key not in but)


def _fit_and_test(
    where: Workspace,
    name: str,
    chosen: NDArray[np.intp],
    *,
    datasets: tuple[Dataset, Dataset],
    seed: int,
) -> dict[str, NDArray[Any]] | str:
    """Fit and test on one training set, in a worker; or tell why it failed."""
    grid, test = datasets
    known = grid.tasks[chosen], grid.policies[chosen], grid.table["cost"][chosen]
    try:
        method = fit_methods(*known, names=[name], seed=seed, workspace=where)[name]
        if hasattr(method, "plan"):
            found = measure_plans(method, where, test)
        else:
            found = measure_method(name, method, where, datasets, chosen)
        if hasattr(method, "n_rollouts_"):
            found["n_rollouts"] = np.array(method.n_rollouts_)
        return found
    except Exception as error:  # whatever a method of others raises
        return f"{type(error).__name__}: {error}"


def _gather(
    sets: Sets, found: Iterable[Any], about: dict[str, Any], n_tasks: int
) -> Trials:
    """Put what was found on each set, one after another, into arrays."""
    results, failed = iter(found), {}
    errors: dict[str, Any] = {}
    nothing = dict.fromkeys(RAW, np.full(n_tasks, np.nan))
    for (design, n_samples), some in sets.items():
        rows = []
        for number in range(len(some)):
            one = next(results)
            if isinstance(one, str):
                failed[f"{design}/{n_samples}/{number}"] = one
            rows.append(nothing if isinstance(one, str) else one)
        for key in set.intersection(*(set(row) for row in rows)):
            errors[f"{design}/{n_samples}/{key}"] = np.array([row[key] for row in rows])
    return Trials({**about, "failed": failed}, dict(sorted(errors.items())))


def _summarise(
    datasets: tuple[Dataset, Dataset], sets: Sets, known: Mapping[str, Trials]
) -> Any:
    """Summarise all methods, by design and size, and the sweep over charts."""
    grid, test = datasets
    jumps = find_jumps(grid.tasks, grid.policies)
    density = task_density(test.tasks[:, 0])
    cells, sweep = [], []
    for (design, n_samples), drawn in sets.items():
        away = away_from_jumps(grid.tasks, jumps, test.tasks, n_samples)
        weights = density if design == "nonuniform" else np.ones(len(density))
        start = f"{design}/{n_samples}/"
        found = {
            name: {
                key.removeprefix(start): errors
                for key, errors in trials.errors.items()
                if key.startswith(start)
            }
            for name, trials in known.items()
        }
        found = {name: raw for name, raw in found.items() if raw}
        counted = [name for name in found if METHODS[name].sets == "sweep"]
        for name in counted:
            raw = found.pop(name)
            n_sets = len(raw["mse"])
            measures = summarise_cell({"charts": raw}, away, weights)["measures"]
            n_charts = int(name.split()[0])
            one = {"n_charts": n_charts, "n_samples": n_samples, "repetitions": n_sets}
            sweep.append({**one, "measures": measures})
        if found:
            of = {"design": design, "n_samples": n_samples, "repetitions": len(drawn)}
            cells.append({**of, **summarise_cell(found, away, weights)})
    failed = {name: one.about["failed"] for name, one in known.items()}
    sweep.sort(key=lambda one: (one["n_charts"], one["n_samples"]))
    spent = {name: _rollouts(trials) for name, trials in known.items()}
    return {
        "rollouts": {name: number for name, number in spent.items() if number},
        "failed": {name: why for name, why in failed.items() if why},
        "cells": cells,
        "sweep": sweep,
    }


def _rollouts(trials: Trials) -> float:
    """Average how many rollouts a method spent on a training set."""
    ends = "/n_rollouts"
    spent = [own for key, own in trials.errors.items() if key.endswith(ends)]
    return float(np.concatenate(spent).mean()) if spent else 0.0


def run_elbows(
    name: str,
    *,
    known: Mapping[str, Any] | None = None,
    profile: str = "quick",
    seed: int = 0,
    jobs: int = 1,
    progress: bool = False,
) -> dict[str, Any]:
    """Count the charts that each elbow picks, and tell how well each gate finds them.

    Parameters
    ----------
    name : {"free", "obstacles"}
        The workspace and its data.
    known : mapping, optional
        What was found before. If it rests on the same tables, code and versions, it is
        returned as it is.
    profile : {"quick", "full"}, default="quick"
        As for `run_study`.
    seed : int, default=0
        As there.
    jobs : int, default=1
        As there.
    progress : bool, default=False
        As there.

    Returns
    -------
    dict
        What `msc.study.measure_elbows` found, what it rests on, and under
        ``"gates"`` what `msc.study.average_gates` gave, on the evenly spaced sets of
        the sweep.

    Raises
    ------
    ValueError
        If the workspace or the profile is another, or its data are unusable.
    """
    effort = _effort(profile)
    told = {"workspace": name, "profile": profile, "seed": seed}
    told["provenance"] = {
        **_provenance(name, profile, seed),
        "code": [identify_module(f"msc.study.{one}") for one in ("_choices", "_gates")],
    }
    if known is not None and {key: known.get(key) for key in told} == told:
        return dict(known)
    tasks, policies, _ = load_dataset(name)
    found = measure_elbows(
        tasks,
        policies,
        n_resamples=effort.n_elbows,
        seed=seed,
        jobs=jobs,
        progress=progress,
    )
    n_draws = effort.sweep_repetitions
    sets = [
        chosen
        for size in effort.sweep_sizes
        for chosen in draw_samples("even", tasks, size, n_draws=n_draws, seed=seed)
    ]
    gates = call_in_order(
        partial(compare_gates, charts=SMCE(N_CHARTS), seed=seed),
        [(tasks[chosen], policies[chosen]) for chosen in sets],
        jobs=jobs,
        label=f"gates, {name}",
        progress=progress,
    )
    return {**told, **found, "gates": average_gates(gates)}


def _effort(profile: str) -> Profile:
    """Look up how much to do."""
    if profile not in PROFILES:
        raise ValueError(f"profile={profile!r}; wanted one of {tuple(PROFILES)}")
    return PROFILES[profile]


def _provenance(
    name: str, profile: str, seed: int, engine: str = _ENGINE
) -> dict[str, Any]:
    """Say by which command, of which data, with which packages."""
    tables = (find_data() / f"{table}.csv" for table in (name, f"{name}_test"))
    command = f"msc evaluate {_options(profile, seed, engine)}"
    return {**describe_origin(command, *tables), "versions": _versions(engine)}


def _versions(engine: str) -> dict[str, str]:
    """Return the versions of the packages that results owe their numbers to."""
    packages = (*_PACKAGES, _PACKAGE_OF[engine])
    return {package: metadata.version(package) for package in packages}
