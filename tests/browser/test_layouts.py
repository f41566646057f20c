"""The layouts to choose from: by a click, by keys and by the address; goals dragged."""

import pytest
from built import PAGES
from test_reach import PHONE, Picture, turned

NAME = next(name for name in PAGES if name.endswith("worlds_layouts"))
OBSTACLES = """root => Array.from(
  root.querySelectorAll(".msc-plane g > g > circle[cx]"),
  one => [one.getAttribute("cx"), one.getAttribute("cy")].join())"""


class Layouts(Picture):
    """The picture in an open page, and the strip above it."""

    def __init__(self, visit):
        super().__init__(visit)
        self.all = visit.page.locator(".msc-layouts")

    def label(self, name):
        return self.all.locator(f"label#drag-{name}")

    def chosen(self):
        return self.all.locator("label:has([type=radio]:checked)").get_attribute("id")

    def told(self):
        return self.all.locator("> p").inner_text()

    def obstacles(self):
        return self.root.evaluate(OBSTACLES)


@pytest.fixture(params=[False, True], ids=["http", "file"])
def layouts(visit, request):
    with visit(NAME, local=request.param) as one:
        yield Layouts(one)
        assert not one.said


def test_a_click_chooses_a_layout(layouts):
    before, drawn = layouts.obstacles(), layouts.drawn()
    assert layouts.chosen() == "drag-layout01"
    layouts.label("layout07").click()
    assert layouts.chosen() == "drag-layout07"
    assert layouts.told().startswith("layout07: 4 obstacles")
    assert len(layouts.obstacles()) == 4
    assert layouts.obstacles() != before
    assert layouts.drawn() != drawn
    assert layouts.page.url.endswith("#drag-layout07")
    layouts.label("layout01").click()
    assert (layouts.obstacles(), layouts.drawn()) == (before, drawn)


def test_keys_choose_the_next_and_the_last(layouts):
    press = layouts.page.keyboard.press
    layouts.label("layout01").locator("input").focus()
    press("ArrowRight")
    assert layouts.chosen() == "drag-layout02"
    press("ArrowLeft")
    press("ArrowLeft")
    assert layouts.chosen() == "drag-layout24"
    assert layouts.told().startswith("layout24: ")
    focused = layouts.label("layout24").evaluate(
        "one => getComputedStyle(one).outlineStyle"
    )
    assert focused == "solid"


def test_the_goal_is_dragged_in_the_layout_that_was_chosen(layouts):
    layouts.label("layout05").click()
    before, drawn, page = layouts.angle(), layouts.drawn(), layouts.page
    page.mouse.move(*layouts.at(0))
    page.mouse.down()
    for turn in (30, 30):
        page.mouse.move(*layouts.at(turn))
    page.mouse.up()
    assert turned(before, layouts.angle()) == pytest.approx(60, abs=6)
    assert all(new != old for new, old in zip(layouts.drawn(), drawn, strict=True))
    said = layouts.root.locator("output").inner_text()
    assert said.startswith(f"Goal at {layouts.angle():g}°: chart ")
    assert said[-1] in layouts.root.locator(".msc-chart text").all_text_contents()


def test_a_method_stays_switched_off_in_another_layout(layouts):
    box = layouts.root.locator("label", has_text="single regression").locator("input")
    box.uncheck()
    layouts.label("layout12").click()
    assert not box.is_checked()
    assert len(layouts.drawn()) == 2


def test_what_touched_is_told_in_words(layouts):
    layouts.label("layout05").click()
    layouts.goal.focus()
    told = set()
    for _ in range(12):
        told |= {*layouts.root.locator("label b").all_inner_texts()}
        layouts.page.keyboard.press("ArrowRight")
    assert {one.partition(" cm")[2] for one in told} == {"", ", touched"}


def test_the_address_chooses_and_sections_lead_back(visit):
    with visit(NAME, query="#layout07") as one:
        layouts = Layouts(one)
        one.page.wait_for_function("document.getElementById('layout07').open")
        assert layouts.chosen() == "drag-layout07"
        back = one.page.locator("details#layout07 a[href='#drag-layout07']")
        layouts.label("layout03").click()
        back.click()
        one.page.wait_for_function("location.hash === '#drag-layout07'")
        assert layouts.chosen() == "drag-layout07"
        assert layouts.label("layout07").bounding_box()["y"] >= 0
        layouts.label("layout03").click()
        layouts.all.locator("> p a").click()
        one.page.wait_for_function("document.getElementById('layout03').open")
        section = one.page.locator("details#layout03")
        assert section.evaluate("one => one.getBoundingClientRect().top") < 200


def test_the_strip_opens_the_page_and_fits_a_phone(visit):
    with visit(NAME) as one:
        layouts = Layouts(one)
        assert layouts.root.locator(".msc-plane").bounding_box()["y"] < 600
    with visit(NAME, viewport=PHONE, has_touch=True) as one:
        layouts = Layouts(one)
        assert one.page.evaluate("document.documentElement.scrollWidth") == 375
        for label in layouts.all.locator("label:has([type=radio])").all():
            box = label.bounding_box()
            assert 0 <= box["x"] <= box["x"] + box["width"] <= 375
            assert min(box["width"], box["height"]) >= 40
        layouts.label("layout20").tap()
        assert layouts.chosen() == "drag-layout20"


def test_without_scripts_the_first_is_a_picture(visit):
    with visit(NAME, java_script_enabled=False) as one:
        layouts = Layouts(one)
        assert layouts.root.locator(".msc-plane svg[role=img]").is_visible()
        assert layouts.root.locator(".msc-plane .msc-arm:visible").count() == 3
        assert layouts.all.locator("label svg:visible").count() == 24 + 7
