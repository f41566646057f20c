"""A term shows its sentence: pointed at, focused, touched; the first page's way out."""

import pytest
from built import PAGES

NAME = PAGES[0]


@pytest.fixture
def page(visit):
    with visit(NAME) as one:
        yield one.page
        assert not one.said


def sentence(page):
    """Return what is shown; empty if nothing is."""
    tip = page.locator("#msc-tip")
    return tip.inner_text() if tip.is_visible() else ""


def test_the_pointer_shows_a_sentence_and_may_go_there(page):
    term = page.locator("a.msc-term").first
    term.hover()
    assert sentence(page).endswith(".")
    page.locator("#msc-tip").hover()
    page.wait_for_timeout(400)
    assert sentence(page), "it goes while one reads it"
    page.mouse.move(2, 2)
    page.wait_for_timeout(400)
    assert not sentence(page)


def test_the_keyboard_shows_it_and_escape_hides_it(page):
    one, other = page.locator("a.msc-term").all()[:2]
    one.focus()
    first = sentence(page)
    assert one.get_attribute("aria-describedby") == "msc-tip"
    other.focus()
    assert sentence(page) not in ("", first)
    assert one.get_attribute("aria-describedby") is None
    page.keyboard.press("Escape")
    assert not sentence(page)
    other.focus()
    page.keyboard.press("Enter")
    page.wait_for_url("**/glossary.html#term-*")


def test_the_first_touch_shows_it_the_second_follows(visit):
    with visit(NAME, viewport={"width": 375, "height": 800}, has_touch=True) as one:
        page = one.page
        term = page.locator("a.msc-term").first
        term.tap()
        assert sentence(page)
        box = page.locator("#msc-tip").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 375
        assert page.url.endswith(f"{NAME}.html")
        term.tap()
        page.wait_for_url("**/glossary.html#term-*")


def test_without_scripts_the_browser_shows_it(visit):
    with visit(NAME, java_script_enabled=False) as one:
        assert one.page.locator("a.msc-term").first.get_attribute("title").endswith(".")


def test_the_citation_is_copied_by_a_button_that_is_seen(page):
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    button = page.locator(".msc-cite button.copybtn")
    assert button.evaluate("button => getComputedStyle(button).opacity") == "1"
    button.click()
    page.wait_for_timeout(300)
    copied = page.evaluate("navigator.clipboard.readText()")
    assert copied.startswith("@software{msc,")
    assert "@misc{paper," in copied


def test_the_first_page_says_which_edition_it_is(page):
    line = page.locator(".msc-edition")
    assert line.inner_text().startswith("Version ")
    assert line.bounding_box()["y"] < 200
    assert not page.locator(".bd-article a[href*='github.com']").count()
