"""How sure a skill is of what it predicts, and whether that can be trusted.

A prediction has a standard deviation, and so a band: Gaussian, or conformal, which
divides errors of training tasks held out by their standard deviations and takes a
quantile of that. And it has a gate, which may be unsure of its chart.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from msc.data import Dataset
from msc.estimates import Estimate, six_digits
from msc.robot import Workspace
from msc.skills import load_crepes
from msc.study import execute_policies, fit_methods
from msc.worlds._draw import family_of
from msc.worlds._each import fill
from msc.worlds._study import are_away, list_world_sets, load_for
from msc.worlds._verdicts import geometric_mean, resample

LEVEL = 0.9  # of the bands
SIZE, N_SETS, N_FOLDS = 24, 3, 4  # training tasks, sets of them, folds of each
FAILED = 0.1  # of the searched cost: what a policy costs more that fails
ASIDE = 0.05, 0.1, 0.2, 0.3, 0.5  # shares of tasks set aside
BANDED = (
    "charts",
    "charts, GP gate",
    "charts, one kernel",
    "single regression",
    "single, one kernel",
)

_KEYS = "coverage", "width", "score"

Array = NDArray[np.float64]


def locate_bands(
    folder: Path,
    out: Path,
    names: Iterable[str],
    *,
    seed: int = 0,
    jobs: int = 1,
    dask: str | None = None,
    progress: bool = False,
) -> list[str]:
    """Measure the bands of worlds, of those that are not measured yet.

    Parameters
    ----------
    folder : Path
        Where worlds and tables are.
    out : Path
        Where results go, `bands_NAME.json` a world.
    names : iterable of str
        Which worlds; those with a choice of ours changed are left out.
    seed : int, default=0
        Seed of the training sets and the clustering.
    jobs : int, default=1
        Worker processes, a world each; the result does not depend on them.
    dask : str, optional
        Address of a Dask scheduler, whose workers do the work instead.
    progress : bool, default=False
        Whether to show a progress bar on standard error.

    Returns
    -------
    list of str
        The worlds that were looked at.
    """
    own = [name for name in names if family_of(name).name != "variant"]
    files = {name: out / f"bands_{name}.json" for name in own}
    how: dict[str, Any] = {"jobs": jobs, "dask": dask, "progress": progress}
    load = load_for("bands", folder, seed)
    return fill("bands", measure_bands, files, load, seed=seed, **how)


def measure_bands(
    world: Workspace, train: Dataset, test: Dataset, seed: int = 0
) -> dict[str, Any]:
    """Measure how often bands hold the policy searched, and what they tell of failures.

    Parameters
    ----------
    world : Workspace
        The world.
    train, test : Dataset
        Its tables.
    seed : int, default=0
        Seed of the training sets and the clustering.

    Returns
    -------
    dict
        Over all weights, test tasks and sets of 24 training tasks, by method:

        - "bands": by kind, "gaussian" or "conformal", and by place, "away" from jumps
          or "beside" one, the share of weights held ("coverage"), and the mean width
          ("width") and interval score ("score") over the weight's spread, or None if
          there is no such task;
        - "failures": how many predictions failed, and how many there are;
        - "caught": by what a task is set aside for, "std" or "gate", and by the share
          of tasks that are, how many of the failures are among them.
    """
    units = world.task_units
    grid, new = (one._replace(tasks=one.tasks / units) for one in (train, test))
    away = are_away(world, grid, new.tasks, SIZE)
    sets = next(s for _, n, s in list_world_sets(grid.tasks, seed) if n == SIZE)
    told = {}
    for name in BANDED:
        looks = [_look(name, world, (grid, new), some, seed) for some in sets[:N_SETS]]
        join = {key: np.stack([one[key] for one in looks]) for key in looks[0]}
        told[name] = {
            "bands": {
                kind: {
                    place: _summarise(join, kind, of)
                    for place, of in (("away", away), ("beside", ~away))
                }
                for kind in ("gaussian", "conformal")
            },
            "failures": [int(join["failed"].sum()), join["failed"].size],
            "caught": {
                by: _catch(join[by], join["failed"])
                for by in ("std", "gate")
                if by in join
            },
        }
    return {"tasks": [int(away.sum()), len(away)], "methods": told}


def _look(
    name: str,
    world: Workspace,
    datasets: tuple[Dataset, Dataset],
    chosen: NDArray[np.intp],
    seed: int,
) -> dict[str, NDArray[Any]]:
    """Fit a method to a training set; hold its bands against all test tasks."""
    grid, new = datasets
    spread = grid.policies.std(axis=0)

    def fit(own: NDArray[np.intp]) -> Any:
        known = grid.tasks[own], grid.policies[own], grid.table["cost"][own]
        return fit_methods(*known, names=[name], seed=seed, workspace=world)[name]

    skill = fit(chosen)
    means, stds = skill.predict(new.tasks, return_std=True)
    found: dict[str, NDArray[Any]] = {}
    halves = {
        "gaussian": norm.ppf((1 + LEVEL) / 2) * stds,
        "conformal": conformal_halves(fit, grid, chosen, stds),
    }
    apart = np.abs(new.policies - means)
    for kind, half in halves.items():
        outside = np.maximum(apart - half, 0)
        scores = (2 * half + 2 / (1 - LEVEL) * outside) / spread
        found[f"{kind} coverage"] = (outside == 0).mean(axis=1)
        found[f"{kind} width"] = (2 * half / spread).mean(axis=1)
        found[f"{kind} score"] = scores.mean(axis=1)
    found["std"] = (stds / spread).mean(axis=1)
    if "gate" in name:
        found["gate"] = 1 - skill.gate_.predict_proba(new.tasks).max(axis=1)
    done = execute_policies(world, means, new.table)
    dearer = done["excess_cost"].to_numpy() > FAILED * new.table["cost"].to_numpy()
    return found | {"failed": dearer}


def conformal_halves(
    fit: Callable[[NDArray[np.intp]], Any],
    grid: Dataset,
    chosen: NDArray[np.intp],
    stds: Array,
) -> Array:
    """Return half the widths of conformal bands, from training tasks held out.

    Every so manieth training task is held out at a time; the error of its prediction is
    divided by the standard deviation of that, and the quantile of all [1]_ multiplies
    those of new tasks.

    Parameters
    ----------
    fit : callable
        Fits a skill to tasks, given by their numbers in the grid.
    grid : Dataset
        All tasks.
    chosen : ndarray of int
        Training tasks.
    stds : ndarray of shape (n_tasks, n_params)
        Standard deviations of the predictions that want bands.

    Returns
    -------
    ndarray of shape (n_tasks, n_params)
        Half the width of each.

    References
    ----------
    .. [1] H. Papadopoulos, V. Vovk and A. Gammerman, "Regression conformal prediction
       with nearest neighbours", JAIR 40, 2011.
    """
    errors, scales = np.empty((2, len(chosen), stds.shape[1]))
    folds = np.arange(len(chosen)) % N_FOLDS
    for k in range(N_FOLDS):
        held = chosen[folds == k]
        means, own = fit(chosen[folds != k]).predict(grid.tasks[held], return_std=True)
        errors[folds == k], scales[folds == k] = grid.policies[held] - means, own
    halves, conformal = np.empty_like(stds), load_crepes()
    for weight, column in enumerate(halves.T):
        model = conformal().fit(errors[:, weight], sigmas=scales[:, weight])
        own = stds[:, weight]
        bands = model.predict_int(np.zeros(len(own)), sigmas=own, confidence=LEVEL)
        column[:] = bands[:, 1]
    return halves


def _summarise(
    looks: Mapping[str, Array], kind: str, of: NDArray[np.bool_]
) -> dict[str, float] | None:
    """Average what is known of one kind of band, over some of the tasks."""
    if not of.any():
        return None
    return {
        key: six_digits(float(looks[f"{kind} {key}"][:, of].mean())) for key in _KEYS
    }


def _catch(doubt: Array, failed: Array) -> dict[str, int]:
    """Count the failures among the tasks that are doubted most."""
    order = np.argsort(-doubt.ravel(), kind="stable")
    caught = failed.ravel()[order].cumsum()
    return {f"{share:g}": int(caught[round(share * len(order)) - 1]) for share in ASIDE}


def judge_bands(results: Path) -> dict[str, Any]:
    """Average the bands of each family of worlds.

    Parameters
    ----------
    results : Path
        Where `locate_bands` wrote.

    Returns
    -------
    dict
        By family and method:

        - "bands": by kind and place "coverage", "width" and "score", each with its
          interval over worlds, the last two as means of logarithms;
        - "failures": how many predictions failed in all worlds, and how many there are;
        - "caught": by what a task is set aside for, and by the share of tasks that are,
          the share of failures among them; none without failures.
    """
    found: dict[str, list[dict[str, Any]]] = {}
    for path in sorted(results.glob("bands_*.json")):
        family = family_of(path.stem.removeprefix("bands_")).name
        found.setdefault(family, []).append(json.loads(path.read_text("utf-8")))
    return {
        family: {
            name: _over_worlds([one["methods"][name] for one in worlds])
            for name in BANDED
        }
        for family, worlds in found.items()
    }


def _over_worlds(worlds: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Average the bands of a method, and join what was caught."""
    failed, n_tasks = np.sum([one["failures"] for one in worlds], axis=0).tolist()
    caught = {
        by: {
            share: six_digits(sum(one["caught"][by][share] for one in worlds) / failed)
            for share in shares
        }
        for by, shares in worlds[0]["caught"].items()
        if failed
    }
    bands = {
        kind: {
            place: _average([one["bands"][kind][place] for one in worlds])
            for place in places
        }
        for kind, places in worlds[0]["bands"].items()
    }
    return {"bands": bands, "failures": [failed, n_tasks], "caught": caught}


def _average(worlds: Sequence[Mapping[str, float] | None]) -> dict[str, Any]:
    """Average coverage, width and score over the worlds that have some."""
    some = [one for one in worlds if one]
    told: dict[str, Any] = {}
    for key in _KEYS if some else ():
        values = np.array([one[key] for one in some])
        if key == "coverage":
            estimate = Estimate(float(values.mean()), *resample(values))
        else:
            estimate = geometric_mean(np.log(values))
        told[key] = estimate.stored("value")
    return told
