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
    told = {"cwd": file.parent, "capture_output": True, "check": False}
    listing = ["git", "ls-files", "--stage", "--full-name", "-z", "--", file.name]
    with suppress(FileNotFoundError):
        entry = subprocess.run(listing, **told).stdout
        subprocess.run(
            ["git", "update-index", "-z", "--index-info"], input=entry, **told
        )
