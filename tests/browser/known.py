"""What axe-core finds in every page of the theme, and we cannot mend.

Each entry: the rule, what the element's selector or its HTML contains, the reason.
Whatever else is found fails.
"""

KNOWN = [
    (
        "region",
        ".sidebar-primary-item",
        "the theme sets the book's title beside its landmarks, not into one",
    ),
    (
        "aria-deprecated-role",
        'role="doc-biblioentry"',
        "docutils gives an entry of the bibliography a role that ARIA has given up",
    ),
    (
        "aria-allowed-role",
        'role="doc-biblioentry"',
        "the same role: it was meant for items of lists, docutils writes no list",
    ),
    (
        "aria-required-children",
        ".citation-list",
        "the list of these entries: docutils calls it a list, its entries no items",
    ),
]


def is_known(rule, selector, html):
    """Tell whether a finding is the theme's own."""
    return any(
        rule == one and (part in selector or part in html) for one, part, _ in KNOWN
    )
