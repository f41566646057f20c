"""The whole road, with little of each: four tasks searched, to a page of the book."""

import json
from pathlib import Path

import pytest

from msc import load_dataset
from msc.claims._page import SECTIONS, TABLE
from msc.cli import main, make_subject
from msc.study import run_study
from msc.study._study import PROFILES, Profile
from press import build_book, write_json

SHORT = "--tasks 4 --jobs 1 --set max_evaluations=45 --set agreement=2"
SHORT += " --set max_sweeps=0"
LITTLE = Profile(
    repetitions=2,
    sizes={"even": (4,)},
    some_sizes=(),
    some_repetitions=0,
    few_sizes=(),
    few_repetitions=0,
    sweep_sizes=(),
    sweep_repetitions=0,
    n_elbows=1,
    methods=("single regression", "nearest neighbour"),
)
CLAIM = """
- id: near-enough
  claim: A regression ends within a hand's breadth of the goals.
  quote: The robot reaches its targets.
  section: IV
  chapter: index
  measured: {file: data/results/study_free.json, design: even, n_samples: 4}
  interpretations:
    on average:
      mean: error_cm
      method: single regression
      below: 8
      unit: cm
  margin: None.
  why: ""
"""
INDEX = f"""# A book

```{{include}} {TABLE}
```

## Each claim

```{{include}} {SECTIONS}
```

```{{bibliography}}
```
"""


def run(command):
    assert main(command.split()) == 0, command


@pytest.fixture
def repository(tmp_path, monkeypatch):
    root = Path(__file__).parents[1]
    for name in ("_config.yml", "pyproject.toml"):
        (tmp_path / name).write_text((root / name).read_text("utf-8"), "utf-8")
    (tmp_path / "_toc.yml").write_text("format: jb-book\nroot: index\n", "utf-8")
    (tmp_path / "book" / "_static").mkdir(parents=True)
    for name in ("book/_static/icon.svg", "book/references.bib"):
        (tmp_path / name).write_bytes((root / name).read_bytes())
    (tmp_path / "book" / "index.md").write_text(INDEX, "utf-8")
    (tmp_path / "book" / "claims.yml").write_text(CLAIM, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(PROFILES, "quick", LITTLE)
    return tmp_path


def test_from_four_tasks_to_a_page(repository):
    run(f"search --workspace free {SHORT} --out data/free.csv")
    run(f"search --workspace free {SHORT} --offset 45 --out data/free_test.csv")
    write_json(
        Path("data/results/study_free.json"), run_study("free", Path("data/results"))
    )
    run("claims --out data/results/claims.json")
    index = build_book(root=repository, subject=make_subject(repository))

    assert load_dataset("free").task_deg.tolist() == [0, 90, 180, 270]
    study = json.loads((repository / "data/results/study_free.json").read_text("utf-8"))
    assert {*study["cells"][0]["measures"]["error_cm"]} == {*LITTLE.methods}
    claims = json.loads((repository / "data/results/claims.json").read_text("utf-8"))
    page = index.read_text("utf-8")
    assert "A regression ends within" in page
    assert claims["near-enough"]["verdict"] in page
