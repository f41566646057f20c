"""Execute the book's chapters: each once, by papermill, and again only when needed.

A chapter is a notebook without outputs. Its run is kept in a cache under everything
that the outputs depend on (code cells, parameters, `msc/`, `data/`, the lock), so that
an edit of the prose never executes anything.
"""

import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from msc import notebook as nb


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
    seconds : float
        Wall time of that run, the start of its kernel included.
    """

    name: str
    notebook: nb.Notebook
    seconds: float


def run_chapters(
    parameters: Mapping[Path, Mapping[str, Any]],
    *,
    root: Path,
    cache: Path,
    jobs: int = 2,
) -> list[Chapter]:
    """Return chapters with their outputs, executing those that are not in the cache.

    Parameters
    ----------
    parameters : mapping from Path to mapping
        The chapters, and for each the values of some of its parameters.
    root : Path
        Repository in which chapters run and on whose code and data they depend.
    cache : Path
        Folder of earlier runs; created if missing.
    jobs : int, default 2
        How many chapters are executed at a time.

    Returns
    -------
    list of Chapter
        In the order of `parameters`.

    Raises
    ------
    ValueError
        If a chapter does not declare a parameter.
    BookError
        If a cell fails. Chapters that have finished by then stay in the cache.
    """
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1, not {jobs}")
    inputs = inputs_digest(root)
    with (
        ThreadPoolExecutor(jobs) as pool,
        tqdm(total=len(parameters), desc="chapters", disable=None) as progress,
    ):
        futures = [
            pool.submit(_run, path, given, root=root, cache=cache, inputs=inputs)
            for path, given in parameters.items()
        ]
        try:
            for future in as_completed(futures):
                future.result()
                progress.update()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [future.result() for future in futures]


def inputs_digest(root: Path) -> str:
    """Return a digest of what every chapter depends on besides its own cells.

    Parameters
    ----------
    root : Path
        Repository: its `msc/`, `data/`, lock and benchmark count.

    Returns
    -------
    str
        Hexadecimal SHA-256 over names and contents.
    """
    files = [*root.glob("msc/**/*.py"), *root.glob("data/**/*")]
    files += [root / "requirements.txt", root / "benchmarks" / "results.json"]
    contents = [
        (file.relative_to(root).as_posix(), _sha256(file.read_bytes()))
        for file in sorted(files)
        if file.is_file() and ".partial" not in file.name
    ]
    return _sha256(json.dumps(contents))


def run_tool(
    name: str, arguments: Sequence[str | Path], **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a Python command-line tool in a process of its own.

    Parameters
    ----------
    name : str
        Where its main function is, "module:function".
    arguments : sequence of str or Path
        Its command line.
    **environment : str
        Environment variables to add.

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
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


def _run(
    path: Path, parameters: Mapping[str, Any], *, root: Path, cache: Path, inputs: str
) -> Chapter:
    """Return one chapter with its outputs, from the cache if nothing has changed."""
    source = nb.read_notebook(path)
    if unknown := sorted(set(parameters) - (known := nb.declared_parameters(source))):
        raise ValueError(
            f"{path.stem} has no parameter {unknown[0]!r}; "
            f"it declares: {', '.join(sorted(known)) or 'none'}"
        )
    code = [
        (nb.source(cell), sorted({"parameters", "raises-exception"} & nb.tags(cell)))
        for cell in nb.code_cells(source)
    ]
    key = _sha256(json.dumps([code, dict(parameters), inputs], sort_keys=True))
    kept = cache / f"{path.stem}-{key[:16]}.ipynb"
    if not kept.exists():
        start = time.perf_counter()
        run = _execute(path, parameters, root)
        run["metadata"]["seconds"] = round(time.perf_counter() - start, 2)
        nb.write_notebook(run, kept)
    run = nb.read_notebook(kept)
    return Chapter(path.stem, nb.with_outputs(source, run), run["metadata"]["seconds"])


def _execute(path: Path, parameters: Mapping[str, Any], root: Path) -> nb.Notebook:
    """Run a chapter by papermill in a kernel of this very interpreter."""
    with tempfile.TemporaryDirectory(prefix="msc-") as folder:
        # A kernel of the same name elsewhere, or the user's own IPython settings,
        # would run the chapter in another environment: ours come first.
        kernel = Path(folder, "kernels", "python3", "kernel.json")
        kernel.parent.mkdir(parents=True)
        launch = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        kernel.write_text(json.dumps({"argv": launch, "display_name": "Python 3"}))
        output = Path(folder, path.name)
        arguments: list[str | Path] = [path.resolve(), output, "--kernel", "python3"]
        arguments += ["--cwd", root.resolve(), "--parameters_yaml"]
        arguments += [json.dumps(dict(parameters)), "--no-progress-bar"]
        result = run_tool(
            "papermill.cli:papermill",
            arguments,
            JUPYTER_PATH=folder,
            IPYTHONDIR=folder,
            OMP_NUM_THREADS="1",
        )
        if result.returncode == 0:
            return nb.read_notebook(output)
        failure = nb.failure(nb.read_notebook(output)) if output.exists() else ""
        last_words = (result.stderr.strip() or "papermill failed").splitlines()[-1]
        raise BookError(f"{path.stem}, {failure or last_words}")


def _sha256(content: str | bytes) -> str:
    data = content.encode() if isinstance(content, str) else content
    return hashlib.sha256(data).hexdigest()
