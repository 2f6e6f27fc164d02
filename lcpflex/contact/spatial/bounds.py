"""Where surfaces of space are: spheres about them, undeformed, and how far deformation may carry their points."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.kinds import PLANE
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import point_place
from lcpflex.kinematics.spatial.rotations import Vector, cross, rotation_matrix
from lcpflex.kinematics.spatial.vectors import apart_from, norm, scaled, turned
from lcpflex.model.spatial import N_PLACE, SpatialModel

__all__ = ["above_plane", "bound", "is_plane", "near_surfaces", "plane_at"]


@kernel
def bound(model: SpatialModel, q: FloatArray, table: SpatialContactTable) -> None:
    """Where every surface is as a rigid one, and how far deformation may carry its points."""
    c = model.contacts
    at = model.bodies.place
    for s in range(len(c.surface_body)):
        b = c.surface_body[s]
        center = (c.surface_center[s, 0], c.surface_center[s, 1], c.surface_center[s, 2])
        deflection = 0.0
        if b >= 0:
            p = at[b]
            x, y, z = turned(rotation_matrix(q[p + 3], q[p + 4], q[p + 5], q[p + 6]), center)
            center = (q[p] + x, q[p + 1] + y, q[p + 2] + z)
            for m in range(at[b + 1] - p - N_PLACE):
                deflection += abs(q[p + N_PLACE + m]) * c.surface_deflection[s, m]
        table.bound[s, 0], table.bound[s, 1], table.bound[s, 2] = center
        table.bound[s, 3] = deflection


@kernel
def is_plane(model: SpatialModel, s: int) -> bool:
    """Whether surface s is a plane."""
    first = model.contacts.feature_start[s]
    return first < model.contacts.feature_start[s + 1] and model.contacts.feature_kind[first] == PLANE


@kernel
def plane_at(model: SpatialModel, q: FloatArray, s: int) -> tuple[Vector, Vector]:
    """Unit normal of the plane s, and a point of it [m]; world axes."""
    f = model.contacts.feature_start[s]
    points = model.contacts.feature_point
    o = point_place(model.bodies, model.points, q, points[f, 0])
    first = apart_from(point_place(model.bodies, model.points, q, points[f, 1]), o)
    second = apart_from(point_place(model.bodies, model.points, q, points[f, 2]), o)
    n = cross(first, second)
    return scaled(1.0 / norm(n), n), o


@kernel
def above_plane(model: SpatialModel, q: FloatArray, table: SpatialContactTable, a: int, b: int) -> float:
    """How far the centre of surface a is above the plane b [m]."""
    n, o = plane_at(model, q, b)
    at = table.bound
    return n[0] * (at[a, 0] - o[0]) + n[1] * (at[a, 1] - o[1]) + n[2] * (at[a, 2] - o[2])


@kernel
def near_surfaces(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, a: int, b: int, margin: float
) -> bool:
    """Whether nodes of surface a may be within ``margin`` [m] of surface b, or below it, as far as spheres tell."""
    extent = model.contacts.surface_extent
    at = table.bound
    reach = extent[a] + at[a, 3] + at[b, 3] + margin
    if extent[b] < math.inf:
        reach += extent[b]
        dx, dy, dz = at[a, 0] - at[b, 0], at[a, 1] - at[b, 1], at[a, 2] - at[b, 2]
        return not dx * dx + dy * dy + dz * dz > reach * reach
    return not is_plane(model, b) or not above_plane(model, q, table, a, b) > reach
