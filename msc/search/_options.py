"""What a search may be told: how wide, how long, how near is near."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from numbers import Real
from typing import Any


@dataclass(frozen=True)
class SearchOptions:
    """How a search goes about its work.

    The tables of this book were made with the defaults. Lengths in policies are shares
    of a policy's norm, or of the spring constant where there is no policy yet.

    Parameters
    ----------
    first_step : float, default=0.5
        CMA-ES's first standard deviation from an independent start, and that of the
        random starts around zero, in spring constants. So wide that starts find
        different ways to move, and one of them the cheapest.
    small_step : float, default=0.006
        The first standard deviation from a given policy, in spring constants. A
        neighbour's policy is nearly right: a wide step would leave its way to move.
    population : int, default=9
        Policies a generation: CMA-ES's own rule, 4 + 3 ln n, for six weights.
    agreement : float, default=0.85
        Rank correlation (Kendall's) with which a surrogate is believed: it then gives
        the costs of a generation's policies that were not executed. Above 1 it never
        is, and all are executed: plain CMA-ES. The default is that of lq-CMA-ES.
    tolerance : float, default=1e-6
        A run ends once the costs of its generations differ by less.
    max_evaluations : int, default=4000
        A run ends with the generation whose rollouts exceed this; converged runs take
        50 to 500.
    patience : float, default=5
        A run is given up if, at the pace of its last `stalled` generations, it would
        not be as cheap as the cheapest known one after so many times as many: it is on
        the way to a dearer way to move, or nowhere.
    stalled : int, default=20
        Generations that a run may go on without gaining.
    gain : float, default=1e-5
        Share of the best cost that these must gain; less is below what the comparison
        of two ways to move needs.
    near : float, default=0.05
        A run narrower than this share of a known policy's norm, and nearer to it, and
        not cheaper, is on the way there: it is stopped.
    same : float, default=0.01
        A run that ends nearer than this share to the best policy has found it too, and
        neighbours are told of one that is farther from what they knew.
    apart : float, default=0
        In a consistency pass a neighbour's policy is a start if it is farther than this
        share of the task's own, and then once: a nearer one is the same way to move.
        At 0 all are, whenever one of them has changed.
    coarse_deg : float, default=10.0
        Degrees between the tasks that are searched first, without a neighbour's policy:
        far fewer than tasks, and dense enough that each way to move is met.
    max_sweeps : int, default=24
        Sweeps of a consistency pass, at most; it has always come to rest earlier.

    Raises
    ------
    ValueError
        If a value is no number as wanted.

    Examples
    --------
    >>> SearchOptions(max_evaluations=90).changed
    ('max_evaluations=90',)
    """

    first_step: float = 0.5
    small_step: float = 0.006
    population: int = 9
    agreement: float = 0.85
    tolerance: float = 1e-6
    max_evaluations: int = 4000
    patience: float = 5.0
    stalled: int = 20
    gain: float = 1e-5
    near: float = 0.05
    same: float = 0.01
    apart: float = 0.0
    coarse_deg: float = 10.0
    max_sweeps: int = 24

    def __post_init__(self) -> None:
        """Check all values, and make numbers of other kinds Python's own."""
        for field in fields(self):
            value: Any = getattr(self, field.name)
            kind: type[float] = float if isinstance(field.default, float) else int
            if field.name == "apart":
                least, wanted = 0.0, "a finite number, at least 0"
            elif kind is float:
                least, wanted = 5e-324, "a finite number above 0"
            else:
                least = {"population": 2, "max_sweeps": 0}.get(field.name, 1)
                wanted = f"a whole number, at least {least}"
            is_number = isinstance(value, Real)
            if not (is_number and least <= value < math.inf and kind(value) == value):
                raise ValueError(f"{field.name}={value!r}; wanted {wanted}")
            object.__setattr__(self, field.name, kind(value))

    @property
    def changed(self) -> tuple[str, ...]:
        """Options that differ from the defaults, each as ``"name=value"``."""
        usual = asdict(SearchOptions())
        changed = {k: v for k, v in asdict(self).items() if v != usual[k]}
        return tuple(f"{name}={value!r}" for name, value in changed.items())

    @classmethod
    def parse(cls, texts: Iterable[str]) -> SearchOptions:
        """Read options as a command line has them.

        Parameters
        ----------
        texts : iterable of str
            Each ``"name=value"``.

        Returns
        -------
        SearchOptions
            These, and defaults for the others.

        Raises
        ------
        ValueError
            If a name is unknown or a value is no number as wanted.

        Examples
        --------
        >>> SearchOptions.parse(["near=0.1"]).near
        0.1
        """
        known = [field.name for field in fields(cls)]
        values: dict[str, float] = {}
        for text in texts:
            name, _, value = text.partition("=")
            if name not in known:
                raise ValueError(
                    f"{text!r} sets nothing known; wanted NAME=VALUE with a name of "
                    f"{', '.join(known)}"
                )
            try:
                values[name] = float(value)
            except ValueError:
                raise ValueError(f"{name}={value!r}; wanted a number") from None
        return cls(**values)  # type: ignore[arg-type]
