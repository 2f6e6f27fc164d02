"""Trees of boxes about the undeformed features of surfaces: which of them a node is near, at a cost of log n.

Built once by splitting at the median of the longest side, four features a leaf. Boxes are laid out in the order in
which they are visited: behind a box that is missed, the search goes on at ``skip``. Source: Ericson, Real-Time
Collision Detection (2005), 6.6.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["FeatureTree", "tree_of"]

LEAF = 4  # features


class FeatureTree(NamedTuple):
    """Boxes in the order of the search, counted from 0."""

    box: FloatArray  # (boxes, 6) lower and upper corner [m]
    skip: IntArray  # (boxes,) the box behind all that are inside of it
    leaf: IntArray  # (boxes, 2) its features, as a range of ``order``; empty of inner boxes
    order: IntArray  # (features,)


def tree_of(lower: FloatArray, upper: FloatArray) -> FeatureTree:
    """Of features with the boxes ``lower`` (k, 3) to ``upper`` (k, 3)."""
    box: list[FloatArray] = []
    skip: list[int] = []
    leaf: list[tuple[int, int]] = []
    order: list[int] = []
    finite = np.isfinite(lower) & np.isfinite(upper)
    middle = 0.5 * (np.where(finite, lower, 0.0) + np.where(finite, upper, 0.0))

    def split(members: IntArray) -> None:
        at = len(box)
        box.append(np.concatenate([lower[members].min(axis=0), upper[members].max(axis=0)]))
        skip.append(0)
        leaf.append((0, 0))
        if len(members) <= LEAF:
            leaf[at] = (len(order), len(order) + len(members))
            order.extend(int(m) for m in np.sort(members))
        else:
            axis = int(np.argmax(np.ptp(middle[members], axis=0)))
            ranked = members[np.argsort(middle[members, axis], kind="stable")]
            split(ranked[: len(ranked) // 2])
            split(ranked[len(ranked) // 2 :])
        skip[at] = len(box)

    if len(lower):
        split(np.arange(len(lower)))
    ints = np.int64
    return FeatureTree(
        np.array(box).reshape(-1, 6),
        np.array(skip, dtype=ints),
        np.array(leaf, dtype=ints).reshape(-1, 2),
        np.array(order, dtype=ints),
    )
