"""A node P, a sphere of radius rho, over the plane through three material points a, b, c: a facet, or without end.

    e_1 = r_b - r_a, e_2 = r_c - r_a,   n = e_1 x e_2 / |.|,   D = n.(r_P - r_a),   g = D - rho
    ndot = -(n.edot_a) e^a,   xi^a = e^a.(r_P - r_a),   xidot^a = e^a.(dv - D ndot)

with the dual basis e^a and dv = v_P - v_Q, Q being the foot r_a + xi^a e_a.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.narrow_phase.sides import (
    Frame,
    Motion,
    is_rigid,
    place_in,
    seen_from,
    three_places,
    three_sums,
    world_place,
)
from lcpflex.contact.spatial.narrow_phase.turning import Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialPoints

__all__ = [
    "Plane",
    "PlaneTurn",
    "plane_of",
    "plane_slip",
    "plane_turn",
    "refresh_facet",
    "refresh_over_ground",
    "set_over",
]


class Plane(NamedTuple):
    """Through three points, in the frame of their body."""

    a: Vector  # [m]
    e1: Vector
    e2: Vector
    n: Vector
    area: float  # |e_1 x e_2| [m^2]


class PlaneTurn(NamedTuple):
    """Dual basis of two edges, their rates, and how the normal and t1 = e_1/|e_1| turn; world axes."""

    dual1: Vector
    dual2: Vector
    rate1: Vector
    rate2: Vector
    ndot: Vector  # [1/s]
    spin: float  # [rad/s]


@kernel
def plane_of(points: SpatialPoints, q: FloatArray, frame: Frame, a: int, b: int, c: int) -> Plane:
    """Through the material points a, b, c."""
    start, second, third = three_places(points, q, frame, a, b, c)
    e1, e2 = apart_from(second, start), apart_from(third, start)
    n = cross(e1, e2)
    area = norm(n)
    return Plane(start, e1, e2, scaled(1.0 / area, n), area)


@kernel
def set_over(table: SpatialContactTable, k: int, frame: Frame, plane: Plane, r: Vector, radius: float) -> None:
    """Entry k becomes that of a sphere about r, world axes, over the plane."""
    d = apart_from(seen_from(frame, r), plane.a)
    table.foot[k, 0] = dot(d, cross(plane.e2, plane.n)) / plane.area
    table.foot[k, 1] = dot(d, cross(plane.n, plane.e1)) / plane.area
    t = turned(frame.A, scaled(1.0 / norm(plane.e1), plane.e1))
    set_entry(table, k, dot(plane.n, d) - radius, turned(frame.A, plane.n), t)


@kernel
def refresh_facet(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and foot of entry k; the foot may leave the facet."""
    r = world_place(i, place_in(points, q, i, table.point[k, 0]))
    plane = plane_of(points, q, j, table.point[k, 1], table.point[k, 2], table.point[k, 3])
    set_over(table, k, j, plane, r, table.radius[k, 0])


@kernel
def refresh_over_ground(points: SpatialPoints, q: FloatArray, i: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap and foot of entry k over a facet or plane of the ground, whose normal and tangent stay."""
    a = row_vector(points.place, table.point[k, 1])
    e1 = apart_from(row_vector(points.place, table.point[k, 2]), a)
    e2 = apart_from(row_vector(points.place, table.point[k, 3]), a)
    n = row_vector(table.normal, k)
    d = apart_from(world_place(i, place_in(points, q, i, table.point[k, 0])), a)
    first, second = cross(e2, n), cross(n, e1)
    table.foot[k, 0] = dot(d, first) / dot(e1, first)
    table.foot[k, 1] = dot(d, second) / dot(e2, second)
    table.gap[k] = dot(n, d) - table.radius[k, 0]


@kernel
def plane_turn(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, a: int, b: int, c: int,
    n: Vector, t: Vector,
) -> PlaneTurn:  # fmt: skip
    """Of the plane through a, b, c with normal n and first tangent t.

    In a rigid body any two edges serve: t1 and t2 are their own dual basis.
    """
    w = cross(n, t)
    if is_rigid(points, a):
        omega = turned(frame.A, motion.omega)
        return PlaneTurn(t, w, cross(omega, t), cross(omega, w), cross(omega, n), dot(omega, n))
    start, end1, end2 = three_places(points, q, frame, a, b, c)
    v, v1, v2 = three_sums(points, a, b, c, u, motion.modal)
    first, second = apart_from(end1, start), apart_from(end2, start)
    rate1 = turned(frame.A, added(cross(motion.omega, first), apart_from(v1, v)))
    rate2 = turned(frame.A, added(cross(motion.omega, second), apart_from(v2, v)))
    e1, e2 = turned(frame.A, first), turned(frame.A, second)
    inverse = 1.0 / norm(cross(e1, e2))
    dual1 = scaled(inverse, cross(e2, n))
    dual2 = scaled(inverse, cross(n, e1))
    ndot = added(scaled(-dot(n, rate1), dual1), scaled(-dot(n, rate2), dual2))
    return PlaneTurn(dual1, dual2, rate1, rate2, ndot, dot(w, rate1) / norm(e1))


@kernel
def plane_slip(turn: PlaneTurn, dv: Vector, D: float) -> Turning:
    """Of a point that moves with dv past its foot and D above it."""
    away = apart_from(dv, scaled(D, turn.ndot))
    slip = added(scaled(-dot(turn.dual1, away), turn.rate1), scaled(-dot(turn.dual2, away), turn.rate2))
    return Turning(turn.ndot, turn.spin, slip, 0.0, 0.0)
