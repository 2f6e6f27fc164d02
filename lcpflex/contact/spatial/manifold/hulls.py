"""The manifold of two convex polyhedra: which faces or edges touch, and an entry for each corner of the patch."""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.entries import load_crossing, load_edges, load_vertex
from lcpflex.contact.spatial.manifold.axes import (
    FaceAxis,
    Pose,
    back,
    beyond_edge,
    ends_of,
    incident_face,
    node_place,
    polygon_normal,
    ridges,
    seen,
    widest_face,
)
from lcpflex.contact.spatial.manifold.clip import CROSSING, INCIDENT, beyond_side, clip_face, next_side, side_of_polygon
from lcpflex.contact.spatial.manifold.weights import lay_weights
from lcpflex.contact.spatial.narrow_phase.edges import TILT, edges_cross
from lcpflex.contact.spatial.narrow_phase.sides import frame_of
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["APART", "polyhedra_touch"]

APART = -1  # instead of a count: no face and no two edges are nearest to each other, nothing touches

# of the size, the smaller body's diagonal
THIN = 2.5e-10  # sides are so thick: stands for rounding, and is less than what ends an entry
ONE = 1e-8  # corners so near each other are one: a face that leaves by its end has no other corner beside that
TIE = 1e-9  # by which the first body's face must be farther from the other to be the reference: not by rounding
ROUNDED = 1e-12  # by which places miss a plane that they are in
SHALLOW = 1e-6  # by which edges must be farther apart than faces, with a tenth of the depth: else the patch tells more
DROP = 1e-7  # by which an edge must fall below a face beyond its side, with its depth there, to hang on that side
WORSE = 0.1  # of the depth


class Patch(NamedTuple):
    """Two faces that touch: polygon p of the reference body, and g of the other, whose pose in its frame is given."""

    law: int
    p: int
    g: int
    pose: Pose
    second: bool  # whether the reference body is the second one, j of all crossings
    normal: Vector  # of p, in its frame
    thin: float  # [m]
    size: float  # [m]


@kernel
def along_j_to_i(patch: Patch) -> Vector:
    """The normal of the reference face from the second body to the first, in its frame."""
    return patch.normal if patch.second else scaled(-1.0, patch.normal)


@kernel
def across(n: Vector, d: Vector) -> float:
    """Square of the part of d that is not along n [m^2]."""
    part = apart_from(d, scaled(dot(n, d), n))
    return dot(part, part)


@kernel
def near_vertex(model: SpatialModel, patch: Patch, place: Vector) -> int:
    """The node of the reference face that a place of its frame is over, -1: none."""
    c = model.contacts
    for k in range(c.side_start[patch.p], c.side_start[patch.p + 1]):
        if across(patch.normal, apart_from(place, node_place(model, c.side_node[k]))) <= patch.thin * patch.thin:
            return c.side_node[k]
    return -1


@kernel
def seen_there(model: SpatialModel, patch: Patch, node: int) -> Vector:
    """A vertex of the other body in the frame of the reference body [m]."""
    return added(turned(patch.pose.A, node_place(model, node)), patch.pose.d)


@kernel
def near_end(model: SpatialModel, patch: Patch, side: int, place: Vector) -> int:
    """The node at an end of a side of the other face that a place is at, -1: none."""
    node = model.contacts.side_node
    for end in (side, next_side(model, patch.g, side)):
        if across(patch.normal, apart_from(place, seen_there(model, patch, node[end]))) <= patch.thin * patch.thin:
            return node[end]
    return -1


@kernel
def keep_entry(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, weight: float, first: int, n: int
) -> int:
    """Entry n with its weight, if it is near enough and none of first..n already; the new count."""
    for k in range(first, n):
        if table.key[k] == table.key[n]:
            table.weight[k] += weight
            return n
    table.weight[n] = weight
    locate(model, q, table, n)
    return n + 1 if table.gap[n] <= margin else n


@kernel
def hangs_on_side(model: SpatialModel, patch: Patch, mine: int, side: int, place: Vector) -> bool:
    """Whether side ``mine`` of the other face falls below the reference face beyond its ``side``, and touches that."""
    c = model.contacts
    start, out = side_of_polygon(model, side, next_side(model, patch.p, side), patch.normal)
    a = seen_there(model, patch, c.side_node[mine])
    b = seen_there(model, patch, c.side_node[next_side(model, patch.g, mine)])
    end = b if dot(out, apart_from(b, a)) > 0.0 else a
    depth = max(-dot(patch.normal, apart_from(place, start)), 0.0)
    if dot(patch.normal, apart_from(place, end)) <= depth + DROP * patch.size:
        return False
    e, f = apart_from(b, a), apart_from(node_place(model, c.side_node[next_side(model, patch.p, side)]), start)
    if not edges_cross(e, f):
        return False
    n = cross(e, f)
    square, y = dot(n, n), apart_from(start, a)  # their lines are nearest at these shares, maybe beyond their ends
    on_e, on_f = dot(cross(y, f), n) / square, dot(cross(y, e), n) / square
    if min(on_e, on_f) < 0.0 or max(on_e, on_f) > 1.0:
        return False
    n = scaled((1.0 if dot(n, patch.normal) > 0.0 else -1.0) / norm(n), n)
    over, beside = polygon_normal(model, c.side_beside[side]), turned(patch.pose.A, polygon_normal(model, patch.g))
    other = turned(patch.pose.A, polygon_normal(model, c.side_beside[mine]))
    return (
        leads_out(n, f, patch.normal, 1.0)
        and leads_out(n, f, over, -1.0)
        and leads_out(scaled(-1.0, n), e, beside, 1.0)
        and leads_out(scaled(-1.0, n), e, other, -1.0)
    )


@kernel
def leads_out(n: Vector, e: Vector, face: Vector, sense: float) -> bool:
    """Whether n leads out of a face beside an edge, or nearly; sense: +1 where the edge runs counter-clockwise."""
    return sense * dot(n, cross(e, face)) >= -TILT * norm(e)


@kernel
def load_corner(
    model: SpatialModel,
    table: SpatialContactTable,
    n: int,
    patch: Patch,
    place: Vector,
    made: int,
    mine: int,
    side: int,
) -> None:
    """Entry n, of a corner of the patch that was made by side ``mine`` of the other face and ``side`` of this one.

    The first body's vertex goes before the second one's where both meet, and a vertex before a crossing: so they have
    one key, whichever face is the reference.
    """
    c = model.contacts
    at = near_vertex(model, patch, place)
    end = near_end(model, patch, mine, place) if made == CROSSING else (c.side_node[mine] if made == INCIDENT else -1)
    if end >= 0 and (at < 0 or patch.second):
        load_vertex(model, table, n, patch.law, end, c.polygon_feature[patch.p])
    elif at >= 0:
        load_vertex(model, table, n, patch.law, at, c.polygon_feature[patch.g])
    elif made == CROSSING:
        of_other, of_this = c.side_edge[mine], c.side_edge[side]
        e, f = (of_other, of_this) if patch.second else (of_this, of_other)
        out = along_j_to_i(patch)
        _, line = ends_of(model, of_this)
        if hangs_on_side(model, patch, mine, side, place):
            _, other = ends_of(model, of_other)
            other = turned(patch.pose.A, other)
            n_ = cross(other, line) if patch.second else cross(line, other)
            load_edges(model, table, n, patch.law, e, f, 1.0 if dot(n_, out) > 0.0 else -1.0)
        else:
            start = row_vector(model.points.place, c.feature_point[of_this, 0])
            inward = apart_from(row_vector(model.points.place, c.side_across[side]), start)
            sense = 1.0 if dot(cross(line, inward), out) > 0.0 else -1.0
            load_crossing(model, table, n, patch.law, e, f, c.side_across[side], sense)
    else:  # two sides of this face meet here, to rounding, at a vertex that is farther away than that
        table.key[n] = -1


@kernel
def merge_corners(at: FloatArray, trace: IntArray, m: int, n: Vector, thin: float) -> int:
    """Of corners that lie on each other, keep one, vertices first; the new count."""
    count = 0
    for k in range(m):
        place = row_vector(at, k)
        known = -1
        if count > 0 and across(n, apart_from(place, row_vector(at, count - 1))) <= thin * thin:
            known = count - 1
        elif k == m - 1 and count > 1 and across(n, apart_from(place, row_vector(at, 0))) <= thin * thin:
            known = 0
        if known >= 0 and not (trace[k, 0] == INCIDENT and trace[known, 0] != INCIDENT):
            continue
        target = known if known >= 0 else count
        for v in range(3):
            at[target, v] = at[k, v]
            trace[target, v] = trace[k, v]
        count += 1 if known < 0 else 0
    return count


@kernel
def lay_patch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, patch: Patch, n: int
) -> int:
    """Entries of a patch, from entry n on; the new count."""
    m, now = clip_face(model, patch.p, patch.g, patch.pose, patch.thin, table.patch, table.trace)
    at, trace = table.patch[now], table.trace[now]
    m = merge_corners(at, trace, m, patch.normal, ONE * patch.size)
    lay_weights(at, m, patch.normal, patch.thin * patch.size)
    first = n
    for k in range(m):
        if n >= len(table.key):
            return n + m - k
        load_corner(model, table, n, patch, row_vector(at, k), trace[k, 0], trace[k, 1], trace[k, 2])
        if table.key[n] >= 0:
            n = keep_entry(model, q, margin, table, at[k, 3], first, n)
    return n


@kernel
def is_beside(
    model: SpatialModel, a: int, b: int, pose: Pose, reverse: Pose, over_a: FaceAxis, over_b: FaceAxis, band: float
) -> bool:
    """Whether one of two bodies is beyond two faces of the other at once, to rounding: at their edge, over neither.

    A box that slides over the seam of two flush ones is there with its front, in the plane of the sides that meet at
    the seam: which face of the second one it would touch first is not known, and it passes along either.
    """
    if abs(over_b.separation) <= band and beyond_edge(model, b, a, pose, over_b.polygon, band):
        return True
    return abs(over_a.separation) <= band and beyond_edge(model, a, b, reverse, over_a.polygon, band)


@late_kernel
def polyhedra_touch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of two convex polyhedra with gaps up to ``margin``, from entry n on; the new count, or APART.

    Of bodies that are apart the patch of two faces tells the distance where these are nearly parallel; else vertices
    and edges may be nearer.
    """
    c = model.contacts
    pose = seen(frame_of(model.bodies, q, c.surface_body[a]), frame_of(model.bodies, q, c.surface_body[b]))
    over_b = widest_face(model, b, a, pose, margin)
    if over_b.separation > margin:
        return n
    reverse = back(pose)
    over_a = widest_face(model, a, b, reverse, margin)
    if over_a.separation > margin:
        return n
    size = 2.0 * min(c.surface_extent[a], c.surface_extent[b])
    second = over_a.separation <= over_b.separation + TIE * size
    axis, there = (over_b, pose) if second else (over_a, reverse)
    if table.seams == 1 and is_beside(model, a, b, pose, reverse, over_a, over_b, ROUNDED * size):
        return n
    normal = polygon_normal(model, axis.polygon)
    g, cosine = incident_face(model, axis.node, turned_back(there.A, normal))
    patch = Patch(law, axis.polygon, g, there, second, normal, THIN * size, size)
    beside = beyond_side(model, axis.polygon, seen_there(model, patch, axis.node)) > THIN * size
    apart, parallel = axis.separation > SHALLOW * size, cosine >= 1.0 - 0.5 * TILT * TILT
    if apart and not parallel:
        return APART
    if beside and not parallel:
        found = ridges(model, a, b, pose)
        if found.separation > axis.separation + WORSE * abs(axis.separation) + SHALLOW * size:
            if n < len(table.key):
                _, e = ends_of(model, found.first)
                _, f = ends_of(model, found.second)
                sense = 1.0 if dot(cross(turned(pose.A, e), f), found.normal) > 0.0 else -1.0
                load_edges(model, table, n, law, found.first, found.second, sense)
                locate(model, q, table, n)
            return n + 1 if found.separation <= margin else n
    count = lay_patch(model, q, margin, table, patch, n)
    return APART if count == n and apart else count
