"""What the nodes of one surface of space have with the features of another.

An entry of the table is one pair of features with its gap, normal and foot; what depends on the configuration is
renewed by :func:`lcpflex.contact.spatial.pairs.refresh`, with the features kept.
"""

from __future__ import annotations

from lcpflex.bodies.spatial.surface import BORE, CONVEX, CYLINDER, EDGES, FACES, MESHES, PIN, RIM_POINTS, TWO_SIDED
from lcpflex.contact.spatial.bounds import plane_vector, set_over_plane
from lcpflex.contact.spatial.cylinder_edge_pass import edges_on_cylinder
from lcpflex.contact.spatial.cylinder_pass import nodes_on_cylinder
from lcpflex.contact.spatial.edge_pass import edges_on_edges
from lcpflex.contact.spatial.entries import load_node, load_rim
from lcpflex.contact.spatial.faces.detection import faces_touch
from lcpflex.contact.spatial.faces.round_means import are_spread, radius_over
from lcpflex.contact.spatial.kinds import PLANE, POINT, RIM
from lcpflex.contact.spatial.manifold.cylinder_on_hull import cylinder_touches
from lcpflex.contact.spatial.manifold.cylinders import cylinders_touch
from lcpflex.contact.spatial.manifold.hulls import APART, polyhedra_touch
from lcpflex.contact.spatial.mesh_detection import meshes_touch
from lcpflex.contact.spatial.narrow_phase.rim import FLAT, lowest_on_rim, rim_axis
from lcpflex.contact.spatial.narrow_phase.sides import frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.node_pass import nodes_on_features
from lcpflex.contact.spatial.node_shifts import moved_place, shift_nodes
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import NODE_EDGE, NODE_FACET, NODE_POINT, SpatialContactTable
from lcpflex.contact.spatial.twice import drop_twice
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import point_place
from lcpflex.kinematics.spatial.vectors import NOTHING, apart_from, dot, norm, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect_pass", "nearest_features"]

FLUSH = 1e-9  # of the length of a pin or bore: how far beyond its end others are within it
STANDING = 1e-2  # up to which fixed points of its rim join the lowest one


@kernel
def nodes_over_plane(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, begin: int, end: int, law: int,
    b: int, moved: bool, n: int,
) -> int:  # fmt: skip
    """Contacts of the nodes begin..end with the plane b, from entry n on; returns the new count.

    moved: they are all of a surface, and ``table.shift`` holds their displacements.
    """
    c = model.contacts
    body = frame_of(model.bodies, q, model.points.body[c.node_point[begin]])
    normal, o = plane_vector(table, b, 0), plane_vector(table, b, 3)
    for node in range(begin, end):
        p = c.node_point[node]
        s = (
            moved_place(model.points, table, p, node - begin, end - begin)
            if moved
            else place_in(model.points, q, body, p)
        )
        away = apart_from(world_place(body, s), o)
        if dot(normal, away) - c.node_radius[node] <= margin:
            if n < len(table.key):
                load_node(model, table, n, law, NODE_FACET, node, c.feature_start[b])
                set_over_plane(table, n, b, away, c.node_radius[node])
            n += 1
    return n


@kernel
def nodes_on_sphere(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes of surface a with the sphere or hole b, from entry n on; returns the new count."""
    c = model.contacts
    f = c.feature_start[b]
    radius = c.feature_radius[f]
    sense = 1.0 if radius >= 0.0 else -1.0
    o = point_place(model.bodies, model.points, q, c.feature_point[f, 0])
    begin, end = c.node_start[a], c.node_start[a + 1]
    moved = shift_nodes(model, q, table, a)
    body = frame_of(model.bodies, q, c.surface_body[a])
    spread = are_spread(model, a)
    for node in range(begin, end):
        p = c.node_point[node]
        s = (
            moved_place(model.points, table, p, node - begin, end - begin)
            if moved
            else place_in(model.points, q, body, p)
        )
        d = apart_from(world_place(body, s), o)
        away, own = norm(d), c.node_radius[node]
        if spread and away > 0.0:
            own = radius_over(model, body, node, scaled(1.0 / away, d), NOTHING, radius)
        if sense * away - radius - own <= margin:
            if n < len(table.key):
                load_node(model, table, n, law, NODE_POINT, node, f)
                table.radius[n, 0] = own
                locate(model, q, table, n)
            n += 1
    return n


@kernel
def nodes_in_bore(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of nodes in the bore b, or of the ends of the bore a around the pin b; returns the new count.

    Of a pin and a bore those ends touch that are within the other: flush ones, to rounding, are in any case.
    """
    c = model.contacts
    f = c.feature_start[b]
    frame, body = frame_of(model.bodies, q, c.surface_body[b]), frame_of(model.bodies, q, c.surface_body[a])
    start = place_in(model.points, q, frame, c.feature_point[f, 0])
    e = apart_from(place_in(model.points, q, frame, c.feature_point[f, 1]), start)
    square, beside = dot(e, e), FLUSH * norm(e) * norm(e)
    for node in range(c.node_start[a], c.node_start[a + 1]):
        d = apart_from(seen_from(frame, world_place(body, place_in(model.points, q, body, c.node_point[node]))), start)
        along = dot(d, e)
        if along < -beside or along > square + beside:
            continue
        y = apart_from(d, scaled(along / square, e))
        if -norm(y) - c.node_radius[node] - c.feature_radius[f] <= margin:
            if n < len(table.key):
                load_node(model, table, n, law, NODE_EDGE, node, f)
                locate(model, q, table, n)
            n += 1
    return n


@kernel
def rims_on_plane(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the rims of cylinder a with the plane b, from entry n on; returns the new count.

    The lowest point of a rim tells its gap exactly, while the tilt tells where that is. Fixed points of the rim, which
    are above it or as low, join it at small tilts, and are alone where there is none: one point holds no disc that
    stands. They come and go above the lowest point, so that the least gap has no jump but RIM_POINTS make of FLAT.
    """
    c = model.contacts
    f = c.feature_start[b]
    normal, o = plane_vector(table, b, 0), plane_vector(table, b, 3)
    body = frame_of(model.bodies, q, c.surface_body[a])
    first = c.feature_start[a]
    for rim in range(first, c.feature_start[a + 1]):
        if c.feature_kind[rim] != RIM:
            break
        axis = rim_axis(model.points, q, body, c.feature_point[rim, 0], c.feature_point[rim, 1])
        lowest, tilt = lowest_on_rim(axis, normal)
        center = world_place(body, place_in(model.points, q, body, c.feature_point[rim, 0]))
        gap = dot(normal, apart_from(center, o)) + c.feature_radius[rim] * dot(normal, lowest)
        if gap > margin:
            continue
        if tilt > FLAT:
            if n < len(table.key):
                load_rim(model, table, n, law, rim, f)
                locate(model, q, table, n)
            n += 1
        if tilt < STANDING:
            node = c.node_start[a] + (rim - first) * RIM_POINTS
            n = nodes_over_plane(model, q, margin, table, node, node + RIM_POINTS, law, b, False, n)
    return n


@kernel
def nearest_features(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, mode: int,
    n: int,
) -> int:  # fmt: skip
    """Contacts of the nodes of both surfaces with the other one, those of b in this ``mode``, and of their edges."""
    before = n
    n = nodes_on_features(model, q, margin, table, a, b, law, TWO_SIDED, n)
    start = n
    n = nodes_on_features(model, q, margin, table, b, a, law, mode, n)
    if start < n <= len(table.key):
        n = drop_twice(model, q, table, b, a, before, start, n)
    return edges_on_edges(model, q, margin, table, a, b, law, n)


@kernel
def bodies_touch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of two convex bodies, cylinders first, from entry n on; the new count."""
    kind = model.contacts.surface_kind
    if kind[a] != CYLINDER:
        count = polyhedra_touch(model, q, margin, table, a, b, law, n)
        return nearest_features(model, q, margin, table, a, b, law, TWO_SIDED, n) if count == APART else count
    if kind[b] != CYLINDER:
        return cylinder_touches(model, q, margin, table, a, b, law, n)
    return cylinders_touch(model, q, margin, table, a, b, law, n)


@kernel
def detect_pass(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, mode: int,
    n: int,
) -> int:  # fmt: skip
    """Contacts of the nodes, rims or edges of surface a with the features of b, from entry n on; the new count."""
    c = model.contacts
    if mode == CONVEX:
        return bodies_touch(model, q, margin, table, a, b, law, n)
    if mode == FACES:
        return faces_touch(model, q, margin, table, a, b, law, n)
    if mode == MESHES:
        return meshes_touch(model, q, margin, table, a, b, law, n)
    if mode == EDGES and c.feature_kind[c.feature_start[b]] == RIM:
        return edges_on_cylinder(model, q, margin, table, a, b, law, n)
    if mode == EDGES:
        return edges_on_edges(model, q, margin, table, a, b, law, n)
    first = c.feature_start[b]
    if c.feature_kind[first] == PLANE:
        if c.feature_start[a + 1] > c.feature_start[a] and c.feature_kind[c.feature_start[a]] == RIM:
            return rims_on_plane(model, q, margin, table, a, b, law, n)
        moved = shift_nodes(model, q, table, a)
        return nodes_over_plane(model, q, margin, table, c.node_start[a], c.node_start[a + 1], law, b, moved, n)
    if c.surface_kind[b] == PIN or c.surface_kind[b] == BORE:
        return nodes_in_bore(model, q, margin, table, a, b, law, n)
    if c.feature_kind[first] == POINT:
        return nodes_on_sphere(model, q, margin, table, a, b, law, n)
    if c.feature_kind[first] == RIM:
        return nodes_on_cylinder(model, q, margin, table, a, b, law, n)
    return nodes_on_features(model, q, margin, table, a, b, law, mode, n)
