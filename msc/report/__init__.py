"""A fit -> one page for a person who looks before they read.

The page is a file of HTML that needs no other: pictures, style and slider are inside.
Every number in its sentences is computed from the fit's *card*; whatever comes from the
table, as names of columns, is shown as text.

    ===================  ==========================================================
    `make_report`        the page
    ===================  ==========================================================
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.report._page import make_report

__all__, __getattr__, __dir__ = face(__name__, __file__)
