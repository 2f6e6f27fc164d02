"""Entries of the table as detection makes them: what does not depend on the configuration.

The key is (what touches of surface a, feature of surface b) as one number: nodes come first, then features.
"""

from __future__ import annotations

import math

from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_FACET,
    RIM_FACET,
    RIM_RIM,
    SpatialContactTable,
)
from lcpflex.jit.kernel import kernel
from lcpflex.model.spatial import SpatialModel

__all__ = [
    "load_by_cylinder",
    "load_crossing",
    "load_edge_by_rim",
    "load_edge_by_side",
    "load_edge_on_cap",
    "load_edges",
    "load_node",
    "load_rim",
    "load_rims",
    "load_vertex",
]


@kernel
def load_pair(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, kind: int, touching: int, point: int, f: int
) -> None:
    """Entry k, of what has the number ``touching`` and its first material point with feature f.

    Normal and tangent are some directions: what refresh keeps where there are none.
    """
    c = model.contacts
    table.key[k] = touching * len(c.feature_kind) + f
    table.law[k] = law
    table.kind[k] = kind
    table.node[k] = point
    for v in range(5):
        table.point[k, v] = point
    table.sense[k] = 1.0
    table.weight[k] = 1.0
    table.area[k] = 0.0
    table.averaged[k] = 0
    table.facing[k] = 0.0
    table.foot[k, 0] = 0.0
    table.foot[k, 1] = 0.0
    table.body[k, 0] = model.points.body[point]
    table.body[k, 1] = model.points.body[c.feature_point[f, 0]]
    for v in range(3):
        table.radius[k, v] = 0.0
        table.normal[k, v] = 1.0 if v == 2 else 0.0
        table.tangent[k, v] = 1.0 if v == 0 else 0.0
    table.along[k] = -1


@kernel
def load_node(model: SpatialModel, table: SpatialContactTable, k: int, law: int, kind: int, node: int, f: int) -> None:
    """Entry k, of a node with a facet, plane, edge, vertex or sphere."""
    c = model.contacts
    load_pair(model, table, k, law, kind, node, c.node_point[node], f)
    for v in range(3):
        table.point[k, 1 + v] = c.feature_point[f, v]
    table.radius[k, 0] = c.node_radius[node]
    table.radius[k, 1] = c.feature_radius[f]
    table.sense[k] = -1.0 if c.feature_radius[f] < 0.0 or c.node_radius[node] < 0.0 else 1.0
    load_share(model, table, k, node)


@kernel
def load_share(model: SpatialModel, table: SpatialContactTable, k: int, node: int) -> None:
    """Of entry k the area that the force of a node acts on, and the part of a force law of a face that it has."""
    c = model.contacts
    if len(c.node_area) > 0:
        table.area[k] = c.node_area[node]
        table.weight[k] = c.node_share[node]


@kernel
def load_vertex(model: SpatialModel, table: SpatialContactTable, k: int, law: int, node: int, f: int) -> None:
    """Entry k, of a vertex of a convex polyhedron with a polygon of another: which they are, the manifold has told."""
    load_node(model, table, k, law, NODE_FACET, node, f)
    table.facing[k] = -math.inf


@kernel
def load_edges(model: SpatialModel, table: SpatialContactTable, k: int, law: int, e: int, f: int, sense: float) -> None:
    """Entry k, of two edges; sense: of e x f as the normal."""
    c = model.contacts
    load_pair(model, table, k, law, EDGE_EDGE, len(c.node_point) + e, c.feature_point[e, 0], f)
    for v in range(2):
        table.point[k, v] = c.feature_point[e, v]
        table.point[k, 2 + v] = c.feature_point[f, v]
    table.radius[k, 0] = c.feature_radius[e]
    table.radius[k, 1] = c.feature_radius[f]
    table.sense[k] = sense


@kernel
def load_crossing(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, e: int, f: int, across: int, sense: float
) -> None:
    """Entry k, of two edges that cross over the face of one of them, which has the material point ``across``, too.

    sense: of (line of that edge) x (way to that point) as the normal.
    """
    load_edges(model, table, k, law, e, f, sense)
    table.kind[k] = EDGE_FACET
    table.point[k, 4] = across


@kernel
def load_rim(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, rim: int, f: int, flat: float = 0.0
) -> None:
    """Entry k, of a rim with a plane; ``flat``: the angle of the place that touches where it lies flat; 0: none."""
    c = model.contacts
    load_pair(model, table, k, law, RIM_FACET, len(c.node_point) + rim, c.feature_point[rim, 0], f)
    table.point[k, 1] = c.feature_point[rim, 1]
    for v in range(3):
        table.point[k, 2 + v] = c.feature_point[f, v]
    table.radius[k, 2] = c.feature_radius[rim]
    table.facing[k] = flat


@kernel
def load_by_cylinder(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, kind: int, node: int, first: int, part: int
) -> None:
    """Entry k, of a node with a part of the cylinder whose features begin at ``first``; 0 and 3 are at its start."""
    c = model.contacts
    load_pair(model, table, k, law, kind, node, c.node_point[node], first + part)
    table.point[k, 1] = c.feature_point[first, 0]
    table.point[k, 2] = c.feature_point[first, 1]
    table.radius[k, 0] = c.node_radius[node]
    table.radius[k, 2] = c.feature_radius[first]
    table.sense[k] = -1.0 if part in (0, 3) else 1.0
    load_share(model, table, k, node)


@kernel
def load_edge_by_side(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, e: int, side: int, sense: float
) -> None:
    """Entry k, of an edge with the side of a cylinder; sense: of e x a as the normal."""
    load_edges(model, table, k, law, e, side, sense)
    table.kind[k] = EDGE_SIDE
    table.radius[k, 1] = 0.0
    table.radius[k, 2] = model.contacts.feature_radius[side]


@kernel
def load_edge_by_rim(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, e: int, first: int, end: int, half: float
) -> None:
    """Entry k, of an edge with a rim of the cylinder whose features begin at ``first``, at its end 0 or 1.

    half: of the circle, +1 or -1; the other one has the key of the flat end there.
    """
    load_edges(model, table, k, law, e, first + end if half > 0.0 else first + end + 3, -1.0 if end == 0 else 1.0)
    table.kind[k] = EDGE_RIM
    for v in range(2):
        table.point[k, 2 + v] = model.contacts.feature_point[first, v]
    table.radius[k, 1] = 0.0
    table.radius[k, 2] = model.contacts.feature_radius[first]
    table.foot[k, 1] = half


@kernel
def load_edge_on_cap(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, e: int, first: int, end: int, half: float
) -> None:
    """Entry k, of an edge that leaves (half > 0) or enters the circle about end 0 or 1: with the keys of its rim."""
    load_edge_by_rim(model, table, k, law, e, first, end, half)
    table.kind[k] = EDGE_CAP


@kernel
def load_rims(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, one: int, other: int, first: float, second: float
) -> None:
    """Entry k, of two rims, near places at these angles."""
    c = model.contacts
    load_pair(model, table, k, law, RIM_RIM, len(c.node_point) + one, c.feature_point[one, 0], other)
    for v in range(2):
        table.point[k, v] = c.feature_point[one, v]
        table.point[k, 2 + v] = c.feature_point[other, v]
    table.radius[k, 2] = c.feature_radius[one]
    table.radius[k, 1] = c.feature_radius[other]
    table.foot[k, 0], table.foot[k, 1] = first, second
