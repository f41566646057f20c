"""What a chapter says it observes, checked where it says so.

With the chapter's own parameters a claim that does not hold stops the build of the
book. With others, which a reader is free to choose, it is told in words.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from press._notebook import Notebook, code_cells

WORDS = "With these parameters it does not hold that"


@dataclass(frozen=True)
class Unmet:
    """Claims that do not hold, as a chapter shows them.

    Attributes
    ----------
    claims : tuple of str
        Each a clause after "that".
    """

    claims: tuple[str, ...]

    def __repr__(self) -> str:
        """Write them down, one a line."""
        return "\n- ".join((WORDS, *self.claims))


def expect(claims: Mapping[str, bool]) -> Unmet | None:
    """Check what a chapter says.

    Parameters
    ----------
    claims : mapping from str to bool
        Whether each holds. It is a clause after "it does not hold that".

    Returns
    -------
    Unmet or None
        Those that do not hold, which a cell shows in words; None, which it does not
        show, if all do.

    Examples
    --------
    >>> expect({"two is even": True})
    >>> expect({"two is even": True, "three is even": False})
    With these parameters it does not hold that
    - three is even
    """
    failed = tuple(claim for claim, holds in claims.items() if not holds)
    return Unmet(failed) if failed else None


def unmet(run: Notebook) -> str:
    """Name the first cell of a run whose claims do not hold.

    Parameters
    ----------
    run : dict
        A chapter with its outputs.

    Returns
    -------
    str
        The cell's number among the code cells, and the claims; empty if all hold.
    """
    for number, cell in enumerate(code_cells(run), start=1):
        for output in cell["outputs"]:
            words = "".join(output.get("data", {}).get("text/plain", ""))
            if words.startswith(WORDS):
                return f"code cell {number}: {' '.join(words.split())}"
    return ""
