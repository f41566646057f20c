"""The goal that opens the book: dragged, touched, by keys, and without a script."""

import math
import re

import pytest
from built import PAGES
from conftest import WIDE, switch_theme

NAME = PAGES[0]
PHONE = {"width": 375, "height": 800}
DRAWN = """root => Array.from(
  root.querySelectorAll(".msc-plane .msc-way:not([display]) .msc-arm"),
  arm => arm.getAttribute("d"))"""


class Picture:
    """The picture in an open page."""

    def __init__(self, visit):
        self.page = visit.page
        self.root = visit.page.locator(".msc-reach").first
        self.goal = self.root.locator(".msc-goal")

    def angle(self):
        return float(self.goal.get_attribute("aria-valuenow"))

    def drawn(self):
        return self.root.evaluate(DRAWN)

    def at(self, turn):
        """Return the place on the screen so many degrees further on the circle."""
        ring = self.root.locator(".msc-goals").bounding_box()
        radius = ring["width"] / 2
        x, y = ring["x"] + radius, ring["y"] + radius
        box = self.goal.locator("circle").last.bounding_box()
        here = math.atan2(
            y - box["y"] - box["height"] / 2, box["x"] + box["width"] / 2 - x
        )
        to = here + math.radians(turn)
        return x + radius * math.cos(to), y - radius * math.sin(to)


@pytest.fixture
def picture(visit):
    with visit(NAME) as one:
        yield Picture(one)
        assert not one.said


def turned(before, after):
    """Return by how many degrees the goal went round, from -180 to 180."""
    return (after - before + 180) % 360 - 180


def test_the_first_picture_is_seen_without_scrolling(visit):
    for size, lowest in ((WIDE, 600), (PHONE, 700)):
        with visit(NAME, viewport=size) as one:
            box = Picture(one).root.locator(".msc-plane svg").bounding_box()
            assert box["y"] + box["height"] <= lowest, size
            assert box["width"] > 300, size


@pytest.mark.parametrize("local", [False, True], ids=["http", "file"])
def test_the_goal_is_dragged_on_the_picture(visit, local):
    with visit(NAME, local=local) as one:
        drag(Picture(one))
        assert not one.said


def drag(picture):
    """Drag the goal, and look at all that follows it."""
    before, drawn = picture.angle(), picture.drawn()
    page = picture.page
    page.mouse.move(*picture.at(0))
    page.mouse.down()
    for turn in (20, 20, 20):
        page.mouse.move(*picture.at(turn))
    page.mouse.up()
    assert turned(before, picture.angle()) == pytest.approx(60, abs=6)
    assert all(new != old for new, old in zip(picture.drawn(), drawn, strict=True))
    assert f"{picture.angle():g}°" in picture.root.locator("output").inner_text()


def test_a_click_on_the_circle_calls_the_goal(picture):
    before = picture.angle()
    picture.page.mouse.click(*picture.at(90))
    assert turned(before, picture.angle()) == pytest.approx(90, abs=3)


def test_keys_step_the_goal_and_go_round(picture):
    goal, press = picture.goal, picture.page.keyboard.press
    assert goal.get_attribute("role") == "slider"
    goal.focus()
    press("Home")
    low = picture.angle()
    assert low == float(goal.get_attribute("aria-valuemin"))
    press("ArrowRight")
    step = picture.angle() - low
    assert step > 0
    press("ArrowUp")
    press("PageUp")
    assert picture.angle() == pytest.approx(low + 12 * step)
    press("ArrowLeft")
    press("PageDown")
    press("ArrowDown")
    assert picture.angle() == low
    press("ArrowLeft")
    high = float(goal.get_attribute("aria-valuemax"))
    assert picture.angle() == high
    spoken = goal.get_attribute("aria-valuetext")
    assert re.match(
        rf"{high:g} degrees\. Left to the goal: charts \d+\.\d\d cm, ", spoken
    )


def test_a_finger_drags_it_and_elsewhere_scrolls(visit):
    with visit(NAME, viewport=PHONE, has_touch=True) as one:
        picture = Picture(one)
        before = picture.angle()
        phone = one.page.context.new_cdp_session(one.page)

        def touch(kind, *places):
            points = [{"x": x, "y": y} for x, y in places]
            given = {"type": kind, "touchPoints": points}
            phone.send("Input.dispatchTouchEvent", given)

        touch("touchStart", picture.at(0))
        for turn in (15, 15, 15):
            touch("touchMove", picture.at(turn))
        touch("touchEnd")
        assert not one.page.evaluate("scrollY"), "the page scrolled"
        assert turned(before, picture.angle()) == pytest.approx(45, abs=6)
        ring = picture.root.locator(".msc-goals").bounding_box()
        beside = ring["x"] + ring["width"] * 0.6, ring["y"] + ring["height"] * 0.6
        touch("touchStart", beside)
        for up in (20, 60, 100, 140):
            touch("touchMove", (beside[0], beside[1] - up))
        touch("touchEnd")
        one.page.wait_for_function("scrollY > 40")
        target = picture.goal.locator("circle").first.bounding_box()
        assert min(target["width"], target["height"]) >= 24


def test_every_method_is_switched_on_and_off(picture):
    boxes = picture.root.locator("input[type=checkbox]")
    wanted = sum(box.is_checked() for box in boxes.all())
    assert len(picture.drawn()) == wanted
    for box in boxes.all():
        box.focus()
        picture.page.keyboard.press("Space")
        wanted += 1 if box.is_checked() else -1
        assert len(picture.drawn()) == wanted
    spoken = picture.goal.get_attribute("aria-valuetext")
    assert "searched" in spoken
    assert "single regression" not in spoken
    names = picture.root.locator("label span").all_inner_texts()
    assert {"linear interpolation", "charts, one kernel"} <= {*names}


def test_what_it_says_is_what_it_draws(picture):
    for box in picture.root.locator("input[type=checkbox]").all():
        box.set_checked(True)
    left = picture.root.evaluate(
        """root => {
          const goal = root.querySelector(".msc-goal").transform.baseVal[0].matrix;
          return Array.from(root.querySelectorAll(".msc-plane .msc-way"), way => {
            const arm = way.querySelector(".msc-arm").getAttribute("d");
            const [x, y] = arm.split("L").pop().split(" ").map(Number);
            return Math.hypot(x - goal.e, y - goal.f);
          });
        }"""
    )
    said = picture.root.locator("label b").all_inner_texts()[::-1]
    assert left == pytest.approx([float(one.split()[0]) for one in said], abs=0.12)


def test_play_moves_the_arms_unless_one_wants_no_motion(visit):
    for wish, moves in (("no-preference", True), ("reduce", False)):
        with visit(NAME, reduced_motion=wish) as one:
            picture = Picture(one)
            one.page.wait_for_timeout(2500)  # it plays once by itself
            before = picture.drawn()
            picture.root.get_by_role("button", name="Play").click()
            one.page.wait_for_timeout(300)
            assert (picture.drawn() != before) == moves, wish
            one.page.wait_for_timeout(2500)
            assert picture.drawn() == before, wish


def test_without_scripts_and_on_paper_it_is_a_picture(visit):
    with visit(NAME, java_script_enabled=False) as one:
        root = Picture(one).root
        assert root.locator(".msc-plane svg[role=img]").is_visible()
        assert root.locator(".msc-plane .msc-arm:visible").count() == 3
        assert not root.locator(":is(input, button):visible").count()
        assert not root.locator("[role=slider]").count()
    with visit(NAME) as one:
        one.page.emulate_media(media="print")
        root = Picture(one).root
        assert root.locator(".msc-plane svg").is_visible()
        assert not root.locator(":is(input, button):visible").count()


def test_its_colours_change_with_the_theme(picture):
    colour = "way => getComputedStyle(way).color"
    way = picture.root.locator(".msc-plane .msc-way").last
    light = way.evaluate(colour)
    switch_theme(picture.page, "dark")
    assert way.evaluate(colour) != light
