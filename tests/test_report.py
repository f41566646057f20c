import copy
import json
import re
from html.parser import HTMLParser

import numpy as np
import pandas as pd
import pytest
from test_fit import broken

from msc.cli import main
from msc.report import make_report
from msc.report._pictures import _middles
from msc.report._words import break_places, tell_found, tell_read, tell_trust
from msc.skills import Table, fit_table

METHODS = ["nearest neighbour", "single, one kernel"]
AWKWARD = (
    "角</script><script>alert(1)</script>",
    "_$x_1$ & 'b'",
    "</style><img src=x>\n",
)


class Reader(HTMLParser):
    """Reads a page as a browser does: its elements, and its words but for scripts."""

    def __init__(self, page):
        super().__init__()
        self.elements, self.words, self.open = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in ("img", "meta", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.words.append(data)

    def named(self, tag):
        return [attributes for one, attributes in self.elements if one == tag]


def make_table(n_columns, n_tasks=40, **options):
    """Make policies that follow the first column and, if there are more, the last."""
    tasks = np.random.default_rng(0).uniform(0, 1, (n_tasks, n_columns))
    policies = np.c_[np.sin(3 * tasks[:, 0]), tasks[:, -1] ** 2]
    names = [f"t{k}" for k in range(n_columns)]
    frame = pd.DataFrame(policies, columns=["push", "lift"])
    return Table(pd.DataFrame(tasks, columns=names), frame, **options)


@pytest.fixture(autouse=True, scope="module")
def coarse():
    """Draw pages of few bytes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("msc.report._pictures._DPI", 20)
        yield


@pytest.fixture(scope="module")
def made():
    frame = broken()
    table = Table(
        frame[["angle"]],
        frame[["push", "lift"]],
        units={"angle": "deg"},
        name="t.csv",
        sha256="c0ffee",
    )
    fit = fit_table(table, methods=METHODS, command="msc fit t.csv --seed 0")
    return table, fit


@pytest.fixture(scope="module")
def page(made):
    return make_report(*made)


@pytest.fixture
def card(made):
    return copy.deepcopy(made[1].card)


# The page.


def test_the_page_loads_nothing(page):
    read = Reader(page)
    assert not re.search(r"https?:|href|srcset|\"//", page)
    assert not {"link", "iframe", "object", "base"} & {one for one, _ in read.elements}
    assert all("src" not in one for one in read.named("script"))
    sources = [one["src"] for one in read.named("img")]
    assert sources
    assert all(one.startswith("data:image/png;base64,") for one in sources)
    style = page[page.index("<style>") : page.index("</style>")]
    assert not re.findall(r"url\(|@import", style)
    (policy,) = (one for one in read.named("meta") if "http-equiv" in one)
    assert policy["content"].startswith("default-src 'none'")


def test_every_picture_has_words(page):
    read = Reader(page)
    told = [one["alt"] for one in read.named("img")]
    told += [one["aria-label"] for one in read.named("canvas")]
    assert all(len(one) > 30 for one in told)
    assert len({*told}) == len(told)
    assert len(read.named("canvas")) == 2, "one a policy column"


def test_the_page_says_what_it_was_made_of(page, card):
    words = " ".join(Reader(page).words).replace("\xa0", " ")
    for told in ("msc fit t.csv --seed 0", "c0ffee", card["versions"]["numpy"]):
        assert told in words
    for sentence in (tell_found(card), *tell_read(card), *tell_trust(card)):
        assert sentence in words


def test_the_same_fit_has_the_same_page(made, page):
    assert make_report(*made) == page


def test_markup_in_names_is_text():
    task, push, lift = AWKWARD
    table = make_table(1, name="<b>t</b>.csv", notes=("<i>",))
    table = Table(
        table.tasks.set_axis([task], axis=1),
        table.policies.set_axis([push, lift], axis=1),
        name=table.name,
        units={push: "<u>"},
        notes=table.notes,
    )
    command = "msc fit '<b>t</b>.csv'"
    page = make_report(table, fit_table(table, methods=METHODS[:1], command=command))
    read = Reader(page)
    assert not {"b", "u"} & {one for one, _ in read.elements}
    assert len(read.named("script")) == len(read.named("style")) == 1
    assert all(one["src"].startswith("data:") for one in read.named("img"))
    words = " ".join(read.words)
    for name in (*AWKWARD, table.name, command, "<i>"):
        assert name in words
    data = re.search(r"previousElementSibling,(.*)\);</script>", page)[1]
    assert "<" not in data
    assert AWKWARD[0] in json.loads(data)["captions"][0]


@pytest.mark.parametrize(("n_columns", "n_maps"), [(1, 0), (2, 3), (4, 12)])
def test_tasks_of_several_columns_are_drawn_by_pairs(n_columns, n_maps):
    table = make_table(n_columns)
    read = Reader(make_report(table, fit_table(table, methods=METHODS[:1])))
    told = [one["alt"] for one in read.named("img")]
    assert sum(one.startswith("A map of") for one in told) == n_maps
    assert sum(" over t0: rows by chart" in one for one in told) == 2 * (not n_maps)
    words = " ".join(read.words)
    assert ("stay at their medians" in words) == (n_columns > 1)
    assert ("Of 2 policy columns, the first is shown" in words) == (n_columns == 4)


def test_of_many_rows_some_are_drawn_and_that_is_told(monkeypatch):
    monkeypatch.setattr("msc.skills._fit.MAX_TASKS", {"quick": 100})
    monkeypatch.setattr("msc.report._pictures._DPI", 200)  # as it is
    tasks = np.linspace(0, 1, 20_000)
    frame = pd.DataFrame({"push": np.sin(5 * tasks)})
    table = Table(pd.DataFrame({"t": tasks}), frame)
    page = make_report(table, fit_table(table, methods=METHODS[:1], seed=3))
    assert len(page) < 3e6
    words = " ".join(Reader(page).words)
    assert "Pictures show 100 of 20,000 rows" in words
    assert "drawn by seed 3" in words


def test_a_policy_column_that_never_changes_is_drawn():
    table = make_table(1, n_tasks=20)
    table.policies["lift"] = 3.25
    page = make_report(table, fit_table(table, methods=METHODS[:1]))
    assert "lift 3.25" in page


def test_a_circle_is_walked_once_round():
    angle = np.arange(-180.0, 180.0, 12.0)
    frame = pd.DataFrame({"push": np.cos(np.radians(angle))})
    table = Table(pd.DataFrame({"a": angle}), frame, periods={"a": 360.0})
    page = make_report(table, fit_table(table, methods=METHODS[:1]))
    data = json.loads(re.search(r"previousElementSibling,(.*)\);</script>", page)[1])
    assert [data["labels"][0], data["labels"][-1]] == ["a 0", "a 360"]
    places = [x for mark in data["panels"][0]["marks"][:2] for x in mark["points"][::2]]
    assert min(places) == 0, "what was -180 is 180"
    assert "Nearest is row 16: a 0" in data["captions"][0]
    assert (
        data["captions"][0].split("Nearest")[1]
        == data["captions"][-1].split("Nearest")[1]
    )
    assert "a comes round again after 360" in " ".join(Reader(page).words)


def test_the_command_writes_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("msc.skills._fit._select", lambda *_: ["mean policy"])
    broken().to_csv("t.csv", index=False)
    words = ["t.csv", "--tasks", "angle", "--policies", "push", "lift", "--out", "o"]
    assert main(["fit", *words]) == 0
    assert "report.html" in capsys.readouterr().out
    page = (tmp_path / "o" / "report.html").read_text(encoding="utf-8")
    card = json.loads((tmp_path / "o" / "card.json").read_text(encoding="utf-8"))
    assert tell_found(card) in " ".join(Reader(page).words).replace("\xa0", " ")
    assert card["table"]["sha256"] in page


# Its sentences, of cards that are made up.


def worth(card, **errors):
    """Give methods errors, with intervals of a tenth to either side."""
    card["methods"] = [
        {
            "method": name.replace("_", " "),
            "error": error,
            "low": 0.9 * error,
            "high": 1.1 * error,
            "above_best": error - min(errors.values()),
            "above_best_low": 0.8 * (error - min(errors.values())),
        }
        for name, error in errors.items()
    ]


def test_a_break_is_told_with_its_place(card):
    worth(card, mean_policy=1.44, nearest_neighbour=0.49, charts=0.0169)
    card["chosen"] = "charts"
    card["jumps"] |= {"n_jumps": 1, "widest_jumps": [[[41.5], [43.25]]]}
    assert tell_found(card) == (
        "The policies break at one place (angle between 41.5 and 43.25 deg); of 3 "
        "methods, “charts” is recommended: on tasks left out it is off by 13 % of the "
        "policies' spread, where the mean policy is off by 120 % and the nearest row "
        "by 70 %."
    )
    (beside,) = (one for one in tell_trust(card) if one.startswith("Beside a break"))
    assert "41.5 and 43.25 deg" in beside


def test_a_break_where_a_circle_is_cut_is_between_its_ends(card):
    card["tasks"][0]["period"] = 360.0
    card["jumps"] |= {"n_jumps": 2, "widest_jumps": [[[1], [355]], [[20.5], [18.5]]]}
    assert break_places(card) == "angle between 18.5 and 20.5, 355 and 1 deg"
    assert _middles(card).ravel().tolist() == [19.5, 358.0]


def test_no_break_is_told_and_warned_of(card):
    card["jumps"] |= {"n_jumps": 0, "widest_jumps": []}
    assert tell_found(card).startswith(
        "No break was found between neighbouring tasks; "
    )
    assert not [one for one in tell_trust(card) if "Beside" in one or "seen" in one]
    card["jumps"]["least_jump"] = 2.34
    assert "less than 2.3 of their spreads" in " ".join(tell_trust(card))


def test_breaks_of_several_columns_are_counted(card):
    card["tasks"] *= 2
    card["jumps"] |= {"n_jumps": 17, "n_edges": 1234, "pieces": [9, 5, 2]}
    assert tell_found(card).startswith(
        "The policies break between 17 of 1,234 pairs of neighbouring tasks, into 3 "
        "pieces; "
    )


def test_that_nothing_beats_the_mean_is_told_first(card):
    worth(card, mean_policy=1.0, nearest_neighbour=1.96)
    card["chosen"] = "mean policy"
    told = tell_found(card)
    assert "of 2 methods none beats the mean policy for certain" in told
    assert "the mean policy is off by 100 % and the nearest row by 140 %" in told
    assert "no policy can be told by its task" in tell_trust(card)[0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"error_of_choosing": {"below_mean_low": -0.1}}, "no better than the mean"),
        ({"error_of_choosing": {"error": 0.0289}}, "was off by 17 %"),
        ({"table": {"n_tasks": 23}}, "23 different tasks are few"),
        ({"table": {"n_tasks": 6007}}, "its 95 % interval is"),
        ({"blocks": {"n_blocks": 29}}, "rests on 29 blocks"),
        ({"held_out": {"single_rows_error": 0.0361}}, "would be 19 %: rows are not"),
        ({"held_out": {"single_rows_error": 1e-8}}, "0.01 %, which flatters"),
        ({"held_out": {"bands": []}}, "does not know how sure it is"),
        ({"failed": {"CrKr": "too <few>"}}, "“CrKr” could not be fitted: too <few>."),
        ({"warnings": ["of <this>"]}, "Told while fitting: of <this>"),
    ],
)
def test_what_to_trust_follows_from_the_card(change, words, card):
    worth(card, mean_policy=1.0, charts=0.0361)
    card["chosen"] = "charts"
    for key, value in change.items():
        card[key] = card[key] | value if isinstance(value, dict) else value
    assert sum(words in one for one in tell_trust(card)) == 1


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (0.61, 0.83, "too narrow"),
        (0.82, 0.95, "as they should"),
        (0.93, 0.97, "wider than need be"),
    ],
)
def test_bands_are_judged_by_their_interval(low, high, verdict, card):
    band = {"level": 0.9, "held": (low + high) / 2, "low": low, "high": high}
    card["held_out"]["bands"] = [band | {"level": 0.5}, band]
    (told,) = (one for one in tell_trust(card) if "Bands that should" in one)
    assert verdict in told
    assert f"({100 * low:.0f} % to {100 * high:.0f} %)" in told


def test_ties_are_named(card):
    worth(card, mean_policy=1.0, charts=0.01, random_forest=0.01, boosted_trees=0.5)
    card["chosen"] = "charts"
    (tie,) = (one for one in tell_trust(card) if "Not told apart" in one)
    assert "certain: “random forest”. Of such “charts” was taken" in tie


def test_what_more_rows_are_worth_is_read_from_the_curve(card):
    chosen, sizes = card["chosen"], (125, 250, 500)
    card["table"]["n_rows"] = 7001
    errors = 0.25, 0.16, 0.04
    card["curve"] = [
        {"method": chosen, "n_tasks": size, "error": error}
        for size, error in zip(sizes, errors, strict=True)
    ]
    told = [one for one in tell_trust(card) if "7,001 rows" in one]
    assert "from 250 to 500 its error still fell, from 40 % to 20 %" in told[0]
    card["curve"][-1]["error"] = 0.1599
    assert any("hardly fell" in one for one in tell_trust(card))


def test_replicates_are_told(card):
    assert len(tell_read(card)) == 1
    card["table"] |= {"n_repeated_tasks": 3, "n_replicates": 7}
    assert "3 tasks come more than once, in 7 rows" in tell_read(card)[1]
