"""Every page of the book: it loads, is typeset, is readable, and fits a phone."""

import json
import re
from pathlib import Path

import axe_playwright_python
import pytest
from built import PAGES, holding
from conftest import WIDE, switch_theme
from known import is_known

AXE = (Path(axe_playwright_python.__file__).parent / "axe.min.js").read_text("utf-8")
NARROW = {"width": 375, "height": 800}
LONGEST = 12_000  # pixels that a page may have, in the wide window
ENDLESS = {"changelog"}  # it grows, and nobody reads it from top to bottom

# Formulas that are not pictures: nothing drawn, or an error drawn.
UNSET = """() => Array.from(document.querySelectorAll(".math")).filter(formula => {
  const drawn = formula.querySelectorAll("mjx-container svg");
  return !drawn.length || formula.querySelector("[data-mml-node=merror], mjx-merror");
}).map(formula => formula.textContent.slice(0, 80))"""

# Text that a reader sees, but for code.
PROSE = """() => {
  const texts = [], skip = "pre, code, script, style, mjx-container, .math";
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    if (!walk.currentNode.parentElement.closest(skip)) {
      texts.push(walk.currentNode.data);
    }
  }
  return texts;
}"""

# What is a picture to those who do not see it: its words, and itself.
PICTURES = """() => Array.from(
  document.querySelectorAll("img, canvas, [role=img]")
).filter(
  element => !element.closest("[aria-hidden=true], [aria-labelledby], mjx-container")
).map(element => [
  element.alt ?? element.getAttribute("aria-label") ?? "",
  element.outerHTML.slice(0, 150),
])"""

# What reaches beyond the right edge of the page's column, where nothing scrolls it.
STICKING_OUT = """() => {
  const column = document.querySelector("article.bd-article") ?? document.body;
  const edge = column.getBoundingClientRect().right + 1;
  const scrolls = element => element && element !== column && (
    /auto|scroll/.test(getComputedStyle(element).overflowX)
    || scrolls(element.parentElement));
  const out = Array.from(column.querySelectorAll("*")).filter(element =>
    element.getBoundingClientRect().right > edge
    && !element.closest("svg svg, svg g, .visually-hidden")
    && getComputedStyle(element).visibility !== "hidden"
    && !scrolls(element.parentElement) && !scrolls(element));
  const page = document.scrollingElement;
  if (page.scrollWidth > page.clientWidth && !out.length) { out.push(page); }
  const inmost = out.filter(element => !out.some(
    other => other !== element && element.contains(other)));
  return inmost.map(element => `${element.outerHTML.slice(0, 120)}: ${
    Math.round(element.getBoundingClientRect().right - edge)} px`);
}"""


@pytest.fixture(scope="module", params=PAGES)
def seen(request, visit):
    """Open each page once for all tests here."""
    with visit(request.param) as one:
        yield one


def violations(page):
    """Let axe-core look; describe what it finds and the theme is not known for."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE)
    run = "axe.run(document, {resultTypes: ['violations'], preload: false})"
    return [
        f"{found['id']} ({found['help']}) at {selector}: {' '.join(html.split())[:150]}"
        + "".join(f"\n    {check['message']}" for check in node["any"][:1])
        for found in page.evaluate(run)["violations"]
        for node in found["nodes"]
        for selector, html in [(json.dumps(node["target"]), node["html"])]
        if not is_known(found["id"], selector, html)
    ]


def listed(name, findings):
    """Write findings below one another under the page's name."""
    return "\n  ".join([f"{name}.html:", *findings])


def test_every_formula_is_typeset(seen):
    unset = seen.page.evaluate(UNSET)
    assert not unset, listed(seen.name, unset)


def test_no_formula_is_left_as_source(seen):
    raw = re.compile(r"\$\$|\\[(\[]|\\(begin|frac|mathbf|sum|sqrt|theta)\b|\$\S[^$]*\$")
    left = [text.strip() for text in seen.page.evaluate(PROSE) if raw.search(text)]
    assert not left, listed(seen.name, left)


def test_every_picture_has_words(seen):
    pictures = seen.page.evaluate(PICTURES)
    file_name = re.compile(r"\S*\.(png|svg|gif|jpe?g|webp)", re.IGNORECASE)
    bad = [
        html
        for words, html in pictures
        if not words.strip() or file_name.fullmatch(words.strip())
    ]
    assert not bad, listed(seen.name, bad)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_accessible(seen, theme):
    switch_theme(seen.page, theme)
    assert seen.page.evaluate("document.documentElement.dataset.theme") == theme
    found = violations(seen.page)
    switch_theme(seen.page, "light")
    assert not found, listed(f"{seen.name} ({theme})", found)


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["1280", "375"])
def test_nothing_sticks_out(seen, size):
    seen.page.set_viewport_size(size)
    out = seen.page.evaluate(STICKING_OUT)
    seen.page.set_viewport_size(WIDE)
    assert not out, listed(f"{seen.name} at {size['width']} px", out)


def test_a_page_is_not_too_long(seen):
    if seen.name in ENDLESS:
        pytest.skip("may be as long as it likes")
    height = seen.page.evaluate("document.scrollingElement.scrollHeight")
    assert height <= LONGEST, f"{seen.name}.html: {height} px; wanted at most {LONGEST}"


def test_a_figure_s_page_begins_with_it(seen):
    if not re.match(r"fig\d", seen.name):
        pytest.skip("no page of a figure")
    first = seen.page.locator("article .cell_output :is(img, .msc-slider)").first
    box = first.bounding_box()
    assert box["y"] < 400
    assert box["y"] + min(box["height"], 300) < 700


# The last tests of each page: what happened in the others counts too.
def test_no_error_in_the_console(seen):
    assert not seen.said, listed(seen.name, seen.said)


def test_no_request_elsewhere(seen, address):
    away = [
        url for url in seen.asked if not url.startswith((address, "data:", "blob:"))
    ]
    assert not away, listed(seen.name, away)


WITHOUT_SERVER = list(dict.fromkeys([
    PAGES[0], *holding("msc-slider")[:1], *holding('class="math')[:1]
]))  # fmt: skip


@pytest.mark.parametrize("name", WITHOUT_SERVER)
def test_opened_from_its_file(name, visit):
    with visit(name, local=True) as seen:
        assert not seen.said, listed(name, seen.said)
        away = [url for url in seen.asked if not url.startswith(("file:", "data:"))]
        assert not away, listed(name, away)
        unset = seen.page.evaluate(UNSET)
        assert not unset, listed(name, unset)
        broken = seen.page.evaluate(
            "Array.from(document.images).filter(i => !i.naturalWidth).map(i => i.src)"
        )
        assert not broken, listed(name, broken)
