"""Relative coordinates c of two material points P and Q in space: what joints prescribe, and what springs resist.

With d = r_P - r_Q, Omega_P and Omega_Q the angular velocities of the material at both points, a an axis that is fixed
in the material at Q (of a component: in the world), a_P an axis fixed in the material at P:

    component       c = a.d, a fixed in the world
    along           c = a.d, a fixed at Q
    angle           c = atan2(x_P.(a x x_Q), x_P.x_Q): x_P as seen along a, counter-clockwise from x_Q, which is normal
                    to a
    distance        c = |d|
    perpendicular   c = a_P.a, 0 where the two are at right angles
    turn            c = a.theta, exp(theta) = A_Q^T A_P C^T the rotation, seen from Q, that leads from the relative
                    rotation C = exp(on_p) to that of now

Each has a gradient (g, t_P, t_Q), in world axes, and a bias:

    cdot = g.ddot + t_P.Omega_P + t_Q.Omega_Q,   cddot = J udot + bias,   J = g (L_P - L_Q) + t_P L^r_P + t_Q L^r_Q.

A force lambda along c is the force lambda g and the torque lambda t_P on the material at P, and -lambda g, lambda t_Q
at Q. Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989 (the constraints); the gradient
of an angle holds for axes that are not parallel, too, and that of a turn is exact.

Scenes name them, kernels know them by their place in the table of :mod:`lcpflex.model.coordinates`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.logarithms import half_cotangent, vector_of_axes
from lcpflex.kinematics.spatial.points import Arm, add_wrench, arm_of, arm_place, material_axes, point_motion
from lcpflex.kinematics.spatial.rotations import (
    Matrix,
    Vector,
    cross,
    exponential,
    rotation_matrix,
)
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, scaled, turned, turned_back
from lcpflex.model.coordinates import ALONG, ANGLE, COMPONENT, DISTANCE, PERPENDICULAR, TURN
from lcpflex.model.spatial import SpatialBodies, SpatialPoints

__all__ = [
    "Apart",
    "Directions",
    "Gradient",
    "Motion",
    "add_gradient",
    "apart",
    "coordinate_bias",
    "coordinate_gradient",
    "coordinate_rate",
    "coordinate_value",
    "off_rest",
    "relative_motion",
    "twist",
]

SMALLEST_LENGTH = 1e-300  # [m] a shorter vector has no direction


class Directions(NamedTuple):
    """What a coordinate is measured along: (3,) each, as fixed in the material, in axes of the bodies."""

    axis: Vector  # at Q; of a component, in the world
    on_p: Vector  # at P
    on_q: Vector  # at Q


class Apart(NamedTuple):
    """d = r_P - r_Q, world axes [m], and the axes of the material at both, A E(psi)."""

    d: Vector
    P: Matrix
    Q: Matrix


class Motion(NamedTuple):
    """ddot = v, dddot = L_P udot - L_Q udot + b; angular velocities, and what is left of their rates at udot = 0."""

    v: Vector  # [m/s]
    b: Vector  # [m/s^2]
    spin_p: Vector  # [rad/s]
    spin_q: Vector
    turn_p: Vector  # [rad/s^2]
    turn_q: Vector


class Gradient(NamedTuple):
    """Of a coordinate, by d and by the rotation of the material at P and at Q; world axes."""

    g: Vector
    at_p: Vector
    at_q: Vector


@kernel
def apart(bodies: SpatialBodies, points: SpatialPoints, q: FloatArray, i: int, j: int) -> tuple[Apart, tuple[Arm, Arm]]:
    """Of the points i = P and j = Q, and the arms of both."""
    arms = (arm_of(bodies, points, q, i), arm_of(bodies, points, q, j))
    d = apart_from(arm_place(bodies, points, q, i, arms[0]), arm_place(bodies, points, q, j, arms[1]))
    return Apart(d, material_axes(arms[0]), material_axes(arms[1])), arms


@kernel
def relative_motion(
    bodies: SpatialBodies, points: SpatialPoints, u: FloatArray, i: int, j: int, arms: tuple[Arm, Arm]
) -> Motion:
    """Of the points i = P and j = Q, whose arms are known."""
    P = point_motion(bodies, points, u, i, arms[0])
    Q = point_motion(bodies, points, u, j, arms[1])
    return Motion(apart_from(P.v, Q.v), apart_from(P.b, Q.b), P.spin, Q.spin, P.turn, Q.turn)


@kernel
def angle_parts(at: Apart, way: Directions) -> tuple[Vector, Vector, Vector, float, float]:
    """x_P, x_Q, y_Q, x_P.x_Q and x_P.y_Q of an angle; world axes."""
    x_p = turned(at.P, way.on_p)
    x_q = turned(at.Q, way.on_q)
    y_q = cross(turned(at.Q, way.axis), x_q)
    return x_p, x_q, y_q, dot(x_p, x_q), dot(x_p, y_q)


@kernel
def turn_vector(at: Apart, rest: Vector) -> Vector:
    """theta of a turn, axes of the material at Q; rest: rotation vector of C."""
    w, x, y, z = exponential(rest[0], rest[1], rest[2])
    C = rotation_matrix(w, x, y, z)
    axes = (  # the columns of A_P C^T, seen from Q
        turned_back(at.Q, turned(at.P, (C[0], C[1], C[2]))),
        turned_back(at.Q, turned(at.P, (C[3], C[4], C[5]))),
        turned_back(at.Q, turned(at.P, (C[6], C[7], C[8]))),
    )
    x_axis, y_axis, z_axis = axes
    return vector_of_axes(
        (
            x_axis[0], y_axis[0], z_axis[0],
            x_axis[1], y_axis[1], z_axis[1],
            x_axis[2], y_axis[2], z_axis[2],
        )
    )  # fmt: skip


@kernel
def coordinate_value(kind: int, at: Apart, way: Directions) -> float:
    """c [m] or [rad]; an angle in (-pi, pi]."""
    if kind == COMPONENT:
        return dot(way.axis, at.d)
    if kind == ALONG:
        return dot(turned(at.Q, way.axis), at.d)
    if kind == DISTANCE:
        return norm(at.d)
    if kind == PERPENDICULAR:
        return dot(turned(at.P, way.on_p), turned(at.Q, way.axis))
    if kind == TURN:
        return dot(way.axis, turn_vector(at, way.on_p))
    _, _, _, x, y = angle_parts(at, way)
    return math.atan2(y, x)


@kernel
def off_rest(kind: int, value: float) -> float:
    """c - rest - f as it counts: angles that differ by whole turns are the same, and come out in (-pi, pi]."""
    if kind != ANGLE or -math.pi < value <= math.pi:
        return value
    return value - 2.0 * math.pi * math.ceil((value - math.pi) / (2.0 * math.pi))


@kernel
def twist(kind: int, at: Apart, way: Directions, rest: float) -> float:
    """How far the points are turned out of ``rest`` [rad], either way; 0 of kinds that tell no whole rotation."""
    if kind == ANGLE:
        return abs(off_rest(kind, coordinate_value(kind, at, way) - rest))
    return norm(turn_vector(at, way.on_p)) if kind == TURN else 0.0


@kernel
def angle_gradient(at: Apart, way: Directions) -> tuple[Vector, Vector, Vector]:
    """t_P of an angle, w = (x y_Q - y x_Q) and x_P, where t_P = x_P x w / (x^2 + y^2); a where a_P is parallel to a."""
    x_p, x_q, y_q, x, y = angle_parts(at, way)
    w = apart_from(scaled(x, y_q), scaled(y, x_q))
    size = max(x * x + y * y, SMALLEST_LENGTH)
    return scaled(1.0 / size, cross(x_p, w)), w, x_p


@kernel
def turn_gradient(theta: Vector, axis: Vector) -> Vector:
    """T^-T(theta) axis, axes of the material at Q."""
    e, _ = half_cotangent(dot(theta, theta))
    once = cross(theta, axis)
    return added(axis, added(scaled(0.5, once), scaled(e, cross(theta, once))))


@kernel
def coordinate_gradient(kind: int, at: Apart, way: Directions) -> Gradient:
    """Of a coordinate; a distance between points that coincide has none."""
    if kind == COMPONENT:
        return Gradient(way.axis, NOTHING, NOTHING)
    if kind == ALONG:
        a = turned(at.Q, way.axis)
        return Gradient(a, NOTHING, cross(a, at.d))
    if kind == DISTANCE:
        return Gradient(scaled(1.0 / max(norm(at.d), SMALLEST_LENGTH), at.d), NOTHING, NOTHING)
    if kind == PERPENDICULAR:
        t = cross(turned(at.P, way.on_p), turned(at.Q, way.axis))
    elif kind == TURN:
        t = turned(at.Q, turn_gradient(turn_vector(at, way.on_p), way.axis))
    else:
        t, _, _ = angle_gradient(at, way)
    return Gradient(NOTHING, t, scaled(-1.0, t))


@kernel
def angle_bias(at: Apart, motion: Motion, way: Directions, spin: Vector) -> float:
    """dt_P/dt.(Omega_P - Omega_Q) of an angle."""
    t, w, x_p = angle_gradient(at, way)
    _, x_q, y_q, x, y = angle_parts(at, way)
    x_p_rate = cross(motion.spin_p, x_p)
    x_rate = dot(spin, cross(x_p, x_q))
    y_rate = dot(spin, cross(x_p, y_q))
    w_rate = added(
        apart_from(scaled(x_rate, y_q), scaled(y_rate, x_q)),
        cross(motion.spin_q, w),
    )
    size = max(x * x + y * y, SMALLEST_LENGTH)
    moved = dot(spin, added(cross(x_p_rate, w), cross(x_p, w_rate)))
    return (moved - 2.0 * (x * x_rate + y * y_rate) * dot(t, spin)) / size


@kernel
def turn_bias(at: Apart, motion: Motion, way: Directions, spin: Vector) -> float:
    """dt_P/dt.(Omega_P - Omega_Q) of a turn."""
    theta = turn_vector(at, way.on_p)
    w = turned_back(at.Q, spin)
    e, slope = half_cotangent(dot(theta, theta))
    once = cross(theta, w)
    rate = added(w, added(scaled(-0.5, once), scaled(e, cross(theta, once))))  # of theta: T^-1 w
    across = cross(theta, way.axis)
    moved = cross(rate, way.axis)
    m_rate = added(scaled(0.5, moved), scaled(2.0 * slope * dot(theta, rate), cross(theta, across)))
    m_rate = added(m_rate, scaled(e, added(cross(rate, across), cross(theta, moved))))
    m = turned(at.Q, turn_gradient(theta, way.axis))
    return dot(m_rate, w) + dot(cross(motion.spin_q, m), spin)


@kernel
def coordinate_bias(kind: int, at: Apart, motion: Motion, way: Directions) -> float:
    """cddot - J udot [m/s^2] or [rad/s^2]."""
    if kind == COMPONENT:
        return dot(way.axis, motion.b)
    if kind == ALONG:
        a = turned(at.Q, way.axis)
        swing = cross(motion.spin_q, a)
        bias = dot(a, motion.b) + 2.0 * dot(swing, motion.v) + dot(cross(a, at.d), motion.turn_q)
        return bias + dot(cross(motion.spin_q, swing), at.d)
    if kind == DISTANCE:
        length = max(norm(at.d), SMALLEST_LENGTH)
        across = cross(scaled(1.0 / length, at.d), motion.v)
        return dot(at.d, motion.b) / length + dot(across, across) / length
    spin = apart_from(motion.spin_p, motion.spin_q)
    bias = dot(coordinate_gradient(kind, at, way).at_p, apart_from(motion.turn_p, motion.turn_q))
    if kind == TURN:
        return bias + turn_bias(at, motion, way, spin)
    if kind == ANGLE:
        return bias + angle_bias(at, motion, way, spin)
    a = turned(at.P, way.on_p)
    b = turned(at.Q, way.axis)
    return bias + dot(added(cross(cross(motion.spin_p, a), b), cross(a, cross(motion.spin_q, b))), spin)


@kernel
def coordinate_rate(gradient: Gradient, motion: Motion) -> float:
    """cdot [m/s] or [rad/s]."""
    return dot(gradient.g, motion.v) + dot(gradient.at_p, motion.spin_p) + dot(gradient.at_q, motion.spin_q)


@kernel
def add_gradient(
    points: SpatialPoints,
    ends: tuple[int, int],
    arms: tuple[Arm, Arm],
    gradient: Gradient,
    scale: float,
    on_p: FloatArray,
    on_q: FloatArray,
) -> None:
    """Add ``scale`` times the gradient, as generalised forces, to the blocks of the bodies of P and Q = ``ends``.

    ``arms``: of both, at the configuration of the gradient.
    """
    add_wrench(points, ends[0], arms[0], scaled(scale, gradient.g), scaled(scale, gradient.at_p), on_p)
    add_wrench(points, ends[1], arms[1], scaled(-scale, gradient.g), scaled(scale, gradient.at_q), on_q)
