"""Blocks of neighbouring tasks, which are left out together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sklearn.cluster import KMeans
from sklearn.decomposition import PCA

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

N_FOLDS = 5
"""Into which blocks are dealt."""

_BLOCK = 3  # different tasks in a block, if that makes at least the fewest blocks
_FEWEST, _MOST = 10, 500  # blocks
_SEEN = 10_000  # tasks among which cells are sought


@dataclass(frozen=True)
class Blocks:
    """Tasks in blocks, and blocks in folds.

    Attributes
    ----------
    of_row : ndarray of int of shape (n_rows,)
        Block of each row, numbered along the line, or the longest axis of tasks.
    folds : ndarray of int of shape (n_blocks,)
        Fold of each block: neighbours in that order are in different ones.
    """

    of_row: Indices
    folds: Indices

    def in_folds(self, *folds: int) -> NDArray[np.bool_]:
        """Tell which rows are in some folds."""
        return np.isin(self.folds, folds)[self.of_row]

    def average(self, values: Array) -> Array:
        """Average numbers, one a row, within each block."""
        return np.bincount(self.of_row, values) / self.sizes

    @property
    def n_folds(self) -> int:
        """Into how many folds blocks were dealt."""
        return int(self.folds.max()) + 1

    @property
    def sizes(self) -> Indices:
        """Rows in each block."""
        return np.bincount(self.of_row, minlength=len(self.folds))


def make_blocks(flat: Array, points: Array, copies: Indices, seed: int) -> Blocks:
    """Part tasks into blocks of neighbours, equal ones always together.

    Those of one number go in their order, three different ones a block; of several,
    into the cells of k-means, as many. There are 10 to 500 blocks.

    >>> line = np.arange(80.0)[:, None]
    >>> make_blocks(line, line, np.arange(80), seed=0).of_row[::10]
    array([ 0,  3,  6,  9, 13, 16, 19, 22])
    """
    _, first, place = np.unique(copies, return_index=True, return_inverse=True)
    n_different = len(first)
    n_blocks = int(np.clip(n_different // _BLOCK, min(_FEWEST, n_different), _MOST))
    if flat.shape[1] == 1:
        ranks = np.argsort(np.argsort(flat[first, 0], kind="stable"))
        labels = ranks * n_blocks // n_different
    else:
        rng = np.random.default_rng(seed)
        different = points[first]
        seen = rng.permutation(n_different)[:_SEEN]
        cells = KMeans(n_blocks, n_init=1, random_state=seed).fit(different[seen])
        found = cells.predict(different)
        along = PCA(1, svd_solver="full").fit(different)
        used = np.unique(found)
        order = np.argsort(along.transform(cells.cluster_centers_[used])[:, 0])
        number = np.empty(n_blocks, dtype=np.intp)
        number[used[order]] = np.arange(len(used))
        labels = number[found]
    n_blocks = int(labels.max()) + 1
    return Blocks(labels[place], np.arange(n_blocks) % min(N_FOLDS, n_blocks))
