"""The floors of the house: imports go down only, and through the faces."""

import ast
import inspect
import subprocess
import sys
import tomllib
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from numpydoc.validate import validate

from msc.search._journal import CODE
from press import homes

ROOT = Path(__file__).parents[1]

# Each may import from those before it, and of other floors what their faces offer.
FLOORS = [
    "press",
    "msc._checks",
    "msc._parallel",
    "msc.robot",
    "msc.learn",
    "msc.data",
    "msc.search",
    "msc.estimates",
    "msc.study.rivals",
    "msc.study",
    "msc.skills",
    "msc.worlds",
    "msc.claims",
    "msc.plots",
    "msc.report",
    "msc._cli_fit",
    "msc.cli",
]
ONLY_IN = {
    "pybullet": "msc.robot._bullet",
    "pybullet_data": "msc.robot._bullet",
    "pybullet_utils": "msc.robot._bullet",
    "mujoco": "msc.robot._mujoco",
    "cma": "msc.search._cmaes",
    "skops": "msc.skills._saved",
}
KNOWS_GOALS = {  # rivals that ask how movements end
    f"msc.study.rivals.{name}"
    for name in ("_mapping", "_option", "_projection", "_promp")
}
PRACTISES = {  # rivals that execute policies, or search
    f"msc.study.rivals.{name}"
    for name in (
        "_by_trial",
        "_contextual",
        "_crkr_practice",
        "_ends",  # which know what a world's tasks are as points
        "_mixture_practice",
        "_multitask",
        "_trial_gate",
        "_trials",
    )
}
IMPORTS = ast.Import, ast.ImportFrom
OTHER_OPEN = {"Image.open", "os.open", "self._open", "webbrowser.open"}  # of no text


def is_folder(floor: str) -> bool:
    return ROOT.joinpath(*floor.split("."), "__init__.py").is_file()


def dotted(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


MODULES = {
    dotted(path): path
    for package in ("msc", "press")
    for path in sorted((ROOT / package).rglob("*.py"))
    if path.stem not in ("__init__", "__main__")
}


FACES = {
    dotted(path).removesuffix(".__init__"): path
    for package in ("msc", "press")
    for path in sorted((ROOT / package).rglob("__init__.py"))
}


def floor_of(name: str) -> str:
    """Return the floor of a module: its folder, or itself if it stands alone."""
    return name if name in FLOORS else name.rpartition(".")[0]


@cache
def nodes(path: Path) -> list[ast.AST]:
    return [*ast.walk(ast.parse(path.read_text("utf-8")))]


@cache
def imported(name: str) -> list[tuple[str, str]]:
    """Return what a module imports anywhere: from which module, and which name."""
    found = []
    for node in nodes(MODULES[name]):
        if isinstance(node, ast.Import):
            found += [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name} has a relative import"
            found += [(node.module or "", alias.name) for alias in node.names]
    return found


def own(name: str) -> list[tuple[str, str]]:
    return [
        pair for pair in imported(name) if pair[0].split(".")[0] in ("msc", "press")
    ]


def test_every_module_stands_on_a_floor():
    assert {floor_of(name) for name in MODULES} == set(FLOORS)


def test_imports_go_down_and_through_the_faces():
    for name in MODULES:
        here = floor_of(name)
        for module, what in own(name):
            there = floor_of(module) if module != "msc" else "msc"
            assert not what.startswith("_"), f"{module} lends {what} to {name}"
            if there != here:
                assert there in FLOORS[: FLOORS.index(here)], f"{module} above {name}"
                assert module == there, f"{module}, behind a face, lends to {name}"


@pytest.mark.parametrize("name", FACES)
def test_a_face_imports_nothing_and_offers_what_stands_behind_it(name):
    tree = ast.parse(FACES[name].read_text("utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    for node in block.body:
        assert isinstance(node, ast.ImportFrom), ast.unparse(node)
        below = name == "msc" and node.module in FLOORS
        assert below or node.module.rpartition(".")[0] == name, node.module
    if name != "press":
        others = [node for node in tree.body if isinstance(node, IMPORTS)]
        told = {ast.unparse(node) for node in others}
        assert told == {
            "from typing import TYPE_CHECKING",
            "from press import face",
        }


def test_no_import_hides_in_a_call():
    for name, path in MODULES.items():
        found = nodes(path)
        names = {node.id for node in found if isinstance(node, ast.Name)}
        names |= {node.attr for node in found if isinstance(node, ast.Attribute)}
        assert not names & {"import_module", "__import__"}, name


def test_a_package_that_is_hidden_has_one_module():
    for name in MODULES:
        for module, _ in imported(name):
            assert ONLY_IN.get(module.split(".")[0], name) == name, module


def test_learners_know_nothing_of_robots():
    for name in MODULES:
        if floor_of(name) not in ("msc.learn", "msc.study.rivals"):
            continue
        known = {"press", "msc._checks", "msc._parallel", "msc.learn", floor_of(name)}
        known |= {"msc.robot"} if name in KNOWS_GOALS | PRACTISES else set()
        known |= {"msc.search"} if name in PRACTISES else set()
        assert {floor_of(module) for module, _ in own(name)} <= known, name


@pytest.mark.parametrize("folder", ["msc", "press", "benchmarks", "tests"])
def test_text_is_read_and_written_in_an_encoding_that_is_named(folder):
    """The one that a machine prefers is not always UTF-8."""
    paths = (ROOT / folder).rglob("*.py")
    pairs = [(path, node) for path in paths for node in nodes(path)]
    for path, node in pairs:
        if not isinstance(node, ast.Call):
            continue
        called = getattr(node.func, "attr", getattr(node.func, "id", ""))
        options = {keyword.arg for keyword in node.keywords}
        modes = [ast.unparse(value) for value in node.args]
        if called in ("read_text", "write_text"):
            is_named = len(modes) > (called == "write_text") or "encoding" in options
        elif called in ("open", "fdopen") and ast.unparse(node.func) not in OTHER_OPEN:
            is_named = "encoding" in options or any("b" in mode for mode in modes[-1:])
        else:
            continue
        assert is_named, f"{path}, line {node.lineno}: {ast.unparse(node)}"


def test_floors_are_loaded_when_asked_for():
    told = "import sys, msc; before = 'msc.learn' in sys.modules; msc.learn.SMCE; "
    told += "print(before, {'robot', 'SMCE'} <= {*dir(msc)}, 'pybullet' in sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", told], capture_output=True, text=True, check=True
    )
    assert ran.stdout.split() == ["False", "True", "False"]


def test_a_table_is_loaded_without_what_only_others_need():
    told = "import sys, msc; msc.load_dataset('free'); print(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", told], capture_output=True, text=True, check=True
    )
    heavy = {"scipy", "sklearn", "pybullet", "mujoco", "matplotlib"}
    assert not heavy & set(ran.stdout.split())


def public(face: str) -> list[str]:
    """Name the functions, classes and public methods that a face offers."""
    found = []
    for name in import_module(face).__all__:
        thing = getattr(import_module(face), name)
        found += [f"{face}.{name}"] if callable(thing) else []
        if inspect.isclass(thing):
            found += [
                f"{face}.{name}.{method}"
                for method, function in inspect.getmembers(thing, inspect.isfunction)
                if method[0] != "_" and function.__qualname__.startswith(f"{name}.")
                if function.__module__.split(".")[0] in ("msc", "press")
            ]
    return found


@pytest.mark.parametrize("face", ["msc", *filter(is_folder, FLOORS)])
def test_what_a_face_offers_has_a_whole_docstring(face):
    """Files behind it are private: what they share among each other has a line."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    but = {*settings["tool"]["numpydoc_validation"]["checks"], "YD01"} - {"all"}
    lacking = {}
    for name in public(face):
        found = validate(name)
        if "\nAttributes\n" in found["docstring"]:  # a record's are its parameters
            found["errors"] = [one for one in found["errors"] if one[0] != "PR01"]
        lacking[name] = [words for code, words in found["errors"] if code not in but]
    lacking = {name: words for name, words in lacking.items() if words}
    assert not lacking


def test_a_journal_knows_all_the_code_that_a_search_depends_on():
    # These keep what is found, and change nothing.
    keepers = ("press", "msc._parallel", "msc.data._tables", "msc.data._jumps")
    keepers += ("msc.search._journal",)
    folders = ["msc", *filter(is_folder, FLOORS)]
    offered = {face: homes(import_module(face).__file__) for face in folders}
    found, new = set(), {"msc.search._sweep"}
    while new:
        found |= new
        places = {
            module if module in MODULES else offered[module].get(what, module)
            for name in new
            for module, what in own(name)
        }
        new = {one for one in places if not one.startswith(keepers)} - found
    assert {f"msc.{name.replace('/', '.')}" for name in CODE} == found
