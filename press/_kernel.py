"""The kernel of the chapters: IPython's own, which writes down what a chapter reads.

`python _kernel.py LOG FOLDER … -f CONNECTION` is started by papermill. Each file of a
folder that the chapter opens for reading, a module at its import or a table, goes to
the log as a line, with the checksum of what was read; so does the name of each package
imported, or loaded for all chapters. That is what the outputs depend on: nothing is
declared, so nothing can be forgotten. Not seen are files that only a process started by
the chapter reads, those that C libraries open, and whether a file exists that is never
opened.

Figures are kept as PNG and as SVG, without dates.
"""

import hashlib
import json
import os
import sys
import warnings
from collections.abc import Sequence
from importlib.util import source_from_cache
from pathlib import Path
from typing import Any

FIGURES = {
    "figure_formats": {"png", "svg"},
    "print_figure_kwargs": {"bbox_inches": "tight", "metadata": {"Date": None}},
}


def watch(log: Path, folders: Sequence[Path]) -> None:
    """Write down what this process reads of these folders, and imports, from now on.

    A line of the log is ``{"file": path, "sha256": digest}``, the digest empty where
    there was no file, or ``{"package": name}``.
    """
    own = tuple(f"{folder.resolve()}{os.sep}" for folder in folders)
    known: set[str] = set()

    def note(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "import":
            entry = {"package": arguments[0].partition(".")[0]}
        elif event == "open" and isinstance(arguments[0], str | bytes):
            path = source_of(os.path.realpath(os.fsdecode(arguments[0])))
            inside = next((path[len(top) :] for top in own if path.startswith(top)), "")
            if path in known or not inside or is_aside(inside):
                return
            known.add(path)
            if arguments[2] & os.O_ACCMODE != os.O_RDONLY:
                return  # what a chapter writes itself is no input
            entry = {"file": path, "sha256": digest(Path(path))}
        else:
            return
        line = json.dumps(entry)
        if line not in known:
            known.add(line)
            with log.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")

    for name in {name.partition(".")[0] for name in sys.modules}:
        note("import", (name,))
    for file in (__file__, str(Path(__file__).with_name("_warm.py"))):
        note("open", (file, "r", os.O_RDONLY))
    sys.addaudithook(note)


def source_of(path: str) -> str:
    """Return the module that a file of bytecode was compiled from, or the file itself.

    >>> source_of("/arm/__pycache__/_dmp.cpython-311.pyc")
    '/arm/_dmp.py'
    >>> source_of("/data/free.csv")
    '/data/free.csv'
    """
    if "__pycache__" not in path:
        return path
    path = path[: path.rfind(".pyc") + len(".pyc")]  # without a writer's number
    try:
        return source_from_cache(path)
    except ValueError:
        return path


def is_aside(inside: str) -> bool:
    """Tell what, within a repository, is not of it: what is hidden or built.

    >>> [is_aside(path) for path in ("data/free.csv", ".venv/a.py", "_build/b.json")]
    [False, True, True]
    """
    parts = Path(inside).parts
    return parts[0] == "_build" or any(part.startswith(".") for part in parts)


def digest(path: Path) -> str:
    """Identify the content of a file by its SHA-256; empty if there is no such file."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


def main() -> None:
    """Watch, then be IPython's kernel."""
    del sys.path[0]  # this file's folder: its modules are no packages
    options = sys.argv.index("-f")
    log, *folders = map(Path, sys.argv[1:options])
    # matplotlib warns if this takes a second: on a busy machine, and not on another.
    warnings.filterwarnings("ignore", "Creating legend with loc")
    watch(log, folders)
    from ipykernel.kernelapp import launch_new_instance  # noqa: PLC0415
    from traitlets.config import Config  # noqa: PLC0415

    launch_new_instance(
        argv=sys.argv[options:], config=Config({"InlineBackend": FIGURES})
    )


if __name__ == "__main__":
    main()
