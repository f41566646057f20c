"""Execute the book's chapters: each once, by papermill, and again only when needed.

A chapter is a notebook without outputs. Its last run with certain parameters is kept in
a cache, with a record of what it depended on. A run holds as long as the code cells are
the same, every file that it read (see `press._kernel`) has the content it had then, and
every package that it imported has the version it had then. Only a change of one of
these executes a chapter again, and the reason is told; an edit of the prose never does.
A run that wrote to stderr is not kept.

What is loaded once for all that are executed (see `press._warm`), a repository lists as
`loads` below `tool.press` in its `pyproject.toml`.

The environment of the processes that make the book is chosen, not inherited, and part
of the record. What a reader happens to have set (a backend, a locale, a time zone,
warnings, threads, folders of settings) would change pictures, numbers or bytes. So a
process that executes a chapter, renders or prints gets the little that the machine
itself needs, what is chosen here, and a home that holds nothing but Matplotlib's list
of fonts.
"""

import functools
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from tqdm import tqdm

from press._kernel import digest
from press._notebook import (
    Notebook,
    NotebookCell,
    code_cells,
    complaints,
    failure,
    parameters,
    read_notebook,
    source,
    tags,
    with_outputs,
    without_picture,
    write_notebook,
)
from press._parameters import check

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
_TOOL, _KERNEL, _WARM = (
    Path(__file__).resolve().with_name(f"_{name}.py")
    for name in ("tool", "kernel", "warm")
)
_LOADS = "papermill.cli", "ipykernel.kernelapp"  # for whatever chapter
_MATPLOTLIBRC = "svg.hashsalt: msc\n"  # any word: it is the same in every run
_NAMED = 4  # of the files that changed; the others are counted


class BookError(RuntimeError):
    """A chapter failed, or the book did not render."""


class ChapterError(BookError):
    """A chapter failed: which, after how many seconds, and how far it came."""

    def __init__(self, name: str, words: str, seconds: float, run: Notebook | None):
        super().__init__(f"{name}, {words}")
        self.name, self.words = name, words
        self.seconds, self.run = seconds, run  # no run: it did not even begin


@dataclass(frozen=True)
class Record:
    """What a run depended on, and how long it took."""

    code: str  # digest of the code cells
    files: dict[str, str]  # read: path relative to the repository, and SHA-256
    packages: dict[str, str]  # imported: distribution and version; and Python's own
    environment: dict[str, str]  # what was chosen of it
    seconds: float  # wall time, the start of the kernel included

    def changes(self, code: str, root: Path) -> list[str]:
        """Say what has changed since the run, a reason each; none if it still holds."""
        reasons = [] if code == self.code else ["its code cells changed"]
        now = {name: digest(root / name) for name in self.files}
        changed = [name for name, content in self.files.items() if content != now[name]]
        if changed:
            more = len(changed) - _NAMED
            further = f" and {more} more" if more > 0 else ""
            reasons.append(f"{', '.join(changed[:_NAMED])}{further} changed")
        for name, version in self.packages.items():
            if (installed := version_of(name)) != version:
                reasons.append(f"{name} {version} became {installed or 'missing'}")
        present = chosen()
        for name in sorted({*present, *self.environment}):
            then, is_now = (
                one.get(name, "unset") for one in (self.environment, present)
            )
            if then != is_now:
                reasons.append(f"{name} {then} became {is_now}")
        return reasons


@dataclass(frozen=True)
class Chapter:
    """A chapter that has been executed."""

    name: str  # its file's, without the ending
    notebook: Notebook  # current text and code, with the outputs of the run
    record: Record  # of that run
    parameters: dict[str, Any]  # the values it was given; others are as declared
    reasons: str = ""  # why it was executed; none if an earlier run holds


def run_chapters(
    given: Mapping[Path, Mapping[str, Any]],
    *,
    root: Path,
    cache: Path,
    jobs: int = 2,
    say: Callable[[str], object] | None = None,
    failed: list[ChapterError] | None = None,
) -> list[Chapter]:
    """Return chapters with their outputs, executing those whose runs hold no longer.

    Each is given values of some of its parameters; all are checked before any chapter
    is executed. A cell that fails, or shows no picture though it has alternative text
    for one, is a ChapterError; what has finished by then stays in the cache. With a
    list of those that `failed`, they are added to it, and the others go on.
    """
    if jobs < 1:
        raise ValueError(f"jobs={jobs}; wanted at least 1")
    checked = {path: read_chapter(path, values) for path, values in given.items()}
    with (
        _Warm(root, cache) as python,
        ThreadPoolExecutor(jobs) as pool,
        tqdm(total=len(given), desc="chapters", disable=None) as progress,
    ):
        futures = [
            pool.submit(_run, path, *chapter, root=root, python=python, say=say)
            for path, chapter in checked.items()
        ]
        try:
            for future in as_completed(futures):
                if failed is None or not isinstance(future.exception(), ChapterError):
                    future.result()
                progress.update()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    errors = [future.exception() for future in futures]
    if failed is not None:
        failed += [error for error in errors if isinstance(error, ChapterError)]
    return [
        one.result() for one, error in zip(futures, errors, strict=True) if not error
    ]


def find_changed(
    given: Mapping[Path, Mapping[str, Any]], *, root: Path, cache: Path
) -> dict[str, str]:
    """Say which chapters `run_chapters` would execute, and why; execute none."""
    checked = {path: read_chapter(path, values) for path, values in given.items()}
    reasons = {
        path.stem: _kept(path, *chapter, root=root, cache=cache).reasons
        for path, chapter in checked.items()
    }
    return {name: words for name, words in reasons.items() if words}


def read_chapter(
    path: Path, given: Mapping[str, Any]
) -> tuple[Notebook, dict[str, Any]]:
    """Read a chapter, and the values of its parameters as it declares them."""
    notebook = read_notebook(path)
    try:
        return notebook, check(parameters(notebook), given)
    except ValueError as error:
        raise ValueError(f"{path.stem}: {error}") from error


def _run(
    path: Path,
    chapter: Notebook,
    given: dict[str, Any],
    *,
    root: Path,
    python: "_Warm",
    say: Callable[[str], object] | None,
) -> Chapter:
    """Return one chapter with its outputs, from the cache if nothing has changed."""
    kept = _kept(path, chapter, given, root=root, cache=python.cache)
    run, record = kept.run, kept.record
    if run is None or record is None or kept.reasons:
        if say:
            say(f"{path.stem}: {kept.reasons}")
        run, record = _execute(path, given, root=root, python=python, code=kept.code)
        if _identify(run) != kept.code:
            words = "its code was edited while the book was built: build it again"
            raise ChapterError(path.stem, words, record.seconds, run)
        run["metadata"]["record"] = asdict(record)
        if not complaints(run):
            write_notebook(run, kept.file)
    done = with_outputs(chapter, run)
    if cell := without_picture(done):
        words = f"{cell}: it has alternative text, but no picture"
        raise ChapterError(path.stem, words, record.seconds, done)
    return Chapter(path.stem, done, record, given, kept.reasons)


class _Kept(NamedTuple):
    """What is kept of a chapter, and why that does not hold."""

    file: Path
    code: str  # digest of the chapter's code cells as they are now
    run: Notebook | None
    record: Record | None
    reasons: str


def _kept(
    path: Path, chapter: Notebook, given: Mapping[str, Any], *, root: Path, cache: Path
) -> _Kept:
    """Look up a chapter's last run with these parameters."""
    code = _identify(chapter)
    file = cache / f"{path.stem}-{_sha256(given)[:8]}.ipynb"
    run = read_notebook(file) if file.exists() else None
    record = read_record(run["metadata"].get("record", {})) if run else None
    if record:
        return _Kept(file, code, run, record, "; ".join(record.changes(code, root)))
    named = ", ".join(f"{name}={value!r}" for name, value in given.items())
    never = "never executed" + (f" with {named}" if named else "")
    return _Kept(file, code, run, record, never)


def _execute(
    path: Path, given: Mapping[str, Any], *, root: Path, python: "_Warm", code: str
) -> tuple[Notebook, Record]:
    """Run a chapter by papermill in a kernel of this very interpreter."""
    cache = python.cache
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="run-", dir=cache.resolve()) as folder:
        start = time.perf_counter()
        # A kernel of the same name elsewhere, or the user's own IPython settings,
        # would run the chapter in another environment: ours come first.
        log, output = Path(folder, "log"), Path(folder, path.name)
        spec = Path(folder, "kernels", "python3", "kernel.json")
        spec.parent.mkdir(parents=True)
        watched = (root.resolve(), _KERNEL.parents[1])
        launch = [*python.command(), *map(str, (_KERNEL, log, *watched))]
        launch += ["-f", "{connection_file}"]
        kernel_spec = {"argv": launch, "display_name": "Python 3"}
        spec.write_text(json.dumps(kernel_spec), "utf-8")
        values = yaml.safe_dump(dict(given), sort_keys=False)  # 1e-5 stays one
        arguments: list[str | Path] = [*map(_literal, (path.resolve(), output))]
        arguments += ["--kernel", "python3", "--cwd", root.resolve()]
        arguments += ["--parameters_yaml", values, "--no-progress-bar"]
        result = run_tool(
            "papermill.cli:papermill",
            arguments,
            cache=cache,
            python=python.command(),
            JUPYTER_PATH=folder,
            IPYTHONDIR=folder,
        )
        seconds = round(time.perf_counter() - start, 2)
        if result.returncode == 0:
            return read_notebook(output), Record(
                code, *read_log(log, root), environment=chosen(), seconds=seconds
            )
        run = read_notebook(output) if output.exists() else None
        last_words = (result.stderr.strip() or "papermill failed").splitlines()[-1]
        words = (run and failure(run)) or last_words
        raise ChapterError(path.stem, words, seconds, run)


def _literal(path: Path) -> str:
    """Write a path for papermill, which fills in what stands in braces."""
    return str(path).replace("{", "{{").replace("}", "}}")


# What a run depended on


def read_record(content: Mapping[str, Any]) -> Record | None:
    """Take a record out of a run's metadata; a cache of another version has none."""
    try:
        return Record(**content)
    except TypeError:
        return None


def read_log(log: Path, root: Path) -> tuple[dict[str, str], dict[str, str]]:
    """Read in a kernel's log which files were read and which packages imported."""
    files, imported = {}, set()
    for line in log.read_text(encoding="utf-8").splitlines():
        entry = json.loads(line)
        if "file" in entry:
            path = Path(os.path.relpath(entry["file"], root.resolve()))
            if not path.parts[0].endswith(".egg-info"):  # how packages are installed
                files[path.as_posix()] = entry["sha256"]
        else:
            imported.add(entry["package"])
    # Of packages that are watched, files count, and no version.
    inits = {name for name in files if name.endswith("/__init__.py")}
    others = imported - {Path(name).parent.name for name in inits}
    owners = {"python"}.union(*(_distributions().get(name, ()) for name in others))
    return (
        dict(sorted(files.items())),
        {name: version_of(name) for name in sorted(owners, key=str.lower)},
    )


@functools.cache
def version_of(name: str) -> str:
    """Return the version of a distribution, or of "python"; empty if there is none."""
    if name == "python":
        return platform.python_version()
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def _identify(notebook: Notebook) -> str:
    """Identify the code of a chapter, or of a run of it."""
    return _sha256([_essence(cell) for cell in code_cells(notebook)])


def _essence(cell: NotebookCell) -> tuple[str, list[str]]:
    """Return what a code cell's outputs depend on."""
    meaningful = {"parameters", "raises-exception"}
    return source(cell), sorted(meaningful & tags(cell))


def _sha256(content: Any) -> str:
    """Identify what JSON can hold."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@functools.cache
def _distributions() -> Mapping[str, list[str]]:
    """Return which distributions each package is of."""
    return metadata.packages_distributions()


# Processes, and their environment


class _Warm:
    """A Python that has loaded what chapters import, from the first that asks for it.

    Without pidfds, which only Linux has, it is an ordinary Python.
    """

    def __init__(self, root: Path, cache: Path) -> None:
        self.root, self.cache = root, cache
        self._lock, self._open = threading.Lock(), ExitStack()
        self._command: list[str] = []

    def __enter__(self) -> "_Warm":
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def command(self) -> list[str]:
        """Return what a command begins with, before the script and its arguments."""
        with self._lock:
            if not self._command:
                self._command = [sys.executable]
                if hasattr(os, "pidfd_open"):
                    address = self._open.enter_context(self._serving())
                    self._command += ["-IS", str(_WARM), "ask", address]
            return self._command

    def _loads(self) -> list[str]:
        """Name the modules that are loaded once: the tools', and the repository's."""
        file = self.root / "pyproject.toml"
        settings = tomllib.loads(file.read_text("utf-8")) if file.is_file() else {}
        return [*_LOADS, *settings.get("tool", {}).get("press", {}).get("loads", ())]

    @contextmanager
    def _serving(self) -> Iterator[str]:
        """Have a process load and wait; give its address."""
        with tempfile.TemporaryDirectory() as folder:
            address = str(Path(folder, "socket"))
            command = [sys.executable, str(_WARM), "serve", address, *self._loads()]
            with subprocess.Popen(
                command,
                cwd=folder,
                env=environment(self.cache),
                stdin=subprocess.PIPE,  # closed at the end, whatever happens
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C goes to those who ask
            ) as process:
                if not (process.stdout and process.stdout.readline()):
                    raise BookError("the process that runs chapters did not start")
                yield address


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
