"""The number of charts: what "the elbow" may mean, and the rules that find one.

The paper reads the number of charts from an elbow and does not say of which curve.
These are the criteria that can be defended, each a curve over the number of charts and
a rule that picks one. The default, in `SMCE`, is "squares".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

SELECTION_CRITERIA = {
    "rows_of_m": "rows of M, k-means",
    "squares": "squares within charts, chord",
    "squares_knee": "squares within charts, knee",
    "eigengap": "eigengap",
    "cross_validation": "cross-validated error",
}
"""The criteria and what they are called, those nearest the paper's words first."""


def elbow(curve: NDArray[np.float64]) -> int:
    """Find the elbow of a falling curve: the entry furthest below its chord.

    Rescaling an axis cannot change it.

    Parameters
    ----------
    curve : ndarray of shape (n_counts,)
        A value for each count 1, 2, …

    Returns
    -------
    int
        The count at the elbow.

    Examples
    --------
    >>> elbow(np.array([9.0, 4.0, 1.0, 0.9, 0.8]))
    3
    """
    chord = np.linspace(curve[0], curve[-1], len(curve))
    return int(np.argmax(chord - curve)) + 1


def knee(curve: ArrayLike) -> int:
    """Find the first knee of a falling curve that stands out.

    Both axes are scaled to [0, 1]. A knee is a local maximum of the distance below the
    chord, if that falls by more than one step along the first axis (a sensitivity of 1)
    before it rises again: V. Satopää, J. Albrecht, D. Irwin and B. Raghavan, "Finding a
    'Kneedle' in a Haystack", ICDCS Workshops 2011. `elbow` takes the greatest instead.

    Parameters
    ----------
    curve : array_like of shape (n_counts,)
        A value for each count 1, 2, …

    Returns
    -------
    int
        The count at the knee; 1 if none stands out.

    Examples
    --------
    >>> knee([9.0, 4.0, 1.0, 0.9, 0.8])
    3
    """
    values = np.asarray(curve, dtype=float)
    if len(values) < 3 or np.ptp(values) == 0:
        return 1
    heights = (values.max() - values) / np.ptp(values)
    below = heights - np.linspace(0, 1, len(values))
    place, threshold = 0, -np.inf
    for i in range(1, len(below) - 1):
        if below[i] >= max(below[i - 1], below[i + 1]) and below[i] > 0:
            place, threshold = i, below[i] - 1 / (len(below) - 1)
        elif below[i] <= min(below[i - 1], below[i + 1]):
            threshold = -np.inf
        if below[i + 1] < threshold:
            return place + 1
    return 1
