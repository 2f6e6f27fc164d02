"""What of each body touches in a contact pair in space, and the lever from there to the place of contact.

What touches is a mean of material points. The lever l is -rho n of a node (sphere) or edge of body i with radius rho,
R c - rho n of a rim, and R n of a sphere, capsule or bore of body j; of a cylinder, the whole way from where it begins.
"""

from __future__ import annotations

from lcpflex.contact.spatial.narrow_phase.cylinder import cylinder_lever, start_of
from lcpflex.contact.spatial.narrow_phase.rim import place_on_rim
from lcpflex.contact.spatial.narrow_phase.rims import rims_lever
from lcpflex.contact.spatial.narrow_phase.sides import Frame, Mean, frame_of, single
from lcpflex.contact.spatial.table import (
    EDGE_EDGE,
    EDGE_FACET,
    NODE_EDGE,
    NODE_FACET,
    NODE_POINT,
    RIM_FACET,
    RIM_RIM,
    SpatialContactTable,
    by_cylinder,
    with_edge,
)
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import apart_from, scaled
from lcpflex.model.spatial import SpatialModel, SpatialPoints

__all__ = ["lever_on_i", "lever_on_j", "mean_on_i", "mean_on_j", "radius_of_j"]


@kernel
def mean_on_i(table: SpatialContactTable, k: int) -> Mean:
    """What of body i touches in entry k: a node, the foot on its edge, or the centre of a rim."""
    p = table.point[k, 0]
    if not with_edge(table, k):
        return single(p)
    s = table.foot[k, 0]
    return Mean(2, p, table.point[k, 1], p, (1.0 - s, s, 0.0))


@kernel
def mean_on_j(table: SpatialContactTable, k: int) -> Mean:
    """What of body j is touched in entry k: a foot, a vertex, the centre of a sphere, or where a cylinder begins."""
    kind = table.kind[k]
    if kind == NODE_POINT:
        return single(table.point[k, 1])
    if by_cylinder(table, k):
        return single(start_of(table, k))
    if kind == RIM_RIM:
        return single(table.point[k, 2])
    first = 1 if kind in (NODE_FACET, NODE_EDGE) else 2
    a = table.point[k, first]
    b = table.point[k, first + 1]
    if kind in (NODE_EDGE, EDGE_EDGE, EDGE_FACET):
        s = table.foot[k, 0 if kind == NODE_EDGE else 1]
        return Mean(2, a, b, a, (1.0 - s, s, 0.0))
    x, y = table.foot[k, 0], table.foot[k, 1]
    return Mean(3, a, b, table.point[k, first + 2], (1.0 - x - y, x, y))


@kernel
def lever_on_i(
    points: SpatialPoints, q: FloatArray, frame: Frame, table: SpatialContactTable, k: int, n: Vector
) -> Vector:
    """From there to the place of contact [m], world axes."""
    if table.kind[k] == RIM_RIM:
        return rims_lever(points, q, frame, table, k, 0)
    if table.kind[k] != RIM_FACET:
        return scaled(-table.radius[k, 0], n)
    c, _ = place_on_rim(points, q, frame, table, k, n)
    return apart_from(scaled(table.radius[k, 2], c), scaled(table.radius[k, 0], n))


@kernel
def radius_of_j(table: SpatialContactTable, k: int) -> float:
    """Radius of the feature of body j [m]; facets have none."""
    kind = table.kind[k]
    return 0.0 if kind in (NODE_FACET, RIM_FACET, RIM_RIM) else table.radius[k, 1]


@kernel
def lever_on_j(
    model: SpatialModel, q: FloatArray, frame: Frame, table: SpatialContactTable, k: int, n: Vector
) -> Vector:
    """From what is touched of body j to the place of contact [m], world axes."""
    if by_cylinder(table, k):
        return cylinder_lever(model.points, q, (frame_of(model.bodies, q, table.body[k, 0]), frame), table, k, n)
    if table.kind[k] == RIM_RIM:
        return rims_lever(model.points, q, frame, table, k, 1)
    return scaled(radius_of_j(table, k), n)
