"""What each rollout of a search cost: how fast it gets where it gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from msc.robot import Workspace, check_policies
from msc.search._lockstep import Search, run_in_lockstep
from msc.search._options import SearchOptions
from msc.search._policy import SearchResult, cost, search_steps


@dataclass(frozen=True, eq=False)
class SearchCurve:
    """A search, and what its rollouts cost.

    Attributes
    ----------
    result : SearchResult
        What was found.
    costs : ndarray of shape (n_rollouts,)
        Cost of each rollout, in the order in which they were asked for; that of a given
        start comes first.
    """

    result: SearchResult
    costs: NDArray[np.float64]

    @property
    def best_costs(self) -> NDArray[np.float64]:
        """Least cost after each rollout, of shape (n_rollouts,)."""
        return np.minimum.accumulate(self.costs)


def search_curves(
    workspace: Workspace,
    tasks_deg: Sequence[float],
    start_policies: ArrayLike | None = None,
    *,
    seed: int,
    n_starts: int | None = None,
    options: SearchOptions | None = None,
) -> list[SearchCurve]:
    """Search the policies of several tasks, and keep what each rollout cost.

    Parameters
    ----------
    workspace : Workspace
        The world.
    tasks_deg : sequence of float
        Task angles (degrees).
    start_policies : array_like of shape (n_tasks, n_params), optional
        Where the search of each task begins, with a small first step: it is executed
        first.
    seed : int
        Seed of all random draws, as of `search_policy`.
    n_starts : int, optional
        Independent starts a task, after the given one; by default none, or four if none
        is given.
    options : SearchOptions, optional
        How the searches go about it; by default ``SearchOptions()``.

    Returns
    -------
    list of SearchCurve
        One a task; what `search_policy` finds with the same start.

    Raises
    ------
    ValueError
        If there are not as many policies as tasks.

    Examples
    --------
    >>> brief = SearchOptions(max_evaluations=20)
    >>> [curve] = search_curves(
    ...     Workspace.free(), [200], np.zeros((1, 6)), seed=1, options=brief
    ... )
    >>> len(curve.costs) == 1 + curve.result.evaluations
    True
    """
    starts: Sequence[NDArray[np.float64] | None] = [None] * len(tasks_deg)
    if start_policies is not None:
        given = check_policies(start_policies, workspace.dmp.n_params)
        starts = list(np.atleast_2d(given))
    if len(starts) != len(tasks_deg):
        raise ValueError(
            f"start_policies has {len(starts)} policies; wanted {len(tasks_deg)}, one "
            "a task"
        )
    if n_starts is None:
        n_starts = 4 if start_policies is None else 0

    def steps(
        task: float, start: NDArray[np.float64] | None
    ) -> Search[tuple[SearchResult, list[float]]]:
        given = [] if start is None else [start]
        search = search_steps(
            workspace,
            task,
            seed=seed,
            n_starts=n_starts,
            start_policies=given,
            options=options,
        )
        paid: list[float] = []
        for policy in given:
            [rollout] = yield policy[np.newaxis]
            paid.append(cost(rollout, workspace.cost))
        asked = next(search)
        while True:
            rollouts = yield asked
            paid += [cost(rollout, workspace.cost) for rollout in rollouts]
            try:
                asked = search.send(rollouts)
            except StopIteration as end:
                return end.value, paid[:-1]  # the last only looked at the policy again

    searches = [
        (task, steps(task, start))
        for task, start in zip(tasks_deg, starts, strict=True)
    ]
    found = dict(run_in_lockstep(workspace, searches))
    ordered = [found[number] for number in range(len(searches))]
    return [SearchCurve(result, np.array(paid)) for result, paid in ordered]
