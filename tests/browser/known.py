"""What axe-core finds in every page of the theme, and we cannot mend.

Each entry: the rule, what the selector of the element contains, the reason. Whatever
else is found fails.
"""

KNOWN = [
    (
        "region",
        ".sidebar-primary-item",
        "the theme sets the book's title beside its landmarks, not into one",
    ),
]


def is_known(rule, selector):
    """Tell whether a finding is the theme's own."""
    return any(rule == one and part in selector for one, part, _ in KNOWN)
