"""Many calls of one function on the cores of this machine, results in their order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from joblib import Parallel, delayed, parallel_config
from threadpoolctl import threadpool_limits
from tqdm import tqdm

SECONDS = 2.0  # of a fit without a word
MANY = 300  # tasks; one regression of more may take that long


def tell(
    steps: Iterable[Any], what: str, *, total: int, n_tasks: int, verbose: bool | None
) -> Any:
    """Show how far a fit is, and how long the rest may take, if it takes long.

    Parameters
    ----------
    steps : iterable
        Its steps.
    what : str
        What they are.
    total : int
        How many.
    n_tasks : int
        Tasks of the largest; above 300 the bar is there from the beginning, otherwise
        after two seconds.
    verbose : bool or None
        Whether to show it; None: if standard error is a terminal.

    Returns
    -------
    tqdm
        The steps again; the bar goes away at their end.

    Examples
    --------
    >>> list(tell("abc", "letters", total=3, n_tasks=9, verbose=False))
    ['a', 'b', 'c']
    """
    return tqdm(
        steps,
        desc=f"fit to {n_tasks} tasks",
        total=total,
        unit=f" {what}",
        delay=0.0 if n_tasks > MANY else SECONDS,
        disable=None if verbose is None else not verbose,
        leave=False,
        dynamic_ncols=True,
    )


class WorkersLost(RuntimeError):
    """Those who do the work ended before it was done."""


@contextmanager
def telling_of_killed_workers() -> Iterator[None]:
    """Have joblib's error about a worker that is gone say it in a sentence.

    Raises
    ------
    WorkersLost
        If a worker process is killed meanwhile, or crashes.
    """
    try:
        yield
    except BrokenProcessPool:
        raise WorkersLost(
            "a worker was killed, as the system does when memory runs out"
        ) from None


def call_in_order(
    function: Callable[..., Any],
    calls: Iterable[tuple[Any, ...]],
    *,
    jobs: int = 1,
    label: str,
    progress: bool = False,
) -> list[Any]:
    """Call a function many times in processes here; results in the order of calls.

    Parameters
    ----------
    function : callable
        What to call.
    calls : iterable of tuple
        Its arguments, one tuple a call.
    jobs : int, default=1
        Worker processes; the result does not depend on them.
    label : str
        What the progress bar says.
    progress : bool, default=False
        Whether to show one on standard error.

    Returns
    -------
    list
        What the calls returned.

    Raises
    ------
    WorkersLost
        If a worker process is killed meanwhile, or crashes.

    Notes
    -----
    One thread a process, one process included: a matrix product on two threads adds up
    in another order, and two processes of two threads each are slower.

    Examples
    --------
    >>> call_in_order(pow, [(2, 3), (3, 2)], label="powers")
    [8, 9]
    """
    listed = list(calls)
    with (
        telling_of_killed_workers(),
        threadpool_limits(1),
        parallel_config("loky", n_jobs=jobs, inner_max_num_threads=1),
    ):
        found = Parallel(return_as="generator")(
            delayed(function)(*call) for call in listed
        )
        return list(tqdm(found, desc=label, total=len(listed), disable=not progress))
