"""The Delassus operator of contacts in space by its blocks of two contacts."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics import libs

__all__ = ["ConeBlocks"]


class ConeBlocks:
    """Blocks of contact k: first[k] to first[k + 1], with contact other[e], entries block[e] (9,) by rows.

    own (n, 9): the block of each contact with itself, which is kept even if it is zero.
    """

    def __init__(self, matrix: Any) -> None:
        n = matrix.shape[0] // 3
        coupled = libs.sparse.bsr_array(libs.sparse.csr_array(matrix), blocksize=(3, 3))
        present = libs.sparse.csr_array(
            (np.ones(len(coupled.indices)), coupled.indices, coupled.indptr), shape=(n, n)
        )  # fmt: skip
        if not present.diagonal().all():  # a contact between two bodies that are held
            coupled = _with_diagonal(coupled, n)
        coupled.sort_indices()
        self.first, self.other = coupled.indptr.astype(np.int64), coupled.indices.astype(np.int64)
        self.block = np.ascontiguousarray(coupled.data.reshape(-1, 9))
        self.own = np.ascontiguousarray(self.block[self.other == np.repeat(np.arange(n), np.diff(self.first))])


def _with_diagonal(coupled: Any, n: int) -> Any:
    """The same blocks and those of each contact with itself, zero or not: a sum would leave zeros out."""
    rows = np.repeat(np.arange(n), np.diff(coupled.indptr))
    missing = np.setdiff1d(np.arange(n), rows[coupled.indices == rows])
    rows, others = np.concatenate([rows, missing]), np.concatenate([coupled.indices, missing])
    block = np.concatenate([coupled.data, np.zeros((len(missing), 3, 3))])
    order = np.lexsort([others, rows])
    first = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n))])
    return libs.sparse.bsr_array((block[order], others[order], first), shape=(3 * n, 3 * n))
