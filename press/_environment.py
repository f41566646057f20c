"""The environment of the processes that make the book: chosen, not inherited.

What a reader happens to have set (a backend, a locale, a time zone, warnings, threads,
folders of settings) would change pictures, numbers or bytes. So a process that executes
a chapter, renders or prints gets the little that the machine itself needs, what is
chosen here, and a home that holds nothing but Matplotlib's list of fonts.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from importlib import metadata
from pathlib import Path

# Without these some machines run nothing.
_MACHINE = (
    "PATH",
    "LD_LIBRARY_PATH",
    "LD_PRELOAD",
    "DYLD_LIBRARY_PATH",
    "DYLD_FALLBACK_LIBRARY_PATH",
    "SYSTEMROOT",
)
# With these a processor computes by other instructions, or without a library's fault.
_SWITCHES = (
    "OPENBLAS_CORETYPE",
    "OPENBLAS_L2_SIZE",
    "NPY_DISABLE_CPU_FEATURES",
    "GLIBC_TUNABLES",
)
_CHOSEN = {
    "COLUMNS": "80",
    "JUPYTER_NO_CONFIG": "1",
    "LC_ALL": "C.UTF-8",
    "MPLBACKEND": "module://matplotlib_inline.backend_inline",
    "OMP_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
    "PYTHONNOUSERSITE": "1",
    "PYTHONUTF8": "1",
    "TZ": "UTC",
}


def chosen() -> dict[str, str]:
    """Return what outputs may depend on.

    Returns
    -------
    dict of str to str
        What the build chooses, and what the machine has set of its processor's
        switches.

    Examples
    --------
    >>> chosen()["TZ"]
    'UTC'
    """
    return _CHOSEN | _inherited(_SWITCHES)


def environment(cache: Path) -> dict[str, str]:
    """Return the environment of a process that takes part in making the book.

    Parameters
    ----------
    cache : Path
        Folder of earlier runs. It gets a folder `home`, unless it has one; with
        Matplotlib's list of fonts, which would else be made, and told of, in chapters.

    Returns
    -------
    dict of str to str
        Every variable of the process.
    """
    home = cache.resolve() / "home"
    settings = home / f"matplotlib-{metadata.version('matplotlib')}"
    own = {"HOME": str(home), "MPLCONFIGDIR": str(settings), "TMPDIR": _scratch(home)}
    given = _inherited(_MACHINE) | chosen() | own
    if not settings.exists():
        home.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=home) as new:
            subprocess.run(
                [sys.executable, "-c", "import matplotlib.font_manager"],
                env=given | {"MPLCONFIGDIR": new},
                capture_output=True,
                check=True,
            )
            with suppress(OSError):  # another process was faster
                Path(new).rename(settings)
    return given


def _inherited(names: tuple[str, ...]) -> dict[str, str]:
    return {name: os.environ[name] for name in names if name in os.environ}


def _scratch(home: Path) -> str:
    """Name a folder for temporary files: the system's, if one may write there."""
    try:
        return tempfile.gettempdir()
    except FileNotFoundError:
        return str(home)
