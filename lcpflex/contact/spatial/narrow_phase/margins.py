"""How far the foot of an entry is inside its features: what ends where a node slides off a facet or an edge.

Detection owns places to a thickness, of the extent of a surface, that stands for rounding. Margins are measured as it
does: distances from the sides of a facet, the ends of an edge, the planes beside edges and vertices, and other parts
of a cylinder, in extents of the surface; of two edges, how far from their ends they cross, in their lengths, and how
far the normal is inside their wedges [rad]. They are 0 where detection finds the pair no more, to that thickness.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.kinds import CAP, EDGE, FACET, PLANE, POLYGON, SIDE
from lcpflex.contact.spatial.manifold.clip import beyond_side
from lcpflex.contact.spatial.mesh_pairs import band_between
from lcpflex.contact.spatial.narrow_phase.crossing import UNKNOWN, face_on_j
from lcpflex.contact.spatial.narrow_phase.cylinder import cylinder_margin
from lcpflex.contact.spatial.narrow_phase.cylinder_edges import edge_margin
from lcpflex.contact.spatial.narrow_phase.edges import END, TILT
from lcpflex.contact.spatial.narrow_phase.facet import plane_of
from lcpflex.contact.spatial.narrow_phase.rim import FLAT, lowest_on_rim, place_on_rim, rim_axis
from lcpflex.contact.spatial.narrow_phase.rims import rims_margin
from lcpflex.contact.spatial.narrow_phase.sides import Frame, line_between, place_in, seen_from, world_place
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    RIM_FACET,
    RIM_RIM,
    SpatialContactTable,
    by_cylinder,
    with_edge,
)
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["margin_on_i", "margin_on_j"]

HANGS = 2e-7  # of the extent, twice the drop from which detection lets an edge hang on a side: it is sure to, then


@kernel
def surface_of(start: IntArray, f: int) -> int:
    """Which surface has feature f."""
    low, high = 0, len(start) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if start[middle] <= f:
            low = middle
        else:
            high = middle
    return low


@kernel
def in_facet(model: SpatialModel, q: FloatArray, frame: Frame, f: int, x: float, y: float) -> float:
    """How far the foot x, y is from the nearest side of facet f [m]; hollow sides have no other side."""
    point, beside = model.contacts.feature_point, model.contacts.feature_neighbour
    plane = plane_of(model.points, q, frame, point[f, 0], point[f, 1], point[f, 2])
    margin = math.inf
    if beside[f, 0] < 0:
        margin = (1.0 - x - y) * plane.area / norm(apart_from(plane.e2, plane.e1))
    if beside[f, 1] < 0:
        margin = min(margin, x * plane.area / norm(plane.e2))
    if beside[f, 2] < 0:
        margin = min(margin, y * plane.area / norm(plane.e1))
    return margin


@kernel
def out_of_facet(model: SpatialModel, q: FloatArray, frame: Frame, f: int, facet: int) -> Vector:
    """The unit vector in a facet, in the frame, that leads out of it across edge f."""
    point = model.contacts.feature_point
    a, b = point[f, 0], point[f, 1]
    opposite = point[facet, 0]
    for k in range(1, 3):
        if opposite in (a, b):
            opposite = point[facet, k]
    start = place_in(model.points, q, frame, a)
    e = apart_from(place_in(model.points, q, frame, b), start)
    inward = apart_from(place_in(model.points, q, frame, opposite), start)
    inward = apart_from(inward, scaled(dot(inward, e) / dot(e, e), e))
    return scaled(-1.0 / norm(inward), inward)


@kernel
def in_wedge(model: SpatialModel, q: FloatArray, frame: Frame, f: int, y: Vector) -> float:
    """How far y, in the frame, leads out of both facets beside edge f; infinite where there are none."""
    margin = math.inf
    for side in range(2):
        facet = model.contacts.feature_neighbour[f, side]
        if facet >= 0:
            margin = min(margin, dot(y, out_of_facet(model, q, frame, f, facet)))
    return margin


@kernel
def in_fan(model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector) -> float:
    """How far a place is behind the planes through vertex f across its edges [m]; infinite of spheres."""
    c = model.contacts
    o = place_in(model.points, q, frame, c.feature_point[f, 0])
    away = apart_from(place, o)
    margin = math.inf
    for k in range(c.fan_start[f], c.fan_start[f + 1]):
        e = apart_from(place_in(model.points, q, frame, c.fan[k]), o)
        margin = min(margin, -dot(away, e) / norm(e))
    return margin


@kernel
def on_edge(model: SpatialModel, q: FloatArray, frame: Frame, f: int, s: float, place: Vector) -> float:
    """How far a place with its foot at s is from the end of what belongs to edge f [m]."""
    a = model.contacts.feature_point[f, 0]
    e = line_between(model.points, q, frame, a, model.contacts.feature_point[f, 1])
    y = apart_from(apart_from(place, place_in(model.points, q, frame, a)), scaled(s, e))
    return min(min(s, 1.0 - s) * norm(e), in_wedge(model, q, frame, f, y))


@kernel
def crossed_within(model: SpatialModel, q: FloatArray, frame: Frame, f: int, s: float, n: Vector) -> float:
    """How far inside edge f another one crosses it at s, n leading out of its body, world axes."""
    margin = min(s, 1.0 - s) - END
    return min(margin, in_wedge(model, q, frame, f, turned_back(frame.A, n)) + TILT)


@kernel
def on_line(model: SpatialModel, f: int, s: float) -> float:
    """How far the foot at s is from the ends of edge f, in extents; the edge of a rigid body."""
    c = model.contacts
    e = apart_from(
        row_vector(model.points.place, c.feature_point[f, 1]), row_vector(model.points.place, c.feature_point[f, 0])
    )
    return min(s, 1.0 - s) * norm(e) / c.surface_extent[surface_of(c.feature_start, f)]


@kernel
def above_side(model: SpatialModel, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> float:
    """How much farther an edge may fall below a face beyond the side that it crosses, in extents; entry k.

    An edge that falls deeper hangs on that side, and its body has tipped over it: detection tells so, from half of
    HANGS on. Infinite where the two edges have no normal that leads out of both bodies, as detection stays there, too;
    so it does of the axis of a cylinder, which touches sides as EDGE_SIDE wherever it can.
    """
    if table.radius[k, 0] > 0.0 or table.radius[k, 1] > 0.0:
        return math.inf
    c, points, point = model.contacts, model.points, table.point
    f = table.key[k] % len(c.feature_kind)
    e = table.key[k] // len(c.feature_kind) - len(c.node_point)
    head = world_place(i, place_in(points, q, i, point[k, 0]))
    tail = world_place(i, place_in(points, q, i, point[k, 1]))
    start = world_place(j, place_in(points, q, j, point[k, 2]))
    end = world_place(j, place_in(points, q, j, point[k, 3]))
    along_i, along_j, normal = apart_from(tail, head), apart_from(end, start), row_vector(table.normal, k)
    size = 2.0 * min(c.surface_extent[surface_of(c.feature_start, e)], c.surface_extent[surface_of(c.feature_start, f)])
    if face_on_j(points, table, k):
        inward = apart_from(world_place(j, place_in(points, q, j, point[k, 4])), start)
        inward = apart_from(inward, scaled(dot(inward, along_j) / dot(along_j, along_j), along_j))
        lowest = head if dot(inward, along_i) > 0.0 else tail
        drop = dot(normal, apart_from(start, lowest))
    else:
        inward = apart_from(world_place(i, place_in(points, q, i, point[k, 4])), head)
        inward = apart_from(inward, scaled(dot(inward, along_i) / dot(along_i, along_i), along_i))
        lowest = start if dot(inward, along_j) > 0.0 else end
        drop = dot(normal, apart_from(lowest, head))
    margin = (max(-table.gap[k], 0.0) - drop) / size + HANGS
    if margin >= 0.0:
        return margin
    n = cross(along_i, along_j)
    if norm(n) <= UNKNOWN * norm(along_i) * norm(along_j):
        return math.inf
    n = scaled((1.0 if dot(n, normal) > 0.0 else -1.0) / norm(n), n)
    out_of_j = in_wedge(model, q, j, f, turned_back(j.A, n))
    out_of_i = in_wedge(model, q, i, e, turned_back(i.A, scaled(-1.0, n)))
    return margin if min(out_of_i, out_of_j) >= -TILT else math.inf


@kernel
def within_circle(model: SpatialModel, q: FloatArray, frame: Frame, f: int, place: Vector, n: Vector) -> float:
    """How far inside the circle about a flat end, with normal n, a place over it is [m]; all in the frame."""
    c = model.contacts
    away = apart_from(place, place_in(model.points, q, frame, c.feature_point[f, 0]))
    return c.feature_radius[f] - norm(apart_from(away, scaled(dot(away, n), n)))


@kernel
def margin_on_j(model: SpatialModel, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> float:
    """How far the foot of entry k is inside the feature of body j."""
    c = model.contacts
    if table.averaged[k] == 1:
        return math.inf  # means have feet on many faces
    f = table.key[k] % len(c.feature_kind)
    if table.kind[k] == EDGE_EDGE:
        return crossed_within(model, q, j, f, table.foot[k, 1], row_vector(table.normal, k))
    if table.kind[k] == RIM_RIM:
        return rims_margin(model.points, q, (i, j), table, k)
    kind = c.feature_kind[f]
    if kind == PLANE:
        return math.inf
    if table.kind[k] == EDGE_FACET:
        return min(on_line(model, f, table.foot[k, 1]), above_side(model, q, i, j, table, k))
    b = surface_of(c.feature_start, f)
    extent = c.surface_extent[b]
    if by_cylinder(table, k):
        if with_edge(table, k):
            return edge_margin(model.points, q, i, j, table, k, extent)
        return cylinder_margin(model.points, q, i, j, table, k) / extent
    if kind == FACET:
        beside = band_between(model, surface_of(c.node_start, table.key[k] // len(c.feature_kind)), b)
        return (in_facet(model, q, j, f, table.foot[k, 0], table.foot[k, 1]) + beside) / extent
    place = world_place(i, place_in(model.points, q, i, table.point[k, 0]))
    if table.kind[k] == RIM_FACET:
        lowest, _ = place_on_rim(model.points, q, i, table, k, row_vector(table.normal, k))
        place = added(place, scaled(table.radius[k, 2], lowest))
    place = seen_from(j, place)
    if kind == POLYGON:
        return -beyond_side(model, c.feature_neighbour[f, 0], place) / extent
    if kind == CAP:
        return within_circle(model, q, j, f, place, turned_back(j.A, row_vector(table.normal, k))) / extent
    if kind in (EDGE, SIDE):
        return on_edge(model, q, j, f, table.foot[k, 0], place) / extent
    return in_fan(model, q, j, f, place) / extent


@kernel
def margin_on_i(model: SpatialModel, q: FloatArray, i: Frame, table: SpatialContactTable, k: int) -> float:
    """How far the contact of entry k is inside what touches of body i."""
    c = model.contacts
    touching = table.key[k] // len(c.feature_kind)
    n = row_vector(table.normal, k)
    if table.kind[k] in (EDGE_FACET, EDGE_CAP):
        return on_line(model, touching - len(c.node_point), table.foot[k, 0])
    if with_edge(table, k):
        return crossed_within(model, q, i, touching - len(c.node_point), table.foot[k, 0], scaled(-1.0, n))
    if table.kind[k] == RIM_FACET and table.facing[k] != 0.0:
        return math.inf  # of a patch, which has it where it lies flat, too
    if table.kind[k] == RIM_FACET:
        _, tilt = lowest_on_rim(rim_axis(model.points, q, i, table.point[k, 0], table.point[k, 1]), n)
        return tilt - FLAT
    if table.kind[k] == RIM_RIM:
        return math.inf
    m = row_vector(c.node_normal, touching)
    if dot(m, m) == 0.0:
        return math.inf
    return -dot(turned(i.A, m), n) - table.facing[k]
