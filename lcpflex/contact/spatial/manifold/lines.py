"""The patch of a cylinder that lies: on a face, on the end or along the side of another one, or along an edge.

It is the part of a line, the lowest one of the side, that is over what it lies on. Its ends are lowest places of rims,
which are over that, or where the line crosses a side of the face or the rim of the end. Of two parallel lines the ends
of what they have in common touch.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.cylinder_edge_pass import gap_of_rim
from lcpflex.contact.spatial.cylinder_pass import SIDE_OF
from lcpflex.contact.spatial.entries import (
    load_by_cylinder,
    load_crossing,
    load_edge_by_rim,
    load_edge_by_side,
    load_node,
    load_rim,
)
from lcpflex.contact.spatial.manifold.axes import ends_of, node_place, polygon_normal
from lcpflex.contact.spatial.manifold.clip import beyond_side, next_side, side_of_polygon
from lcpflex.contact.spatial.manifold.discs import NEAR_END, NEARLY_PARALLEL, over_disc, set_disc
from lcpflex.contact.spatial.manifold.hulls import keep_entry, leads_out
from lcpflex.contact.spatial.manifold.rods import Rod, axis_node, cap_of, center_of, lowest_at, outward_of, side_of_rod
from lcpflex.contact.spatial.narrow_phase.rim_line import half_of, nearest_on_rim, towards
from lcpflex.contact.spatial.table import NODE_EDGE, NODE_SIDE, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["lay_along_edge", "lay_end_of_rod", "lay_on_end", "lay_on_face", "lay_side_by_side"]


@kernel
def crosses_side(model: SpatialModel, rod: Rod, p: int, side: int, share: float, place: Vector) -> tuple[bool, float]:
    """Whether the lowest line touches a side of face p which it crosses, as an edge, at its ``share`` and a place.

    And the sense of (its feature's line) x (axis) as the normal from the rod into the body. Else the normal of both
    leads out of the body beside that side, or is not known, and that of the face stands for it.
    """
    c = model.contacts
    n = polygon_normal(model, p)
    start = node_place(model, c.side_node[side])
    f = apart_from(node_place(model, c.side_node[next_side(model, p, side)]), start)
    out = cross(f, rod.axis)
    length = norm(out)
    along = dot(f, apart_from(place, start)) / dot(f, f)
    if (
        length <= NEARLY_PARALLEL * norm(f)
        or min(share, 1.0 - share) <= NEAR_END
        or min(along, 1.0 - along) <= NEAR_END
    ):
        return False, 1.0
    out = scaled((1.0 if dot(out, n) > 0.0 else -1.0) / length, out)
    touches = leads_out(out, f, n, 1.0) and leads_out(out, f, polygon_normal(model, c.side_beside[side]), -1.0)
    _, line = ends_of(model, c.side_edge[side])
    return touches, -1.0 if dot(cross(line, rod.axis), out) > 0.0 else 1.0


@kernel
def load_end_of_line(
    model: SpatialModel, table: SpatialContactTable, n: int, law: int, rod: Rod, p: int, end: int, side: int,
    share: float, place: Vector,
) -> None:  # fmt: skip
    """Entry n, of an end of the line on face p: the rim there, or where it crosses a side, at its ``share``."""
    c = model.contacts
    if side < 0:
        load_rim(model, table, n, law, rod.first + end, c.polygon_feature[p])
        return
    edge = c.side_edge[side]
    touches, sense = crosses_side(model, rod, p, side, share, place)
    if touches:
        load_edge_by_side(model, table, n, law, edge, side_of_rod(rod), sense)
        return
    start, line = ends_of(model, edge)
    inward = apart_from(row_vector(model.points.place, c.side_across[side]), start)
    sense = -1.0 if dot(cross(line, inward), polygon_normal(model, p)) > 0.0 else 1.0
    load_crossing(model, table, n, law, edge, side_of_rod(rod), c.side_across[side], sense)


@kernel
def lay_on_face(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, p: int,
    thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of a rod that lies on polygon p, in whose frame it is, from entry n on; the new count, and if any."""
    c = model.contacts
    normal = polygon_normal(model, p)
    head, tail = lowest_at(rod, 0, normal), lowest_at(rod, 1, normal)
    line = apart_from(tail, head)
    low, high, first, last = 0.0, 1.0, -1, -1
    for k in range(c.side_start[p], c.side_start[p + 1]):
        start, out = side_of_polygon(model, k, next_side(model, p, k), normal)
        a, b = dot(out, apart_from(head, start)), dot(out, apart_from(tail, start))
        if a > thin and b > thin:
            return n, False
        if a > thin and a / (a - b) > low:
            low, first = a / (a - b), k
        if b > thin and a / (a - b) < high:
            high, last = a / (a - b), k
    if low > high + thin / rod.length:
        return n, False
    begin = n
    for end in range(2):
        if n >= len(table.key):
            return n + 2 - end, True
        if end == 1 and n > begin and (high - low) * rod.length <= thin:
            break
        share = high if end == 1 else low
        place = added(head, scaled(share, line))
        load_end_of_line(model, table, n, law, rod, p, end, last if end == 1 else first, share, place)
        n = keep_entry(model, q, margin, table, 1.0, begin, n)
    return n, True


@kernel
def lay_end_of_rod(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, end: int,
    place: Vector, p: int, thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """The entry of the lowest place of a rim over polygon p, where it is over that; the same."""
    if beyond_side(model, p, place) > thin:
        return n, False
    if n < len(table.key):
        load_rim(model, table, n, law, rod.first + end, model.contacts.polygon_feature[p])
        return keep_entry(model, q, margin, table, 1.0, n, n), True
    return n + 1, True


@kernel
def lay_on_end(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, other: Rod,
    facing: int, thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of a rod that lies or leans on an end of another one, from entry n on; the same."""
    disc = set_disc(other, facing)
    begin, any_one = n, False
    for end in range(2):
        if over_disc(disc, lowest_at(rod, end, disc.n), thin):
            any_one = True
            if n < len(table.key):
                load_rim(model, table, n, law, rod.first + end, cap_of(other, facing))
                n = keep_entry(model, q, margin, table, 1.0, begin, n)
            else:
                n += 1
    e, away = scaled(rod.length, rod.axis), apart_from(center_of(other, facing), rod.start)
    found = nearest_on_rim(other.axis, other.radius, e, away)
    for number in range(2 if found.two else 1):
        place = found.first if number == 0 else found.second
        c = towards(found, place)
        within, gap = gap_of_rim(away, e, outward_of(other, facing), c, other.radius, rod.radius)
        if not within:
            continue
        any_one = True
        if gap <= margin:
            if n < len(table.key):
                half = half_of(found, place[0])
                load_edge_by_rim(model, table, n, law, side_of_rod(rod), other.first, facing, half)
                n = keep_entry(model, q, margin, table, 1.0, begin, n)
            else:
                n += 1
    return n, any_one


@kernel
def load_end_by_line(
    model: SpatialModel, table: SpatialContactTable, n: int, law: int, rod: Rod, end: int, f: int
) -> None:
    """Entry n, of an end of a rod, as a sphere about the middle of its rim, with an edge or the side of another one."""
    load_node(model, table, n, law, NODE_EDGE, axis_node(model, rod, end), f)


@kernel
def lay_side_by_side(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, other: Rod,
    thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of two rods that are nearly parallel: both ends of what they have in common; the same."""
    begin = n
    a0, a1 = dot(other.axis, apart_from(rod.start, other.start)), 0.0
    a1 = a0 + rod.length * dot(other.axis, rod.axis)
    low, high = (0, 1) if a0 <= a1 else (1, 0)
    least, most = min(a0, a1), max(a0, a1)
    if least > other.length + thin or most < -thin:
        return n, False
    for upper in range(2):
        if n >= len(table.key):
            return n + 2 - upper, True
        of_rod = most <= other.length + thin if upper == 1 else least >= -thin
        if of_rod:
            load_end_by_line(model, table, n, law, rod, high if upper == 1 else low, side_of_rod(other))
        else:
            load_end_by_line(model, table, n, law, other, upper, side_of_rod(rod))
        n = keep_entry(model, q, margin, table, 1.0, begin, n)
    return n, True


@kernel
def vertex_at(model: SpatialModel, s: int, point: int) -> int:
    """The node of a polyhedron that is a material point."""
    c = model.contacts
    for node in range(c.node_start[s], c.node_start[s + 1]):
        if c.node_point[node] == point:
            return node
    return -1


@kernel
def lay_along_edge(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, s: int,
    edge: int, thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """Entries of a rod along an edge of polyhedron s, in whose frame it is: ends of what they have in common."""
    begin = n
    start, line = ends_of(model, edge)
    a0 = dot(rod.axis, apart_from(start, rod.start))
    a1 = a0 + dot(rod.axis, line)
    low, high = (0, 1) if a0 <= a1 else (1, 0)
    least, most = min(a0, a1), max(a0, a1)
    if least > rod.length + thin or most < -thin:
        return n, False
    for upper in range(2):
        if n >= len(table.key):
            return n + 2 - upper, True
        of_edge = most <= rod.length + thin if upper == 1 else least >= -thin
        if of_edge:
            point = model.contacts.feature_point[edge, high if upper == 1 else low]
            load_by_cylinder(model, table, n, law, NODE_SIDE, vertex_at(model, s, point), rod.first, SIDE_OF)
            table.facing[n] = -math.inf
        else:
            load_end_by_line(model, table, n, law, rod, upper, edge)
        n = keep_entry(model, q, margin, table, 1.0, begin, n)
    return n, True
