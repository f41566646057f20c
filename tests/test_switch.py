"""Figures of which a page shows one: buttons in the order of pictures, described."""

import base64
import re

import matplotlib.pyplot as plt
import pytest

from msc.plots import Switch


def figure(width):
    drawn = plt.figure(figsize=(width, 1))
    drawn.add_subplot()
    plt.close(drawn)
    return drawn


@pytest.fixture(scope="module")
def bundle():
    pair = {"one <each>": figure(2), "common": figure(3)}
    return Switch("scale", pair, "Two errors.")._repr_mimebundle_()


def test_each_picture_has_a_button_and_words_in_its_place(bundle):
    page = bundle["text/html"]
    buttons = re.findall("<label><input[^>]*> (.*?)</label>", page)
    assert buttons == ["one &lt;each&gt;", "common"]
    alts = re.findall('alt="(.*?)"', page)
    assert alts[1] == "Two errors. scale: common."
    assert len(re.findall(" checked", page)) == 1
    assert page.index("</label><div>") > page.rindex("<input")


def test_where_there_is_no_html_the_first_is_shown(bundle):
    first = re.search('base64,(.*?)"', bundle["text/html"])[1]
    assert bundle["image/png"] == first
    assert base64.b64decode(first).startswith(b"\x89PNG")
    assert bundle["image/svg+xml"].startswith("<?xml")


def test_a_switch_of_one_is_refused():
    with pytest.raises(ValueError, match="figures: 1 of them; wanted two at least"):
        Switch("scale", {"one": figure(1)}, "An error.")


def test_two_switches_of_a_page_do_not_disturb_each_other(bundle):
    other = Switch("scale", {"a": figure(2), "b": figure(4)}, "Two.").to_html()
    names = [set(re.findall('name="(.*?)"', t)) for t in (bundle["text/html"], other)]
    assert names[0].isdisjoint(names[1])
