"""A figure in more ways than one: chosen by keyboard, and all of them on paper."""

import pytest
from built import holding


@pytest.fixture(scope="module", params=holding("msc-switch"))
def page(request, visit):
    with visit(request.param) as one:
        yield one.page


def shown(page):
    """Tell of each picture of the first switch whether it is seen."""
    pictures = page.locator(".msc-switch").first.locator("img")
    return [picture.is_visible() for picture in pictures.all()]


def test_the_keyboard_chooses_the_picture(page):
    assert shown(page) == [True, False]
    page.locator(".msc-switch input").first.focus()
    page.keyboard.press("ArrowRight")
    assert shown(page) == [False, True]
    page.keyboard.press("ArrowLeft")
    assert shown(page) == [True, False]


def test_on_paper_all_are_there_and_named(page):
    page.emulate_media(media="print")
    assert shown(page) == [True, True]
    assert page.locator(".msc-switch p").first.is_visible()
    assert not page.locator(".msc-switch input").first.is_visible()
    page.emulate_media(media="screen")
