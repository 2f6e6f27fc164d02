"""Rows W and biases w of contact pairs: gdot = W^T u, gddot = W^T udot + w.

P is the slave with radius r on body i; the feature belongs to body j. With J = [[0, -1], [1, 0]] and t = -J n:

    segment a-b, Q = r_a + s e, e = r_b - r_a:  gdot_N = n.(v_P - v_Q), gdot_T = t.(v_P - v_Q) + r adot_P
    arc about o, n = sense (r_P - r_o)/|.|:     gdot_N = n.(v_P - v_o), gdot_T = t.(v_P - v_o) + r adot_P + R adot_o

where adot is the rate of rotation of the material at a point and R the signed radius (< 0 for holes). w collects the
Coriolis and centrifugal accelerations, the rotation of n and t, and the sliding of Q along its surface.
Sources: Pfeiffer & Glocker 1996; Ebrahimi & Eberhard 2005.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import ContactTable
from lcpflex.contact.features import COINCIDENT, SEGMENT
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import (
    add_point_rows,
    add_rotation_row,
    point_motion,
    point_position,
)
from lcpflex.model.arrays import Model


@kernel
def contact_rows(
    model: Model, q: FloatArray, table: ContactTable, k: int, normal_rows: FloatArray, tangent_rows: FloatArray
) -> None:
    """Rows of entry k at q, (2, width) each: blocks for body i and body j; a block on the ground stays 0."""
    for i in range(2):
        for c in range(normal_rows.shape[1]):
            normal_rows[i, c] = 0.0
            tangent_rows[i, c] = 0.0
    bodies = model.bodies
    points = model.points
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    p = table.slave[k]
    if table.body[k, 0] >= 0:
        add_point_rows(bodies, points, q, p, nx, ny, normal_rows[0], tangent_rows[0])
        if table.slave_radius[k] != 0.0:
            add_rotation_row(bodies, points, p, table.slave_radius[k], tangent_rows[0])
    if table.body[k, 1] >= 0:
        a = table.a[k]
        if table.kind[k] == SEGMENT:
            s = table.s[k]
            add_point_rows(bodies, points, q, a, -(1.0 - s) * nx, -(1.0 - s) * ny, normal_rows[1], tangent_rows[1])
            add_point_rows(bodies, points, q, table.b[k], -s * nx, -s * ny, normal_rows[1], tangent_rows[1])
        else:
            add_point_rows(bodies, points, q, a, -nx, -ny, normal_rows[1], tangent_rows[1])
            if table.radius[k] != 0.0:
                add_rotation_row(bodies, points, a, table.radius[k], tangent_rows[1])


@kernel
def gap_rate(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> float:
    """gdot_N [m/s] of entry k."""
    bodies = model.bodies
    points = model.points
    _, _, vx, vy, _, _ = point_motion(bodies, points, q, u, table.slave[k])
    _, _, wx, wy, _, _ = point_motion(bodies, points, q, u, table.a[k])
    if table.kind[k] == SEGMENT:
        _, _, ex, ey, _, _ = point_motion(bodies, points, q, u, table.b[k])
        wx += table.s[k] * (ex - wx)
        wy += table.s[k] * (ey - wy)
    return table.normal[k, 0] * (vx - wx) + table.normal[k, 1] * (vy - wy)


@kernel
def contact_bias(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """w_N and w_T [m/s^2] of entry k."""
    bodies = model.bodies
    points = model.points
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    tx = ny
    ty = -nx
    p = table.slave[k]
    a = table.a[k]
    b = table.b[k]
    px, py, vpx, vpy, bpx, bpy = point_motion(bodies, points, q, u, p)
    ax, ay, vax, vay, bax, bay = point_motion(bodies, points, q, u, a)
    dx = px - ax
    dy = py - ay
    wx = vpx - vax
    wy = vpy - vay
    if table.kind[k] == SEGMENT:
        cx, cy, vbx, vby, bbx, bby = point_motion(bodies, points, q, u, b)
        ex = cx - ax
        ey = cy - ay
        fx = vbx - vax
        fy = vby - vay
        l2 = ex * ex + ey * ey
        s = table.s[k]
        turn = (ex * fy - ey * fx) / l2
        slide = (fx * dx + fy * dy + ex * wx + ey * wy - 2.0 * s * (ex * fx + ey * fy)) / l2
        rx = bpx - bax - s * (bbx - bax)
        ry = bpy - bay - s * (bby - bay)
        wx -= s * fx
        wy -= s * fy
        # ndot = turn J n, tdot = turn J t
        w_n = nx * rx + ny * ry + turn * (-ny * wx + nx * wy) - slide * (nx * fx + ny * fy)
        w_t = tx * rx + ty * ry + turn * (-ty * wx + tx * wy) - slide * (tx * fx + ty * fy)
        return w_n, w_t
    distance = max(math.hypot(dx, dy), COINCIDENT)
    turn = table.sense[k] * (-ny * wx + nx * wy) / distance
    rx = bpx - bax
    ry = bpy - bay
    return nx * rx + ny * ry + turn * (-ny * wx + nx * wy), tx * rx + ty * ry + turn * (-ty * wx + tx * wy)


@kernel
def contact_point(model: Model, q: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Where entry k touches: the point of the slave's circle nearest to the feature [m], world axes."""
    px, py = point_position(model.bodies, model.points, q, table.slave[k])
    return px - table.slave_radius[k] * table.normal[k, 0], py - table.slave_radius[k] * table.normal[k, 1]
