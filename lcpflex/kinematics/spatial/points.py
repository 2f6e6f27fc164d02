"""Kinematics of material points of floating-frame bodies in space.

    r = R + A s,  s = x + Phi eta;   rdot = L u,  L = [I, -A s~, A Phi]
    rddot = L udot + A( omega x (omega x s) + 2 omega x Phi etadot )

The material at the point is turned by A E(psi), psi = Psi eta, E = exp, and

    Omega = L^r u = A(omega + T(psi) psidot),   Omegadot = L^r udot + A( omega x T psidot + Tdot psidot ),

with T of :mod:`lcpflex.kinematics.spatial.rotations`: axes that are fixed in the material stay orthonormal, as those of
I + psi~ would not. Points of the ground are in world axes, and have no rows. Source: Shabana, Dynamics of Multibody
Systems.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import (
    Matrix,
    Vector,
    cross,
    exponential,
    product,
    rotation_matrix,
    tangent,
    tangent_rate,
)
from lcpflex.kinematics.spatial.vectors import IDENTITY, NOTHING, added, is_zero, scaled, turned, turned_back
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies, SpatialPoints

__all__ = [
    "Arm",
    "PointMotion",
    "add_wrench",
    "arm_of",
    "arm_place",
    "material_axes",
    "point_axes",
    "point_motion",
    "point_place",
    "point_velocity",
]


class Arm(NamedTuple):
    """A point in the frame of its body, deformed, that frame, and how far the material has turned in it."""

    s: Vector  # [m]; of the ground, world axes
    A: Matrix
    psi: Vector  # [rad], axes of the body; 0 in rigid bodies


class PointMotion(NamedTuple):
    """rdot = v, rddot = L udot + b; Omega = spin, Omegadot = L^r udot + turn; all in world axes."""

    v: Vector  # [m/s]
    b: Vector  # [m/s^2]
    spin: Vector  # [rad/s]
    turn: Vector  # [rad/s^2]


@kernel
def modal_sums(
    points: SpatialPoints, p: int, values: FloatArray, modal: int
) -> tuple[float, float, float, float, float, float]:
    """Phi e and Psi e of point p for the modal numbers e that begin at ``modal`` of ``values``."""
    x = y = z = a = b = c = 0.0
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        e = values[modal + k]
        x += points.phi[start + k, 0] * e
        y += points.phi[start + k, 1] * e
        z += points.phi[start + k, 2] * e
        a += points.psi[start + k, 0] * e
        b += points.psi[start + k, 1] * e
        c += points.psi[start + k, 2] * e
    return x, y, z, a, b, c


@kernel
def arm_of(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, p: int) -> Arm:
    """Of point p."""
    x = points.place[p, 0]
    y = points.place[p, 1]
    z = points.place[p, 2]
    b = points.body[p]
    if b < 0:
        return Arm((x, y, z), IDENTITY, NOTHING)
    at = bodies.place[b]
    A = rotation_matrix(q[at + 3], q[at + 4], q[at + 5], q[at + 6])
    if points.start[p + 1] == points.start[p]:
        return Arm((x, y, z), A, NOTHING)
    dx, dy, dz, px, py, pz = modal_sums(points, p, q, at + N_PLACE)
    return Arm((x + dx, y + dy, z + dz), A, (px, py, pz))


@kernel
def arm_place(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, p: int, arm: Arm) -> Vector:
    """r [m] of point p, whose arm is known; world axes."""
    b = points.body[p]
    if b < 0:
        return arm.s
    at = bodies.place[b]
    x, y, z = turned(arm.A, arm.s)
    return q[at] + x, q[at + 1] + y, q[at + 2] + z


@kernel
def material_axes(arm: Arm) -> Matrix:
    """A E(psi): what axes of the body that are fixed in the material have become, world axes."""
    if is_zero(arm.psi):
        return arm.A
    w, x, y, z = exponential(arm.psi[0], arm.psi[1], arm.psi[2])
    return product(arm.A, rotation_matrix(w, x, y, z))


@kernel
def point_place(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, p: int) -> Vector:
    """r [m] of point p; world axes."""
    return arm_place(bodies, points, q, p, arm_of(bodies, points, q, p))


@kernel
def point_axes(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, p: int) -> Matrix:
    """A E(psi) of the material at point p."""
    return material_axes(arm_of(bodies, points, q, p))


@kernel
def point_motion(bodies: SpatialBodies, points: SpatialPoints, u: FloatArray, p: int, arm: Arm) -> PointMotion:
    """Of point p, whose arm is known."""
    b = points.body[p]
    if b < 0:
        return PointMotion(NOTHING, NOTHING, NOTHING, NOTHING)
    d = bodies.dof[b]
    A = arm.A
    omega = (u[d + 3], u[d + 4], u[d + 5])
    sweep = cross(omega, arm.s)
    v = (u[d], u[d + 1], u[d + 2])
    if points.start[p + 1] == points.start[p]:
        return PointMotion(added(v, turned(A, sweep)), turned(A, cross(omega, sweep)), turned(A, omega), NOTHING)
    x, y, z, px, py, pz = modal_sums(points, p, u, d + N_RIGID)
    flow = (x, y, z)
    v = added(v, turned(A, added(sweep, flow)))
    bias = turned(A, cross(omega, added(sweep, scaled(2.0, flow))))
    rate = (px, py, pz)
    if is_zero(rate):
        return PointMotion(v, bias, turned(A, omega), NOTHING)
    spin = turned(tangent(arm.psi[0], arm.psi[1], arm.psi[2]), rate)
    turn = added(cross(omega, spin), turned(tangent_rate(arm.psi, rate), rate))
    return PointMotion(v, bias, turned(A, added(omega, spin)), turned(A, turn))


@kernel
def point_velocity(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, u: FloatArray, p: int) -> PointMotion:
    """The motion of point p at (q, u)."""
    return point_motion(bodies, points, u, p, arm_of(bodies, points, q, p))


@kernel
def add_wrench(points: SpatialPoints, p: int, arm: Arm, force: Vector, torque: Vector, row: FloatArray) -> None:
    """row += L^T force + (L^r)^T torque: a force [N] and a torque [N m] on the material at point p, both world axes.

    row: the block of the body of p.
    """
    if points.body[p] < 0:
        return
    f = turned_back(arm.A, force)
    t = turned_back(arm.A, torque)
    m = added(cross(arm.s, f), t)
    for i in range(3):
        row[i] += force[i]
        row[3 + i] += m[i]
    start = points.start[p]
    n = points.start[p + 1] - start
    for k in range(n):
        row[N_RIGID + k] += (
            points.phi[start + k, 0] * f[0] + points.phi[start + k, 1] * f[1] + points.phi[start + k, 2] * f[2]
        )
    if n == 0 or is_zero(t):
        return
    t = turned_back(tangent(arm.psi[0], arm.psi[1], arm.psi[2]), t)
    for k in range(n):
        row[N_RIGID + k] += (
            points.psi[start + k, 0] * t[0] + points.psi[start + k, 1] * t[1] + points.psi[start + k, 2] * t[2]
        )
