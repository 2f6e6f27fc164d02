"""Which stored instants of two runs are the same."""

from __future__ import annotations

import numpy as np

from tests.comparison.record import Array

__all__ = ["in_both"]

SAME = 1e-9  # instants as near as this are the same, as a share of the last time


def in_both(old: Array, new: Array) -> tuple[Array, Array]:
    """Indices of instants that both have stored, in order of time; those stored twice are met one by one.

    Schemes with fixed steps store the same instants. Schemes with error control do so on the grid of the record; what
    they store of events, which may be moved, counts where it was not.
    """
    if len(old) == len(new) and np.array_equal(old, new):
        every = np.arange(len(old))
        return every, every
    near = SAME * max(np.max(np.abs(old), initial=0.0), np.max(np.abs(new), initial=0.0))
    pairs: list[tuple[int, int]] = []
    i = j = 0
    while i < len(old) and j < len(new):
        if abs(old[i] - new[j]) <= near:
            pairs.append((i, j))
            i, j = i + 1, j + 1
        elif old[i] < new[j]:
            i += 1
        else:
            j += 1
    met = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return met[:, 0], met[:, 1]
