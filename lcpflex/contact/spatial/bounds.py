"""Where surfaces of space are: spheres about them, undeformed, and how far deformation may carry their points."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.kinds import PLANE
from lcpflex.contact.spatial.narrow_phase.facet import plane_of
from lcpflex.contact.spatial.narrow_phase.sides import frame_of, world_place
from lcpflex.contact.spatial.narrow_phase.turning import set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross, rotation_matrix
from lcpflex.kinematics.spatial.vectors import dot, norm, scaled, turned
from lcpflex.model.spatial import N_PLACE, SpatialModel

__all__ = ["above_plane", "bound", "is_beside_box", "is_plane", "near_surfaces", "plane_vector", "set_over_plane"]


@kernel
def is_plane(model: SpatialModel, s: int) -> bool:
    """Whether surface s is a plane."""
    first = model.contacts.feature_start[s]
    return first < model.contacts.feature_start[s + 1] and model.contacts.feature_kind[first] == PLANE


@kernel
def bound(model: SpatialModel, q: FloatArray, table: SpatialContactTable) -> None:
    """Where every surface is as a rigid one, planes as such, and how far deformation may carry its points."""
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
        if is_plane(model, s):
            lay_plane(model, q, table, s)


@kernel
def lay_plane(model: SpatialModel, q: FloatArray, table: SpatialContactTable, s: int) -> None:
    """Row s of ``table.plane``; those of the ground stay as they were laid first."""
    row = table.plane[s]
    if model.contacts.surface_body[s] < 0 and (row[0] != 0.0 or row[1] != 0.0 or row[2] != 0.0):
        return
    point = model.contacts.feature_point[model.contacts.feature_start[s]]
    frame = frame_of(model.bodies, q, model.contacts.surface_body[s])
    plane = plane_of(model.points, q, frame, point[0], point[1], point[2])
    larger = 1.0 / plane.area
    keep_vector(row, 0, turned(frame.A, plane.n))
    keep_vector(row, 3, world_place(frame, plane.a))
    keep_vector(row, 6, turned(frame.A, scaled(1.0 / norm(plane.e1), plane.e1)))
    keep_vector(row, 9, turned(frame.A, scaled(larger, cross(plane.e2, plane.n))))
    keep_vector(row, 12, turned(frame.A, scaled(larger, cross(plane.n, plane.e1))))


@kernel
def keep_vector(row: FloatArray, at: int, a: Vector) -> None:
    """Three numbers of a row."""
    row[at], row[at + 1], row[at + 2] = a


@kernel
def plane_vector(table: SpatialContactTable, s: int, at: int) -> Vector:
    """Three numbers of row s of ``table.plane``: of 0 the normal, 3 a point, 6 the first tangent, 9, 12 dual edges."""
    return table.plane[s, at], table.plane[s, at + 1], table.plane[s, at + 2]


@kernel
def set_over_plane(table: SpatialContactTable, k: int, s: int, d: Vector, radius: float) -> None:
    """Entry k becomes that of a sphere, d from the point of plane s, world axes."""
    n = plane_vector(table, s, 0)
    table.foot[k, 0] = dot(d, plane_vector(table, s, 9))
    table.foot[k, 1] = dot(d, plane_vector(table, s, 12))
    set_entry(table, k, dot(n, d) - radius, n, plane_vector(table, s, 6))


@kernel
def above_plane(table: SpatialContactTable, a: int, b: int) -> float:
    """How far the centre of surface a is above the plane b [m]."""
    n, o = plane_vector(table, b, 0), plane_vector(table, b, 3)
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
    return not is_plane(model, b) or not above_plane(table, a, b) > reach


@kernel(inline=True)
def is_beside_box(model: SpatialModel, box: int, start: Vector, end: Vector, near: float) -> bool:
    """Whether a line from ``start`` to ``end``, or a place, both being that, is farther than ``near`` from a box [m].

    As far as its sides tell; all in the frame of the body that has the box.
    """
    sides = model.contacts.box
    beside = False
    for k in range(3):
        low, high = min(start[k], end[k]), max(start[k], end[k])
        if high < sides[box, k] - near or low > sides[box, 3 + k] + near:
            beside = True
    return beside
