"""Relative coordinates c of two material points P and Q: what joints prescribe, and what springs resist.

With r = r_P - r_Q, rdot = v, rddot = L_P udot - L_Q udot + b, and the angles alpha of the material at both points:

    component of r along d, fixed in the world   c = d.r
    the same along d, fixed in the material at Q c = d.r,   bias = d.b + 2 alphadot (J d).v - alphadot^2 d.r
    angle                                        c = alpha_P - alpha_Q
    distance                                     c = |r|,   bias = e.b + (v.v - (e.v)^2) / |r|,   e = r / |r|

Each has a value c(r, alpha_P, alpha_Q) and

    cdot = g.v + g_P alphadot_P + g_Q alphadot_Q,   cddot = J udot + bias,

the gradient (g, g_P, g_Q) of which makes the row J, and the generalised force of a force along c. For a direction
fixed at Q, ddot = alphadot J d, J = [[0, -1], [1, 0]], so that g_Q = (J d).r.

Scenes name them, kernels know them by their place in the table of :mod:`lcpflex.model.coordinates`. To add one: its
line there, and its two branches; from then on joints and springs can name it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import (
    Arm,
    add_arm_row,
    add_rotation_row,
    arm_motion,
    arm_of,
    point_angle,
    point_position,
)
from lcpflex.model.arrays import Bodies, Points
from lcpflex.model.coordinates import ANGLE, COMPONENT, DISTANCE

__all__ = [
    "Apart",
    "Motion",
    "add_gradient",
    "apart",
    "coordinate_gradient",
    "coordinate_value",
    "relative_motion",
]

SMALLEST_LENGTH = 1e-300  # [m] a shorter vector has no direction


class Apart(NamedTuple):
    """r = r_P - r_Q, world axes, and the angles of the material at both; the ground has none."""

    x: float  # [m]
    y: float
    angle_p: float  # [rad]
    angle_q: float


class Motion(NamedTuple):
    """rdot = v, rddot = L_P udot - L_Q udot + b, and the rates of the angles."""

    vx: float  # [m/s]
    vy: float
    bx: float  # [m/s^2]
    by: float
    spin_p: float  # [rad/s]
    spin_q: float


@kernel
def apart(bodies: Bodies, points: Points, q: FloatArray, i: int, j: int) -> Apart:
    """Of the points i = P and j = Q."""
    xi, yi = point_position(bodies, points, q, i)
    xj, yj = point_position(bodies, points, q, j)
    return Apart(xi - xj, yi - yj, point_angle(bodies, points, q, i), point_angle(bodies, points, q, j))


@kernel
def relative_motion(
    bodies: Bodies, points: Points, q: FloatArray, u: FloatArray, i: int, j: int
) -> tuple[Apart, Motion, tuple[Arm, Arm]]:
    """Of the points i = P and j = Q, and the arms of both."""
    arms = (arm_of(bodies, points, q, i), arm_of(bodies, points, q, j))
    px, py, vpx, vpy, bpx, bpy = arm_motion(bodies, points, q, u, i, arms[0])
    ox, oy, vox, voy, box, boy = arm_motion(bodies, points, q, u, j, arms[1])
    place = Apart(px - ox, py - oy, point_angle(bodies, points, q, i), point_angle(bodies, points, q, j))
    spins = (point_angle(bodies, points, u, i), point_angle(bodies, points, u, j))
    return place, Motion(vpx - vox, vpy - voy, bpx - box, bpy - boy, spins[0], spins[1]), arms


@kernel
def direction(kind: int, at: Apart, ax: float, ay: float) -> tuple[float, float]:
    """d of a component, world axes; (ax, ay): as it is fixed, in the world or in the material at Q at angle 0."""
    if kind == COMPONENT:
        return ax, ay
    cos = math.cos(at.angle_q)
    sin = math.sin(at.angle_q)
    return cos * ax - sin * ay, sin * ax + cos * ay


@kernel
def coordinate_value(kind: int, at: Apart, ax: float, ay: float) -> float:
    """c [m] or [rad]; (ax, ay): the direction that the coordinate has, if it has one."""
    if kind == ANGLE:
        return at.angle_p - at.angle_q
    if kind == DISTANCE:
        return math.hypot(at.x, at.y)
    dx, dy = direction(kind, at, ax, ay)
    return dx * at.x + dy * at.y


@kernel
def coordinate_gradient(
    kind: int, at: Apart, motion: Motion, ax: float, ay: float
) -> tuple[float, float, float, float, float]:
    """g_x, g_y, g_P, g_Q and the bias of a coordinate; of a distance between points that coincide there is none."""
    if kind == ANGLE:
        return 0.0, 0.0, 1.0, -1.0, 0.0
    if kind == DISTANCE:
        length = max(math.hypot(at.x, at.y), SMALLEST_LENGTH)
        ex = at.x / length
        ey = at.y / length
        across = ex * motion.vy - ey * motion.vx
        return ex, ey, 0.0, 0.0, ex * motion.bx + ey * motion.by + across * across / length
    dx, dy = direction(kind, at, ax, ay)
    bias = dx * motion.bx + dy * motion.by
    if kind == COMPONENT:
        return dx, dy, 0.0, 0.0, bias
    x, y, spin = at.x, at.y, motion.spin_q
    bias += 2.0 * spin * (dx * motion.vy - dy * motion.vx)
    return dx, dy, 0.0, dx * y - dy * x, bias - spin * spin * (dx * x + dy * y)


@kernel
def add_gradient(
    points: Points,
    ends: tuple[int, int],
    arms: tuple[Arm, Arm],
    gradient: tuple[float, float, float, float, float],
    scale: float,
    on_p: FloatArray,
    on_q: FloatArray,
) -> None:
    """Add ``scale`` times the gradient, as generalised forces, to the blocks of the bodies of P and Q = ``ends``.

    ``arms``: of both, at the configuration of the gradient.
    """
    gx, gy, turn_p, turn_q, _ = gradient
    if gx != 0.0 or gy != 0.0:
        add_arm_row(points, ends[0], arms[0], scale * gx, scale * gy, on_p)
        add_arm_row(points, ends[1], arms[1], -scale * gx, -scale * gy, on_q)
    if turn_p != 0.0:
        add_rotation_row(points, ends[0], scale * turn_p, on_p)
    if turn_q != 0.0:
        add_rotation_row(points, ends[1], scale * turn_q, on_q)
