"""Execute the book's chapters: each once, by papermill, and again only when needed.

A chapter is a notebook without outputs. Its last run with certain parameters is kept in
a cache, with a record of what it depended on. A run holds as long as the code cells are
the same, every file that it read (see `press._kernel`) has the content it had then, and
every package that it imported has the version it had then. Only a change of one of
these executes a chapter again, and the reason is told; an edit of the prose never does.
A run that wrote to stderr is not kept.
"""

import functools
import hashlib
import json
import os
import platform
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import ExitStack
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
from press._processes import chosen, run_tool, warm_python

_KERNEL = Path(__file__).resolve().with_name("_kernel.py")
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
    found = _look_up(given, root=root, cache=cache)
    with ExitStack() as stack:
        python: list[str] = []  # nothing is executed
        if any(one.reasons for one in found):
            python = stack.enter_context(warm_python(root, cache))
        pool = stack.enter_context(ThreadPoolExecutor(jobs))
        progress = stack.enter_context(
            tqdm(total=len(given), desc="chapters", disable=None)
        )
        futures = [
            pool.submit(_run, one, root=root, cache=cache, python=python, say=say)
            for one in found
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
    found = _look_up(given, root=root, cache=cache)
    return {one.path.stem: one.reasons for one in found if one.reasons}


def read_chapter(
    path: Path, given: Mapping[str, Any]
) -> tuple[Notebook, dict[str, Any]]:
    """Read a chapter, and the values of its parameters as it declares them."""
    notebook = read_notebook(path)
    try:
        return notebook, check(parameters(notebook), given)
    except ValueError as error:
        raise ValueError(f"{path.stem}: {error}") from error


class _Kept(NamedTuple):
    """A chapter, what is kept of its last run, and why that does not hold."""

    path: Path
    chapter: Notebook
    given: dict[str, Any]
    file: Path  # where the run is, or would be
    code: str  # digest of the chapter's code cells as they are now
    run: Notebook | None
    record: Record | None
    reasons: str


def _look_up(
    given: Mapping[Path, Mapping[str, Any]], *, root: Path, cache: Path
) -> list[_Kept]:
    """Look up the last runs of chapters, after all their parameters are checked."""
    checked = {path: read_chapter(path, values) for path, values in given.items()}
    return [
        _kept(path, *chapter, root=root, cache=cache)
        for path, chapter in checked.items()
    ]


def _kept(
    path: Path, chapter: Notebook, given: dict[str, Any], *, root: Path, cache: Path
) -> _Kept:
    """Look up a chapter's last run with these parameters."""
    code = _identify(chapter)
    file = cache / f"{path.stem}-{_sha256(given)[:8]}.ipynb"
    run = read_notebook(file) if file.exists() else None
    record = read_record(run["metadata"].get("record", {})) if run else None
    if record:
        reasons = "; ".join(record.changes(code, root))
    else:
        named = ", ".join(f"{name}={value!r}" for name, value in given.items())
        reasons = "never executed" + (f" with {named}" if named else "")
    return _Kept(path, chapter, given, file, code, run, record, reasons)


def _run(
    kept: _Kept,
    *,
    root: Path,
    cache: Path,
    python: Sequence[str],
    say: Callable[[str], object] | None,
) -> Chapter:
    """Return one chapter with its outputs, from the cache if nothing has changed."""
    path, given, run, record = kept.path, kept.given, kept.run, kept.record
    if run is None or record is None or kept.reasons:
        if say:
            say(f"{path.stem}: {kept.reasons}")
        run, record = _execute(
            path, given, root=root, cache=cache, python=python, code=kept.code
        )
        if _identify(run) != kept.code:
            words = "its code was edited while the book was built: build it again"
            raise ChapterError(path.stem, words, record.seconds, run)
        run["metadata"]["record"] = asdict(record)
        if not complaints(run):
            write_notebook(run, kept.file)
    done = with_outputs(kept.chapter, run)
    if cell := without_picture(done):
        words = f"{cell}: it has alternative text, but no picture"
        raise ChapterError(path.stem, words, record.seconds, done)
    return Chapter(path.stem, done, record, given, kept.reasons)


def _execute(
    path: Path,
    given: Mapping[str, Any],
    *,
    root: Path,
    cache: Path,
    python: Sequence[str],
    code: str,
) -> tuple[Notebook, Record]:
    """Run a chapter by papermill in a kernel of this very interpreter."""
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="run-", dir=cache.resolve()) as folder:
        start = time.perf_counter()
        # A kernel of the same name elsewhere, or the user's own IPython settings,
        # would run the chapter in another environment: ours come first.
        log, output = Path(folder, "log"), Path(folder, path.name)
        spec = Path(folder, "kernels", "python3", "kernel.json")
        spec.parent.mkdir(parents=True)
        watched = (root.resolve(), _KERNEL.parents[1])
        launch = [*python, *map(str, (_KERNEL, log, *watched))]
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
            python=python,
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
