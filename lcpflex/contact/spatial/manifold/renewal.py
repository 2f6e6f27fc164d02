"""Weights of the corners of patches whose entries are kept, while the bodies slide on each other."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.manifold.weights import lay_weights
from lcpflex.contact.spatial.pairs import contact_point
from lcpflex.contact.spatial.table import EDGE_EDGE, EDGE_FACET, RIM_FACET, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.vectors import apart_from, dot, row_vector
from lcpflex.model.spatial import SpatialModel

__all__ = ["renew_weights"]

THIN = 1e-9  # of the square of the patch: an area that is less stands for rounding


@kernel
def of_patch(table: SpatialContactTable, k: int) -> bool:
    """Whether entry k may be of a corner of a patch."""
    return bool(table.facing[k] == -math.inf or table.kind[k] in (EDGE_FACET, EDGE_EDGE, RIM_FACET))


@kernel
def same_pair(table: SpatialContactTable, k: int, m: int) -> bool:
    """Whether entries k and m are of the same declared contact and bodies, in either order."""
    a, b = table.body[k, 0], table.body[k, 1]
    c, d = table.body[m, 0], table.body[m, 1]
    return bool(table.law[k] == table.law[m] and ((a == c and b == d) or (a == d and b == c)))


@kernel
def renew_weights(model: SpatialModel, q: FloatArray, n: int, table: SpatialContactTable) -> None:
    """Weights of the first n entries by their present places; corners of a patch are one behind the other, in order."""
    first = 0
    while first < n:
        last = first + 1
        while last < n and of_patch(table, last) and same_pair(table, first, last):
            last += 1
        m = last - first
        if m > 2 and of_patch(table, first) and m <= table.patch.shape[1]:
            at, size = table.patch[0], 0.0
            for k in range(m):
                place = contact_point(model, q, table, first + k)
                for v in range(3):
                    at[k, v] = place[v]
                way = apart_from(place, row_vector(at, 0))
                size = max(size, dot(way, way))
            lay_weights(at, m, row_vector(table.normal, first), THIN * size)
            for k in range(m):
                table.weight[first + k] = at[k, 3]
        first = last
