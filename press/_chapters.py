"""Execute the book's chapters: each once, by papermill, and again only when needed.

A chapter is a notebook without outputs. Its last run with certain parameters is kept in
a cache, with a record of what it depended on (see `press._record`): its code cells, the
files that it read, the packages that it imported, its environment. Only a change of one
of these executes it again, and the reason is told; an edit of the prose never does. A
run that wrote to stderr is not kept.
"""

import hashlib
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from tqdm import tqdm

from press import _kernel as kernel
from press import _notebook as nb
from press._environment import chosen, environment
from press._parameters import check
from press._record import Record, read_log, read_record


class BookError(RuntimeError):
    """A chapter failed, or the book did not render."""


@dataclass(frozen=True)
class Chapter:
    """A chapter that has been executed.

    Attributes
    ----------
    name : str
        File name without its ending.
    notebook : dict
        The chapter's current text and code with the outputs of its run.
    record : Record
        What that run depended on, and how long it took.
    parameters : dict
        The values it was given; others are as the chapter declares them.
    """

    name: str
    notebook: nb.Notebook
    record: Record
    parameters: dict[str, Any]


def run_chapters(
    parameters: Mapping[Path, Mapping[str, Any]],
    *,
    root: Path,
    cache: Path,
    jobs: int = 2,
    say: Callable[[str], object] | None = None,
) -> list[Chapter]:
    """Return chapters with their outputs, executing those whose runs hold no longer.

    Parameters
    ----------
    parameters : mapping from Path to mapping
        The chapters, and for each the values of some of its parameters.
    root : Path
        Repository in which chapters run.
    cache : Path
        Folder of earlier runs; created if missing.
    jobs : int, default 2
        How many chapters are executed at a time.
    say : callable, optional
        Is told in a line which chapter is executed, and why.

    Returns
    -------
    list of Chapter
        In the order of `parameters`.

    Raises
    ------
    ValueError
        If a chapter does not declare a parameter, or it cannot take its value: before
        any of the chapters is executed.
    BookError
        If a cell fails, or shows no picture though it has alternative text for one.
        Chapters that have finished by then stay in the cache.
    """
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, not {jobs}")
    checked = {path: read_chapter(path, given) for path, given in parameters.items()}
    with (
        ThreadPoolExecutor(jobs) as pool,
        tqdm(total=len(parameters), desc="chapters", disable=None) as progress,
    ):
        futures = [
            pool.submit(_run, path, *chapter, root=root, cache=cache, say=say)
            for path, chapter in checked.items()
        ]
        try:
            for future in as_completed(futures):
                future.result()
                progress.update()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [future.result() for future in futures]


def read_chapter(
    path: Path, parameters: Mapping[str, Any]
) -> tuple[nb.Notebook, dict[str, Any]]:
    """Read a chapter, and check the parameters that it is to be run with.

    Parameters
    ----------
    path : Path
        The notebook.
    parameters : mapping from str to object
        Values for some of its parameters.

    Returns
    -------
    dict, dict
        The notebook, and the values as the chapter declares them: text that is a number
        is one where a number is meant.

    Raises
    ------
    ValueError
        If the file is no notebook, or a parameter is not declared or cannot take its
        value.
    OSError
        If the file cannot be read.
    """
    notebook = nb.read_notebook(path)
    try:
        return notebook, check(nb.parameters(notebook), parameters)
    except ValueError as error:
        raise ValueError(f"{path.stem}: {error}") from error


def run_tool(
    name: str, arguments: Sequence[str | Path], *, cache: Path, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Run a Python command-line tool in a process of its own.

    Parameters
    ----------
    name : str
        Where its main function is, "module:function".
    arguments : sequence of str or Path
        Its command line.
    cache : Path
        Folder of earlier runs, which holds the home of the process.
    **variables : str
        What its environment has besides (see `press._environment`).

    Returns
    -------
    subprocess.CompletedProcess
        Exit status and what it printed.
    """
    module, function = name.split(":")
    # jsonschema imports a grammar of internationalised addresses if it finds one, which
    # takes seconds. No notebook needs it.
    code = (
        "import sys; sys.modules['rfc3987_syntax'] = None; "
        f"from {module} import {function}; {function}()"
    )
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env=environment(cache) | variables,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )


def _run(
    path: Path,
    source: nb.Notebook,
    given: dict[str, Any],
    *,
    root: Path,
    cache: Path,
    say: Callable[[str], object] | None,
) -> Chapter:
    """Return one chapter with its outputs, from the cache if nothing has changed."""
    code = _sha256([_essence(cell) for cell in nb.code_cells(source)])
    kept = cache / f"{path.stem}-{_sha256(given)[:8]}.ipynb"
    run = nb.read_notebook(kept) if kept.exists() else None
    record = read_record(run["metadata"].get("record", {})) if run else None
    if record is None:
        named = ", ".join(f"{name}={value!r}" for name, value in given.items())
        reasons = ["never executed" + (f" with {named}" if named else "")]
    else:
        reasons = record.changes(code, root)
    if run is None or record is None or reasons:
        if say:
            say(f"{path.stem}: {'; '.join(reasons)}")
        run, record = _execute(path, given, root=root, cache=cache, code=code)
        run["metadata"]["record"] = record.to_json()
        if not nb.complaints(run):
            nb.write_notebook(run, kept)
    done = nb.with_outputs(source, run)
    if cell := nb.without_picture(done):
        raise BookError(f"{path.stem}, {cell}: it has alternative text, but no picture")
    return Chapter(path.stem, done, record, given)


def _essence(cell: nb.Cell) -> tuple[str, list[str]]:
    """Return what a code cell's outputs depend on."""
    meaningful = {"parameters", "raises-exception"}
    return nb.source(cell), sorted(meaningful & nb.tags(cell))


def _execute(
    path: Path, parameters: Mapping[str, Any], *, root: Path, cache: Path, code: str
) -> tuple[nb.Notebook, Record]:
    """Run a chapter by papermill in a kernel of this very interpreter."""
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="run-", dir=cache.resolve()) as folder:
        start = time.perf_counter()
        # A kernel of the same name elsewhere, or the user's own IPython settings,
        # would run the chapter in another environment: ours come first.
        log, output = Path(folder, "log"), Path(folder, path.name)
        spec = Path(folder, "kernels", "python3", "kernel.json")
        spec.parent.mkdir(parents=True)
        script = Path(kernel.__file__).resolve()
        watched = (root.resolve(), script.parents[1])
        launch = [sys.executable, *map(str, (script, log, *watched))]
        launch += ["-f", "{connection_file}"]
        kernel_spec = {"argv": launch, "display_name": "Python 3"}
        spec.write_text(json.dumps(kernel_spec), "utf-8")
        given = yaml.safe_dump(dict(parameters), sort_keys=False)  # 1e-5 stays one
        arguments: list[str | Path] = [*map(_literal, (path.resolve(), output))]
        arguments += ["--kernel", "python3", "--cwd", root.resolve()]
        arguments += ["--parameters_yaml", given, "--no-progress-bar"]
        result = run_tool(
            "papermill.cli:papermill",
            arguments,
            cache=cache,
            JUPYTER_PATH=folder,
            IPYTHONDIR=folder,
        )
        if result.returncode == 0:
            seconds = round(time.perf_counter() - start, 2)
            return nb.read_notebook(output), Record(
                code, *read_log(log, root), environment=chosen(), seconds=seconds
            )
        failure = nb.failure(nb.read_notebook(output)) if output.exists() else ""
        last_words = (result.stderr.strip() or "papermill failed").splitlines()[-1]
        raise BookError(f"{path.stem}, {failure or last_words}")


def _literal(path: Path) -> str:
    """Write a path for papermill, which fills in what stands in braces."""
    return str(path).replace("{", "{{").replace("}", "}}")


def _sha256(content: Any) -> str:
    """Identify what JSON can hold."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
