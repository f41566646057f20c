"""One browser for all tests, and a server that keeps the book in a folder of a host."""

import os
import shutil
import threading
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest
from built import HTML, PAGES, built
from playwright.sync_api import Page, sync_playwright

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
PREFIX = "/some/where/"
WIDE = {"width": 1280, "height": 900}
PATIENCE = 120_000  # ms, for a machine that does much else

# Whatever is not on this machine cannot be reached, not even looked up.
ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
]

# Wait for MathJax, where a page has it, but not for ever.
TYPESET = """ms => Promise.race([
  Promise.resolve(window.MathJax?.startup?.promise).then(() => true),
  new Promise(resolve => setTimeout(() => resolve(false), ms)),
])"""


def pytest_configure(config):
    """Refuse to start without what is to be looked at, and without eyes."""
    if not built(PAGES[0]).is_file():
        raise pytest.UsageError(f"there is no book in {HTML}: make book comes first")
    if not CHROMIUM:
        raise pytest.UsageError(
            "these tests need a Chromium on the PATH (Debian: apt-get install "
            "chromium), or its path in the environment variable CHROMIUM"
        )


@dataclass
class Visit:
    """A page that is open, with what it said and asked for since."""

    name: str
    page: Page
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)


@contextmanager
def visiting(browser, name, url, **options):
    """Open a page in a window of its own, and close it."""
    settings = {"viewport": WIDE, "reduced_motion": "reduce"} | options
    context = browser.new_context(**settings)
    try:
        visit = Visit(name, new_page(context))
        listen(visit)
        load(visit, url)
        if options.get("java_script_enabled", True):
            typeset(visit)
        yield visit
    finally:
        context.close()


def new_page(context):
    """Open an empty page that waits for slow machines."""
    context.set_default_timeout(PATIENCE)
    return context.new_page()


def load(visit, url):
    """Open an address in a page."""
    answer = visit.page.goto(url)
    assert url.startswith("file:") or answer.ok, (
        f"{visit.name}: {url} answers {answer.status}; make book builds it"
    )


def typeset(visit):
    """Wait until all formulas are drawn."""
    done = visit.page.evaluate(TYPESET, PATIENCE)
    assert done, f"{visit.name}: MathJax does not finish"


def listen(visit):
    """Note what a page says and asks for."""
    page = visit.page
    page.on("pageerror", lambda error: visit.said.append(f"uncaught: {error}"))
    page.on("request", lambda request: visit.asked.append(request.url))
    page.on("console", lambda said: note(visit, said))


def note(visit, said):
    """Note an error that a page writes to the console."""
    if said.type == "error":
        visit.said.append(f"{said.text} ({said.location['url']})")


class Handler(SimpleHTTPRequestHandler):
    """Serve the book below the prefix, and nothing elsewhere."""

    def translate_path(self, path):
        if not path.startswith(PREFIX):
            return os.devnull + "/"
        return super().translate_path(path.removeprefix(PREFIX.rstrip("/")))

    def log_message(self, *_):
        pass


@pytest.fixture(scope="session")
def address():
    """Serve the book; give the URL of its folder."""
    serve = partial(Handler, directory=str(HTML))
    with ThreadingHTTPServer(("127.0.0.1", 0), serve) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}{PREFIX}"
        server.shutdown()


@pytest.fixture(scope="session")
def browser():
    """Start the system's Chromium, without a window."""
    with sync_playwright() as playwright:
        one = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield one
        one.close()


@pytest.fixture(scope="session")
def visit(browser, address):
    """Give a function that opens a page: by http, or from its file."""

    def open_page(name, *, query="", local=False, **options):
        start = f"{HTML.as_uri()}/" if local else address
        return visiting(browser, name, f"{start}{name}.html{query}", **options)

    return open_page


@pytest.fixture(scope="session")
def look_at(browser, address):
    """Give a function that opens one page after another in the same window.

    For tests that only look: what a page has loaded, the next need not load again.
    """
    context = browser.new_context(viewport=WIDE, reduced_motion="reduce")
    one = Visit("", new_page(context))
    listen(one)

    def open_page(name):
        one.name = name
        one.said.clear()
        one.asked.clear()
        load(one, f"{address}{name}.html")
        typeset(one)
        return one

    yield open_page
    context.close()


def switch_theme(page, wanted):
    """Press the theme's button until it has reached a mode.

    By script: a pointer that rests on the button would open its tooltip.
    """
    mode = "document.documentElement.dataset.mode"
    for _ in range(3):
        if page.evaluate(mode) == wanted:
            return
        button = page.locator("button.theme-switch-button:visible").first
        button.evaluate("button => button.click()")
    assert page.evaluate(mode) == wanted, f"three presses do not lead to {wanted}"
