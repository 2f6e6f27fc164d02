"""What the nodes of one surface of space have with the features of another.

An entry of the table is one pair of features with its gap, normal and foot; what depends on the configuration is
renewed by :func:`lcpflex.contact.spatial.pairs.refresh`, with the features kept.
"""

from __future__ import annotations

from lcpflex.contact.spatial.bounds import is_plane, plane_at
from lcpflex.contact.spatial.pairs import refresh
from lcpflex.contact.spatial.table import NODE_FACET, NODE_POINT, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import point_place
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, rotation_matrix
from lcpflex.kinematics.spatial.vectors import apart_from, dot, norm
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect_pass"]


@kernel
def load_node(model: SpatialModel, table: SpatialContactTable, k: int, law: int, kind: int, node: int, f: int) -> None:
    """Entry k, of a node with a feature: what does not depend on the configuration."""
    c = model.contacts
    table.key[k] = node * len(c.feature_kind) + f
    table.law[k] = law
    table.kind[k] = kind
    table.node[k] = c.node_point[node]
    table.point[k, 0] = c.node_point[node]
    for v in range(3):
        table.point[k, 1 + v] = c.feature_point[f, v]
    table.point[k, 4] = c.feature_point[f, 0]
    table.radius[k, 0] = c.node_radius[node]
    table.radius[k, 1] = c.feature_radius[f]
    table.radius[k, 2] = 0.0
    table.sense[k] = 1.0 if c.feature_radius[f] >= 0.0 else -1.0
    table.foot[k, 0] = 0.0
    table.foot[k, 1] = 0.0
    table.body[k, 0] = model.points.body[c.node_point[node]]
    table.body[k, 1] = model.points.body[c.feature_point[f, 0]]
    table.along[k] = -1


@kernel
def axes_of_body(model: SpatialModel, q: FloatArray, body: int) -> Matrix:
    """A of a body; world axes of the ground."""
    if body < 0:
        return 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    p = model.bodies.place[body]
    return rotation_matrix(q[p + 3], q[p + 4], q[p + 5], q[p + 6])


@kernel
def axis_across(A: Matrix, n: Vector) -> int:
    """Which column of A is the farthest from the direction n: a tangent is its projection."""
    x = abs(A[0] * n[0] + A[3] * n[1] + A[6] * n[2])
    y = abs(A[1] * n[0] + A[4] * n[1] + A[7] * n[2])
    z = abs(A[2] * n[0] + A[5] * n[1] + A[8] * n[2])
    if x <= y and x <= z:
        return 0
    return 1 if y <= z else 2


@kernel
def nodes_on_plane(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes of surface a with the plane b, from entry n on; returns the new count."""
    c = model.contacts
    f = c.feature_start[b]
    normal, o = plane_at(model, q, b)
    for node in range(c.node_start[a], c.node_start[a + 1]):
        place = point_place(model.bodies, model.points, q, c.node_point[node])
        gap = dot(normal, apart_from(place, o)) - c.node_radius[node]
        if gap <= margin:
            if n < len(table.key):
                load_node(model, table, n, law, NODE_FACET, node, f)
                table.gap[n] = gap
                refresh(model, q, table, n)
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
    for node in range(c.node_start[a], c.node_start[a + 1]):
        d = apart_from(point_place(model.bodies, model.points, q, c.node_point[node]), o)
        gap = sense * norm(d) - radius - c.node_radius[node]
        if gap <= margin:
            if n < len(table.key):
                load_node(model, table, n, law, NODE_POINT, node, f)
                table.gap[n] = gap
                table.along[n] = axis_across(axes_of_body(model, q, table.body[n, 1]), d)
                refresh(model, q, table, n)
            n += 1
    return n


@kernel
def detect_pass(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes of surface a with the features of b, from entry n on; returns the new count."""
    if is_plane(model, b):
        return nodes_on_plane(model, q, margin, table, a, b, law, n)
    return nodes_on_sphere(model, q, margin, table, a, b, law, n)
