"""Which contacts in space a time stepper takes for closed: those of flush faces together."""

from __future__ import annotations

from lcpflex.contact.spatial.detection import detect
from lcpflex.contact.spatial.kinds import POLYGON
from lcpflex.contact.spatial.narrow_phase.margins import surface_of
from lcpflex.contact.spatial.pairs import contact_point
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    EDGE_RIM,
    NODE_CAP,
    NODE_FACET,
    SpatialContactTable,
    copy_entry,
)
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import cross
from lcpflex.kinematics.spatial.vectors import apart_from, dot, norm, row_vector
from lcpflex.model.spatial import SpatialModel

__all__ = ["find_closed"]

FLUSH = 1e3  # tolerances: 1e-6 of the length, which a turn of a few 1e-8 rad makes, as of a float32
ALIGNED = 1.0 - 5e-7  # cosine of 1e-3 rad: of the normals at corners of flush faces, which may be turned by more
SLIGHT = 1e-3  # of the body's extent: what is deeper is no drift, but an impact
NEAR = 10.0  # depths over the sine between normals: as far from the side is a vertex that is found by drift, and more


@kernel
def is_flat(table: SpatialContactTable, k: int) -> bool:
    """Whether entry k is one over a flat face, which has others beside it."""
    return table.kind[k] in (NODE_FACET, NODE_CAP, EDGE_FACET, EDGE_CAP)


@kernel
def closes_with(table: SpatialContactTable, k: int, first: int, last: int, tolerance: float) -> bool:
    """Whether one of the entries first..last is of the same two faces as entry k, with its normal, and closed."""
    found = False
    n = row_vector(table.normal, k)
    for i in range(first, last):
        same = is_flat(table, i) and table.law[i] == table.law[k]
        if same and table.gap[i] <= tolerance:  # normals of the two sides lead against each other
            found = found or abs(dot(row_vector(table.normal, i), n)) >= ALIGNED
    return found


@kernel
def is_leaving(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int, count: int, tolerance: float
) -> bool:
    """Whether entry k is that of a vertex about to leave a face over a side, where an edge as deep crosses that.

    Of two convex bodies no vertex is on a face, and an edge with another normal on its side, but where both meet. Both
    are a little inside, by what steps leave: else the vertex would be above the face until it is beyond.
    """
    c = model.contacts
    if table.kind[k] != NODE_FACET or len(c.polygon_feature) == 0:  # no convex bodies, or functions of a user's
        return False
    if c.feature_kind[table.key[k] % len(c.feature_kind)] != POLYGON:
        return False
    extent = c.surface_extent[surface_of(c.node_start, table.key[k] // len(c.feature_kind))]
    n = row_vector(table.normal, k)
    for i in range(count):
        kind, depth = table.kind[i], max(-table.gap[i], 0.0) + tolerance
        crosses = kind in (EDGE_FACET, EDGE_EDGE, EDGE_RIM)
        if table.law[i] != table.law[k] or not crosses or table.gap[i] > min(table.gap[k], 0.0) + tolerance:
            continue
        sine = norm(cross(row_vector(table.normal, i), n))
        if depth > SLIGHT * extent or abs(dot(row_vector(table.normal, i), n)) >= ALIGNED:
            continue
        away = apart_from(contact_point(model, q, table, i), contact_point(model, q, table, k))
        if norm(away) * sine <= NEAR * depth:
            return True
    return False


@kernel
def find_closed(model: SpatialModel, q: FloatArray, tolerance: float, table: SpatialContactTable) -> int:
    """Contacts with gap <= tolerance [m], and those of the same pairs that are hardly wider; how many, as ``detect``.

    A face that is turned by 1e-8 rad against another one stands on one corner. If the others were open in a step, the
    body would tip about that by what a step takes, a thousand times as far as it is open. Where a tilted face slides
    over an edge its corners are as near as that just before they leave over it: they strike nothing.
    """
    table.faces.kept.used = 1
    n = detect(model, q, FLUSH * tolerance, table)
    if n > len(table.key):
        return n
    m = 0
    for k in range(n):
        kept = table.gap[k] <= tolerance
        if not kept and is_flat(table, k):
            kept = closes_with(table, k, 0, m, tolerance) or closes_with(table, k, k + 1, n, tolerance)
        if kept and not is_leaving(model, q, table, k, n, tolerance):
            if m != k:
                copy_entry(table, k, table, m)
            m += 1
    return m
