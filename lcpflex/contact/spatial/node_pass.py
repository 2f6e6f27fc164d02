"""What the nodes of one surface have with facets, edges and vertices of another: candidates, and of these the contacts.

A node is a material point with a radius. The nearest feature tells whether it is in the solid, and which is the way
out: a node below a facet has no contact with that if another feature is nearer, or another facet, below which it is,
too; but those of a hollow hold it together. Of two facets that face alike, the one that owns it counts before one that
it is beside, within the band of two meshes.
"""

from __future__ import annotations

import math

from lcpflex.bodies.spatial.surface import ALL_FEATURES, CORNERS, NO_POINTS
from lcpflex.contact.spatial.bounds import is_beside_box
from lcpflex.contact.spatial.entries import load_node
from lcpflex.contact.spatial.faces.round_means import are_spread, keep_over_round
from lcpflex.contact.spatial.kinds import EDGE, FACET, POINT
from lcpflex.contact.spatial.mesh_pairs import BLUNT, DEEP, TURNED, are_meshes, band_between, deforms
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.ownership import corners_of, facet_normal, over
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import NODE_EDGE, NODE_FACET, NODE_POINT, SpatialContactTable, copy_entry
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import apart_from, dot, row_vector, turned, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["THIN", "nodes_on_features"]

THIN = 1e-9  # of the extent of a surface: planes between features are so thick
SAME = 1e-9  # two facets whose normals differ by less are one
ALIKE = math.cos(TILT)  # between the normals of facets that face alike
FACING = 1e-9  # a node whose own outward normal has a larger component along that of a feature cannot touch it
BARRED = -2  # instead of an axis: a node above a feature that it cannot touch; so it is outside


@kernel
def is_hollow(model: SpatialModel, q: FloatArray, frame: Frame, f: int, g: int, thin: float) -> bool:
    """Whether facets f and g face each other: the middle of one is above the other."""
    at, of = corners_of(model, q, frame, f), corners_of(model, q, frame, g)
    d = (
        (of.a[0] + of.b[0] + of.c[0] - at.a[0] - at.b[0] - at.c[0]) / 3.0,
        (of.a[1] + of.b[1] + of.c[1] - at.a[1] - at.b[1] - at.c[1]) / 3.0,
        (of.a[2] + of.b[2] + of.c[2] - at.a[2] - at.b[2] - at.c[2]) / 3.0,
    )
    return dot(facet_normal(at), d) > thin and dot(facet_normal(of), d) < -thin


@kernel
def touch_each_other(model: SpatialModel, f: int, g: int) -> bool:
    """Whether two features share a material point."""
    point = model.contacts.feature_point
    for k in range(3):
        for m in range(3):
            if point[f, k] == point[g, m]:
                return True
    return False


@kernel
def dominated(
    model: SpatialModel, q: FloatArray, frame: Frame, table: SpatialContactTable, k: int, i: int, thin: float,
    deep: float,
) -> bool:  # fmt: skip
    """Whether what a node has with the feature of candidate k is no contact because of what it has with that of i.

    ``gap`` of candidates is that of the centre of the node, ``normal`` in the frame of the features; the first number
    of their ``foot`` tells how far the node is beside a facet that has it by its band. Being outside takes a node from
    facets below which it is more than ``deep``: beside the rim of a flush face it is above the side.
    """
    if i == k or (table.along[i] == BARRED and (table.kind[k] != NODE_FACET or table.gap[k] >= -deep)):
        return False
    count = len(model.contacts.feature_kind)
    f, g = table.key[k] % count, table.key[i] % count
    d, e = table.gap[k], table.gap[i]
    beside, other = table.foot[k, 0], table.foot[i, 0]
    if table.kind[k] != NODE_FACET:
        return table.kind[i] == NODE_FACET and (e >= -thin or other > 0.0) and touch_each_other(model, f, g)
    if table.kind[i] != NODE_FACET:
        return beside == 0.0 and d < -thin and e < -d
    n, m = row_vector(table.normal, k), row_vector(table.normal, i)
    if beside != other and dot(n, m) > ALIKE:
        return other < beside
    away = apart_from(n, m)
    if dot(away, away) <= SAME * SAME and abs(d - e) <= thin:
        return i < k
    if d > thin or abs(e) > abs(d) or (abs(e) == abs(d) and i > k):
        return False
    return not is_hollow(model, q, frame, f, g, thin)


@kernel
def keep_contacts(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frame: Frame, first: int, n: int,
    thin: float, deep: float,
) -> int:  # fmt: skip
    """Of the candidates first..n of one node, keep the contacts with gap <= margin; returns the new count."""
    for k in range(first, n):
        if table.along[k] == BARRED:
            continue
        kept = table.gap[k] - table.radius[k, 0] - table.radius[k, 1] <= margin
        if kept and n > first + 1:
            for i in range(first, n):
                if dominated(model, q, frame, table, k, i, thin, deep):
                    kept = False
                    break
        table.along[k] = 1 if kept else 0  # not set yet
    m = first
    for k in range(first, n):
        if table.along[k] == 1:
            copy_entry(table, k, table, m)
            table.along[m] = -1
            x, y, z = turned(frame.A, row_vector(table.normal, m))
            table.normal[m, 0], table.normal[m, 1], table.normal[m, 2] = x, y, z
            locate(model, q, table, m)
            m += 1
    return m


@kernel
def collect(
    model: SpatialModel, q: FloatArray, highest: float, table: SpatialContactTable, frame: Frame, b: int, law: int,
    node: int, place: Vector, m: Vector, facing: float, mode: int, n: int, thin: float, band: float,
) -> int:  # fmt: skip
    """Candidates of one node with the features of surface b, at most ``highest`` above them; returns the new count.

    m: outward normal of the node, in the frame of the features, as its place; ``facing``: how far they face it at
    least. Above what it cannot touch a node is outside of the solid all the same, and is not deep below a facet of its
    far side: so one on the rim of a flush face, which elastic displacements have brought beyond that of the other.
    """
    c = model.contacts
    near = highest + table.bound[b, 3] + max(thin, band)
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        if is_beside_box(model, box, place, place, near):
            box = c.box_skip[box]
            continue
        for at in range(c.box_leaf[box, 0], c.box_leaf[box, 1]):
            f = c.box_feature[at]
            kind = c.feature_kind[f]
            if kind == POINT and mode == NO_POINTS:
                continue
            found = over(model, q, frame, f, place, highest, thin, band)
            length = 1.0 if kind == FACET else found.distance
            least = facing if kind == FACET or length > thin else 0.0
            barred = dot(m, found.away) > (FACING - least) * length
            if not found.owned or (barred and found.distance <= thin):
                continue
            if n < len(table.key):
                chosen = NODE_FACET if kind == FACET else (NODE_EDGE if kind == EDGE else NODE_POINT)
                load_node(model, table, n, law, chosen, node, f)
                table.along[n] = BARRED if barred else -1
                table.facing[n] = least
                table.gap[n] = found.distance
                table.foot[n, 0] = found.beside
                for k in range(3):
                    table.normal[n, k] = found.away[k]
            n += 1
        box += 1
    return n


@kernel
def detect_node(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frame: Frame, b: int, law: int,
    node: int, place: Vector, m: Vector, facing: float, mode: int, n: int, band: float,
) -> int:  # fmt: skip
    """Contacts of one node with surface b, from entry n on; returns the count."""
    thin = THIN * model.contacts.surface_extent[b]
    radius = model.contacts.node_radius[node]
    reach = margin + radius
    first = n
    n = collect(model, q, reach, table, frame, b, law, node, place, m, facing, mode, first, thin, band)
    deepest = 0.0
    for k in range(first, min(n, len(table.key))):
        if table.kind[k] == NODE_FACET:
            deepest = max(deepest, -table.gap[k])
    if deepest > reach:  # whatever is nearer than that decides
        n = collect(model, q, deepest, table, frame, b, law, node, place, m, facing, mode, first, thin, band)
    if first < n <= len(table.key):
        return keep_contacts(model, q, margin, table, frame, first, n, thin, DEEP * band)
    return n


@kernel
def least_facing(model: SpatialModel, node: int, mode: int, slack: float) -> float:
    """Cosine between the outward normal of a node and the reversed one of what it touches, at least.

    In passes of two sides a node touches what its own facets face alone: a node within a flat face would catch the side
    of a body that slides over it. slack: how far those may have turned [rad].
    """
    if mode == ALL_FEATURES:
        return 0.0
    facing = model.contacts.node_facing[node]
    return facing if slack == 0.0 else math.cos(min(math.acos(facing) + slack, 0.5 * math.pi))


@kernel
def nodes_on_features(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, mode: int,
    n: int,
) -> int:  # fmt: skip
    """Contacts of the nodes of surface a with the features of b, from entry n on; returns the new count."""
    c = model.contacts
    of_nodes = frame_of(model.bodies, q, c.surface_body[a])
    frame = frame_of(model.bodies, q, c.surface_body[b])
    center = (c.surface_center[b, 0], c.surface_center[b, 1], c.surface_center[b, 2])
    band = band_between(model, a, b)
    slack = TURNED if are_meshes(model, a, b) and (deforms(model, a) or deforms(model, b)) else 0.0
    reach = c.surface_extent[b] + margin + table.bound[b, 3] + band
    spread = are_spread(model, a)
    for node in range(c.node_start[a], c.node_start[a + 1]):
        if mode == CORNERS and c.node_facing[node] > BLUNT:
            continue
        place = seen_from(frame, world_place(of_nodes, place_in(model.points, q, of_nodes, c.node_point[node])))
        d = apart_from(place, center)
        far = reach + c.node_radius[node]
        if not dot(d, d) > far * far:
            m = turned_back(frame.A, turned(of_nodes.A, row_vector(c.node_normal, node)))
            facing = least_facing(model, node, mode, slack)
            first = n
            n = detect_node(model, q, margin, table, frame, b, law, node, place, m, facing, mode, first, band)
            if spread and first < n <= len(table.key):
                n = keep_over_round(model, q, margin, table, (of_nodes, frame), node, first, n)
    return n
