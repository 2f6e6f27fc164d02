"""Of two surfaces that are node sides of each other: nodes that meet nodes are one contact."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.table import SpatialContactTable, copy_entry
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import point_place
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector
from lcpflex.model.spatial import SpatialModel

__all__ = ["drop_twice"]

MEETING = 1e-6  # of the extent of the smaller surface: nodes that are so near each other meet


@kernel
def drop_twice(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, a: int, b: int, before: int, first: int, n: int
) -> int:
    """Drop the entries first..n that are among before..first already; returns the new count.

    Those have the nodes of surface b, these the nodes of a; the same place, and opposite normals.
    """
    extent = model.contacts.surface_extent
    near = MEETING * min(extent[a], extent[b])
    if not near < math.inf:
        return n
    m = first
    for k in range(first, n):
        place = point_place(model.bodies, model.points, q, table.node[k])
        normal = row_vector(table.normal, k)
        known = False
        for i in range(before, first):
            if norm(added(normal, row_vector(table.normal, i))) > MEETING:
                continue
            d = apart_from(point_place(model.bodies, model.points, q, table.node[i]), place)
            if dot(d, d) <= near * near:
                known = True
                break
        if not known:
            if m != k:
                copy_entry(table, k, table, m)
            m += 1
    return m
