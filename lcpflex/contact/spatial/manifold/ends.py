"""Contacts of the patch of a flat end of a cylinder with a face of a polyhedron, or with the end of another one."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.cylinder_pass import ENDS_OF
from lcpflex.contact.spatial.entries import load_by_cylinder, load_edge_by_rim, load_edge_on_cap, load_rim, load_vertex
from lcpflex.contact.spatial.manifold.axes import polygon_normal
from lcpflex.contact.spatial.manifold.discs import (
    CORNER,
    LOWEST,
    LOWEST_OTHER,
    NEAR_END,
    NEARLY_PARALLEL,
    ON_RIM,
    Disc,
    along,
    collect_corners,
    lay_corner,
    lay_face,
    lay_rim_polygon,
    over_disc,
    over_polygon,
    seen_on,
    set_disc,
    weigh,
)
from lcpflex.contact.spatial.manifold.hulls import keep_entry, leads_out
from lcpflex.contact.spatial.manifold.rods import Rod, cap_of, center_of, is_along, outward_of
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.contact.spatial.narrow_phase.rim import FLAT, direction_at, lowest_on_rim
from lcpflex.contact.spatial.narrow_phase.rim_line import half_of, nearest_on_rim, towards
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.table import NODE_CAP, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, scaled, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["lay_end_on_end", "lay_end_on_face"]

OVERHANGS = 0.9  # of the radius: nearer to the middle a body tips over none of 16 chords, which are .98 from there


@kernel
def edge_line(model: SpatialModel, q: FloatArray, frame: Frame, edge: int) -> tuple[Vector, Vector]:
    """Where an edge begins in the frame [m], and its line."""
    c = model.contacts
    own = frame_of(model.bodies, q, model.points.body[c.feature_point[edge, 0]])
    start = seen_from(frame, world_place(own, place_in(model.points, q, own, c.feature_point[edge, 0])))
    end = seen_from(frame, world_place(own, place_in(model.points, q, own, c.feature_point[edge, 1])))
    return start, apart_from(end, start)


@kernel
def touches_rim(
    model: SpatialModel, table: SpatialContactTable, disc: Disc, k: int, m: int, x: float, y: float
) -> bool:
    """Whether side k of a face of m corners touches the rim, as an edge, where it crosses the circle at x, y.

    Else the normal of both leads out of the body beside that side, or is not known, and that of the end stands for it.
    """
    c = model.contacts
    at = table.patch[0]
    j = k + 1 if k + 1 < m else 0
    e = (at[j, 0] - at[k, 0], at[j, 1] - at[k, 1], at[j, 2] - at[k, 2])
    share = ((x - at[k, 0]) * e[0] + (y - at[k, 1]) * e[1]) / (e[0] * e[0] + e[1] * e[1])
    tau = (-y / disc.rod.radius, x / disc.rod.radius, 0.0)
    n = cross(e, tau)
    length = norm(n)
    if length <= NEARLY_PARALLEL * norm(e) or min(share, 1.0 - share) <= NEAR_END:
        return False
    n = scaled((1.0 if n[2] > 0.0 else -1.0) / length, n)
    if n[0] * x + n[1] * y < -TILT * disc.rod.radius:
        return False
    side = table.trace[0, k, 2]
    own, other = polygon_normal(model, polygon_of_side(model, side)), polygon_normal(model, c.side_beside[side])
    inward = scaled(-1.0, n)
    return leads_out(inward, e, along(disc, own), 1.0) and leads_out(inward, e, along(disc, other), -1.0)


@kernel
def polygon_of_side(model: SpatialModel, side: int) -> int:
    """Which polygon has a side."""
    start = model.contacts.side_start
    low, high = 0, len(start) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if start[middle] <= side:
            low = middle
        else:
            high = middle
    return low


@kernel
def load_crossing_of_rim(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, n: int, law: int, frame: Frame, disc: Disc,
    edge: int, x: float, y: float, touches: bool,
) -> None:  # fmt: skip
    """Entry n, of an edge that crosses the circle at x, y: with the rim, which it touches, or else the flat end."""
    rod = disc.rod
    start, e = edge_line(model, q, frame, edge)
    leaves = x * dot(e, disc.u) + y * dot(e, disc.v) > 0.0
    if not touches:
        load_edge_on_cap(model, table, n, law, edge, rod.first, disc.end, 1.0 if leaves else -1.0)
        return
    found = nearest_on_rim(rod.axis, rod.radius, e, apart_from(disc.center, start))
    place = found.first
    if found.two:
        first, second = towards(found, found.first), towards(found, found.second)
        if dot(along(disc, second), (x, y, 0.0)) > dot(along(disc, first), (x, y, 0.0)):
            place = found.second
    load_edge_by_rim(model, table, n, law, edge, rod.first, disc.end, half_of(found, place[0]))


@kernel
def lowest_of_end(
    model: SpatialModel, q: FloatArray, frame: Frame, rod: Rod, end: int, n: Vector, over: Vector
) -> tuple[bool, Vector, float]:
    """The lowest place of a rim along n [m]; of one that lies flat that towards ``over``, whose angle is told, too.

    A body that overhangs tips over it: between two points of the rim it would tip too soon, and fall on the arc. One
    whose middle is far inside of the points tips over none, and of one in the very middle rounding tells the way: there
    is no such place then.
    """
    point, rim = model.contacts.feature_point, rod.first + end
    own = frame_of(model.bodies, q, model.contacts.surface_body[rod.surface])
    o, x = point[rim, 0], point[rim, 1]
    u = turned_back(frame.A, direction_at(model.points, q, own, o, x, 0.0))
    v = cross(scaled(-1.0, outward_of(rod, end)), u)
    d = apart_from(over, center_of(rod, end))
    across, along = dot(d, u), dot(d, v)
    angle = math.atan2(along, across)
    c, tilt = lowest_on_rim(rod.axis, n)
    if tilt <= FLAT:
        if math.hypot(across, along) < OVERHANGS * rod.radius:
            return False, NOTHING, 0.0
        c = added(scaled(math.cos(angle), u), scaled(math.sin(angle), v))
    place = added(center_of(rod, end), scaled(rod.radius, c))
    return True, place, angle if angle != 0.0 else 2.0 * math.pi  # 0 stands for none


@kernel
def middle_of(rod: Rod) -> Vector:
    """Of a cylinder [m]."""
    return added(rod.start, scaled(0.5 * rod.length, rod.axis))


@kernel
def lay_end_on_face(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, frame: Frame, rod: Rod,
    end: int, p: int, thin: float, size: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of an end and polygon p, in whose frame the rod is, from entry n on; the new count, and if any corner."""
    c = model.contacts
    disc = set_disc(rod, end)
    m = lay_face(model, table, disc, p)
    normal = polygon_normal(model, p)
    count, sense = collect_corners(model, q, table, frame, disc, m, is_along(rod, normal), thin)
    leans, place, angle = lowest_of_end(model, q, frame, rod, end, normal, NOTHING)
    x, y, z = seen_on(disc, place)
    if leans and over_polygon(table.patch[0], m, sense, x, y, thin):
        count = lay_corner(table, count, x, y, z, LOWEST, 0, 0, thin)
    weigh(table, count, thin, size)
    at, trace = table.patch[1], table.trace[1]
    first = n
    for k in range(count):
        if n >= len(table.key):
            return n + count - k, True
        made = trace[k, 0]
        if made == CORNER:
            load_by_cylinder(model, table, n, law, NODE_CAP, trace[k, 1], rod.first, ENDS_OF + end)
            table.facing[n] = -math.inf
        elif made == ON_RIM:
            load_vertex(model, table, n, law, trace[k, 1], c.polygon_feature[p])
        elif made == LOWEST:
            load_rim(model, table, n, law, rod.first + end, c.polygon_feature[p], angle)
        else:
            i = trace[k, 1]
            touches = touches_rim(model, table, disc, i, m, at[k, 0], at[k, 1])
            edge = table.trace[0, i, 1]
            load_crossing_of_rim(model, q, table, n, law, frame, disc, edge, at[k, 0], at[k, 1], touches)
        n = keep_entry(model, q, margin, table, at[k, 3], first, n)
    return n, count > 0


@kernel
def lay_end_on_end(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, frame: Frame, rod: Rod,
    end: int, other: Rod, facing: int, thin: float, size: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of an end of a rod and that of another one which faces it, from entry n on; the same."""
    disc, opposite = set_disc(rod, end), set_disc(other, facing)
    m = lay_rim_polygon(model, q, table, frame, disc, other, facing)
    count, _ = collect_corners(model, q, table, frame, disc, m, True, thin)
    leans, place, angle_other = lowest_of_end(model, q, frame, other, facing, disc.n, middle_of(rod))
    if leans and over_disc(disc, place, thin):
        x, y, z = seen_on(disc, place)
        count = lay_corner(table, count, x, y, z, LOWEST_OTHER, 0, 0, thin)
    leans, place, angle = lowest_of_end(model, q, frame, rod, end, opposite.n, middle_of(other))
    if leans and over_disc(opposite, place, thin):
        x, y, z = seen_on(disc, place)
        count = lay_corner(table, count, x, y, z, LOWEST, 0, 0, thin)
    weigh(table, count, thin, size)
    at, trace = table.patch[1], table.trace[1]
    first = n
    for k in range(count):
        if n >= len(table.key):
            return n + count - k, True
        made = trace[k, 0]
        if made == CORNER:
            load_by_cylinder(model, table, n, law, NODE_CAP, trace[k, 1], rod.first, ENDS_OF + end)
        elif made == ON_RIM:
            load_by_cylinder(model, table, n, law, NODE_CAP, trace[k, 1], other.first, ENDS_OF + facing)
        elif made == LOWEST_OTHER:
            load_rim(model, table, n, law, other.first + facing, cap_of(rod, end), angle_other)
        elif made == LOWEST:
            load_rim(model, table, n, law, rod.first + end, cap_of(other, facing), angle)
        else:
            edge = table.trace[0, trace[k, 1], 1]
            load_crossing_of_rim(model, q, table, n, law, frame, disc, edge, at[k, 0], at[k, 1], False)
        n = keep_entry(model, q, margin, table, at[k, 3], first, n)
    return n, count > 0
