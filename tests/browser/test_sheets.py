"""The sections of worlds: a link opens one, and on paper all are open."""

import pytest
from built import holding

PAGES = holding("msc-sheets")
OPEN = """() => Array.from(
  document.querySelectorAll(".msc-sheets details[open]")
).map(section => section.id)"""
ALL = """() => Array.from(document.querySelectorAll(".msc-sheets details")).map(
  section => section.id)"""


@pytest.mark.parametrize("name", PAGES)
def test_a_link_opens_its_section(visit, name):
    with visit(name) as one:
        first, *_, last = one.page.evaluate(ALL)
        assert not one.page.evaluate(OPEN)
    with visit(name, query=f"#{last}") as one:
        one.page.wait_for_function(f"({OPEN})().length")
        assert one.page.evaluate(OPEN) == [last]
        assert (
            one.page.locator(f"#{last}").evaluate("e => e.getBoundingClientRect().top")
            < 200
        )
        one.page.evaluate(f"location.hash = '{first}'")
        one.page.wait_for_function(f"({OPEN})().length === 2")
        assert one.page.evaluate(OPEN) == [first, last]


@pytest.mark.parametrize("name", PAGES[:1])
def test_on_paper_all_are_open(visit, name):
    with visit(name) as one:
        one.page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert one.page.evaluate(OPEN) == one.page.evaluate(ALL)
        one.page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert not one.page.evaluate(OPEN)
