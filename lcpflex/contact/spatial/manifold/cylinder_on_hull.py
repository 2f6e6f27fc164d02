"""The manifold of a cylinder and a convex polyhedron.

Separating axes are the normals of faces and of flat ends and, where these do not tell it, those of curves that cross:
of an edge with the side or a rim. The axis with the largest separation says what touches: along the axis of the
cylinder its flat end, across it a line of its side, else the lowest place of a rim.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.cylinder_pass import SIDE_OF
from lcpflex.contact.spatial.entries import load_by_cylinder, load_edge_by_rim, load_edge_by_side
from lcpflex.contact.spatial.manifold.axes import ONE_FACE, ends_of, incident_face, node_place, polygon_normal
from lcpflex.contact.spatial.manifold.curves import (
    DEEP,
    NO_CURVES,
    ON_RIM,
    SIDE_ACROSS,
    SIDE_ALONG,
    VERTEX,
    Curves,
    Flat,
    cross_within,
    decides,
    larger,
)
from lcpflex.contact.spatial.manifold.discs import NEARLY_PARALLEL, over_disc, set_disc
from lcpflex.contact.spatial.manifold.ends import lay_end_on_face
from lcpflex.contact.spatial.manifold.hulls import ROUNDED, SHALLOW, THIN, TIE
from lcpflex.contact.spatial.manifold.lines import lay_along_edge, lay_end_of_rod, lay_on_face
from lcpflex.contact.spatial.manifold.rods import (
    FLAT_FROM,
    Rod,
    center_of,
    is_across,
    is_along,
    lowest_at,
    lowest_height,
    outward_of,
    rod_of,
    side_of_rod,
)
from lcpflex.contact.spatial.narrow_phase.cylinder import radial
from lcpflex.contact.spatial.narrow_phase.edges import END
from lcpflex.contact.spatial.narrow_phase.rim_line import half_of, nearest_on_rim, towards
from lcpflex.contact.spatial.narrow_phase.sides import frame_of
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import NODE_RIM, NODE_SIDE, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["cylinder_touches"]


@kernel
def flat_of_polyhedron(model: SpatialModel, s: int, rod: Rod, margin: float) -> Flat:
    """Of polyhedron s the face that a rod in its frame is farthest above; more than ``margin``: the first such."""
    c = model.contacts
    best = Flat(-math.inf, -1, -1, 0)
    for p in range(c.polygon_start[s], c.polygon_start[s + 1]):
        separation = lowest_height(rod, polygon_normal(model, p)) - c.polygon_plane[p, 3]
        if separation > best.separation:
            best = Flat(separation, p, -1, 0)
            if separation > margin:
                break
    return best


@kernel
def rod_beyond_edge(model: SpatialModel, s: int, rod: Rod, first: int, band: float) -> bool:
    """Whether a rod is beyond a second face of polyhedron s, too, as :func:`beyond_edge`."""
    c = model.contacts
    m = polygon_normal(model, first)
    for p in range(c.polygon_start[s], c.polygon_start[s + 1]):
        n = polygon_normal(model, p)
        if dot(n, m) <= ONE_FACE and lowest_height(rod, n) - c.polygon_plane[p, 3] >= -band:
            return True
    return False


@kernel
def flat_of_rod(model: SpatialModel, s: int, rod: Rod) -> Flat:
    """Of a rod the end that polyhedron s, in whose frame it is, is farthest above."""
    c = model.contacts
    best = Flat(-math.inf, -1, -1, 1)
    for end in range(2):
        n = outward_of(rod, end)
        lowest, node = math.inf, -1
        for k in range(c.node_start[s], c.node_start[s + 1]):
            height = dot(n, node_place(model, k))
            if height < lowest:
                lowest, node = height, k
        separation = lowest - dot(n, center_of(rod, end))
        if separation > best.separation:
            best = Flat(separation, end, node, 1)
    return best


@kernel
def edge_by_side(rod: Rod, edge: int, start: Vector, f: Vector, m1: Vector, m2: Vector) -> Curves:
    """Separation of an edge between faces with normals m1 and m2 from the side of a rod, where their normals meet."""
    nothing = Curves(-math.inf, NO_CURVES, -1, 0, 1.0, 1.0)
    n = cross(f, rod.axis)
    if norm(n) > NEARLY_PARALLEL * norm(f):
        if dot(m1, rod.axis) * dot(m2, rod.axis) >= 0.0 or not cross_within(apart_from(start, rod.start), f, rod):
            return nothing
        sense = 1.0 if dot(n, added(m1, m2)) > 0.0 else -1.0
        n = scaled(sense / norm(n), n)
        return Curves(dot(n, apart_from(rod.start, start)) - rod.radius, SIDE_ACROSS, edge, 0, 1.0, -sense)
    middle = added(start, scaled(0.5, f))
    away = apart_from(rod.start, middle)
    away = apart_from(away, scaled(dot(away, rod.axis), rod.axis))
    cosine = dot(m1, m2)
    if dot(away, apart_from(m1, scaled(cosine, m2))) < 0.0 or dot(away, apart_from(m2, scaled(cosine, m1))) < 0.0:
        return nothing
    return Curves(norm(away) - rod.radius, SIDE_ALONG, edge, 0, 1.0, 1.0)


@kernel
def edge_by_rim(
    rod: Rod, end: int, edge: int, start: Vector, f: Vector, m1: Vector, m2: Vector, margin: float
) -> Curves:  # fmt: skip
    """The same of a rim of the rod."""
    best = Curves(-math.inf, NO_CURVES, -1, 0, 1.0, 1.0)
    away = apart_from(center_of(rod, end), start)
    apart = apart_from(away, scaled(dot(away, f) / dot(f, f), f))
    if norm(apart) > rod.radius + margin:
        return best
    outward = outward_of(rod, end)
    found = nearest_on_rim(rod.axis, rod.radius, f, away)
    for number in range(2 if found.two else 1):
        place = found.first if number == 0 else found.second
        c = towards(found, place)
        tau = cross(rod.axis, c)
        n = cross(f, tau)
        if norm(n) <= NEARLY_PARALLEL * norm(f) or dot(m1, tau) * dot(m2, tau) >= 0.0:
            continue
        n = scaled((1.0 if dot(n, added(m1, m2)) > 0.0 else -1.0) / norm(n), n)
        to = added(away, scaled(rod.radius, c))
        s = dot(f, to) / dot(f, f)
        if dot(n, outward) > 0.0 or dot(n, c) > 0.0 or s <= END or s >= 1.0 - END:
            continue
        separation = dot(n, to)
        best = larger(best, Curves(separation, ON_RIM, edge, end, half_of(found, place[0]), 1.0))
    return best


@kernel
def supports(model: SpatialModel, s: int, n: Vector, height: float) -> bool:
    """Whether no vertex of polyhedron s is higher along n than that of the ``height``, to rounding."""
    c = model.contacts
    highest = height
    for k in range(c.node_start[s], c.node_start[s + 1]):
        highest = max(highest, dot(n, node_place(model, k)))
    return highest <= height + 1e-12 * c.surface_extent[s]


@kernel
def vertices_by_rod(model: SpatialModel, s: int, rod: Rod, least: float, size: float) -> Curves:
    """Of polyhedron s the vertex whose normal is that of the side of a rod, or of a rim that it is away from.

    least: that separations smaller than that are not looked at [m].
    """
    c = model.contacts
    best = Curves(least, NO_CURVES, -1, 0, 1.0, 1.0)
    for k in range(c.node_start[s], c.node_start[s + 1]):
        place = node_place(model, k)
        z, p, r = radial(rod.axis, apart_from(place, rod.start))
        above = max(-z, z - rod.length)
        if above > 0.0 and r > rod.radius:
            separation, end = math.hypot(above, r - rod.radius), 0 if z < 0.0 else 1
            away = added(scaled(above, outward_of(rod, end)), scaled((r - rod.radius) / r, p))
            found = separation > SHALLOW * size
        else:
            separation, end, away = r - rod.radius, -1, p
            found = above <= 0.0 and r > 0.0
        if found and separation > best.separation:
            n = scaled(-1.0 / norm(away), away)
            if supports(model, s, n, dot(n, place)):
                best = Curves(separation, VERTEX, k, end, 1.0, 1.0)
    return best


@kernel
def curves_of_polyhedron(model: SpatialModel, s: int, rod: Rod, margin: float, size: float) -> Curves:
    """Edges and vertices of polyhedron s with the side and the rims of a rod in its frame."""
    c = model.contacts
    best = Curves(-math.inf, NO_CURVES, -1, 0, 1.0, 1.0)
    for i in range(c.ridge_start[s], c.ridge_start[s + 1]):
        m1, m2 = polygon_normal(model, c.ridge_polygon[i, 0]), polygon_normal(model, c.ridge_polygon[i, 1])
        start, f = ends_of(model, c.ridge_edge[i])
        best = larger(best, edge_by_side(rod, c.ridge_edge[i], start, f, m1, m2))
        for end in range(2):
            best = larger(best, edge_by_rim(rod, end, c.ridge_edge[i], start, f, m1, m2, margin))
    return larger(best, vertices_by_rod(model, s, rod, best.separation, size))


@kernel
def lay_flat(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, s: int,
    flat: Flat, thin: float, size: float, n: int,
) -> tuple[int, bool, bool]:  # fmt: skip
    """Entries that a face or end makes, from entry n on; the new count, if any place is over it, and if all are.

    All: the bodies touch there alone, if they do: the lowest place is over it, or faces are nearly parallel.
    """
    frame = frame_of(model.bodies, q, model.contacts.surface_body[s])
    if flat.own == 1:
        normal = outward_of(rod, flat.at)
        g, cosine = incident_face(model, flat.node, normal)
        n, found = lay_end_on_face(model, q, margin, table, law, frame, rod, flat.at, g, thin, size, n)
        over = over_disc(set_disc(rod, flat.at), node_place(model, flat.node), thin)
        return n, found, found and (over or cosine > FLAT_FROM)
    normal = polygon_normal(model, flat.at)
    end = 0 if dot(rod.axis, normal) > 0.0 else 1
    if is_along(rod, normal):
        n, found = lay_end_on_face(model, q, margin, table, law, frame, rod, end, flat.at, thin, size, n)
    elif is_across(rod, normal):
        n, found = lay_on_face(model, q, margin, table, law, rod, flat.at, thin, n)
    else:
        place = lowest_at(rod, end, normal)
        n, found = lay_end_of_rod(model, q, margin, table, law, rod, end, place, flat.at, thin, n)
    return n, found, found


@kernel
def lay_curves(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, law: int, rod: Rod, s: int,
    curves: Curves, thin: float, n: int,
) -> tuple[int, bool]:  # fmt: skip
    """The entries of an edge or vertex of polyhedron s with the side or a rim of a rod, from entry n on; the same."""
    if curves.kind == SIDE_ALONG:
        return lay_along_edge(model, q, margin, table, law, rod, s, curves.edge, thin, n)
    if n < len(table.key):
        if curves.kind == SIDE_ACROSS:
            load_edge_by_side(model, table, n, law, curves.edge, side_of_rod(rod), curves.sense)
        elif curves.kind == VERTEX:
            kind, part = (NODE_SIDE, SIDE_OF) if curves.end < 0 else (NODE_RIM, curves.end)
            load_by_cylinder(model, table, n, law, kind, curves.edge, rod.first, part)
            table.facing[n] = -math.inf
        else:
            load_edge_by_rim(model, table, n, law, curves.edge, rod.first, curves.end, curves.half)
        locate(model, q, table, n)
    return n + 1, True


@late_kernel
def cylinder_touches(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of cylinder a and the convex polyhedron b with gaps up to ``margin``, from entry n on; the count."""
    c = model.contacts
    rod = rod_of(model, q, a, frame_of(model.bodies, q, c.surface_body[b]))
    of_face = flat_of_polyhedron(model, b, rod, margin)
    if of_face.separation > margin:
        return n
    of_end = flat_of_rod(model, b, rod)
    size = 2.0 * min(c.surface_extent[a], c.surface_extent[b])
    on_plane = table.seams == 1 and abs(of_face.separation) <= ROUNDED * size
    if on_plane and rod_beyond_edge(model, b, rod, of_face.at, ROUNDED * size):
        return n
    thin = THIN * size
    flat = of_end if of_end.separation > of_face.separation + TIE * size else of_face
    if flat.separation > margin:
        return n
    if flat.separation > -DEEP * size:
        count, _, enough = lay_flat(model, q, margin, table, law, rod, b, flat, thin, size, n)
        if enough:
            return count
    curves = curves_of_polyhedron(model, b, rod, margin, size)
    if curves.separation > margin:
        return n
    if decides(curves, flat, size):
        count, found = lay_curves(model, q, margin, table, law, rod, b, curves, thin, n)
        if found:
            return count
    count, found, _ = lay_flat(model, q, margin, table, law, rod, b, flat, thin, size, n)
    if not found and curves.separation > flat.separation - SHALLOW * size:  # else one of another side of the body
        count, found = lay_curves(model, q, margin, table, law, rod, b, curves, thin, n)
    return count
