"""The whole road for an arm of one's own: a world's file, and four commands."""

import json

import pandas as pd
import pytest

from msc.cli import main
from msc.skills import METHODS

MINE = """
name = "mine"

[units]
length = "cm"

[arm]
link_lengths = [45, 30, 25]

[tasks]
radius = [30, 40]

[[obstacles]]
x = -35
y = 60
radius = 5
"""


@pytest.fixture(scope="module")
def road(tmp_path_factory):
    """Search a few tasks, fit by two methods, predict, and draw one."""
    with pytest.MonkeyPatch.context() as patch:
        two = {name: METHODS[name] for name in ("mean policy", "nearest neighbour")}
        patch.setattr("msc.skills._fit.METHODS", two)
        patch.setattr("msc.report._pictures.Picture.to_png", lambda _: "")  # dear
        patch.chdir(folder := tmp_path_factory.mktemp("mine"))
        (folder / "mine.toml").write_text(MINE, "utf-8")
        new = pd.DataFrame({"task_deg": [100.0, 200.0], "radius_m": [0.35, 0.32]})
        new.to_csv("new.csv", index=False)
        brief = "--set max_evaluations=4 --set population=4 --set agreement=2 "
        brief += "--set max_sweeps=0 --jobs 1"
        for command in (
            f"search --workspace mine.toml --tasks 12 {brief} --out mine.csv",
            "fit mine.csv --jobs 1 --out skill",
            "predict skill/skill.skops new.csv --out predicted.csv",
            "render --workspace mine.toml --skill skill/skill.skops --task 100 0.35 "
            "--out mine.png",
        ):
            assert main(command.split()) == 0, command
        yield folder


def test_a_table_of_a_search_tells_its_columns_itself(road):
    card = json.loads((road / "skill" / "card.json").read_text("utf-8"))
    told = json.dumps(card)
    assert '"task_deg"' in told
    assert '"radius_m"' in told
    assert "--period task_deg=360" in told
    assert "--units task_deg=deg radius_m=m" in told
    assert "--cost cost" in told


def test_new_tasks_are_predicted_and_one_is_drawn(road):
    found = pd.read_csv(road / "predicted.csv")
    assert found["task_deg"].tolist() == [100.0, 200.0]
    assert found.filter(regex=r"^weight_[xy]\d$").notna().all(axis=None)
    assert (road / "mine.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("fit new.csv --out other", "--tasks and --policies: wanted names"),
        ("fit mine.csv --tasks task_deg --out other", "--tasks and --policies: wanted"),
        (
            "render --skill skill/skill.skops --task 100 --out no.png",
            "a skill for tasks of task_deg, radius_m; wanted task_deg, as free",
        ),
        (
            "render --skill no.skops --policy 0 0 0 0 0 0 --task 100 --out no.png",
            "--policy and --skill: wanted one of them",
        ),
    ],
)
def test_what_is_amiss_is_a_sentence(road, monkeypatch, capsys, command, words):
    monkeypatch.chdir(road)
    before = sorted(road.iterdir())
    assert main(command.split()) != 0
    assert words in capsys.readouterr().err
    assert sorted(road.iterdir()) == before
