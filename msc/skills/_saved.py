"""Skills in files, which run nothing when they are read.

A file is skops's, with one member more that says who wrote it. Of what skops itself
does not trust, only `TRUSTED` is allowed: by name, since whole packages have functions
that do harm.
"""

from __future__ import annotations

import io
import json
import warnings
import zipfile
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Any

from msc.skills._skill import TableSkill
from press import replace_file

TRUSTED = (
    "msc.learn._gaussian.GaussianProcess",
    "msc.learn._gaussian._Eigen",
    "msc.learn._gaussian._refine",
    "msc.learn._skill.ParameterizedSkill",
    "msc.learn._smce.SMCE",
    "msc.skills._bands.Doubt",
    "msc.skills._scale.TaskScale",
    "msc.skills._skill.TableSkill",
    "msc.study.rivals._crkr.CrKR",
    "msc.study.rivals._interpolation.Interpolation",
    "scipy.interpolate._interpnd.LinearNDInterpolator",
    "scipy.sparse._csr.csr_array",
    "scipy.spatial._qhull.Delaunay",
    "sklearn.ensemble._hist_gradient_boosting.predictor.TreePredictor",
    "sklearn.gaussian_process.kernels.ConstantKernel",
    "sklearn.gaussian_process.kernels.Product",
    "sklearn.gaussian_process.kernels.RBF",
    "sklearn.gaussian_process.kernels.Sum",
    "sklearn.gaussian_process.kernels.WhiteKernel",
    "sklearn.metrics._dist_metrics.EuclideanDistance64",
    "sklearn.neighbors._kd_tree.KDTree",
    "sklearn.tree._tree.Tree",
)
"""What a skill is made of, besides what skops trusts."""

_ABOUT = "msc.json"  # the member that says who wrote the file
_SCHEMA = "schema.json"  # skops's own
_PACKAGES = "msc", "scikit-learn", "scipy", "numpy", "skops"


def load_skops() -> Any:
    """Return skops's module for files, or say that it is an extra."""
    try:
        import skops.io  # noqa: PLC0415
    except ImportError:
        raise ValueError(
            "files of skills: wanted the extra, pip install 'msc[skills]'"
        ) from None
    return skops.io


def versions() -> dict[str, str]:
    """Return the versions on which a saved skill hangs."""
    found = {}
    for name in _PACKAGES:
        with suppress(metadata.PackageNotFoundError):  # skops, where it is not needed
            found[name] = metadata.version(name)
    return found


def save_skill(skill: TableSkill, path: Path | str) -> None:
    """Write a fitted skill, whole or not at all.

    Parameters
    ----------
    skill : TableSkill
        The skill.
    path : Path or str
        Where to; its name should end in ``.skops``.
    """
    replace_file(Path(path), skill_bytes(skill))


def skill_bytes(skill: TableSkill) -> bytes:
    """Return the file of a skill; of equal ones that were just fitted, the same."""
    # skops names parts by their addresses in memory, and notes the time; trees of
    # neighbours count how often they were asked, whatever writes them.
    given = zipfile.ZipFile(io.BytesIO(load_skops().dumps(skill)))
    schema = json.loads(given.read(_SCHEMA))
    names: dict[str, str] = {}
    _renumber(schema, {}, names)
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as file:
        for old, new in names.items():
            file.writestr(zipfile.ZipInfo(new), given.read(old))
        file.writestr(zipfile.ZipInfo(_SCHEMA), json.dumps(schema))
        file.writestr(zipfile.ZipInfo(_ABOUT), json.dumps({"versions": versions()}))
    return written.getvalue()


def _renumber(part: Any, numbers: dict[int, int], names: dict[str, str]) -> None:
    """Rename parts, and the files that they name, to numbers in their order."""
    if isinstance(part, dict):
        if isinstance(old := part.get("__id__"), int):
            part["__id__"] = numbers.setdefault(old, len(numbers) + 1)
        if "__loader__" in part and isinstance(file := part.get("file"), str):
            suffix = Path(file).suffix
            part["file"] = names.setdefault(file, f"{len(names) + 1}{suffix}")
        part = list(part.values())
    if isinstance(part, list):
        for one in part:
            _renumber(one, numbers, names)


def load_skill(path: Path | str) -> TableSkill:
    """Read a fitted skill.

    Parameters
    ----------
    path : Path or str
        A file that `msc fit` or `save_skill` wrote.

    Returns
    -------
    TableSkill
        The skill. It predicts what it did where it was written, to the bit if the
        versions of NumPy and SciPy are the same and the processor is alike.

    Raises
    ------
    ValueError
        If the file is cut short, no skill, or holds a type that is not trusted.

    Warns
    -----
    UserWarning
        If it was written by other versions.

    Notes
    -----
    Nothing in the file is run, and only types named in a short list are made. Trees and
    neighbours are arrays that compiled code walks through, though: of strangers, take a
    table rather than a skill.
    """
    skops = load_skops()
    path = Path(path)
    content = path.read_bytes()
    no_skill = f"{path.name} is no file of a skill, or was cut short"
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as file:
            names = set(file.namelist())
            damaged = file.testzip()
            about = json.loads(file.read(_ABOUT)) if _ABOUT in names else {}
    except (zipfile.BadZipFile, ValueError, EOFError, OSError):
        raise ValueError(no_skill) from None
    if damaged or _SCHEMA not in names:
        raise ValueError(no_skill)
    others = _other_versions(about)
    try:
        unknown = sorted({*skops.get_untrusted_types(data=content)} - {*TRUSTED})
    except Exception as error:  # whatever skops makes of another's schema
        raise ValueError(f"{no_skill}: {_words(error)}{others}") from None
    if unknown:
        raise ValueError(
            f"{path.name} holds {unknown[0]}, which is not trusted; wanted a file that "
            "msc fit wrote"
        )
    if others:
        warnings.warn(f"{path.name}{others}", stacklevel=2)
    try:
        skill = skops.loads(content, trusted=[*TRUSTED])
    except Exception as error:  # whatever a part of another version says
        raise ValueError(f"{no_skill}: {_words(error)}{others}") from None
    if not isinstance(skill, TableSkill):
        kind = type(skill).__name__
        raise ValueError(f"{path.name} holds a {kind}; wanted a skill of msc fit")
    return skill


def _other_versions(about: Any) -> str:
    """Say which packages had other versions where a file was written."""
    theirs = about.get("versions", {}) if isinstance(about, dict) else {}
    other = [
        f"{name} {theirs.get(name, 'unknown')} (here {version})"
        for name, version in versions().items()
        if theirs.get(name) != version
    ]
    return f" was written with {', '.join(other)}" if other else ""


def _words(error: Exception) -> str:
    return " ".join(str(error).split())
