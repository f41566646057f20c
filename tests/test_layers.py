"""The modules stand in a row, and each imports only from those before it."""

import ast
from pathlib import Path

import pytest

from msc.search._journal import CODE

PACKAGE = Path(__file__).parents[1] / "msc"

ROW = [
    "parallel",
    "files",
    "arrays",
    "escapes",
    "sampling",
    "geometry",
    "workspace",
    "dmp",
    "kinematics",
    "dynamics",
    "control",
    "bullet",
    "arm",
    "rays",
    "scene",
    "camera",
    "cmaes",
    "search",
    "generations",
    "journal",
    "workers",
    "tables",
    "results",
    "dataset",
    "jumps",
    "survey",
    "bisection",
    "audit",
    "movements",
    "validation",
    "copies",
    "spectral",
    "interior",
    "reconstruction",
    "smce",
    "gaussian",
    "skill",
    "crkr",
    "elbows",
    "elbow_parts",
    "gates",
    "pieces",
    "toys",
    "methods",
    "comparison",
    "execution",
    "trial",
    "evaluation",
    "cells",
    "profiles",
    "study",
    "effects",
    "lookups",
    "measured",
    "claim_file",
    "verdicts",
    "claims",
    "claims_page",
    "looks",
    "plots_world",
    "plots",
    "audit_tables",
    "study_tables",
    "cost_tables",
    "plots_study",
    "scrubber",
    "marks",
    "plots_scrubber",
    "plots_costs",
    "plots_arm",
    "plots_weights",
    "plots_curves",
    "plots_skill",
    "plots_predicted",
    "plots_generations",
    "plots_generations_scrubber",
    "plots_graph",
    "plots_graph_scrubber",
    "plots_audit",
    "plots_movements",
    "plots_charts",
    "schema",
    "notebook",
    "checks",
    "environment",
    "kernel",
    "record",
    "opening",
    "chapters",
    "reference",
    "source_pages",
    "headings",
    "rendering",
    "figures",
    "provenance",
    "book",
    "release",
    "print_book",
    "cli_options",
    "cli_search",
    "cli_book",
    "cli",
]
ROBOT = set(ROW[ROW.index("geometry") : ROW.index("validation")]) - {"tables", "jumps"}
LEARNERS = {
    "validation",
    "copies",
    "spectral",
    "interior",
    "reconstruction",
    "smce",
    "gaussian",
    "skill",
    "crkr",
    "elbows",
    "elbow_parts",
    "gates",
    "sampling",
    "pieces",
    "toys",
    "methods",
}
OTHER_OPEN = {"Image.open", "os.open", "self._open", "webbrowser.open"}  # of no text
ONLY_IN = {
    "pybullet": {"bullet"},
    "pybullet_data": {"bullet"},
    "pybullet_utils": {"bullet"},
    "cma": {"cmaes"},
}

MODULES = sorted(path.stem for path in PACKAGE.glob("*.py") if path.stem[0] != "_")


def imported(name: str) -> tuple[set[str], set[str]]:
    """Return what `msc/<name>.py` imports anywhere: from msc, and from elsewhere."""
    own, others = set(), set()
    for node in ast.walk(ast.parse((PACKAGE / f"{name}.py").read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module == "msc":
            names = [f"msc.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"msc/{name}.py has a relative import"
            names = [node.module or ""]
        else:
            continue
        for full in names:
            top, _, rest = full.partition(".")
            (own if top == "msc" else others).add(rest if top == "msc" else top)
    return own, others


def test_every_module_has_its_place():
    assert set(MODULES) <= set(ROW), "give the new module its place in ROW"


@pytest.mark.parametrize("name", MODULES)
def test_imports_only_from_modules_before_it(name):
    own, _ = imported(name)
    assert own <= set(ROW[: ROW.index(name)])


@pytest.mark.parametrize("name", MODULES)
def test_pybullet_and_cma_have_one_module_each(name):
    _, others = imported(name)
    assert all(name in ONLY_IN.get(package, {name}) for package in others)


@pytest.mark.parametrize(
    "path",
    [
        path
        for folder in ("msc", "benchmarks", "tests")
        for path in (PACKAGE.parent / folder).rglob("*.py")
    ],
    ids=lambda path: path.stem,
)
def test_text_is_read_and_written_in_an_encoding_that_is_named(path):
    """The one that a machine prefers is not always UTF-8."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
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
        assert is_named, f"line {node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize("name", sorted(LEARNERS & set(MODULES)))
def test_learners_know_nothing_of_robots(name):
    own, _ = imported(name)
    assert not own & ROBOT


def test_a_journal_knows_all_the_code_that_a_search_depends_on():
    found, new = set(), {"dataset"}
    while new:
        found |= new
        new = set().union(*(imported(name)[0] for name in new)) - found
        new -= {
            "journal",
            "workers",
            "files",
            "tables",
        }  # they keep what is found, and change nothing
    assert set(CODE) == found
