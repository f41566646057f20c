"""The search: what a rollout costs, and from one task to its policy.

A search keeps what it found; `record_search` also keeps all that was tried.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc._checks import check_whole, to_floats
from msc.robot import (
    DMP,
    CostWeights,
    Rollout,
    Workspace,
    cached_arm,
    check_policies,
    forward_kinematics,
)
from msc.search._cmaes import CmaRun, minimize_steps
from msc.search._lockstep import Search, run_in_lockstep
from msc.search._options import SearchOptions

ERROR_WEIGHT = CostWeights.error  # 1/m²
ENERGY_WEIGHT = CostWeights.energy  # s/rad²

Task = float | Sequence[float]  # an angle (degrees), or all numbers of a task


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The policy found for a task, and how.

    Attributes
    ----------
    task_deg : float or tuple of float
        Task angle (degrees), or all numbers of the task.
    policy : ndarray of shape (n_params,)
        Weights of Eq. 7.
    cost : float
        Its cost, see `cost`.
    error, energy, contact_impulse : float
        What its rollout measured, see `Rollout`.
    runs : tuple of CmaRun
        All runs of CMA-ES, in order; the cheapest gave the policy.
    same : float
        How near to the policy a run has to end to agree, see `SearchOptions`.
    """

    task_deg: float | tuple[float, ...]
    policy: NDArray[np.float64]
    cost: float
    error: float
    energy: float
    contact_impulse: float
    runs: tuple[CmaRun, ...]
    same: float = SearchOptions.same

    @property
    def evaluations(self) -> int:
        """Rollouts spent, over all runs."""
        return sum(run.evaluations for run in self.runs)

    @property
    def winner(self) -> str:
        """Name of the run that gave the policy."""
        return _best(self.runs).name

    @property
    def n_agreeing(self) -> int:
        """Runs that ended at the policy, or were stopped on their way to it."""
        return len(self.runs) - len(self._others)

    @property
    def is_confirmed(self) -> bool:
        """Whether two runs agree on the policy, an independent one among them."""
        agreeing = [run for run in self.runs if run not in self._others]
        is_free = [run.name.startswith("start") for run in agreeing]
        return len(agreeing) > 1 and any(is_free)

    @property
    def margin(self) -> float:
        """Cost of the best run that ended elsewhere, over the policy's; NaN if none.

        A small margin tells of two behaviours that are nearly tied.
        """
        costs = [run.cost for run in self._others if not run.failed]
        return min(costs) - self.cost if costs else float("nan")

    @property
    def _others(self) -> list[CmaRun]:
        """Runs that did not end at the policy, those that failed among them."""
        ends = [
            number if run.merged_into < 0 else run.merged_into
            for number, run in enumerate(self.runs)
        ]
        reach = self.same * np.linalg.norm(self.policy)
        there = [
            not run.failed and np.linalg.norm(run.policy - self.policy) <= reach
            for run in self.runs
        ]
        return [run for run, end in zip(self.runs, ends, strict=True) if not there[end]]


def _best(runs: Sequence[CmaRun]) -> CmaRun:
    """Return the cheapest run, of those that did not fail if there are any."""
    return min(runs, key=lambda run: (run.failed, run.cost))


def cost(rollout: Rollout, weights: CostWeights | None = None) -> float:
    """Weigh what a rollout missed against how much it moved.

    Parameters
    ----------
    rollout : Rollout
        What happened.
    weights : CostWeights, optional
        What is paid for what; by default ``CostWeights()``.

    Returns
    -------
    float
        100/m² · error² + 0.005 s/rad² · energy: one centimetre weighs as much as
        2 rad²/s. The paper asks for a term that penalises longer movements; energy
        bounds the squared length of the joint path and, unlike length, settles the
        timing along it too, so that the optimum is a point. A world may also ask a
        price for contacts, or for length.
    """
    pays = weights or CostWeights()
    paid = pays.error * rollout.error**2 + pays.energy * rollout.energy
    if pays.contact:
        paid += pays.contact * rollout.contact_impulse
    if pays.length:
        paid += pays.length * rollout.length
    return paid


def search_policy(
    workspace: Workspace,
    task_deg: Task,
    *,
    seed: int,
    n_starts: int = 4,
    start_policies: Sequence[ArrayLike] = (),
    incumbent: SearchResult | None = None,
    dmp: DMP | None = None,
    options: SearchOptions | None = None,
) -> SearchResult:
    """Search the policy that solves one task, by CMA-ES.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees); where tasks have further numbers, a row of them.
    seed : int
        Seed of all random draws, together with the task and the start's number: a
        task's search does not depend on what else is searched.
    n_starts : int, default=4
        Independent starts: from the zero policy, then from random ones.
    start_policies : sequence of array_like of shape (n_params,), optional
        Starts before those, from given policies and with a small first step.
    incumbent : SearchResult, optional
        An earlier search of the same task, to go on from: its runs count too.
    dmp : DMP, optional
        What a policy means; by default the workspace's.
    options : SearchOptions, optional
        How the search goes about it; by default ``SearchOptions()``.

    Returns
    -------
    SearchResult
        The cheapest policy of all starts.

    Raises
    ------
    ValueError
        If there is no start at all, an argument is not a number as wanted, or the
        incumbent is of another task.
    RuntimeError
        If the cost is flat around every start.

    Examples
    --------
    >>> found = search_policy(Workspace.free(), 200, seed=1, n_starts=1)
    >>> found.error < 0.005
    True
    """
    search = search_steps(
        workspace,
        task_deg,
        seed=seed,
        n_starts=n_starts,
        start_policies=start_policies,
        incumbent=incumbent,
        dmp=dmp,
        options=options,
    )
    [(_, result)] = run_in_lockstep(workspace, [(task_deg, search)], dmp)
    return result


def search_policies(
    workspace: Workspace,
    tasks_deg: Sequence[Task],
    *,
    seed: int,
    n_starts: int = 4,
    start_policies: Any = None,
    options: SearchOptions | None = None,
) -> list[SearchResult]:
    """Search the policies of several tasks, nine at a time in one physics world.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks_deg : sequence of float
        Task angles (degrees); where tasks have further numbers, rows of them.
    seed : int
        Seed of all random draws, as of `search_policy`.
    n_starts : int, default=4
        Independent starts a task.
    start_policies : array_like of shape (n_tasks, n_given, n_params), optional
        Starts of each task before those, as of `search_policy`.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    list of SearchResult
        Of each task what `search_policy` finds, to the bit, in a third of its time.

    Examples
    --------
    >>> brief = SearchOptions(max_evaluations=20)
    >>> pair = search_policies(
    ...     Workspace.free(), [200, 90], seed=1, n_starts=1, options=brief
    ... )
    >>> alone = search_policy(
    ...     Workspace.free(), 90, seed=1, n_starts=1, options=brief
    ... )
    >>> pair[1].cost == alone.cost
    True
    """
    search = partial(search_steps, seed=seed, n_starts=n_starts, options=options)
    given = [()] * len(tasks_deg) if start_policies is None else start_policies
    searches = [
        (task, search(workspace, task, start_policies=starts))
        for task, starts in zip(tasks_deg, given, strict=True)
    ]
    found = dict(run_in_lockstep(workspace, searches))
    return [found[number] for number in range(len(searches))]


def search_steps(
    workspace: Workspace,
    task_deg: Task,
    *,
    seed: int,
    n_starts: int = 4,
    start_policies: Sequence[ArrayLike] = (),
    incumbent: SearchResult | None = None,
    dmp: DMP | None = None,
    options: SearchOptions | None = None,
) -> Search[SearchResult]:
    """Search as `search_policy` does, executed by whoever asks for the next step."""
    dmp, options = dmp or workspace.dmp, options or SearchOptions()
    runs = list(incumbent.runs) if incumbent else []
    numbers = _check(workspace, task_deg, seed, n_starts)
    if n_starts + len(start_policies) + len(runs) == 0:
        raise ValueError(
            f"n_starts={n_starts} with {len(start_policies)} start_policies; "
            "wanted at least one start"
        )
    given = [
        check_policies(policy, dmp.n_params, single=True) for policy in start_policies
    ]
    task_of = numbers[0] if len(numbers) == 1 else numbers
    if incumbent and incumbent.task_deg != task_of:
        raise ValueError(
            f"incumbent is of task {incumbent.task_deg}°; wanted one of {task_deg}°"
        )
    task = _Task(workspace, numbers, seed, dmp, options)
    for number, policy in enumerate(given):
        runs.append((yield from task.run(runs, (f"given {number}", policy))))
    for _ in range(n_starts):
        runs.append((yield from task.run(runs)))
    best = _best(runs)
    if best.failed:
        raise RuntimeError(
            f"task {_named(numbers)}: all {len(runs)} starts ended with their first "
            f"generation: costs within {options.tolerance:g}; wanted a cost that tells "
            "policies apart, or a smaller tolerance"
        )
    [rollout] = yield best.policy[np.newaxis]
    return SearchResult(
        task_deg=task_of,
        policy=best.policy,
        cost=cost(rollout, workspace.cost),
        error=rollout.error,
        energy=rollout.energy,
        contact_impulse=rollout.contact_impulse,
        runs=tuple(runs),
        same=options.same,
    )


def _check(
    workspace: Workspace, task_deg: Task, seed: int, n_starts: int
) -> tuple[float, ...]:
    """Refuse what is no task, no seed, or no number of starts; return the task's."""
    numbers = to_floats("task_deg", task_deg)
    if not np.isfinite(numbers).all():
        raise ValueError(f"task_deg={task_deg}; wanted a finite angle")
    wanted = (len(workspace.task_names),) if workspace.further else ()
    if numbers.shape != wanted:
        raise ValueError(
            f"task_deg={task_deg}; wanted {' and '.join(workspace.task_names)}"
        )
    check_whole("seed", seed, 0)
    check_whole("n_starts", n_starts, 0)
    return tuple(np.atleast_1d(numbers).tolist())


def _named(numbers: Sequence[float]) -> str:
    """Call a task by its angle, and whatever else it has."""
    angle, *others = numbers
    return ", ".join([f"{angle:g}°", *(f"{number:g}" for number in others)])


class _Task:
    """One task's runs of CMA-ES, each of which is told of those before it."""

    def __init__(
        self,
        workspace: Workspace,
        numbers: tuple[float, ...],
        seed: int,
        dmp: DMP,
        options: SearchOptions,
    ) -> None:
        angle, *others = numbers
        self._seed = [seed, round(1000 * angle) % 360_000]
        self._seed += [round(1e6 * number) % 2**32 for number in others]
        self._dmp, self._options, self._pays = dmp, options, workspace.cost
        task = numbers if others else angle
        self._sqrt_cov = initial_covariance(workspace, task, dmp)

    def run(
        self,
        runs: Sequence[CmaRun],
        given: tuple[str, NDArray[np.float64]] | None = None,
        seen: list[tuple[NDArray[np.float64], NDArray[np.float64]]] | None = None,
    ) -> Search[CmaRun]:
        """Run from a named policy, or from the next independent start."""
        # A generator of its own: it draws the same whatever else is searched.
        rng = np.random.default_rng([*self._seed, len(runs)])
        if given:
            (name, x0), step = given, self._options.small_step * self._dmp.spring
        else:
            number = sum(run.name.startswith("start") for run in runs)
            step = self._options.first_step * self._dmp.spring
            name, x0 = f"start {number}", random_start(number, step, self._dmp, rng)
        return minimize_steps(
            x0,
            step,
            rng,
            self._sqrt_cov,
            lambda rollouts: [cost(rollout, self._pays) for rollout in rollouts],
            name=name,
            known=runs,
            options=self._options,
            seen=seen,
        )


def random_start(
    number: int, width: float, dmp: DMP, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw where a run begins: the first at the zero policy, the others anywhere."""
    if number == 0:
        return np.zeros(dmp.n_params)
    return width * rng.standard_normal(dmp.n_params)


def initial_covariance(
    workspace: Workspace, task_deg: Task, dmp: DMP
) -> NDArray[np.float64]:
    """Guess how far CMA-ES should look in each direction.

    Of an end effector that moves freely, a link's length for every radian of a joint,
    the cost is quadratic in the policy. The inverse of that quadratic form, as the
    first covariance instead of the unit matrix, saves CMA-ES about half of its rollouts
    and leaves open where it goes.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees).
    dmp : DMP
        What a policy means.

    Returns
    -------
    ndarray of shape (n_params, n_params)
        A square root of the covariance, scaled to determinant 1.
    """
    physics, pays = workspace.physics, workspace.cost
    times = np.linspace(0, physics.duration, physics.n_moving + 1)
    home = workspace.home_of(task_deg)
    start = forward_kinematics(home, workspace.link_lengths)[-1]
    policies = np.vstack([np.zeros(dmp.n_params), np.eye(dmp.n_params)])
    paths = dmp.path(policies, start, workspace.target(task_deg), times)
    moved = paths[1:] - paths[0]
    speeds = np.gradient(moved, times, axis=1) / workspace.link_lengths[0]
    ends, speeds = moved[:, -1], speeds.reshape(dmp.n_params, -1)
    # The best covariance is the inverse Hessian (Hansen's tutorial, arXiv 1604.00772,
    # section 0.4); here that of what a weight does to the end point and the velocity.
    energy = pays.energy or ENERGY_WEIGHT  # any other price of moving is as good
    bend = pays.error * ends @ ends.T + energy * times[1] * speeds @ speeds.T
    bend += 1e-9 * np.trace(bend) * np.eye(dmp.n_params)  # where a weight does nothing
    root = np.linalg.cholesky(np.linalg.inv(bend))
    return np.asarray(root / np.exp(np.mean(np.log(np.diag(root)))))


@dataclass(frozen=True)
class SearchTrace:
    """One run of CMA-ES and all that it tried.

    Of a generation some policies are executed; the others, ranked by the surrogate
    alone, have NaN for what only a rollout tells.

    Attributes
    ----------
    run : CmaRun
        What was found, the same as in `SearchResult.runs`.
    policies : ndarray of shape (n_generations, n_policies, n_params)
        Weights of Eq. 7.
    costs : ndarray of shape (n_generations, n_policies)
        What each costs.
    joints : ndarray of shape (n_generations, n_policies, n_steps + 1, 3)
        What the arm did (rad).
    """

    run: CmaRun
    policies: NDArray[np.float64]
    costs: NDArray[np.float64]
    joints: NDArray[np.float64]

    @property
    def evaluations(self) -> NDArray[np.intp]:
        """Rollouts spent after each generation, of shape (n_generations,)."""
        return np.cumsum(np.isfinite(self.costs).sum(axis=1))

    @property
    def best_costs(self) -> NDArray[np.float64]:
        """Least cost up to each generation, of shape (n_generations,)."""
        return np.minimum.accumulate(np.nanmin(self.costs, axis=1))


def record_search(
    workspace: Workspace,
    task_deg: Task,
    *,
    seed: int,
    n_starts: int = 4,
    options: SearchOptions | None = None,
) -> list[SearchTrace]:
    """Search as `search_policy` does, and keep all that is executed.

    Parameters
    ----------
    workspace : Workspace
        The world.
    task_deg : float
        Task angle (degrees); where tasks have further numbers, a row of them.
    seed : int
        Seed of all random draws, together with the task and the start's number.
    n_starts : int, default=4
        Independent starts: from the zero policy, then from random ones.
    options : SearchOptions, optional
        How the search goes about it; by default ``SearchOptions()``.

    Returns
    -------
    list of SearchTrace
        One a start, in order.

    Raises
    ------
    ValueError
        If there is no start, or an argument is not a number as wanted.

    Examples
    --------
    >>> [trace] = record_search(Workspace.free(), 200, seed=1, n_starts=1)
    >>> bool(trace.best_costs[-1] == trace.run.cost < trace.best_costs[0])
    True
    """
    numbers = _check(workspace, task_deg, seed, n_starts)
    if n_starts < 1:
        raise ValueError(f"n_starts={n_starts}; wanted at least one")
    dmp, options = workspace.dmp, options or SearchOptions()
    task = _Task(workspace, numbers, seed, dmp, options)
    traces: list[SearchTrace] = []
    for _ in range(n_starts):
        seen: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
        search = task.run([trace.run for trace in traces], seen=seen)
        [(_, run)] = run_in_lockstep(workspace, [(task_deg, search)], dmp)
        policies, costs = map(np.array, zip(*seen, strict=True))
        executed, arm = np.isfinite(costs), cached_arm(workspace, dmp)
        rollouts = arm.execute_many(policies[executed], task_deg)  # as they did before
        joints = np.full((*costs.shape, *rollouts[0].joints.shape), np.nan)
        joints[executed] = [rollout.joints for rollout in rollouts]
        traces.append(SearchTrace(run, policies, costs, joints))
    return traces
