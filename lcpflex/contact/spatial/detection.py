"""Which surfaces of space are near each other, and what touches between them.

Bounding spheres come first, widened by the most that the present modal coordinates can move a point of either surface;
then what one surface has with the other (:mod:`lcpflex.contact.spatial.passes`).
"""

from __future__ import annotations

import numpy as np

from lcpflex.contact.spatial.bounds import bound, near_surfaces
from lcpflex.contact.spatial.passes import detect_pass
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.contact.table import ALL
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect"]


@kernel
def detect(model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable) -> int:
    """All contacts with gap <= margin [m] at q, in the order of passes, nodes and features.

    Returns how many there are, or at least as many if that exceeds the capacity: entries then mean nothing.
    """
    bound(model, q, table)
    c = model.contacts
    n = int(np.int64(0))  # a literal 0 would have the kernels below compiled once more, for it alone
    for w in range(len(c.pass_node)):
        law = c.pass_law[w]
        if table.collects != ALL and table.compliant[law] != table.collects:
            continue
        if near_surfaces(model, q, table, c.pass_node[w], c.pass_feature[w], margin):
            n = detect_pass(model, q, margin, table, c.pass_node[w], c.pass_feature[w], law, n)
    return n
