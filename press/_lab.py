"""Git beside JupyterLab: a chapter that was only run is no change.

Git's filter leaves the outputs out, but git tells from a file's size alone that it has
changed. So `make lab` has it look again after each save.
"""

import subprocess
from contextlib import suppress
from pathlib import Path
from threading import Lock, Thread
from typing import Any

_LOCK = Lock()  # of git's index


def after_save(os_path: str, **_: Any) -> None:
    """Have git look at a file again, beside what JupyterLab does."""
    Thread(target=look_again, args=[Path(os_path)]).start()


def look_again(file: Path) -> None:
    """Take a file's new size into git's index, if its filter leaves nothing else."""

    def git(*arguments: str) -> bool:
        command = ["git", *arguments, "--", file.name]
        done = subprocess.run(command, cwd=file.parent, capture_output=True, check=False)
        return done.returncode == 0

    with _LOCK, suppress(FileNotFoundError):  # there is no git
        if git("diff", "--quiet"):
            git("add", "--update")
