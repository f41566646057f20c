import json

from msc.record import read_log


def test_how_the_package_is_installed_is_no_input(tmp_path):
    log, digest = tmp_path / "log", "0" * 64
    read = ["data/free.csv", "msc.egg-info/entry_points.txt"]
    lines = [{"file": str(tmp_path / name), "sha256": digest} for name in read]
    log.write_text("\n".join(map(json.dumps, lines)))
    assert read_log(log, tmp_path)[0] == {"data/free.csv": digest}
