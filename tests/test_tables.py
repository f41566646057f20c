import hashlib
import json
import os
import shutil
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import press._files
from msc import load_dataset
from msc.data import COLUMNS, WEIGHTS, find_data
from msc.data import save_table as save
from press import replace_file


def made_up(n_tasks=5, **columns):
    rng = np.random.default_rng(0)
    table = {
        name: {"integer": np.arange(n_tasks), "string": ["start 0"] * n_tasks}.get(
            kind, rng.normal(size=n_tasks)
        )
        for name, (kind, _) in COLUMNS.items()
    }
    table["task_deg"] = 360 * np.arange(n_tasks) / n_tasks
    return pd.DataFrame(table | columns)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "data" / "free.csv"
    save(made_up(), path, command="msc search", seed=7)
    return path


def package(path):
    return json.loads(path.with_name("datapackage.json").read_text("utf-8"))


def rewrite(path, table):
    """Write a table that no data package describes."""
    path.with_name("datapackage.json").unlink()
    table.to_csv(path, index=False)
    return path


# There and back


def test_a_table_comes_back_bit_for_bit(path):
    tasks, policies, table = found = load_dataset(path)
    pd.testing.assert_frame_equal(table, made_up(), check_exact=True)
    np.testing.assert_array_equal(tasks[:, 0], np.deg2rad(made_up()["task_deg"]))
    np.testing.assert_array_equal(policies, made_up()[list(WEIGHTS)])
    assert (tasks.shape, policies.shape) == ((5, 1), (5, 6))
    assert found.task_deg.tolist() == made_up()["task_deg"].tolist()


def test_every_number_comes_back(path):
    patterns = np.random.default_rng(0).integers(2**63, size=3000)
    numbers = patterns.view(float)
    numbers[~np.isfinite(numbers)] = -0.0
    save(made_up(3000, cost=numbers), path, command="", seed=0)
    assert load_dataset(path)[2]["cost"].to_numpy().tobytes() == numbers.tobytes()


@pytest.mark.parametrize("margin", [[0.5, np.nan, 0.0, np.nan, 2.0], [np.nan] * 5])
def test_a_margin_may_be_empty(path, margin):
    save(made_up(margin=margin), path, command="", seed=0)
    table = load_dataset(path)[2]
    np.testing.assert_array_equal(table["margin"], margin)
    place = list(COLUMNS).index("margin")
    for line, value in zip(
        path.read_text("utf-8").splitlines()[1:], margin, strict=True
    ):
        assert line.split(",")[place] == ("" if np.isnan(value) else str(value))


def test_tasks_come_back_ascending(path):
    save(made_up()[::-1], path, command="", seed=0)
    tasks, policies, _ = load_dataset(path)
    assert (np.diff(tasks[:, 0]) > 0).all()
    np.testing.assert_array_equal(policies, made_up()[list(WEIGHTS)])


def test_columns_come_in_one_order_whatever_the_table_s(path):
    before = path.read_bytes()
    shuffled = made_up()[list(COLUMNS)[::-1]].assign(extra=1)
    save(shuffled, path, command="", seed=0)
    assert path.read_bytes() == before


# The data package


def test_the_package_says_what_a_table_is(path):
    (resource,) = package(path)["resources"]
    content = path.read_bytes()
    assert resource["path"] == "free.csv"
    assert resource["bytes"] == len(content)
    assert resource["hash"] == f"sha256:{hashlib.sha256(content).hexdigest()}"
    assert (resource["command"], resource["seed"]) == ("msc search", 7)
    assert {"python", "numpy", "pybullet", "cma"} <= set(resource["versions"])
    fields = resource["schema"]["fields"]
    assert [field["name"] for field in fields] == list(pd.read_csv(path).columns)
    assert all(field["type"] and field["description"] for field in fields)


def test_saving_again_replaces_that_table_alone(path):
    save(made_up(3), path.with_name("free_test.csv"), command="more", seed=1)
    save(made_up(4), path, command="again", seed=2)
    old, new = sorted(package(path)["resources"], key=lambda one: one["command"])[::-1]
    assert (old["path"], new["path"]) == ("free_test.csv", "free.csv")
    assert (new["command"], new["seed"]) == ("again", 2)
    assert len(load_dataset(path)[0]) == 4
    assert len(load_dataset(path.with_name("free_test.csv"))[0]) == 3


def test_saving_the_same_gives_the_same_bytes(path):
    folder = path.parent
    before = {one.name: one.read_bytes() for one in folder.iterdir()}
    save(made_up(), path, command="msc search", seed=7)
    assert {one.name: one.read_bytes() for one in folder.iterdir()} == before


# Where the data are


def test_a_name_is_looked_up_here_and_above(path, monkeypatch):
    deep = path.parents[1] / "book" / "chapter"
    deep.mkdir(parents=True)
    for folder in (path.parents[1], deep):
        monkeypatch.chdir(folder)
        assert find_data() == path.parent
        assert len(load_dataset("free")[0]) == 5


def test_elsewhere_the_data_are_those_beside_msc(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find_data().parent.joinpath("msc", "data", "_tables.py").is_file()


def test_a_known_name_may_be_a_path(path, monkeypatch):
    monkeypatch.chdir(path.parents[1])
    found, named = load_dataset(Path("free")), load_dataset("free")
    pd.testing.assert_frame_equal(found.table, named.table, check_exact=True)
    pd.testing.assert_frame_equal(found.table, made_up(), check_exact=True)


# Bad tables


@pytest.mark.parametrize("name", ["fre", "no/such.csv", "."])
def test_a_missing_file_is_named(name):
    with pytest.raises(ValueError, match=r"dataset '.*' is not there; wanted one of"):
        load_dataset(name)


def test_a_missing_table_of_a_known_name_is_named(path, monkeypatch):
    monkeypatch.chdir(path.parents[1])
    with pytest.raises(ValueError, match=r"dataset 'obstacles' is not there"):
        load_dataset("obstacles")


def test_missing_columns_are_named(path):
    rewrite(path, made_up().drop(columns=["cost", "weight_y2"]))
    with pytest.raises(ValueError, match=r"free\.csv: columns missing: weight_y2, co"):
        load_dataset(path)


def test_duplicate_tasks_are_named(path):
    rewrite(path, made_up(task_deg=[0.0, 5.0, 10.0, 5.0, 20.0]))
    with pytest.raises(ValueError, match=r"duplicate tasks at task_deg=\[5\.0\]"):
        load_dataset(path)


@pytest.mark.parametrize(
    ("column", "value"),
    [("weight_x3", np.nan), ("weight_x3", np.inf), ("margin", np.inf)],
)
def test_columns_that_are_not_finite_are_named(path, column, value):
    rewrite(path, made_up(**{column: [1.0, 2.0, value, 4.0, 5.0]}))
    with pytest.raises(ValueError, match=rf"free\.csv: NaN or infinite .* in {column}"):
        load_dataset(path)


@pytest.mark.parametrize("column", ["cost", "margin"])
def test_text_among_numbers_is_shown(path, column):
    rewrite(path, made_up(**{column: ["a lot", "2", "3", "4", "5"]}))
    with pytest.raises(ValueError, match=r"free\.csv: wanted numbers: .*'a lot'"):
        load_dataset(path)


def test_a_changed_table_is_refused_and_its_command_shown(path):
    path.write_bytes(path.read_bytes().replace(b"start 0", b"start 1", 1))
    with pytest.raises(ValueError, match=r"free\.csv: checksum .* it: msc search$"):
        load_dataset(path)


def test_a_table_without_a_package_is_taken_as_it_is(path, tmp_path):
    alone = shutil.copy(path, tmp_path)
    assert len(load_dataset(alone)[0]) == 5


@pytest.mark.parametrize("content", ["", ",".join(COLUMNS) + "\n"])
def test_an_empty_table_is_named(path, content):
    path.with_name("datapackage.json").unlink()
    path.write_text(content, "utf-8")
    with pytest.raises(ValueError, match=r"free\.csv: "):
        load_dataset(path)


# A broken data package

BROKEN = [
    b"",
    b"{",
    b"[]",
    b"5",
    b"null",
    b"{}",
    b'{"resources": null}',
    b'{"resources": {}}',
    b'{"resources": [5]}',
    b'{"resources": [{}]}',
    b'{"resources": [{"path": 5}]}',
    b'{"resources": [], "name": "\xe4"}',
    b'{"resources": [], "name": "\\ud800"}',
    b"\xef\xbb\xbf{}",
    b"[" * 100_000,
]


@pytest.mark.parametrize("content", BROKEN)
def test_a_broken_package_is_named_and_left(content, path):
    before = path.read_bytes()
    file = path.with_name("datapackage.json")
    file.write_bytes(content)
    for use in (
        lambda: load_dataset(path),
        lambda: save(made_up(), path, command="", seed=0),
    ):
        with pytest.raises(ValueError, match=r"^/.*/datapackage\.json: wanted a data "):
            use()
    assert (file.read_bytes(), path.read_bytes()) == (content, before)


def test_a_package_that_is_a_folder_is_named(path):
    path.with_name("datapackage.json").unlink()
    path.with_name("datapackage.json").mkdir()
    with pytest.raises(
        ValueError, match=r"/datapackage\.json: cannot be read: Is a dir"
    ):
        load_dataset(path)


@pytest.mark.parametrize("key", ["hash", "command"])
def test_a_package_that_lacks_a_key_is_no_package_of_the_table(key, path):
    described = package(path)
    described["resources"][0]["hash"] = "none"
    del described["resources"][0][key]
    path.with_name("datapackage.json").write_text(json.dumps(described), "utf-8")
    with pytest.raises(ValueError, match=r"free\.csv: checksum .* differs"):
        load_dataset(path)


# Whole or not at all


def test_tables_saved_at_once_are_all_described(tmp_path):
    paths = [tmp_path / f"{number}.csv" for number in range(8)]
    together = threading.Barrier(len(paths))

    def save_together(path):
        together.wait()
        save(made_up(), path, command="", seed=0)

    with ThreadPoolExecutor(len(paths)) as pool:
        list(pool.map(save_together, paths))
    described = package(paths[0])["resources"]
    assert [one["path"] for one in described] == [path.name for path in paths]


def test_a_table_and_its_description_are_written_both_or_neither(path, monkeypatch):
    before = {one.name: one.read_bytes() for one in path.parent.iterdir()}
    really, calls = os.fsync, []

    def fail_at_last(handle):
        calls.append(handle)
        if len(calls) == 2:
            raise OSError(28, "No space left on device")
        really(handle)

    monkeypatch.setattr(press._files.os, "fsync", fail_at_last)
    with pytest.raises(OSError, match=r"No space left on device: '/.*package"):
        save(made_up(3), path, command="", seed=0)
    assert {one.name: one.read_bytes() for one in path.parent.iterdir()} == before


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    file = tmp_path / "new" / "file.txt"
    replace_file(file, "old")

    def fail(_):
        raise OSError("disk full")

    monkeypatch.setattr(press._files.os, "fsync", fail)
    with pytest.raises(OSError, match="disk full"):
        replace_file(file, "new")
    assert file.read_text("utf-8") == "old"
    assert [one.name for one in file.parent.iterdir()] == ["file.txt"]


# Tables from spreadsheets


def as_text(path, change):
    """Write a table as text that a spreadsheet could have written."""
    path.with_name("datapackage.json").unlink()
    text = made_up().to_csv(index=False)
    path.write_bytes(change(text))
    return path


def separate(text, separator):
    return text.replace(",", separator)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (lambda text: separate(text, ";"), "by semicolons; wanted commas"),
        (lambda text: separate(text, ";").replace(".", ","), "by semicolons; wanted"),
        (lambda text: separate(text, "; "), "by semicolons; wanted commas"),
        (lambda text: '"' + separate(text, '";"'), "by semicolons; wanted commas"),
        (lambda text: "\ufeff" + separate(text, ";"), "by semicolons; wanted commas"),
        (lambda text: "\n\n" + separate(text, ";"), "by semicolons; wanted commas"),
        (lambda text: separate(text, "\t"), "by tabs; wanted commas"),
        (lambda text: separate(text, "\t").replace(".", ","), "by tabs; wanted commas"),
        (lambda text: separate(text, "|"), "by pipes; wanted commas"),
        (lambda text: separate(text, " | "), "by pipes; wanted commas"),
        (lambda text: separate(text, "   "), "by spaces; wanted commas"),
        (lambda text: "sep=;\n" + separate(text, ";"), r"by semicolons and .* 'sep=;'"),
        (lambda text: "SEP=;\n" + separate(text, ";"), r"by semicolons and .* 'SEP=;'"),
        (lambda text: "sep=\t\n" + separate(text, "\t"), "by tabs and the first line"),
        (lambda text: "sep=,\n" + text, "by commas and the first line is 'sep=,'"),
        (lambda text: '"sep=;"\n' + separate(text, ";"), "by semicolons and the first"),
        (lambda text: separate(text, ":"), "by ':'; wanted commas"),
        (lambda text: separate(text, "^"), r"by '\^'; wanted commas"),
        (lambda text: "sep=^\n" + separate(text, "^"), r"by '\^' and the first line"),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_another_separator_is_told(path, change, found, newline):
    as_text(path, lambda text: change(text).replace("\n", newline).encode())
    with pytest.raises(ValueError, match=rf"^free\.csv: columns are separated {found}"):
        load_dataset(path)


@pytest.mark.parametrize(
    ("column", "cell", "message"),
    [
        ("task_deg", "1_0", "wanted numbers: task_deg in row 2 is '1_0'"),
        ("weight_x1", "1_0", "wanted numbers: weight_x1 in row 2 is '1_0'"),
        ("cost", "5%", "wanted numbers: cost in row 2 is '5%'"),
        ("margin", "TRUE", "wanted numbers: margin in row 2 is 'TRUE'"),
        ("weight_y3", "1e308", r"weight_y3 reaches 1e\+308; wanted at most 1e\+09"),
        ("evaluations", "1.5", "evaluations holds fractions; wanted whole numbers"),
    ],
)
def test_what_is_no_number_is_told_where(path, column, cell, message):
    def change(text):
        head, first, second, *others = text.split("\n")
        cells = second.split(",")
        cells[head.split(",").index(column)] = cell
        return "\n".join([head, first, ",".join(cells), *others]).encode()

    as_text(path, change)
    with pytest.raises(ValueError, match=rf"^free\.csv: {message}"):
        load_dataset(path)


def test_missing_columns_are_told_beside_the_first_that_are_there(path):
    as_text(path, lambda text: text.replace("task_deg", "TASK_DEG").encode())
    with pytest.raises(ValueError, match="missing: task_deg; the first ones are 'TASK"):
        load_dataset(path)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.encode() + b"\r\n\r\n\n",
        lambda text: separate(text, ", ").encode(),
        lambda text: separate(text, " , ").encode(),
        lambda text: (
            ('"' + text.partition("\n")[0].replace(",", '","') + '"\n').encode()
            + text.partition("\n")[2].encode()
        ),
        lambda text: text.replace("\n", ",\n").encode(),
    ],
)
def test_what_a_spreadsheet_adds_round_commas_changes_nothing(path, change):
    wanted = load_dataset(path)
    for found, value in zip(
        load_dataset(as_text(path, change))[:2], wanted, strict=False
    ):
        np.testing.assert_array_equal(found, value)


@pytest.mark.parametrize("number", ["0,5", "1,234.5", "-1.234,5"])
def test_commas_within_numbers_are_told(path, number):
    rewrite(path, made_up(cost=[number, "2", "3", "4", "5"]))
    with pytest.raises(
        ValueError, match=rf"'{number}'; wanted decimal points, no comm"
    ):
        load_dataset(path)


def test_rows_longer_than_the_header_are_told(path):
    as_text(path, lambda text: text.replace(".", ",").encode())
    with pytest.raises(
        ValueError, match=r"free\.csv: .*(more values|Expected 19 fields)"
    ):
        load_dataset(path)
    head, _, rows = made_up().to_csv(index=False).partition("\n")
    path.write_text(head + "\n" + rows.replace("\n", ",7\n"), "utf-8")
    with pytest.raises(ValueError, match=r"free\.csv: rows hold more values than"):
        load_dataset(path)


def test_other_encodings_and_names_given_twice_are_told(path):
    as_text(path, lambda text: text.replace("start 0", "début").encode("latin-1"))
    with pytest.raises(ValueError, match=r"free\.csv: wanted a table in UTF-8"):
        load_dataset(path)
    path.write_bytes(made_up().to_csv(index=False).encode("utf-16"))
    with pytest.raises(ValueError, match=r"free\.csv: wanted a table in UTF-8"):
        load_dataset(path)
    twice = made_up().to_csv(index=False).replace("seed", "seed,seed ", 1)
    path.write_text(twice.replace("\n", ",1\n").replace(",1\n", "\n", 1), "utf-8")
    with pytest.raises(ValueError, match=r"free\.csv: columns given twice: seed"):
        load_dataset(path)


@pytest.mark.parametrize(
    ("tasks", "named"),
    [
        ([0.0, 90.0, 180.0, 270.0, 360.0], r"\[360\.0\]"),
        ([-1e-9, 90.0, 180.0, 270.0, 359.0], r"\[-1e-09\]"),
        ([-90.0, 90.0, 180.0, 450.0, 359.0], r"\[-90\.0, 450\.0\]"),
    ],
)
def test_tasks_outside_the_turn_are_named(path, tasks, named):
    rewrite(path, made_up(task_deg=tasks))
    with pytest.raises(ValueError, match=rf"task_deg={named}; wanted angles from 0 to"):
        load_dataset(path)


def test_tasks_at_the_ends_of_the_turn_are_loaded(path):
    last = np.nextafter(360.0, 0.0)
    rewrite(path, made_up(task_deg=[-0.0, 90.0, 180.0, 270.0, last]))
    tasks = load_dataset(path)[0]
    assert 0 <= tasks.min() < tasks.max() < 2 * np.pi
