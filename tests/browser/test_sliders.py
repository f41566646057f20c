"""Drawings that follow a slider: by mouse, by keyboard, in the dark, without script."""

import re

import pytest
from built import built, holding
from conftest import switch_theme
from vision import contrast

SLIDERS = {
    (name, number): html
    for name in holding('class="msc-slider')
    for number, html in enumerate(
        built(name).read_text(encoding="utf-8").split('class="msc-slider')[1:]
    )
}
FILMS = [where for where, html in SLIDERS.items() if ">Play</button>" in html]
SOON = 10_000  # ms that a picture may take to follow

PICTURES = "root => Array.from(root.querySelectorAll('canvas'), c => c.toDataURL())"
BLANK = """root => Array.from(root.querySelectorAll("canvas")).filter(canvas => {
  const area = [0, 0, canvas.width || 1, canvas.height || 1];
  const pixels = canvas.getContext("2d").getImageData(...area).data;
  return new Set(new Uint32Array(pixels.buffer)).size < 2;
}).map(canvas => canvas.getAttribute("aria-label"))"""


# Press Play and show the frames one after another, five a second by a clock that no
# busy machine disturbs: the number of different pictures, and whether the last is the
# first.
FILM = """root => {
  let time = 1000;
  const frames = [], seen = new Set();
  const look = () => Array.from(
    root.querySelectorAll("canvas"), canvas => canvas.toDataURL()
  ).join();
  performance.now = () => time;
  window.requestAnimationFrame = frame => frames.push(frame);
  const first = look();
  root.querySelector("button").click();
  while (frames.length && time < 30_000) {
    time += 200;
    frames.splice(0).forEach(frame => frame(time));
    seen.add(look());
  }
  return [seen.size, look() === first];
}"""


class Drawing:
    """A slider in an open page, with what it draws and says."""

    def __init__(self, visit, number):
        self.page = visit.page
        self.where = f"{visit.name}.html, slider {number + 1}"
        self.root = visit.page.locator(".msc-slider").nth(number)
        self.slider = self.root.locator("input[type=range]").first
        self.output = self.root.locator("output").first

    def state(self):
        """Return pictures, words and the spoken value."""
        spoken = self.slider.get_attribute("aria-valuetext")
        return self.root.evaluate(PICTURES), self.output.inner_text(), spoken

    def value(self):
        return float(self.slider.input_value())

    def follows(self, before, by):
        """Check that everything has changed, after a while at most."""
        for _ in range(SOON // 50):
            now = self.state()
            if all(new != old for new, old in zip(now, before, strict=True)):
                return now
            self.page.wait_for_timeout(50)
        parts = zip(("picture", "caption", "spoken value"), now, before, strict=True)
        still = [part for part, new, old in parts if new == old]
        pytest.fail(f"{self.where}: moved by {by}, the same as before: {still}")


@pytest.fixture(
    scope="module", params=SLIDERS, ids=lambda where: "{}-{}".format(*where)
)
def drawing(visit, request):
    """Open each slider's page once; tests leave it light, and on the screen."""
    name, number = request.param
    with visit(name) as one:
        yield Drawing(one, number)


def test_slider(drawing):
    where, slider = drawing.where, drawing.slider
    slider.scroll_into_view_if_needed()
    blank = drawing.root.evaluate(BLANK)
    assert not blank, f"{where}: nothing is drawn on {blank}"
    assert not drawing.root.locator(".msc-poster").is_visible(), where

    first = drawing.state()
    assert first[1].strip(), f"{where}: no caption"
    box = slider.bounding_box()
    start = drawing.value()
    middle = box["y"] + box["height"] / 2
    share = start / max(1, float(slider.get_attribute("max")))
    drawing.page.mouse.move(box["x"] + box["width"] * (0.03 + 0.94 * share), middle)
    drawing.page.mouse.down()
    end = 0.2 if share > 0.5 else 0.8
    drawing.page.mouse.move(box["x"] + box["width"] * end, middle, steps=4)
    drawing.page.mouse.up()
    assert drawing.value() != start, f"{where}: the mouse does not move it"
    dragged = drawing.follows(first, "mouse")

    slider.focus()
    drawing.page.keyboard.press("End")
    drawing.page.keyboard.press("Home")
    assert drawing.value() == float(slider.get_attribute("min")), where
    home = drawing.follows(dragged, "the key Home")
    drawing.page.keyboard.press("ArrowRight")
    assert drawing.value() > float(slider.get_attribute("min")), where
    drawing.follows(home, "the key ArrowRight")


def test_it_is_drawn_anew_in_the_dark_and_its_colours_stand_out(drawing):
    light, *_ = drawing.state()
    switch_theme(drawing.page, "dark")
    drawing.page.wait_for_timeout(100)
    dark, *_ = drawing.state()
    assert light != dark, f"{drawing.where} keeps the ink of the light theme"
    colours = drawing.root.locator(".msc-legend i").evaluate_all(
        "dots => dots.map(dot => getComputedStyle(dot).backgroundColor)"
    )
    ground = drawing.page.evaluate("getComputedStyle(document.body).backgroundColor")
    switch_theme(drawing.page, "light")
    for colour in colours:
        apart = contrast(*(rgb(one) for one in (colour, ground)))
        assert apart >= 3, f"{drawing.where}: {colour} on {ground}"


def rgb(css):
    """Return a colour's parts, from 0 to 1, as the browser writes it."""
    return tuple(int(part) / 255 for part in re.findall(r"\d+", css)[:3])


def test_paper_gets_the_poster(drawing):
    drawing.page.emulate_media(media="print")
    shows_the_poster(drawing)
    drawing.page.emulate_media(media="screen")


@pytest.mark.parametrize("name", dict.fromkeys(name for name, _ in SLIDERS))
def test_without_scripts_there_is_the_poster(visit, name):
    with visit(name, java_script_enabled=False) as one:
        for number in range(one.page.locator(".msc-slider").count()):
            shows_the_poster(Drawing(one, number))


def shows_the_poster(drawing):
    """Check that the picture is there, with no control that does nothing."""
    poster = drawing.root.locator(".msc-poster")
    assert poster.is_visible(), f"{drawing.where}: no poster"
    assert poster.evaluate("image => image.naturalWidth") > 100, drawing.where
    for part in ("canvas", "input", "button"):
        shown = drawing.root.locator(f"{part}:visible").count()
        assert not shown, f"{drawing.where}: {shown} {part} beside the poster"


@pytest.mark.parametrize(("name", "number"), FILMS)
def test_a_film_plays_and_ends(visit, name, number):
    with visit(name, reduced_motion="no-preference") as one:
        drawing = Drawing(one, number)
        pictures, ends = drawing.root.evaluate(FILM)
        assert pictures > 5, f"{drawing.where}: Play moves nothing"
        last = drawing.value() == float(drawing.slider.get_attribute("max"))
        assert ends or last, f"{drawing.where}: it ends neither where it began nor last"
