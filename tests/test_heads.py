"""Heads of tables: one row where pandas writes two, and words for true and false."""

import re

import pandas as pd
import pytest

from press._notebook import _readable_tables

PLAIN = pd.DataFrame({"a": [True], "b": [False]})
PAIRS = pd.MultiIndex.from_tuples([(1, 2)])


def shown(table):
    return _readable_tables({"data": {"text/html": table.to_html()}})["data"]


def heads(table):
    """Return what a page's table has in each row of its head."""
    head = re.search("<thead>(.*)</thead>", shown(table)["text/html"], re.DOTALL)[1]
    rows = re.findall("<tr.*?</tr>", head, re.DOTALL)
    return [re.findall("<t[hd][^>]*>(.*?)</t[hd]>", row) for row in rows]


@pytest.mark.parametrize(
    ("table", "wanted"),
    [
        (PLAIN, ["", "a", "b"]),
        (PLAIN.rename_axis("method"), ["method", "a", "b"]),
        (PLAIN.rename_axis(columns="cm"), ["cm", "a", "b"]),
        (
            PLAIN.rename_axis(index="method", columns="cm"),
            ["method ↓ cm →", "a", "b"],
        ),
        (PLAIN.set_axis(PAIRS.set_names(["p", "q"])), ["p", "q", "a", "b"]),
        (PLAIN.set_axis(PAIRS.set_names(["", "q"])), ["", "q", "a", "b"]),
    ],
)
def test_names_of_rows_stand_in_the_corner(table, wanted):
    assert heads(table) == [wanted]


def test_groups_of_columns_stay_above_them():
    columns = pd.MultiIndex.from_tuples([("w", "a"), ("w", "b")])
    assert heads(PLAIN.set_axis(columns, axis=1).rename_axis("method")) == [
        ["", "w"],
        ["method", "a", "b"],
    ]


def test_true_and_false_are_words():
    page = shown(PLAIN)["text/html"]
    assert re.findall("<td>(.*?)</td>", page)[-2:] == ["yes", "no"]


def test_what_is_no_table_stays():
    output = {"data": {"text/plain": "True"}}
    assert _readable_tables(output) is output
