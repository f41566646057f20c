"""A Python that has loaded what takes long, and is there at once for each script.

`python _warm.py serve SOCKET MODULE …` loads modules and says that it is ready. From
then on, until its standard input is closed, `python _warm.py ask SOCKET SCRIPT …` does
what `python SCRIPT …` does, but in a copy (a fork) of the process that serves. The copy
has the working directory, the variables and the streams of the one that asks, gets its
signals, gives it its exit code, and ends with it.
"""

import json
import os
import select
import signal
import socket
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

STREAMS = (0, 1, 2)


def serve(address: str, modules: Sequence[str]) -> list[str]:
    """Load modules and make copies; return in each of them, with its script's words."""
    import gc  # noqa: PLC0415 (who asks needs neither)
    from pkgutil import resolve_name  # noqa: PLC0415

    sys.modules["rfc3987_syntax"] = None  # type: ignore[assignment] # see `_tool`
    for name in modules:
        with suppress(ModuleNotFoundError):  # then no script can want it
            resolve_name(name)
    gc.freeze()  # what no collection visits, copies go on sharing
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those who mind
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        os.write(1, b"ready\n")
        while 0 not in _ready(0, listener):
            connection, _ = listener.accept()
            if not os.fork():
                listener.close()
                return _mind(connection)
            connection.close()
    sys.exit()


def _mind(connection: socket.socket) -> list[str]:
    """Make the copy that was asked for and see to its end; return in the copy."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    _, streams, _, _ = socket.recv_fds(connection, 1, len(STREAMS))
    with connection.makefile("rb") as told:
        folder, variables, words = json.loads(told.readline())
    copy = os.fork()
    if not copy:
        connection.close()
        for stream, number in zip(streams, STREAMS, strict=True):
            os.dup2(stream, number)
            os.close(stream)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(variables)
        if "JPY_PARENT_PID" in variables:  # a kernel ends when that is not its parent
            os.environ["JPY_PARENT_PID"] = str(os.getppid())
        return list(words)
    for stream in streams:
        os.close(stream)
    connection.sendall(b"%d\n" % copy)
    end = os.pidfd_open(copy)
    if end not in _ready(0, connection, end):
        os.kill(copy, signal.SIGKILL)  # nobody wants it any more
    code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    with suppress(OSError):
        connection.sendall(b"%d\n" % code)
    os._exit(0)


def _ready(*files: Any) -> list[Any]:
    """Wait until some of these files can be read, or are at their end."""
    return select.select(files, [], [])[0]


def ask(address: str, words: Sequence[str]) -> int:
    """Have a copy run a script; return its exit code, as a shell gives it."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(address)
        socket.send_fds(connection, [b"\n"], STREAMS)
        told = json.dumps([os.fspath(Path.cwd()), dict(os.environ), words])
        connection.sendall(f"{told}\n".encode())
        with connection.makefile("rb") as heard:
            copy = int(heard.readline())
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, lambda number, _: os.kill(copy, number))
            code = int(heard.readline() or 1)
    return code if code >= 0 else 128 - code


def main() -> None:
    """Serve or ask; in a copy, be the script."""
    task, address, *words = sys.argv[1:]
    if task == "ask":
        sys.exit(ask(address, words))
    del sys.path[0]  # this file's folder: its modules are no packages
    words = serve(address, words)
    from runpy import run_path  # noqa: PLC0415

    sys.argv = words
    sys.path.insert(0, os.fspath(Path(words[0]).parent))
    run_path(words[0], run_name="__main__")


if __name__ == "__main__":
    main()
