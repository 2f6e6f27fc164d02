"""What touches between two meshes, of which one at least deforms or need not be convex: see :mod:`~.mesh_pairs`.

Nodes of both are looked at, then edges; but of the coarser one of two that deform, those nodes alone where sharp edges
end. What comes twice is told by the first of these. That must not depend on how near contacts are asked for: all are
found to a band above the margin, and those above it go at the end.
"""

from __future__ import annotations

import math

from lcpflex.bodies.spatial.surface import CORNERS, TWO_SIDED
from lcpflex.contact.spatial.crossing_pass import crossings_of_meshes
from lcpflex.contact.spatial.levers import mean_on_i
from lcpflex.contact.spatial.mesh_pairs import band_between, deforms
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.contact.spatial.narrow_phase.sides import frame_of, mean_place, world_place
from lcpflex.contact.spatial.node_pass import nodes_on_features
from lcpflex.contact.spatial.table import SpatialContactTable, copy_entry
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import apart_from, dot, row_vector, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["meshes_touch"]

DOUBLE = 2.0  # bands along the plane of contact: what is nearer is one contact; two would bend a body between them
ALIKE = math.cos(TILT)


@kernel
def place_on_i(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> Vector:
    """Where entry k touches body i, but for its radius [m]."""
    frame = frame_of(model.bodies, q, table.body[k, 0])
    return world_place(frame, mean_place(model.points, q, frame, mean_on_i(table, k)))


@kernel
def drop_doubles(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, before: int, first: int, n: int, near: float
) -> int:
    """Drop the entries first..n that are at most ``near`` beside one of before..first; returns the new count."""
    if n > len(table.key):
        return n
    m = first
    for k in range(first, n):
        place = place_on_i(model, q, table, k)
        normal = row_vector(table.normal, k)
        known = False
        for i in range(before, first):
            cosine = dot(normal, row_vector(table.normal, i))
            if table.body[i, 0] != table.body[k, 0]:
                cosine = -cosine
            if cosine < ALIKE:
                continue
            d = apart_from(place_on_i(model, q, table, i), place)
            d = apart_from(d, scaled(dot(d, normal), normal))
            if dot(d, d) <= near * near:
                known = True
                break
        if not known:
            if m != k:
                copy_entry(table, k, table, m)
            m += 1
    return m


@kernel
def keep_near(table: SpatialContactTable, first: int, n: int, margin: float) -> int:
    """Of the entries first..n, keep those with gap <= margin; returns the new count."""
    if n > len(table.key):
        return n
    m = first
    for k in range(first, n):
        if table.gap[k] <= margin:
            if m != k:
                copy_entry(table, k, table, m)
            m += 1
    return m


@kernel
def meshes_touch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts between two meshes, from entry n on; the new count. Of rigid ones, a is the first node side."""
    c = model.contacts
    band = band_between(model, a, b)
    wide = margin + band
    back = TWO_SIDED
    if deforms(model, a) or deforms(model, b):
        back = CORNERS
        if c.node_start[a + 1] - c.node_start[a] < c.node_start[b + 1] - c.node_start[b]:
            a, b = b, a
    first = n
    n = nodes_on_features(model, q, wide, table, a, b, law, TWO_SIDED, n)
    start = n
    n = nodes_on_features(model, q, wide, table, b, a, law, back, n)
    n = drop_doubles(model, q, table, first, start, n, DOUBLE * band)
    start = n
    n = crossings_of_meshes(model, q, wide, table, a, b, law, n)
    n = drop_doubles(model, q, table, first, start, n, DOUBLE * band)
    return keep_near(table, first, n, margin)
