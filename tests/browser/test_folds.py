"""What is folded: closed at first, opened by a link that leads to it or into it."""

import pytest


def opened(page, folds):
    return page.locator(folds).evaluate_all("all => all.filter(one => one.open).length")


def test_claims_are_folded_until_one_is_linked_to(visit):
    with visit("claims") as seen:
        page, folds = seen.page, "#the-readings details"
        assert page.locator(folds).count() >= 20
        assert opened(page, folds) == 0
        page.evaluate("location.hash = 'claim-exec-free'")
        page.wait_for_function("document.getElementById('claim-exec-free').open")
        assert opened(page, folds) == 1
        page.locator(f"{folds} summary").first.click()
        assert opened(page, folds) == 2


@pytest.mark.parametrize("anchor", ["msc.SMCE", "msc.SMCE.fit"])
def test_a_link_to_a_name_of_the_package_opens_it(visit, anchor):
    with visit("api_learn") as seen:
        page, folds = seen.page, ".msc-fold"
        assert opened(page, folds) == 0
        page.evaluate(f"location.hash = '{anchor}'")
        page.wait_for_function("document.querySelector('.msc-fold[open]')")
        assert opened(page, folds) == 1
        assert page.locator(f"[id='{anchor}']").is_visible()
