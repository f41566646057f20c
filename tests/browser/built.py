"""The built book as it lies on the disk: its pages, their links and what they load."""

from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

from press import pages

ROOT = Path(__file__).parents[2]
HTML = ROOT / "_build" / "html"
PAGES = [
    source.relative_to(ROOT / "book").with_suffix("").as_posix()
    for source in pages(ROOT)
]

# Where elements name other files.
LINKS = {("a", "href"), ("area", "href")}
RESOURCES = {
    ("audio", "src"),
    ("embed", "src"),
    ("iframe", "src"),
    ("img", "src"),
    ("link", "href"),
    ("object", "data"),
    ("script", "src"),
    ("source", "src"),
    ("video", "src"),
}


@dataclass
class Page(HTMLParser):
    """What a page names: anchors of its own, links, files that it loads."""

    ids: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    resources: list[str] = field(default_factory=list)

    def __post_init__(self):
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id" or (tag, name) == ("a", "name"):
                self.ids.append(value)
            elif (tag, name) in LINKS:
                self.links.append(value or "")
            elif (tag, name) in RESOURCES:
                self.resources.append(value or "")


@cache
def read(file):
    """Read one HTML file of the book."""
    page = Page()
    page.feed(file.read_text(encoding="utf-8"))
    return page


def built(name):
    """Return the file of a page."""
    return HTML / f"{name}.html"


@cache
def source(name):
    """Return the HTML of a page; empty if it is not built."""
    return built(name).read_text(encoding="utf-8") if built(name).is_file() else ""


def holding(text):
    """Name the pages whose HTML holds a text."""
    return [name for name in PAGES if text in source(name)]
