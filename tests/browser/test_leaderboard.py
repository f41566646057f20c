"""The table of all methods: sorted and filtered by keyboard, whole on a phone."""

import pytest

NAME = "leaderboard"
NARROW = {"width": 375, "height": 800}


@pytest.fixture(scope="module")
def page(visit):
    with visit(NAME) as one:
        yield one.page


def rows(page):
    """Return of each row the name, and what is said of its mean."""
    return page.evaluate(
        """() => Array.from(
          document.querySelectorAll(".msc-leaderboard tbody tr"),
          row => [row.cells[0].firstChild.data, row.cells[2].firstChild.data],
        )"""
    )


def test_the_table_is_shown_and_not_its_picture(page):
    assert page.locator(".msc-leaderboard table").is_visible()
    assert not page.locator(".msc-leaderboard .msc-poster").is_visible()
    assert len(rows(page)) > 20
    assert page.locator(".msc-axis span").count() > 1


def test_a_head_sorts_by_keyboard_both_ways(page):
    for key, place in (("name", 0), ("mean", 1)):
        head = page.locator(f".msc-leaderboard th button[value={key}]")
        head.focus()
        page.keyboard.press("Enter")
        up = [row[place] for row in rows(page)]
        assert head.locator("..").get_attribute("aria-sort") == "ascending"
        page.keyboard.press("Enter")
        down = [row[place] for row in rows(page)]
        assert head.locator("..").get_attribute("aria-sort") == "descending"
        page.keyboard.press("Enter")
        assert up != down
        if key == "name":
            assert up == down[::-1]


def test_boxes_and_lists_choose_rows(page):
    before = rows(page)
    box = page.locator(".msc-groups input:not(:checked)").first
    box.focus()
    page.keyboard.press("Space")
    assert len(rows(page)) > len(before)
    told = page.locator(".msc-told")
    said = told.inner_text()
    page.locator(".msc-leaderboard select").nth(1).select_option("excess_cost")
    assert told.inner_text() != said
    assert "excess cost" in told.inner_text()


def test_all_of_a_row_is_seen_on_a_phone(page):
    page.set_viewport_size(NARROW)
    wide = page.evaluate(
        """() => Array.from(document.querySelectorAll(".msc-leaderboard td"))
          .filter(cell => cell.getBoundingClientRect().right > innerWidth).length"""
    )
    assert not wide
    widths = page.locator(".msc-leaderboard .msc-bar").first.bounding_box()
    assert widths["width"] > 0.8 * NARROW["width"]
