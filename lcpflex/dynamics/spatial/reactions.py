"""Reactions of joints in space: what a joint does to the body of its point P, by the rows that are laid.

A row prescribes a coordinate c with cdot = g.(rdot_P - rdot_Q) + t_P.Omega_P + t_Q.Omega_Q. Its multiplier lambda makes
the force F = lambda g on the body of P, at P, and the moment M = lambda t_P about P: ``work.rows.wrench``.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["peaks", "reaction"]


@kernel
def reaction(
    model: SpatialModel, work: SpatialWork, joint: int, p: FloatArray
) -> tuple[float, float, float, float, float, float]:
    """(F, M) of one joint with the multipliers p of all rows, world axes, M about P; by the rows laid."""
    x = y = z = a = b = c = 0.0
    for r in range(model.joints.row[joint], model.joints.row[joint + 1]):
        x += p[r] * work.rows.wrench[r, 0]
        y += p[r] * work.rows.wrench[r, 1]
        z += p[r] * work.rows.wrench[r, 2]
        a += p[r] * work.rows.wrench[r, 3]
        b += p[r] * work.rows.wrench[r, 4]
        c += p[r] * work.rows.wrench[r, 5]
    return x, y, z, a, b, c


@kernel
def peaks(model: SpatialModel, impulse: FloatArray | tuple[float, ...], h: float) -> tuple[float, float]:
    """|F|^2 and |M| of the reaction ``impulse`` / h."""
    x, y, z = impulse[0] / h, impulse[1] / h, impulse[2] / h
    a, b, c = impulse[3] / h, impulse[4] / h, impulse[5] / h
    return x * x + y * y + z * z, math.sqrt(a * a + b * b + c * c)
