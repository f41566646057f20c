"""The paper's claims -> verdicts."""

from typing import TYPE_CHECKING

from press._lazy import face

if TYPE_CHECKING:
    from msc.claims._file import load_claims
    from msc.claims._judge import (
        CLAIMS,
        VERDICTS,
        judge_all,
        show_claims,
        summarise,
    )
    from msc.claims._page import (
        tally,
        with_summary,
        write_claims,
    )

__all__, __getattr__, __dir__ = face(__name__, __file__)
