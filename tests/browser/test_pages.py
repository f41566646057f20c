"""Every page of the book: it loads, is typeset, is readable, and fits a phone."""

import json
import re
from pathlib import Path

import axe_playwright_python
import pytest
from built import PAGES, holding, source
from conftest import WIDE, switch_theme
from known import is_known
from some import some

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


def left_as_source(page):
    """Return texts that hold a formula as it is written, and not as it looks."""
    raw = re.compile(r"\$\$|\\[(\[]|\\(begin|frac|mathbf|sum|sqrt|theta)\b|\$\S[^$]*\$")
    return [text.strip() for text in page.evaluate(PROSE) if raw.search(text)]


def without_words(page):
    """Return pictures that say nothing, or the name of their file."""
    file_name = re.compile(r"\S*\.(png|svg|gif|jpe?g|webp)", re.IGNORECASE)
    return [
        html
        for words, html in page.evaluate(PICTURES)
        if not words.strip() or file_name.fullmatch(words.strip())
    ]


def too_long(page, name):
    """Return the height of a page that nobody reads to the end."""
    height = page.evaluate("document.scrollingElement.scrollHeight")
    return [f"{height} px"] if height > LONGEST and name not in ENDLESS else []


def late_figure(page, name):
    """Return where the first figure of a figure's page is, if not at its head."""
    if not re.match(r"fig\d", name):
        return []
    box = page.locator(
        "article .cell_output :is(img, .msc-slider)"
    ).first.bounding_box()
    is_seen = box["y"] < 400 and box["y"] + min(box["height"], 300) < 700
    return [] if is_seen else [f"{box}"]


def cover():
    """Choose pages that together hold every kind of thing of our own."""
    kinds = {
        name: set(re.findall(r'class="(msc-[a-z-]+)', source(name))) for name in PAGES
    }
    chosen, missing = [], set().union(*kinds.values())
    while missing:
        chosen.append(max(kinds, key=lambda name: len(kinds[name] & missing)))
        missing -= kinds[chosen[-1]]
    return chosen


# axe-core looks long: at these, and at a third of the others.
KINDS = cover()
EXAMINED = {*KINDS, *some(PAGES, every=3)}


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_typeset_accessible_and_fits_and_asks_for_nothing(
    name, look_at, address
):
    """All that is to be seen of a page, in one visit."""
    seen = look_at(name)
    page = seen.page
    found = {
        "not typeset": page.evaluate(UNSET),
        "left as source": left_as_source(page),
        "a picture without words": without_words(page),
        "not accessible": violations(page) if name in EXAMINED else [],
        "sticks out": page.evaluate(STICKING_OUT),
        "too long": too_long(page, name),
        "the figure comes late": late_figure(page, name),
    }
    page.set_viewport_size(NARROW)
    found["sticks out of a phone"] = page.evaluate(STICKING_OUT)
    page.set_viewport_size(WIDE)
    here = (address, "data:", "blob:")
    found["an error in the console"] = seen.said
    found["a request elsewhere"] = [
        url for url in seen.asked if not url.startswith(here)
    ]
    faults = [f"{what}: {one}" for what, some in found.items() for one in some]
    assert not faults, listed(name, faults)


@pytest.mark.parametrize("name", KINDS)
def test_accessible_in_the_dark(name, visit):
    with visit(name) as seen:
        switch_theme(seen.page, "dark")
        assert seen.page.evaluate("document.documentElement.dataset.theme") == "dark"
        assert not (found := violations(seen.page)), listed(name, found)
        assert not seen.said, listed(name, seen.said)


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
