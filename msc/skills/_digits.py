"""Columns of numbers -> lines of a file, many at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Cells = NDArray[np.uint32]

_MOST = 9  # digits that are written at once: of longer numbers products are not exact
_SHORT = {"%d": _MOST, "%.3g": 3, "%.9g": _MOST, "%.15g": _MOST}  # digits by format
_WORDS = 7  # of four bytes, that a number takes: 9 digits, the point, 12 more
_DOUBT = 1e-6  # of a last digit: closer to its half, rounding may go either way
_POWERS = 10.0 ** np.arange(-4, _MOST + 1)  # the least that is written without exponent
_TENS = 10 ** np.arange(2 * _MOST)
_LEAST = -4
_COMMA, _LINE, _POINT, _MINUS = np.array([*b",\n.-"], dtype="<u4")  # and three zeros


def _fours(blank: str, keep: str = "") -> list[bytes]:
    """Write 0000 to 9999, without zeros before or after."""
    words = [f"{number:04d}" for number in range(10_000)]
    if blank == "before":
        words = [(word.lstrip("0") or keep).rjust(4, "\0") for word in words]
    if blank == "after":
        words = [word.rstrip("0").ljust(4, "\0") for word in words]
    return [word.encode() for word in words]


# All four digits; without zeros before, or after; and the same, but for the last one.
_TABLE = np.frombuffer(
    b"".join(
        [*_fours(""), *_fours("before"), *_fours("after"), *_fours("before", "0")]
    ),
    "<u4",
)
_ALL, _BEFORE, _AFTER, _ONE = 0, 10_000, 20_000, 30_000


def format_lines(numbers: Array, formats: Sequence[str]) -> list[str]:
    """Write a line a row, as the formats of % do, with commas between.

    An empty format takes no number, and leaves its cell blank.

    >>> format_lines(np.array([[0.5, -1 / 3], [12.0, 1e-7]]), ["%.3g", "", "%.9g"])
    ['0.5,,-0.333333333', '12,,1e-07']
    """
    columns, parts = iter(numbers.T), []
    for form in formats:
        if form:
            parts.append(_write(np.ascontiguousarray(next(columns)), form))
        parts.append(np.full((len(numbers), 1), _COMMA))
    parts[-1][:] = _LINE
    return np.hstack(parts).tobytes().translate(None, b"\0 ").decode().splitlines()


def _write(numbers: Array, form: str) -> Cells:
    """Write a column: by its digits, or what these do not say for certain by %."""
    digits = _SHORT.get(form, 0)
    sizes, is_below = np.abs(numbers), np.signbit(numbers)
    if form == "%d":
        is_below = numbers <= -1  # there is no -0
    exponents = np.searchsorted(_POWERS, sizes, side="right") + _LEAST - 1
    is_sure = (exponents >= _LEAST) & (exponents < digits)
    exponents = np.where(is_sure, exponents, 0)
    after = np.maximum(digits - 1 - exponents, 0)  # digits after the point
    power = _TENS[after]
    scaled = np.where(is_sure, sizes, 0.0) * power
    whole = np.rint(scaled)
    is_sure &= np.abs(scaled - np.floor(scaled) - 0.5) > _DOUBT
    is_sure &= whole < 10.0**digits
    if form in ("%.15g", "%d"):  # of which no digit may be lost
        is_sure &= whole / power == sizes
    is_sure |= sizes == 0
    left, right = np.divmod(whole.astype(np.int64), power)
    high, low = np.divmod(left, 10_000)
    top, high = np.divmod(high, 10_000)
    right *= _TENS[12 - after]
    first, last = np.divmod(right, 10_000)
    first, middle = np.divmod(first, 10_000)
    cells = np.empty((len(numbers), _WORDS), dtype=np.uint32)
    cells[:, 0] = _TABLE[_BEFORE + top]
    cells[:, 0] |= np.where(is_below, _MINUS, 0)
    cells[:, 1] = _TABLE[np.where(top > 0, _ALL, _BEFORE) + high]
    cells[:, 2] = _TABLE[np.where(left >= 10_000, _ALL, _ONE) + low]
    cells[:, 3] = np.where(right > 0, _POINT, 0)
    cells[:, 4] = _TABLE[np.where(right % 100_000_000 > 0, _ALL, _AFTER) + first]
    cells[:, 5] = _TABLE[np.where(last > 0, _ALL, _AFTER) + middle]
    cells[:, 6] = _TABLE[_AFTER + last]
    others = numbers[~is_sure].tolist()
    words = (form.replace("%", f"%-{4 * _WORDS}") * len(others)) % tuple(others)
    cells[~is_sure] = np.frombuffer(words.encode(), "<u4").reshape(-1, _WORDS)
    return cells
