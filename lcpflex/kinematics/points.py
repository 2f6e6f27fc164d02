"""Kinematics of material points of floating-frame bodies, planar.

    r = R + A s,  s = x + Phi q;   rdot = L u,  L = [I, A J s, A Phi],  J = [[0, -1], [1, 0]]
    rddot = L udot + A( -omega^2 s + 2 omega J Phi qdot )

Source of the formulation: Shabana, Dynamics of Multibody Systems; inertia terms as in Zwoelfer & Gerstmayr (2020).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Bodies, Points
from lcpflex.model.planar import N_RIGID


class Arm(NamedTuple):
    """A point in the frame of its body, deformed, and the direction of that frame; on the ground, world axes."""

    x: float  # [m]
    y: float
    cos: float
    sin: float


@kernel
def local_place(bodies: Bodies, points: Points, q: FloatArray, p: int) -> tuple[float, float]:
    """s = x + Phi q: place of point p in the frame of its body, deformed [m]."""
    sx = points.place[p, 0]
    sy = points.place[p, 1]
    b = points.body[p]
    if b >= 0:
        modal = bodies.dof[b] + N_RIGID
        start = points.start[p]
        for k in range(points.start[p + 1] - start):
            sx += points.phi[start + k, 0] * q[modal + k]
            sy += points.phi[start + k, 1] * q[modal + k]
    return sx, sy


@kernel
def arm_of(bodies: Bodies, points: Points, q: FloatArray, p: int) -> Arm:
    """Of point p."""
    sx, sy = local_place(bodies, points, q, p)
    b = points.body[p]
    if b < 0:
        return Arm(sx, sy, 1.0, 0.0)
    angle = q[bodies.dof[b] + 2]
    return Arm(sx, sy, math.cos(angle), math.sin(angle))


@kernel
def point_position(bodies: Bodies, points: Points, q: FloatArray, p: int) -> tuple[float, float]:
    """r_P [m], world axes."""
    sx, sy = local_place(bodies, points, q, p)
    b = points.body[p]
    if b < 0:
        return sx, sy
    d = bodies.dof[b]
    cos = math.cos(q[d + 2])
    sin = math.sin(q[d + 2])
    return q[d] + cos * sx - sin * sy, q[d + 1] + sin * sx + cos * sy


@kernel
def point_motion(
    bodies: Bodies, points: Points, q: FloatArray, u: FloatArray, p: int
) -> tuple[float, float, float, float, float, float]:
    """r_P, rdot_P and Ldot u of one point; world axes."""
    return arm_motion(bodies, points, q, u, p, arm_of(bodies, points, q, p))


@kernel
def arm_motion(
    bodies: Bodies, points: Points, q: FloatArray, u: FloatArray, p: int, arm: Arm
) -> tuple[float, float, float, float, float, float]:
    """:func:`point_motion` of a point whose arm is known."""
    sx, sy, cos, sin = arm
    b = points.body[p]
    if b < 0:
        return sx, sy, 0.0, 0.0, 0.0, 0.0
    d = bodies.dof[b]
    rx = 0.0
    ry = 0.0
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        rx += points.phi[start + k, 0] * u[d + N_RIGID + k]
        ry += points.phi[start + k, 1] * u[d + N_RIGID + k]
    omega = u[d + 2]
    vx = rx - omega * sy
    vy = ry + omega * sx
    bx = -omega * omega * sx - 2.0 * omega * ry
    by = -omega * omega * sy + 2.0 * omega * rx
    return (
        q[d] + cos * sx - sin * sy,
        q[d + 1] + sin * sx + cos * sy,
        u[d] + cos * vx - sin * vy,
        u[d + 1] + sin * vx + cos * vy,
        cos * bx - sin * by,
        sin * bx + cos * by,
    )


@kernel
def motion_between(
    bodies: Bodies, points: Points, q: FloatArray, u: FloatArray, p: int, o: int
) -> tuple[float, float, float, float, float, float]:
    """r_P - r_O, its rate, and the part of its second derivative that does not depend on udot; world axes."""
    px, py, vpx, vpy, bpx, bpy = point_motion(bodies, points, q, u, p)
    ox, oy, vox, voy, box, boy = point_motion(bodies, points, q, u, o)
    return px - ox, py - oy, vpx - vox, vpy - voy, bpx - box, bpy - boy


@kernel
def point_angle(bodies: Bodies, points: Points, q: FloatArray, p: int) -> float:
    """Rotation of the material at P: angle of the body plus psi q [rad]; of u, its rate [rad/s]. 0 on the ground."""
    b = points.body[p]
    if b < 0:
        return 0.0
    d = bodies.dof[b]
    angle = q[d + 2]
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        angle += points.psi[start + k] * q[d + N_RIGID + k]
    return angle


@kernel
def force_at(
    bodies: Bodies, points: Points, q: FloatArray, p: int, dx: float, dy: float
) -> tuple[float, float, float, float]:
    """Place of point p and a force (dx, dy) in the frame of its body, which is not the ground."""
    sx, sy = local_place(bodies, points, q, p)
    d = bodies.dof[points.body[p]]
    cos = math.cos(q[d + 2])
    sin = math.sin(q[d + 2])
    return sx, sy, cos * dx + sin * dy, -sin * dx + cos * dy


@kernel
def add_point_row(bodies: Bodies, points: Points, q: FloatArray, p: int, dx: float, dy: float, row: FloatArray) -> None:
    """row += L^T d: the generalised force of a force d [N, world axes] at P, into the block of its body."""
    if points.body[p] >= 0:
        add_arm_row(points, p, arm_of(bodies, points, q, p), dx, dy, row)


@kernel
def add_arm_row(points: Points, p: int, arm: Arm, dx: float, dy: float, row: FloatArray) -> None:
    """:func:`add_point_row` of a point whose arm is known."""
    if points.body[p] < 0:
        return
    ex = arm.cos * dx + arm.sin * dy
    ey = -arm.sin * dx + arm.cos * dy
    row[0] += dx
    row[1] += dy
    row[2] += arm.x * ey - arm.y * ex
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        row[N_RIGID + k] += points.phi[start + k, 0] * ex + points.phi[start + k, 1] * ey


@kernel
def add_point_rows(
    bodies: Bodies,
    points: Points,
    q: FloatArray,
    p: int,
    dx: float,
    dy: float,
    along: FloatArray,
    across: FloatArray,
) -> None:
    """along += L^T d and across += L^T (-J d): ``add_point_row`` for d and for the force (dy, -dx) across it."""
    if points.body[p] < 0:
        return
    sx, sy, ex, ey = force_at(bodies, points, q, p, dx, dy)
    along[0] += dx
    along[1] += dy
    along[2] += sx * ey - sy * ex
    across[0] += dy
    across[1] -= dx
    across[2] -= sx * ex + sy * ey
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        fx = points.phi[start + k, 0]
        fy = points.phi[start + k, 1]
        along[N_RIGID + k] += fx * ex + fy * ey
        across[N_RIGID + k] += fx * ey - fy * ex


@kernel
def add_rotation_row(points: Points, p: int, torque: float, row: FloatArray) -> None:
    """row += the generalised force of a torque [N m] on the material at P, into the block of its body."""
    if points.body[p] < 0:
        return
    row[2] += torque
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        row[N_RIGID + k] += points.psi[start + k] * torque
