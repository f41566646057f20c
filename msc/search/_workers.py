"""Who does the work: processes on this machine, or a Dask cluster."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed, parallel_config

from msc._parallel import WorkersLost, telling_of_killed_workers
from msc.search._journal import identify_code

Run = Callable[[Callable[..., Any], Iterable[tuple[Any, ...]]], Iterable[Any]]

PATIENCE = 10  # seconds, with a Dask scheduler that does not answer


@contextmanager
def open_workers(jobs: int = 1, dask: str | None = None) -> Iterator[Run]:
    """Give what calls a function many times, in parallel.

    Parameters
    ----------
    jobs : int, default=1
        Worker processes on this machine.
    dask : str, optional
        Address of a Dask scheduler, ``"tcp://host:port"``, whose workers are used
        instead. A task whose worker dies is given to another. At ``"tls://host:port"``
        the certificate is used that Dask's own settings name.

    Yields
    ------
    callable
        Takes a function and tuples of arguments; gives results as they come.

    Raises
    ------
    ValueError
        If `dask` is not installed or lacks a certificate, nothing answers at the
        address within ten seconds, there are no workers, or they have another `msc`
        than is here.
    WorkersLost
        If a worker process is killed meanwhile, or crashes; if that happens to every
        worker of Dask's that a task was given to; or if its scheduler is gone.

    Notes
    -----
    Dask's own futures, not joblib's backend for it: that one waits forever where Dask
    gives up.

    Examples
    --------
    >>> with open_workers() as run:
    ...     list(run(pow, [(2, 3), (3, 2)]))
    [8, 9]
    """
    if dask is not None:
        with _connect(dask) as run:
            yield run
        return
    with (
        telling_of_killed_workers(),
        parallel_config("loky", n_jobs=jobs, inner_max_num_threads=1),
    ):
        yield lambda function, calls: Parallel(return_as="generator_unordered")(
            delayed(function)(*call) for call in calls
        )


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


@contextmanager
def _connect(address: str) -> Iterator[Run]:
    """Use the workers of a Dask scheduler."""
    try:
        from distributed import Client, KilledWorker, as_completed  # noqa: PLC0415
        from distributed.client import FutureCancelledError  # noqa: PLC0415
    except ImportError:
        raise ValueError("dask: wanted the extra, pip install 'msc[cluster]'") from None
    if address.startswith("tls://"):
        _check_certificate(address)
    with _silenced("distributed.client"), Client(address, timeout=PATIENCE) as client:
        try:
            code = client.run(identify_code)
        except Exception as error:  # whatever a worker without msc makes of it
            raise ValueError(f"dask: a worker of {address} fails: {error}") from None
        if not code:
            raise ValueError(
                f"dask: {address} has no workers; start some, dask worker {address}"
            )
        other = [worker for worker, found in code.items() if found != identify_code()]
        if other:
            raise ValueError(f"dask: other code than here on {', '.join(other)}")

        def run(
            function: Callable[..., Any], calls: Iterable[tuple[Any, ...]]
        ) -> Iterator[Any]:
            futures = [client.submit(function, *call, pure=False) for call in calls]
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
