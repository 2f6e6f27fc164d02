"""Two rims, circles of radius R_1 about o_1 of body i and R_2 about o_2 of body j; axes a lead into the cylinders.

    X = r_1 + R_1 c_1, K = r_2 + R_2 c_2, tau = a x c,   d = X - K = D n,   tau_1.d = tau_2.d = 0,
    n = +-(tau_1 x tau_2)/|.| out of the cylinder of j,   g = D,   t1 = tau_2

Each is carried rigidly by the material at its o, whose spin is Omega. With c' = Omega x c + phi tau and
w = v_1 + R_1 Omega_1 x c_1 - v_2 - R_2 Omega_2 x c_2 the places slide with

    (R_1 - c_1.d) phi_1 - R_2 (tau_1.tau_2) phi_2 = -tau_1.w - d.(Omega_1 x tau_1),
    R_1 (tau_1.tau_2) phi_1 - (R_2 + c_2.d) phi_2 = -tau_2.w - d.(Omega_2 x tau_2),

and the normal turns as that of two edges along tau_1 and tau_2, with tau' = Omega x tau - phi c. The angles of c_1 and
c_2 from a direction that is fixed in the material are the feet, from which the next ones are found by Newton's method.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.narrow_phase.edges import PARALLEL, TILT
from lcpflex.contact.spatial.narrow_phase.rim import lowest_on_rim, rim_axis, turned_by_material
from lcpflex.contact.spatial.narrow_phase.sides import Frame, Motion, place_in, point_spin, world_place
from lcpflex.contact.spatial.narrow_phase.turning import Turning, set_entry
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, row_vector, scaled
from lcpflex.model.spatial import SpatialPoints

__all__ = [
    "Circle",
    "between",
    "circle_of",
    "nearest_of_rims",
    "on_circle",
    "refresh_rims",
    "rims_lever",
    "rims_margin",
    "rims_motion",
]

PASSES = 40  # of Newton's method, which takes four; it may wander where circles are far from each other


class Circle(NamedTuple):
    """A rim: its middle [m], its axis, a direction across that, and its radius [m]."""

    middle: Vector
    axis: Vector
    u: Vector
    radius: float


@kernel
def circle_of(points: SpatialPoints, q: FloatArray, frame: Frame, o: int, x: int, radius: float) -> Circle:
    """The rim about material point o with another one, x, on its axis; world axes."""
    undeformed = apart_from(row_vector(points.place, x), row_vector(points.place, o))
    across, _ = lowest_on_rim(scaled(1.0 / norm(undeformed), undeformed), NOTHING)
    middle = world_place(frame, place_in(points, q, frame, o))
    return Circle(middle, rim_axis(points, q, frame, o, x), turned_by_material(points, q, frame, o, across), radius)


@kernel
def on_circle(circle: Circle, angle: float) -> tuple[Vector, Vector]:
    """c and tau at an angle."""
    v = cross(circle.axis, circle.u)
    s, c = math.sin(angle), math.cos(angle)
    return added(scaled(c, circle.u), scaled(s, v)), added(scaled(-s, circle.u), scaled(c, v))


@kernel
def between(one: Circle, first: float, other: Circle, second: float) -> Vector:
    """d of two angles [m]."""
    c, _ = on_circle(one, first)
    e, _ = on_circle(other, second)
    return apart_from(added(one.middle, scaled(one.radius, c)), added(other.middle, scaled(other.radius, e)))


@kernel
def nearest_of_rims(one: Circle, other: Circle, first: float, second: float) -> tuple[float, float]:
    """Angles where two circles are nearest to each other, from those of places nearby."""
    R, S = one.radius, other.radius
    for _ in range(PASSES):
        c, tau = on_circle(one, first)
        e, sigma = on_circle(other, second)
        d = between(one, first, other, second)
        slope, tilt = dot(tau, d), -dot(sigma, d)
        t = dot(tau, sigma)
        a, b, s = R - dot(c, d), S + dot(e, d), -t
        least = 1e-3 * min(R, S)  # a minimum, not another place where both slopes are 0
        a, b = max(a, least), max(b, least)
        determinant = a * b - s * s * R * S
        if determinant <= 1e-6 * a * b:
            determinant, s = a * b, 0.0
        on_one = -(b * slope - s * S * tilt) / determinant
        on_other = -(a * tilt - s * R * slope) / determinant
        longest = max(abs(on_one), abs(on_other))
        if longest > 0.5:  # [rad]
            on_one, on_other = on_one * 0.5 / longest, on_other * 0.5 / longest
        first, second = first + on_one, second + on_other
        if longest < 1e-15:
            break
    return first, second


@kernel
def rims_of(
    points: SpatialPoints, q: FloatArray, frames: tuple[Frame, Frame], table: SpatialContactTable, k: int
) -> tuple[Circle, Circle]:
    """Both circles of entry k."""
    point = table.point
    one = circle_of(points, q, frames[0], point[k, 0], point[k, 1], table.radius[k, 2])
    return one, circle_of(points, q, frames[1], point[k, 2], point[k, 3], table.radius[k, 1])


@late_kernel
def refresh_rims(points: SpatialPoints, q: FloatArray, i: Frame, j: Frame, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and feet of entry k; where tangents are parallel, the normal stays."""
    one, other = rims_of(points, q, (i, j), table, k)
    first, second = nearest_of_rims(one, other, table.foot[k, 0], table.foot[k, 1])
    table.foot[k, 0], table.foot[k, 1] = first, second
    d = between(one, first, other, second)
    _, tau = on_circle(one, first)
    e, sigma = on_circle(other, second)
    n = cross(tau, sigma)
    size = norm(n)
    if size <= PARALLEL:
        table.gap[k] = dot(row_vector(table.normal, k), d)
        return
    n = scaled((1.0 if dot(n, apart_from(e, other.axis)) >= 0.0 else -1.0) / size, n)
    set_entry(table, k, dot(n, d), n, sigma)


@kernel
def rims_lever(
    points: SpatialPoints, q: FloatArray, frame: Frame, table: SpatialContactTable, k: int, side: int
) -> Vector:
    """R c of body i (side 0) or j (1) in entry k [m], world axes."""
    radius = table.radius[k, 2 - side]
    circle = circle_of(points, q, frame, table.point[k, 2 * side], table.point[k, 2 * side + 1], radius)
    c, _ = on_circle(circle, table.foot[k, side])
    return scaled(radius, c)


@kernel
def rims_motion(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, dv: Vector,
) -> tuple[Vector, Vector, Turning]:  # fmt: skip
    """What both levers add to v_rel and b_rel, and the turning of entry k; dv = v_1 - v_2."""
    one, other = rims_of(points, q, frames, table, k)
    c, tau = on_circle(one, table.foot[k, 0])
    e, sigma = on_circle(other, table.foot[k, 1])
    R, S, d = one.radius, other.radius, scaled(table.gap[k], n)
    spin, turn = point_spin(points, q, u, frames[0], motions[0], table.point[k, 0])
    spin_j, turn_j = point_spin(points, q, u, frames[1], motions[1], table.point[k, 2])
    v = apart_from(cross(spin, scaled(R, c)), cross(spin_j, scaled(S, e)))
    w, t = added(dv, v), dot(tau, sigma)
    carried, carried_j = cross(spin, tau), cross(spin_j, sigma)
    on_tau, on_sigma = -dot(tau, w) - dot(d, carried), -dot(sigma, w) - dot(d, carried_j)
    determinant = R * S * t * t - (R - dot(c, d)) * (S + dot(e, d))
    phi = (-(S + dot(e, d)) * on_tau + S * t * on_sigma) / determinant
    psi = ((R - dot(c, d)) * on_sigma - R * t * on_tau) / determinant
    rate, rate_j = apart_from(carried, scaled(phi, c)), apart_from(carried_j, scaled(psi, e))
    inverse = 1.0 / dot(n, cross(tau, sigma))
    dual, dual_j = scaled(inverse, cross(sigma, n)), scaled(inverse, cross(n, tau))
    ndot = added(scaled(-dot(n, rate), dual), scaled(-dot(n, rate_j), dual_j))
    lever_rate = scaled(R, added(cross(spin, c), scaled(phi, tau)))
    lever_rate_j = scaled(S, added(cross(spin_j, e), scaled(psi, sigma)))
    b = added(cross(turn, scaled(R, c)), cross(spin, lever_rate))
    b = apart_from(b, added(cross(turn_j, scaled(S, e)), cross(spin_j, lever_rate_j)))
    return v, b, Turning(ndot, dot(cross(n, sigma), rate_j), NOTHING, 0.0, 0.0)


@kernel
def rims_margin(
    points: SpatialPoints, q: FloatArray, frames: tuple[Frame, Frame], table: SpatialContactTable, k: int
) -> float:
    """How far the normal of entry k is inside the wedges of both rims, between those of side and end [rad]."""
    one, other = rims_of(points, q, frames, table, k)
    c, _ = on_circle(one, table.foot[k, 0])
    e, _ = on_circle(other, table.foot[k, 1])
    n = row_vector(table.normal, k)
    return min(min(dot(n, e), -dot(n, other.axis)), min(-dot(n, c), dot(n, one.axis))) + TILT
