"""What a reader does in the book: searches it, and changes its colours."""

import re

import pytest
from built import PAGES, built
from conftest import switch_theme

BACKGROUND = """() => {
  const colour = getComputedStyle(document.body).backgroundColor;
  const [red, green, blue] = colour.match(/[\\d.]+/g).map(Number);
  return (red + green + blue) / 765;
}"""


def word_of(name):
    """Return the longest word of a page's title."""
    html = built(name).read_text(encoding="utf-8")
    title = re.search(r"<h1>(.*?)(<a class=\"headerlink|</h1>)", html, re.DOTALL)[1]
    return max(re.findall(r"[a-z]+", re.sub("<.*?>", "", title), re.I), key=len)


@pytest.mark.parametrize(("name", "local"), [(PAGES[1], False), (PAGES[-1], True)])
def test_search_finds_a_word(visit, name, local):
    word = word_of(name)
    with visit(PAGES[0], local=local) as seen:
        page = seen.page
        page.locator(".search-button__button:visible").first.click()
        page.locator("#pst-search-dialog input[type=search]").fill(word)
        page.keyboard.press("Enter")
        page.wait_for_url(f"**/search.html?q={word}*")
        found = page.locator("#search-results li a")
        found.first.wait_for()
        page.wait_for_load_state("networkidle")
        paths = found.evaluate_all("links => links.map(link => link.pathname)")
        assert any(path.endswith(f"/{name}.html") for path in paths), (
            f"the search for {word!r} does not find {name}.html but {paths}"
        )
        assert not seen.said, f"search for {word!r}: {seen.said}"


def test_search_says_that_there_is_nothing(visit):
    with visit("search", query="?q=qwertzuiop") as seen:
        seen.page.get_by_text("did not match any documents").wait_for()
        assert not seen.page.locator("#search-results li").count()
        assert not seen.said


def test_the_button_changes_the_theme_for_all_pages(visit):
    with visit(PAGES[0]) as seen:
        page = seen.page
        light = page.evaluate(BACKGROUND)
        switch_theme(page, "dark")
        dark = page.evaluate(BACKGROUND)
        assert light > 0.9, f"brightness {light}"
        assert dark < 0.3, f"brightness {dark}"
        page.goto(page.url.replace(f"{PAGES[0]}.html", f"{PAGES[1]}.html"))
        assert page.evaluate(BACKGROUND) == dark, f"{PAGES[1]}.html forgets the theme"
        switch_theme(page, "light")
        assert page.evaluate(BACKGROUND) == light


def test_a_wide_figure_keeps_its_size_on_a_phone(visit):
    with visit("what_it_costs", viewport={"width": 375, "height": 800}) as seen:
        page = seen.page
        frame = page.locator(".msc-wide").first
        frame.focus()
        page.keyboard.press("ArrowRight")
        page.wait_for_function(
            "frame => frame.scrollLeft > 0", arg=frame.element_handle()
        )
        assert frame.locator("img").bounding_box()["width"] >= 600
        page.set_viewport_size({"width": 1280, "height": 900})
        assert frame.evaluate("frame => frame.tabIndex") == -1
