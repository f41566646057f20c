"""The paper's claims -> verdicts.

A *claim* is a sentence of the paper and has one or several *interpretations* (the book
calls them readings). Each names a *quantity* in a result file, as "ratio" or "jumps",
and one predicate that the number, with its whole interval, must fulfil;
`book/claims.yml` holds them all. What an interpretation came to is a *finding*, and the
findings make a *verdict*: reproduced, partly, not reproduced, undecided, by
construction, or cannot be tested.

- `load_claims`: the file, checked
- `judge_all`: every verdict, whoever asks; `show_claims` shows some in a chapter
- `count_elsewhere`, `elsewhere_values`, `write_counts`, `OVER_WORLDS`: what the worlds
  of `msc.worlds` answer to it
- `headline_values`, `STUDIES`: the numbers that the book's first page quotes
- `summarise`, `tally`, `claim_fragments`, `with_summary`: verdicts as data and as pages
"""

from typing import TYPE_CHECKING

from press import face

if TYPE_CHECKING:
    from msc.claims._claims import load_claims
    from msc.claims._elsewhere import (
        OVER_WORLDS,
        count_elsewhere,
        elsewhere_values,
        write_counts,
    )
    from msc.claims._headline import STUDIES, headline_values
    from msc.claims._judge import (
        CLAIMS,
        VERDICTS,
        judge_all,
        show_claims,
        summarise,
    )
    from msc.claims._page import (
        claim_fragments,
        tally,
        with_summary,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
