"""Processes that take part in making the book, and their environment.

The environment of the processes that make the book is chosen, not inherited, and part
of the record. What a reader happens to have set (a backend, a locale, a time zone,
warnings, threads, folders of settings) would change pictures, numbers or bytes. So a
process that executes a chapter, renders or prints gets the little that the machine
itself needs, what is chosen here, and a home that holds nothing but Matplotlib's list
of fonts.

What most chapters import is loaded once for all that are executed (`press._warm`). A
repository lists it as `loads` below `tool.press` in its `pyproject.toml`.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
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
_HERE = Path(__file__).resolve()
_TOOL, _WARM = _HERE.with_name("_tool.py"), _HERE.with_name("_warm.py")
_LOADS = "papermill.cli", "ipykernel.kernelapp"  # for whatever chapter
_MATPLOTLIBRC = "svg.hashsalt: msc\n"  # any word: it is the same in every run


@contextmanager
def warm_python(root: Path, cache: Path) -> Iterator[list[str]]:
    """Have a Python load what chapters import; give what a command begins with.

    Without pidfds, which only Linux has, it is an ordinary Python.
    """
    if not hasattr(os, "pidfd_open"):
        yield [sys.executable]
        return
    with tempfile.TemporaryDirectory() as folder:
        address = str(Path(folder, "socket"))
        command = [sys.executable, str(_WARM), "serve", address, *_loads(root)]
        with subprocess.Popen(
            command,
            cwd=folder,
            env=environment(cache),
            stdin=subprocess.PIPE,  # closed at the end, whatever happens
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C goes to those who ask
        ) as process:
            if not (process.stdout and process.stdout.readline()):
                raise ChildProcessError("the process that runs chapters did not start")
            yield [sys.executable, "-IS", str(_WARM), "ask", address]


def _loads(root: Path) -> list[str]:
    """Name the modules that are loaded once: the tools', and the repository's."""
    file = root / "pyproject.toml"
    settings = tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
    return [*_LOADS, *settings.get("tool", {}).get("press", {}).get("loads", ())]


def run_tool(
    name: str,
    arguments: Sequence[str | Path],
    *,
    cache: Path,
    python: Sequence[str] = (sys.executable,),
    **variables: str,
) -> subprocess.CompletedProcess[str]:
    """Run a Python command-line tool, "module:function", in a process of its own.

    Its environment is the chosen one, and the variables given besides.
    """
    return subprocess.run(
        [*python, str(_TOOL), name, *map(str, arguments)],
        env=environment(cache) | variables,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )


def chosen() -> dict[str, str]:
    """Return what outputs may depend on: chosen, or the processor's switches.

    >>> chosen()["TZ"]
    'UTC'
    """
    return _CHOSEN | _inherited(_SWITCHES)


def environment(cache: Path) -> dict[str, str]:
    """Return every variable of a process that takes part in making the book.

    The cache gets a folder `home`, unless it has one; with Matplotlib's list of fonts,
    which would else be made, and told of, in chapters, and with its settings: names in
    SVG do not change from run to run.
    """
    home = cache.resolve() / "home"
    settings = home / f"settings-{metadata.version('matplotlib')}"
    own = {"HOME": str(home), "MPLCONFIGDIR": str(settings), "TMPDIR": _scratch(home)}
    given = _inherited(_MACHINE) | chosen() | own
    if not settings.exists():
        home.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=home) as new:
            Path(new, "matplotlibrc").write_text(_MATPLOTLIBRC, encoding="utf-8")
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
    """Return those variables of this process that are set."""
    return {name: os.environ[name] for name in names if name in os.environ}


def _scratch(home: Path) -> str:
    """Name a folder for temporary files: the system's, if one may write there."""
    try:
        return tempfile.gettempdir()
    except FileNotFoundError:
        return str(home)
