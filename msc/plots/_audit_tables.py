"""What audits found, as tables of a chapter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from msc.search import LOWER


def quality_table(*audits: dict[str, Any]) -> pd.DataFrame:
    """Put the outcome of audits beside one another.

    Parameters
    ----------
    *audits : dict
        What `audit_table` returned.

    Returns
    -------
    DataFrame
        One column an audit.
    """
    columns = {}
    for audit in audits:
        executed, searched = audit["executed"], audit["searched"]
        changes = np.array(searched["change_of_cost"])
        found = {
            "policies": audit["n_tasks"],
            "executed again: identical distances": executed["identical"],
            "largest difference (m)": executed["largest_difference_m"],
            "searched again": len(changes),
            "cheaper by more than 0.5 %": searched["n_cheaper"],
            "largest gain (%)": round(100 * max(0.0, -changes.min()), 4),
            "not found again (dearer by more than 0.5 %)": int((changes > LOWER).sum()),
            "large steps, the cut's included": len(audit["jumps"]),
            "of these jumps": sum(jump["is_jump"] for jump in audit["jumps"]),
        }
        columns[audit["table"]] = pd.Series(found, dtype=object)
    return pd.DataFrame(columns)


def jump_table(audit: dict[str, Any]) -> pd.DataFrame:
    """List the large steps that an audit bisected.

    Parameters
    ----------
    audit : dict
        What `audit_table` returned.

    Returns
    -------
    DataFrame
        One row a step: where (degrees), how large at first and at last, the verdict.
    """
    return pd.DataFrame(
        [
            {
                "after (degrees)": jump["between_deg"][0],
                "located between (degrees)": "{:.10g} and {:.10g}".format(
                    *jump["located_deg"]
                ),
                "step": jump["step_sizes"][0],
                "step there": jump["step_sizes"][-1],
                "jump": jump["is_jump"],
            }
            for jump in audit["jumps"]
        ]
    )


def confirmed_jumps(audit: dict[str, Any]) -> list[int]:
    """Return where bisection confirmed a jump, that at the cut not counted.

    Parameters
    ----------
    audit : dict
        What `audit_table` returned, of a table whose tasks begin at 0°.

    Returns
    -------
    list of int
        Indices i of tasks for which the step to the next is a jump.

    Examples
    --------
    >>> steps = [([14.0, 15.0], True), ([93.0, 94.0], False), ([359.0, 360.0], True)]
    >>> jumps = [{"between_deg": at, "is_jump": found} for at, found in steps]
    >>> confirmed_jumps({"n_tasks": 360, "jumps": jumps})
    [14]
    """
    return [
        round(jump["between_deg"][0] * audit["n_tasks"] / 360)
        for jump in audit["jumps"]
        if jump["is_jump"] and jump["between_deg"][1] < 360
    ]
