"""Reactions of joints in space: what a joint does to the body of its point P, by the rows that are laid.

A row prescribes a coordinate c with cdot = g.(rdot_P - rdot_Q) + t_P.Omega_P + t_Q.Omega_Q. Its multiplier lambda makes
the force F = lambda g on the body of P, at P, and the moment M = lambda t_P about P. The row holds

    g  and  s_P x A^T g + A^T t_P        of the body of P,
   -g  and  -s_Q x A^T g + A^T t_Q       of the body of Q,  with  t_P + t_Q + (r_P - r_Q) x g = 0,

since no rigid motion changes c: so the block of either body tells g and t_P, whatever its modes are.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import arm_of, point_place
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, cross, transform
from lcpflex.model.spatial import SpatialModel

__all__ = ["peaks", "reaction"]


@kernel
def lever(model: SpatialModel, q: FloatArray, joint: int) -> tuple[Matrix, Vector]:
    """A of the body whose rows tell, that of P unless it is the ground, and P from its origin [m], world axes."""
    bodies, points = model.bodies, model.points
    p = model.joints.point[joint, 0]
    if points.body[p] >= 0:
        arm = arm_of(bodies, points, q, p)
        return arm.A, transform(arm.A, arm.s[0], arm.s[1], arm.s[2])
    other = model.joints.point[joint, 1]
    at = bodies.place[points.body[other]]
    x, y, z = point_place(bodies, points, q, p)
    return arm_of(bodies, points, q, other).A, (x - q[at], y - q[at + 1], z - q[at + 2])


@kernel
def reaction(
    model: SpatialModel, work: SpatialWork, joint: int, p: FloatArray
) -> tuple[float, float, float, float, float, float]:
    """(F, M) of one joint with the multipliers p of all rows, world axes, M about P; by the rows laid."""
    rows, first, last = work.rows, model.joints.row[joint], model.joints.row[joint + 1]
    i = 0 if model.points.body[model.joints.point[joint, 0]] >= 0 else 1
    x = y = z = a = b = c = 0.0
    if model.points.body[model.joints.point[joint, i]] < 0:  # both on the ground
        return x, y, z, a, b, c
    sign = 1.0 - 2.0 * i
    for r in range(first, last):
        weight = sign * p[r]
        x += weight * rows[r, i, 0]
        y += weight * rows[r, i, 1]
        z += weight * rows[r, i, 2]
        a += weight * rows[r, i, 3]
        b += weight * rows[r, i, 4]
        c += weight * rows[r, i, 5]
    A, place = lever(model, work.arrow.laid, joint)
    turn = transform(A, a, b, c)
    swept = cross(place, (x, y, z))
    return x, y, z, turn[0] - swept[0], turn[1] - swept[1], turn[2] - swept[2]


@kernel
def peaks(model: SpatialModel, impulse: FloatArray | tuple[float, ...], h: float) -> tuple[float, float]:
    """|F|^2 and |M| of the reaction ``impulse`` / h."""
    x, y, z = impulse[0] / h, impulse[1] / h, impulse[2] / h
    a, b, c = impulse[3] / h, impulse[4] / h, impulse[5] / h
    return x * x + y * y + z * z, math.sqrt(a * a + b * b + c * c)
