"""Git beside JupyterLab: a chapter that was only run is no change.

Git's filter leaves the outputs out, but git takes a file of another size for changed
before it filters anything. So `make lab` has it forget the size after each save.
"""

import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any


def forget_size(os_path: str, **_: Any) -> None:
    """Write a file's entry in git's index as it is, but without the file's size.

    What is staged stays as it is. Without git, or outside of it, nothing happens.
    """
    file = Path(os_path)

    def git(*arguments: str, told: bytes = b"") -> bytes:
        command = ["git", *arguments]
        return subprocess.run(
            command, cwd=file.parent, input=told, capture_output=True, check=False
        ).stdout

    with suppress(FileNotFoundError):
        entry = git("ls-files", "--stage", "--full-name", "-z", "--", file.name)
        git("update-index", "-z", "--index-info", told=entry)
