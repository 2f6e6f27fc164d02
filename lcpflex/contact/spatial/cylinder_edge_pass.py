"""What the edges of capsules have with a cylinder, where it is not an end of theirs that is nearest.

An edge touches the side where it crosses the axis between both ends, and a rim where circle and line are nearest to
each other with a normal between those of the side and of the end, to the small angle that crossing edges have. So a
capsule that lies along a cylinder, or across an end of it, is held by two contacts: its own ends and places of rims.
"""

from __future__ import annotations

from lcpflex.contact.spatial.cylinder_pass import SIDE_OF
from lcpflex.contact.spatial.entries import load_edge_by_rim, load_edge_by_side
from lcpflex.contact.spatial.kinds import EDGE
from lcpflex.contact.spatial.narrow_phase.cylinder import length_between
from lcpflex.contact.spatial.narrow_phase.edges import END, TILT, crossing_of, edges_cross
from lcpflex.contact.spatial.narrow_phase.rim import rim_axis
from lcpflex.contact.spatial.narrow_phase.rim_line import half_of, nearest_on_rim, towards
from lcpflex.contact.spatial.narrow_phase.sides import frame_of, line_between, place_in, world_place
from lcpflex.contact.spatial.narrow_phase.turning import COINCIDENT
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, scaled, turned
from lcpflex.model.spatial import SpatialModel

__all__ = ["edges_on_cylinder"]


@kernel
def gap_of_side(y: Vector, e: Vector, a: Vector, length: float, radii: float) -> tuple[bool, float, float]:
    """Whether an edge e from y has a contact with the side, its sense and its gap [m]."""
    if not edges_cross(e, a):
        return False, 1.0, 0.0
    n, s, t = crossing_of(y, e, scaled(length, a))
    height = dot(n, y)
    within = s > END and s < 1.0 - END and t > END and t < 1.0 - END
    return within, 1.0 if height >= 0.0 else -1.0, abs(height) - radii


@kernel
def gap_of_rim(away: Vector, e: Vector, outward: Vector, c: Vector, R: float, rho: float) -> tuple[bool, float]:
    """Whether an edge has a contact with the place R c of a rim, whose centre is ``away`` from it; and the gap [m]."""
    to = added(away, scaled(R, c))
    s = dot(e, to) / dot(e, e)
    d = apart_from(scaled(s, e), to)
    D = norm(d)
    within = s > END and s < 1.0 - END and D >= COINCIDENT
    return within and dot(d, outward) >= -TILT * D and dot(d, c) >= -TILT * D, D - rho


@kernel
def edge_on_cylinder(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, edge: int, b: int, law: int,
    y: Vector, e: Vector, a: Vector, n: int,
) -> int:  # fmt: skip
    """Contacts of an edge, e from y behind where the cylinder b begins, from entry n on; returns the new count."""
    c = model.contacts
    first = c.feature_start[b]
    R, rho = c.feature_radius[first], c.feature_radius[edge]
    length = length_between(model.points, c.feature_point[first, 0], c.feature_point[first, 1])
    within, sense, gap = gap_of_side(y, e, a, length, R + rho)
    if within and gap <= margin:
        if n < len(table.key):
            load_edge_by_side(model, table, n, law, edge, first + SIDE_OF, sense)
            locate(model, q, table, n)
        n += 1
    for end in range(2):
        away = apart_from(scaled(length if end == 1 else 0.0, a), y)
        outward = scaled(1.0 if end == 1 else -1.0, a)
        found = nearest_on_rim(a, R, e, away)
        for number in range(2 if found.two else 1):
            place = found.first if number == 0 else found.second
            within, gap = gap_of_rim(away, e, outward, towards(found, place), R, rho)
            if within and gap <= margin:
                if n < len(table.key):
                    load_edge_by_rim(model, table, n, law, edge, first, end, half_of(found, place[0]))
                    locate(model, q, table, n)
                n += 1
    return n


@late_kernel
def edges_on_cylinder(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the edges of surface a with the cylinder b, from entry n on; returns the new count."""
    c = model.contacts
    frame, of_edges = frame_of(model.bodies, q, c.surface_body[b]), frame_of(model.bodies, q, c.surface_body[a])
    first = c.feature_start[b]
    o, x = c.feature_point[first, 0], c.feature_point[first, 1]
    start, axis = world_place(frame, place_in(model.points, q, frame, o)), rim_axis(model.points, q, frame, o, x)
    for edge in range(c.feature_start[a], c.feature_start[a + 1]):
        if c.feature_kind[edge] == EDGE:
            p, r = c.feature_point[edge, 0], c.feature_point[edge, 1]
            y = apart_from(world_place(of_edges, place_in(model.points, q, of_edges, p)), start)
            e = turned(of_edges.A, line_between(model.points, q, of_edges, p, r))
            n = edge_on_cylinder(model, q, margin, table, edge, b, law, y, e, axis, n)
    return n
