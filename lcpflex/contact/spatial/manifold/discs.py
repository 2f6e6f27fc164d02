"""The patch of a flat end of a cylinder and a polygon: a face of a polyhedron, or the end of another cylinder.

Seen along the axis, the patch is what the circle about the end and the polygon have in common. Its corners are the
polygon's in the circle, crossings of its sides with the circle, points of the rim over the polygon, and the lowest
places of rims that lean: these tell the gap exactly, the others hold what stands. Ends of other cylinders are polygons
of the points of their rims.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.kinds import AROUND
from lcpflex.contact.spatial.manifold.axes import node_place
from lcpflex.contact.spatial.manifold.rods import Rod, center_of, chord_of, outward_of, rim_node
from lcpflex.contact.spatial.manifold.weights import lay_weights
from lcpflex.contact.spatial.narrow_phase.edges import END
from lcpflex.contact.spatial.narrow_phase.rim import lowest_on_rim
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, apart_from, dot
from lcpflex.model.spatial import SpatialModel

__all__ = [
    "CORNER",
    "Disc",
    "LOWEST",
    "LOWEST_OTHER",
    "NEARLY_PARALLEL",
    "NEAR_END",
    "ON_RIM",
    "along",
    "collect_corners",
    "lay_corner",
    "lay_face",
    "lay_rim_polygon",
    "over_disc",
    "over_polygon",
    "seen_on",
    "set_disc",
    "weigh",
]

# what makes a corner: a corner of the polygon, a point of the rim, a crossing; the lowest place of the rim over the
# polygon, and of the polygon's own rim over the end
CORNER, ON_RIM, CROSSING, LOWEST, LOWEST_OTHER = range(5)
NEARLY_PARALLEL = 1e-3  # sine of the angle of two curves below which rounding and a little tilt turn their normal
NEAR_END = 2.0 * END  # of its length: an edge that crosses so near its end is not followed as one that does


class Disc(NamedTuple):
    """A flat end: its cylinder, which end, its middle [m], outward normal, and two directions across that."""

    rod: Rod
    end: int
    center: Vector
    n: Vector
    u: Vector
    v: Vector


@kernel
def set_disc(rod: Rod, end: int) -> Disc:
    """An end of a cylinder."""
    n = outward_of(rod, end)
    u, _ = lowest_on_rim(n, NOTHING)
    return Disc(rod, end, center_of(rod, end), n, u, cross(n, u))


@kernel
def seen_on(disc: Disc, place: Vector) -> Vector:
    """x, y and height of a place over an end [m]."""
    d = apart_from(place, disc.center)
    return dot(d, disc.u), dot(d, disc.v), dot(d, disc.n)


@kernel
def over_disc(disc: Disc, place: Vector, thin: float) -> bool:
    """Whether a place is over an end, seen along its axis."""
    x, y, _ = seen_on(disc, place)
    return math.hypot(x, y) <= disc.rod.radius + thin


@kernel
def lay_polygon_corner(
    at: FloatArray, trace: IntArray, m: int, place: Vector, node: int, edge: int, side: int
) -> None:  # fmt: skip
    """Corner m of a polygon, and its side from there to the next one."""
    at[m, 0], at[m, 1], at[m, 2] = place
    trace[m, 0], trace[m, 1], trace[m, 2] = node, edge, side


@kernel
def lay_face(model: SpatialModel, table: SpatialContactTable, disc: Disc, p: int) -> int:
    """The corners of polygon p of a polyhedron, in whose frame the disc is; how many."""
    c = model.contacts
    m = 0
    for k in range(c.side_start[p], c.side_start[p + 1]):
        place = seen_on(disc, node_place(model, c.side_node[k]))
        lay_polygon_corner(table.patch[0], table.trace[0], m, place, c.side_node[k], c.side_edge[k], k)
        m += 1
    return m


@kernel
def rim_place(model: SpatialModel, q: FloatArray, frame: Frame, rod: Rod, end: int, k: int) -> tuple[int, Vector]:
    """Point k of a rim: its node, and where it is in the frame [m]."""
    node = rim_node(model, rod, end, k)
    own = frame_of(model.bodies, q, model.contacts.surface_body[rod.surface])
    place = world_place(own, place_in(model.points, q, own, model.contacts.node_point[node]))
    return node, seen_from(frame, place)


@kernel
def lay_rim_polygon(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, frame: Frame, disc: Disc, rod: Rod, end: int
) -> int:
    """The points of the rim of another cylinder, as a polygon; how many."""
    for k in range(AROUND):
        node, place = rim_place(model, q, frame, rod, end, k)
        chord = chord_of(rod, end, k)
        lay_polygon_corner(table.patch[0], table.trace[0], k, seen_on(disc, place), node, chord, -1)
    return AROUND


@kernel
def twice_area(at: FloatArray, m: int) -> float:
    """Of a polygon of m corners, signed [m^2]."""
    total = 0.0
    for k in range(m):
        j = k + 1 if k + 1 < m else 0
        total += at[k, 0] * at[j, 1] - at[k, 1] * at[j, 0]
    return total


@kernel
def over_polygon(at: FloatArray, m: int, sense: float, x: float, y: float, thin: float) -> bool:
    """Whether a place is within a polygon of m corners, which run counter-clockwise if sense > 0."""
    for k in range(m):
        j = k + 1 if k + 1 < m else 0
        ex, ey = at[j, 0] - at[k, 0], at[j, 1] - at[k, 1]
        if sense * (ex * (y - at[k, 1]) - ey * (x - at[k, 0])) < -thin * math.hypot(ex, ey):
            return False
    return True


@kernel
def lay_corner(
    table: SpatialContactTable, n: int, x: float, y: float, z: float, made: int, first: int, second: int, thin: float
) -> int:
    """Corner n of the patch, if none is there already; the new count."""
    at, trace = table.patch[1], table.trace[1]
    for k in range(n):
        if math.hypot(at[k, 0] - x, at[k, 1] - y) <= thin:
            return n
    at[n, 0], at[n, 1], at[n, 2] = x, y, z
    trace[n, 0], trace[n, 1], trace[n, 2] = made, first, second
    return n + 1


@kernel
def lay_crossings(table: SpatialContactTable, disc: Disc, m: int, n: int, thin: float) -> int:
    """Where sides of the polygon of m corners cross the circle; the new count of corners of the patch."""
    at, R = table.patch[0], disc.rod.radius
    for k in range(m):
        j = k + 1 if k + 1 < m else 0
        ex, ey = at[j, 0] - at[k, 0], at[j, 1] - at[k, 1]
        square = ex * ex + ey * ey
        middle = -(at[k, 0] * ex + at[k, 1] * ey) / square
        reach = math.hypot(at[k, 0] + middle * ex, at[k, 1] + middle * ey)
        if reach >= R:
            continue
        half = math.sqrt((R - reach) * (R + reach) / square)
        for leaves in range(2):
            s = middle + half if leaves == 1 else middle - half
            if 0.0 < s < 1.0:
                x, y = at[k, 0] + s * ex, at[k, 1] + s * ey
                n = lay_corner(table, n, x, y, at[k, 2] + s * (at[j, 2] - at[k, 2]), CROSSING, k, leaves, thin)
    return n


@kernel
def collect_corners(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, frame: Frame, disc: Disc, m: int, flat: bool,
    thin: float,
) -> tuple[int, float]:  # fmt: skip
    """Corners that the polygon of m corners, crossings and, where it lies ``flat``, the rim make; and its sense.

    A point of the rim is not a vertex, whose normals lead anywhere: where an edge crosses it, that is what touches.
    """
    at, trace = table.patch[0], table.trace[0]
    sense = 1.0 if twice_area(at, m) >= 0.0 else -1.0
    n = 0
    for k in range(m):
        if math.hypot(at[k, 0], at[k, 1]) <= disc.rod.radius + thin:
            n = lay_corner(table, n, at[k, 0], at[k, 1], at[k, 2], CORNER, trace[k, 0], k, thin)
    n = lay_crossings(table, disc, m, n, thin)
    for k in range(AROUND if flat else 0):
        node, place = rim_place(model, q, frame, disc.rod, disc.end, k)
        x, y, z = seen_on(disc, place)
        if over_polygon(at, m, sense, x, y, thin):
            n = lay_corner(table, n, x, y, z, ON_RIM, node, k, thin)
    return n, sense


@kernel
def sort_around(table: SpatialContactTable, n: int) -> None:
    """The n corners of the patch, in their order about its middle."""
    at, trace = table.patch[1], table.trace[1]
    x, y = 0.0, 0.0
    for k in range(n):
        x += at[k, 0] / n
        y += at[k, 1] / n
    for k in range(n):
        at[k, 3] = math.atan2(at[k, 1] - y, at[k, 0] - x)
    for k in range(1, n):
        j = k
        while j > 0 and at[j - 1, 3] > at[j, 3]:
            for c in range(4):
                at[j - 1, c], at[j, c] = at[j, c], at[j - 1, c]
                trace[j - 1, c], trace[j, c] = trace[j, c], trace[j - 1, c]
            j -= 1


@kernel
def weigh(table: SpatialContactTable, n: int, thin: float, size: float) -> None:
    """Weights of the n corners of the patch, which come into their order."""
    sort_around(table, n)
    at = table.patch[1]
    for k in range(n):
        at[k, 2] = 0.0
    if n > 0:
        lay_weights(at, n, (0.0, 0.0, 1.0), thin * size)


@kernel
def along(disc: Disc, a: Vector) -> Vector:
    """A direction along the axes of an end."""
    return dot(a, disc.u), dot(a, disc.v), dot(a, disc.n)
