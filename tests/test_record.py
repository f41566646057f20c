import json
from dataclasses import asdict

from press import _chapters
from press._chapters import Record, chosen, read_log, read_record


def test_how_the_package_is_installed_is_no_input(tmp_path):
    log, digest = tmp_path / "log", "0" * 64
    read = ["data/free.csv", "msc.egg-info/entry_points.txt"]
    lines = [{"file": str(tmp_path / name), "sha256": digest} for name in read]
    log.write_text("\n".join(map(json.dumps, lines)), "utf-8")
    assert read_log(log, tmp_path)[0] == {"data/free.csv": digest}


def test_a_run_in_another_environment_holds_no_longer(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_CORETYPE", "Haswell")
    kept = Record("code", {}, {}, chosen(), seconds=1.0)
    assert read_record(json.loads(json.dumps(asdict(kept)))) == kept
    assert kept.changes("code", tmp_path) == []
    monkeypatch.delenv("OPENBLAS_CORETYPE")
    monkeypatch.setattr(
        _chapters, "chosen", lambda: chosen() | {"MPLBACKEND": "agg", "NEW": "1"}
    )
    assert kept.changes("code", tmp_path) == [
        f"MPLBACKEND {chosen()['MPLBACKEND']} became agg",
        "NEW unset became 1",
        "OPENBLAS_CORETYPE Haswell became unset",
    ]


def test_a_run_whose_environment_is_not_known_is_no_record():
    old = asdict(Record("code", {}, {}, {}, seconds=1.0))
    del old["environment"]
    assert read_record(old) is None
