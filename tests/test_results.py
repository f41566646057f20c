"""Result files: loaded as written, refused when what they rest on has changed."""

import json

import pytest

from msc.data import describe_origin, load_results


@pytest.fixture
def results(tmp_path, monkeypatch):
    """Make a data folder with one result of one table; be there."""
    data = tmp_path / "data"
    (data / "results").mkdir(parents=True)
    (data / "datapackage.json").write_text("{}", "utf-8")
    (data / "free.csv").write_text("1,2\n", "utf-8")
    found = {"cells": [1], "provenance": describe_origin("msc …", data / "free.csv")}
    (data / "results" / "study_free.json").write_text(json.dumps(found), "utf-8")
    monkeypatch.chdir(tmp_path)
    return data


def test_results_are_loaded_as_written(results):
    (found,) = load_results("study_free")
    assert found["cells"] == [1]
    assert found["provenance"]["command"] == "msc …"
    assert list(found["provenance"]["data"]) == ["free.csv"]


def test_results_of_another_table_are_refused(results):
    (results / "free.csv").write_text("1,3\n", "utf-8")
    message = r"study_free\.json rests on another free\.csv; .* msc evaluate"
    with pytest.raises(ValueError, match=message):
        load_results("study_free")


@pytest.mark.parametrize(
    ("name", "command"),
    [
        ("study_obstacles", "msc evaluate --profile full"),
        ("audit_free", r"msc audit data/free\.csv --out data/results/audit_free\.json"),
        ("cut", "make data"),
    ],
)
def test_a_missing_result_says_how_to_make_it(results, name, command):
    with pytest.raises(ValueError, match=rf"{name}\.json is not there; .*: {command}"):
        load_results(name)
