"""Bilateral constraints phi(q, t) = 0 of the joints: residuals, Jacobian rows and accelerations.

With r = r_P - r_Q, v = rdot, alpha the angle of the material at a point, d a direction fixed in the material at Q
(so that ddot = alphadot_Q J d, J = [[0, -1], [1, 0]]), and f(t) a prescribed motion:

    coincidence  phi = r                      phiddot = L_P udot - L_Q udot + b,   b = Ldot_P u - Ldot_Q u
    direction    phi = d.r - f                bias = d.b + 2 alphadot_Q (J d).v - alphadot_Q^2 d.r - f''
    angle        phi = alpha_P - alpha_Q - alpha_0 - f                      bias = -f''
    distance     phi = |r| - f,  e = r / |r|  bias = e.b + (v.v - (e.v)^2) / |r| - f''

Which of them a joint has, in the order of its rows, follows from its kind (:mod:`lcpflex.scene.joints`):
0 revolute: coincidence (2 rows); 1 weld: coincidence, angle; 2 prismatic: direction normal to the axis, angle;
3 point on line: direction normal to the axis; 4 distance; 5 driven angle; 6 driven displacement: direction of the axis.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.points import (
    add_point_row,
    add_rotation_row,
    point_angle,
    point_bias,
    point_position,
    point_velocity,
)
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import Model

__all__ = ["joint_residual", "joint_rows"]

SMALLEST_LENGTH = 1e-300  # [m] a shorter vector has no direction


@kernel
def motion(model: Model, joint: int, t: float, external: FloatArray) -> tuple[float, float, float]:
    """f, f', f'' of a joint; its constant length for a distance without a motion, else 0."""
    if model.joints.signal[joint] >= 0:
        return signal_value(model.signals, model.joints.signal[joint], t, external)
    if model.joints.kind[joint] == 4:
        return model.joints.value[joint, 3], 0.0, 0.0
    return 0.0, 0.0, 0.0


@kernel
def direction(model: Model, q: FloatArray, joint: int) -> tuple[float, float]:
    """Unit vector d of a joint, world axes: its axis as the material at Q carries it, or the normal J d to that."""
    angle = point_angle(model.bodies, model.points, q, model.joints.point[joint, 1])
    x = model.joints.value[joint, 1]
    y = model.joints.value[joint, 2]
    dx = math.cos(angle) * x - math.sin(angle) * y
    dy = math.sin(angle) * x + math.cos(angle) * y
    if model.joints.kind[joint] == 6:
        return dx, dy
    return -dy, dx


@kernel
def joint_residual(model: Model, t: float, q: FloatArray, external: FloatArray, phi: FloatArray) -> None:
    """phi(q, t) of all joints, ``joints.row[-1]`` values [m] or [rad]."""
    for joint in range(len(model.joints.kind)):
        kind = model.joints.kind[joint]
        i = model.joints.point[joint, 0]
        j = model.joints.point[joint, 1]
        r = model.joints.row[joint]
        f, _, _ = motion(model, joint, t, external)
        xi, yi = point_position(model.bodies, model.points, q, i)
        xj, yj = point_position(model.bodies, model.points, q, j)
        if kind <= 1:
            phi[r] = xi - xj
            phi[r + 1] = yi - yj
            r += 2
        elif kind == 4:
            phi[r] = math.hypot(xi - xj, yi - yj) - f
        elif kind != 5:
            dx, dy = direction(model, q, joint)
            phi[r] = dx * (xi - xj) + dy * (yi - yj) - f
            r += 1
        if kind == 1 or kind == 2 or kind == 5:
            turn = point_angle(model.bodies, model.points, q, i) - point_angle(model.bodies, model.points, q, j)
            phi[r] = turn - model.joints.value[joint, 0] - f


@kernel
def difference_row(model: Model, q: FloatArray, joint: int, dx: float, dy: float, row: FloatArray) -> None:
    """row = gradient of d.(r_P - r_Q) at fixed d, in its two blocks (2, width)."""
    i = model.joints.point[joint, 0]
    j = model.joints.point[joint, 1]
    if model.points.body[i] >= 0:
        add_point_row(model.bodies, model.points, q, i, dx, dy, row[0])
    if model.points.body[j] >= 0:
        add_point_row(model.bodies, model.points, q, j, -dx, -dy, row[1])


@kernel
def joint_rows(
    model: Model,
    t: float,
    q: FloatArray,
    u: FloatArray,
    external: FloatArray,
    rows: FloatArray,
    row_body: IntArray,
    rate: FloatArray,
    bias: FloatArray,
) -> None:
    """The rows J of all joints by body block, with phidot = J u + rate and phiddot = J udot + bias.

    rows (R, 2, width), row_body (R, 2), rate (R,) [m/s] or [rad/s], bias (R,) [m/s^2] or [rad/s^2]: the first
    ``joints.row[-1]`` of each are overwritten. Block 0 belongs to the body of P, block 1 to that of Q; body -1 is the
    ground.
    """
    bodies = model.bodies
    points = model.points
    for r in range(model.joints.row[-1]):
        for k in range(rows.shape[2]):
            rows[r, 0, k] = 0.0
            rows[r, 1, k] = 0.0
    for joint in range(len(model.joints.kind)):
        kind = model.joints.kind[joint]
        i = model.joints.point[joint, 0]
        j = model.joints.point[joint, 1]
        r = model.joints.row[joint]
        for s in range(r, model.joints.row[joint + 1]):
            row_body[s, 0] = points.body[i]
            row_body[s, 1] = points.body[j]
        _, f_rate, f_acceleration = motion(model, joint, t, external)
        xi, yi = point_position(bodies, points, q, i)
        xj, yj = point_position(bodies, points, q, j)
        vxi, vyi = point_velocity(bodies, points, q, u, i)
        vxj, vyj = point_velocity(bodies, points, q, u, j)
        bxi, byi = point_bias(bodies, points, q, u, i)
        bxj, byj = point_bias(bodies, points, q, u, j)
        x = xi - xj
        y = yi - yj
        vx = vxi - vxj
        vy = vyi - vyj
        bx = bxi - bxj
        by = byi - byj
        if kind <= 1:
            difference_row(model, q, joint, 1.0, 0.0, rows[r])
            difference_row(model, q, joint, 0.0, 1.0, rows[r + 1])
            rate[r] = 0.0
            rate[r + 1] = 0.0
            bias[r] = bx
            bias[r + 1] = by
            r += 2
        elif kind == 4:
            length = max(math.hypot(x, y), SMALLEST_LENGTH)
            ex = x / length
            ey = y / length
            across = ex * vy - ey * vx
            difference_row(model, q, joint, ex, ey, rows[r])
            rate[r] = -f_rate
            bias[r] = ex * bx + ey * by + across * across / length - f_acceleration
        elif kind != 5:
            dx, dy = direction(model, q, joint)
            spin = point_angle(bodies, points, u, j)
            difference_row(model, q, joint, dx, dy, rows[r])
            add_rotation_row(bodies, points, j, dx * y - dy * x, rows[r, 1])
            rate[r] = -f_rate
            bias[r] = dx * bx + dy * by + 2.0 * spin * (dx * vy - dy * vx) - spin * spin * (dx * x + dy * y)
            bias[r] -= f_acceleration
            r += 1
        if kind == 1 or kind == 2 or kind == 5:
            add_rotation_row(bodies, points, i, 1.0, rows[r, 0])
            add_rotation_row(bodies, points, j, -1.0, rows[r, 1])
            rate[r] = -f_rate
            bias[r] = -f_acceleration
