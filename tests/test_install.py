"""The package as others install it: the built wheel, with its base requirements."""

import ast
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from press._notebook import code_cells, read_notebook, source

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]

# Everybody gets these; what comes later is an extra, and its absence a sentence.
BASE = ["cma", "cvxpy", "imageio-ffmpeg", "joblib", "matplotlib", "numpy", "pandas"]
BASE += ["papermill", "pillow", "pybullet", "pyyaml", "scikit-learn", "scipy"]
BASE += ["threadpoolctl", "tqdm"]
EXTRAS = {"cluster", "gpy", "mujoco", "skills"}

# A skill from a table, and the arm that executes it, without what is no base package;
# and all that chapters import: papermill alone executes them, with no Jupyter Book.
USE = """
import importlib.abc, sys
import numpy as np

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in (
            "distributed", "mujoco", "sphinx", "jupyterlab",
            "jupyter_book", "myst_nb", "myst_parser", "docutils",
        ):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
try:
    import jupyter_book
except ModuleNotFoundError:
    import msc, press
from msc import Arm, ParameterizedSkill, Workspace, load_dataset

tasks, policies, table = load_dataset("obstacles")
skill = ParameterizedSkill(random_state=0).fit(tasks[::20], policies[::20])
with Arm(Workspace.obstacles()) as arm:
    rollout = arm.execute(skill.predict(np.deg2rad([[123.0]]))[0], task_deg=123.0)
print(msc.__file__, press.__file__, rollout.error, sep="\\n")
"""


def imports():
    """Return every import of any chapter as a line."""
    found = {}
    for path in sorted((ROOT / "book").glob("*.ipynb")):
        for cell in code_cells(read_notebook(path)):
            for node in ast.walk(ast.parse(source(cell))):
                if isinstance(node, ast.Import | ast.ImportFrom):
                    found[ast.unparse(node)] = None
    return list(found)


def name_of(requirement):
    return re.split(r"[>=;]", requirement)[0].strip()


def test_the_base_install_is_what_it_was():
    assert [name_of(one) for one in PROJECT["dependencies"]] == BASE


def test_all_else_is_an_extra():
    assert set(PROJECT["optional-dependencies"]) == EXTRAS


def test_pybullet_is_asked_for_where_it_has_wheels_and_mujoco_is_the_other_engine():
    asked = map(Requirement, PROJECT["dependencies"])
    (bullet,) = [one for one in asked if one.name == "pybullet"]
    versions = ("3.11", "3.12", "3.13", "3.14")
    where = [bullet.marker.evaluate({"python_version": one}) for one in versions]
    assert where == [True, False, False, False]
    assert all(
        version in SpecifierSet(PROJECT["requires-python"]) for version in versions
    )
    assert "3.10" not in SpecifierSet(PROJECT["requires-python"])
    (mujoco,) = map(Requirement, PROJECT["optional-dependencies"]["mujoco"])
    pinned = re.search(
        r"^mujoco-core==(\S+)", (ROOT / "requirements.txt").read_text("utf-8"), re.M
    )
    assert (mujoco.name, pinned[1] in mujoco.specifier) == ("mujoco-core", True)


ALONE = """
import sys
sys.modules["pybullet"] = None  # as where it has no wheels
from dataclasses import replace
import numpy as np
import msc
from msc import Arm, Workspace, load_dataset
from msc.robot import Physics

world = replace(Workspace.free(), physics=Physics(engine="mujoco"))
with Arm(world) as arm:
    rollout = arm.execute(load_dataset("free").policies[123], task_deg=123.0)
print(rollout.error)
try:
    Arm(Workspace.free())
except ValueError as error:
    print(error)
"""


def test_without_pybullet_the_package_works_in_mujoco_and_says_what_it_lacks():
    pytest.importorskip("mujoco", reason="MuJoCo, the second engine, is not installed")
    run = subprocess.run(
        [sys.executable, "-c", ALONE], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    error, said = run.stdout.splitlines()
    assert 0 < float(error) < 0.5
    assert said == (
        "engine='pybullet' is not installed, and has no wheels for Python 3.12 and "
        "later; wanted it, or a world whose engine is 'mujoco'"
    )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    source, folder = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for package in ("msc", "press"):
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, source / package, ignore=ignore)
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, source)
    build = "pip wheel --no-deps --no-build-isolation --quiet --wheel-dir"
    made = subprocess.run(
        [sys.executable, "-m", *build.split(), folder, source],
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    (file,) = folder.iterdir()
    return file


@pytest.fixture(scope="module")
def fresh(wheel, tmp_path_factory):
    """An environment with the wheel and, beside it, the packages of the lock."""
    folder = tmp_path_factory.mktemp("fresh")
    venv.create(folder, symlinks=True)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    install = "install --quiet --no-deps --no-index"
    subprocess.run([*pip, "--python", python, *install.split(), wheel], check=True)
    (site,) = folder.glob("lib/*/site-packages")
    locked = sysconfig.get_path("purelib")  # its own .pth files do not count there
    (site / "locked.pth").write_text(f"{locked}\n", "utf-8")
    return python


def test_the_wheel_holds_what_the_packages_hold(wheel):
    kept = {
        path.relative_to(ROOT).as_posix()
        for package in ("msc", "press")
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".py", ".js", ".css")
    }
    inside = {
        name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name
    }
    assert inside == kept


def test_the_wheel_alone_fits_a_skill_runs_an_arm_and_has_what_chapters_import(fresh):
    lines = imports()
    assert any(line.startswith("from msc") for line in lines)
    run = subprocess.run(
        [fresh, "-c", "\n".join([USE, *lines])],
        cwd=ROOT / "data",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, "")
    *places, error = run.stdout.split()
    assert all(place.startswith(str(fresh.parents[1])) for place in places)
    assert 0 < float(error) < 0.5


def test_the_command_line_of_the_wheel_tells_its_commands(fresh):
    help_ = [fresh.with_name("msc"), "--help"]
    told = subprocess.run(help_, capture_output=True, text=True, check=True).stdout
    assert all(f"\n    {name} " in told for name in ("search", "evaluate", "book"))
