"""Who does the work, and how far it is.

One runner calls a function many times: in processes on this machine, or on the workers
of a Dask cluster.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config
from threadpoolctl import threadpool_limits
from tqdm import tqdm

QUIET_SECONDS = 2.0  # of a fit without a word
MANY = 300  # tasks; one regression of more may take that long
ANSWER_SECONDS = 10  # in which a Dask scheduler has to answer

# Calls a function with each tuple of arguments; gives the calls' numbers and results.
Runner = Callable[
    [Callable[..., Any], Iterable[tuple[Any, ...]]], Iterable[tuple[int, Any]]
]


def tell(
    steps: Sequence[Callable[[], Any]], what: str, *, n_tasks: int, verbose: bool | None
) -> Any:
    """Take the steps of a fit, and show how far it is, if it takes long.

    Parameters
    ----------
    steps : sequence of callable
        Its steps.
    what : str
        What they are.
    n_tasks : int
        Tasks of the largest; above 300 the bar is there from the beginning, otherwise
        after two seconds.
    verbose : bool or None
        Whether to show it; None: if standard error is a terminal.

    Returns
    -------
    tqdm
        What the steps return, each taken as it is asked for; the bar goes away at
        their end.

    Examples
    --------
    >>> list(tell([dict, list], "steps", n_tasks=9, verbose=False))
    [{}, []]
    """
    return tqdm(
        (step() for step in steps),
        desc=f"fit to {n_tasks} tasks",
        total=len(steps),
        unit=f" {what}",
        delay=0.0 if n_tasks > MANY else QUIET_SECONDS,
        disable=None if verbose is None else not verbose,
        leave=False,
        dynamic_ncols=True,
    )


class WorkersLost(RuntimeError):
    """Those who do the work ended before it was done."""


@contextmanager
def open_workers(
    jobs: int = 1, dask: str | None = None, *, code: Callable[[], str] = str
) -> Iterator[Runner]:
    """Give what calls a function many times, in parallel.

    Parameters
    ----------
    jobs : int, default=1
        Worker processes on this machine.
    dask : str, optional
        Address of a Dask scheduler, ``"tcp://host:port"``, whose workers are used
        instead. A task whose worker dies is given to another. At ``"tls://host:port"``
        the certificate is used that Dask's own settings name.
    code : callable, optional
        Identifies the code that is run; Dask's workers have to say the same of theirs.

    Yields
    ------
    callable
        Takes a function and tuples of arguments; gives pairs of a call's number and
        its result, as they come.

    Raises
    ------
    ValueError
        If `dask` is not installed, lacks a certificate or is no address, nothing
        answers there within ten seconds, there are no workers, or they have another
        `msc` than is here.
    WorkersLost
        If a worker process is killed meanwhile, or crashes; if that happens to every
        worker of Dask's that a task was given to; or if its scheduler is gone.

    Notes
    -----
    One thread a process, one process included: a matrix product on two threads adds up
    in another order, and two processes of two threads each are slower.

    Dask's own futures, not joblib's backend for it: that one waits forever where Dask
    gives up.

    Examples
    --------
    >>> with open_workers() as run:
    ...     list(run(pow, [(2, 3), (3, 2)]))
    [(0, 8), (1, 9)]
    """
    if dask is not None:
        with _connect(dask, code) as run:
            yield run
        return
    try:
        with (
            threadpool_limits(1),
            parallel_config("loky", n_jobs=jobs, inner_max_num_threads=1),
        ):
            yield lambda function, calls: Parallel(return_as="generator_unordered")(
                delayed(_call)(number, function, arguments)
                for number, arguments in enumerate(calls)
            )
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

    Examples
    --------
    >>> call_in_order(pow, [(2, 3), (3, 2)], label="powers")
    [8, 9]
    """
    listed = list(calls)
    with open_workers(jobs) as run:
        pairs = run(function, listed)
        found = dict(tqdm(pairs, desc=label, total=len(listed), disable=not progress))
    return [found[number] for number in range(len(listed))]


def _call(
    number: int, function: Callable[..., Any], arguments: tuple[Any, ...]
) -> tuple[int, Any]:
    """Do one call, in a worker."""
    return number, function(*arguments)


@contextmanager
def _connect(address: str, code: Callable[[], str]) -> Iterator[Runner]:
    """Use the workers of a Dask scheduler."""
    try:
        from distributed import KilledWorker, as_completed  # noqa: PLC0415
        from distributed.client import FutureCancelledError  # noqa: PLC0415
    except ImportError:
        raise ValueError("dask: wanted the extra, pip install 'msc[cluster]'") from None
    if address.startswith("tls://"):
        _check_certificate(address)
    with _silenced("distributed.client"), _reach(address) as client:
        try:
            theirs = client.run(code)
        except Exception as error:  # whatever a worker without msc makes of it
            raise ValueError(f"dask: a worker of {address} fails: {error}") from None
        if not theirs:
            raise ValueError(
                f"dask: {address} has no workers; start some, dask worker {address}"
            )
        other = [worker for worker, found in theirs.items() if found != code()]
        if other:
            raise ValueError(f"dask: other code than here on {', '.join(other)}")

        def run(
            function: Callable[..., Any], calls: Iterable[tuple[Any, ...]]
        ) -> Iterator[tuple[int, Any]]:
            futures = [
                client.submit(_call, number, function, arguments, pure=False)
                for number, arguments in enumerate(calls)
            ]
            for future in as_completed(futures):
                try:
                    yield future.result()
                except KilledWorker:
                    raise WorkersLost(
                        "dask: every worker that a task was given to was killed, as "
                        "systems do when memory runs out"
                    ) from None
                except FutureCancelledError:
                    raise WorkersLost(
                        f"dask: the connection to the scheduler {address} was lost"
                    ) from None

        yield run


def _reach(address: str) -> Any:
    """Return a client of a Dask scheduler, or say why there is none."""
    from distributed import Client  # noqa: PLC0415

    try:
        return Client(address, timeout=ANSWER_SECONDS)
    except Exception as error:  # whatever Dask makes of an address
        raise ValueError(
            f"dask={address!r}: {error}; wanted a scheduler's tcp://host:port, or tls://"
        ) from None


def _check_certificate(address: str) -> None:
    """Refuse to connect by TLS where Dask's settings name no certificate."""
    from dask import config  # noqa: PLC0415

    for name in ("ca-file", "client.cert"):
        setting = f"distributed.comm.tls.{name}"
        if not (file := config.get(setting, None)):
            raise ValueError(f"dask: {address} wants TLS, but {setting} is not set")
        if not Path(file).is_file():
            raise ValueError(f"dask: {setting} is {file!r}, but there is no such file")


@contextmanager
def _silenced(name: str) -> Iterator[None]:
    """Keep a library from logging what is told of by an exception."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)
