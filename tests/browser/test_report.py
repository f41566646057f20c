"""The page of `msc fit`: names with markup, on screens, on paper, in the dark."""

import numpy as np
import pandas as pd
import pytest
from conftest import WIDE, visiting
from test_pages import NARROW, STICKING_OUT, violations

from msc.report import make_report
from msc.skills import Table, fit_table

TASK, PUSH, LIFT = "<b>angle</b> & 'co'", '"push" <i>', "lift&lt;</p>"
PICTURES = "() => Array.from(document.querySelectorAll('canvas'), c => c.toDataURL())"


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Write the page of a table with a break, drawn by a seed."""
    rng = np.random.default_rng(11)
    angle = np.sort(rng.uniform(0, 300, 60))
    push = np.cos(np.radians(angle)) + 3 * (angle > 200)
    lift = 100 * np.sin(np.radians(angle)) + rng.normal(0, 2, 60)
    table = Table(
        pd.DataFrame({TASK: angle}),
        pd.DataFrame({PUSH: push, LIFT: lift}),
        units={TASK: "deg"},
        name="<u>t</u>.csv",
    )
    methods = ["nearest neighbour", "single, one kernel"]
    fit = fit_table(table, methods=methods, command="msc fit '<u>t</u>.csv'")
    file = tmp_path_factory.mktemp("report") / "report.html"
    file.write_text(make_report(table, fit), encoding="utf-8")
    return file.as_uri()


@pytest.fixture(scope="module")
def seen(browser, address):
    """Open the page once; tests leave it as wide as it was, and on the screen."""
    with visiting(browser, "report", address) as one:
        yield one


def test_markup_in_names_is_shown_as_text(seen):
    words = seen.page.locator("main").inner_text()
    for name in (TASK, PUSH, LIFT, "<u>t</u>.csv"):
        assert name in words
    assert not seen.page.locator("main :is(b, u, i:not(.msc-legend i))").count()
    assert seen.page.title() == "<u>t</u>.csv: what was learned"


def test_it_is_accessible_and_asks_for_nothing(seen, address):
    for scheme in ("dark", "light"):
        seen.page.emulate_media(color_scheme=scheme)
        assert not violations(seen.page), scheme
    assert not seen.said
    assert [url for url in seen.asked if not url.startswith("data:")] == [address]
    missing = "Array.from(document.images).filter(i => !i.naturalWidth).length"
    assert seen.page.evaluate(missing) == 0


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["1280", "375"])
def test_nothing_sticks_out(seen, size):
    seen.page.set_viewport_size(size)
    out, page = seen.page.evaluate(STICKING_OUT), "document.scrollingElement"
    fits = seen.page.evaluate(f"{page}.scrollWidth <= {page}.clientWidth")
    seen.page.set_viewport_size(WIDE)
    assert fits, out
    assert not out


def test_the_slider_moves_by_keyboard(seen):
    slider = seen.page.locator("input[type=range]")
    said = seen.page.locator(".msc-slider output").first
    slider.focus()
    before = seen.page.evaluate(PICTURES), said.inner_text()
    for key in ("ArrowRight", "End", "Home"):
        seen.page.keyboard.press(key)
        seen.page.wait_for_timeout(200)
        now = seen.page.evaluate(PICTURES), said.inner_text()
        if key != "Home" or before[1] != now[1]:
            assert all(new != old for new, old in zip(now, before, strict=True)), key
        before = now
    assert slider.get_attribute("aria-valuetext")


def test_paper_gets_pictures_and_no_controls(seen):
    seen.page.emulate_media(media="print")
    assert seen.page.locator(".msc-poster").is_visible()
    for part in ("canvas", "input", "button"):
        assert not seen.page.locator(f"{part}:visible").count(), part
    ground = "getComputedStyle(document.body).backgroundColor"
    assert seen.page.evaluate(ground) in ("rgb(255, 255, 255)", "rgba(0, 0, 0, 0)")
